//! The configuration of motion: the axes, coordinate systems and transforms of a motion group, and their limits.
//!
//! `arcline-config` makes it. It holds nothing that changes while the machine runs, and nothing of the drives behind the axes: those are
//! configured beside it (`arcline_controller::machine`).
//!
//! Units: positions in the axis's own units (u), speeds u/s, rates u/s², jerks u/s³, times in
//! nanoseconds or seconds as named. Places (`u16`) count from 0 in configuration order.

mod axis;
mod home;
mod inputs;
mod system;

pub use axis::{
    Axis, AxisKind, CommandLimits, ExceptionActions, PositionErrorLimit, ProgrammedStopMode, Start, Travel,
};
pub use home::{Home, HomeDirection, HomeInputs, HomeMode, HomeSequence, HomeSwitch};
pub use inputs::{Feed, Inputs};
pub use system::{AxisLimits, Build, CoordinateSystem, Corner, Orientation, Robot};

pub use arcline_kinematics::{Geometry, Parameters, Wrist};
pub use arcline_planner::precise::Deviation;
pub use arcline_planner::profile::Bounds as DynamicsBits;

use arcline_instruction_set::{AxisId, SystemId};

/// Largest number of axes of one machine.
pub const MAX_AXES: usize = 256;

/// Largest number of coordinate systems of one machine.
pub const MAX_SYSTEMS: usize = 64;

/// Largest number of transforms of one machine.
pub const MAX_TRANSFORMS: usize = 64;

/// Largest number of axes of one coordinate system that moves interpolate as a vector: X, Y, Z.
pub const MAX_PRIMARY_AXES: usize = 3;

/// Largest number of execution targets of output cams of one axis: a bit of OutputCamStatus each.
pub const MAX_OUTPUT_TARGETS: usize = 32;

/// Largest number of axes of one coordinate system: X, Y, Z, Rx, Ry, Rz, or the joints J1 to J6.
pub const MAX_SYSTEM_AXES: usize = 6;

/// Deepest queue of pending moves behind the active one.
pub const MAX_QUEUE_DEPTH: usize = 1000;

/// The motion group: everything that motion controls.
///
/// Motion relies on these properties of it: names are unique without regard to case among group, axes, systems and transforms; every
/// identity (`CoordinateSystem::axes`, `Transform::source`) exists; numbers are finite and within the ranges of their fields.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionGroup {
    /// Coarse update period: the length of one tick, 250,000 to 32,000,000 ns.
    pub period_ns: u64,
    /// Name of the motion group.
    pub group: String,
    /// The axes, at most [`MAX_AXES`].
    pub axes: Vec<Axis>,
    /// The coordinate systems, at most [`MAX_SYSTEMS`].
    pub systems: Vec<CoordinateSystem>,
    /// The transforms that MCT may turn on, at most [`MAX_TRANSFORMS`].
    pub transforms: Vec<Transform>,
}

impl MotionGroup {
    /// A motion group of the name `Motion`, at a coarse update period of 1 ms, without transforms.
    pub fn new(axes: Vec<Axis>, systems: Vec<CoordinateSystem>) -> Self {
        MotionGroup {
            period_ns: 1_000_000,
            group: "Motion".to_owned(),
            axes,
            systems,
            transforms: Vec::new(),
        }
    }

    /// Coarse update period in seconds.
    pub fn period(&self) -> f64 {
        // Exact: the period is far below 2^53 ns.
        self.period_ns as f64 / 1e9
    }

    /// Place of the axis of that name, case ignored.
    pub fn axis(&self, name: &str) -> Option<AxisId> {
        index_of(self.axes.iter().map(|axis| axis.name.as_str()), name).map(AxisId)
    }

    /// Place of the coordinate system of that name, case ignored.
    pub fn system(&self, name: &str) -> Option<SystemId> {
        index_of(self.systems.iter().map(|system| system.name.as_str()), name).map(SystemId)
    }

    /// Place of the transform of that name, case ignored.
    pub fn transform(&self, name: &str) -> Option<u16> {
        index_of(self.transforms.iter().map(|transform| transform.name.as_str()), name)
    }

    /// Whether the motion group has that name, case ignored.
    pub fn is_group(&self, name: &str) -> bool {
        self.group.eq_ignore_ascii_case(name)
    }
}

/// A link between two coordinate systems for MCT.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Transform {
    /// Name of the link.
    pub name: String,
    /// Place of the source system in [`MotionGroup::systems`].
    pub source: SystemId,
    /// Place of the target system in [`MotionGroup::systems`], another one.
    pub target: SystemId,
}

/// The jerk maximum that stands for "100 % of time" at full speed and full rate: `rate² / speed`
/// (spec/axis-and-data-types.md §9.2), u/s³; what an absent jerk maximum is.
pub fn default_jerk(speed: f64, rate: f64) -> f64 {
    if speed > 0.0 { rate * rate / speed } else { 0.0 }
}

fn index_of<'a>(mut names: impl Iterator<Item = &'a str>, name: &str) -> Option<u16> {
    names
        .position(|other| other.eq_ignore_ascii_case(name))
        .and_then(|index| u16::try_from(index).ok())
}

/// The first three of what each axis of a coordinate system has: those of its primary axes, or of an arm's joints.
pub(crate) fn three<T: Copy>(of: &[T; MAX_SYSTEM_AXES]) -> [T; MAX_PRIMARY_AXES] {
    [of[0], of[1], of[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_ignore_case() {
        let machine = MotionGroup {
            period_ns: 1_000_000,
            group: "Motion".into(),
            axes: vec![],
            systems: vec![],
            transforms: vec![Transform {
                name: "T1".into(),
                source: SystemId(0),
                target: SystemId(1),
            }],
        };
        assert_eq!(machine.transform("t1"), Some(0));
        assert_eq!(machine.transform("t2"), None);
        assert!(machine.is_group("MOTION"));
        assert_eq!(machine.period(), 0.001);
    }

    #[test]
    fn absent_jerk_is_full_time() {
        // The value seen in exported projects (spec/axis-and-data-types.md §9.2).
        assert!((default_jerk(92.083336, 894.4814) - 8688.8).abs() < 0.1);
        assert_eq!(default_jerk(0.0, 1.0), 0.0);
    }
}
