//! Homing of axes from one tick to the next, and the status bits of MAH.
//!
//! Real-time: no allocation; bounded by the legs of a sequence.

use arcline_instruction_set::{AxisId, Flag};

use super::Motion;
use crate::execution::Execution;
use crate::machine::HomeMode;

impl Motion {
    /// Begins homing of an axis. An active sequence ends all other motion of the axis, including its coordinated moves; the other axes of
    /// those brake separately.
    pub(crate) fn begin_homing(&mut self, axis: AxisId, execution: Execution) {
        self.axes[axis].end_passive_homing(&mut self.controls);
        let from = self.axes[axis].command;
        let stop = self.axes[axis].dynamics.stop(self.axes[axis].is_s_curve());
        if self.axes[axis].home.mode == HomeMode::Active {
            for index in self.systems.ids() {
                if self.systems[index].has(axis) && self.systems[index].is_busy() {
                    self.systems[index].end_stop(&mut self.controls);
                    self.abort_system(index, |other| other == axis);
                }
            }
            self.end_generators(axis);
        }
        self.axes[axis].begin_homing(execution, from, &stop, &self.clock);
        self.controls.write(execution, Flag::Ip.mask(), 0);
    }
}
