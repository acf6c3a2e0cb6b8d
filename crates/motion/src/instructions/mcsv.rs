//! MCSV, Motion Calculate Slave Values (spec/axis-and-data-types.md §3.9). It works on tags and is worked out beside the tick.

use arcline_instruction_set::{Call, MotionError};

use crate::control::Execution;
use crate::material::Sent;
use crate::motion::Motion;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call, sent: &Sent) -> Result<(), MotionError> {
    motion.verify_operands(call)?;
    sent.verdict()?;
    motion.done(execution);
    Ok(())
}
