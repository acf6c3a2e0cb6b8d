//! MDCC, Master Driven Coordinated Control (spec/coordinated-instructions.md §8.2, §8.3, §18).

use arcline_instruction_set::enumerations::Reference;
use arcline_instruction_set::operands::Mdcc;
use arcline_instruction_set::{AxisId, Call, Flag, MotionError};

use crate::execution::Execution;
use crate::motion::Motion;
use crate::order::{DependencyCycle, Follower};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    let Mdcc {
        master_axis,
        master_reference,
        nominal_master_velocity,
    } = motion.operands(call)?;
    let master = motion.axis_of(&master_axis)?;
    let reference = *master_reference;
    if motion.systems[index].has(master) {
        return Err(MotionError::MasterAxisConflict);
    }
    let order = motion.plan_order(Follower::System(index, master));
    let order = order.map_err(|DependencyCycle| MotionError::MasterAxisConflict)?;
    let system = &motion.systems[index];
    let other_reference = |driving: AxisId, read: Reference| driving == master && read != reference;
    let active = system.links.active.map(|link| link.master);
    if system.is_busy() && active.is_some_and(|active| other_reference(active.axis, active.reference)) {
        return Err(MotionError::MdscInvalidModeOrMasterChange);
    }
    let link = motion.link_numbers.link(
        execution,
        (master, reference),
        *nominal_master_velocity,
        &motion.axes,
        &motion.clock,
    );
    let ended = motion.systems[index].links.make(link);
    motion.controls.end_links(ended);
    motion.order.take(order);
    let made = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, made, 0);
    Ok(())
}
