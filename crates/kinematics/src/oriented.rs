//! Robots with a wrist: deltas that rotate and tilt their tool, a SCARA that rotates it, and the arm of six axes
//! (spec/coordinated-instructions.md §22.8).
//!
//! The arm in front of the wrist is a [`Robot`]. Not here: work and tool frames ([`crate::end_of_arm`]). Units: position
//! units, degrees.

use nalgebra::Matrix3;

use crate::error::{GeometryError, KinematicsError};
use crate::number::Number;
use crate::pose::{DEGREES, Pose, product, turn_x, turn_y, turn_z};
use crate::robot::{Arm, Elbow, Geometry, Parameters, Robot};
use crate::tolerance::{NEAREST_AT_REST_SHARE, OFF_ANGLE_SINE, OFF_PLANE_UNITS};

/// The construction of a robot with a wrist, by the names of its joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrist {
    /// A delta of two arms and J6, which rotates the tool.
    DeltaJ1J2J6,
    /// A delta of three arms and J6.
    DeltaJ1J2J3J6,
    /// A delta of three arms, J4, which rotates a swing arm, and J5, which tilts it.
    DeltaJ1J2J3J4J5,
    /// An independent SCARA and J6.
    ScaraJ1J2J3J6,
    /// An independent articulated arm and three axes through one point: J4 along the second link, J5 across it, J6 along the
    /// tool. At internal 0 they all lie along X1. X1e is the distance from that point to the end of the arm, X3e the height of the second link
    /// above its joint.
    ArticulatedJ1J2J3J4J5J6,
}

impl Wrist {
    /// The number of joints.
    #[must_use]
    pub fn joints(self) -> usize {
        match self {
            Wrist::DeltaJ1J2J6 => 3,
            Wrist::DeltaJ1J2J3J6 | Wrist::ScaraJ1J2J3J6 => 4,
            Wrist::DeltaJ1J2J3J4J5 => 5,
            Wrist::ArticulatedJ1J2J3J4J5J6 => 6,
        }
    }

    /// Its Coordinate Definition (spec/axis-and-data-types.md §9.6).
    #[must_use]
    pub const fn definition(self) -> &'static str {
        match self {
            Wrist::DeltaJ1J2J6 => "J1J2J6",
            Wrist::DeltaJ1J2J3J6 | Wrist::ScaraJ1J2J3J6 => "J1J2J3J6",
            Wrist::DeltaJ1J2J3J4J5 => "J1J2J3J4J5",
            Wrist::ArticulatedJ1J2J3J4J5J6 => "J1J2J3J4J5J6",
        }
    }

    fn arm(self) -> Geometry {
        match self {
            Wrist::DeltaJ1J2J6 => Geometry::Delta2,
            Wrist::DeltaJ1J2J3J6 | Wrist::DeltaJ1J2J3J4J5 => Geometry::Delta3,
            Wrist::ScaraJ1J2J3J6 => Geometry::ScaraIndependent,
            Wrist::ArticulatedJ1J2J3J4J5J6 => Geometry::ArticulatedIndependent3,
        }
    }

    /// The joint is rotary, not linear.
    #[must_use]
    pub fn turns(self, joint: usize) -> bool {
        joint < self.joints() && !(self == Wrist::ScaraJ1J2J3J6 && joint == 2)
    }

    /// The robot has a solution with that configuration.
    #[must_use]
    pub fn has(self, configuration: Configuration) -> bool {
        let Configuration { lefty, below, flip } = configuration;
        match self {
            Wrist::DeltaJ1J2J6 | Wrist::DeltaJ1J2J3J6 | Wrist::DeltaJ1J2J3J4J5 => !lefty && !below && !flip,
            Wrist::ScaraJ1J2J3J6 => !below && !flip,
            Wrist::ArticulatedJ1J2J3J4J5J6 => true,
        }
    }

    /// All counted turns are of joints that the robot has.
    #[must_use]
    pub fn counts(self, turns: Turns) -> bool {
        let mut counted = turns.iter().zip(self.counted());
        counted.all(|(turns, index)| *turns == 0 || index.is_some())
    }

    /// The joint index of each turns counter: J1, J4, J6.
    fn counted(self) -> [Option<usize>; 3] {
        match self {
            Wrist::DeltaJ1J2J6 => [None, None, Some(2)],
            Wrist::DeltaJ1J2J3J6 => [None, None, Some(3)],
            Wrist::ScaraJ1J2J3J6 => [Some(0), None, Some(3)],
            Wrist::DeltaJ1J2J3J4J5 => [None, Some(3), None],
            Wrist::ArticulatedJ1J2J3J4J5J6 => [Some(0), Some(3), Some(5)],
        }
    }
}

