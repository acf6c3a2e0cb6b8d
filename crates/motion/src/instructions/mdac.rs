//! MDAC, Master Driven Axis Control (spec/axis-and-data-types.md §3.8).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError};

use super::{mdcc, place};
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::masters::cam::Cam;
use crate::masters::links::Serves;
use crate::motion::Motion;
use crate::order::Follower;

/// Places of MDAC's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    master: usize,
    motion_type: usize,
    reference: usize,
}

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mdac, name);
        Layout {
            master: place("Master Axis"),
            motion_type: place("Motion Type"),
            reference: place("Master Reference"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mdac;
    let axis = motion.target_axis(call)?;
    let at = usize::from(axis);
    motion.verify_operands(call)?;
    let master = mdcc::master(motion, call, layout.master)?;
    let reference = mdcc::reference(call, layout.reference);
    let serves = Serves::ALL
        .get(call.word(layout.motion_type) as usize)
        .copied()
        .unwrap_or(Serves::All);
    if motion.plan_order(Follower::Axis(axis, master)).is_err() {
        return Err(MotionError::MasterAxisConflict);
    }
    let state = &motion.axes[at];
    if state.links.conflict(serves) {
        return Err(MotionError::MdscMdacAllConflict);
    }
    let active = state.links.of(serves).active;
    let driven = |link: u32| {
        let mut guides = state.sum.active().filter_map(|(_, generator)| generator.guide);
        let cam = state.cam(Slot::TimeCam).and_then(Cam::link);
        cam == Some(link) || guides.any(|guide| guide.link == link)
    };
    if let Some(active) = active
        && active.master.axis == master
        && active.master.reference != reference
        && driven(active.id)
    {
        return Err(MotionError::MdscInvalidModeOrMasterChange);
    }
    let link = motion.new_link(execution, master, reference, 0.0);
    let ended = motion.axes[at].links.of_mut(serves).make(link);
    for execution in ended {
        motion.end_link(execution);
    }
    motion.order.take();
    let made = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, made, 0, motion.clock.tick);
    Ok(())
}
