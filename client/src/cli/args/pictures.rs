//! `gcode` and `plot`: files in, motion, programs and pictures out.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::values::Point;

#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("instead").args(["simulate", "emit"]))]
pub(crate) struct Gcode {
    /// The program
    #[arg(value_name = "FILE.ngc")]
    pub(crate) file: PathBuf,
    /// The coordinate system that runs it
    #[arg(value_name = "CS")]
    pub(crate) system: String,
    /// Run it on a virtual clock, by `arcline-server simulate`, and print its duration
    #[arg(long)]
    pub(crate) simulate: bool,
    /// Write it as Structured Text instead; - is standard output
    #[arg(long, value_name = "OUT.st")]
    pub(crate) emit: Option<PathBuf>,
    /// With --simulate: the configuration of the machine; by default the embedded one
    #[arg(long, value_name = "FILE.toml", requires = "simulate")]
    pub(crate) config: Option<PathBuf>,
    /// With --simulate: write a trace
    #[arg(long, value_name = "OUT.csv", requires = "simulate")]
    pub(crate) trace: Option<PathBuf>,
    /// With --simulate: write the events
    #[arg(long, value_name = "OUT.jsonl", requires = "simulate")]
    pub(crate) events: Option<PathBuf>,
    /// Number of axes of the coordinate system; by default that of the server, without a server 3
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=3))]
    pub(crate) axes: Option<u8>,
    /// Unit of the coordinate system; by default that of the server, without a server mm
    #[arg(long, value_enum)]
    pub(crate) unit: Option<Unit>,
    /// Position before the first line; by default that of the server, without a server 0
    #[arg(long, value_name = "X,Y[,Z]", allow_hyphen_values = true)]
    pub(crate) start: Option<Point>,
    /// Words to skip, such as M3, or S for every S word
    #[arg(long, value_name = "WORD", value_delimiter = ',')]
    pub(crate) skip: Vec<String>,
    /// Name of the motion control tag; the server creates it on first use
    #[arg(long, value_name = "NAME", default_value = "Ngc")]
    pub(crate) tag: String,
}

impl Gcode {
    /// Whether the program runs on a server.
    pub(crate) fn needs_server(&self) -> bool {
        !self.simulate && self.emit.is_none()
    }
}

/// A unit of length.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Unit {
    /// Millimetre
    Mm,
    /// Inch
    Inch,
}

#[derive(Args, Debug)]
pub(crate) struct Diff {
    /// A trace, of `arcline-server simulate --trace` or `arcline trace`
    #[arg(value_name = "A.csv")]
    pub(crate) a: PathBuf,
    /// The other one
    #[arg(value_name = "B.csv")]
    pub(crate) b: PathBuf,
    /// Greatest difference of two numbers that counts as none; ticks and times have none
    #[arg(long, value_name = "NUMBER", default_value = "0", value_parser = tolerance)]
    pub(crate) tolerance: f64,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(tolerance) if (0.0..f64::INFINITY).contains(&tolerance) => Ok(tolerance),
        _ => Err("expected a number, 0 or more".to_owned()),
    }
}

#[derive(Args, Debug)]
pub(crate) struct Plot {
    /// The trace, of `arcline-server simulate --trace` or `arcline trace`
    #[arg(value_name = "FILE.csv")]
    pub(crate) trace: PathBuf,
    /// The picture
    #[arg(short, long, value_name = "OUT.svg|.png")]
    pub(crate) output: PathBuf,
    /// Mark the instructions of these events
    #[arg(long, value_name = "FILE.jsonl")]
    pub(crate) events: Option<PathBuf>,
    /// The axes, the first two or three with their path; by default those that move
    #[arg(long, value_name = "AXIS", value_delimiter = ',')]
    pub(crate) axes: Vec<String>,
    /// A title
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub(crate) title: String,
    /// PNG: scale of the picture, which is 960 by 596 pixels at 1
    #[arg(long, value_name = "FACTOR", default_value = "2")]
    pub(crate) scale: f32,
}
