//! Homing of axes from one tick to the next, and what its instruction shows.
//!
//! Real-time: no allocation; bounded by the legs of a sequence.

use arcline_instruction_set::{AxisIndex, Flag, MotionError};

use super::Motion;
use crate::control::Execution;
use crate::machine::HomeMode;

impl Motion {
    /// Begins homing of an axis. An active sequence ends whatever else moves the axis: coordinated moves of it are
    /// over, their other axes brake by themselves.
    pub(crate) fn begin_homing(&mut self, axis: u16, execution: Execution) {
        let at = usize::from(axis);
        self.end_passive_homing(axis);
        let from = self.axes[at].command;
        let stop = self.axes[at].dynamics.stop(self.axes[at].is_s_curve());
        if self.axes[at].home.mode == HomeMode::Active {
            for index in 0..self.systems.len() {
                if self.systems[index].has(axis) && self.systems[index].is_busy() {
                    self.end_stop(index);
                    self.abort_system(index, |other| other == axis);
                }
            }
            self.end_generators(axis);
        }
        self.axes[at].begin_homing(execution, from, &stop, &self.clock);
        self.controls.write(execution, Flag::Ip.mask(), 0, self.clock.tick);
    }

    /// Ends homing that does not move the axis, without PC.
    pub(crate) fn end_passive_homing(&mut self, axis: u16) {
        if let Some(execution) = self.axes[usize::from(axis)].take_passive_homing() {
            self.end_move(execution, 0);
        }
    }

    /// Homing and redefining the position would break the link of an axis that a transform moves.
    pub(crate) fn not_in_transform(&self, axis: u16) -> Result<(), MotionError> {
        if self.axes[usize::from(axis)].is_transformed() {
            return Err(MotionError::AxisInTransformMotion(AxisIndex(0)));
        }
        Ok(())
    }
}
