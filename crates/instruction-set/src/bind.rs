//! From unbound operands to a [`Call`]: Structured Text, CIP services, instruction tags and the command
//! line all come through here, so the same cause gives the same error.
//!
//! Binding checks types, words and names. The execution checks ranges
//! ([`crate::Instruction::verify`]), because a value out of range is a motion error with ERR and EXERR.

mod error;
mod unbound;

use crate::instruction::{Kind, Object};
use crate::{
    Argument, Call, ControlSlot, MAX_ELEMENTS, MAX_OPERANDS, Mnemonic, OperandIndex, RealArray, TagAddress,
    WrittenArray,
};

pub use error::BindError;
pub use unbound::UnboundOperand;

use unbound::{is_none, short};

/// Knows the names of the machine.
pub trait Directory {
    /// Index of a motion object by its name, case ignored.
    fn object(&self, object: Object, name: &str) -> Option<u16>;

    /// A REAL array tag (or member, such as `Move1.CalculatedData`) that can be written.
    fn real_array(&self, name: &str) -> Option<WrittenArray>;

    /// A tag of a structure type such as `PATH_DATA`. Machines without such tags have none.
    fn structure(&self, type_name: &str, name: &str) -> Option<TagAddress> {
        let _ = (type_name, name);
        None
    }
}

/// Makes a call of an instruction. `operands` are the operands behind target and motion control, in faceplate
/// order; trailing ones may be missing.
///
/// A number for an array is an array of one element, an array of one element is a number, and the number 0
/// is "none" where an operand can be none. Elements behind the ninth of Position and its like are dropped,
/// since no instruction uses them; Event Distance, whose length means something, is refused instead.
/// One more operand that newer faceplates have is dropped ([`crate::Operand::ignored_before`]).
///
/// # Errors
/// See [`BindError`].
pub fn bind(
    mnemonic: Mnemonic,
    target: Option<u16>,
    control: ControlSlot,
    operands: &[UnboundOperand],
    directory: &dyn Directory,
) -> Result<Call, BindError> {
    let instruction = mnemonic.instruction();
    let most = instruction.operands_behind_control().count();
    let ignored = instruction
        .ignored_operand()
        .filter(|_| operands.len() == most + 1)
        .and_then(|ignored| {
            instruction
                .operands_behind_control()
                .position(|operand| operand == ignored)
        });
    if operands.len() > most && ignored.is_none() {
        return Err(BindError::TooMany {
            mnemonic,
            count: operands.len(),
            most,
        });
    }
    let mut values = operands
        .iter()
        .enumerate()
        .filter(|(k, _)| Some(*k) != ignored)
        .map(|(_, value)| value)
        .peekable();
    let mut arguments = [Argument::None; MAX_OPERANDS];
    for place in instruction.operands_behind_control() {
        let binder = Binder {
            mnemonic,
            operand: OperandIndex(place as u8),
            directory,
        };
        let value = values.next().unwrap_or(&UnboundOperand::Missing);
        let kind = &instruction.operands[place].kind;
        // An array of one number arrives as that number. A REAL 0 is such an array if the call has an array for the results of it.
        let is_array = matches!(kind, Kind::ArrayOrNone)
            && *value == UnboundOperand::Number(0.0)
            && values.peek().is_some_and(|next| !is_none(next));
        arguments[place] = if is_array {
            binder.array(value)?
        } else {
            binder.argument(kind, value)?
        };
    }
    Ok(Call {
        mnemonic,
        target,
        control,
        arguments,
    })
}

struct Binder<'a> {
    mnemonic: Mnemonic,
    operand: OperandIndex,
    directory: &'a dyn Directory,
}

