//! Transforms from one tick to the next, and the reaction to a robot that cannot follow (spec/coordinated-instructions.md §19.8): the MCT
//! shows the error, the motion that moves the joints brakes on its path while they can follow, and the transform ends when all axes stand.
//!
//! The check looks ahead over the path of a stop (`crate::transforms`), so the joints stay on the path to the end, within their speeds.
//! Real-time: nothing allocates; bounded by the transforms, the coordinate systems and the axes.

use arcline_instruction_set::{AxisId, MotionError};

use super::Motion;
use crate::axes::share;
use crate::axis::generator_kind::GeneratorKind;
use crate::cause::Cause;
use crate::stop::AxisSet;
use crate::transforms::TransformId;
use crate::transforms::cancel::Release;
use crate::transforms::guard::Verdict;
use crate::transforms::present::Present;

impl Motion {
    /// The present state of axes, coordinate systems and transforms, for the look ahead.
    pub(crate) fn present(&self) -> Present<'_> {
        Present {
            axes: &self.axes,
            systems: &self.systems,
            transforms: &self.transforms,
            clock: &self.clock,
        }
    }

    /// Checks transforms once an update, after the commands: adds the robots' own displacements to the positions of their sources, brakes the
    /// transforms whose robots will be unable to follow, and ends those whose robots are unable to follow now.
    pub(super) fn check_transforms(&mut self) {
        for id in self.transforms.ids() {
            let present = Present {
                axes: &self.axes,
                systems: &self.systems,
                transforms: &self.transforms,
                clock: &self.clock,
            };
            match present.verdict(id, &mut self.ahead) {
                Verdict::GoesOn => {}
                Verdict::Settles => self.transforms.settle(id, &mut self.axes),
                Verdict::Brakes(error) => self.fail_transform(id, error),
                Verdict::Fails(error) => {
                    self.fail_transform(id, error);
                    self.cancel_transform(id, &Release::default());
                }
                Verdict::Ends => {
                    self.cancel_transform(id, &Release::default());
                }
            }
        }
        self.transforms.merge_cancelled_feedback(&self.axes);
    }

    /// Cancels every transform that an axis is part of; the axes that the transforms moved brake at the maxima of their coordinate systems.
    pub(crate) fn cancel_transforms_of(&mut self, axis: AxisId) {
        if !self.axes[axis].is_transformed() {
            return;
        }
        for id in self.transforms.ids() {
            if self.transforms.get(id).is_some_and(|transform| transform.has(axis)) {
                self.cancel_transform(id, &Release::default());
            }
        }
    }

    /// Cancels a transform. Returns the axes that brake.
    pub(crate) fn cancel_transform(&mut self, id: TransformId, release: &Release) -> AxisSet {
        let now = self.clock.now();
        let Motion {
            transforms,
            axes,
            systems,
            ..
        } = self;
        let Some(cancelled) = transforms.cancel(id, release, axes, systems, now) else {
            return AxisSet::default();
        };
        if let Some(execution) = cancelled.execution {
            self.controls.end_move(execution, 0);
        }
        cancelled.braking
    }

    /// Fails the instruction of a transform; all motion that moves the target, and the target itself, begins to brake.
    fn fail_transform(&mut self, id: TransformId, error: MotionError) {
        if let Some(execution) = self.transforms.begin_braking(id) {
            self.controls.fail(execution, error);
            self.controls.because(execution.into());
        }
        if let Some(target) = self.transforms.get(id).map(|transform| transform.target) {
            self.brake_all_motion_of(&target);
        }
        // From the source to the beginning of the chain of transforms.
        let mut next = Some(id);
        for _ in 0..self.transforms.most() {
            let Some(transform) = next.and_then(|id| self.transforms.get(id)) else {
                break;
            };
            let source = transform.source;
            next = self.transforms.preceding(transform).map(|(id, _)| id);
            self.brake_all_motion_of(&source);
            // The source can move further targets, whose motion moves it by feedback.
            for other in self.transforms.ids() {
                let other = self.transforms.get(other).filter(|other| share(&other.source, &source));
                if let Some(target) = other.map(|other| other.target) {
                    self.brake_all_motion_of(&target);
                }
            }
        }
        self.controls.because(Cause::Itself);
    }

    /// Brakes all motion of some axes; motion that brakes already changes to the guard's rates if these bring it to rest sooner.
    fn brake_all_motion_of(&mut self, axes: &[AxisId]) {
        for index in self.systems.ids() {
            let system = &self.systems[index];
            if system.is_busy() && share(axes, system.taken()) {
                let limits = system.guarded_stop();
                self.systems.cancel_pending(index, &mut self.controls);
                self.systems[index].end_active(&mut self.controls);
                self.systems[index].stop_on_path_at_once(&limits, &self.clock);
            }
        }
        for axis in axes {
            let limits = self.axes[*axis].guarded_stop();
            for kind in GeneratorKind::ALL.into_iter().filter(|kind| kind.is_single_axis()) {
                self.axes[*axis].stop_generator_soonest(kind, &limits, &mut self.controls, &self.clock);
            }
        }
    }
}
