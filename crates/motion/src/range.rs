//! The range of positions about 0: 2³² coarse updates at Maximum Speed (spec/coordinated-instructions.md §4.6, "The range of positions").
//!
//! Beyond it a position has so few digits left that its rounding would be visible in the motion: at the end of the range a digit is a
//! millionth of the distance of one update at Maximum Speed. Not here: the range of every number (`arcline_instruction_set::Range`).
//! Units: position units.

use arcline_instruction_set::{MotionError, OperandIndex};
use arcline_planner::geometry::{Path, Point};

use crate::axes::Axes;
use crate::axis::Axis;
use crate::system::{System, component, numbered};

/// Checks that a position is within the range of an axis.
///
/// # Errors
/// `ParameterOutOfRange` (13) with the operand of the position.
pub(crate) fn verify(axis: &Axis, position: f64, operand: OperandIndex) -> Result<(), MotionError> {
    if position.abs() <= axis.range {
        Ok(())
    } else {
        Err(MotionError::ParameterOutOfRange(operand))
    }
}

/// Checks that a point is within the ranges of the axes of a coordinate system.
///
/// # Errors
/// `ParameterOutOfRange` (13) with the operand of the point.
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

/// Checks that every point of a path is within the ranges of the axes. No point of an arc is further from its start than its length or its
/// diameter.
///
/// # Errors
/// `ParameterOutOfRange` (13) with the operand of the path.
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
