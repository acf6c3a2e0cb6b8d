//! Arguments that several commands share.

use clap::Args;

use super::values::Rate;

/// The coordinate system of a command.
#[derive(Args, Debug, Default)]
pub(crate) struct System {
    /// The coordinate system
    #[arg(id = "system", value_name = "CS")]
    pub(crate) name: String,
}

/// The axis of a command.
#[derive(Args, Debug, Default)]
pub(crate) struct Axis {
    /// The axis
    #[arg(id = "axis", value_name = "AXIS")]
    pub(crate) name: String,
}

/// The objects of a command that shows them.
#[derive(Args, Debug)]
pub(crate) struct Names {
    /// Axes, coordinate systems, groups; all of them by default
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
}

/// The speed.
#[derive(Args, Debug, Default)]
pub(crate) struct Speed {
    /// Speed: units/s, or % of the maximum
    #[arg(long, value_name = "V[%]", allow_hyphen_values = true)]
    pub(crate) speed: Option<Rate>,
}

/// Acceleration and deceleration.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct Ramps {
    /// Acceleration: units/s², or % of the maximum
    #[arg(long, value_name = "A[%]", allow_hyphen_values = true)]
    pub(crate) accel: Option<Rate>,
    /// Deceleration: units/s², or % of the maximum
    #[arg(long, value_name = "D[%]", allow_hyphen_values = true)]
    pub(crate) decel: Option<Rate>,
}

/// Selects whether a command ends before the motion does.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct Waiting {
    /// Do not wait for the end of the motion
    #[arg(long)]
    pub(crate) no_wait: bool,
}

/// Arguments of moves, arcs and jogs.
#[derive(Args, Debug, Default)]
pub(crate) struct Motion {
    #[command(flatten)]
    pub(crate) ramps: Ramps,
    /// Trapezoidal profile instead of an S-curve
    #[arg(long)]
    pub(crate) trapezoid: bool,
    /// Name of the motion control tag; the server creates it on first use
    #[arg(long, value_name = "NAME")]
    pub(crate) tag: Option<String>,
    #[command(flatten)]
    pub(crate) waiting: Waiting,
}
