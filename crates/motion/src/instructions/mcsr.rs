//! MCSR, Motion Coordinated Shutdown Reset (spec/coordinated-instructions.md §17).

use arcline_instruction_set::{AxisIndex, Call, MotionError};

use super::masr;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    let mut faulted = None;
    for place in 0..motion.systems[index].description.axes.len() {
        if !masr::reset(motion, motion.systems[index].description.axes[place]) {
            faulted = faulted.or(Some(AxisIndex(place as u8)));
        }
    }
    motion.systems[index].shutdown = false;
    if let Some(place) = faulted {
        return Err(MotionError::AxisInFaultedState(place));
    }
    motion.done(execution);
    Ok(())
}
