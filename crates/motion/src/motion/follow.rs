//! Axes that follow others: slaves of gears and cams, master driven motions, and both sides of transforms.
//!
//! A follower is computed after its master, in the same tick, in an order that is determined when a link or a transform is made.
//! Without followers there is no order, and the tick computes the axes one after the other. Real-time: nothing allocates; a tick is
//! bounded by the axes, the coordinate systems and the active transforms.

use super::Motion;
use crate::order::{DependencyCycle, Follower, PlannedOrder, Step};

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
                        self.systems[index].read_masters(&self.axes, &self.clock);
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
                followers += usize::from(state.is_transformed() || state.masters().next().is_some());
            }
        }
        if followers == 0 {
            self.order.clear();
        }
    }

    /// Calculates the commands of followers again after a change within the tick.
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
                    self.systems[index].read_masters(&self.axes, &self.clock);
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

    /// Updates the side of each transform that moves the other one, after the motions that ended in this update.
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

    /// Plans the order with one more follower; the order takes effect when it begins to follow.
    ///
    /// # Errors
    /// If the axes would follow each other in a cycle.
    pub(crate) fn plan_order(&mut self, more: Follower<'_>) -> Result<PlannedOrder, DependencyCycle> {
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
                edges.system(index, &system.description.axes, system.masters().chain(more));
            }
            for (slave, axis) in axes.ids().zip(axes.iter()) {
                axis.masters().for_each(|master| edges.axis(slave, master));
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
