//! Homing of axes from one tick to the next, and what its instruction shows.
//!
//! Real-time: no allocation; bounded by the legs of a sequence.

use arcline_instruction_set::{AxisId, AxisIndex, Flag, MotionError};

use super::Motion;
use crate::execution::Execution;
use crate::machine::HomeMode;

impl Motion {
    /// Begins homing of an axis. An active sequence ends whatever else moves the axis: coordinated moves of it are
    /// over, their other axes brake by themselves.
    pub(crate) fn begin_homing(&mut self, axis: AxisId, execution: Execution) {
        self.end_passive_homing(axis);
        let from = self.axes[axis].command;
        let stop = self.axes[axis].dynamics.stop(self.axes[axis].is_s_curve());
        if self.axes[axis].home.mode == HomeMode::Active {
            for index in self.systems.ids() {
                if self.systems[index].has(axis) && self.systems[index].is_busy() {
                    self.end_stop(index);
                    self.abort_system(index, |other| other == axis);
                }
            }
            self.end_generators(axis);
        }
        self.axes[axis].begin_homing(execution, from, &stop, &self.clock);
        self.controls.write(execution, Flag::Ip.mask(), 0, self.clock.tick);
    }

    /// Ends homing that does not move the axis, without PC.
    pub(crate) fn end_passive_homing(&mut self, axis: AxisId) {
        if let Some(execution) = self.axes[axis].take_passive_homing() {
            self.end_move(execution, 0);
        }
    }

    /// Homing and redefining the position would break the link of an axis that a transform moves.
    pub(crate) fn not_in_transform(&self, axis: AxisId) -> Result<(), MotionError> {
        if self.axes[axis].is_transformed() {
            return Err(MotionError::AxisInTransformMotion(AxisIndex(0)));
        }
        Ok(())
    }
}
