//! MGSD, Motion Group Shutdown (spec/axis-and-data-types.md §4).

use arcline_instruction_set::{Call, MotionError};

use super::masd;
use crate::control::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    motion.target_group(call)?;
    motion.verify_operands(call)?;
    for axis in motion.axes.ids() {
        masd::shut_down(motion, axis);
    }
    motion.done_at_next_update(execution);
    Ok(())
}
