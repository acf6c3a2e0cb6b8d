//! MSF, Motion Servo Off (spec/axis-and-data-types.md §2). A moving axis coasts; the coordinated motion that it takes part in ends, and
//! the other axes of that motion brake separately.

use arcline_instruction_set::{AxisIndex, Call, MotionError};

use crate::axis::state::AxisState;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    let state = &motion.axes[axis];
    if state.is_virtual || state.feeding.is_some() {
        return Err(MotionError::WrongAxisType(AxisIndex(0)));
    }
    if matches!(state.state, AxisState::Running | AxisState::Starting) {
        motion.end_all_motion_of(axis);
        motion.axes[axis].disable(AxisState::Stopping);
        motion.done_next_update(execution, axis, Some(AxisState::Stopping));
    } else {
        motion.done_next_update(execution, axis, None);
    }
    Ok(())
}
