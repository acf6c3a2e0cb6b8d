//! MAR, Motion Arm Registration (spec/axis-and-data-types.md §5).

use arcline_drive::Trigger;
use arcline_instruction_set::enumerations::{RegistrationTrigger, Windowed};
use arcline_instruction_set::operands::Mar;
use arcline_instruction_set::{Call, Flag, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;
use crate::verify::{self, alone};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mar {
        trigger_condition,
        windowed_registration,
        min_position,
        max_position,
        input_number,
    } = motion.operands(call)?;
    let window = match *windowed_registration {
        Windowed::Disabled => None,
        Windowed::Enabled if *min_position > *max_position => return Err(min_position.out_of_range()),
        Windowed::Enabled => Some([*min_position, *max_position]),
    };
    let state = &mut motion.axes[axis];
    verify::not_shut_down(alone(state))?;
    let input = *input_number as usize - 1;
    let Some(registration) = state.registrations.get_mut(input).filter(|input| input.exists) else {
        return Err(MotionError::InstructionNotSupported);
    };
    if registration.is_armed() {
        return Err(MotionError::RegistrationInProgress);
    }
    let trigger = match *trigger_condition {
        RegistrationTrigger::PositiveEdge => Trigger::RegistrationOn,
        RegistrationTrigger::NegativeEdge => Trigger::RegistrationOff,
    };
    registration.arm(execution, state.link.arm(trigger, false), window);
    motion.controls.write(execution, Flag::Ip.mask(), 0);
    motion.done_next_update(execution, axis, None);
    Ok(())
}