/// The solution, as the bits of RobotConfiguration. A delta has one: 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Configuration {
    /// Bit 1: a SCARA's elbow is on the left; the base of an articulated arm points away from the wrist.
    pub lefty: bool,
    /// Bit 2: the elbow of an articulated arm is below the line from shoulder to wrist.
    pub below: bool,
    /// Bit 3: J5 of an articulated arm is negative.
    pub flip: bool,
}

impl Configuration {
    /// The bits.
    #[must_use]
    pub fn bits(self) -> i32 {
        i32::from(self.lefty) << 1 | i32::from(self.below) << 2 | i32::from(self.flip) << 3
    }

    /// The configuration of bits; the other bits are ignored.
    #[must_use]
    pub fn from_bits(bits: i32) -> Self {
        Configuration {
            lefty: bits & 2 != 0,
            below: bits & 4 != 0,
            flip: bits & 8 != 0,
        }
    }
}

/// Whole turns of J1, J4 and J6, beyond half a turn in either direction.
pub type Turns = [i16; 3];

/// The end of the arm for positions of the joints, with their solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken<N: Number = f64> {
    /// The end of the arm in the frame of the base.
    pub pose: Pose<N>,
    /// The solution.
    pub configuration: Configuration,
    /// The turns.
    pub turns: Turns,
}

/// A robot with a wrist and valid parameters. Total, bounded, without allocation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedRobot {
    wrist: Wrist,
    arm: Robot,
    zero: [f64; 6],
    /// Distance from the point of the wrist to the end of the arm, along the tool.
    tool: f64,
}

