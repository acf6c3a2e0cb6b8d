//! MDCC, Master Driven Coordinated Control (spec/coordinated-instructions.md §8.2, §8.3, §18).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError, OperandIndex};

use super::place;
use crate::control::Execution;
use crate::masters::Reference;
use crate::motion::Motion;
use crate::order::Follower;

/// Places of MDCC's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    master: usize,
    reference: usize,
    nominal: usize,
}

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mdcc, name);
        Layout {
            master: place("Master Axis"),
            reference: place("Master Reference"),
            nominal: place("Nominal Master Velocity"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mdcc;
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    let master = master(motion, call, layout.master)?;
    let reference = reference(call, layout.reference);
    let system = &motion.systems[index];
    if system.has(master) || motion.plan_order(Follower::System(index, master)).is_err() {
        return Err(MotionError::MasterAxisConflict);
    }
    let system = &motion.systems[index];
    let other_reference = |guided: u16, read: Reference| guided == master && read != reference;
    let active = system.links.active.map(|link| link.master);
    if system.is_busy() && active.is_some_and(|active| other_reference(active.axis, active.reference)) {
        return Err(MotionError::MdscInvalidModeOrMasterChange);
    }
    let link = motion.new_link(execution, master, reference, call.number(layout.nominal));
    let ended = motion.systems[index].links.make(link);
    for execution in ended {
        motion.end_link(execution);
    }
    motion.order.take();
    let made = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, made, 0, motion.clock.tick);
    Ok(())
}

/// The operand that names the master.
pub(super) fn master(motion: &Motion, call: &Call, operand: usize) -> Result<u16, MotionError> {
    call.object(operand)
        .filter(|master| usize::from(*master) < motion.axes.len())
        .ok_or(MotionError::ParameterOutOfRange(OperandIndex(operand as u8)))
}

/// The operand that says what of the master is read.
pub(super) fn reference(call: &Call, operand: usize) -> Reference {
    if call.word(operand) == ACTUAL {
        Reference::Actual
    } else {
        Reference::Command
    }
}

/// Master Reference: actual position.
const ACTUAL: i32 = 0;
