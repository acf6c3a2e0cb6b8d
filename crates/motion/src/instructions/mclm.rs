//! MCLM, Motion Coordinated Linear Move (spec/coordinated-instructions.md §12).

use arcline_instruction_set::enumerations::MoveType;
use arcline_instruction_set::operands::{Mclm, Operands};
use arcline_instruction_set::{Call, MotionError};
use arcline_planner::geometry::Path;

use super::moves::{self, MoveOperands};
use super::points::{self, primary, target_point};
use super::programmed::Programmed;
use crate::execution::Execution;
use crate::motion::Motion;
use crate::range;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let Mclm {
        move_type,
        position,
        dynamics,
        termination_type,
        merge,
        merge_speed,
        command_tolerance,
        lock,
        events,
    } = Mclm::of(call);
    let operands = MoveOperands {
        programmed: Programmed::new(dynamics, lock),
        termination_type: *termination_type,
        merge: *merge,
        merge_speed: *merge_speed,
        command_tolerance: *command_tolerance,
        events,
    };
    moves::execute(motion, execution, call, &operands, |motion, system, start| {
        let values = primary(system, &position);
        let mut target = target_point(values, &start, *move_type);
        if *move_type == MoveType::Absolute {
            points::unwind(motion, system, &start, values, &mut target, position.index)?;
        }
        range::verify_point(system, &motion.axes, &target, position.index)?;
        Ok(Path::line(start, target))
    })
}
