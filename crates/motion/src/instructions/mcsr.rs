//! MCSR, Motion Coordinated Shutdown Reset (spec/coordinated-instructions.md §17).

use arcline_instruction_set::{AxisIndex, Call, MotionError};

use super::masr;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    let mut faulted = None;
    for member in 0..motion.systems[index].description.axes.len() {
        if !masr::reset(motion, motion.systems[index].description.axes[member]) {
            faulted = faulted.or(Some(AxisIndex(member as u8)));
        }
    }
    motion.systems[index].shutdown = false;
    if let Some(member) = faulted {
        return Err(MotionError::AxisInFaultedState(member));
    }
    motion.done(execution);
    Ok(())
}
