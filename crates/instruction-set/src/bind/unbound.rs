//! An operand as a program or client wrote it, before binding.

use std::fmt;

/// The value of an operand in a call, before binding.
#[derive(Clone, PartialEq, Debug)]
pub enum UnboundOperand {
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

impl fmt::Display for UnboundOperand {
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

impl From<f64> for UnboundOperand {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<i64> for UnboundOperand {
    fn from(number: i64) -> Self {
        Self::Integer(number)
    }
}

impl From<Vec<f64>> for UnboundOperand {
    fn from(numbers: Vec<f64>) -> Self {
        Self::Array(numbers)
    }
}

/// 0, `None`, or left out.
pub(super) fn is_none(operand: &UnboundOperand) -> bool {
    match operand {
        UnboundOperand::Missing => true,
        UnboundOperand::Number(number) => *number == 0.0,
        UnboundOperand::Integer(number) => *number == 0,
        UnboundOperand::Word(text) | UnboundOperand::Name(text) => text.is_empty() || text.eq_ignore_ascii_case("none"),
        UnboundOperand::Array(numbers) => numbers.is_empty(),
    }
}

/// Peers can send long text; a message shows its start.
pub(super) fn short(text: &str) -> String {
    const SHOWN: usize = 60;
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
