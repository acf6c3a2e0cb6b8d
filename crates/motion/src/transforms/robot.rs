//! The map of a transform from the positions of one side to the other: between two Cartesian frames, or to a robot's joints and back.
//!
//! A robot's joints are followed through whole turns: they stay close to their last positions, and so do the angles of an orientation
//! that follows from joints. Not here: the side that moves the other one ([`super::compute`]). Real-time: nothing allocates.
//! Units: position units, degrees of joints and of orientation, seconds.

use arcline_instruction_set::{AxisIndex, Detail, MotionError};
use arcline_kinematics::{
    Arm, Configuration, KinematicsError, OrientedRobot, Pose, Robot, Taken, Turns, end_of_arm, tool_centre,
};
use arcline_planner::geometry::{Frame, Point as Vector};
use arcline_profile::KinematicState;

use super::sides::{Positions, SideState, positions, side, vectors, wide};
use crate::call_data::Frames;
use crate::machine::{MAX_SYSTEM_AXES, three};
use crate::tolerance::CONSISTENT_UNITS;

/// The map between the two sides of a transform.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate in the tick")]
pub(crate) enum Map {
    /// Both sides are Cartesian.
    Frames(Frame),
    /// One side is a robot's joints.
    Robot(RobotMap),
}

/// The side with the robot's joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Joints {
    /// The source is Cartesian.
    Target,
    /// The target is Cartesian.
    Source,
}

/// A robot at one end of a transform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RobotMap {
    mechanism: Mechanism,
    side: Joints,
    /// The last positions of its joints, through whole turns.
    last: Positions,
}

/// The mechanism between the two sides.
#[derive(Clone, Copy, Debug)]
enum Mechanism {
    Arm { frame: Frame, robot: Robot, arm: Arm },
    Wrist(WristMap),
}

/// A robot with a wrist, behind X, Y, Z, Rx, Ry, Rz.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WristMap {
    pub(crate) robot: OrientedRobot,
    work: Pose,
    tool: Pose,
    /// IDs of the work frame and the tool frame.
    pub(crate) ids: [i32; 2],
    configuration: Configuration,
    /// The last Rx, Ry, Rz of the other side, through the ends of their ranges.
    angles: [f64; 3],
}

impl WristMap {
    /// The tool centre in the frame of the end of the arm.
    pub(crate) fn tool(&self) -> Vector {
        self.tool.position
    }

    /// The tool centre in the work frame.
    pub(crate) fn point(
        &self,
        joints: &[KinematicState; MAX_SYSTEM_AXES],
    ) -> Result<Pose<KinematicState>, KinematicsError> {
        let Taken { pose, .. } = self.robot.forward(joints)?;
        Ok(tool_centre(&self.work, &pose, &self.tool))
    }
}

impl RobotMap {
    /// `joints`: their positions, which determine the solution of the arm.
    pub(crate) fn new(frame: Frame, robot: Robot, side: Joints, joints: Positions) -> Self {
        let arm = Arm::default();
        RobotMap::at_joints(Mechanism::Arm { frame, robot, arm }, side, joints)
    }

    /// The target is a robot with a wrist; `joints` and `source` are the positions of both sides.
    ///
    /// The angles of the orientation are those of the source's axes if these agree with the robot's; otherwise the angles within their
    /// ranges.
    pub(crate) fn with_wrist(frames: &Frames, robot: OrientedRobot, joints: Positions, source: &Positions) -> Self {
        let [.., rx, ry, rz] = *source;
        let mut wrist = WristMap {
            robot,
            work: Pose::new(frames.work.coordinates),
            tool: Pose::new(frames.tool.coordinates),
            ids: [frames.work.id, frames.tool.id],
            configuration: Configuration::default(),
            angles: [rx, ry, rz],
        };
        if let Ok(point) = wrist.point(&joints.map(KinematicState::at_rest)) {
            let angles = |coordinates: [KinematicState; 6]| {
                let [.., rx, ry, rz] = coordinates.map(|at| at.position);
                [rx, ry, rz]
            };
            let near = angles(point.coordinates_near(wrist.angles));
            let apart = near.iter().zip(wrist.angles).map(|(near, now)| (near - now).abs());
            if apart.fold(0.0, f64::max) > CONSISTENT_UNITS {
                wrist.angles = angles(point.coordinates());
            }
        }
        RobotMap::at_joints(Mechanism::Wrist(wrist), Joints::Target, joints)
    }

