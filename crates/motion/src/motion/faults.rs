//! The effect of faults of axes on motion: checked once an update, on actual positions (spec/axis-and-data-types.md §9.3, §12).
//!
//! Real-time: no allocation; bounded by the axes, the coordinate systems and the depth of their queues.

use arcline_instruction_set::{AxisId, ExceptionAction, FaultSet};

use super::Motion;
use crate::axis::state::AxisState;
use crate::cause::Cause;

impl Motion {
    /// Injects causes of faults into an axis, which the next update finds, in place of those injected before. Causes that the axis cannot
    /// have, and an axis that does not exist, change nothing. Real-time.
    pub fn inject(&mut self, axis: AxisId, causes: FaultSet) {
        if let Some(axis) = self.axes.get_mut(axis) {
            axis.faults.inject(causes);
        }
    }

    /// Checks every axis and executes the actions of its faults.
    pub(super) fn check_faults(&mut self) {
        let period = self.clock.period();
        for index in self.axes.ids() {
            if self.axes[index].dormant {
                continue;
            }
            let axis = &mut self.axes[index];
            let mut observed = axis.observed();
            observed.lost = axis
                .feeding
                .as_mut()
                .is_some_and(|feeding| feeding.is_stale(&self.clock));
            if let Some(action) = axis.faults.check(&observed, period) {
                let faults = axis.faults.raised();
                let axis = index;
                self.controls.because(Cause::Fault { axis, faults });
                self.act(axis, action);
                self.controls.because(Cause::Itself);
            }
            if self.axes[index].state != AxisState::Aborting {
                continue;
            }
            if self.axes[index].has_gone_off() {
                // Without torque nothing brakes the axis.
                self.end_generators(index);
            }
            let axis = &mut self.axes[index];
            if axis.state == AxisState::Aborting && !axis.in_motion() {
                let next = if axis.faults.block() {
                    AxisState::Faulted
                } else {
                    AxisState::Stopped
                };
                axis.disable(next);
            }
        }
    }

    fn act(&mut self, axis: AxisId, action: ExceptionAction) {
        match action {
            ExceptionAction::Ignore | ExceptionAction::Alarm | ExceptionAction::FaultStatusOnly => {}
            ExceptionAction::StopPlanner => self.stop_planner(axis),
            ExceptionAction::StopDrive if self.axes[axis].is_virtual => self.stop_planner(axis),
            ExceptionAction::StopDrive => match self.axes[axis].state {
                AxisState::Running | AxisState::Starting => {
                    self.stop_planner(axis);
                    self.axes[axis].state = AxisState::Aborting;
                }
                AxisState::Stopped | AxisState::Stopping => {
                    self.unlink_slave(axis);
                    self.axes[axis].state = AxisState::Faulted;
                }
                AxisState::Aborting | AxisState::Faulted | AxisState::Shutdown => {}
            },
            ExceptionAction::Shutdown => self.shut_down(axis),
        }
    }

    /// Ends all motion of an axis at once and opens its loop. Motion of other axes that depended on it brakes.
    pub(crate) fn shut_down(&mut self, axis: AxisId) {
        self.end_all_motion_of(axis);
        self.axes[axis].disarm(&mut self.controls);
        self.unlink_slave(axis);
        self.unlink_master(axis);
        self.axes[axis].disable(AxisState::Shutdown);
    }

    /// Ends all motion of the axis by one deceleration; the axes that moved with it brake separately.
    fn stop_planner(&mut self, axis: AxisId) {
        for index in self.systems.ids() {
            if self.systems[index].has(axis) {
                self.systems[index].end_stop(&mut self.controls);
                self.abort_system(index, |_| false);
            }
        }
        self.unlink_slave(axis);
        if self.axes[axis].dynamics.deceleration > 0.0 {
            self.stop_axis(axis, None);
        } else {
            // No motion can begin on an axis with a Maximum Deceleration of 0, so none needs a stop.
            self.end_generators(axis);
        }
    }
}
