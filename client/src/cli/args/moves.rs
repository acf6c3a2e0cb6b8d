//! Arguments of `move`, `arc`, `change`, `override`, `hold`, `resume`, `stop`, `servo`, `home`.

use clap::{Args, ValueEnum};

use arcline_instruction_set::enumerations;

use super::common::{Motion, Ramps, Speed, System, Waiting};
use super::values::{Percent, Point, word_parser};

/// Arguments of lines and arcs.
#[derive(Args, Debug, Default)]
pub(crate) struct Dynamics {
    /// Positions are distances from the start of the move
    #[arg(long)]
    pub(crate) relative: bool,
    #[command(flatten)]
    pub(crate) speed: Speed,
    #[command(flatten)]
    pub(crate) motion: Motion,
    /// Termination type, by word or number
    #[arg(long, value_name = "T", value_parser = word_parser(&enumerations::TERMINATION_TYPE))]
    pub(crate) termination: Option<i32>,
    /// Merge, by word or number
    #[arg(long, value_name = "M", value_parser = word_parser(&enumerations::MERGE))]
    pub(crate) merge: Option<i32>,
}

#[derive(Args, Debug)]
pub(crate) struct Move {
    #[command(flatten)]
    pub(crate) system: System,
    /// End point, or increments
    #[arg(value_name = "X,Y[,Z]", allow_hyphen_values = true)]
    pub(crate) position: Point,
    #[command(flatten)]
    pub(crate) dynamics: Dynamics,
}

#[derive(Args, Debug)]
pub(crate) struct Arc {
    #[command(flatten)]
    pub(crate) system: System,
    /// End point, or increments
    #[arg(value_name = "X,Y[,Z]", allow_hyphen_values = true)]
    pub(crate) position: Point,
    #[command(flatten)]
    pub(crate) circle: Circle,
    #[command(flatten)]
    pub(crate) direction: Direction,
    /// A full circle
    #[arg(long)]
    pub(crate) full: bool,
    #[command(flatten)]
    pub(crate) dynamics: Dynamics,
}

#[derive(Args, Debug, Default)]
#[group(required = true, multiple = false)]
pub(crate) struct Circle {
    /// A point on the arc
    #[arg(long, value_name = "P", allow_hyphen_values = true)]
    pub(crate) via: Option<Point>,
    /// The centre
    #[arg(long, value_name = "P", allow_hyphen_values = true)]
    pub(crate) center: Option<Point>,
    /// The radius; negative for the longer arc
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub(crate) radius: Option<f64>,
    /// The centre, relative to the start
    #[arg(long, value_name = "P", allow_hyphen_values = true)]
    pub(crate) center_offset: Option<Point>,
}

#[derive(Args, Debug, Default)]
#[group(multiple = false)]
pub(crate) struct Direction {
    /// Clockwise (the default in two dimensions)
    #[arg(long)]
    pub(crate) cw: bool,
    /// Counterclockwise
    #[arg(long)]
    pub(crate) ccw: bool,
    /// The shorter arc (the default in three dimensions)
    #[arg(long)]
    pub(crate) shortest: bool,
    /// The longer arc
    #[arg(long)]
    pub(crate) longest: bool,
}

#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("changes").args(["speed", "accel", "decel"]).required(true).multiple(true))]
pub(crate) struct Change {
    #[command(flatten)]
    pub(crate) system: System,
    #[command(flatten)]
    pub(crate) speed: Speed,
    #[command(flatten)]
    pub(crate) ramps: Ramps,
    /// Change the pending move too
    #[arg(long)]
    pub(crate) pending: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Stop {
    /// A coordinate system or an axis; all of them by default
    #[arg(value_name = "CS|AXIS")]
    pub(crate) name: Option<String>,
    /// The motion to stop
    #[arg(long = "type", value_enum, default_value = "all")]
    pub(crate) kind: StopType,
    /// Stop everything, and refuse motion until `arcline release`
    #[arg(long, conflicts_with_all = ["name", "kind"])]
    pub(crate) hold: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Override {
    #[command(flatten)]
    pub(crate) system: System,
    /// Percent of the programmed speeds, 0 to 200
    #[arg(value_name = "PERCENT[%]", allow_hyphen_values = true)]
    pub(crate) percent: Percent,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Debug)]
pub(crate) enum StopType {
    /// Moves and transforms
    All,
    /// Moves
    Move,
    /// Transforms
    Transform,
}

#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("which").args(["axes", "all"]).required(true))]
pub(crate) struct Servo {
    /// On or off
    #[arg(value_enum)]
    pub(crate) state: OnOff,
    /// Axes
    #[arg(value_name = "AXIS")]
    pub(crate) axes: Vec<String>,
    /// Every axis that has a drive
    #[arg(long)]
    pub(crate) all: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Home {
    /// Axes
    #[arg(value_name = "AXIS", required = true)]
    pub(crate) axes: Vec<String>,
    #[command(flatten)]
    pub(crate) waiting: Waiting,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Debug)]
pub(crate) enum OnOff {
    On,
    Off,
}
