//! A robot: its geometry with its parameters, and the two directions of its transform
//! (spec/coordinated-instructions.md §22).
//!
//! Not here: work and tool frames, orientation ([`crate::OrientedRobot`]), whole turns of a joint. Units: lengths
//! in position units, joints in degrees (linear joints in position units) as in the axes' tags.

use crate::error::{GeometryError, KinematicsError};
use crate::number::Number;
use crate::parallel::Arms;
use crate::two_links::TwoLinks;

/// The construction of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// Two joints in a plane; the second link rotates with the first one.
    ArticulatedIndependent2,
    /// Two joints in a plane that turns with the base; the second link rotates with the first one.
    ArticulatedIndependent3,
    /// Two joints in a plane; the second link keeps its angle when the first one moves.
    ArticulatedDependent2,
    /// Two joints in a plane that turns with the base; the second link keeps its angle when the first one moves.
    ArticulatedDependent3,
    /// Two horizontal links and a vertical linear axis.
    ScaraIndependent,
    /// Two horizontal parallel arms and a vertical linear axis.
    ScaraDelta,
    /// Two parallel arms in a vertical plane.
    Delta2,
    /// Three parallel arms.
    Delta3,
}

impl Geometry {
    /// The number of joints, which is also that of the tool's coordinates.
    #[must_use]
    pub fn joints(self) -> usize {
        match self {
            Geometry::ArticulatedIndependent2 | Geometry::ArticulatedDependent2 | Geometry::Delta2 => 2,
            _ => 3,
        }
    }

    /// The joint is rotary, not linear.
    #[must_use]
    pub fn turns(self, joint: usize) -> bool {
        !(joint == 2 && matches!(self, Geometry::ScaraIndependent | Geometry::ScaraDelta))
    }

    /// The geometry has a left and a right solution.
    #[must_use]
    pub fn is_arm(self) -> bool {
        !matches!(self, Geometry::ScaraDelta | Geometry::Delta2 | Geometry::Delta3)
    }

    /// The geometry has a mirrored solution, with the first joint half a turn further.
    #[must_use]
    pub fn has_mirror(self) -> bool {
        matches!(
            self,
            Geometry::ArticulatedIndependent3 | Geometry::ArticulatedDependent3
        )
    }
}

/// The parameters of a geometry; those that it does not have are ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    /// LinkLength1 and 2, position units.
    pub link_lengths: [f64; 2],
    /// X1b, X2b, X3b, position units.
    pub base_offsets: [f64; 3],
    /// X1e, X2e, X3e, position units.
    pub end_effector_offsets: [f64; 3],
    /// Zero angle orientation of each joint, degrees: the position in the tag minus the internal angle.
    pub zero_angles: [f64; 6],
}

/// The side of the elbow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Elbow {
    /// The second link bends in the negative direction.
    Left,
    /// The second link bends in the positive direction.
    #[default]
    Right,
}

/// The solution of an arm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Arm {
    /// The side of the elbow.
    pub elbow: Elbow,
    /// The first joint points away from the tool.
    pub mirrored: bool,
}

/// A robot with valid parameters. Every function is total and takes bounded time; nothing allocates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robot {
    geometry: Geometry,
    zero: [f64; 3],
    /// The shoulder from the base's origin: out and up, or the two coordinates of a plane arm.
    shoulder: [f64; 2],
    mechanism: Mechanism,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mechanism {
    Serial {
        links: TwoLinks,
        /// Angle of the tool against the second link, radians.
        bent: f64,
        /// The second link rotates with the first one.
        independent: bool,
    },
    Parallel {
        arms: Arms,
        /// Height of the tool over the plate.
        tool: f64,
    },
}

