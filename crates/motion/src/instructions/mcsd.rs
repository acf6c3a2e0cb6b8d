//! MCSD, Motion Coordinated Shutdown (spec/coordinated-instructions.md §16).

use arcline_instruction_set::{Call, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    for member in 0..motion.systems[index].description.axes.len() {
        motion.shut_down(motion.systems[index].description.axes[member]);
    }
    motion.systems[index].shutdown = true;
    motion.done(execution);
    Ok(())
}