impl Binder<'_> {
    fn argument(&self, kind: &Kind, value: &UnboundOperand) -> Result<Argument, BindError> {
        match kind {
            Kind::Target(_) | Kind::MotionControl => Ok(Argument::None),
            Kind::Word(words) => match value {
                UnboundOperand::Word(text) | UnboundOperand::Name(text) => match words.parse_word(text) {
                    Some(value) => Ok(Argument::Number(f64::from(value))),
                    None => Err(self.unknown_word(text)),
                },
                _ => self.number(value, "a word or its number"),
            },
            Kind::Number(_) => self.number(value, "a number"),
            Kind::Integer(_) => self.number(value, "a whole number"),
            Kind::Array(_) => match value {
                UnboundOperand::Missing => Ok(Argument::Array(RealArray::default())),
                _ => self.array(value),
            },
            Kind::ArrayOrNone => match value {
                _ if is_none(value) => Ok(Argument::None),
                UnboundOperand::Array(numbers) if numbers.len() > MAX_ELEMENTS => Err(BindError::TooLong {
                    mnemonic: self.mnemonic,
                    operand: self.operand,
                    count: numbers.len(),
                    most: MAX_ELEMENTS,
                }),
                _ => self.array(value),
            },
            Kind::WrittenArray(_) => match value {
                _ if is_none(value) => Ok(Argument::None),
                UnboundOperand::Word(name) | UnboundOperand::Name(name) => match self.directory.real_array(name) {
                    Some(array) => Ok(Argument::Written(array)),
                    None => Err(BindError::UnknownArray {
                        mnemonic: self.mnemonic,
                        operand: self.operand,
                        name: short(name),
                    }),
                },
                _ => Err(self.wrong_type(value, "the name of a REAL array tag, or 0")),
            },
            Kind::Object(object) => match value {
                UnboundOperand::Word(name) | UnboundOperand::Name(name) => match self.directory.object(*object, name) {
                    Some(index) => Ok(Argument::Object(index)),
                    None => Err(BindError::UnknownObject {
                        mnemonic: self.mnemonic,
                        operand: self.operand,
                        object: *object,
                        name: short(name),
                    }),
                },
                UnboundOperand::Missing => Err(self.missing()),
                _ => Err(self.wrong_type(value, "the name of a motion object")),
            },
            Kind::StructureOrNone(_) if is_none(value) => Ok(Argument::None),
            Kind::Structure(type_name) | Kind::StructureOrNone(type_name) => match value {
                UnboundOperand::Word(name) | UnboundOperand::Name(name) => {
                    match self.directory.structure(type_name, name) {
                        Some(tag) => Ok(Argument::Tag(tag)),
                        None => Err(BindError::UnknownTag {
                            mnemonic: self.mnemonic,
                            operand: self.operand,
                            type_name,
                            name: short(name),
                        }),
                    }
                }
                UnboundOperand::Missing => Err(self.missing()),
                _ => Err(self.wrong_type(value, "the name of a tag")),
            },
        }
    }

    fn number(&self, value: &UnboundOperand, expected: &'static str) -> Result<Argument, BindError> {
        match value {
            UnboundOperand::Missing => Ok(Argument::Number(crate::Operand::OMITTED)),
            UnboundOperand::Number(number) => Ok(Argument::Number(*number)),
            UnboundOperand::Integer(number) => Ok(Argument::Number(*number as f64)),
            UnboundOperand::Array(numbers) if numbers.len() == 1 => Ok(Argument::Number(numbers[0])),
            _ => Err(self.wrong_type(value, expected)),
        }
    }

    fn array(&self, value: &UnboundOperand) -> Result<Argument, BindError> {
        match value {
            UnboundOperand::Array(numbers) => Ok(Argument::Array(RealArray::from_slice(numbers))),
            UnboundOperand::Number(number) => Ok(Argument::Array(RealArray::from_slice(&[*number]))),
            UnboundOperand::Integer(number) => Ok(Argument::Array(RealArray::from_slice(&[*number as f64]))),
            _ => Err(self.wrong_type(value, "an array of numbers")),
        }
    }

    fn missing(&self) -> BindError {
        BindError::TooFew {
            mnemonic: self.mnemonic,
            operand: self.operand,
        }
    }

    fn wrong_type(&self, value: &UnboundOperand, expected: &'static str) -> BindError {
        BindError::WrongType {
            mnemonic: self.mnemonic,
            operand: self.operand,
            value: value.clone(),
            expected,
        }
    }

    fn unknown_word(&self, word: &str) -> BindError {
        BindError::UnknownWord {
            mnemonic: self.mnemonic,
            operand: self.operand,
            word: short(word),
        }
    }
}

#[cfg(test)]
mod tests;
