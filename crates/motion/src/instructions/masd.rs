//! MASD, Motion Axis Shutdown (spec/axis-and-data-types.md §2).

use arcline_instruction_set::{AxisId, Call, MotionError};

use crate::axis::AxisState;
use crate::control::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    shut_down(motion, axis);
    motion.done_next_update(execution, axis, None);
    Ok(())
}

/// Ends every motion of an axis at once and opens its loop. Motion of other axes that depended on it brakes.
pub(crate) fn shut_down(motion: &mut Motion, axis: AxisId) {
    motion.leave(axis);
    motion.disarm(axis);
    motion.unlink_slave(axis);
    motion.unlink_master(axis);
    motion.axes[axis].disable(AxisState::Shutdown);
}
