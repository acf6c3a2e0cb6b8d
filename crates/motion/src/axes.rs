//! The axes of a machine, by their index in its configuration.
//!
//! A tick passes over dormant axes ([`Axis::dormant`]): mutable access to an axis wakes it, except in the loops of the tick over
//! all axes ([`Axes::awake_mut`], [`Axes::all_mut`]). Not here: one axis (`crate::axis`). Nothing allocates after [`Axes::new`].

use arcline_instruction_set::AxisId;
use std::ops::{Deref, Index, IndexMut};

use arcline_instruction_set::enumerations::Reference;
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use crate::axis::Axis;
use crate::axis::generator::Equation;
use crate::axis::generator_kind::GeneratorKind;
use crate::axis::state::AxisState;
use crate::control::Controls;
use crate::machine::MotionGroup;
use crate::masters::MasterAt;
use crate::masters::cam::{Cam, Source};
use crate::masters::follower::{DrivenBy, FollowerStart, LockCondition, MasterFollower};
use crate::masters::links::MasterLink;
use crate::masters::master::Master;

/// Every axis of a machine at the present tick.
#[derive(Debug)]
pub(crate) struct Axes {
    axes: Vec<Axis>,
    /// The exchange of the present tick has happened: the actual positions are those of this tick.
    pub(crate) exchanged: bool,
    /// At least one axis has an execution target of output cams.
    pub(crate) have_output_cams: bool,
}

impl Axes {
    /// The axes of a machine at rest. The only allocation.
    pub(crate) fn new(machine: &MotionGroup, clock: &Clock) -> Self {
        Axes {
            axes: machine.axes.iter().map(|axis| Axis::new(axis, clock)).collect(),
            exchanged: true,
            have_output_cams: machine.axes.iter().any(|axis| axis.output_cam_targets > 0),
        }
    }

    /// All axes, in the order of the configuration.
    pub(crate) fn ids(&self) -> impl Iterator<Item = AxisId> + use<> {
        AxisId::first(self.axes.len())
    }

    pub(crate) fn get(&self, axis: AxisId) -> Option<&Axis> {
        self.axes.get(axis.index())
    }

    /// Wakes the axis.
    pub(crate) fn get_mut(&mut self, axis: AxisId) -> Option<&mut Axis> {
        let axis = self.axes.get_mut(axis.index())?;
        axis.dormant = false;
        Some(axis)
    }

