//! A position with an orientation, and frames of tools and works (spec/coordinated-instructions.md §22.8).
//!
//! Not here: which poses a robot can take. Units: position units, degrees.

use nalgebra::{Matrix3, Vector3};

/// Where something is, and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Its origin, position units.
    pub position: Vector3<f64>,
    /// Its axes, as columns.
    pub rotation: Matrix3<f64>,
}

impl Pose {
    /// No frame: at the origin, not turned.
    #[must_use]
    pub fn identity() -> Pose {
        Pose {
            position: Vector3::zeros(),
            rotation: Matrix3::identity(),
        }
    }

    /// X, Y, Z, Rx, Ry, Rz: `Rz(Rz) * Ry(Ry) * Rx(Rx)`, fixed X-Y-Z angles in degrees.
    #[must_use]
    pub fn new([x, y, z, rx, ry, rz]: [f64; 6]) -> Pose {
        Pose {
            position: Vector3::new(x, y, z),
            rotation: turn_z(rz) * turn_y(ry) * turn_x(rx),
        }
    }

    /// X, Y, Z, Rx, Ry, Rz, with Rx and Rz above -180 up to 180 and Ry from -90 to 90. Where Ry is 90 or -90 only the sum or
    /// difference of the others says something: Rx is 0 then.
    #[must_use]
    pub fn coordinates(&self) -> [f64; 6] {
        let m = &self.rotation;
        let level = libm::hypot(m[(0, 0)], m[(1, 0)]);
        let ry = libm::atan2(-m[(2, 0)], level);
        let (rx, rz) = if level > UPRIGHT {
            (libm::atan2(m[(2, 1)], m[(2, 2)]), libm::atan2(m[(1, 0)], m[(0, 0)]))
        } else {
            (0.0, libm::atan2(-m[(0, 1)], m[(1, 1)]))
        };
        let [rx, ry, rz] = [rx, ry, rz].map(f64::to_degrees).map(above_half_turn);
        let p = &self.position;
        [p.x, p.y, p.z, rx, ry, rz]
    }

    /// What lies in this frame, seen from outside of it.
    #[must_use]
    pub fn of(&self, inner: &Pose) -> Pose {
        Pose {
            position: self.rotation * inner.position + self.position,
            rotation: self.rotation * inner.rotation,
        }
    }

    /// What is outside, seen from this frame.
    #[must_use]
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.transpose();
        Pose {
            position: -(rotation * self.position),
            rotation,
        }
    }
}

/// The end of the arm in the frame of the base for a tool centre in a work frame: `work * tool_centre * inverse(tool)`.
#[must_use]
pub fn end_of_arm(work: &Pose, tool_centre: &Pose, tool: &Pose) -> Pose {
    work.of(tool_centre).of(&tool.inverse())
}

/// The reverse: the tool centre in the work frame.
#[must_use]
pub fn tool_centre(work: &Pose, end_of_arm: &Pose, tool: &Pose) -> Pose {
    work.inverse().of(&end_of_arm.of(tool))
}

/// A rotation about X, degrees.
pub(crate) fn turn_x(degrees: f64) -> Matrix3<f64> {
    let (s, c) = sin_cos(degrees);
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// A rotation about Y, degrees.
pub(crate) fn turn_y(degrees: f64) -> Matrix3<f64> {
    let (s, c) = sin_cos(degrees);
    Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

/// A rotation about Z, degrees.
pub(crate) fn turn_z(degrees: f64) -> Matrix3<f64> {
    let (s, c) = sin_cos(degrees);
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// Sine and cosine of degrees; those of quarter turns are whole numbers.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let (s, c) = libm::sincos((degrees - 90.0 * quarters).to_radians());
    match quarters.rem_euclid(4.0) as u8 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// -180 and what rounds to it is 180.
fn above_half_turn(degrees: f64) -> f64 {
    if degrees <= -180.0 + ROUNDING {
        degrees + 360.0
    } else {
        degrees
    }
}

/// Below this cosine of Ry the other two angles cannot be told apart.
const UPRIGHT: f64 = 1e-9;
/// Degrees.
const ROUNDING: f64 = 1e-9;
