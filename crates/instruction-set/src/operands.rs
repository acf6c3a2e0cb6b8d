//! The operands of a call as typed values: how the structs of the catalogue ([`crate::catalog`]) read them.
//!
//! An instruction takes its struct apart by a pattern without `..`, so that an operand that no code reads is a compiler error.

use std::ops::Deref;

use crate::instruction::Kind;
use crate::{AxisId, Call, Enumeration, MotionError, OperandIndex, RealArray, SystemId, TagAddress, WrittenArray};

pub use crate::catalog::typed::*;

/// The value of an operand, with the index that a motion error names it by.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OperandValue<T> {
    /// The value.
    pub value: T,
    /// The index on the faceplate.
    pub index: OperandIndex,
}

impl<T> OperandValue<T> {
    /// The error of a value that is not legal (13).
    pub const fn out_of_range(&self) -> MotionError {
        MotionError::ParameterOutOfRange(self.index)
    }
}

impl<T> Deref for OperandValue<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// All operands of an instruction, or some of them that belong together.
pub trait Operands: Sized {
    /// Reads them in faceplate order. Real-time.
    fn read(reader: &mut OperandReader<'_>) -> Self;

    /// The operands of a call. A number that is no value of its enumeration reads as the first value:
    /// [`crate::Instruction::verify`] refuses the call. Real-time.
    fn of(call: &Call) -> Self {
        Self::read(&mut OperandReader { call, next: 0 })
    }
}

/// Reads one operand after another; target and motion control are no values.
#[derive(Debug)]
pub struct OperandReader<'a> {
    call: &'a Call,
    next: usize,
}

impl OperandReader<'_> {
    fn index(&mut self) -> usize {
        let operands = self.call.instruction().operands;
        let is_value = |index: &usize| {
            let kind = operands.get(*index).map(|operand| &operand.kind);
            !matches!(kind, Some(Kind::Target(_) | Kind::MotionControl))
        };
        let index = (self.next..=operands.len()).find(is_value).unwrap_or(operands.len());
        self.next = index + 1;
        index
    }
}

impl<T: FromCall> Operands for OperandValue<T> {
    fn read(reader: &mut OperandReader<'_>) -> Self {
        let index = reader.index();
        OperandValue {
            value: T::from_call(reader.call, index),
            index: OperandIndex(index as u8),
        }
    }
}

/// A type that an operand can have.
pub trait FromCall {
    /// The operand at an index. Real-time.
    fn from_call(call: &Call, operand: usize) -> Self;
}

impl FromCall for f64 {
    fn from_call(call: &Call, operand: usize) -> Self {
        call.number(operand)
    }
}

/// A count.
impl FromCall for i32 {
    fn from_call(call: &Call, operand: usize) -> Self {
        call.word(operand)
    }
}

impl FromCall for RealArray {
    fn from_call(call: &Call, operand: usize) -> Self {
        RealArray::from_slice(call.array(operand))
    }
}

impl FromCall for Option<WrittenArray> {
    fn from_call(call: &Call, operand: usize) -> Self {
        call.written(operand)
    }
}

/// Another axis.
impl FromCall for Option<AxisId> {
    fn from_call(call: &Call, operand: usize) -> Self {
        call.object(operand).map(AxisId)
    }
}

/// Another coordinate system.
impl FromCall for Option<SystemId> {
    fn from_call(call: &Call, operand: usize) -> Self {
        call.object(operand).map(SystemId)
    }
}

/// A structure tag.
impl FromCall for Option<TagAddress> {
    fn from_call(call: &Call, operand: usize) -> Self {
        call.tag(operand)
    }
}

impl<E: Enumeration> FromCall for E {
    fn from_call(call: &Call, operand: usize) -> Self {
        E::from_number(call.word(operand)).unwrap_or(E::FIRST)
    }
}
