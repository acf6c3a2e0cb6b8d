//! MRP, Motion Redefine Position (spec/axis-and-data-types.md §3.7). No axis moves: one offset shifts command and actual position, and the
//! motion under way.

use arcline_instruction_set::enumerations::{RedefineType, Reference};
use arcline_instruction_set::operands::Mrp;
use arcline_instruction_set::{Call, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;
use crate::range;
use crate::verify::{self, alone};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mrp {
        redefine_type,
        position_select,
        position,
    } = motion.operands(call)?;
    let state = &motion.axes[axis];
    if *redefine_type == RedefineType::Absolute && state.unwind.is_some_and(|turn| !(0.0..turn).contains(&*position)) {
        return Err(position.out_of_range());
    }
    verify::not_shut_down(alone(state))?;
    verify::not_homing(alone(state))?;
    if state.homing().is_some() || motion.is_redefining(axis) {
        return Err(MotionError::RedefinePositionInProcess);
    }
    motion.axes[axis].not_in_transform()?;
    let state = &mut motion.axes[axis];
    let (command, actual) = (state.command.position, state.actual.position);
    let offset = match (*redefine_type, *position_select) {
        (RedefineType::Relative, _) => *position,
        (RedefineType::Absolute, Reference::Command) => *position - command,
        (RedefineType::Absolute, Reference::Actual) => *position - actual,
    };
    for redefined in [command + offset, actual + offset] {
        range::verify(state, redefined, position.index)?;
    }
    match (*redefine_type, *position_select) {
        (RedefineType::Relative, _) => state.redefine(*position),
        (RedefineType::Absolute, Reference::Command) => state.redefine_command(*position),
        (RedefineType::Absolute, Reference::Actual) => state.redefine_actual(*position),
    }
    motion.done_next_update(execution, axis, None);
    Ok(())
}
