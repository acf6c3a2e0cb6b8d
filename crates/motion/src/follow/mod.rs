//! Axes that follow others: slaves of gears and cams, and both sides of transforms.
//!
//! What follows is computed after what it follows, in the same tick, in an order that is worked out when a link is made.
//! While nothing follows there is no order, and axes are computed one after the other. Real-time: nothing allocates; a
//! tick is bounded by the axes and the transforms that are under way.

pub(crate) mod cam;
mod cancel;
mod failing;
pub(crate) mod gear;
pub(crate) mod order;
pub(crate) mod reach;
pub(crate) mod robot;
pub(crate) mod transform;

use arcline_drive::Motion as Point;

use crate::axis::generator::Law;
use crate::axis::sum::Slot;
use crate::axis::{Axis, AxisState};
use crate::motion::Motion;
use cam::{Cam, Source};
pub(crate) use cancel::Release;
use gear::{MasterAt, Reference};
use order::{Circle, Followers, Masters, Step};
use transform::Link;

impl Motion {
    /// Commands and drives of all axes at the present tick, in order, and what came to its end.
    pub(crate) fn advance_followers(&mut self) {
        let mut followers = 0;
        for place in 0..self.order.len() {
            let Some(step) = self.order.step(place) else {
                break;
            };
            self.compute(step);
            if let Step::Whole(axis) = step {
                self.follow_command(axis);
                let state = &self.axes[usize::from(axis)];
                followers += usize::from(state.is_linked() || masters(state).iter().any(Option::is_some));
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
            Step::Own(axis) => {
                self.follow_master(axis);
                self.axes[usize::from(axis)].advance(&self.clock);
            }
            Step::Down(index) => self.compute_down(usize::from(index)),
            Step::Back(index) => self.compute_back(usize::from(index)),
            Step::Lead(index) => self.compute_lead(usize::from(index)),
            Step::Whole(axis) => self.compose(axis),
        }
    }

    fn follow_master(&mut self, axis: u16) {
        for slot in Axis::CAMS {
            let cam = self.axes[usize::from(axis)].cam(slot);
            if let Some(Source::Axis { master, reference }) = cam.map(Cam::source) {
                let at = self.master_at(master, reference);
                self.axes[usize::from(axis)].follow_cam(slot, &at);
            }
        }
        let Some(gear) = self.axes[usize::from(axis)].gear() else {
            return;
        };
        let at = self.master_at(gear.master, gear.reference);
        if let Some(generator) = self.axes[usize::from(axis)].sum.get_mut(Slot::Gear)
            && let Law::Geared(gear) = &mut generator.law
        {
            generator.now = gear.follow(&at, generator.now.position, &self.clock);
        }
    }

    /// What a gear reads of its master now. A master without torque moves where its drive does.
    pub(crate) fn master_at(&self, master: u16, reference: Reference) -> MasterAt {
        let axis = &self.axes[usize::from(master)];
        let commanded = matches!(axis.state, AxisState::Running | AxisState::Starting);
        let (point, read) = match reference {
            Reference::Command if commanded => (axis.command, Reference::Command),
            _ => (axis.drive.actual(), Reference::Actual),
        };
        MasterAt {
            point: Point {
                position: point.position - axis.redefined,
                ..point
            },
            read,
        }
    }

    /// Works out the order with one master more of an axis.
    ///
    /// # Errors
    /// When the axes would follow each other in a circle.
    pub(crate) fn plan_master(&mut self, slave: u16, master: u16) -> Result<(), Circle> {
        let Motion { axes, links, order, .. } = self;
        order.plan(&Followers {
            axes: axes.len(),
            masters: |axis: u16| {
                let mut masters = masters(&axes[usize::from(axis)]);
                if axis == slave {
                    masters[0] = Some(master);
                }
                masters
            },
            links,
        })
    }

    /// Works out the order with one transform more.
    ///
    /// # Errors
    /// When the axes would follow each other in a circle.
    pub(crate) fn plan_transform(&mut self, target: usize, link: &Link) -> Result<(), Circle> {
        let Motion { axes, links, order, .. } = self;
        let before = links[target].replace(*link);
        let planned = order.plan(&Followers {
            axes: axes.len(),
            masters: |axis: u16| masters(&axes[usize::from(axis)]),
            links,
        });
        links[target] = before;
        planned
    }
}

/// The axes that an axis follows; the first place is free.
fn masters(axis: &Axis) -> Masters {
    [
        None,
        axis.gear().map(|gear| gear.master),
        axis.cam_master(Slot::PositionCam),
        axis.cam_master(Slot::TimeCam),
    ]
}
