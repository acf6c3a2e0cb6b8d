//! What happens when a robot cannot follow (spec/coordinated-instructions.md §19.8): the MCT shows the error, what leads the
//! joints brakes on its path as long as they can follow, and the transform is over when all stands.
//!
//! It is looked for ahead, over the way that a stop takes: so the joints stay on the path to the end, within their speeds.
//! Real-time: nothing allocates; bounded by the transforms, the coordinate systems and the axes.

use arcline_drive::Motion as Point;
use arcline_instruction_set::{AxisIndex, MotionError};
use arcline_planner::profile::{Jerk, Limits};

use super::Release;
use super::pair::{Link, Side};
use crate::axis::sum::Slot;
use crate::instructions::stop_move;
use crate::machine::MAX_PRIMARY_AXES;
use crate::motion::Motion;
use crate::system::{Activity, System, component};

impl Motion {
    /// Once an update, when commands are known: what robots have moved by themselves becomes part of where their sources
    /// are, those that will not be able to follow begin to brake, those that cannot follow any more are let go of.
    pub(crate) fn look_after_transforms(&mut self) {
        for index in 0..self.links.len() {
            let Some(link) = self.links[index].filter(|link| link.robot().is_some()) else {
                continue;
            };
            if let Some(error) = link.failed {
                self.fail_transform(index, error);
                self.cancel_transform(index, &Release::default());
            } else if link.braking {
                if !self.moves_either_side(&link) {
                    self.cancel_transform(index, &Release::default());
                }
            } else if let Err(error) = self.look_ahead(&link) {
                self.fail_transform(index, error);
            } else {
                self.settle_transform(index);
            }
        }
    }

    /// The instruction shows the error; everything that leads the target, and the target itself, begins to brake.
    fn fail_transform(&mut self, index: usize, error: MotionError) {
        let Some(link) = &mut self.links[index] else {
            return;
        };
        link.braking = true;
        let link = *link;
        if let Some(execution) = self.links[index].as_mut().and_then(|link| link.execution.take()) {
            self.controls.fail(execution, error, self.clock.tick);
        }
        self.brake_what_moves(link.target());
        // From the source up to where the chain of transforms begins.
        let mut above = Some(link);
        for _ in 0..self.links.len() {
            let Some(next) = above else {
                break;
            };
            self.brake_what_moves(next.source());
            above = self.links().map(|(_, other)| *other).find(|other| {
                let leads = |axis: &u16| next.source().contains(axis);
                other.target().iter().any(leads)
            });
        }
    }

    fn brake_what_moves(&mut self, axes: &[u16]) {
        for index in 0..self.systems.len() {
            let system = &self.systems[index];
            if system.activity == Activity::Moving && axes.iter().any(|axis| system.has(*axis)) {
                let limits = self.path_stop(index);
                stop_move(self, index, &limits);
            }
        }
        for axis in axes {
            let state = &self.axes[usize::from(*axis)];
            let limits = state.dynamics.stop(state.is_s_curve());
            for slot in Slot::ALL.into_iter().filter(|slot| slot.is_single_axis()) {
                let runs = |generator: &crate::axis::generator::Generator| !generator.stopping;
                if self.axes[usize::from(*axis)].sum.get(slot).is_some_and(runs) {
                    self.stop_generator(*axis, slot, &limits, None);
                }
            }
        }
    }

    /// A stop on the path at the maxima of the coordinate system.
    fn path_stop(&self, index: usize) -> Limits {
        let system = &self.systems[index];
        let own = &system.description;
        let active = system.planner.active().map(|running| running.motion.data.dynamics);
        let s_curve = match &system.contour {
            Some(contour) => contour.moves().any(|planned| planned.data.dynamics.is_s_curve()),
            None => active.is_some_and(|dynamics| dynamics.is_s_curve()),
        };
        Limits {
            speed: own.max_speed,
            acceleration: own.max_deceleration,
            deceleration: own.max_deceleration,
            jerk: s_curve.then_some(Jerk {
                acceleration: own.max_deceleration_jerk,
                deceleration: own.max_deceleration_jerk,
            }),
        }
    }

    pub(crate) fn moves_either_side(&self, link: &Link) -> bool {
        let mut axes = link.source().iter().chain(link.target());
        axes.any(|axis| self.axes[usize::from(*axis)].in_motion())
    }

