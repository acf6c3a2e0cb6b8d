//! MASD, Motion Axis Shutdown (spec/axis-and-data-types.md §2).

use arcline_instruction_set::{Call, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    motion.shut_down(axis);
    motion.done_next_update(execution, axis, None);
    Ok(())
}
