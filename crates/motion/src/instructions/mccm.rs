//! MCCM, Motion Coordinated Circular Move (spec/coordinated-instructions.md §13, the reference page MCCM).

use arcline_instruction_set::{Call, Mnemonic, MotionError, OperandIndex};
use arcline_planner::geometry::{Arc, ArcError, CirclePoint, Dimension, Direction, Path};

use super::moves::{self, INCREMENTAL};
use super::place;
use super::points::{self, primary, target_point, unwinds};
use crate::control::Execution;
use crate::motion::Motion;
use crate::range;
use crate::rotary::Turn;
use crate::system::{System, component};

/// Places of the operands that only MCCM has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CircleLayout {
    circle_type: usize,
    circle_point: usize,
    direction: usize,
}

/// Circle Type: a point on the circle.
const VIA: i32 = 0;
/// Circle Type: the radius.
const RADIUS: i32 = 2;
/// Circle Type: the centre, from the start point whatever the Move Type.
const CENTER_INCREMENTAL: i32 = 3;

impl CircleLayout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mccm, name);
        CircleLayout {
            circle_type: place("Circle Type"),
            circle_point: place("Via/Center/Radius"),
            direction: place("Direction"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    if motion.systems[index].description.orientation.is_some() {
        return Err(MotionError::InstructionNotSupported);
    }
    let layout = motion.layouts.mccm;
    let circle = motion.layouts.circle;
    moves::execute(motion, execution, call, &layout, 2, |motion, system, start| {
        let axes = system.description.linear().len();
        let incremental = call.word(layout.move_type) == INCREMENTAL;
        let position = primary(system, call, layout.position);
        let mut end = target_point(position, &start, incremental);
        if incremental {
            verify_turns(motion, system, position, layout.position)?;
        } else {
            points::unwind(motion, system, &start, position, &mut end, layout.position)?;
        }
        range::verify_point(system, &motion.axes, &end, layout.position)?;
        let values = primary(system, call, circle.circle_point);
        let point = |incremental: bool| {
            let mut point = target_point(values, &start, incremental);
            if !incremental {
                // Of all the turns of a rotary axis the one in which the arc is.
                for (place, unwind) in unwinds(motion, system) {
                    let middle = 0.5 * (component(&start, place) + component(&end, place));
                    point[place] = Turn::nearest(unwind, point[place], middle);
                }
            }
            point
        };
        let circle_point = match call.word(circle.circle_type) {
            VIA => CirclePoint::Via(point(incremental)),
            RADIUS => CirclePoint::Radius(values.first().copied().unwrap_or(0.0)),
            CENTER_INCREMENTAL => CirclePoint::Center(point(true)),
            _ => CirclePoint::Center(point(incremental)),
        };
        let dimension = if axes == 2 { Dimension::Two } else { Dimension::Three };
        let direction = Direction::from_word(call.word(circle.direction))
            .ok_or(MotionError::ParameterOutOfRange(OperandIndex(circle.direction as u8)))?;
        let arc = Arc::new(dimension, start, end, circle_point, direction).map_err(error)?;
        let path = Path::Arc(arc);
        range::verify_path(system, &motion.axes, &path, circle.circle_point)?;
        Ok(path)
    })
}

/// No increment moves a rotary axis by more than one turn (spec/coordinated-instructions.md §13.6).
fn verify_turns(motion: &Motion, system: &System, increments: &[f64], operand: usize) -> Result<(), MotionError> {
    let beyond = |(place, unwind): (usize, f64)| increments.get(place).is_some_and(|by| by.abs() > unwind);
    if unwinds(motion, system).any(beyond) {
        return Err(MotionError::ParameterOutOfRange(OperandIndex(operand as u8)));
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
