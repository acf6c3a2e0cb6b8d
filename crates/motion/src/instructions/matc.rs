//! MATC, Motion Axis Time Cam (spec/axis-and-data-types.md §3.9): over time, or over the distance of a master that MDAC links.

use arcline_instruction_set::enumerations::{ExecutionSchedule, InstructionMode, MdacMotionType};
use arcline_instruction_set::operands::{LockOperands, Matc};
use arcline_instruction_set::{AxisId, Call, MotionError};

use super::axis_moves;
use super::camming::{CamStart, begin, not_stopping, sign, verify_change, verify_reach, wait};
use super::programmed::{driven_by, verify_lock};
use crate::axis::generator_kind::GeneratorKind;
use crate::call_data::ReceivedData;
use crate::execution::Execution;
use crate::masters::cam::{self, Cam, CamProgram, Source};
use crate::masters::displacement::{Crossing, Sense};
use crate::masters::follower::DrivenBy;
use crate::masters::links::MasterLink;
use crate::motion::Motion;

/// The master of the cam; `None`: time.
///
/// # Errors
/// A lock direction of the other mode, or of a position for a pending cam, which begins at the end of the active one (95); no link (93);
/// a position that the master never shows (13).
fn driven(
    motion: &Motion,
    axis: AxisId,
    mode: InstructionMode,
    lock: &LockOperands,
    schedule: ExecutionSchedule,
) -> Result<Option<(MasterLink, DrivenBy)>, MotionError> {
    let master_driven = mode == InstructionMode::MasterDriven;
    let link = motion.axes[axis].links.newest(MdacMotionType::TimeCam);
    verify_lock(lock, master_driven, link)?;
    let Some(link) = link.filter(|_| master_driven) else {
        return Ok(None);
    };
    let driven_by = driven_by(motion, lock, link)?;
    if schedule == ExecutionSchedule::Pending && driven_by.lock.position.is_some() {
        return Err(MotionError::MdscLockDirectionConflict);
    }
    Ok(Some((*link, driven_by)))
}

pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Matc {
        direction,
        cam_profile: _,
        distance_scaling,
        time_scaling,
        execution_mode,
        execution_schedule,
        lock,
        instruction_mode,
    } = motion.operands(call)?;
    let driven = driven(motion, axis, *instruction_mode, &lock, *execution_schedule)?;
    axis_moves::verify_axis(&motion.axes[axis], false)?;
    not_stopping(&motion.axes[axis], GeneratorKind::TimeCam)?;
    let since = motion.clock.now();
    let source = driven.map_or(Source::Time { since }, |(link, _)| Source::Axis {
        master: link.master.axis,
        reference: link.master.reference,
    });
    let pending = *execution_schedule == ExecutionSchedule::Pending;
    verify_change(&motion.axes[axis], GeneratorKind::TimeCam, source, pending)?;
    let sense = driven.map(|(_, driven_by)| driven_by.lock.sense);
    let runs = motion.axes[axis].cam(GeneratorKind::TimeCam).map(Cam::sense);
    if runs.is_some_and(|runs| runs != sense) {
        return Err(MotionError::MdscDirectionMismatch);
    }
    let profile = data.cam()?;

    let before = motion.axes[axis].cams(GeneratorKind::TimeCam).direction;
    let program = CamProgram {
        entry: profile.start().0,
        profile,
        source,
        slave_scale: sign(*direction, before) * *distance_scaling,
        // The slave continues in its direction, whichever direction of the master it follows.
        master_scale: sense.map_or(1.0, Sense::sign) * *time_scaling,
        mode: *execution_mode,
        sense,
        link: driven.map(|(link, _)| link.id),
    };
    verify_reach(motion, axis, &program, distance_scaling.index)?;
    if pending {
        wait(motion, axis, GeneratorKind::TimeCam, program, execution);
        return Ok(());
    }
    let mut lock = None;
    let master = match driven {
        None => cam::time(since, &motion.clock),
        Some((link, driven_by)) => {
            motion.axes[axis].take_up_link(link.id, &mut motion.controls);
            let state = &motion.axes[link.master.axis];
            lock = driven_by.lock.position.map(|position| Crossing {
                position: position - state.redefined,
                sense,
                unwind: state.unwind,
            });
            motion
                .axes
                .master_at(link.master.axis, link.master.reference, &motion.clock)
        }
    };
    let beginning = CamStart {
        kind: GeneratorKind::TimeCam,
        program,
        lock,
        master,
    };
    begin(motion, axis, beginning, execution);
    Ok(())
}
