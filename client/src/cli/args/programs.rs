//! `exec` and `run`.

use clap::{Args, ValueEnum};

use arcline_client::QueueFull;

use super::common::Waiting;

#[derive(Args, Debug)]
pub(crate) struct Exec {
    /// Such as 'MSO(X, M1)'
    pub(crate) call: String,
    #[command(flatten)]
    pub(crate) waiting: Waiting,
}

#[derive(Args, Debug)]
pub(crate) struct Run {
    /// The program
    pub(crate) file: String,
    /// Reaction of a coordinated move to a full queue
    #[arg(long, value_enum, default_value = "wait")]
    pub(crate) queue_full: QueueFullWord,
    /// Continue when an instruction errs
    #[arg(long)]
    pub(crate) keep_going: bool,
    #[command(flatten)]
    pub(crate) waiting: Waiting,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Debug)]
pub(crate) enum QueueFullWord {
    /// Waits for room
    Wait,
    /// Errs with 43
    Error,
}

impl From<QueueFullWord> for QueueFull {
    fn from(word: QueueFullWord) -> Self {
        match word {
            QueueFullWord::Wait => Self::Wait,
            QueueFullWord::Error => Self::Error,
        }
    }
}
