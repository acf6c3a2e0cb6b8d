//! The errors of a text, and of a project that is loaded.

use std::fmt;

/// The reason for which a text is not a rung, expression or statement. Positions are byte offsets in it.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum SyntaxError {
    /// Another text is found there.
    #[error("found {found:?}, expected {expected}")]
    Unexpected {
        /// Byte in the text.
        at: usize,
        /// The beginning of the text there.
        found: String,
        /// The tokens that are possible here.
        expected: &'static str,
    },
    /// A text in quotes or a comment has no end.
    #[error("a text or comment that begins here has no end")]
    Unended {
        /// Its first byte.
        at: usize,
    },
    /// A number that no type holds.
    #[error("a number that no type holds, expected at most 64 bits")]
    NumberTooLarge {
        /// Its first byte.
        at: usize,
    },
    /// Brackets, branches or statements within one another.
    #[error("nested deeper than {limit}")]
    TooDeep {
        /// Byte in the text.
        at: usize,
        /// The limit.
        limit: usize,
    },
    /// The text is longer than any real one.
    #[error("longer than {limit}")]
    TooLong {
        /// The limit.
        limit: usize,
    },
}

impl SyntaxError {
    /// Byte in the text.
    pub fn at(&self) -> usize {
        match self {
            Self::Unexpected { at, .. }
            | Self::Unended { at }
            | Self::NumberTooLarge { at }
            | Self::TooDeep { at, .. } => *at,
            Self::TooLong { .. } => 0,
        }
    }
}

/// A part of a project that does not run, and where it stands.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Finding {
    /// The kind of part.
    pub kind: FindingKind,
    /// Its name: the mnemonic, the type, the routine.
    pub name: String,
    /// The reason for which it does not run; empty: it is not implemented.
    pub reason: String,
    /// The program, or the add-on instruction.
    pub program: Option<String>,
    /// The routine.
    pub routine: Option<String>,
    /// Rung or line.
    pub place: Option<Line>,
}

impl Finding {
    /// A finding without a place; empty reason: the part is not implemented.
    #[must_use]
    pub fn new(kind: FindingKind, name: &str, reason: String) -> Self {
        Finding {
            kind,
            name: name.to_owned(),
            reason,
            program: None,
            routine: None,
            place: None,
        }
    }

    /// Program, routine and rung or line; empty: the project as a whole.
    pub fn position(&self) -> String {
        let Some(program) = &self.program else {
            return String::new();
        };
        let routine = self.routine.as_ref().map(|routine| format!("/{routine}"));
        let place = self.place.map(|place| format!(" {place}"));
        format!("{program}{}{}", routine.unwrap_or_default(), place.unwrap_or_default())
    }

    /// The part and the reason, without its position.
    pub fn what(&self) -> String {
        let Finding { kind, name, reason, .. } = self;
        match (kind, reason.as_str()) {
            (kind, "") => format!("{} {name} is not supported", kind.name()),
            (FindingKind::Absent | FindingKind::Error, reason) => format!("{name}: {reason}"),
            (kind, reason) => format!("{} {name}: {reason}", kind.name()),
        }
    }
}

/// A rung of ladder or a line of Structured Text, as the file numbers them.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Line {
    /// Number of a rung.
    Rung(u32),
    /// Number of a line.
    Text(u32),
}

/// The kind of a part that does not run.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum FindingKind {
    /// An instruction that Arcline does not have.
    Instruction,
    /// A routine in another language, or encoded.
    Routine,
    /// A program of another kind.
    Program,
    /// A data type.
    Type,
    /// A task.
    Task,
    /// A tag whose first value or whose connection is not that of the file.
    Tag,
    /// A module.
    Module,
    /// A tag of another controller, or for one.
    Shared,
    /// A number in a text that is not the first value of its tag.
    FirstNumber,
    /// A tag, member, type, routine, task or function that an instruction or a statement names and the project does not have, or Arcline left out.
    Absent,
    /// An operand, a tag or a text that does not fit.
    Error,
}

impl FindingKind {
    /// The name of the kind, one word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Instruction => "instruction",
            Self::Routine => "routine",
            Self::Type => "type",
            Self::Program => "program",
            Self::Task => "task",
            Self::Tag | Self::Shared | Self::FirstNumber => "tag",
            Self::Module => "module",
            Self::Absent => "missing",
            Self::Error => "error",
        }
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rung(number) => write!(f, "rung {number}"),
            Self::Text(number) => write!(f, "line {number}"),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.program.is_some() {
            write!(f, "{}: ", self.position())?;
        }
        f.write_str(&self.what())
    }
}
