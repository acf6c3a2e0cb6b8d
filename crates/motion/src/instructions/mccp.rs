//! MCCP, Motion Calculate Cam Profile (spec/axis-and-data-types.md §3.9). It works on tags and is calculated beside the tick.

use arcline_instruction_set::{Call, MotionError};

use crate::call_data::ReceivedData;
use crate::execution::Execution;
use crate::motion::Motion;

pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    motion.verify_operands(call)?;
    data.verdict()?;
    motion.done(execution);
    Ok(())
}
