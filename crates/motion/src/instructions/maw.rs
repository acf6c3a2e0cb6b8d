//! MAW, Motion Arm Watch (spec/axis-and-data-types.md §5).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError};

use super::axis_moves::not_shut_down;
use super::camming::on_turn;
use super::place;
use crate::control::Execution;
use crate::masters::cam::Lock;
use crate::motion::Motion;

/// Places of MAW's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    trigger: usize,
    position: usize,
}

impl Layout {
    pub(super) fn new() -> Self {
        Layout {
            trigger: place(Mnemonic::Maw, "Trigger Condition"),
            position: place(Mnemonic::Maw, "Position"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.maw;
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    let position = call.number(layout.position);
    let state = &mut motion.axes[usize::from(axis)];
    on_turn(state, position, layout.position)?;
    not_shut_down(state)?;
    if state.watch.is_armed() {
        return Err(MotionError::ExecutionCollision);
    }
    let lock = Lock {
        position: position - state.redefined,
        way: Some(if call.is_one(layout.trigger) { -1.0 } else { 1.0 }),
        unwind: state.unwind,
    };
    let now = state.actual.position - state.redefined;
    state.watch.arm(execution, lock, position, now);
    motion.controls.write(execution, Flag::Ip.mask(), 0, motion.clock.tick);
    motion.done_next_update(execution, axis, None);
    Ok(())
}
