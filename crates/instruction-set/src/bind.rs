//! From what somebody gave to a [`Call`]: Structured Text, CIP services, instruction tags and the command
//! line all come through here, so the same cause gives the same error.
//!
//! Binding looks at types, words and names. Ranges are looked at when the instruction executes
//! ([`crate::Instruction::verify`]), because a value out of range is a motion error with ERR and EXERR.

use std::fmt;

use crate::instruction::{Kind, Object};
use crate::{
    Argument, Call, ControlSlot, MAX_ELEMENTS, MAX_OPERANDS, Mnemonic, OperandIndex, RealArray,
};

/// What was given for an operand.
#[derive(Clone, PartialEq, Debug)]
pub enum Given {
    /// Left out: 0, None, Disabled, Programmed.
    Missing,
    /// A number.
    Number(f64),
    /// A whole number.
    Integer(i64),
    /// A bare word: an enumeration word, or a name.
    Word(String),
    /// An array of numbers.
    Array(Vec<f64>),
    /// A name: an object or a tag.
    Name(String),
}

impl fmt::Display for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("missing"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Integer(number) => write!(f, "{number}"),
            Self::Word(text) | Self::Name(text) => write!(f, "{:?}", short(text)),
            Self::Array(numbers) => write!(f, "an array of {}", numbers.len()),
        }
    }
}

impl From<f64> for Given {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<i64> for Given {
    fn from(number: i64) -> Self {
        Self::Integer(number)
    }
}

impl From<Vec<f64>> for Given {
    fn from(numbers: Vec<f64>) -> Self {
        Self::Array(numbers)
    }
}

/// Knows the names of the machine.
pub trait Directory {
    /// Index of a motion object by its name, case ignored.
    fn object(&self, object: Object, name: &str) -> Option<u16>;

    /// A REAL array tag (or member, such as `Move1.CalculatedData`) that can be written.
    fn real_array(&self, name: &str) -> Option<u32>;

    /// A tag of a structure type such as `PATH_DATA`. Machines without such tags have none.
    fn structure(&self, type_name: &str, name: &str) -> Option<u32> {
        let _ = (type_name, name);
        None
    }
}

/// Why a call could not be bound. Positions are those of the faceplate.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum BindError {
    /// An operand that has no default was left out.
    #[error("{mnemonic}: {} is missing", Place(*mnemonic, *operand))]
    TooFew {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The first operand that is missing.
        operand: OperandIndex,
    },
    /// More operands than the faceplate has.
    #[error(
        "{mnemonic}: {given} operands behind target and motion control, expected at most {most}"
    )]
    TooMany {
        /// The instruction.
        mnemonic: Mnemonic,
        /// Operands given.
        given: usize,
        /// Operands of the faceplate behind target and motion control.
        most: usize,
    },
    /// Not the type of the operand.
    #[error("{mnemonic}: {} is {given}, expected {expected}", Place(*mnemonic, *operand))]
    WrongType {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// What was given.
        given: Given,
        /// What is accepted.
        expected: &'static str,
    },
    /// An array longer than any instruction uses, where the length has a meaning.
    #[error("{mnemonic}: {} has {given} elements, at most {most} are possible", Place(*mnemonic, *operand))]
    TooLong {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// Elements given.
        given: usize,
        /// Elements possible.
        most: usize,
    },
    /// A word that the enumeration does not have.
    #[error("{mnemonic}: {} is {word:?}, expected one of {}", Place(*mnemonic, *operand), Choices(*mnemonic, *operand))]
    UnknownWord {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// The word.
        word: String,
    },
    /// No object of that name.
    #[error("{mnemonic}: {} is {name:?}, there is no such {object}", Place(*mnemonic, *operand))]
    UnknownObject {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// What it must be.
        object: Object,
        /// The name.
        name: String,
    },
    /// No REAL array tag of that name.
    #[error("{mnemonic}: {} is {name:?}, there is no such REAL array tag", Place(*mnemonic, *operand))]
    UnknownArray {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The operand.
        operand: OperandIndex,
        /// The name.
        name: String,
    },
    /// No tag of that type and name.
    #[error("{mnemonic}: {} is {name:?}, there is no such tag of type {type_name}", Place(*mnemonic, *operand))]
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

/// Makes a call of an instruction. `given` are the operands behind target and motion control, in faceplate
/// order; trailing ones may be missing.
///
/// A number for an array is an array of one element, an array of one element is a number, and the number 0
/// is "none" where an operand can be none. Elements behind the ninth of Position and its like are dropped,
/// since no instruction uses them; Event Distance, whose length means something, is refused instead.
/// MAPC takes one more operand behind Cam Lock Position, which newer faceplates have, and ignores it.
///
/// # Errors
/// See [`BindError`].
pub fn bind(
    mnemonic: Mnemonic,
    target: Option<u16>,
    control: ControlSlot,
    given: &[Given],
    directory: &dyn Directory,
) -> Result<Call, BindError> {
    let instruction = mnemonic.instruction();
    let most = instruction.given_operands().count();
    let cam_type = (mnemonic == Mnemonic::Mapc && given.len() == most + 1).then_some(MAPC_CAM_TYPE);
    if given.len() > most && cam_type.is_none() {
        return Err(BindError::TooMany {
            mnemonic,
            given: given.len(),
            most,
        });
    }
    let mut values = given
        .iter()
        .enumerate()
        .filter(|(k, _)| Some(*k) != cam_type)
        .map(|(_, value)| value);
    let mut arguments = [Argument::None; MAX_OPERANDS];
    for place in instruction.given_operands() {
        let binder = Binder {
            mnemonic,
            operand: OperandIndex(place as u8),
            directory,
        };
        let value = values.next().unwrap_or(&Given::Missing);
        arguments[place] = binder.argument(&instruction.operands[place].kind, value)?;
    }
    Ok(Call {
        mnemonic,
        target,
        control,
        arguments,
    })
}

