//! The tags of a path move: its path and its dynamics (spec/coordinated-instructions.md §23.1, §23.2).
//!
//! They are read beside the tick when the instruction is sent. This module checks nothing; MCPM verifies the members.

use arcline_instruction_set::enumerations::{
    InterpolationType, MoveType, TerminationType, TimeUnits, UnitsMode, VelocityProfile,
};

/// A PATH_DATA.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathData {
    /// `None`: the number is not one of its values; the same holds for all words here.
    pub interpolation_type: Option<InterpolationType>,
    /// X, Y, Z in position units; Rx, Ry, Rz, fixed X-Y-Z angles in degrees. The three reserved elements are left out.
    pub position: [f64; 6],
    /// Flags of the arm's pose.
    pub robot_configuration: i32,
    /// Turns of J1, J4, J6, and one reserved.
    pub turns_counters: [i16; 4],
    /// Absolute or incremental.
    pub move_type: Option<MoveType>,
    /// The termination type.
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

/// The operands of an MCPM from its two tags.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathMove {
    /// Its Path.
    pub path: PathData,
    /// Its Dynamics.
    pub dynamics: DynamicsData,
}
