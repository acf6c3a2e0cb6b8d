//! An operand as a program or client gave it, before binding.

use std::fmt;

/// The value of an operand in a call, before binding.
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

/// 0, `None`, or left out.
pub(super) fn is_none(given: &Given) -> bool {
    match given {
        Given::Missing => true,
        Given::Number(number) => *number == 0.0,
        Given::Integer(number) => *number == 0,
        Given::Word(text) | Given::Name(text) => text.is_empty() || text.eq_ignore_ascii_case("none"),
        Given::Array(numbers) => numbers.is_empty(),
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
