//! MCTP, Motion Calculate Transform Position (spec/coordinated-instructions.md §19, §21): moves no axis.

use arcline_instruction_set::enumerations::TransformDirection;
use arcline_instruction_set::operands::Mctp;
use arcline_instruction_set::{Call, MotionError};
use arcline_kinematics::{Arm, Elbow, Robot};
use arcline_planner::geometry::Point;

use super::mct::{frame, positions, verify_linear, verify_pair};
use crate::call_data::ReceivedData;
use crate::execution::Execution;
use crate::machine::three;
use crate::motion::Motion;
use crate::transforms::robot::{Joints, refused};

pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    let source = motion.target_system(call)?;
    let Mctp {
        target_system,
        orientation,
        translation,
        transform_direction,
        reference_position,
        transform_position,
    } = motion.operands(call)?;
    let target = motion.system_of(&target_system)?;
    let robot = verify_pair(motion, source, target)?;
    let [from, to] = [source, target].map(|index| motion.systems[index].description.axes.as_slice());
    let frame = frame(&orientation, &translation, from.len())?;
    verify_linear(motion, from)?;
    verify_linear(motion, to)?;
    if data.results().is_some_and(|results| results.elements() < from.len()) {
        return Err(transform_position.out_of_range());
    }
    let mut reference = Point::zeros();
    for (number, given) in reference.iter_mut().zip(reference_position.as_slice()).take(from.len()) {
        *number = *given;
    }
    let direction = *transform_direction;
    let point = match (robot, direction) {
        (None, TransformDirection::Forward) => frame.inverse_transform_point(&reference),
        (None, TransformDirection::Inverse) => frame.transform_point(&reference),
        (None, _) => return Err(MotionError::TransformDirectionNotSupported),
        (Some((robot, Joints::Target)), TransformDirection::Forward) => {
            frame.inverse_transform_point(&tool(&robot, &reference)?)
        }
        (Some((robot, Joints::Target)), _) => {
            let arm = arm(&robot, direction, three(&positions(motion, to)))?;
            joints(&robot, &frame.transform_point(&reference), arm)?
        }
        (Some((robot, Joints::Source)), TransformDirection::Forward) => {
            let arm = robot.arm(three(&positions(motion, from)));
            joints(&robot, &frame.inverse_transform_point(&reference), arm)?
        }
        (Some((robot, Joints::Source)), TransformDirection::Inverse) => {
            frame.transform_point(&tool(&robot, &reference)?)
        }
        (Some((_, Joints::Source)), _) => return Err(MotionError::TransformDirectionNotSupported),
    };
    if let Some(results) = data.results() {
        results.set(&point.as_slice()[..from.len()]);
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

/// The arm solution for a transform direction (spec/coordinated-instructions.md §21).
fn arm(robot: &Robot, direction: TransformDirection, present: [f64; 3]) -> Result<Arm, MotionError> {
    let (elbow, mirrored) = match direction {
        TransformDirection::Forward | TransformDirection::Inverse => return Ok(robot.arm(present)),
        TransformDirection::InverseLeftArm => (Elbow::Left, false),
        TransformDirection::InverseLeftArmMirror => (Elbow::Left, true),
        TransformDirection::InverseRightArm => (Elbow::Right, false),
        TransformDirection::InverseRightArmMirror => (Elbow::Right, true),
    };
    let arm = Arm { elbow, mirrored };
    let geometry = robot.geometry();
    if !geometry.is_arm() || (arm.mirrored && !geometry.has_mirror()) {
        return Err(MotionError::TransformDirectionNotSupported);
    }
    Ok(arm)
}
