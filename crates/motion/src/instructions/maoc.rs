//! MAOC, Motion Arm Output Cam (spec/axis-and-data-types.md §5).

use arcline_instruction_set::enumerations::ExecutionSchedule;
use arcline_instruction_set::operands::{Maoc, Operands};
use arcline_instruction_set::{AxisId, Call, Flag, MotionError, TagAddress};

use super::camming::on_turn;
use super::mapc::crossing;
use crate::call_data::ReceivedData;
use crate::execution::Execution;
use crate::masters::displacement::Crossing;
use crate::motion::Motion;
use crate::output::{ArmedCam, Arming, TagBits};
use crate::verify::{self, alone};

/// Ranges in the order of the faceplate.
fn verify(motion: &Motion, axis: AxisId, operands: &Maoc, call: &Call) -> Result<(), MotionError> {
    let Maoc {
        cam_start_position: start,
        cam_end_position: end,
        execution_schedule: schedule,
        axis_arm_position: axis_arm,
        cam_arm_position: cam_arm,
        ..
    } = operands;
    let on_turn = match crossing(**schedule) {
        Some(_) => on_turn(&motion.axes[axis], axis_arm),
        None => Ok(()),
    };
    let outside = **schedule != ExecutionSchedule::Pending && !(**start..=**end).contains(&**cam_arm);
    let rises = if **start < **end {
        Ok(())
    } else {
        Err(end.out_of_range())
    };
    let inside = if outside { Err(cam_arm.out_of_range()) } else { Ok(()) };
    let own = rises.and(on_turn).and(inside);
    match (motion.verify_operands(call), own) {
        (Err(MotionError::ParameterOutOfRange(first)), Err(MotionError::ParameterOutOfRange(own))) => {
            Err(MotionError::ParameterOutOfRange(first.min(own)))
        }
        (verified, own) => verified.and(own),
    }
}

/// The execution target that an operand names.
///
/// # Errors
/// `IllegalExecutionTarget` (35) if the axis has no target of that number.
pub(super) fn target(motion: &Motion, axis: AxisId, number: i32) -> Result<usize, MotionError> {
    let targets = motion.axes[axis].outputs.len();
    let target = usize::try_from(number).ok();
    target
        .filter(|target| *target < targets)
        .ok_or(MotionError::IllegalExecutionTarget)
}

pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let operands = Maoc::of(call);
    verify(motion, axis, &operands, call)?;
    let Maoc {
        execution_target,
        output,
        input,
        output_cam: _,
        cam_start_position: _,
        cam_end_position: _,
        output_compensation: _,
        execution_mode,
        execution_schedule,
        axis_arm_position,
        cam_arm_position,
        position_reference,
    } = operands;
    verify::not_shut_down(alone(&motion.axes[axis]))?;
    let target = target(motion, axis, *execution_target)?;
    let (cam, [output_bits, input_bits]) = data.output_cam()?;
    let program = ArmedCam {
        cam,
        mode: *execution_mode,
        execution,
    };
    let clock = motion.clock;
    let reference = *position_reference;
    let point = motion.axes.master_at(axis, reference, &motion.clock).point;
    let state = &mut motion.axes[axis];
    let word = |tag: Option<TagAddress>, bits: u32| {
        tag.map(|tag| TagBits {
            tag,
            mask: u32::MAX,
            bits,
        })
    };
    let lock = crossing(*execution_schedule).map(|sense| Crossing {
        position: *axis_arm_position - state.redefined,
        sense,
        unwind: state.unwind,
    });
    let Some(execution_target) = state.outputs.target_mut(target) else {
        return Err(MotionError::IllegalExecutionTarget);
    };
    let ended = if *execution_schedule == ExecutionSchedule::Pending {
        execution_target.wait(program, &clock)
    } else {
        let arming = Arming {
            lock,
            entry: *cam_arm_position,
            reference,
            output: word(*output, output_bits).unwrap_or_default(),
            input: word(*input, input_bits),
        };
        execution_target.begin(program, &arming, point, &clock)
    };
    let written = execution_target.write(&clock);
    if let Some(ended) = ended {
        motion.controls.end_move(ended, 0);
    }
    motion.write_word(written);
    motion.controls.write(execution, Flag::Ip.mask(), 0);
    motion.done_next_update(execution, axis, None);
    Ok(())
}
