//! MGSR, Motion Group Shutdown Reset (spec/axis-and-data-types.md §4).

use arcline_instruction_set::{Call, MotionError};

use super::masr;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    motion.target_group(call)?;
    motion.verify_operands(call)?;
    let mut all = true;
    for axis in motion.axes.ids() {
        all &= masr::reset(motion, axis);
    }
    for system in motion.systems.iter_mut() {
        system.shutdown = false;
    }
    if !all {
        return Err(MotionError::PartialGroupShutdownReset);
    }
    motion.done_at_next_update(execution);
    Ok(())
}
