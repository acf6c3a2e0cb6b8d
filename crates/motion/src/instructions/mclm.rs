//! MCLM, Motion Coordinated Linear Move (spec/coordinated-instructions.md §12).

use arcline_instruction_set::{Call, MotionError};
use arcline_planner::geometry::Path;

use super::moves::{self, INCREMENTAL};
use super::points::{self, primary, target_point};
use crate::control::Execution;
use crate::motion::Motion;
use crate::range;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mclm;
    moves::execute(motion, execution, call, &layout, 1, |motion, system, start| {
        let incremental = call.word(layout.move_type) == INCREMENTAL;
        let values = primary(system, call, layout.position);
        let mut target = target_point(values, &start, incremental);
        if !incremental {
            points::unwind(motion, system, &start, values, &mut target, layout.position)?;
        }
        range::verify_point(system, &motion.axes, &target, layout.position)?;
        Ok(Path::line(start, target))
    })
}
