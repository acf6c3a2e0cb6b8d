//! Axes that follow others: slaves of gears and cams, what is a function of a master's way, and both sides of transforms.
//!
//! What follows is computed after what it follows, in the same tick, in an order that is worked out when a link is made.
//! While nothing follows there is no order, and axes are computed one after the other. Real-time: nothing allocates; a
//! tick is bounded by the axes, the coordinate systems and the transforms that are under way.

use super::Motion;
use crate::axis::Axis;
use crate::axis::generator::Law;
use crate::axis::sum::Slot;
use crate::masters::cam::{Cam, Source};
use crate::order::{Circle, Follower, Followers, Masters, Step};
use crate::system::System;

impl Motion {
    /// Commands of all axes at the present tick, in order.
    pub(crate) fn advance_followers(&mut self) {
        let mut followers = 0;
        for place in 0..self.order.len() {
            let Some(step) = self.order.step(place) else {
                break;
            };
            match step {
                Step::System(index) => {
                    let index = usize::from(index);
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
                self.axes[usize::from(axis)].advance_homing(&self.clock);
                let state = &self.axes[usize::from(axis)];
                followers += usize::from(state.is_linked() || !masters_of_axis(state).is_empty());
            }
        }
        if followers == 0 {
            self.order.clear();
        }
    }

    /// Commands alone, once more: something changed within the tick.
    pub(crate) fn refresh_followers(&mut self) {
        for place in 0..self.order.len() {
            if let Some(step) = self.order.step(place) {
                self.compute(step);
            }
        }
    }

    fn compute(&mut self, step: Step) {
        match step {
            Step::System(index) => {
                let index = usize::from(index);
                if self.systems[index].follows() {
                    self.read_masters(index);
                    if self.systems[index].is_busy() {
                        self.sample_system(index);
                    }
                }
            }
            Step::Own(axis) => {
                self.follow_guides(axis);
                self.follow_master(axis);
                self.axes[usize::from(axis)].advance(&self.clock);
            }
            Step::Down(index) => self.compute_down(usize::from(index)),
            Step::Back(index) => self.compute_back(usize::from(index)),
            Step::Lead(index) => self.compute_lead(usize::from(index)),
            Step::Whole(axis) => self.compose(axis),
        }
    }

    /// Where the masters of a coordinate system are now, and how far they lead its move.
    fn read_masters(&mut self, index: usize) {
        let mut links = self.systems[index].links;
        for link in links.iter_mut() {
            let at = self
                .axes
                .master_at(link.master.axis, link.master.reference, &self.clock);
            link.master.read(&at, &self.clock);
        }
        self.systems[index].links = links;
        if let Some(mut guide) = self.systems[index].guide {
            guide.advance(
                &self
                    .axes
                    .master_at(guide.master.axis, guide.master.reference, &self.clock),
                &self.clock,
            );
            self.systems[index].guide = Some(guide);
        }
    }

    /// The same for what moves an axis by itself.
    fn follow_guides(&mut self, axis: u16) {
        let at = usize::from(axis);
        if !self.axes[at].links.is_empty() {
            let mut links = self.axes[at].links;
            for link in links.iter_mut() {
                let at = self
                    .axes
                    .master_at(link.master.axis, link.master.reference, &self.clock);
                link.master.read(&at, &self.clock);
            }
            self.axes[at].links = links;
        }
        for slot in Slot::GUIDED {
            let Some(mut guide) = self.axes[at].sum.get(slot).and_then(|generator| generator.guide) else {
                continue;
            };
            guide.advance(
                &self
                    .axes
                    .master_at(guide.master.axis, guide.master.reference, &self.clock),
                &self.clock,
            );
            if let Some(generator) = self.axes[at].sum.get_mut(slot) {
                generator.guide = Some(guide);
            }
        }
    }

    fn follow_master(&mut self, axis: u16) {
        for slot in Axis::CAMS {
            let cam = self.axes[usize::from(axis)].cam(slot);
            if let Some(Source::Axis { master, reference }) = cam.map(Cam::source) {
                let at = self.axes.master_at(master, reference, &self.clock);
                let at = self.axes[usize::from(axis)].offset_master(slot, at, &self.clock);
                self.axes[usize::from(axis)].follow_cam(slot, &at);
            }
        }
        let Some(gear) = self.axes[usize::from(axis)].gear() else {
            return;
        };
        let at = self.axes.master_at(gear.master, gear.reference, &self.clock);
        if let Some(generator) = self.axes[usize::from(axis)].sum.get_mut(Slot::Gear)
            && let Law::Geared(gear) = &mut generator.law
        {
            generator.now = gear.follow(&at, generator.now.position, &self.clock);
        }
    }

    /// Works out the order with one master more of an axis.
    ///
    /// # Errors
    /// When the axes would follow each other in a circle.
    pub(crate) fn plan_master(&mut self, slave: u16, master: u16) -> Result<(), Circle> {
        self.plan_order(Follower::Axis(slave, master))
    }

    /// Works out the order with one follower more, to be taken when it begins to follow.
    ///
    /// # Errors
    /// When the axes would follow each other in a circle.
    pub(crate) fn plan_order(&mut self, more: Follower<'_>) -> Result<(), Circle> {
        let Motion {
            axes,
            systems,
            links,
            order,
            ..
        } = self;
        let before = match more {
            Follower::Target(target, link) => links.get_mut(target).map(|place| (target, place.replace(*link))),
            _ => None,
        };
        let planned = order.plan(&Followers {
            axes: axes.len(),
            masters: |axis: u16| {
                let mut masters = masters_of_axis(&axes[usize::from(axis)]);
                if let Follower::Axis(slave, master) = more
                    && slave == axis
                {
                    masters.add(master);
                }
                masters
            },
            systems: |index: usize| {
                let mut masters = masters_of_system(&systems[index]);
                if let Follower::System(slave, master) = more
                    && slave == index
                {
                    masters.add(master);
                }
                (systems[index].description.axes.as_slice(), masters)
            },
            links,
        });
        if let Some((target, before)) = before {
            links[target] = before;
        }
        planned
    }
}

fn masters_of_axis(axis: &Axis) -> Masters {
    let gear = axis.gear().map(|gear| gear.master);
    let cams = Axis::CAMS.into_iter().filter_map(|slot| axis.cam_master(slot));
    let guided = axis.sum.active().filter_map(|(_, generator)| generator.guide);
    let links = axis.links.iter().map(|link| link.master.axis);
    gear.into_iter()
        .chain(cams)
        .chain(links)
        .chain(guided.map(|guide| guide.master.axis))
        .collect()
}

fn masters_of_system(system: &System) -> Masters {
    let guide = system.guide.map(|guide| guide.master.axis);
    let links = system.links.iter().map(|link| link.master.axis);
    links.chain(guide).collect()
}
