//! The tags of a path move: where a path leads, and how fast (spec/coordinated-instructions.md §23.1, §23.2).
//!
//! They are read beside the tick when the instruction is sent. Nothing is checked here: what the members may be is MCPM's to say.

use arcline_instruction_set::enumerations::{
    InterpolationType, MoveType, TerminationType, TimeUnits, UnitsMode, VelocityProfile,
};

/// A PATH_DATA.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathData {
    /// `None`: a number that is none of its values, as of all words here.
    pub interpolation_type: Option<InterpolationType>,
    /// X, Y, Z in position units; Rx, Ry, Rz, fixed X-Y-Z angles in degrees. The three reserved elements are not kept.
    pub position: [f64; 6],
    /// Flags of the arm's pose.
    pub robot_configuration: i32,
    /// Turns of J1, J4, J6, and one reserved.
    pub turns_counters: [i16; 4],
    /// Absolute or incremental.
    pub move_type: Option<MoveType>,
    /// How the move ends.
    pub termination_type: Option<TerminationType>,
    /// The tolerance of termination type 6, position units.
    pub command_tolerance_linear: f64,
}

/// A DYNAMICS_DATA.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DynamicsData {
    /// Percent of the maxima, or coordination units.
    pub units_mode: Option<UnitsMode>,
    /// By seconds or by master units.
    pub time_units: Option<TimeUnits>,
    /// Trapezoidal or S-curve.
    pub profile: Option<VelocityProfile>,
    /// Speed, Acceleration, Deceleration: percent, or position units per time unit and its square.
    pub linear: [f64; 3],
    /// AccelerationJerk, DecelerationJerk: percent of time.
    pub jerks: [f64; 2],
    /// OrientationSpeed, OrientationAcceleration, OrientationDeceleration: percent, or degrees per time unit and its square.
    pub orientation: [f64; 3],
}

/// The operands that an MCPM has from its two tags.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathMove {
    /// Its Path.
    pub path: PathData,
    /// Its Dynamics.
    pub dynamics: DynamicsData,
}
