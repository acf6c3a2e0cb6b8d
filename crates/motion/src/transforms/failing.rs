//! What happens when a robot cannot follow (spec/coordinated-instructions.md §19.8): the MCT shows the error, what leads the
//! joints brakes on its path as long as they can follow, and the transform is over when all stands.
//!
//! It is looked for ahead, over the way that a stop takes ([`super::guard`]): so the joints stay on the path to the end, within
//! their speeds.
//! Real-time: nothing allocates; bounded by the transforms, the coordinate systems and the axes.

use arcline_instruction_set::MotionError;

use super::cancel::Release;
use super::transform::Link;
use crate::axes::share;
use crate::axis::sum::Slot;
use crate::cause::Cause;
use crate::motion::Motion;

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
                } else if let Err(error) = self.guard(index, &link) {
                    // What has begun since brakes too.
                    self.fail_transform(index, error);
                }
            } else {
                match self.guard(index, &link) {
                    Err(error) => self.fail_transform(index, error),
                    Ok(()) => self.settle_transform(index),
                }
            }
        }
        self.join_beside();
    }

    fn guard(&mut self, index: usize, link: &Link) -> Result<(), MotionError> {
        let mut ahead = std::mem::take(&mut self.ahead);
        let verdict = self.look_ahead(index, link, &mut ahead);
        self.ahead = ahead;
        verdict
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
            self.controls.because(execution.into());
        }
        self.brake_what_moves(link.target());
        // From the source up to where the chain of transforms begins.
        let mut above = Some(link);
        for _ in 0..self.links.len() {
            let Some(next) = above else {
                break;
            };
            self.brake_what_moves(next.source());
            // Other targets of it lead it too.
            for other in 0..self.links.len() {
                if let Some(other) = self.links[other].filter(|other| share(other.source(), next.source())) {
                    self.brake_what_moves(other.target());
                }
            }
            above = self.above_of(&next).copied();
        }
        self.controls.because(Cause::Itself);
    }

    /// What brakes already brakes at the guard's rates, if that is sooner at rest.
    fn brake_what_moves(&mut self, axes: &[u16]) {
        for index in 0..self.systems.len() {
            let system = &self.systems[index];
            if system.is_busy() && axes.iter().any(|axis| system.taken().contains(axis)) {
                let limits = self.path_stop(index);
                self.cancel_pending(index);
                self.end_active(index);
                self.stop_on_path_at_once(index, &limits);
            }
        }
        for axis in axes {
            let limits = self.axes[usize::from(*axis)].guarded_stop();
            for slot in Slot::ALL.into_iter().filter(|slot| slot.is_single_axis()) {
                self.stop_generator_soonest(*axis, slot, &limits);
            }
        }
    }

    pub(crate) fn moves_either_side(&self, link: &Link) -> bool {
        let mut axes = link.source().iter().chain(link.target());
        axes.any(|axis| self.axes[usize::from(*axis)].in_motion())
    }
}
