//! Motion of single axes from one tick to the next, and its end together with the transforms that an axis is part of.
//!
//! Not here: operations on one axis alone (`crate::axis`). Real-time: no allocation; bounded by the axes.

use arcline_instruction_set::{AxisId, Flag, SystemId};
use arcline_planner::profile::Limits;

use super::Motion;
use crate::axis::Axis;
use crate::execution::Execution;
use crate::stop::AxisSet;

impl Motion {
    /// Commands of all axes at the present tick.
    pub(super) fn advance_axes(&mut self) {
        if !self.order.is_empty() {
            self.advance_followers();
            return;
        }
        for axis in self.axes.awake_mut() {
            axis.advance(&self.clock);
            axis.advance_homing(&self.clock);
        }
    }

    /// Updates the commands for motion that instructions began at this tick. `changed`: coordinated motion began or changed.
    pub(super) fn refresh_axes(&mut self, mut changed: bool) {
        for index in self.axes.ids() {
            if self.axes[index].stale {
                self.axes[index].stale = false;
                changed = true;
                self.axes[index].advance(&self.clock);
                self.axes[index].report(&mut self.controls, &self.clock);
            }
        }
        if changed && !self.order.is_empty() {
            self.refresh_followers();
        }
    }

    /// Ends all generators of an axis without PC, and the transforms that it is part of.
    pub(crate) fn end_generators(&mut self, axis: AxisId) {
        self.cancel_transforms_of(axis);
        self.axes[axis].end_generators(&mut self.controls);
    }

    /// Stops all motion of an axis by one deceleration at the axis's own maxima; `execution` completes when the axis stands. Coordinated motion
    /// must have been ended; transforms that the axis is part of are cancelled.
    pub(crate) fn stop_axis(&mut self, axis: AxisId, execution: Option<Execution>) {
        let state = &self.axes[axis];
        let limits = state.dynamics.stop(state.is_s_curve());
        self.stop_axis_at(axis, &limits, execution);
    }

    /// As [`Motion::stop_axis`], at given rates.
    pub(crate) fn stop_axis_at(&mut self, axis: AxisId, limits: &Limits, execution: Option<Execution>) {
        self.axes[axis].end_passive_homing(&mut self.controls);
        self.axes[axis].end_pending_cams(None, &mut self.controls);
        self.cancel_transforms_of(axis);
        if !self.axes[axis].in_motion() {
            // The only motion to stop was a transform that did not move this axis.
            if let Some(execution) = execution {
                self.controls.end_move(execution, Flag::Pc.mask());
            }
            return;
        }
        self.axes[axis].stop_all(limits, execution, &mut self.controls, &self.clock);
    }

    /// Ends the group's stop when every axis that it stopped is at rest.
    pub(super) fn finish_group_stop(&mut self) {
        let Some(stop) = self.group_stop else { return };
        let moves = |axis: &Axis| axis.is_stopping() || axis.actual.velocity != 0.0 && !axis.has_torque();
        let mut axes = self.axes.ids().zip(self.axes.iter());
        if !axes.any(|(index, axis)| stop.braking.contains(index) && moves(axis)) {
            self.group_stop = None;
            self.controls.end_move(stop.execution, Flag::Pc.mask());
        }
    }

    /// Removes an axis from all motion: the systems that move it are aborted, and their other axes brake.
    pub(crate) fn end_all_motion_of(&mut self, axis: AxisId) {
        for index in self.systems.ids() {
            if self.systems[index].has(axis) {
                self.systems[index].end_stop(&mut self.controls);
                self.abort_system(index, |other| other == axis);
            }
        }
        self.end_generators(axis);
        self.axes[axis].end_passive_homing(&mut self.controls);
    }

    /// Ends all coordinated motion of a system at once; its axes brake separately, except those that stand or are without torque according to
    /// `hold`. Returns the axes that brake.
    pub(crate) fn abort_system(&mut self, index: SystemId, hold: impl Fn(AxisId) -> bool) -> AxisSet {
        let Motion {
            systems,
            axes,
            controls,
            clock,
            ..
        } = self;
        systems.abort(index, axes, controls, clock, hold)
    }
}
