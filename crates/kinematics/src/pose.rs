//! A position with an orientation, and frames of tools and work pieces (spec/coordinated-instructions.md §22.8).
//!
//! Not here: the poses that a robot can take. Units: position units, degrees.

use nalgebra::{Matrix3, Vector3};

use crate::number::Number;
use crate::tolerance::{HALF_TURN_DEG, UPRIGHT_COSINE};

/// A position and an orientation; with [`arcline_profile::KinematicState`] also their derivatives by time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<N: Number = f64> {
    /// Its origin, position units.
    pub position: Vector3<N>,
    /// Its axes, as columns.
    pub rotation: Matrix3<N>,
}

impl Pose {
    /// The identity: at the origin, not rotated.
    #[must_use]
    pub fn identity() -> Pose {
        Pose {
            position: Vector3::zeros(),
            rotation: Matrix3::identity(),
        }
    }

    /// The pose as a constant: its numbers have derivatives of 0.
    #[must_use]
    pub fn constant<N: Number>(&self) -> Pose<N> {
        Pose {
            position: self.position.map(N::constant),
            rotation: self.rotation.map(N::constant),
        }
    }
}

impl<N: Number> Pose<N> {
    /// X, Y, Z, Rx, Ry, Rz: `Rz(Rz) * Ry(Ry) * Rx(Rx)`, fixed X-Y-Z angles in degrees.
    #[must_use]
    pub fn new([x, y, z, rx, ry, rz]: [N; 6]) -> Pose<N> {
        Pose {
            position: Vector3::new(x, y, z),
            rotation: product(&product(&turn_z(rz), &turn_y(ry)), &turn_x(rx)),
        }
    }

    /// X, Y, Z, Rx, Ry, Rz, with Rx and Rz above -180 up to 180 and Ry from -90 to 90. If Ry is 90 or -90, only the sum or
    /// difference of the others is determined: Rx is 0 then.
    #[must_use]
    pub fn coordinates(&self) -> [N; 6] {
        let p = &self.position;
        let [rx, ry, rz] = self.angles(0.0);
        [p.x, p.y, p.z, above_half_turn(rx), ry, above_half_turn(rz)]
    }

    /// The coordinates with the angles of this orientation that are nearest to `others`, degrees. They may exceed their ranges, so that a continuous
    /// motion through an end of a range does not jump.
    #[must_use]
    pub fn coordinates_near(&self, others: [f64; 3]) -> [N; 6] {
        let p = &self.position;
        let [rx, ry, rz] = self.angles(others[0]);
        // Every orientation has two triples of angles.
        let near = |angles: [N; 3]| {
            let mut far = 0.0;
            let near = [0, 1, 2].map(|index| {
                let angle = angles[index];
                let angle = angle + 360.0 * ((others[index] - angle.value()) / 360.0).round();
                far += (others[index] - angle.value()).abs();
                angle
            });
            (near, far)
        };
        let (first, far) = near([rx, ry, rz]);
        let (second, further) = near([rx + 180.0, -ry + 180.0, rz + 180.0]);
        let [rx, ry, rz] = if further < far { second } else { first };
        [p.x, p.y, p.z, rx, ry, rz]
    }

    /// Rx, Ry, Rz. `upright`: Rx if it is undetermined.
    fn angles(&self, upright: f64) -> [N; 3] {
        let m = &self.rotation;
        let square = m[(0, 0)] * m[(0, 0)] + m[(1, 0)] * m[(1, 0)];
        let angles = if square.value() > UPRIGHT_COSINE * UPRIGHT_COSINE {
            [
                m[(2, 1)].atan2(m[(2, 2)]),
                (-m[(2, 0)]).atan2(square.sqrt()),
                m[(1, 0)].atan2(m[(0, 0)]),
            ]
        } else {
            let quarter = if m[(2, 0)].value() < 0.0 { QUARTER } else { -QUARTER };
            let rx = upright.to_radians();
            let rz = (-m[(0, 1)]).atan2(m[(1, 1)]) + rx * quarter.signum();
            [N::constant(rx), N::constant(quarter), rz]
        };
        angles.map(|angle| angle * DEGREES)
    }

