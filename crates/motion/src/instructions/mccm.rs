//! MCCM, Motion Coordinated Circular Move (spec/coordinated-instructions.md §13, the reference page MCCM).

use arcline_instruction_set::enumerations::{CircleDirection, CircleType, MoveType};
use arcline_instruction_set::operands::{Mccm, OperandValue, Operands};
use arcline_instruction_set::{AxisIndex, Call, MotionError, RealArray};
use arcline_planner::geometry::{Arc, ArcError, CirclePoint, Dimension, Direction, Path};

use super::moves::{self, MoveOperands};
use super::points::{self, primary, target_point, unwinds};
use super::programmed::Programmed;
use crate::execution::Execution;
use crate::motion::Motion;
use crate::range;
use crate::rotary::RotaryPosition;
use crate::system::{System, component};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    if motion.systems[index].description.orientation.is_some() {
        return Err(MotionError::InstructionNotSupported);
    }
    let Mccm {
        move_type,
        position,
        circle_type,
        via_center_radius,
        direction,
        dynamics,
        termination_type,
        merge,
        merge_speed,
        command_tolerance,
        lock,
        events,
    } = Mccm::of(call);
    let operands = MoveOperands {
        programmed: Programmed::new(dynamics, lock),
        termination_type: *termination_type,
        merge: *merge,
        merge_speed: *merge_speed,
        command_tolerance: *command_tolerance,
        events,
    };
    moves::execute(motion, execution, call, &operands, |motion, system, start| {
        let axes = system.description.linear().len();
        let ends = primary(system, &position);
        let mut end = target_point(ends, &start, *move_type);
        match *move_type {
            MoveType::Incremental => verify_turns(motion, system, &position)?,
            MoveType::Absolute => points::unwind(motion, system, &start, ends, &mut end, position.index)?,
        }
        range::verify_point(system, &motion.axes, &end, position.index)?;
        let values = primary(system, &via_center_radius);
        let point = |move_type: MoveType| {
            let mut point = target_point(values, &start, move_type);
            if move_type == MoveType::Absolute {
                // On a rotary axis the point takes the turn nearest to the middle between start and end.
                for (member, unwind) in unwinds(motion, system) {
                    let middle = 0.5 * (component(&start, member) + component(&end, member));
                    let coordinate = &mut point[usize::from(member.0)];
                    *coordinate = RotaryPosition::nearest(unwind, *coordinate, middle);
                }
            }
            point
        };
        let circle_point = match *circle_type {
            CircleType::Via => CirclePoint::Via(point(*move_type)),
            CircleType::Center => CirclePoint::Center(point(*move_type)),
            CircleType::Radius => CirclePoint::Radius(values.first().copied().unwrap_or(0.0)),
            CircleType::CenterIncremental => CirclePoint::Center(point(MoveType::Incremental)),
        };
        let dimension = if axes == 2 { Dimension::Two } else { Dimension::Three };
        let direction = match *direction {
            CircleDirection::Clockwise => Direction::Clockwise,
            CircleDirection::CounterClockwise => Direction::CounterClockwise,
            CircleDirection::ClockwiseFull => Direction::ClockwiseFull,
            CircleDirection::CounterClockwiseFull => Direction::CounterClockwiseFull,
        };
        let arc = Arc::new(dimension, start, end, circle_point, direction).map_err(error)?;
        let path = Path::Arc(arc);
        range::verify_path(system, &motion.axes, &path, via_center_radius.index)?;
        Ok(path)
    })
}

/// Checks that no increment moves a rotary axis by more than one turn (spec/coordinated-instructions.md §13.6).
fn verify_turns(motion: &Motion, system: &System, increments: &OperandValue<RealArray>) -> Result<(), MotionError> {
    let of_axes = primary(system, increments);
    let beyond =
        |(member, unwind): (AxisIndex, f64)| of_axes.get(usize::from(member.0)).is_some_and(|by| by.abs() > unwind);
    if unwinds(motion, system).any(beyond) {
        return Err(increments.out_of_range());
    }
    Ok(())
}

fn error(error: ArcError) -> MotionError {
    match error {
        ArcError::Collinear => MotionError::CircularCollinearity,
        ArcError::StartEnd => MotionError::CircularStartEnd,
        ArcError::RadiusMismatch { .. } => MotionError::CircularR1R2Mismatch,
        ArcError::SmallRadius { .. } => MotionError::CircularSmallR,
        ArcError::RadiusIn3d => MotionError::IllegalInstruction,
    }
}
