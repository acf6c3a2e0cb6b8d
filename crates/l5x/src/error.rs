//! Errors in an L5X file, with their position.

use std::fmt;

/// A file that is no L5X, or one whose content contradicts itself.
///
/// Displayed as `FILE:LINE:COLUMN: PATH: found …, expected …`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct L5xError {
    /// Name of the file, the argument of [`crate::import`].
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The element or attribute, such as `Controller/Tags/Tag/@Dimensions`; empty for the file as a whole.
    pub path: String,
    /// The problem.
    pub problem: Problem,
}

impl fmt::Display for L5xError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: ", self.file, self.line, self.column)?;
        if !self.path.is_empty() {
            write!(f, "{}: ", self.path)?;
        }
        self.problem.fmt(f)
    }
}

impl std::error::Error for L5xError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.problem)
    }
}

/// The problem at the position of an [`L5xError`].
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The text is not well-formed XML, or has a DTD.
    #[error("not valid XML: {message}")]
    Syntax {
        /// The parser's message.
        message: String,
    },
    /// Larger, deeper or wider than is read.
    #[error("found {found} {what}, expected at most {limit}")]
    TooMuch {
        /// The unit of the count: `bytes`, `levels of elements`, `attributes of one element`.
        what: &'static str,
        /// The amount in the file, as far as it was counted.
        found: usize,
        /// The greatest amount.
        limit: usize,
    },
    /// An element or attribute that must be there is not.
    #[error("{what} is missing, expected {expected}")]
    Missing {
        /// The element or `@attribute`.
        what: &'static str,
        /// The expected value.
        expected: &'static str,
    },
    /// A value that does not do.
    #[error("found {found:?}, expected {expected}")]
    Value {
        /// The value, shortened.
        found: String,
        /// The expected value.
        expected: &'static str,
    },
    /// The result is no valid configuration.
    #[error("as a configuration: {message}")]
    Configuration {
        /// The key and its problem.
        message: String,
    },
}
