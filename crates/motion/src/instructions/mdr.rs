//! MDR, Motion Disarm Registration (spec/axis-and-data-types.md §5).

use arcline_instruction_set::{Call, Mnemonic, MotionError};

use super::place;
use crate::control::Execution;
use crate::motion::Motion;

/// Place of MDR's operand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    input: usize,
}

impl Layout {
    pub(super) fn new() -> Self {
        Layout {
            input: place(Mnemonic::Mdr, "Input Number"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mdr;
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    let input = call.word(layout.input) as usize - 1;
    let registrations = &mut motion.axes[usize::from(axis)].registrations;
    let Some(registration) = registrations.get_mut(input).filter(|input| input.exists) else {
        return Err(MotionError::InstructionNotSupported);
    };
    if let Some(ended) = registration.disarm() {
        motion.end_move(ended, 0);
    }
    motion.done_next_update(execution, axis, None);
    Ok(())
}
