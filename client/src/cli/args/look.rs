//! `watch` and `shell`: what stays.

use clap::Args;

use super::values::seconds;

#[derive(Args, Debug)]
pub(crate) struct Watch {
    /// Axes, coordinate systems, groups; all of them when none is named
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Seconds between two looks
    #[arg(long, value_name = "SECONDS", default_value = "0.1", value_parser = seconds)]
    pub(crate) interval: f64,
    /// End after so many seconds; otherwise by Ctrl-C
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) duration: Option<f64>,
}

#[derive(Args, Debug)]
pub(crate) struct Shell {
    /// Where the lines of earlier sessions are kept; `arcline/history` in the folder of the user's state unless given
    #[arg(long, value_name = "FILE|off")]
    pub(crate) history: Option<String>,
}
