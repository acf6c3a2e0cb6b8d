//! Tag services of a Logix-like controller and the data they carry (spec/ethernet-ip.md §9-§11; spec/contract.md §4).
//!
//! Codecs only: which tag, its type and its value are the caller's. Requests ignore surplus bytes, because stock clients
//! send them (spec/ethernet-ip.md §4); operands of motion services ([`decode_operands`]) do not.

mod browse;
mod create;
mod definition;
mod operands;
mod tag_services;
mod template;
mod wire_type;

pub use browse::{Symbol, instance_list_reply};
pub use create::CreateSymbol;
pub use definition::{Definition, data_type, template_instance};
pub use operands::{MAX_OPERANDS, Typed, TypedError, decode_operands, encode_operands};
pub use tag_services::{ReadModifyWrite, ReadReply, ReadTag, WriteTag};
pub use template::{ReadTemplate, TemplateAttributes};
pub use wire_type::{SHORT_STRING, STRUCTURE, WireType};
