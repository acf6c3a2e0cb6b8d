//! `exec` and `run`.

use clap::{Args, ValueEnum};

use arcline_client::QueueFull;

#[derive(Args, Debug)]
pub(crate) struct Exec {
    /// Such as 'MSO(X, M1)'
    pub(crate) call: String,
    /// Do not wait for the end of the motion
    #[arg(long)]
    pub(crate) no_wait: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Run {
    /// The program
    pub(crate) file: String,
    /// What a coordinated move does when the queue is full
    #[arg(long, value_enum, default_value = "wait")]
    pub(crate) queue_full: QueueFullWord,
    /// Go on when an instruction errs
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Do not wait for the end of the motion
    #[arg(long)]
    pub(crate) no_wait: bool,
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
