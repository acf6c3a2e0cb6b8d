//! The end points of coordinated moves: points of a coordinate system from axes and operands.
//!
//! Not here: paths between them. Units: position units.

use arcline_instruction_set::enumerations::MoveType;
use arcline_instruction_set::{AxisIndex, MotionError, OperandIndex, RealArray, SystemId};
use arcline_planner::geometry::Point;

use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::motion::Motion;
use crate::rotary::RotaryPosition;
use crate::system::{Activity, System, component, numbered};

/// A quantity of the axes of a coordinate system as a point.
pub(super) fn command(motion: &Motion, index: SystemId, quantity: impl Fn(&Axis) -> f64) -> Point {
    let mut point = Point::zeros();
    for (axis, coordinate) in motion.systems[index].description.linear().iter().zip(point.iter_mut()) {
        *coordinate = motion.axes.get(*axis).map_or(0.0, &quantity);
    }
    point
}

/// The offsets by which positions were redefined since the queue of a coordinate system began.
pub(super) fn queue_shift(motion: &Motion, index: SystemId) -> Point {
    match motion.systems[index].activity {
        Activity::Moving => command(motion, index, |axis| axis.sum.shift_of(GeneratorKind::System)),
        _ => Point::zeros(),
    }
}

/// The end of the last move in the queue, or the command position.
pub(super) fn start_point(motion: &Motion, index: SystemId) -> Point {
    let system = &motion.systems[index];
    let queued = if system.activity == Activity::Moving {
        system.travel.last().map(|last| last.path.end())
    } else {
        None
    };
    queued.unwrap_or_else(|| command(motion, index, |axis| axis.command.position))
}

/// The point of an operand, absolute or relative to the start; axes beyond the operand keep the start's position.
pub(super) fn target_point(values: &[f64], start: &Point, move_type: MoveType) -> Point {
    let mut target = *start;
    for ((coordinate, from), value) in target.iter_mut().zip(start.iter()).zip(values) {
        *coordinate = match move_type {
            MoveType::Incremental => from + value,
            MoveType::Absolute => *value,
        };
    }
    target
}

/// The elements of an array operand that belong to the axes of a coordinate system.
pub(super) fn primary<'a>(system: &System, operand: &'a RealArray) -> &'a [f64] {
    let values = operand.as_slice();
    &values[..system.description.linear().len().min(values.len())]
}

/// The unwinds of the axes of a coordinate system, with their indices; linear axes have none.
pub(super) fn unwinds(motion: &Motion, system: &System) -> impl Iterator<Item = (AxisIndex, f64)> {
    let axes = numbered(system.description.linear());
    axes.filter_map(|(member, axis)| Some((member, motion.axes.get(axis)?.unwind?)))
}

/// Places absolute positions of rotary axes relative to the start: the sign of an operand is the direction, its magnitude the position
/// within one turn (spec/coordinated-instructions.md §12.2).
///
/// # Errors
/// `ParameterOutOfRange` (13) with the operand if a magnitude is beyond the unwind.
pub(super) fn unwind(
    motion: &Motion,
    system: &System,
    start: &Point,
    values: &[f64],
    target: &mut Point,
    operand: OperandIndex,
) -> Result<(), MotionError> {
    for (member, unwind) in unwinds(motion, system) {
        if let Some(position) = values.get(usize::from(member.0)) {
            let turn = RotaryPosition::at(component(start, member), unwind);
            target[usize::from(member.0)] = turn
                .signed(*position)
                .ok_or(MotionError::ParameterOutOfRange(operand))?;
        }
    }
    Ok(())
}
