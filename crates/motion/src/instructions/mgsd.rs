//! MGSD, Motion Group Shutdown (spec/axis-and-data-types.md §4).

use arcline_instruction_set::{Call, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    motion.target_group(call)?;
    motion.verify_operands(call)?;
    for axis in motion.axes.ids() {
        motion.shut_down(axis);
    }
    motion.done_at_next_update(execution);
    Ok(())
}
