//! MCCM, Motion Coordinated Circular Move (spec/coordinated-instructions.md §13, the MCCM seed).

use arcline_instruction_set::{Call, Mnemonic, MotionError};
use arcline_planner::geometry::{Arc, ArcError, CirclePoint, Dimension, Direction, Path};

use super::moves::{self, INCREMENTAL, target_point};
use super::place;
use crate::control::Execution;
use crate::motion::Motion;

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
    let layout = motion.layouts.mccm;
    let circle = motion.layouts.circle;
    moves::execute(motion, execution, call, &layout, 2, |motion, system, start| {
        let rotary = |axis: &u16| {
            motion
                .axes
                .get(usize::from(*axis))
                .is_some_and(|axis| axis.unwind.is_some())
        };
        if system.description.axes.iter().any(rotary) {
            return Err(MotionError::FeatureNotSupported);
        }
        let axes = system.description.axes.len();
        let primary = |operand: usize| {
            let values = call.array(operand);
            &values[..axes.min(values.len())]
        };
        let incremental = call.word(layout.move_type) == INCREMENTAL;
        let end = target_point(primary(layout.position), &start, incremental);
        let values = primary(circle.circle_point);
        let circle_point = match call.word(circle.circle_type) {
            VIA => CirclePoint::Via(target_point(values, &start, incremental)),
            RADIUS => CirclePoint::Radius(values.first().copied().unwrap_or(0.0)),
            CENTER_INCREMENTAL => CirclePoint::Center(target_point(values, &start, true)),
            _ => CirclePoint::Center(target_point(values, &start, incremental)),
        };
        let dimension = if axes == 2 { Dimension::Two } else { Dimension::Three };
        let direction = Direction::from_word(call.word(circle.direction)).ok_or(MotionError::ParameterOutOfRange(
            arcline_instruction_set::OperandIndex(circle.direction as u8),
        ))?;
        let arc = Arc::new(dimension, start, end, circle_point, direction).map_err(error)?;
        Ok(Path::Arc(arc))
    })
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
