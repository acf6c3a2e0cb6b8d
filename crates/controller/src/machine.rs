//! The machine: the motion group, and the drives behind its axes.
//!
//! The motion core receives only the [`MotionGroup`]. A fieldbus or a plant model adds its configuration here, beside that of the
//! simulated drives.

use std::ops::{Deref, DerefMut};

pub use arcline_drive::simulated::{Sensor, Settings};
pub use arcline_motion::machine::*;

/// A motion group with its drives.
#[derive(Clone, PartialEq, Debug)]
pub struct Machine {
    /// The axes, coordinate systems and transforms.
    pub motion: MotionGroup,
    /// The simulated drive of each axis, in the order of the axes; `None`: the axis has no drive.
    pub drives: Vec<Option<SimulatedDrive>>,
}

/// The configuration of a simulated drive.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct SimulatedDrive {
    /// The servo, its motor and its encoder.
    pub settings: Settings,
    /// Home switch, marker and mechanical stops.
    pub sensor: Sensor,
}

impl Machine {
    /// A motion group whose servo axes have simulated drives with default settings and without sensors.
    pub fn new(motion: MotionGroup) -> Self {
        let drive = |axis: &Axis| (axis.kind == AxisKind::Servo).then(SimulatedDrive::default);
        let drives = motion.axes.iter().map(drive).collect();
        Machine { motion, drives }
    }
}

impl SimulatedDrive {
    /// The inputs for homing that motion may rely on.
    pub fn home_inputs(&self) -> HomeInputs {
        let has_edge = |direction| self.sensor.edge(direction).is_some_and(f64::is_finite);
        HomeInputs {
            switch: match [has_edge(1.0), has_edge(-1.0)] {
                [true, true] => Some(HomeSwitch::Both),
                [true, false] => Some(HomeSwitch::Forward),
                [false, true] => Some(HomeSwitch::Reverse),
                [false, false] => None,
            },
            marker: self.sensor.marker.is_some(),
            stops: self.sensor.stops.is_some(),
        }
    }
}

/// Most readers of a machine read its motion group.
impl Deref for Machine {
    type Target = MotionGroup;

    fn deref(&self) -> &MotionGroup {
        &self.motion
    }
}

impl DerefMut for Machine {
    fn deref_mut(&mut self) -> &mut MotionGroup {
        &mut self.motion
    }
}