impl OrientedRobot {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`GeometryError`], as for a [`Robot`].
    pub fn new(wrist: Wrist, parameters: &Parameters) -> Result<OrientedRobot, GeometryError> {
        let mut arm = *parameters;
        arm.zero_angles = [0.0; 6];
        let mut tool = 0.0;
        if wrist == Wrist::ArticulatedJ1J2J3J4J5J6 {
            tool = std::mem::take(&mut arm.end_effector_offsets[0]);
        }
        // With two arms X3 is the height, which is X2 in the plane of the arms.
        if wrist == Wrist::DeltaJ1J2J6 {
            arm.end_effector_offsets[1] = arm.end_effector_offsets[2];
        }
        Ok(OrientedRobot {
            wrist,
            arm: Robot::new(wrist.arm(), &arm)?,
            zero: parameters.zero_angles,
            tool,
        })
    }

    /// Its construction.
    #[must_use]
    pub fn wrist(&self) -> Wrist {
        self.wrist
    }

    /// The end of the arm. Joints that the robot does not have are ignored.
    ///
    /// # Errors
    /// [`KinematicsError`] if a joint is outside of its range, or the arms hold no plate.
    pub fn forward<N: Number>(&self, joints: &[N; 6]) -> Result<Taken<N>, KinematicsError> {
        let mut internal = *joints;
        for (joint, zero) in internal.iter_mut().zip(self.zero) {
            *joint = *joint - zero;
        }
        let [j1, j2, j3, j4, j5, j6] = internal;
        let nothing = N::constant(0.0);
        let (position, rotation) = match self.wrist {
            Wrist::DeltaJ1J2J6 => {
                let [x, z, _] = self.arm.forward([j1, j2, nothing])?;
                ([x, nothing, z], product(&turn_z(j3), &down()))
            }
            Wrist::DeltaJ1J2J3J6 => (self.arm.forward([j1, j2, j3])?, product(&turn_z(j4), &down())),
            Wrist::DeltaJ1J2J3J4J5 => (
                self.arm.forward([j1, j2, j3])?,
                product(&product(&turn_z(-j4), &turn_y(-j5)), &down()),
            ),
            Wrist::ScaraJ1J2J3J6 => {
                let turn = turn_z(j1 + j2 + j4);
                (self.arm.forward([j1, j2, j3])?, product(&turn, &down()))
            }
            Wrist::ArticulatedJ1J2J3J4J5J6 => {
                let hand = product(&product(&turn_x(j4), &turn_y(-j5)), &turn_x(j6));
                let rotation = product(&product(&forearm(j1, j2 + j3), &hand), &along_tool());
                let wrist = self.arm.forward([j1, j2, j3])?;
                let end = [0, 1, 2].map(|row| wrist[row] + rotation[(row, 2)] * self.tool);
                (end, rotation)
            }
        };
        let (configuration, turns) = self.solution(&joints.map(N::value));
        let taken = Taken {
            pose: Pose {
                position: position.into(),
                rotation,
            },
            configuration,
            turns,
        };
        let finite = position.iter().chain(rotation.iter()).all(|part| part.is_finite());
        finite.then_some(taken).ok_or(KinematicsError::Reach { joint: 0 })
    }

    /// The configuration and the turns of joint positions.
    #[must_use]
    pub fn solution(&self, joints: &[f64; 6]) -> (Configuration, Turns) {
        let mut internal = *joints;
        for (joint, zero) in internal.iter_mut().zip(self.zero) {
            *joint -= zero;
        }
        let [j1, j2, j3, _, j5, _] = internal;
        let arm = self.arm.arm([j1, j2, j3]);
        let configuration = match self.wrist {
            Wrist::DeltaJ1J2J6 | Wrist::DeltaJ1J2J3J6 | Wrist::DeltaJ1J2J3J4J5 => Configuration::default(),
            Wrist::ScaraJ1J2J3J6 => Configuration {
                lefty: arm.elbow == Elbow::Left,
                ..Configuration::default()
            },
            Wrist::ArticulatedJ1J2J3J4J5J6 => Configuration {
                lefty: arm.mirrored,
                below: arm.elbow == Elbow::Right,
                flip: wrapped(j5) < 0.0,
            },
        };
        let turns = self.wrist.counted().map(|index| {
            let joint = index.map_or(0.0, |index| internal[index]);
            ((joint - wrapped(joint)) / TURN_DEG).round() as i16
        });
        (configuration, turns)
    }

    /// The joints for a pose of the end of the arm. Joints that the robot does not have are 0.
    ///
    /// # Errors
    /// [`KinematicsError`] if the pose is out of reach, if the robot cannot take its orientation, or if a motion comes too close to a
    /// singularity.
    pub fn inverse<N: Number>(
        &self,
        pose: &Pose<N>,
        configuration: Configuration,
        turns: Turns,
    ) -> Result<[N; 6], KinematicsError> {
        let m = &pose.rotation;
        let p = &pose.position;
        let nothing = N::constant(0.0);
        let elbow = |right: bool| if right { Elbow::Right } else { Elbow::Left };
        let mut joints = match self.wrist {
            Wrist::DeltaJ1J2J6 => {
                if p.y.value().abs() > OFF_PLANE_UNITS {
                    return Err(KinematicsError::Orientation { angle: 1 });
                }
                let [j1, j2, _] = self.arm.inverse([p.x, p.z, nothing], Arm::default())?;
                [j1, j2, downwards(m)?, nothing, nothing, nothing]
            }
            Wrist::DeltaJ1J2J3J6 => {
                let [j1, j2, j3] = self.arm.inverse((*p).into(), Arm::default())?;
                [j1, j2, j3, downwards(m)?, nothing, nothing]
            }
            Wrist::DeltaJ1J2J3J4J5 => {
                let [j1, j2, j3] = self.arm.inverse((*p).into(), Arm::default())?;
                let turned = product(m, &down());
                if turned[(2, 1)].value().abs() > OFF_ANGLE_SINE {
                    return Err(KinematicsError::Orientation { angle: 3 });
                }
                let j4 = -degrees(-turned[(0, 1)], turned[(1, 1)]);
                let j5 = -degrees(-turned[(2, 0)], turned[(2, 2)]);
                [j1, j2, j3, j4, j5, nothing]
            }
            Wrist::ScaraJ1J2J3J6 => {
                let arm = Arm {
                    elbow: elbow(!configuration.lefty),
                    mirrored: false,
                };
                let [j1, j2, j3] = self.arm.inverse((*p).into(), arm)?;
                [j1, j2, j3, wrapped(downwards(m)? - j1 - j2), nothing, nothing]
            }
            Wrist::ArticulatedJ1J2J3J4J5J6 => {
                let arm = Arm {
                    elbow: elbow(configuration.below),
                    mirrored: configuration.lefty,
                };
                let wrist = [0, 1, 2].map(|row| p[row] - m[(row, 2)] * self.tool);
                let [j1, j2, j3] = self.arm.inverse(wrist, arm)?;
                let end = product(m, &along_tool::<N>().transpose());
                let hand = product(&forearm(j1, j2 + j3).transpose(), &end);
                let [j4, j5, j6] = hand_joints(&hand, configuration.flip)?;
                [j1, j2, j3, j4, j5, j6]
            }
        };
        for (counter, index) in turns.into_iter().zip(self.wrist.counted()) {
            if let Some(joint) = index.and_then(|index| joints.get_mut(index)) {
                *joint = wrapped(*joint) + TURN_DEG * f64::from(counter);
            }
        }
        for (joint, zero) in joints.iter_mut().zip(self.zero).take(self.wrist.joints()) {
            *joint = *joint + zero;
        }
        match joints.iter().position(|joint| !joint.is_finite()) {
            None => Ok(joints),
            Some(index) => Err(KinematicsError::Reach { joint: index as u8 }),
        }
    }
}

