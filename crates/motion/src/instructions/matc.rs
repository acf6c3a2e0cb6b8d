//! MATC, Motion Axis Time Cam (spec/axis-and-data-types.md §3.9).

use arcline_instruction_set::{Call, Mnemonic, MotionError};

use super::camming::{Beginning, CamLayout, begin, not_stopping, verify_change, wait};
use super::{axis_moves, place};
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::follow::cam::{self, Program, Source};
use crate::material::Sent;
use crate::motion::Motion;

/// Places of MATC's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    cam: CamLayout,
    lock_direction: usize,
    instruction_mode: usize,
}

/// Lock Direction: None.
const NONE: i32 = 0;

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Matc, name);
        Layout {
            cam: CamLayout::of(Mnemonic::Matc, "Distance Scaling", "Time Scaling"),
            lock_direction: place("Lock Direction"),
            instruction_mode: place("Instruction Mode"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call, sent: &Sent) -> Result<(), MotionError> {
    let layout = motion.layouts.matc;
    let axis = motion.target_axis(call)?;
    let at = usize::from(axis);
    motion.verify_operands(call)?;
    let master_driven = call.is_one(layout.instruction_mode);
    if master_driven == (call.word(layout.lock_direction) == NONE) {
        return Err(MotionError::MdscLockDirectionConflict);
    }
    if master_driven {
        return Err(MotionError::MdscNotActivated);
    }
    axis_moves::verify_axis(&motion.axes[at], false)?;
    not_stopping(&motion.axes[at], Slot::TimeCam)?;
    let since = motion.clock.now();
    let source = Source::Time { since };
    let pending = layout.cam.is_pending(call);
    verify_change(&motion.axes[at], Slot::TimeCam, source, pending)?;
    let profile = sent.cam()?;

    let before = motion.axes[at].cams(Slot::TimeCam).direction;
    let program = Program {
        entry: profile.start().0,
        profile,
        source,
        slave_scale: layout.cam.direction(call, before) * call.number(layout.cam.slave_scaling),
        master_scale: call.number(layout.cam.master_scaling),
        mode: layout.cam.mode(call),
        way: None,
    };
    if pending {
        wait(motion, axis, Slot::TimeCam, program, execution);
        return Ok(());
    }
    let beginning = Beginning {
        slot: Slot::TimeCam,
        program,
        lock: None,
        master: cam::time(since, &motion.clock),
    };
    begin(motion, axis, beginning, execution);
    Ok(())
}
