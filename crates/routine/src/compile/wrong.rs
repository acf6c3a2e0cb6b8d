//! The reason for which a rung's instruction or a statement cannot be compiled.

use std::fmt;

use crate::error::FindingKind;

/// The reason for which an operand or a statement cannot be compiled, in words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Wrong {
    words: String,
    kind: FindingKind,
}

impl Wrong {
    /// A tag, member, type, routine, task or function is not there.
    pub(crate) fn absent(words: String) -> Self {
        Wrong {
            words,
            kind: FindingKind::Absent,
        }
    }

    /// The same with the operand that is meant in front of it.
    #[must_use]
    pub(crate) fn of(self, what: impl fmt::Display) -> Self {
        Wrong {
            words: format!("{what}: {}", self.words),
            kind: self.kind,
        }
    }

    /// The finding that it becomes: an error, or a part that is not there.
    pub(crate) fn kind(&self) -> FindingKind {
        self.kind
    }
}

impl From<String> for Wrong {
    fn from(words: String) -> Self {
        Wrong {
            words,
            kind: FindingKind::Error,
        }
    }
}

impl From<&str> for Wrong {
    fn from(words: &str) -> Self {
        words.to_owned().into()
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

impl From<Wrong> for String {
    fn from(wrong: Wrong) -> Self {
        wrong.words
    }
}
