//! The axes of a machine, by their index in its configuration.
//!
//! Not here: what one axis is (`crate::axis`). Nothing allocates after [`Axes::new`].

use std::ops::{Deref, DerefMut, Index, IndexMut};

use arcline_planner::Clock;

use crate::axis::{Axis, AxisState};
use crate::machine::Machine;
use crate::masters::MasterAt;
use arcline_instruction_set::enumerations::Reference;
use arcline_profile::KinematicState;

/// Every axis of a machine at the present tick.
#[derive(Debug)]
pub(crate) struct Axes {
    axes: Vec<Axis>,
    /// The feedback of the present tick is there.
    pub(crate) exchanged: bool,
}

impl Axes {
    /// The axes of a machine at rest. The only allocation.
    pub(crate) fn new(machine: &Machine, clock: &Clock) -> Self {
        Axes {
            axes: machine.axes.iter().map(|axis| Axis::new(axis, clock)).collect(),
            exchanged: true,
        }
    }

    /// What a slave reads of a master now. A master without torque moves where its drive does. Before the exchange of a tick, the
    /// actual position is the one that is expected of it.
    pub(crate) fn master_at(&self, master: u16, reference: Reference, clock: &Clock) -> MasterAt {
        let axis = &self[master];
        let commanded = matches!(axis.state, AxisState::Running | AxisState::Starting);
        let (point, read) = match reference {
            Reference::Command if commanded => (axis.command, Reference::Command),
            _ if self.exchanged => (axis.actual, Reference::Actual),
            _ => (axis.expected(clock), Reference::Actual),
        };
        MasterAt {
            point: KinematicState {
                position: point.position - axis.redefined,
                ..point
            },
            read,
            redefined: axis.redefined,
        }
    }
}

impl Deref for Axes {
    type Target = [Axis];

    fn deref(&self) -> &[Axis] {
        &self.axes
    }
}

impl DerefMut for Axes {
    fn deref_mut(&mut self) -> &mut [Axis] {
        &mut self.axes
    }
}

impl Index<u16> for Axes {
    type Output = Axis;

    fn index(&self, axis: u16) -> &Axis {
        &self.axes[usize::from(axis)]
    }
}

impl IndexMut<u16> for Axes {
    fn index_mut(&mut self, axis: u16) -> &mut Axis {
        &mut self.axes[usize::from(axis)]
    }
}

impl Index<usize> for Axes {
    type Output = Axis;

    fn index(&self, axis: usize) -> &Axis {
        &self.axes[axis]
    }
}

impl IndexMut<usize> for Axes {
    fn index_mut(&mut self, axis: usize) -> &mut Axis {
        &mut self.axes[axis]
    }
}

/// Whether two lists of axes have one in common.
pub(crate) fn share(some: &[u16], others: &[u16]) -> bool {
    some.iter().any(|axis| others.contains(axis))
}