    /// Converts a pose in this frame to the outer frame.
    #[must_use]
    pub fn of(&self, inner: &Pose<N>) -> Pose<N> {
        let moved = turned(&self.rotation, &inner.position);
        Pose {
            position: Vector3::from_fn(|row, _| moved[row] + self.position[row]),
            rotation: product(&self.rotation, &inner.rotation),
        }
    }

    /// Converts a pose in the outer frame to this frame.
    #[must_use]
    pub fn inverse(&self) -> Pose<N> {
        let rotation = self.rotation.transpose();
        Pose {
            position: turned(&rotation, &self.position).map(|part| -part),
            rotation,
        }
    }
}

/// The end of the arm in the frame of the base for a tool centre in a work frame: `work * tool_centre * inverse(tool)`.
#[must_use]
pub fn end_of_arm<N: Number>(work: &Pose, tool_centre: &Pose<N>, tool: &Pose) -> Pose<N> {
    work.constant().of(tool_centre).of(&tool.inverse().constant())
}

/// The inverse: the tool centre in the work frame.
#[must_use]
pub fn tool_centre<N: Number>(work: &Pose, end_of_arm: &Pose<N>, tool: &Pose) -> Pose<N> {
    work.inverse().constant().of(&end_of_arm.of(&tool.constant()))
}

/// The product of two rotations: `first * second`.
pub(crate) fn product<N: Number>(first: &Matrix3<N>, second: &Matrix3<N>) -> Matrix3<N> {
    Matrix3::from_fn(|row, column| {
        first[(row, 0)] * second[(0, column)]
            + first[(row, 1)] * second[(1, column)]
            + first[(row, 2)] * second[(2, column)]
    })
}

/// A rotated vector.
pub(crate) fn turned<N: Number>(rotation: &Matrix3<N>, vector: &Vector3<N>) -> Vector3<N> {
    Vector3::from_fn(|row, _| {
        rotation[(row, 0)] * vector[0] + rotation[(row, 1)] * vector[1] + rotation[(row, 2)] * vector[2]
    })
}

/// A rotation about X, degrees.
pub(crate) fn turn_x<N: Number>(degrees: N) -> Matrix3<N> {
    let (s, c) = sin_cos(degrees);
    let [o, i] = [0.0, 1.0].map(N::constant);
    Matrix3::new(i, o, o, o, c, -s, o, s, c)
}

/// A rotation about Y, degrees.
pub(crate) fn turn_y<N: Number>(degrees: N) -> Matrix3<N> {
    let (s, c) = sin_cos(degrees);
    let [o, i] = [0.0, 1.0].map(N::constant);
    Matrix3::new(c, o, s, o, i, o, -s, o, c)
}

/// A rotation about Z, degrees.
pub(crate) fn turn_z<N: Number>(degrees: N) -> Matrix3<N> {
    let (s, c) = sin_cos(degrees);
    let [o, i] = [0.0, 1.0].map(N::constant);
    Matrix3::new(c, -s, o, s, c, o, o, o, i)
}

/// Sine and cosine of degrees, exact for quarter turns.
fn sin_cos<N: Number>(degrees: N) -> (N, N) {
    let quarters = (degrees.value() / 90.0).round();
    let (s, c) = ((degrees - 90.0 * quarters) * RADIANS).sin_cos();
    match quarters.rem_euclid(4.0) as u8 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Replaces an angle of -180, and any that rounds to it, by 180.
fn above_half_turn<N: Number>(degrees: N) -> N {
    if degrees.value() <= -180.0 + HALF_TURN_DEG {
        degrees + 360.0
    } else {
        degrees
    }
}

pub(crate) const DEGREES: f64 = 180.0 / core::f64::consts::PI;
pub(crate) const RADIANS: f64 = core::f64::consts::PI / 180.0;
/// Radians.
const QUARTER: f64 = core::f64::consts::FRAC_PI_2;
