//! Data types, values, structure templates, tag types and tag paths.
//!
//! The nature of a tag, and the position of a part of it in its bytes. This crate stores no tag, reads and writes no
//! network, and knows no motion: `arcline-proto` carries these types, and
//! `arcline-controller` keeps the memory that they describe. All data is little-endian; offsets and sizes
//! are bytes.
#![forbid(unsafe_code)]

mod elementary;
mod handle;
mod nearest;
mod path;
mod string;
mod tag_type;
mod tag_value;
mod template;
mod value;
mod write_value;

pub use elementary::Elementary;
pub use nearest::nearest;
pub use path::{PathError, PathSegment, TagPath, program_name, scope, split};
pub use string::{
    STRING_CAPACITY, STRING_HANDLE, STRING_INSTANCE, STRING_SIZE, clamp_strings, string_template, string_text,
    write_string,
};
pub use tag_type::{Location, TagType, elements_of};
pub use tag_value::{FloatsOnly, StructureValue, TagValue, shortest};
pub use template::{DataType, Member, Template, TemplateBuilder};
pub use value::Value;
pub use write_value::{Fraction, Misfit, WriteValue};
