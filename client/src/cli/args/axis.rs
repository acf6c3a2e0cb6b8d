//! Arguments of `move-axis` and `jog`.

use clap::Args;

use super::common::{Axis, Motion, Speed};
use super::values::Rate;

#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("way").args(["relative", "shortest", "positive", "negative"]))]
pub(crate) struct MoveAxis {
    #[command(flatten)]
    pub(crate) axis: Axis,
    /// End position, or distance
    #[arg(value_name = "POSITION", allow_hyphen_values = true)]
    pub(crate) position: f64,
    /// The position is a distance from the start of the move
    #[arg(long)]
    pub(crate) relative: bool,
    /// Rotary axis: in the direction of the shorter distance
    #[arg(long)]
    pub(crate) shortest: bool,
    /// Rotary axis: in positive direction
    #[arg(long)]
    pub(crate) positive: bool,
    /// Rotary axis: in negative direction
    #[arg(long)]
    pub(crate) negative: bool,
    #[command(flatten)]
    pub(crate) speed: Speed,
    #[command(flatten)]
    pub(crate) motion: AxisMotion,
}

#[derive(Args, Debug)]
pub(crate) struct Jog {
    #[command(flatten)]
    pub(crate) axis: Axis,
    /// Speed: units/s, or % of the maximum; negative for the negative direction
    #[arg(value_name = "SPEED[%]", allow_hyphen_values = true)]
    pub(crate) speed: Rate,
    #[command(flatten)]
    pub(crate) motion: AxisMotion,
}

/// Arguments of moves and jogs of an axis.
#[derive(Args, Debug, Default)]
pub(crate) struct AxisMotion {
    #[command(flatten)]
    pub(crate) motion: Motion,
    /// End other moves, jogs and gears of the axis; otherwise they add
    #[arg(long)]
    pub(crate) merge: bool,
}
