//! How far from 0 axes can be: 2³² coarse updates at Maximum Speed (spec/coordinated-instructions.md §4.6, "The range of positions").
//!
//! Beyond it a position has so few digits left that its rounding would show in the motion: at the end of the range a digit is a
//! millionth of the way that the axis goes in one update at Maximum Speed. Not here: the range of every number
//! (`arcline_instruction_set::Range`). Units: position units.

use arcline_instruction_set::{MotionError, OperandIndex};
use arcline_planner::geometry::{Path, Point};

use crate::axes::Axes;
use crate::axis::Axis;
use crate::system::{System, component, numbered};

/// An axis can be at a position.
///
/// # Errors
/// `ParameterOutOfRange` (13) with the operand that leads there.
pub(crate) fn verify(axis: &Axis, position: f64, operand: OperandIndex) -> Result<(), MotionError> {
    if position.abs() <= axis.range {
        Ok(())
    } else {
        Err(MotionError::ParameterOutOfRange(operand))
    }
}

/// The axes of a coordinate system can be at a point.
///
/// # Errors
/// `ParameterOutOfRange` (13) with the operand that leads there.
pub(crate) fn verify_point(
    system: &System,
    axes: &Axes,
    point: &Point,
    operand: OperandIndex,
) -> Result<(), MotionError> {
    for (member, axis) in numbered(system.description.linear()) {
        if let Some(axis) = axes.get(axis) {
            verify(axis, component(point, member), operand)?;
        }
    }
    Ok(())
}

/// No point of a path is further from 0 than an axis can be. An arc goes no further from its start than its length or its
/// diameter.
///
/// # Errors
/// `ParameterOutOfRange` (13) with the operand that leads there.
pub(crate) fn verify_path(system: &System, axes: &Axes, path: &Path, operand: OperandIndex) -> Result<(), MotionError> {
    let Path::Arc(arc) = path else {
        return verify_point(system, axes, &path.end(), operand);
    };
    let away = path.length().min(2.0 * arc.radius().max(arc.end_radius()));
    let furthest = path.start().map(|start| start.abs() + away);
    let flat = system.description.linear().len();
    let furthest = Point::from_fn(|member, _| if member < flat { furthest[member] } else { 0.0 });
    verify_point(system, axes, &furthest, operand)
}
