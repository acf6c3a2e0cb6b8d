//! MCTO, Motion Coordinated Transform with Orientation (spec/coordinated-instructions.md §19, §24), and the checks that it shares with
//! MCTPO.

use arcline_instruction_set::operands::{Mcto, OperandValue};
use arcline_instruction_set::{Call, Detail, MotionError, OperandIndex, Range, SystemId};
use arcline_kinematics::{GeometryError, OrientedRobot};
use arcline_planner::geometry::Point;

use super::mct::{self, positions, refused};
use crate::axes::share;
use crate::call_data::{Frames, ReceivedData};
use crate::execution::Execution;
use crate::motion::Motion;
use crate::range;
use crate::transforms::robot::RobotMap;
use crate::transforms::transform::{Map, Transform};

/// The Cartesian system, the robot's system, and the robot.
///
/// # Errors
/// 61: the two cannot be linked (spec/coordinated-instructions.md §19.6, §24).
pub(super) fn pair(
    motion: &Motion,
    call: &Call,
    robot_system: &OperandValue<Option<SystemId>>,
) -> Result<(SystemId, SystemId, OrientedRobot), MotionError> {
    let source = motion.target_system(call)?;
    let target = motion.system_of(robot_system)?;
    if source == target {
        return Err(refused(mct::SAME_SYSTEM));
    }
    let [from, to] = [source, target].map(|index| &motion.systems[index]);
    if from.description.orientation.is_none() {
        return Err(refused(mct::WRONG_SOURCE));
    }
    let Some(robot) = to.wrist else {
        return Err(refused(mct::WRONG_TARGET));
    };
    if share(&from.description.axes, &to.description.axes) {
        return Err(refused(mct::AXIS_IN_BOTH));
    }
    match robot {
        Ok(robot) => Ok((source, target, robot)),
        Err(GeometryError::LinkLengths) => Err(refused(mct::LINK_LENGTHS)),
        Err(GeometryError::Offsets) => Err(refused(mct::OFFSETS)),
    }
}

/// Checks that the numbers are finite and the angles within their ranges (spec/coordinated-instructions.md §22.8). EXERR of error 74 is the
/// angle: those of the work frame from 0, those of the tool frame from 3.
pub(super) fn verify_frames([work, tool]: [OperandIndex; 2], frames: &Frames) -> Result<(), MotionError> {
    let both = [(work, &frames.work, 0), (tool, &frames.tool, 3)];
    for (operand, frame, _) in both {
        if !frame.coordinates.iter().all(|number| Range::Any.holds(*number)) {
            return Err(MotionError::ParameterOutOfRange(operand));
        }
    }
    for (_, frame, first) in both {
        let [.., rx, ry, rz] = frame.coordinates;
        let turn = |angle: f64| angle > -180.0 && angle <= 180.0;
        let held = [turn(rx), ry.abs() <= 90.0, turn(rz)];
        if let Some(index) = held.iter().position(|held| !held) {
            return Err(MotionError::InvalidOrientationAngle(Detail(first + index as i8)));
        }
    }
    Ok(())
}

pub(super) fn execute(
    motion: &mut Motion,
    execution: Execution,
    call: &Call,
    data: &ReceivedData,
) -> Result<(), MotionError> {
    motion.target_system(call)?;
    let Mcto {
        robot_system,
        work_frame,
        tool_frame,
    } = motion.operands(call)?;
    let frames = data.frames()?;
    let (source, target, robot) = pair(motion, call, &robot_system)?;
    mct::verify_free(motion, target)?;
    verify_frames([work_frame.index, tool_frame.index], frames)?;
    for (frame, operand) in [(&frames.work, work_frame.index), (&frames.tool, tool_frame.index)] {
        let [x, y, z, ..] = frame.coordinates;
        range::verify_point(&motion.systems[source], &motion.axes, &Point::new(x, y, z), operand)?;
    }
    let [from, to] = [source, target].map(|index| &motion.systems[index].description.axes);
    let map = RobotMap::with_wrist(frames, robot, positions(motion, to), &positions(motion, from));
    let transform = Transform::new(Some(execution), source, Map::Robot(map), from, to);
    mct::begin(motion, execution, target, transform)
}