/// The rotation of the forearm against the base.
fn forearm<N: Number>(base: N, lift: N) -> Matrix3<N> {
    product(&turn_z(base), &turn_y(-lift))
}

/// J4, J5, J6 of `Rx(J4) * Ry(-J5) * Rx(J6)`. If J5 is 0 at rest, J4 is 0, too.
fn hand_joints<N: Number>(m: &Matrix3<N>, flip: bool) -> Result<[N; 3], KinematicsError> {
    let square = m[(1, 0)] * m[(1, 0)] + m[(2, 0)] * m[(2, 0)];
    if square.value() < N::NEAREST_SHARE * N::NEAREST_SHARE {
        if N::NEAREST_SHARE > NEAREST_AT_REST_SHARE {
            return Err(KinematicsError::Origin);
        }
        let straight = if m[(0, 0)].value() < 0.0 { 180.0 } else { 0.0 };
        let rest = degrees(m[(2, 1)], m[(1, 1)]);
        return Ok([N::constant(0.0), N::constant(straight), rest]);
    }
    let bend = square.sqrt();
    let sign = if flip { -1.0 } else { 1.0 };
    Ok([
        degrees(m[(1, 0)] * -sign, m[(2, 0)] * sign),
        degrees(bend * sign, m[(0, 0)]),
        degrees(m[(0, 1)] * -sign, m[(0, 2)] * -sign),
    ])
}

/// Rz of a tool that points straight down.
fn downwards<N: Number>(m: &Matrix3<N>) -> Result<N, KinematicsError> {
    let [rolled, tilted, up] = [m[(2, 1)], m[(2, 0)], m[(2, 2)]].map(N::value);
    if libm::hypot(tilted, rolled) > OFF_ANGLE_SINE || up > 0.0 {
        let angle = if tilted.abs() > OFF_ANGLE_SINE { 4 } else { 3 };
        return Err(KinematicsError::Orientation { angle });
    }
    Ok(degrees(m[(1, 0)], m[(0, 0)]))
}

/// The orientation of a delta's or SCARA's tool, which points down: Rx is 180.
fn down<N: Number>() -> Matrix3<N> {
    turn_x(N::constant(180.0))
}

/// The end of an articulated arm has its Z along the tool, which is X1 at internal 0.
fn along_tool<N: Number>() -> Matrix3<N> {
    turn_y(N::constant(90.0))
}

fn degrees<N: Number>(sin: N, cos: N) -> N {
    sin.atan2(cos) * DEGREES
}

/// The angle within half a turn: above -180 up to 180.
fn wrapped<N: Number>(angle: N) -> N {
    let turned = angle - TURN_DEG * (angle.value() / TURN_DEG).round();
    if turned.value() <= -0.5 * TURN_DEG {
        turned + TURN_DEG
    } else {
        turned
    }
}

/// Degrees.
const TURN_DEG: f64 = 360.0;
