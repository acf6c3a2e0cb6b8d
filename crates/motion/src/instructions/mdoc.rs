//! MDOC, Motion Disarm Output Cam (spec/axis-and-data-types.md §5).

use arcline_instruction_set::{Call, Mnemonic, MotionError};

use super::{maoc, place};
use crate::control::Execution;
use crate::motion::Motion;

/// Places of MDOC's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    target: usize,
    disarm_type: usize,
}

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mdoc, name);
        Layout {
            target: place("Execution Target"),
            disarm_type: place("Disarm Type"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mdoc;
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    // All of them, or one.
    let targets = if call.is_one(layout.disarm_type) {
        let target = maoc::target(motion, axis, call, layout.target)?;
        target..target + 1
    } else {
        0..motion.axes[usize::from(axis)].outputs.len()
    };
    for target in targets {
        motion.disarm_output(axis, target);
    }
    motion.done(execution);
    Ok(())
}
