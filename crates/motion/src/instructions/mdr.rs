//! MDR, Motion Disarm Registration (spec/axis-and-data-types.md §5).

use arcline_instruction_set::operands::Mdr;
use arcline_instruction_set::{Call, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mdr { input_number } = motion.operands(call)?;
    let input = *input_number as usize - 1;
    let registrations = &mut motion.axes[axis].registrations;
    let Some(registration) = registrations.get_mut(input).filter(|input| input.exists) else {
        return Err(MotionError::InstructionNotSupported);
    };
    if let Some(ended) = registration.disarm() {
        motion.controls.end_move(ended, 0);
    }
    motion.done_next_update(execution, axis, None);
    Ok(())
}
