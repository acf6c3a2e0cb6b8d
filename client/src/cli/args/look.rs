//! `status`, `mode`, `watch`, `identify` and `shell`.

use clap::{Args, ValueEnum};

use super::common::Names;
use super::values::seconds;

#[derive(Args, Debug)]
pub(crate) struct Mode {
    /// The mode to change to; none: show it
    #[arg(value_enum)]
    pub(crate) mode: Option<ModeWord>,
}

/// A mode of the controller's program.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum ModeWord {
    /// The tasks run.
    Run,
    /// The tasks do not run.
    Program,
}

#[derive(Args, Debug)]
pub(crate) struct Watch {
    #[command(flatten)]
    pub(crate) of: Names,
    /// Seconds between two updates
    #[arg(long, value_name = "SECONDS", default_value = "0.1", value_parser = seconds)]
    pub(crate) interval: f64,
    /// End after this many seconds; otherwise at Ctrl-C
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) duration: Option<f64>,
}

#[derive(Args, Debug)]
pub(crate) struct Shell {
    /// File with the lines of earlier sessions; by default `arcline/history` in the user's state folder
    #[arg(long, value_name = "FILE|off")]
    pub(crate) history: Option<String>,
}

#[derive(Args, Debug)]
pub(crate) struct Status {
    #[command(flatten)]
    pub(crate) of: Names,
}

#[derive(Args, Debug)]
pub(crate) struct Identify {
    /// Ask all devices at a broadcast address
    #[arg(long, value_name = "ADDR[:PORT]")]
    pub(crate) broadcast: Option<String>,
    /// Seconds to listen for answers to a broadcast
    #[arg(long, value_name = "SECONDS", default_value = "1")]
    pub(crate) wait: f64,
}
