//! MCSR, Motion Coordinated Shutdown Reset (spec/coordinated-instructions.md §17).

use arcline_instruction_set::{Call, MotionError};

use super::masr;
use crate::control::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    for place in 0..motion.systems[index].description.axes.len() {
        masr::reset(motion, motion.systems[index].description.axes[place]);
    }
    motion.systems[index].shutdown = false;
    motion.done(execution);
    Ok(())
}
