//! MASR, Motion Axis Shutdown Reset (spec/axis-and-data-types.md §2).

use arcline_instruction_set::{AxisId, Call, MotionError};

use crate::axis::state::AxisState;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    reset(motion, axis);
    motion.done_next_update(execution, axis, None);
    Ok(())
}

/// Clears faults and leaves shutdown for Ready: a servo stays off, a virtual axis is ready at once. Returns true if no cause of a fault is
/// left.
pub(super) fn reset(motion: &mut Motion, axis: AxisId) -> bool {
    let gone = motion.axes[axis].reset_faults(motion.controls.cause());
    let axis = &mut motion.axes[axis];
    if axis.state == AxisState::Shutdown {
        axis.state = if axis.is_virtual {
            AxisState::Running
        } else {
            AxisState::Stopped
        };
    }
    gone
}
