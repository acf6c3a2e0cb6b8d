//! The errors of a configuration, and their positions.

use std::borrow::Cow;
use std::fmt;

/// A configuration that cannot be used: the position, the key, the value found and the value expected.
///
/// Displayed as `FILE:LINE:COLUMN: KEY: found value, expected value`.
#[derive(Clone, PartialEq, Debug)]
pub struct ConfigError {
    /// Name of the file, as given to [`crate::load`].
    pub file: String,
    /// Line of the value or key at fault, from 1.
    pub line: usize,
    /// Column of the value or key at fault in characters, from 1.
    pub column: usize,
    /// Path of the key, such as `axis[1].max_speed` (tables of a list count from 1) or `server.listen`; empty
    /// for the file as a whole.
    pub key: String,
    /// The problem.
    pub problem: Box<Problem>,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: ", self.file, self.line, self.column)?;
        if !self.key.is_empty() {
            write!(f, "{}: ", self.key)?;
        }
        self.problem.fmt(f)
    }
}

impl std::error::Error for ConfigError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.problem)
    }
}

/// The problem at the position of a [`ConfigError`].
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The text is not TOML.
    #[error("not valid TOML: {message}")]
    Syntax {
        /// The TOML parser's message.
        message: String,
    },
    /// The text is larger than any configuration need be.
    #[error("the file has {size} bytes, expected at most {limit}")]
    TooLarge {
        /// Size of the text, bytes.
        size: usize,
        /// The limit, bytes.
        limit: usize,
    },
    /// A key that nothing reads.
    #[error("unknown key{}, expected one of {}", suggest(.suggestion), .known.join(", "))]
    UnknownKey {
        /// The nearest known key.
        suggestion: Option<String>,
        /// All keys that are known here.
        known: Vec<&'static str>,
    },
    /// A key that must be there is not.
    #[error("missing, expected {expected}")]
    Missing {
        /// The expected value of the key.
        expected: Cow<'static, str>,
    },
    /// A value of the wrong type, out of range, or not in the list.
    #[error("found {found}{}, expected {expected}", suggest(.suggestion))]
    Value {
        /// The value as it stands in the file.
        found: String,
        /// The expected value of the key.
        expected: Cow<'static, str>,
        /// The nearest legal word.
        suggestion: Option<String>,
    },
    /// A name that nothing has.
    #[error("there is no {what} `{name}`{}", suggest(.suggestion))]
    UnknownName {
        /// The sort of the name: `axis`, `coordinate system`.
        what: &'static str,
        /// The name.
        name: String,
        /// The nearest name of that sort.
        suggestion: Option<String>,
    },
    /// A name that is taken already; names ignore case.
    #[error("the name `{name}` is taken by line {line}, expected a name of its own (case is ignored)")]
    Duplicate {
        /// The name.
        name: String,
        /// Line where it was used first, from 1.
        line: usize,
    },
    /// Two keys that contradict each other.
    #[error("cannot stand together with `{other}`: {reason}")]
    Conflict {
        /// The other key.
        other: &'static str,
        /// The reason for the refusal.
        reason: &'static str,
    },
    /// More tables of one sort than there can be.
    #[error("found {count} of them, expected at most {limit}")]
    TooMany {
        /// The number in the file.
        count: usize,
        /// The greatest number.
        limit: usize,
    },
}

impl Problem {
    /// The expected value of the key, if there is a short answer.
    pub fn expected(&self) -> Option<String> {
        match self {
            Self::Missing { expected } | Self::Value { expected, .. } => Some(expected.to_string()),
            Self::UnknownKey { known, .. } => Some(format!("one of {}", known.join(", "))),
            Self::TooLarge { limit, .. } | Self::TooMany { limit, .. } => Some(format!("at most {limit}")),
            Self::Duplicate { .. } => Some("a name of its own".to_owned()),
            Self::Syntax { .. } | Self::UnknownName { .. } | Self::Conflict { .. } => None,
        }
    }
}

fn suggest(suggestion: &Option<String>) -> String {
    suggestion
        .as_ref()
        .map(|word| format!(" (did you mean `{word}`?)"))
        .unwrap_or_default()
}
