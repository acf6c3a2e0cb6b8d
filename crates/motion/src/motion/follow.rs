//! Axes that follow others: slaves of gears and cams, master driven motions, and both sides of transforms.
//!
//! A follower is computed after its master, in the same tick, in an order that is worked out when a link or a transform is made.
//! While nothing follows there is no order, and axes are computed one after the other. Real-time: nothing allocates; a
//! tick is bounded by the axes, the coordinate systems and the transforms that are under way.

use super::Motion;
use crate::axis::Axis;
use crate::order::{Circle, Follower, Planned, Step};
use crate::system::System;
use arcline_instruction_set::{AxisId, SystemId};

impl Motion {
    /// Commands of all axes at the present tick, in order.
    pub(crate) fn advance_followers(&mut self) {
        let mut followers = 0;
        for step_index in 0..self.order.len() {
            let Some(step) = self.order.step(step_index) else {
                break;
            };
            match step {
                Step::System(index) => {
                    if self.systems[index].follows() {
                        followers += 1;
                        self.read_masters(index);
                        if self.systems[index].is_busy() {
                            self.advance_system(index);
                        }
                    }
                }
                _ => self.compute(step),
            }
            if let Step::Whole(axis) = step {
                self.axes[axis].advance_homing(&self.clock);
                let state = &self.axes[axis];
                followers += usize::from(state.is_transformed() || masters_of_axis(state).next().is_some());
            }
        }
        if followers == 0 {
            self.order.clear();
        }
    }

    /// Commands alone, once more: something changed within the tick.
    pub(crate) fn refresh_followers(&mut self) {
        for step_index in 0..self.order.len() {
            if let Some(step) = self.order.step(step_index) {
                self.compute(step);
            }
        }
    }

    fn compute(&mut self, step: Step) {
        match step {
            Step::System(index) => {
                if self.systems[index].follows() {
                    self.read_masters(index);
                    if self.systems[index].is_busy() {
                        self.sample_system(index);
                    }
                }
            }
            Step::Own(axis) => {
                self.axes.follow_masters(axis, &self.clock);
                self.axes[axis].advance(&self.clock);
            }
            Step::Transform(part) => self.transforms.compute(part, &mut self.axes, self.clock.period()),
            Step::Whole(axis) => self.transforms.compose(axis, &mut self.axes),
        }
    }

    /// Where the masters of a coordinate system are now, and how far they lead its move.
    fn read_masters(&mut self, index: SystemId) {
        let Motion {
            systems, axes, clock, ..
        } = self;
        let system = &mut systems[index];
        for link in system.links.iter_mut() {
            link.master
                .read(&axes.master_at(link.master.axis, link.master.reference, clock), clock);
        }
        if let Some(follower) = &mut system.follower {
            follower.advance(
                &axes.master_at(follower.master.axis, follower.master.reference, clock),
                clock,
            );
        }
    }

    /// Which side of each transform moves the other one, once the motions that ended in this update are over.
    pub(super) fn show_transforms(&mut self) {
        for step_index in 0..self.order.len() {
            match self.order.step(step_index) {
                Some(Step::Transform(part)) => self.transforms.show(part, &self.axes),
                Some(Step::Whole(axis)) if self.axes[axis].is_transformed() => {
                    self.transforms.show_controlled(axis, &mut self.axes);
                }
                _ => {}
            }
        }
    }

    /// Works out the order with one follower more, to be taken when it begins to follow.
    ///
    /// # Errors
    /// When the axes would follow each other in a circle.
    pub(crate) fn plan_order(&mut self, more: Follower<'_>) -> Result<Planned, Circle> {
        let Motion {
            axes,
            systems,
            transforms,
            order,
            ..
        } = self;
        order.plan(|edges| {
            for (index, system) in systems.ids().zip(systems.iter()) {
                let more = match more {
                    Follower::System(slave, master) if slave == index => Some(master),
                    _ => None,
                };
                edges.system(index, &system.description.axes, masters_of_system(system).chain(more));
            }
            for (slave, axis) in axes.ids().zip(axes.iter()) {
                masters_of_axis(axis).for_each(|master| edges.axis(slave, master));
            }
            if let Follower::Axis(slave, master) = more {
                edges.axis(slave, master);
            }
            edges.transforms(|id| match more {
                Follower::Target(target, transform) if target == id => Some(transform),
                _ => transforms.get(id),
            });
        })
    }
}

pub(super) fn masters_of_axis(axis: &Axis) -> impl Iterator<Item = AxisId> {
    let gear = axis.gear().map(|gear| gear.master.axis);
    let cams = Axis::CAMS.into_iter().filter_map(|slot| axis.cam_master(slot));
    let driven = axis.sum.active().filter_map(|(_, generator)| generator.follower);
    let links = axis.links.iter().map(|link| link.master.axis);
    gear.into_iter()
        .chain(cams)
        .chain(links)
        .chain(driven.map(|follower| follower.master.axis))
}

fn masters_of_system(system: &System) -> impl Iterator<Item = AxisId> {
    let follower = system.follower.map(|follower| follower.master.axis);
    let links = system.links.iter().map(|link| link.master.axis);
    links.chain(follower)
}