    fn at_joints(mechanism: Mechanism, side: Joints, joints: Positions) -> Self {
        let mut map = RobotMap {
            mechanism,
            side,
            last: Positions::default(),
        };
        map.note_joints(joints);
        map
    }

    /// The robot with a wrist, if it is one.
    pub(crate) fn wrist(&self) -> Option<&WristMap> {
        match &self.mechanism {
            Mechanism::Arm { .. } => None,
            Mechanism::Wrist(wrist) => Some(wrist),
        }
    }

    /// Takes the joints of an update, so that the next ones stay on the same turns.
    pub(super) fn follow(&mut self, source: &SideState, target: &Positions) {
        match self.side {
            Joints::Target => self.last = *target,
            Joints::Source => self.note_joints(positions(source)),
        }
    }

    /// Takes the orientation of an update, so that the next one stays on the same turns.
    pub(super) fn follow_turn(&mut self, source: &SideState) {
        if let Mechanism::Wrist(wrist) = &mut self.mechanism {
            let [.., rx, ry, rz] = positions(source);
            wrist.angles = [rx, ry, rz];
        }
    }

    /// Takes over the arm solution of the joints, while all axes stand.
    pub(super) fn settle(&mut self, source: &SideState, target: &SideState) {
        match self.side {
            Joints::Target => self.note_joints(positions(target)),
            Joints::Source => self.note_joints(positions(source)),
        }
    }

    /// Takes positions of the joints, which may belong to another solution of the arm.
    pub(super) fn note_joints(&mut self, joints: Positions) {
        self.last = joints;
        match &mut self.mechanism {
            Mechanism::Arm { robot, arm, .. } => *arm = robot.arm(three(&joints)),
            Mechanism::Wrist(wrist) => wrist.configuration = wrist.robot.solution(&joints).0,
        }
    }

    /// The target side has the robot's joints.
    pub(super) fn has_robot_target(&self) -> bool {
        self.side == Joints::Target
    }

    /// Applies the transform from the source to the target, inverse or forward.
    pub(super) fn target_of(&self, source: &SideState) -> Result<SideState, MotionError> {
        match (&self.mechanism, self.side) {
            (Mechanism::Wrist(wrist), _) => self.wrist_joints(wrist, source),
            (Mechanism::Arm { frame, robot, arm }, Joints::Target) => {
                let tool = framed(source, |p| frame.transform_point(p), |d| frame.transform_vector(d));
                self.joints(robot, *arm, &tool)
            }
            (Mechanism::Arm { frame, robot, .. }, Joints::Source) => {
                let tool = tool(robot, source)?;
                Ok(framed(
                    &tool,
                    |p| frame.transform_point(p),
                    |d| frame.transform_vector(d),
                ))
            }
        }
    }

    /// Applies the opposite transform.
    pub(super) fn source_of(&self, target: &SideState) -> Result<SideState, MotionError> {
        match (&self.mechanism, self.side) {
            (Mechanism::Wrist(wrist), _) => {
                let point = wrist.point(target).map_err(refused)?;
                Ok(point.coordinates_near(wrist.angles))
            }
            (Mechanism::Arm { frame, robot, .. }, Joints::Target) => {
                let tool = tool(robot, target)?;
                Ok(framed(
                    &tool,
                    |p| frame.inverse_transform_point(p),
                    |d| frame.inverse_transform_vector(d),
                ))
            }
            (Mechanism::Arm { frame, robot, arm }, Joints::Source) => {
                let tool = framed(
                    target,
                    |p| frame.inverse_transform_point(p),
                    |d| frame.inverse_transform_vector(d),
                );
                self.joints(robot, *arm, &tool)
            }
        }
    }

