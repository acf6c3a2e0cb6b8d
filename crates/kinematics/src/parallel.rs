//! Delta robots of three and two arms, and the two arms of a SCARA Delta (spec/coordinated-instructions.md §22.6, §22.7).
//!
//! Every arm is an upper link that rotates about the rim of the base, and a rod from its elbow to the plate. At a positive angle the upper link
//! hangs down. Units: any for lengths, radians.

use crate::number::root;
use crate::tolerance::{DEGENERATE_SHARE, RANGE_END_RAD};
use crate::{KinematicsError, Number};

/// The arms of a delta robot, and the range of their angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arms {
    upper: f64,
    rod: f64,
    /// The distance of an arm from the centre at the base minus that at the plate: `X1b - X1e`.
    apart: f64,
    /// The angles with the links folded over each other, and stretched, radians.
    pub(crate) range: [f64; 2],
}

impl Arms {
    /// Lengths above 0 and not equal, with `|apart| <= |rod - upper|`; the caller has checked them.
    pub(crate) fn new(upper: f64, rod: f64, apart: f64) -> Self {
        let most = libm::acos((-apart / (upper + rod)).clamp(-1.0, 1.0));
        let least = -libm::acos((apart / (rod - upper)).clamp(-1.0, 1.0));
        Arms {
            upper,
            rod,
            apart,
            range: [least, most],
        }
    }

    /// The angles of three arms, a third of a turn apart, for a position of the plate.
    pub(crate) fn three<N: Number>(&self, [x, y, z]: [N; 3]) -> Result<[N; 3], KinematicsError> {
        let mut angles = [N::constant(0.0); 3];
        for (joint, ((cos, sin), angle)) in (0..).zip(AZIMUTHS.into_iter().zip(&mut angles)) {
            let (out, across) = (x * cos + y * sin, y * cos - x * sin);
            *angle = self.angle([out, across, z], joint)?;
        }
        Ok(angles)
    }

    /// The angles of two arms, half a turn apart, for a position of the plate in their plane.
    pub(crate) fn two<N: Number>(&self, [x, z]: [N; 2]) -> Result<[N; 2], KinematicsError> {
        let across = N::constant(0.0);
        Ok([self.angle([x, across, z], 0)?, self.angle([-x, across, z], 1)?])
    }

    /// The plate of three arms: the point at which three spheres about the elbows meet, below them.
    pub(crate) fn plate_of_three<N: Number>(&self, angles: [N; 3]) -> Result<[N; 3], KinematicsError> {
        let mut elbows = [[N::constant(0.0); 3]; 3];
        for (joint, ((cos, sin), elbow)) in (0..).zip(AZIMUTHS.into_iter().zip(&mut elbows)) {
            let [out, z] = self.elbow(angles[usize::from(joint)], joint)?;
            *elbow = [out * cos, out * sin, z];
        }
        let [first, second, third] = elbows;
        let (a, b) = (minus(second, first), minus(third, first));
        let normal = cross(a, b);
        let square = dot(normal, normal);
        if square.value() <= DEGENERATE_SHARE * self.rod.powi(4) {
            return Err(KinematicsError::Origin);
        }
        // From the first elbow to the centre of the circle through all of them, and on, across their plane.
        let (aa, bb) = (dot(a, a), dot(b, b));
        let lever = [0, 1, 2].map(|k| b[k] * aa - a[k] * bb);
        let centre = cross(lever, normal).map(|part| part / (square * 2.0));
        let left = N::constant(self.rod * self.rod) - dot(centre, centre);
        let height = self.height(left / square, 1.0 / square.value())?;
        let height = if normal[2].value() < 0.0 { height } else { -height };
        Ok([0, 1, 2].map(|k| first[k] + centre[k] + normal[k] * height))
    }

    /// The plate of two arms: the point at which two circles about the elbows meet, below them.
    pub(crate) fn plate_of_two<N: Number>(&self, [first, second]: [N; 2]) -> Result<[N; 2], KinematicsError> {
        let ([out, z1], [back, z2]) = (self.elbow(first, 0)?, self.elbow(second, 1)?);
        let (width, rise) = (out + back, z1 - z2);
        let square = width * width + rise * rise;
        if square.value() <= DEGENERATE_SHARE * self.rod * self.rod {
            return Err(KinematicsError::Origin);
        }
        let left = N::constant(self.rod * self.rod) - square * 0.25;
        let height = self.height(left / square, 1.0 / square.value())?;
        let height = if width.value() < 0.0 { -height } else { height };
        Ok([(out - back) * 0.5 + rise * height, (z1 + z2) * 0.5 - width * height])
    }

    /// The elbow of an arm, out and up; its distance from the centre is that for a plate of no size.
    fn elbow<N: Number>(&self, angle: N, joint: u8) -> Result<[N; 2], KinematicsError> {
        self.verify(angle.value(), joint)?;
        let (sin, cos) = angle.sin_cos();
        Ok([cos * self.upper + self.apart, sin * -self.upper])
    }

    /// The distance of the plate from the plane of the elbows, from its square in units of `1 / scale`.
    fn height<N: Number>(&self, square: N, scale: f64) -> Result<N, KinematicsError> {
        if square.value() < N::LEAST_BEND_SHARE * self.rod * self.rod * scale {
            return Err(KinematicsError::Reach { joint: 0 });
        }
        Ok(root(square))
    }

    /// The angle of an arm for a plate at `out`, `across` and the height `z`.
    fn angle<N: Number>(&self, [out, across, z]: [N; 3], joint: u8) -> Result<N, KinematicsError> {
        let out = out - self.apart;
        let p = out * (-2.0 * self.upper);
        let q = z * (2.0 * self.upper);
        let w = out * out + across * across + z * z + (self.upper * self.upper - self.rod * self.rod);
        let square = p * p + q * q;
        let left = square - w * w;
        if square.value() <= 0.0 || left.value() < N::LEAST_BEND_SHARE * square.value() {
            return Err(KinematicsError::Reach { joint });
        }
        // Both solutions turn the direction (p, q) by the same angle; the elbow outside has the larger cosine.
        let turn = root(left);
        let turn = if q.value() > 0.0 { -turn } else { turn };
        let angle = (turn * p - w * q).atan2(-(w * p) - turn * q);
        self.verify(angle.value(), joint)?;
        Ok(angle)
    }

    /// Checks that an angle is within the range of an arm.
    fn verify(&self, angle: f64, joint: u8) -> Result<(), KinematicsError> {
        let [least, most] = self.range;
        if angle >= least - RANGE_END_RAD && angle <= most + RANGE_END_RAD {
            Ok(())
        } else {
            Err(KinematicsError::Reach { joint })
        }
    }
}

fn minus<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Cosine and sine of the directions of three arms: 0, 120 and 240 degrees, counter-clockwise.
const AZIMUTHS: [(f64, f64); 3] = [(1.0, 0.0), (-0.5, HALF_ROOT_3), (-0.5, -HALF_ROOT_3)];
/// `sqrt(3) / 2`.
const HALF_ROOT_3: f64 = 0.866_025_403_784_438_6;