    /// Every axis, mutable. Wakes all of them.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Axis> {
        for axis in &mut self.axes {
            axis.dormant = false;
        }
        self.axes.iter_mut()
    }

    /// The axes that a tick does not pass over.
    pub(crate) fn awake_mut(&mut self) -> impl Iterator<Item = &mut Axis> {
        self.axes.iter_mut().filter(|axis| !axis.dormant)
    }

    /// Every axis, without waking it; for changes that leave a dormant axis dormant.
    pub(crate) fn all_mut(&mut self) -> impl Iterator<Item = &mut Axis> {
        self.axes.iter_mut()
    }

    /// Makes those axes dormant that nothing in the tick after this one would change.
    pub(crate) fn let_rest(&mut self, tick: u64) {
        for axis in self.awake_mut() {
            axis.dormant = axis.can_be_dormant();
            axis.dormant_since = tick;
        }
    }

    /// The state of a master axis as its slaves read it in the present tick. The reference of a master without torque is its actual motion.
    /// Before the exchange of a tick, the actual position is the expected one.
    pub(crate) fn master_at(&self, master: AxisId, reference: Reference, clock: &Clock) -> MasterAt {
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

    /// The master follower of a motion that begins on an axis at the present tick; its link is the active one from now on.
    pub(crate) fn begin_follower(
        &mut self,
        axis: AxisId,
        driven_by: DrivenBy,
        controls: &mut Controls,
        clock: &Clock,
    ) -> Option<MasterFollower> {
        let (link, ended) = self[axis].links.take_up(driven_by.link)?;
        controls.end_links([ended]);
        Some(self.follower(&link, driven_by.lock, clock.now(), clock))
    }

    /// The master follower of a motion that begins by a link at an instant of this update.
    pub(crate) fn follower(
        &self,
        link: &MasterLink,
        lock: LockCondition,
        since: Instant,
        clock: &Clock,
    ) -> MasterFollower {
        let Master { axis, reference, .. } = link.master;
        let at = self.master_at(axis, reference, clock);
        let beginning = FollowerStart {
            link: link.id,
            lock,
            unwind: self[axis].unwind,
            since,
        };
        MasterFollower::begin(beginning, &link.master, &at, clock)
    }

    /// Updates the followers of an axis (its links, the moves that they drive, its cams and its gear) to the positions of their masters
    /// at the present tick.
    pub(crate) fn follow_masters(&mut self, axis: AxisId, clock: &Clock) {
        self.read_links(axis, clock);
        self.follow_cams(axis, clock);
        let Some(master) = self[axis].gear().map(|gear| gear.master) else {
            return;
        };
        let at = self.master_at(master.axis, master.reference, clock);
        if let Some(generator) = self[axis].sum.get_mut(GeneratorKind::Gear)
            && let Equation::Geared(gear) = &mut generator.equation
        {
            generator.now = gear.follow(&at, clock);
        }
    }

    fn read_links(&mut self, axis: AxisId, clock: &Clock) {
        if !self[axis].links.is_empty() {
            let mut index = 0;
            loop {
                let Some(link) = self[axis].links.iter().nth(index) else {
                    break;
                };
                let master = &link.master;
                let at = self.master_at(master.axis, master.reference, clock);
                if let Some(link) = self[axis].links.iter_mut().nth(index) {
                    link.master.read(&at, clock);
                }
                index += 1;
            }
        }
        for kind in GeneratorKind::MASTER_DRIVEN {
            let generator = self[axis].sum.get(kind);
            let Some(master) = generator.and_then(|generator| Some(&generator.follower.as_ref()?.master)) else {
                continue;
            };
            let at = self.master_at(master.axis, master.reference, clock);
            let generator = self[axis].sum.get_mut(kind);
            if let Some(follower) = generator.and_then(|generator| generator.follower.as_mut()) {
                follower.advance(&at, clock);
            }
        }
    }

    fn follow_cams(&mut self, axis: AxisId, clock: &Clock) {
        for kind in Axis::CAMS {
            if let Some(Source::Axis { master, reference }) = self[axis].cam(kind).map(Cam::source) {
                let at = self.master_at(master, reference, clock);
                let slave = &mut self[axis];
                let at = slave.offset_master(kind, at, clock);
                slave.follow_cam(kind, &at, clock);
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

impl Index<AxisId> for Axes {
    type Output = Axis;

    fn index(&self, axis: AxisId) -> &Axis {
        &self.axes[axis.index()]
    }
}

impl IndexMut<AxisId> for Axes {
    /// Wakes the axis.
    fn index_mut(&mut self, axis: AxisId) -> &mut Axis {
        let axis = &mut self.axes[axis.index()];
        axis.dormant = false;
        axis
    }
}

/// A list of different axes, of bounded length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisList<const MOST: usize> {
    axes: [AxisId; MOST],
    count: usize,
}

impl<const MOST: usize> AxisList<MOST> {
    /// Adds an axis that is not in the list; a full list ignores it.
    pub(crate) fn add(&mut self, axis: AxisId) {
        if !self.contains(&axis)
            && let Some(end) = self.axes.get_mut(self.count)
        {
            *end = axis;
            self.count += 1;
        }
    }

    /// The index of an axis in the list.
    pub(crate) fn index_of(&self, axis: AxisId) -> Option<usize> {
        self.iter().position(|own| *own == axis)
    }
}

impl<const MOST: usize> Default for AxisList<MOST> {
    fn default() -> Self {
        AxisList {
            axes: [AxisId::default(); MOST],
            count: 0,
        }
    }
}

impl<const MOST: usize> Deref for AxisList<MOST> {
    type Target = [AxisId];

    fn deref(&self) -> &[AxisId] {
        &self.axes[..self.count]
    }
}

impl<const MOST: usize> Extend<AxisId> for AxisList<MOST> {
    fn extend<I: IntoIterator<Item = AxisId>>(&mut self, axes: I) {
        axes.into_iter().for_each(|axis| self.add(axis));
    }
}

impl<const MOST: usize> FromIterator<AxisId> for AxisList<MOST> {
    fn from_iter<I: IntoIterator<Item = AxisId>>(axes: I) -> Self {
        let mut list = AxisList::default();
        list.extend(axes);
        list
    }
}

/// The two lists have an axis in common.
pub(crate) fn share(some: &[AxisId], others: &[AxisId]) -> bool {
    some.iter().any(|axis| others.contains(axis))
}