    /// Whether the joints could follow a stop that began now, each within its speed.
    ///
    /// # Errors
    /// What they would fail with.
    fn look_ahead(&self, link: &Link) -> Result<(), MotionError> {
        if !link.leads_joints() || !link.leads {
            return Ok(());
        }
        let leads = |(index, system): (usize, &System)| {
            system.activity == Activity::Moving
                && system.planner.active().is_some()
                && self.leads_to(index, link, self.links.len())
        };
        let system = self.systems.iter().enumerate().position(leads);
        for look in 0..=LOOKS {
            let share = f64::from(look) / f64::from(LOOKS);
            let source = match system {
                Some(index) if look > 0 => self.along_path(link, index, share),
                _ => self.straight_on(link, share),
            };
            let joints = link.place(&source)?;
            for (place, (axis, joint)) in link.target().iter().zip(&joints).enumerate() {
                let fastest = self.axes[usize::from(*axis)].dynamics.speed;
                if joint.velocity.abs() > fastest * (1.0 + ROUNDING) {
                    return Err(MotionError::MaxJointVelocityExceeded(AxisIndex(place as u8)));
                }
            }
        }
        Ok(())
    }

    /// The source at a share of the way of a stop on the path of the coordinate system that leads it.
    fn along_path(&self, link: &Link, index: usize, share: f64) -> Side {
        let system = &self.systems[index];
        let [speed, along, length] = system.along;
        let way = stop_way(speed, &self.path_stop(index), self.clock.period());
        let Some(path) = system.planner.active().map(|running| running.motion.path) else {
            return self.straight_on(link, share);
        };
        let (here, there) = (path.at(along), path.at((along + way * share).min(length)));
        let speed = speed * (1.0 - share).max(0.0).sqrt();
        self.when(link, &|axis| {
            let place = system.description.linear().iter().position(|own| *own == axis);
            place.map_or_else(
                || self.alone(axis, share),
                |place| Point {
                    position: component(&there.position, place) - component(&here.position, place),
                    velocity: component(&there.tangent, place) * speed,
                    acceleration: 0.0,
                },
            )
        })
    }

    /// How far from where it is an axis is that moves by itself, at a share of the way of its own stop.
    fn alone(&self, axis: u16, share: f64) -> Point {
        let state = &self.axes[usize::from(axis)];
        let velocity = state.sum.motion_of(|slot| slot != Slot::Transform).velocity;
        if velocity == 0.0 {
            return Point::default();
        }
        let way = stop_way(
            velocity.abs(),
            &state.dynamics.stop(state.is_s_curve()),
            self.clock.period(),
        );
        Point {
            position: way * share * velocity.signum(),
            velocity: velocity * (1.0 - share).max(0.0).sqrt(),
            acceleration: 0.0,
        }
    }

    /// The source at a share of the way of a stop straight on.
    fn straight_on(&self, link: &Link, share: f64) -> Side {
        let mut source = Side::default();
        for (axis, point) in link.source().iter().zip(&mut source) {
            *point = self.axes[usize::from(*axis)].command;
        }
        let linear = link.source().len().min(MAX_PRIMARY_AXES);
        let mut seconds = 0.0_f64;
        for places in [0..linear, linear..link.source().len()] {
            let axes = link.source()[places.clone()]
                .iter()
                .map(|axis| &self.axes[usize::from(*axis)]);
            let squares = source[places].iter().map(|point| point.velocity * point.velocity);
            let speed = squares.sum::<f64>().sqrt();
            let rate = axes
                .clone()
                .map(|axis| axis.dynamics.deceleration)
                .fold(f64::INFINITY, f64::min);
            if let Some(first) = axes.clone().next().filter(|_| speed > 0.0) {
                let mut limits = first.dynamics.stop(false);
                limits.deceleration = rate;
                seconds = seconds.max(stop_way(speed, &limits, self.clock.period()) / speed);
            }
        }
        for point in &mut source {
            point.position += point.velocity * seconds * share;
            point.velocity *= (1.0 - share).max(0.0).sqrt();
        }
        source
    }
}

/// How far a stop goes on that begins an update from now, at most.
fn stop_way(speed: f64, limits: &Limits, period: f64) -> f64 {
    let build_up = limits.jerk.map_or(0.0, |jerk| limits.deceleration / jerk.deceleration);
    speed * (0.5 * (speed / limits.deceleration + build_up) + period)
}

/// Places on the way of a stop that are looked at.
const LOOKS: u8 = 4;
/// A joint this little too fast, as a share, is as fast as it may be.
const ROUNDING: f64 = 1e-9;
