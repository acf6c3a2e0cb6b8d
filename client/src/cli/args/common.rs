//! What several commands take, once each.

use clap::Args;

use super::values::Rate;

/// What a command is about.
#[derive(Args, Debug, Default)]
pub(crate) struct System {
    /// The coordinate system
    #[arg(id = "system", value_name = "CS")]
    pub(crate) name: String,
}

/// What a command is about.
#[derive(Args, Debug, Default)]
pub(crate) struct Axis {
    /// The axis
    #[arg(id = "axis", value_name = "AXIS")]
    pub(crate) name: String,
}

/// What is looked at.
#[derive(Args, Debug)]
pub(crate) struct Names {
    /// Axes, coordinate systems, groups; all of them when none is named
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
}

/// How fast.
#[derive(Args, Debug, Default)]
pub(crate) struct Speed {
    /// Speed: units/s, or % of the maximum
    #[arg(long, value_name = "V[%]", allow_hyphen_values = true)]
    pub(crate) speed: Option<Rate>,
}

/// How fast it gets faster and slower.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct Ramps {
    /// Acceleration: units/s², or % of the maximum
    #[arg(long, value_name = "A[%]", allow_hyphen_values = true)]
    pub(crate) accel: Option<Rate>,
    /// Deceleration: units/s², or % of the maximum
    #[arg(long, value_name = "D[%]", allow_hyphen_values = true)]
    pub(crate) decel: Option<Rate>,
}

/// Whether a command ends before the motion does.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct Waiting {
    /// Do not wait for the end of the motion
    #[arg(long)]
    pub(crate) no_wait: bool,
}

/// What moves, arcs and jogs have in common.
#[derive(Args, Debug, Default)]
pub(crate) struct Motion {
    #[command(flatten)]
    pub(crate) ramps: Ramps,
    /// Trapezoidal profile instead of an S-curve
    #[arg(long)]
    pub(crate) trapezoid: bool,
    /// Name of the motion control tag, made on first use
    #[arg(long, value_name = "NAME")]
    pub(crate) tag: Option<String>,
    #[command(flatten)]
    pub(crate) waiting: Waiting,
}
