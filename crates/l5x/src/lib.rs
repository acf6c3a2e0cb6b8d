//! L5X, the XML of a Studio 5000 project, and Arcline's configuration: text in, values out, both ways.
//!
//! [`import()`] takes the tags, data types, axes, coordinate systems and the motion group of an export and makes tables of
//! a configuration of them; its [`Report`] has all parts that it does not understand or that have no counterpart in a configuration.
//! [`logic()`] takes tasks, programs, routines and modules as they are written, for `arcline-routine`.
//! [`export`] writes a project so that it imports again as the same one. It reads and writes no files and runs no logic. The correspondence is one table, [`mapping`], which
//! docs/L5X.md shows. Units are those of the two formats: L5X has the coarse update period in microseconds and gains in per
//! cent, all else in position units and seconds.
//!
//! Source of the attributes' meanings: spec/axis-and-data-types.md §9.
#![forbid(unsafe_code)]

mod document;
mod error;
mod export;
mod import;
mod logic;
pub mod mapping;
mod overlay;
mod report;
mod scan;
mod text;

pub use error::{L5xError, Problem};
pub use export::export;
pub use import::{Import, import, machine};
pub use logic::logic;
pub use report::{Group, Reason, Report};
pub use scan::{MAX_ATTRIBUTES, MAX_DEPTH, MAX_TEXT};

#[cfg(test)]
mod tests;
