//! `move-axis` and `jog`: what single axes are told.

use clap::Args;

use super::values::Rate;

#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("way").args(["relative", "shortest", "positive", "negative"]))]
pub(crate) struct MoveAxis {
    /// Axis
    #[arg(value_name = "AXIS")]
    pub(crate) axis: String,
    /// End position, or distance
    #[arg(value_name = "POSITION", allow_hyphen_values = true)]
    pub(crate) position: f64,
    /// Take the position relative to where the move begins
    #[arg(long)]
    pub(crate) relative: bool,
    /// Rotary axis: the short way
    #[arg(long)]
    pub(crate) shortest: bool,
    /// Rotary axis: forwards
    #[arg(long)]
    pub(crate) positive: bool,
    /// Rotary axis: backwards
    #[arg(long)]
    pub(crate) negative: bool,
    /// Speed: units/s, or % of the maximum
    #[arg(long, value_name = "V[%]", allow_hyphen_values = true)]
    pub(crate) speed: Option<Rate>,
    #[command(flatten)]
    pub(crate) motion: AxisMotion,
}

#[derive(Args, Debug)]
pub(crate) struct Jog {
    /// Axis
    #[arg(value_name = "AXIS")]
    pub(crate) axis: String,
    /// Speed: units/s, or % of the maximum; negative backwards
    #[arg(value_name = "SPEED[%]", allow_hyphen_values = true)]
    pub(crate) speed: Rate,
    #[command(flatten)]
    pub(crate) motion: AxisMotion,
}

/// What moves and jogs of an axis have in common.
#[derive(Args, Debug, Default)]
pub(crate) struct AxisMotion {
    /// Acceleration: units/s², or % of the maximum
    #[arg(long, value_name = "A[%]", allow_hyphen_values = true)]
    pub(crate) accel: Option<Rate>,
    /// Deceleration: units/s², or % of the maximum
    #[arg(long, value_name = "D[%]", allow_hyphen_values = true)]
    pub(crate) decel: Option<Rate>,
    /// Trapezoidal profile instead of an S-curve
    #[arg(long)]
    pub(crate) trapezoid: bool,
    /// End other moves, jogs and gears of the axis; without it they add
    #[arg(long)]
    pub(crate) merge: bool,
    /// Name of the motion control tag, made on first use
    #[arg(long, value_name = "NAME")]
    pub(crate) tag: Option<String>,
    /// Do not wait for the end of the motion
    #[arg(long)]
    pub(crate) no_wait: bool,
}
