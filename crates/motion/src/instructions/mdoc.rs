//! MDOC, Motion Disarm Output Cam (spec/axis-and-data-types.md §5).

use arcline_instruction_set::enumerations::DisarmType;
use arcline_instruction_set::operands::Mdoc;
use arcline_instruction_set::{Call, MotionError};

use super::maoc;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mdoc {
        execution_target,
        disarm_type,
    } = motion.operands(call)?;
    let targets = match *disarm_type {
        DisarmType::Specific => {
            let target = maoc::target(motion, axis, *execution_target)?;
            target..target + 1
        }
        DisarmType::All => 0..motion.axes[axis].outputs.len(),
    };
    for target in targets {
        motion.axes[axis].disarm_output(target, &mut motion.controls);
    }
    motion.done(execution);
    Ok(())
}
