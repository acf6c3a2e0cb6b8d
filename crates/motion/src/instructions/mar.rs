//! MAR, Motion Arm Registration (spec/axis-and-data-types.md §5).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError, OperandIndex};

use super::axis_moves::not_shut_down;
use super::place;
use crate::control::Execution;
use crate::motion::Motion;

/// Places of MAR's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    trigger: usize,
    windowed: usize,
    min: usize,
    max: usize,
    input: usize,
}

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mar, name);
        Layout {
            trigger: place("Trigger Condition"),
            windowed: place("Windowed Registration"),
            min: place("Min Position"),
            max: place("Max Position"),
            input: place("Input Number"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mar;
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    let [min, max] = [layout.min, layout.max].map(|operand| call.number(operand));
    let window = call.is_one(layout.windowed).then_some([min, max]);
    if window.is_some() && min > max {
        return Err(MotionError::ParameterOutOfRange(OperandIndex(layout.min as u8)));
    }
    let state = &mut motion.axes[usize::from(axis)];
    not_shut_down(state)?;
    let input = call.word(layout.input) as usize - 1;
    let Some(registration) = state.registrations.get_mut(input).filter(|input| input.exists) else {
        return Err(MotionError::InstructionNotSupported);
    };
    if registration.is_armed() {
        return Err(MotionError::RegistrationInProgress);
    }
    registration.arm(execution, !call.is_one(layout.trigger), window);
    motion.controls.write(execution, Flag::Ip.mask(), 0, motion.clock.tick);
    motion.done_next_update(execution, axis, None);
    Ok(())
}
