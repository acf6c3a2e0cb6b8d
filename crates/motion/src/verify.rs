//! The order of the checks of an instruction: the first error counts
//! (spec/coordinated-instructions.md §11.1, spec/axis-and-data-types.md §1.7).
//!
//! Step 1 (control tag) is in `control`, step 5 (operands) in the catalogue, step 10 (geometry) and the conflicts of step 11 with the
//! instructions. Steps 2 and 3 cannot fail: the controller is always in Run, and a machine has exactly one group.

use core::iter;

use arcline_instruction_set::{AxisId, AxisIndex, Culprit, MotionError};
use arcline_planner::geometry::Point;

use crate::axes::Axes;
use crate::axis::Axis;
use crate::axis::state::AxisState;
use crate::system::{Activity, System, component, numbered};

/// Axes to check, each with the index that an error reports: the axes of a coordinate system, or one axis alone. A check reports the first of
/// them that fails it.
pub(crate) trait Members<'a>: Iterator<Item = (AxisIndex, &'a Axis)> + Clone {}

impl<'a, I: Iterator<Item = (AxisIndex, &'a Axis)> + Clone> Members<'a> for I {}

/// The axes of a coordinate system in its order.
pub(crate) fn members<'a>(system: &'a System, axes: &'a Axes) -> impl Members<'a> {
    among(&system.description.axes, axes)
}

/// One axis, which is the operand of its instruction.
pub(crate) fn alone(axis: &Axis) -> impl Members<'_> {
    iter::once((AxisIndex(0), axis))
}

/// Step 8: no axis is shut down, and every axis has its servo on and no fault.
pub(crate) fn ready<'a>(members: impl Members<'a>) -> Result<(), MotionError> {
    switched_on(members.clone())?;
    not_faulted(members)
}

/// Step 8 of a stop: no axis is shut down, and every axis has its servo on, except those that a fault has switched off.
pub(crate) fn switched_on<'a>(members: impl Members<'a>) -> Result<(), MotionError> {
    not_shut_down(members.clone())?;
    none(members, Axis::is_off, MotionError::ServoOffState)
}

/// Step 8: no axis is shut down; the servo may be off.
pub(crate) fn not_shut_down<'a>(members: impl Members<'a>) -> Result<(), MotionError> {
    let shut_down = |axis: &Axis| axis.state == AxisState::Shutdown;
    none(members, shut_down, MotionError::ShutdownState)
}

/// Step 8: no axis has a fault; the servo may be off.
pub(crate) fn not_faulted<'a>(members: impl Members<'a>) -> Result<(), MotionError> {
    none(members, Axis::is_faulted, MotionError::AxisInFaultedState)
}

/// Step 8, after [`ready`]: no active sequence homes an axis.
pub(crate) fn not_homing<'a>(members: impl Members<'a>) -> Result<(), MotionError> {
    none(members, Axis::is_homed_actively, MotionError::HomeInProcess)
}

/// Step 9: every axis has a deceleration to stop with.
pub(crate) fn stoppable<'a>(members: impl Members<'a>) -> Result<(), MotionError> {
    let without = |axis: &Axis| axis.dynamics.deceleration <= 0.0;
    none(members, without, |member| {
        MotionError::ZeroMaxDecel(Culprit::Axis(member))
    })
}

/// Step 9, after [`stoppable`]: every axis has a jerk to stop an S-curve with.
pub(crate) fn stoppable_by_jerk<'a>(members: impl Members<'a>) -> Result<(), MotionError> {
    let without = |axis: &Axis| axis.dynamics.deceleration_jerk <= 0.0;
    none(members, without, |member| {
        MotionError::ZeroMaxDecelJerk(Culprit::Axis(member))
    })
}

/// Step 9: a coordinate system and each of its axes have the rates to stop every motion that begins.
pub(crate) fn system_stoppable(system: &System, axes: &Axes, s_curve: bool) -> Result<(), MotionError> {
    if system.description.max_deceleration <= 0.0 {
        return Err(MotionError::ZeroMaxDecel(Culprit::CoordinateSystem));
    }
    stoppable(members(system, axes))?;
    if !s_curve {
        return Ok(());
    }
    if system.description.max_deceleration_jerk <= 0.0 {
        return Err(MotionError::ZeroMaxDecelJerk(Culprit::CoordinateSystem));
    }
    stoppable_by_jerk(members(system, axes))
}

/// Step 11: no stop of a whole axis is under way.
pub(crate) fn not_stopping<'a>(members: impl Members<'a>) -> Result<(), MotionError> {
    none(members, Axis::is_stopping, MotionError::NotAllowedWhileStopping)
}

/// Step 11: no stop of a coordinate system or of one of its axes is under way.
pub(crate) fn system_not_stopping(system: &System, axes: &Axes) -> Result<(), MotionError> {
    not_stopping(members(system, axes))?;
    // A failed transform also stops moves on their path.
    if system.activity == Activity::Stopping || system.stop.is_some_and(|stop| stop.of_moves) {
        return Err(MotionError::NotAllowedWhileStopping(AxisIndex(0)));
    }
    Ok(())
}

/// Step 12, overtravel: no axis outside of its travel moves further out. `direction`: a number with the sign of an axis's motion.
pub(crate) fn no_overtravel<'a>(
    mut members: impl Members<'a>,
    direction: impl Fn(AxisIndex, &Axis) -> f64,
) -> Result<(), MotionError> {
    if members.any(|(member, axis)| axis.faults.forbids(direction(member, axis))) {
        return Err(MotionError::OvertravelCondition);
    }
    Ok(())
}

/// Step 12, overtravel, of a path of the linear axes of a coordinate system.
pub(crate) fn no_overtravel_to(system: &System, axes: &Axes, end: &Point) -> Result<(), MotionError> {
    no_overtravel(among(system.description.linear(), axes), |member, axis| {
        component(end, member) - axis.command.position
    })
}

fn among<'a>(ids: &'a [AxisId], axes: &'a Axes) -> impl Members<'a> {
    numbered(ids).filter_map(move |(member, id)| axes.get(id).map(|axis| (member, axis)))
}

/// No axis is at fault; otherwise the error of the first that is.
fn none<'a>(
    mut members: impl Members<'a>,
    at_fault: impl Fn(&Axis) -> bool,
    error: impl Fn(AxisIndex) -> MotionError,
) -> Result<(), MotionError> {
    match members.find(|(_, axis)| at_fault(axis)) {
        Some((member, _)) => Err(error(member)),
        None => Ok(()),
    }
}
