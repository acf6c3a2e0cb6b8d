//! MDW, Motion Disarm Watch (spec/axis-and-data-types.md §5).

use arcline_instruction_set::{Call, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    if let Some(ended) = motion.axes[axis].watch.disarm() {
        motion.controls.end_move(ended, 0);
    }
    motion.done_next_update(execution, axis, None);
    Ok(())
}
