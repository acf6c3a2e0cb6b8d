//! MAPC, Motion Axis Position Cam (spec/axis-and-data-types.md §3.9).

use arcline_instruction_set::enumerations::{ExecutionSchedule, MasterDirection};
use arcline_instruction_set::operands::Mapc;
use arcline_instruction_set::{Call, MotionError};

use super::axis_moves;
use super::camming::{CamStart, begin, not_stopping, on_turn, sign, verify_change, verify_reach, wait};
use crate::axis::generator_kind::GeneratorKind;
use crate::call_data::ReceivedData;
use crate::execution::Execution;
use crate::masters::cam::{CamProgram, Source};
use crate::masters::displacement::{Crossing, Sense};
use crate::motion::Motion;
use crate::order::{DependencyCycle, Follower};

/// Execution Schedule: whether the cam waits for the master to cross the lock position, and the direction of the crossing.
pub(super) fn crossing(schedule: ExecutionSchedule) -> Option<Option<Sense>> {
    match schedule {
        ExecutionSchedule::Immediate | ExecutionSchedule::Pending => None,
        ExecutionSchedule::ForwardOnly => Some(Some(Sense::Forward)),
        ExecutionSchedule::ReverseOnly => Some(Some(Sense::Reverse)),
        ExecutionSchedule::Bidirectional => Some(None),
    }
}

/// Master Direction: the only direction in which the slave follows the master.
fn sense(direction: MasterDirection) -> Option<Sense> {
    match direction {
        MasterDirection::Bidirectional => None,
        MasterDirection::ForwardOnly => Some(Sense::Forward),
        MasterDirection::ReverseOnly => Some(Sense::Reverse),
    }
}

pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mapc {
        master_axis,
        direction,
        cam_profile: _,
        slave_scaling,
        master_scaling,
        execution_mode,
        execution_schedule,
        master_lock_position,
        cam_lock_position,
        master_reference,
        master_direction,
    } = motion.operands(call)?;
    let master = motion.axis_of(&master_axis)?;
    let pending = *execution_schedule == ExecutionSchedule::Pending;
    let crossing = crossing(*execution_schedule);
    if crossing.is_some() {
        on_turn(&motion.axes[master], &master_lock_position)?;
    }
    let profile = data.cam();
    let entry = *cam_lock_position;
    if !pending && profile.as_ref().is_ok_and(|profile| !profile.contains(entry)) {
        return Err(cam_lock_position.out_of_range());
    }
    axis_moves::verify_axis(&motion.axes[axis], false)?;
    not_stopping(&motion.axes[axis], GeneratorKind::PositionCam)?;
    let order = motion.plan_order(Follower::Axis(axis, master));
    let order = order.map_err(|DependencyCycle| MotionError::MasterAxisConflict)?;
    let reference = *master_reference;
    let source = Source::Axis { master, reference };
    verify_change(&motion.axes[axis], GeneratorKind::PositionCam, source, pending)?;
    let profile = profile?;

    let before = motion.axes[axis].cams(GeneratorKind::PositionCam).direction;
    let program = CamProgram {
        profile,
        source,
        slave_scale: sign(*direction, before) * *slave_scaling,
        master_scale: *master_scaling,
        mode: *execution_mode,
        sense: sense(*master_direction),
        entry,
        link: None,
    };
    verify_reach(motion, axis, &program, slave_scaling.index)?;
    if pending {
        wait(motion, axis, GeneratorKind::PositionCam, program, execution);
        return Ok(());
    }
    let state = &motion.axes[master];
    let lock = crossing.map(|sense| Crossing {
        position: *master_lock_position - state.redefined,
        sense,
        unwind: state.unwind,
    });
    let beginning = CamStart {
        kind: GeneratorKind::PositionCam,
        program,
        lock,
        master: motion.axes.master_at(master, reference, &motion.clock),
    };
    begin(motion, axis, beginning, execution);
    motion.order.take(order);
    Ok(())
}
