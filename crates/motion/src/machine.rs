//! The configuration of motion: the axes, coordinate systems and transforms of a motion group, and their limits.
//!
//! `arcline-config` makes it. It holds no data that change while the machine runs, and none of the drives behind the axes: those are
//! configured beside it (`arcline_controller::machine`).
//!
//! Units: positions in the axis's own units (u), speeds u/s, rates u/s², jerks u/s³, times in
//! nanoseconds or seconds as named. Indices (`u16`) count from 0 in configuration order.

mod axis;
mod home;
mod inputs;
mod limits;
mod system;

pub use axis::{
    Axis, AxisKind, CommandLimits, ExceptionActions, PositionErrorLimit, ProgrammedStopMode, StartState, Travel,
};
pub use home::{Home, HomeDirection, HomeInputs, HomeMode, HomeSequence, HomeSwitch};
pub use inputs::{AxisInputs, FeedTag};
pub(crate) use limits::three;
pub use limits::{
    MAX_AXES, MAX_OUTPUT_TARGETS, MAX_PRIMARY_AXES, MAX_QUEUE_DEPTH, MAX_SYSTEM_AXES, MAX_SYSTEMS, MAX_TRANSFORMS,
    default_jerk,
};
pub use system::{CoordinateSystem, Corner, KinematicStructure, LimitPolicy, Orientation, Robot};

pub use arcline_contour::Deviation;
pub use arcline_kinematics::{Geometry, Parameters, Wrist};
pub use arcline_planner::profile::DynamicsBits;

use arcline_instruction_set::{AxisId, SystemId};

/// The motion group: all axes, coordinate systems and transforms that motion controls.
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

    /// The axis of that name, case ignored.
    pub fn axis(&self, name: &str) -> Option<AxisId> {
        index_of(self.axes.iter().map(|axis| axis.name.as_str()), name).map(AxisId)
    }

    /// The coordinate system of that name, case ignored.
    pub fn system(&self, name: &str) -> Option<SystemId> {
        index_of(self.systems.iter().map(|system| system.name.as_str()), name).map(SystemId)
    }

    /// The index of the transform of that name, case ignored.
    pub fn transform(&self, name: &str) -> Option<u16> {
        index_of(self.transforms.iter().map(|transform| transform.name.as_str()), name)
    }

    /// The motion group has that name, case ignored.
    pub fn is_group(&self, name: &str) -> bool {
        self.group.eq_ignore_ascii_case(name)
    }
}

/// A link between two coordinate systems for MCT.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Transform {
    /// Name of the link.
    pub name: String,
    /// The source system in [`MotionGroup::systems`].
    pub source: SystemId,
    /// The target system in [`MotionGroup::systems`]; differs from the source.
    pub target: SystemId,
}

fn index_of<'a>(mut names: impl Iterator<Item = &'a str>, name: &str) -> Option<u16> {
    names
        .position(|other| other.eq_ignore_ascii_case(name))
        .and_then(|index| u16::try_from(index).ok())
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
}
