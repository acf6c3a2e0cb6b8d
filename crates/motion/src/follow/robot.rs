//! What a transform makes of positions: one Cartesian frame seen from another, and with a robot the joints behind it.
//!
//! A robot's joints are followed through whole turns: they stay near what they were before. Not here: who leads whom
//! ([`super::transform`]). Real-time: nothing allocates. Units: position units, degrees of joints, seconds.

use arcline_drive::Motion as Point;
use arcline_instruction_set::{AxisIndex, Detail, MotionError};
use arcline_kinematics::{Arm, KinematicsError, Moving, Robot};
use arcline_planner::geometry::{Frame, Point as Vector};

use super::transform::Side;
use crate::machine::MAX_PRIMARY_AXES;

/// How the two sides of a transform lie to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Map {
    /// Both are Cartesian.
    Frames(Frame),
    /// One is a robot's joints.
    Robot(RobotMap),
}

/// Which side is the robot's.
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
    frame: Frame,
    robot: Robot,
    side: Joints,
    arm: Arm,
    /// Where its joints were last, to follow them through whole turns.
    last: Vector,
}

impl RobotMap {
    /// `joints`: where they are; which solution of the arm that is, is kept.
    pub(crate) fn new(frame: Frame, robot: Robot, side: Joints, joints: Vector) -> Self {
        let mut map = RobotMap {
            frame,
            robot,
            side,
            arm: Arm::default(),
            last: Vector::zeros(),
        };
        map.stand(joints);
        map
    }

    /// The update's joints, so that the next ones stay in the same turns.
    pub(super) fn follow(&mut self, source: &Side, target: &Vector) {
        match self.side {
            Joints::Target => self.last = *target,
            Joints::Source => self.stand(vectors(source)[0]),
        }
    }

    /// Everything stands: the arm is in the solution in which its joints are.
    pub(super) fn settle(&mut self, source: &Side, target: &Side) {
        match self.side {
            Joints::Target => self.stand(vectors(target)[0]),
            Joints::Source => self.stand(vectors(source)[0]),
        }
    }

    /// The joints are somewhere, perhaps in another solution of the arm.
    pub(super) fn stand(&mut self, joints: Vector) {
        self.arm = self.robot.arm(joints.into());
        self.last = joints;
    }

    /// Whether the joints are the target's.
    pub(super) fn leads_joints(&self) -> bool {
        self.side == Joints::Target
    }

    /// The inverse or forward transform, whichever leads from the source to the target.
    pub(super) fn place(&self, source: &Side) -> Result<Side, MotionError> {
        match self.side {
            Joints::Target => self.joints(&framed(source, |p| self.frame.place(p), |d| self.frame.turn(d))),
            Joints::Source => {
                let tool = self.tool(source)?;
                Ok(framed(&tool, |p| self.frame.place(p), |d| self.frame.turn(d)))
            }
        }
    }

    /// The other one.
    pub(super) fn place_back(&self, target: &Side) -> Result<Side, MotionError> {
        match self.side {
            Joints::Target => {
                let tool = self.tool(target)?;
                Ok(framed(&tool, |p| self.frame.place_back(p), |d| self.frame.turn_back(d)))
            }
            Joints::Source => self.joints(&framed(
                target,
                |p| self.frame.place_back(p),
                |d| self.frame.turn_back(d),
            )),
        }
    }

    /// Where a path begins, perhaps far from here: a first joint that cannot turn on is within its range there.
    pub(super) fn begin(&mut self, source: &Side) -> Result<Side, MotionError> {
        if self.robot.geometry().has_mirror() {
            let tool = framed(source, |p| self.frame.place(p), |d| self.frame.turn(d));
            let joints = self.robot.inverse(tool.map(moving), self.arm).map_err(refused)?;
            self.last[0] = joints[0].position;
        }
        let joints = self.place(source)?;
        self.follow_joints(&joints);
        Ok(joints)
    }

    /// The joints were led on.
    pub(super) fn follow_joints(&mut self, joints: &Side) {
        self.last = vectors(joints)[0];
    }

    /// Whether a joint turns, and does not slide.
    pub(super) fn turns(&self, joint: usize) -> bool {
        self.robot.geometry().turns(joint)
    }

    fn tool(&self, joints: &Side) -> Result<Side, MotionError> {
        let tool = self.robot.forward(joints.map(moving)).map_err(refused)?;
        Ok(tool.map(point))
    }

    fn joints(&self, tool: &Side) -> Result<Side, MotionError> {
        let joints = self.robot.inverse(tool.map(moving), self.arm).map_err(refused)?;
        Ok(self.near(joints)?.map(point))
    }

    /// In the turns in which they were last.
    fn near(&self, mut joints: [Moving; MAX_PRIMARY_AXES]) -> Result<[Moving; MAX_PRIMARY_AXES], MotionError> {
        for (place, joint) in joints.iter_mut().enumerate() {
            if self.robot.geometry().turns(place) && place < self.robot.geometry().joints() {
                joint.position += TURN * ((self.last[place] - joint.position) / TURN).round();
            }
        }
        if self.robot.geometry().has_mirror()
            && let Some([least, most]) = self.robot.range(0)
            && !(least..=most).contains(&joints[0].position)
        {
            return Err(MotionError::MaxJointAngleExceeded(AxisIndex(0)));
        }
        Ok(joints)
    }
}

/// Where a side is in the frame at the other end.
fn framed(side: &Side, place: impl Fn(&Vector) -> Vector, turn: impl Fn(&Vector) -> Vector) -> Side {
    let [position, velocity, acceleration] = vectors(side);
    self::side([place(&position), turn(&velocity), turn(&acceleration)])
}

/// What instructions, and transforms under way, tell of it (§19.8).
pub(crate) fn refused(error: KinematicsError) -> MotionError {
    match error {
        KinematicsError::Reach { joint } | KinematicsError::Orientation { angle: joint } => {
            MotionError::InvalidTransformPosition(Detail(joint as i8))
        }
        KinematicsError::Origin => MotionError::TransformAtOrigin,
    }
}

fn moving(at: Point) -> Moving {
    Moving {
        position: at.position,
        velocity: at.velocity,
        acceleration: at.acceleration,
    }
}

fn point(at: Moving) -> Point {
    Point {
        position: at.position,
        velocity: at.velocity,
        acceleration: at.acceleration,
    }
}

pub(super) fn vectors(side: &Side) -> [Vector; 3] {
    let mut vectors = [Vector::zeros(); 3];
    for (place, point) in side.iter().enumerate() {
        vectors[0][place] = point.position;
        vectors[1][place] = point.velocity;
        vectors[2][place] = point.acceleration;
    }
    vectors
}

pub(super) fn side([position, velocity, acceleration]: [Vector; 3]) -> Side {
    let mut side = Side::default();
    for (place, point) in side.iter_mut().enumerate() {
        *point = Point {
            position: position[place],
            velocity: velocity[place],
            acceleration: acceleration[place],
        };
    }
    side
}

/// Degrees.
const TURN: f64 = 360.0;
