//! MAFR, Motion Axis Fault Reset (spec/axis-and-data-types.md §2). No fault can occur yet, so there is none
//! to clear; the request is answered all the same.

use arcline_instruction_set::{Call, MotionError};

use crate::control::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    motion.done_next_update(execution, axis, None);
    Ok(())
}
