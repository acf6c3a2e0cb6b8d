//! The axes of a machine, by their index in its configuration.
//!
//! Not here: one axis (`crate::axis`). Nothing allocates after [`Axes::new`].

use std::ops::{Deref, DerefMut, Index, IndexMut};

use arcline_instruction_set::enumerations::Reference;
use arcline_planner::Clock;
use arcline_profile::KinematicState;

use crate::axis::generator::Law;
use crate::axis::sum::Slot;
use crate::axis::{Axis, AxisState};
use crate::machine::Machine;
use crate::masters::MasterAt;
use crate::masters::cam::{Cam, Source};

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

    /// A master as its slaves read it now. A master without torque moves where its drive does. Before the exchange of a tick, the
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

    /// Brings the followers of an axis to where their masters are at the present tick: its links, the moves that they drive, its
    /// cams and its gear.
    pub(crate) fn follow_masters(&mut self, axis: u16, clock: &Clock) {
        self.read_links(axis, clock);
        self.follow_cams(axis, clock);
        let Some(master) = self[axis].gear().map(|gear| gear.master) else {
            return;
        };
        let at = self.master_at(master.axis, master.reference, clock);
        if let Some(generator) = self[axis].sum.get_mut(Slot::Gear)
            && let Law::Geared(gear) = &mut generator.law
        {
            generator.now = gear.follow(&at, clock);
        }
    }

    fn read_links(&mut self, axis: u16, clock: &Clock) {
        if !self[axis].links.is_empty() {
            let mut links = self[axis].links;
            for link in links.iter_mut() {
                link.master
                    .read(&self.master_at(link.master.axis, link.master.reference, clock), clock);
            }
            self[axis].links = links;
        }
        for slot in Slot::GUIDED {
            let Some(mut guide) = self[axis].sum.get(slot).and_then(|generator| generator.guide) else {
                continue;
            };
            guide.advance(&self.master_at(guide.master.axis, guide.master.reference, clock), clock);
            if let Some(generator) = self[axis].sum.get_mut(slot) {
                generator.guide = Some(guide);
            }
        }
    }

    fn follow_cams(&mut self, axis: u16, clock: &Clock) {
        for slot in Axis::CAMS {
            if let Some(Source::Axis { master, reference }) = self[axis].cam(slot).map(Cam::source) {
                let at = self.master_at(master, reference, clock);
                let slave = &mut self[axis];
                let at = slave.offset_master(slot, at, clock);
                slave.follow_cam(slot, &at, clock);
            }
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

/// A list of different axes, of bounded length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisList<const MOST: usize> {
    axes: [u16; MOST],
    count: usize,
}

impl<const MOST: usize> AxisList<MOST> {
    /// Adds an axis that is not in the list; one for which there is no room is left out.
    pub(crate) fn add(&mut self, axis: u16) {
        if !self.contains(&axis)
            && let Some(end) = self.axes.get_mut(self.count)
        {
            *end = axis;
            self.count += 1;
        }
    }

    /// The index of an axis in the list.
    pub(crate) fn index_of(&self, axis: u16) -> Option<usize> {
        self.iter().position(|own| *own == axis)
    }
}

impl<const MOST: usize> Default for AxisList<MOST> {
    fn default() -> Self {
        AxisList {
            axes: [0; MOST],
            count: 0,
        }
    }
}

impl<const MOST: usize> Deref for AxisList<MOST> {
    type Target = [u16];

    fn deref(&self) -> &[u16] {
        &self.axes[..self.count]
    }
}

impl<const MOST: usize> Extend<u16> for AxisList<MOST> {
    fn extend<I: IntoIterator<Item = u16>>(&mut self, axes: I) {
        axes.into_iter().for_each(|axis| self.add(axis));
    }
}

impl<const MOST: usize> FromIterator<u16> for AxisList<MOST> {
    fn from_iter<I: IntoIterator<Item = u16>>(axes: I) -> Self {
        let mut list = AxisList::default();
        list.extend(axes);
        list
    }
}

/// Whether two lists of axes have one in common.
pub(crate) fn share(some: &[u16], others: &[u16]) -> bool {
    some.iter().any(|axis| others.contains(axis))
}
