//! MRP, Motion Redefine Position (spec/axis-and-data-types.md §3.7). Nothing moves: command and actual position, and
//! what runs, are shifted by one offset.

use arcline_instruction_set::{Call, Mnemonic, MotionError, OperandIndex};

use super::axis_moves::{not_homing, not_shut_down};
use super::place;
use crate::control::Execution;
use crate::motion::Motion;
use crate::range;

/// Places of MRP's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    redefine_type: usize,
    position_select: usize,
    position: usize,
}

/// Type: the position is an offset.
const RELATIVE: i32 = 1;
/// Position Select: the command position.
const COMMAND: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mrp, name);
        Layout {
            redefine_type: place("Type"),
            position_select: place("Position Select"),
            position: place("Position"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mrp;
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    let state = &motion.axes[usize::from(axis)];
    let position = call.number(layout.position);
    let relative = call.word(layout.redefine_type) == RELATIVE;
    if !relative && state.unwind.is_some_and(|turn| !(0.0..turn).contains(&position)) {
        return Err(MotionError::ParameterOutOfRange(OperandIndex(layout.position as u8)));
    }
    not_shut_down(state)?;
    not_homing(state)?;
    if state.homing().is_some() || motion.is_redefining(axis) {
        return Err(MotionError::RedefinePositionInProcess);
    }
    motion.not_in_transform(axis)?;
    let state = &mut motion.axes[usize::from(axis)];
    let (command, actual) = (state.command.position, state.actual.position);
    let offset = match (relative, call.word(layout.position_select) == COMMAND) {
        (true, _) => position,
        (false, true) => position - command,
        (false, false) => position - actual,
    };
    for redefined in [command + offset, actual + offset] {
        range::verify(state, redefined, layout.position)?;
    }
    if relative {
        state.redefine(position);
    } else if call.word(layout.position_select) == COMMAND {
        state.redefine_command(position);
    } else {
        state.redefine_actual(position);
    }
    motion.done_next_update(execution, axis, None);
    Ok(())
}