    /// The joints at the start of a path, perhaps far from their present positions: a first joint with a limited range is within it there.
    pub(super) fn begin(&mut self, source: &SideState) -> Result<SideState, MotionError> {
        if let Mechanism::Arm { frame, robot, arm } = &self.mechanism
            && robot.geometry().has_mirror()
        {
            let tool = framed(source, |p| frame.transform_point(p), |d| frame.transform_vector(d));
            let joints = robot.inverse(three(&tool), *arm).map_err(refused)?;
            self.last[0] = joints[0].position;
        }
        let joints = self.target_of(source)?;
        self.follow_joints(&joints);
        Ok(joints)
    }

    /// Takes the joints of the next sample.
    pub(super) fn follow_joints(&mut self, joints: &SideState) {
        self.last = positions(joints);
    }

    /// The joint is rotary, not linear.
    pub(super) fn turns(&self, joint: usize) -> bool {
        match &self.mechanism {
            Mechanism::Arm { robot, .. } => joint < robot.geometry().joints() && robot.geometry().turns(joint),
            Mechanism::Wrist(wrist) => wrist.robot.wrist().turns(joint),
        }
    }

    /// The range of a joint, degrees; `None`: unlimited.
    pub(super) fn range(&self, joint: usize) -> Option<[f64; 2]> {
        match &self.mechanism {
            Mechanism::Arm { robot, .. } => robot.range(joint),
            Mechanism::Wrist(_) => None,
        }
    }

    /// The same tool point can also be reached with the first joint half a turn further.
    pub(super) fn has_mirror(&self) -> bool {
        matches!(&self.mechanism, Mechanism::Arm { robot, .. } if robot.geometry().has_mirror())
    }

    fn joints(&self, robot: &Robot, arm: Arm, tool: &SideState) -> Result<SideState, MotionError> {
        let joints = robot.inverse(three(tool), arm).map_err(refused)?;
        let joints = self.near(wide(joints));
        if robot.geometry().has_mirror()
            && let Some([least, most]) = robot.range(0)
            && !(least..=most).contains(&joints[0].position)
        {
            return Err(MotionError::MaxJointAngleExceeded(AxisIndex(0)));
        }
        Ok(joints)
    }

    fn wrist_joints(&self, wrist: &WristMap, source: &SideState) -> Result<SideState, MotionError> {
        let centre = Pose::new(*source);
        let end = end_of_arm(&wrist.work, &centre, &wrist.tool);
        let joints = wrist.robot.inverse(&end, wrist.configuration, Turns::default());
        Ok(self.near(joints.map_err(refused)?))
    }

    /// The joints on the turns closest to their last positions.
    pub(super) fn near(&self, mut joints: SideState) -> SideState {
        for (index, joint) in joints.iter_mut().enumerate().filter(|(index, _)| self.turns(*index)) {
            joint.position += TURN_DEG * ((self.last[index] - joint.position) / TURN_DEG).round();
        }
        joints
    }
}

fn tool(robot: &Robot, joints: &SideState) -> Result<SideState, MotionError> {
    let tool = robot.forward(three(joints)).map_err(refused)?;
    Ok(wide(tool))
}

/// Converts the motion of a side to the frame at the other end.
fn framed(side: &SideState, point: impl Fn(&Vector) -> Vector, vector: impl Fn(&Vector) -> Vector) -> SideState {
    let [position, velocity, acceleration] = vectors(side);
    self::side([point(&position), vector(&velocity), vector(&acceleration)])
}

/// The motion error of a position that a robot cannot reach (spec/coordinated-instructions.md §19.8).
pub(crate) fn refused(error: KinematicsError) -> MotionError {
    match error {
        KinematicsError::Reach { joint } | KinematicsError::Orientation { angle: joint } => {
            MotionError::InvalidTransformPosition(Detail(joint as i8))
        }
        KinematicsError::Origin => MotionError::TransformAtOrigin,
    }
}

/// Degrees.
const TURN_DEG: f64 = 360.0;
