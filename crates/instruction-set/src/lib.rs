//! The instructions of Arcline as data: operands, words, ranges, motion errors, predefined types.
//!
//! One catalogue has the operands of every instruction; Structured Text, CIP services, instruction tags, the
//! command line and the reference pages are made from it. This crate executes no instruction, and encodes none
//! for a network. Numbers are in the units of their operands.
#![forbid(unsafe_code)]

mod attribute;
mod bind;
mod call;
pub mod catalog;
mod control;
pub mod docs;
mod ending;
mod error;
mod explain;
mod fault;
mod form;
mod instruction;
mod instruction_tag;
mod mnemonic;
mod object_id;
pub mod operands;
pub mod predefined;
mod queue;
mod safety_margin;
mod verify;
mod words;

pub use attribute::{ATTRIBUTES, Attribute, DYNAMICS_CONFIGURATION_BITS, Quantity, Setting};
pub use bind::{BindError, Directory, UnboundOperand, bind};
pub use call::{Argument, Call, ControlSlot, MAX_ELEMENTS, MAX_OPERANDS, RealArray, TagAddress, WrittenArray};
pub use control::{Flag, MotionControl};
pub use ending::{Ending, JogEnd};
pub use error::{AxisIndex, Culprit, Detail, ERRORS, ErrorText, Extended, MotionError, OperandIndex, describe};
pub use explain::{Explanation, explain};
pub use fault::{ExceptionAction, FAULTS, Fault, FaultKind, FaultSet, FaultWord};
pub use form::{TargetDialog, TargetRow, Unit};
pub use instruction::{
    ArrayRule, Axes, Condition, FIRST_SERVICE, Instruction, Kind, Object, Operand, Range, Timing, by_service, services,
};
pub use instruction_tag::{
    instruction_tag_defaults, instruction_tag_operands, instruction_tag_target, instruction_tag_template, locate,
    set_instruction_tag_target,
};
pub use mnemonic::{Mnemonic, UnknownMnemonic};
pub use object_id::{AxisId, SystemId};
pub use safety_margin::BlendedSequence;
pub use words::{Enumeration, Word, Words, list as enumerations};