impl Robot {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`GeometryError`], which MCT reports as ERR 61 with EXERR 9 or 10.
    pub fn new(geometry: Geometry, parameters: &Parameters) -> Result<Robot, GeometryError> {
        let [l1, l2] = parameters.link_lengths;
        let [x1b, x2b, x3b] = parameters.base_offsets;
        let [x1e, x2e, x3e] = parameters.end_effector_offsets;
        let [z1, z2, z3, ..] = parameters.zero_angles;
        if !(l1 > 0.0 && l2 > 0.0 && l1.is_finite() && l2.is_finite()) {
            return Err(GeometryError::LinkLengths);
        }
        let serial = |second: f64, bent: f64, independent: bool| Mechanism::Serial {
            links: TwoLinks { first: l1, second },
            bent,
            independent,
        };
        let (shoulder, mechanism) = match geometry {
            Geometry::ArticulatedIndependent2 | Geometry::ArticulatedIndependent3 => {
                let upright = if geometry.joints() == 2 { x2e } else { x3e };
                let second = libm::hypot(l2 + x1e, upright);
                if second <= 0.0 {
                    return Err(GeometryError::LinkLengths);
                }
                let height = if geometry.joints() == 2 { x2b } else { x3b };
                ([x1b, height], serial(second, libm::atan2(upright, l2 + x1e), true))
            }
            // The tool keeps its direction: its offsets only shift the base.
            Geometry::ArticulatedDependent2 => ([x1b + x1e, x2b + x2e], serial(l2, 0.0, false)),
            Geometry::ArticulatedDependent3 => ([x1b + x1e, x3b + x3e], serial(l2, 0.0, false)),
            Geometry::ScaraIndependent => ([0.0; 2], serial(l2, 0.0, true)),
            Geometry::ScaraDelta | Geometry::Delta2 | Geometry::Delta3 => {
                if l1 == l2 {
                    return Err(GeometryError::LinkLengths);
                }
                let apart = x1b - x1e;
                if apart.abs() > (l2 - l1).abs() || apart.abs() >= l1 + l2 {
                    return Err(GeometryError::Offsets);
                }
                let tool = match geometry {
                    Geometry::Delta3 => x3e,
                    Geometry::Delta2 => x2e,
                    _ => 0.0,
                };
                let arms = Arms::new(l1, l2, apart);
                ([0.0; 2], Mechanism::Parallel { arms, tool })
            }
        };
        Ok(Robot {
            geometry,
            zero: [z1, z2, z3],
            shoulder,
            mechanism,
        })
    }

    /// Its construction.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// The forward transform: the tool in the frame of the base. The third coordinate of a plane robot is 0.
    ///
    /// # Errors
    /// [`KinematicsError`] if a joint is outside of its range, or the arms hold no plate.
    pub fn forward<N: Number>(&self, joints: [N; 3]) -> Result<[N; 3], KinematicsError> {
        let [j1, j2, j3] = [0, 1, 2].map(|joint| self.internal(joints[joint], joint));
        let nothing = N::constant(0.0);
        let [right, up] = self.shoulder;
        let tool = match self.mechanism {
            Mechanism::Serial {
                links,
                bent,
                independent,
            } => {
                let plane = self.geometry.joints() == 2;
                let (turn, first, bend) = match self.geometry {
                    Geometry::ScaraIndependent => (nothing, j1, j2),
                    _ if plane => (nothing, j1, j2),
                    _ => (j1, j2, j3),
                };
                let second = if independent { first + bend + bent } else { bend };
                let [u, w] = links.end(first, second);
                let (u, w) = (u + right, w + up);
                match self.geometry {
                    Geometry::ScaraIndependent => [u, w, j3],
                    _ if plane => [u, w, nothing],
                    _ => {
                        let (sin, cos) = turn.sin_cos();
                        [u * cos, u * sin, w]
                    }
                }
            }
            Mechanism::Parallel { arms, tool } => match self.geometry {
                Geometry::Delta3 => {
                    let [x, y, z] = arms.plate_of_three([j1, j2, j3])?;
                    [x, y, z + tool]
                }
                Geometry::ScaraDelta => {
                    let [x, z] = arms.plate_of_two([j1, j2])?;
                    [x, -z, j3]
                }
                _ => {
                    let [x, z] = arms.plate_of_two([j1, j2])?;
                    [x, z + tool, nothing]
                }
            },
        };
        finite(tool)
    }

    /// The inverse transform: the joints for a point of the tool in the base's frame. Every rotary joint is
    /// within half a turn of its internal zero. The third joint of a plane robot is 0.
    ///
    /// # Errors
    /// [`KinematicsError`] if the point is out of reach, or a motion comes too close to a singularity.
    pub fn inverse<N: Number>(&self, point: [N; 3], arm: Arm) -> Result<[N; 3], KinematicsError> {
        let [x, y, z] = point;
        let nothing = N::constant(0.0);
        let [right, up] = self.shoulder;
        let joints = match self.mechanism {
            Mechanism::Serial {
                links,
                bent,
                independent,
            } => {
                let second = |first: N, bend: N| {
                    if independent { bend - bent } else { first + bend }
                };
                match self.geometry {
                    Geometry::ScaraIndependent => {
                        let [first, bend] = links.angles([x, y], arm.elbow, 1)?;
                        [first, bend, z]
                    }
                    _ if self.geometry.joints() == 2 => {
                        let [first, bend] = links.angles([x - right, y - up], arm.elbow, 1)?;
                        [first, second(first, bend), nothing]
                    }
                    _ => {
                        let square = x * x + y * y;
                        let reach = links.first + links.second;
                        if square.value() <= N::NEAREST_SHARE * N::NEAREST_SHARE * reach * reach {
                            return Err(KinematicsError::Origin);
                        }
                        let out = square.sqrt();
                        let (turn, out) = if arm.mirrored {
                            ((-y).atan2(-x), -out)
                        } else {
                            (y.atan2(x), out)
                        };
                        let [first, bend] = links.angles([out - right, z - up], arm.elbow, 2)?;
                        [turn, first, second(first, bend)]
                    }
                }
            }
            Mechanism::Parallel { arms, tool } => match self.geometry {
                Geometry::Delta3 => arms.three([x, y, z - tool])?,
                Geometry::ScaraDelta => {
                    let [first, second] = arms.two([x, -y])?;
                    [first, second, z]
                }
                _ => {
                    let [first, second] = arms.two([x, y - tool])?;
                    [first, second, nothing]
                }
            },
        };
        finite([0, 1, 2].map(|joint| self.shown(joints[joint], joint)))
    }

    /// The solution of joint positions. A straight arm counts as right.
    #[must_use]
    pub fn arm(&self, joints: [f64; 3]) -> Arm {
        let Mechanism::Serial {
            links,
            bent,
            independent,
        } = self.mechanism
        else {
            return Arm::default();
        };
        let [j1, j2, j3] = [0, 1, 2].map(|joint| self.internal(joints[joint], joint));
        let (first, second) = match self.geometry.has_mirror() {
            true => (j2, j3),
            false => (j1, j2),
        };
        let bend = if independent { second + bent } else { second - first };
        let (sin, _) = libm::sincos(bend);
        let [out, _] = links.end(first, first + bend);
        Arm {
            elbow: if sin < 0.0 { Elbow::Left } else { Elbow::Right },
            mirrored: self.geometry.has_mirror() && out + self.shoulder[0] < 0.0,
        }
    }

    /// The range of a joint, in positions of its tag, degrees; `None`: unlimited.
    #[must_use]
    pub fn range(&self, joint: usize) -> Option<[f64; 2]> {
        let zero = self.zero.get(joint)?;
        match self.mechanism {
            Mechanism::Parallel { arms, .. } if self.geometry.turns(joint) => {
                Some(arms.range.map(|angle| angle.to_degrees() + zero))
            }
            Mechanism::Serial { .. } if joint == 0 && self.geometry.has_mirror() => {
                Some([zero - HALF_TURN, zero + HALF_TURN])
            }
            _ => None,
        }
    }

    fn internal<N: Number>(&self, joint: N, index: usize) -> N {
        let internal = joint - self.zero[index];
        match self.geometry.turns(index) {
            true => internal * RADIANS,
            false => internal,
        }
    }

    fn shown<N: Number>(&self, joint: N, index: usize) -> N {
        let scaled = match self.geometry.turns(index) {
            true => wrapped(joint) * DEGREES,
            false => joint,
        };
        if index < self.geometry.joints() {
            scaled + self.zero[index]
        } else {
            scaled
        }
    }
}

/// An angle within half a turn of 0: above -pi up to pi.
fn wrapped<N: Number>(angle: N) -> N {
    use core::f64::consts::{PI, TAU};
    if angle.value() > PI {
        angle - TAU
    } else if angle.value() <= -PI {
        angle + TAU
    } else {
        angle
    }
}

fn finite<N: Number>(numbers: [N; 3]) -> Result<[N; 3], KinematicsError> {
    match numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(numbers),
        Some(index) => Err(KinematicsError::Reach { joint: index as u8 }),
    }
}

const DEGREES: f64 = 180.0 / core::f64::consts::PI;
const RADIANS: f64 = core::f64::consts::PI / 180.0;
/// Degrees.
const HALF_TURN: f64 = 180.0;
