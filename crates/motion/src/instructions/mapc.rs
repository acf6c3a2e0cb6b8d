//! MAPC, Motion Axis Position Cam (spec/axis-and-data-types.md §3.9).

use arcline_instruction_set::{Call, Mnemonic, MotionError, OperandIndex};

use super::camming::{Beginning, CamLayout, begin, not_stopping, on_turn, verify_change, verify_reach, wait};
use super::{axis_moves, place};
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::masters::Reference;
use crate::masters::cam::{Lock, Program, Source};
use crate::material::Sent;
use crate::motion::Motion;

/// Places of MAPC's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    master: usize,
    cam: CamLayout,
    schedule: usize,
    master_lock: usize,
    cam_lock: usize,
    reference: usize,
    master_direction: usize,
}

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mapc, name);
        Layout {
            master: place("Master Axis"),
            cam: CamLayout::of(Mnemonic::Mapc, "Slave Scaling", "Master Scaling"),
            schedule: place("Execution Schedule"),
            master_lock: place("Master Lock Position"),
            cam_lock: place("Cam Lock Position"),
            reference: place("Master Reference"),
            master_direction: place("Master Direction"),
        }
    }
}

/// Execution Schedule: when the master crosses the lock position, with the way that it must go then.
pub(super) fn crossing(schedule: i32) -> Option<Option<f64>> {
    match schedule {
        2 => Some(Some(1.0)),
        3 => Some(Some(-1.0)),
        4 => Some(None),
        _ => None,
    }
}

/// Master Direction: the only way that is followed.
fn way(direction: i32) -> Option<f64> {
    match direction {
        1 => Some(1.0),
        2 => Some(-1.0),
        _ => None,
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call, sent: &Sent) -> Result<(), MotionError> {
    let layout = motion.layouts.mapc;
    let axis = motion.target_axis(call)?;
    let at = usize::from(axis);
    motion.verify_operands(call)?;
    let beyond = |operand: usize| MotionError::ParameterOutOfRange(OperandIndex(operand as u8));
    let master = call
        .object(layout.master)
        .filter(|master| usize::from(*master) < motion.axes.len())
        .ok_or(beyond(layout.master))?;
    let lock_position = call.number(layout.master_lock);
    let pending = layout.cam.is_pending(call);
    let crossing = crossing(call.word(layout.schedule));
    if crossing.is_some() {
        on_turn(&motion.axes[usize::from(master)], lock_position, layout.master_lock)?;
    }
    let profile = sent.cam();
    let entry = call.number(layout.cam_lock);
    if !pending && profile.as_ref().is_ok_and(|profile| !profile.contains(entry)) {
        return Err(beyond(layout.cam_lock));
    }
    axis_moves::verify_axis(&motion.axes[at], false)?;
    not_stopping(&motion.axes[at], Slot::PositionCam)?;
    if motion.plan_master(axis, master).is_err() {
        return Err(MotionError::MasterAxisConflict);
    }
    let reference = if call.word(layout.reference) == 0 {
        Reference::Actual
    } else {
        Reference::Command
    };
    let source = Source::Axis { master, reference };
    verify_change(&motion.axes[at], Slot::PositionCam, source, pending)?;
    let profile = profile?;

    let before = motion.axes[at].cams(Slot::PositionCam).direction;
    let program = Program {
        profile,
        source,
        slave_scale: layout.cam.direction(call, before) * call.number(layout.cam.slave_scaling),
        master_scale: call.number(layout.cam.master_scaling),
        mode: layout.cam.mode(call),
        way: way(call.word(layout.master_direction)),
        entry,
        link: None,
    };
    verify_reach(motion, axis, &program, layout.cam.slave_scaling)?;
    if pending {
        wait(motion, axis, Slot::PositionCam, program, execution);
        return Ok(());
    }
    let state = &motion.axes[usize::from(master)];
    let lock = crossing.map(|way| Lock {
        position: lock_position - state.redefined,
        way,
        unwind: state.unwind,
    });
    let beginning = Beginning {
        slot: Slot::PositionCam,
        program,
        lock,
        master: motion.axes.master_at(master, reference, &motion.clock),
    };
    begin(motion, axis, beginning, execution);
    motion.order.take();
    Ok(())
}
