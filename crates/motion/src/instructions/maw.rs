//! MAW, Motion Arm Watch (spec/axis-and-data-types.md §5).

use arcline_instruction_set::enumerations::WatchTrigger;
use arcline_instruction_set::operands::Maw;
use arcline_instruction_set::{Call, Flag, MotionError};

use super::camming::on_turn;
use crate::execution::Execution;
use crate::masters::displacement::{Crossing, Sense};
use crate::motion::Motion;
use crate::verify::{self, alone};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Maw {
        trigger_condition,
        position,
    } = motion.operands(call)?;
    let state = &mut motion.axes[axis];
    on_turn(state, &position)?;
    verify::not_shut_down(alone(state))?;
    if state.watch.is_armed() {
        return Err(MotionError::ExecutionCollision);
    }
    let crossing = Crossing {
        position: *position - state.redefined,
        sense: Some(match *trigger_condition {
            WatchTrigger::Forward => Sense::Forward,
            WatchTrigger::Reverse => Sense::Reverse,
        }),
        unwind: state.unwind,
    };
    let now = state.watched_motion();
    state.watch.arm(execution, crossing, *position, now);
    motion.controls.write(execution, Flag::Ip.mask(), 0);
    motion.done_next_update(execution, axis, None);
    Ok(())
}
