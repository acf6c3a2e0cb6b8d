//! The state of the whole machine at one tick, for publication.

use crate::machine::Machine;
use arcline_motion::{AxisSnapshot, SystemSnapshot};

/// Every axis and coordinate system at the end of one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// The tick.
    pub tick: u64,
    /// Axes in configuration order.
    pub axes: Vec<AxisSnapshot>,
    /// Coordinate systems in configuration order.
    pub systems: Vec<SystemSnapshot>,
    /// The number of events lost in the controller for lack of room.
    pub lost_events: u64,
}

impl Snapshot {
    /// An empty snapshot with memory for all objects of a machine.
    pub fn new(machine: &Machine) -> Self {
        let systems = machine.systems.iter().map(|system| SystemSnapshot {
            tool: system.robot.map(|_| [f64::NAN; 3]),
            ..SystemSnapshot::default()
        });
        Snapshot {
            tick: 0,
            axes: vec![AxisSnapshot::default(); machine.axes.len()],
            systems: systems.collect(),
            lost_events: 0,
        }
    }
}