/// Place of Cam Type among the given operands of a MAPC that has it.
const MAPC_CAM_TYPE: usize = 9;

struct Binder<'a> {
    mnemonic: Mnemonic,
    operand: OperandIndex,
    directory: &'a dyn Directory,
}

impl Binder<'_> {
    fn argument(&self, kind: &Kind, given: &Given) -> Result<Argument, BindError> {
        match kind {
            Kind::Target(_) | Kind::MotionControl => Ok(Argument::None),
            Kind::Word(words) => match given {
                Given::Word(text) | Given::Name(text) => match words.parse_word(text) {
                    Some(value) => Ok(Argument::Number(f64::from(value))),
                    None => Err(self.unknown_word(text)),
                },
                _ => self.number(given, "a word or its number"),
            },
            Kind::Number(_) => self.number(given, "a number"),
            Kind::Integer(_) => self.number(given, "a whole number"),
            Kind::Array(_) => match given {
                Given::Missing => Ok(Argument::Array(RealArray::default())),
                _ => self.array(given),
            },
            Kind::ArrayOrNone => match given {
                _ if is_none(given) => Ok(Argument::None),
                Given::Array(numbers) if numbers.len() > MAX_ELEMENTS => Err(BindError::TooLong {
                    mnemonic: self.mnemonic,
                    operand: self.operand,
                    given: numbers.len(),
                    most: MAX_ELEMENTS,
                }),
                _ => self.array(given),
            },
            Kind::WrittenArray(_) => match given {
                _ if is_none(given) => Ok(Argument::None),
                Given::Word(name) | Given::Name(name) => match self.directory.real_array(name) {
                    Some(tag) => Ok(Argument::Tag(tag)),
                    None => Err(BindError::UnknownArray {
                        mnemonic: self.mnemonic,
                        operand: self.operand,
                        name: short(name),
                    }),
                },
                _ => Err(self.wrong_type(given, "the name of a REAL array tag, or 0")),
            },
            Kind::Reference(object) => match given {
                Given::Word(name) | Given::Name(name) => match self.directory.object(*object, name)
                {
                    Some(index) => Ok(Argument::Object(index)),
                    None => Err(BindError::UnknownObject {
                        mnemonic: self.mnemonic,
                        operand: self.operand,
                        object: *object,
                        name: short(name),
                    }),
                },
                Given::Missing => Err(self.missing()),
                _ => Err(self.wrong_type(given, "the name of a motion object")),
            },
            Kind::Structure(type_name) => match given {
                Given::Word(name) | Given::Name(name) => {
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
                Given::Missing => Err(self.missing()),
                _ => Err(self.wrong_type(given, "the name of a tag")),
            },
        }
    }

    fn number(&self, given: &Given, expected: &'static str) -> Result<Argument, BindError> {
        match given {
            Given::Missing => Ok(Argument::Number(crate::Operand::OMITTED)),
            Given::Number(number) => Ok(Argument::Number(*number)),
            Given::Integer(number) => Ok(Argument::Number(*number as f64)),
            Given::Array(numbers) if numbers.len() == 1 => Ok(Argument::Number(numbers[0])),
            _ => Err(self.wrong_type(given, expected)),
        }
    }

    fn array(&self, given: &Given) -> Result<Argument, BindError> {
        match given {
            Given::Array(numbers) => Ok(Argument::Array(RealArray::from_slice(numbers))),
            Given::Number(number) => Ok(Argument::Array(RealArray::from_slice(&[*number]))),
            Given::Integer(number) => Ok(Argument::Array(RealArray::from_slice(&[*number as f64]))),
            _ => Err(self.wrong_type(given, "an array of numbers")),
        }
    }

    fn missing(&self) -> BindError {
        BindError::TooFew {
            mnemonic: self.mnemonic,
            operand: self.operand,
        }
    }

    fn wrong_type(&self, given: &Given, expected: &'static str) -> BindError {
        BindError::WrongType {
            mnemonic: self.mnemonic,
            operand: self.operand,
            given: given.clone(),
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

/// 0, `None`, or left out.
fn is_none(given: &Given) -> bool {
    match given {
        Given::Missing => true,
        Given::Number(number) => *number == 0.0,
        Given::Integer(number) => *number == 0,
        Given::Word(text) | Given::Name(text) => {
            text.is_empty() || text.eq_ignore_ascii_case("none")
        }
        Given::Array(numbers) => numbers.is_empty(),
    }
}

/// Peers can send long text; a message shows its start.
fn short(text: &str) -> String {
    const SHOWN: usize = 60;
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// "operand 7 (Speed)".
struct Place(Mnemonic, OperandIndex);

impl fmt::Display for Place {
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
        for (k, word) in words.words.iter().enumerate() {
            write!(
                f,
                "{}{} ({})",
                if k == 0 { "" } else { ", " },
                word.keyword(),
                word.value
            )?;
        }
        Ok(())
    }
}
