//! MGSP, Motion Group Strobe Position (spec/axis-and-data-types.md §4).

use arcline_instruction_set::{Call, MotionError};

use crate::axis::generator_kind::GeneratorKind;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    motion.target_group(call)?;
    motion.verify_operands(call)?;
    for axis in motion.axes.iter_mut() {
        axis.cams_mut(GeneratorKind::PositionCam).offset.strobed = axis.master_offset().position;
        axis.strobed = [axis.command.position, axis.actual.position].map(|position| axis.shown(position));
    }
    motion.done(execution);
    Ok(())
}
