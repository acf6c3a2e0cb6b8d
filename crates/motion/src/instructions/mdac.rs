//! MDAC, Master Driven Axis Control (spec/axis-and-data-types.md §3.8).

use arcline_instruction_set::operands::Mdac;
use arcline_instruction_set::{Call, Flag, MotionError};

use crate::axis::generator_kind::GeneratorKind;
use crate::execution::Execution;
use crate::masters::cam::Cam;
use crate::motion::Motion;
use crate::order::{DependencyCycle, Follower};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mdac {
        master_axis,
        motion_type,
        master_reference,
    } = motion.operands(call)?;
    let master = motion.axis_of(&master_axis)?;
    let reference = *master_reference;
    let serves = *motion_type;
    let order = motion.plan_order(Follower::Axis(axis, master));
    let order = order.map_err(|DependencyCycle| MotionError::MasterAxisConflict)?;
    let state = &motion.axes[axis];
    if state.links.conflict(serves) {
        return Err(MotionError::MdscMdacAllConflict);
    }
    let active = state.links.of(serves).active;
    let driven = |link: u32| {
        let mut followers = state.sum.active().filter_map(|(_, generator)| generator.follower);
        let cam = state.cam(GeneratorKind::TimeCam).and_then(Cam::link);
        cam == Some(link) || followers.any(|follower| follower.link == link)
    };
    if let Some(active) = active
        && active.master.axis == master
        && active.master.reference != reference
        && driven(active.id)
    {
        return Err(MotionError::MdscInvalidModeOrMasterChange);
    }
    let link = motion
        .link_numbers
        .link(execution, (master, reference), 0.0, &motion.axes, &motion.clock);
    let ended = motion.axes[axis].links.of_mut(serves).make(link);
    motion.controls.end_links(ended);
    motion.order.take(order);
    let made = Flag::Dn.mask() | Flag::Ip.mask();
    motion.controls.write(execution, made, 0);
    Ok(())
}
