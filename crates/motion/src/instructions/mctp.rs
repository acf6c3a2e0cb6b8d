//! MCTP, Motion Calculate Transform Position (spec/coordinated-instructions.md §19, §21): nothing moves.

use arcline_instruction_set::{Call, Mnemonic, MotionError, OperandIndex};
use arcline_kinematics::{Arm, Elbow, Robot};
use arcline_planner::geometry::Point;

use super::mct::{self, positions, verify_linear, verify_pair};
use super::place;
use crate::control::Execution;
use crate::material::Sent;
use crate::motion::Motion;
use crate::transforms::robot::{Joints, refused, three};

/// Places of MCTP's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    transform: mct::Layout,
    direction: usize,
    reference: usize,
    result: usize,
}

/// Transform Direction: from the target to the source.
const FORWARD: i32 = 0;
/// Transform Direction: from the source to the target, as the arm is now.
const INVERSE: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mctp, name);
        Layout {
            transform: mct::Layout::of(Mnemonic::Mctp),
            direction: place("Transform Direction"),
            reference: place("Reference Position"),
            result: place("Transform Position"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call, sent: &Sent) -> Result<(), MotionError> {
    let layout = motion.layouts.mctp;
    let source = motion.target_system(call)?;
    motion.verify_operands(call)?;
    let target = layout.transform.target(motion, call)?;
    let robot = verify_pair(motion, source, target)?;
    let [from, to] = [source, target].map(|index| motion.systems[index].description.axes.as_slice());
    let frame = layout.transform.frame(call, from.len())?;
    verify_linear(motion, from)?;
    verify_linear(motion, to)?;
    if sent.answer().is_some_and(|answer| answer.room() < from.len()) {
        return Err(MotionError::ParameterOutOfRange(OperandIndex(layout.result as u8)));
    }
    let mut reference = Point::zeros();
    for (number, given) in reference.iter_mut().zip(call.array(layout.reference)).take(from.len()) {
        *number = *given;
    }
    let direction = call.word(layout.direction);
    let point = match (robot, direction) {
        (None, FORWARD) => frame.place_back(&reference),
        (None, INVERSE) => frame.place(&reference),
        (None, _) => return Err(MotionError::TransformDirectionNotSupported),
        (Some((robot, Joints::Target)), FORWARD) => frame.place_back(&tool(&robot, &reference)?),
        (Some((robot, Joints::Target)), _) => {
            let arm = arm(&robot, direction, three(&positions(motion, to)))?;
            joints(&robot, &frame.place(&reference), arm)?
        }
        (Some((robot, Joints::Source)), FORWARD) => {
            let arm = robot.arm(three(&positions(motion, from)));
            joints(&robot, &frame.place_back(&reference), arm)?
        }
        (Some((robot, Joints::Source)), INVERSE) => frame.place(&tool(&robot, &reference)?),
        (Some((_, Joints::Source)), _) => return Err(MotionError::TransformDirectionNotSupported),
    };
    if let Some(answer) = sent.answer() {
        answer.give(&point.as_slice()[..from.len()]);
    }
    motion.done(execution);
    Ok(())
}

fn tool(robot: &Robot, joints: &Point) -> Result<Point, MotionError> {
    robot.forward((*joints).into()).map(Point::from).map_err(refused)
}

fn joints(robot: &Robot, tool: &Point, arm: Arm) -> Result<Point, MotionError> {
    robot.inverse((*tool).into(), arm).map(Point::from).map_err(refused)
}

/// The solution that a direction asks for (spec/coordinated-instructions.md §21).
fn arm(robot: &Robot, direction: i32, present: [f64; 3]) -> Result<Arm, MotionError> {
    if direction == INVERSE {
        return Ok(robot.arm(present));
    }
    let arm = Arm {
        elbow: if direction <= 3 { Elbow::Left } else { Elbow::Right },
        mirrored: direction % 2 == 1,
    };
    let geometry = robot.geometry();
    if !geometry.is_arm() || (arm.mirrored && !geometry.has_mirror()) {
        return Err(MotionError::TransformDirectionNotSupported);
    }
    Ok(arm)
}
