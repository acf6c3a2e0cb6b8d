//! Moves of coordinate systems that end early: cancelled, aborted, or replaced by a move of another coordinate system.
//!
//! Real-time: no allocation; bounded by the axes and the depth of the queues.

use arcline_instruction_set::{AxisId, SystemId};
use arcline_planner::Clock;

use super::{Activity, Systems};
use crate::axes::Axes;
use crate::axis::generator_kind::GeneratorKind;
use crate::control::Controls;
use crate::stop::AxisSet;

impl Systems {
    /// Cancels every pending move of a coordinate system; without an active move it is then at rest.
    pub(crate) fn cancel_pending(&mut self, index: SystemId, controls: &mut Controls) {
        let system = &mut self[index];
        while let Some(cancelled) = system.travel.cancel_waiting() {
            controls.end_move(cancelled.execution, 0);
        }
        if system.activity != Activity::Stopping && system.travel.active().is_none() {
            self.retire_all(index);
            self[index].rest();
        }
    }

    /// Ends all moves of a system and their motion at once; the caller releases the axes.
    pub(crate) fn end_travel(&mut self, index: SystemId, controls: &mut Controls) {
        self.cancel_pending(index, controls);
        self[index].end_active(controls);
        self.retire_all(index);
        self[index].rest();
    }

    /// Ends all coordinated motion of a system at once. Its axes brake separately, except those that stand or are without torque according to
    /// `hold`. Returns the axes that brake.
    pub(crate) fn abort(
        &mut self,
        index: SystemId,
        axes: &mut Axes,
        controls: &mut Controls,
        clock: &Clock,
        hold: impl Fn(AxisId) -> bool,
    ) -> AxisSet {
        let mut braking = AxisSet::default();
        let system = &self[index];
        if !system.is_busy() {
            return braking;
        }
        let s_curve = system.is_s_curve();
        let before = system.travel.limits_in_force(&system.time_base(clock));
        self.end_travel(index, controls);
        for axis in self[index].taken() {
            let Some(state) = axes.get_mut(*axis) else {
                continue;
            };
            if hold(*axis) {
                state.release();
            } else {
                let limits = state.dynamics.stop(s_curve);
                if let Some(part) = state.sum.get_mut(GeneratorKind::System) {
                    part.in_force = before;
                }
                state.brake(GeneratorKind::System, &limits, None, clock.now());
                braking.insert(*axis);
            }
        }
        self[index].braking = braking;
        braking
    }

    /// Ends all coordinated motion of a system at once in favour of another system that uses their common axes; the other axes brake.
    pub(crate) fn abort_but(
        &mut self,
        index: SystemId,
        taker: SystemId,
        axes: &mut Axes,
        controls: &mut Controls,
        clock: &Clock,
    ) {
        let mut taken = AxisSet::default();
        for axis in self[taker].description.linear() {
            taken.insert(*axis);
        }
        self.abort(index, axes, controls, clock, |axis| taken.contains(axis));
    }
}
