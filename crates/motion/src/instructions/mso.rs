//! MSO, Motion Servo On (spec/axis-and-data-types.md §2).

use arcline_instruction_set::{AxisIndex, Call, MotionError};

use crate::axis::state::AxisState;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    let state = &mut motion.axes[axis];
    if state.is_virtual || state.feeding.is_some() {
        return Err(MotionError::WrongAxisType(AxisIndex(0)));
    }
    match state.state {
        _ if state.state != AxisState::Shutdown && state.is_faulted() => {
            return Err(MotionError::AxisInFaultedState(AxisIndex(0)));
        }
        AxisState::Aborting | AxisState::Faulted => {}
        AxisState::Shutdown => return Err(MotionError::ShutdownState(AxisIndex(0))),
        AxisState::Running if state.in_motion() => return Err(MotionError::AxisInMotion(AxisIndex(0))),
        AxisState::Running => {
            motion.done(execution);
            return Ok(());
        }
        AxisState::Starting => {}
        AxisState::Stopped | AxisState::Stopping => {
            if state.actual.velocity != 0.0 {
                return Err(MotionError::AxisInMotion(AxisIndex(0)));
            }
            state.enable();
        }
    }
    motion.done_next_update(execution, axis, Some(AxisState::Starting));
    Ok(())
}
