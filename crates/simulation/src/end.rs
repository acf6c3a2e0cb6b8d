//! The ends of runs, and the refusals of statements.

use std::fmt;

use arcline_controller::image::{ControlError, ReadError, WriteError};
use arcline_instruction_set::{BindError, Mnemonic, describe};
use arcline_structured_text::RunError;

/// The end of a run.
#[derive(Clone, Debug)]
pub enum End {
    /// The program ran to its end and all motion ended.
    Finished,
    /// An instruction erred, and the motion that had begun ended.
    Erred(Erred),
    /// The program could not continue.
    Wrong(RunError<Refused>),
    /// The time limit passed, s.
    TooLong(f64),
    /// The observer ended the run.
    Left,
}

/// An instruction that erred.
#[derive(Clone, Debug, PartialEq)]
pub struct Erred {
    /// Its motion control tag; empty: none.
    pub tag: String,
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// Line of its call, from 1.
    pub line: usize,
    /// ERR.
    pub err: i16,
    /// EXERR.
    pub exerr: i8,
    /// The operand at fault, if it was left out.
    pub left_out: Option<&'static str>,
}

impl Erred {
    /// The text of the error.
    pub fn text(&self) -> String {
        let text = describe(self.err, self.exerr, Some(self.mnemonic));
        match self.left_out {
            Some(operand) => format!("{text}: {operand} was not given"),
            None => text,
        }
    }
}

impl fmt::Display for Erred {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tag = if self.tag.is_empty() { "without tag" } else { &self.tag };
        write!(f, "line {}: {} ({tag}): {}", self.line, self.mnemonic, self.text())
    }
}

/// The reason why a statement was not executed.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Refused {
    /// The operands do not fit.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The name is not a valid name of a motion control tag.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// No axis or coordinate system has the name.
    #[error("there is no axis or coordinate system {name}")]
    NoObject {
        /// The name.
        name: String,
    },
    /// A tag cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A tag cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// An instruction erred: this one, or an earlier one in a tick that has passed.
    #[error("an instruction erred")]
    Erred {
        /// ERR.
        err: i16,
    },
    /// No motion or change is left that could make the condition of a WAIT true.
    #[error("WAIT can no longer come true: every axis is at rest, and nothing has changed for {STILL_SECONDS} s")]
    Still,
}

/// Simulated seconds for which a WAIT lasts while the machine is at rest. Only the program moves a simulated machine, and any
/// remaining motion of a drive or servo has ended long before.
pub(crate) const STILL_SECONDS: u32 = 60;
