//! The reason for which a call could not be bound: the operand, its value, and the expected value.

use std::fmt;

use super::UnboundOperand;
use crate::instruction::{Kind, Object};
use crate::{Mnemonic, OperandIndex};

/// The reason for which a call could not be bound. Positions are those of the faceplate.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum BindError {
    /// An operand that has no default was left out.
    #[error("{mnemonic}: {} is missing", NamedOperand(*mnemonic, *operand))]
    TooFew {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The first operand that is missing.
        operand: OperandIndex,
    },
    /// More operands than the faceplate has.
    #[error("{mnemonic}: {count} operands behind target and motion control, expected at most {most}")]
    TooMany {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The number of operands.
        count: usize,
        /// The number of operands of the faceplate behind target and motion control.
        most: usize,
    },
    /// The value does not have the type of the operand.
    #[error("{mnemonic}: {} is {value}, expected {expected}", NamedOperand(*mnemonic, *operand))]
    WrongType {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// The value.
        value: UnboundOperand,
        /// The expected value.
        expected: &'static str,
    },
    /// An array longer than any instruction uses, where the length has a meaning.
    #[error("{mnemonic}: {} has {count} elements, at most {most} are possible", NamedOperand(*mnemonic, *operand))]
    TooLong {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// The number of elements.
        count: usize,
        /// The number of possible elements.
        most: usize,
    },
    /// A word that the enumeration does not have.
    #[error("{mnemonic}: {} is {word:?}, expected one of {}", NamedOperand(*mnemonic, *operand), Choices(*mnemonic, *operand))]
    UnknownWord {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// The word.
        word: String,
    },
    /// No object of that name.
    #[error("{mnemonic}: {} is {name:?}, there is no such {object}", NamedOperand(*mnemonic, *operand))]
    UnknownObject {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// The expected kind of object.
        object: Object,
        /// The name.
        name: String,
    },
    /// No REAL array tag of that name.
    #[error("{mnemonic}: {} is {name:?}, there is no such REAL array tag", NamedOperand(*mnemonic, *operand))]
    UnknownArray {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// The name.
        name: String,
    },
    /// No tag of that type and name.
    #[error("{mnemonic}: {} is {name:?}, there is no such tag of type {type_name}", NamedOperand(*mnemonic, *operand))]
    UnknownTag {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// The type.
        type_name: &'static str,
        /// The name.
        name: String,
    },
}

impl BindError {
    /// The operand at fault; `None` when there are too many.
    pub fn operand(&self) -> Option<OperandIndex> {
        match self {
            Self::TooFew { operand, .. }
            | Self::WrongType { operand, .. }
            | Self::TooLong { operand, .. }
            | Self::UnknownWord { operand, .. }
            | Self::UnknownObject { operand, .. }
            | Self::UnknownArray { operand, .. }
            | Self::UnknownTag { operand, .. } => Some(*operand),
            Self::TooMany { .. } => None,
        }
    }
}

/// "operand 7 (Speed)".
struct NamedOperand(Mnemonic, OperandIndex);

impl fmt::Display for NamedOperand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let operand = self.0.instruction().operands.get(usize::from(self.1.0));
        write!(
            f,
            "operand {} ({})",
            self.1.0,
            operand.map_or("?", |operand| operand.name)
        )
    }
}

/// The words of an operand.
struct Choices(Mnemonic, OperandIndex);

impl fmt::Display for Choices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let operand = self.0.instruction().operands.get(usize::from(self.1.0));
        let Some(Kind::Word(words)) = operand.map(|operand| &operand.kind) else {
            return Ok(());
        };
        f.write_str(&words.choices())
    }
}
