//! The order of the checks of an instruction: the first error counts
//! (spec/coordinated-instructions.md §11.1, spec/axis-and-data-types.md §1.7).
//!
//! Step 1 (control tag) is in `control`, step 5 (operands) in the catalogue, step 10 (geometry) and the conflicts of step 11 with the
//! instructions. Steps 2 and 3 cannot fail: the controller is always in Run, and a machine has exactly one group.

use arcline_instruction_set::{AxisId, AxisIndex, Culprit, MotionError};

use arcline_planner::geometry::Point;

use crate::axes::Axes;
use crate::axis::Axis;
use crate::axis::state::AxisState;
use crate::system::{Activity, System, component, numbered};

/// Step 8: no axis is shut down, and every axis has its servo on and no fault. The axis with the lowest index is reported first.
pub(crate) fn axes_ready(system: &System, axes: &Axes) -> Result<(), MotionError> {
    axes_on(system, axes)?;
    match first(system, axes, Axis::is_faulted) {
        Some(member) => Err(MotionError::AxisInFaultedState(member)),
        None => Ok(()),
    }
}

/// Step 8 of a stop: no axis is shut down, and every axis has its servo on, except those that a fault has switched off.
pub(crate) fn axes_on(system: &System, axes: &Axes) -> Result<(), MotionError> {
    if let Some(member) = first(system, axes, |axis| axis.state == AxisState::Shutdown) {
        return Err(MotionError::ShutdownState(member));
    }
    match first(system, axes, Axis::is_off) {
        Some(member) => Err(MotionError::ServoOffState(member)),
        None => Ok(()),
    }
}

/// Step 8, after [`axes_ready`]: no axis is being homed. The axis with the lowest index is reported first.
pub(crate) fn not_homing(system: &System, axes: &Axes) -> Result<(), MotionError> {
    match first(system, axes, Axis::is_homed_actively) {
        Some(member) => Err(MotionError::HomeInProcess(member)),
        None => Ok(()),
    }
}

/// Step 9: the system and each axis have the rates to stop every motion that begins.
pub(crate) fn stoppable(system: &System, axes: &Axes, s_curve: bool) -> Result<(), MotionError> {
    if system.description.max_deceleration <= 0.0 {
        return Err(MotionError::ZeroMaxDecel(Culprit::CoordinateSystem));
    }
    if let Some(member) = first(system, axes, |axis| axis.dynamics.deceleration <= 0.0) {
        return Err(MotionError::ZeroMaxDecel(Culprit::Axis(member)));
    }
    if !s_curve {
        return Ok(());
    }
    if system.description.max_deceleration_jerk <= 0.0 {
        return Err(MotionError::ZeroMaxDecelJerk(Culprit::CoordinateSystem));
    }
    match first(system, axes, |axis| axis.dynamics.deceleration_jerk <= 0.0) {
        Some(member) => Err(MotionError::ZeroMaxDecelJerk(Culprit::Axis(member))),
        None => Ok(()),
    }
}

/// Step 11: no stop of this system or of one of its axes is under way.
pub(crate) fn not_stopping(system: &System, axes: &Axes) -> Result<(), MotionError> {
    if let Some(member) = first(system, axes, Axis::is_stopping) {
        return Err(MotionError::NotAllowedWhileStopping(member));
    }
    // A failed transform also stops moves on their path.
    if system.activity == Activity::Stopping || system.stop.is_some_and(|stop| stop.of_moves) {
        return Err(MotionError::NotAllowedWhileStopping(AxisIndex(0)));
    }
    Ok(())
}

/// Step 12, overtravel: no axis outside of its travel moves further out.
pub(crate) fn no_overtravel(system: &System, axes: &Axes, end: &Point) -> Result<(), MotionError> {
    let out = |(member, axis): (AxisIndex, AxisId)| {
        let axis = axes.get(axis);
        axis.is_some_and(|axis| axis.faults.forbids(component(end, member) - axis.command.position))
    };
    if numbered(system.description.linear()).any(out) {
        return Err(MotionError::OvertravelCondition);
    }
    Ok(())
}

fn first(system: &System, axes: &Axes, at_fault: impl Fn(&Axis) -> bool) -> Option<AxisIndex> {
    let mut members = numbered(&system.description.axes);
    let found = members.find(|(_, axis)| axes.get(*axis).is_some_and(&at_fault));
    found.map(|(index, _)| index)
}
