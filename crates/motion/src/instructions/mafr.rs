//! MAFR, Motion Axis Fault Reset (spec/axis-and-data-types.md §2). A cause that is still present faults the axis again at the next
//! update.

use arcline_instruction_set::{Call, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    motion.axes[axis].reset_faults(motion.controls.cause());
    motion.done_next_update(execution, axis, None);
    Ok(())
}
