//! Orientation along a path: fixed X-Y-Z angles as a rotation and back, and the rotation from one orientation to another.
//!
//! A rotation has one fixed axis; whole turns about X3 can be added to it, so that a joint with a turns counter reaches its
//! count (spec/coordinated-instructions.md §23.3). The angle per share of the path is constant.
//! Not here: positions, speeds. Angles are degrees, rates radians.

use nalgebra::Matrix3;

use crate::Point;
use crate::frame::sin_cos;
use crate::tolerance::{HALF_TURN_RATIO, NO_ROTATION_RATIO, SAME_ANGLES_DEG, UPRIGHT_COSINE};

/// `Rz * Ry * Rx` of fixed X-Y-Z angles in degrees. Quarter turns are exact.
#[must_use]
pub fn rotation(angles: &Point) -> Matrix3<f64> {
    let [(s1, c1), (s2, c2), (s3, c3)] = [angles.x, angles.y, angles.z].map(sin_cos);
    let x = Matrix3::new(1.0, 0.0, 0.0, 0.0, c1, -s1, 0.0, s1, c1);
    let y = Matrix3::new(c2, 0.0, s2, 0.0, 1.0, 0.0, -s2, 0.0, c2);
    let z = Matrix3::new(c3, -s3, 0.0, s3, c3, 0.0, 0.0, 0.0, 1.0);
    z * y * x
}

/// The fixed X-Y-Z angles of a rotation, degrees: the second within a quarter turn of 0, the others on the turns nearest
/// to `near`. If the second is a quarter turn, only the sum or difference of the others is determined: the first stays.
#[must_use]
pub fn angles(rotation: &Matrix3<f64>, near: &Point) -> Point {
    let m = rotation;
    let level = libm::hypot(m[(0, 0)], m[(1, 0)]);
    let second = libm::atan2(-m[(2, 0)], level).to_degrees();
    let (first, third) = if level > UPRIGHT_COSINE {
        let first = libm::atan2(m[(2, 1)], m[(2, 2)]).to_degrees();
        (first, libm::atan2(m[(1, 0)], m[(0, 0)]).to_degrees())
    } else {
        // The third minus the first, or the sum of both.
        let both = libm::atan2(-m[(0, 1)], m[(1, 1)]).to_degrees();
        let side = if second > 0.0 { 1.0 } else { -1.0 };
        (near.x, both + side * near.x)
    };
    Point::new(nearest(first, near.x), second, nearest(third, near.z))
}

/// The fixed X-Y-Z angles of a rotation, degrees, that are nearest to `near`; the second angle may exceed a quarter turn if that
/// continues it without a step.
#[must_use]
pub fn continued(rotation: &Matrix3<f64>, near: &Point) -> Point {
    let one = angles(rotation, near);
    let other = Point::new(
        nearest(one.x + 180.0, near.x),
        nearest(180.0 - one.y, near.y),
        nearest(one.z + 180.0, near.z),
    );
    let one = Point::new(one.x, nearest(one.y, near.y), one.z);
    if (one - near).abs().sum() <= (other - near).abs().sum() {
        one
    } else {
        other
    }
}

/// An angle on the turn on which it is nearest to another, degrees.
#[must_use]
pub fn nearest(angle: f64, near: f64) -> f64 {
    angle + 360.0 * ((near - angle) / 360.0).round()
}

/// Converts a rate and its derivative, radians per second and per second², to those of fixed X-Y-Z angles, in degrees. If the second
/// angle is a quarter turn, the first one does not move.
#[must_use]
pub fn angle_rates(angles: &Point, rate: &Point, change: &Point) -> [Point; 2] {
    let [(_, _), (sb, cb), (sc, cc)] = [angles.x, angles.y, angles.z].map(sin_cos);
    let along = rate.x * cc + rate.y * sc;
    let upright = cb.abs() <= UPRIGHT_COSINE;
    let over = if upright { 0.0 } else { 1.0 / cb };
    let first = along * over;
    let second = rate.y * cc - rate.x * sc;
    let third = rate.z + first * sb;
    let along_change = change.x * cc + change.y * sc + third * second;
    let first_change = (along_change + first * second * sb) * over;
    let second_change = change.y * cc - change.x * sc - third * along;
    let third_change = change.z + first_change * sb + first * second * cb;
    [
        Point::new(first, second, third),
        Point::new(first_change, second_change, third_change),
    ]
    .map(|of| of.map(f64::to_degrees))
}

/// The inverse of [`angle_rates`]: converts the rates of fixed X-Y-Z angles and their derivatives, in degrees, to those about axes: radians per
/// second and per second².
#[must_use]
pub fn angular_rates(angles: &Point, velocity: &Point, acceleration: &Point) -> [Point; 2] {
    let [(_, _), (sb, cb), (sc, cc)] = [angles.x, angles.y, angles.z].map(sin_cos);
    let [v, a] = [velocity, acceleration].map(|of| of.map(f64::to_radians));
    // The rate of the first angle is along its axis in the plane of X3 and X1, that of the second one across it.
    let along = v.x * cb;
    let along_change = a.x * cb - v.x * v.y * sb - v.y * v.z;
    let across_change = a.y + along * v.z;
    let rate = Point::new(along * cc - v.y * sc, along * sc + v.y * cc, v.z - v.x * sb);
    let change = Point::new(
        along_change * cc - across_change * sc,
        along_change * sc + across_change * cc,
        a.z - a.x * sb - v.x * v.y * cb,
    );
    [rate, change]
}

/// A rotation from one orientation to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    from: Matrix3<f64>,
    to: Matrix3<f64>,
    /// The fixed axis.
    axis: Point,
    /// The angle about it, radians, at least 0.
    angle: f64,
    /// The additional angle about X3, radians.
    spin: f64,
    /// The fixed angles at its ends, degrees.
    shown: [Point; 2],
    /// The rotation belongs to a move that keeps the orientation.
    keeps_orientation: bool,
}

/// An orientation on the path, and its derivatives by the share of the path or by time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationState {
    /// The orientation.
    pub orientation: Matrix3<f64>,
    /// The axis and the rate of the rotation, radians per unit of its variable: a share of the path, or seconds.
    pub rate: Point,
    /// The derivative of the rate, radians per square of the unit.
    pub change: Point,
    /// Fixed angles, degrees, that determine the turns of the orientation's angles; at the ends of the path they are those angles.
    pub near: Point,
}

impl Rotation {
    /// The shortest rotation, with `turns` additional whole turns about X3. Of two opposite half turns, the one about the
    /// positive axis, X3 before X2 before X1.
    #[must_use]
    pub fn new(from: &Matrix3<f64>, to: &Matrix3<f64>, turns: f64) -> Rotation {
        let (axis, angle) = axis_angle(&(to * from.transpose()));
        Rotation {
            from: *from,
            to: *to,
            axis,
            angle,
            spin: turns * core::f64::consts::TAU,
            shown: [Point::zeros(); 2],
            keeps_orientation: false,
        }
    }

    /// The rotation with the fixed angles at its ends, degrees, each on the turn on which it is shown.
    #[must_use]
    pub fn showing(self, shown: [Point; 2]) -> Rotation {
        Rotation { shown, ..self }
    }

    /// The rotation of a move that keeps an orientation.
    #[must_use]
    pub fn keeping(angles: &Point) -> Rotation {
        let at = rotation(angles);
        Rotation {
            keeps_orientation: true,
            ..Rotation::new(&at, &at, 0.0).showing([*angles; 2])
        }
    }

    /// The rotation belongs to a move that keeps the orientation.
    #[must_use]
    pub fn keeps_orientation(&self) -> bool {
        self.keeps_orientation
    }

    /// Its end state, at rest.
    #[must_use]
    pub fn ended(&self) -> RotationState {
        RotationState::at_rest(self.to, self.shown[1])
    }

    /// The orientation at the end.
    #[must_use]
    pub fn end(&self) -> &Matrix3<f64> {
        &self.to
    }

    /// Its total angle, degrees. Rotations about both axes have a constant ratio: the angle between the axes stays, as X3 does not move.
    #[must_use]
    pub fn angle(&self) -> f64 {
        (self.axis * self.angle + Point::z() * self.spin).norm().to_degrees()
    }

    /// The orientation at a share of the path; exact at both ends, 0 and 1. Beyond the end the rotation continues. Real-time.
    #[must_use]
    pub fn at(&self, share: f64) -> RotationState {
        if self.keeps_orientation {
            return self.ended();
        }
        let [first, last] = self.shown;
        let spun = about(&Point::z(), self.spin * share);
        let axis = spun * self.axis;
        let rotation = if share == 0.0 {
            self.from
        } else if share == 1.0 {
            self.to
        } else {
            spun * about(&self.axis, self.angle * share) * self.from
        };
        let spin = Point::z() * self.spin;
        RotationState {
            orientation: rotation,
            rate: spin + axis * self.angle,
            change: spin.cross(&axis) * self.angle,
            // Between the ends, the angles of a rotation of at most half a turn differ from these by less than half a turn.
            near: if share == 1.0 {
                last
            } else {
                first + (last - first) * share
            },
        }
    }
}

impl RotationState {
    /// At rest.
    #[must_use]
    pub fn at_rest(rotation: Matrix3<f64>, near: Point) -> RotationState {
        RotationState {
            orientation: rotation,
            rate: Point::zeros(),
            change: Point::zeros(),
            near,
        }
    }

    /// The fixed angles, degrees; exactly those of the end at its orientation. Real-time.
    #[must_use]
    pub fn angles(&self) -> Point {
        let shown = angles(&self.orientation, &self.near);
        let stands = self.rate == Point::zeros() && self.change == Point::zeros();
        if stands && (shown - self.near).abs().max() <= SAME_ANGLES_DEG {
            self.near
        } else {
            shown
        }
    }

    /// The state by time, for a speed and an acceleration of the share of the path.
    #[must_use]
    pub fn in_time(self, speed: f64, acceleration: f64) -> RotationState {
        RotationState {
            rate: self.rate * speed,
            change: self.rate * acceleration + self.change * (speed * speed),
            ..self
        }
    }

    /// This state combined with the rest of another rotation that ends at the beginning of this one, if both are active at once.
    #[must_use]
    pub fn after(self, other: &RotationState, other_end: &RotationState) -> RotationState {
        let own = self.orientation * other_end.orientation.transpose();
        let carried = own * other.rate;
        RotationState {
            orientation: own * other.orientation,
            rate: self.rate + carried,
            change: self.change + own * other.change + self.rate.cross(&carried),
            near: self.near + other.near - other_end.near,
        }
    }
}

/// The rotation about a unit axis by an angle in radians.
pub(crate) fn about(axis: &Point, angle: f64) -> Matrix3<f64> {
    let (s, _) = libm::sincos(angle);
    let (half, _) = libm::sincos(0.5 * angle);
    let k = axis.cross_matrix();
    Matrix3::identity() + k * s + k * k * (2.0 * half * half)
}

/// The unit axis and the angle (0 to pi) of a rotation; a zero axis without a rotation.
fn axis_angle(m: &Matrix3<f64>) -> (Point, f64) {
    // The largest of the four parts of the quaternion, four times its square: no quotient loses digits.
    let parts = [
        1.0 + m[(0, 0)] + m[(1, 1)] + m[(2, 2)],
        1.0 + m[(0, 0)] - m[(1, 1)] - m[(2, 2)],
        1.0 - m[(0, 0)] + m[(1, 1)] - m[(2, 2)],
        1.0 - m[(0, 0)] - m[(1, 1)] + m[(2, 2)],
    ];
    let skew = Point::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
    let [xy, xz, yz] = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| m[(i, j)] + m[(j, i)]);
    let largest = parts.iter().copied().fold(0.0, f64::max);
    let (w, v) = if parts[0] == largest {
        (parts[0], skew)
    } else if parts[1] == largest {
        (skew.x, Point::new(parts[1], xy, xz))
    } else if parts[2] == largest {
        (skew.y, Point::new(xy, parts[2], yz))
    } else {
        (skew.z, Point::new(xz, yz, parts[3]))
    };
    let norm = libm::sqrt(v.dot(&v));
    if norm <= NO_ROTATION_RATIO * w.abs() {
        return (Point::zeros(), 0.0);
    }
    let axis = v / norm;
    let first = [axis.z, axis.y, axis.x]
        .into_iter()
        .find(|part| part.abs() > UPRIGHT_COSINE);
    let backwards = if w.abs() <= HALF_TURN_RATIO * norm {
        first.is_some_and(|part| part < 0.0)
    } else {
        w < 0.0
    };
    let (axis, w) = if backwards { (-axis, -w) } else { (axis, w) };
    (axis, 2.0 * libm::atan2(norm, w))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn distance(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
        (a - b).abs().max()
    }

    #[test]
    fn turns_that_can_be_told_beforehand() {
        #[rustfmt::skip]
        let cases = [
            // why,                          from,                to,                    turns, whole, the middle
            ("a tool that points down",      [180.0, 0.0, 0.0],   [180.0, 0.0, 90.0],    0.0,   90.0,  [180.0, 0.0, 45.0]),
            ("half a rotation goes forwards",    [180.0, 0.0, 0.0],   [180.0, 0.0, 180.0],   0.0,   180.0, [180.0, 0.0, 90.0]),
            ("over the edge of the range",   [0.0, 0.0, 170.0],   [0.0, 0.0, -170.0],    0.0,   20.0,  [0.0, 0.0, 180.0]),
            ("a rotation more",                  [180.0, 0.0, 0.0],   [180.0, 0.0, 45.0],    1.0,   405.0, [180.0, 0.0, 202.5]),
            ("a rotation back",                  [180.0, 0.0, 0.0],   [180.0, 0.0, 45.0],    -1.0,  315.0, [180.0, 0.0, -157.5]),
            ("a rotation with no other",         [10.0, 20.0, 30.0],  [10.0, 20.0, 30.0],    1.0,   360.0, [10.0, 20.0, 210.0]),
            ("none",                         [10.0, 20.0, 30.0],  [10.0, 20.0, 30.0],    0.0,   0.0,   [10.0, 20.0, 30.0]),
            ("through the mirror",           [180.0, 80.0, 0.0],  [0.0, 80.0, 180.0],    0.0,   20.0,  [180.0, 90.0, 0.0]),
            ("about X1",                     [0.0, 0.0, 0.0],     [90.0, 0.0, 0.0],      0.0,   90.0,  [45.0, 0.0, 0.0]),
        ];
        for (why, from, to, turns, whole, middle) in cases {
            let [from, to, middle] = [from, to, middle].map(|angles| rotation(&Point::from(angles)));
            let rotation = Rotation::new(&from, &to, turns);
            assert!(
                (rotation.angle() - whole).abs() < 1e-12,
                "{why}: {} degrees",
                rotation.angle()
            );
            assert!(
                distance(&rotation.at(0.5).orientation, &middle) < 1e-12,
                "{why}: {}",
                rotation.at(0.5).orientation
            );
            assert_eq!(
                (rotation.at(0.0).orientation, rotation.at(1.0).orientation),
                (from, to),
                "{why}"
            );
        }
    }

    fn orientation() -> impl Strategy<Value = Point> {
        (-180.0..180.0, -90.0..90.0, -180.0..180.0).prop_map(|(x, y, z)| Point::new(x, y, z))
    }

    proptest! {
        #[test]
        fn angles_and_back(wanted in orientation(), turns in prop::array::uniform2(-3i32..=3)) {
            let near = wanted + Point::new(360.0 * f64::from(turns[0]), 0.0, 360.0 * f64::from(turns[1]));
            let found = angles(&rotation(&near), &near);
            prop_assert!(distance(&rotation(&found), &rotation(&wanted)) < 1e-12, "{found} is not {wanted}");
            // Near a quarter turn of the second angle, the others are not sharp.
            let sharp = 1e-12 / libm::cos(wanted.y.to_radians()).max(1e-9);
            prop_assert!((found - near).abs().max() < sharp.max(1e-11), "{found} is not {near}");
        }

        #[test]
        fn angles_that_go_on_have_no_step(axis in 0..3usize, from in orientation(), rate in -1.0..1.0f64) {
            let mut near = from;
            for step in 1..200 {
                let mut wanted = from;
                wanted[axis] += 5.0 * rate * f64::from(step);
                let next = continued(&rotation(&wanted), &near);
                prop_assert!(distance(&rotation(&next), &rotation(&wanted)) < 1e-11);
                let upright = libm::cos(wanted.y.to_radians()).abs() < 0.1;
                prop_assert!(upright || (next - wanted).abs().max() < 1e-8, "{next} is not {wanted}");
                near = wanted;
            }
        }

        #[test]
        fn straight_up_the_first_stays(side in prop::bool::ANY, first in -720.0..720.0f64, third in -180.0..180.0f64) {
            let upright = Point::new(first, if side { 90.0 } else { -90.0 }, third);
            let found = angles(&rotation(&upright), &upright);
            prop_assert!((found - upright).abs().max() < 1e-10, "{found} is not {upright}");
        }

        #[test]
        fn a_turn_ends_where_it_is_to_and_is_even(from in orientation(), to in orientation(), turns in -2i32..=2) {
            let [from, to] = [from, to].map(|angles| rotation(&angles));
            let rotation = Rotation::new(&from, &to, turns.into());
            prop_assert!(turns != 0 || rotation.angle() <= 180.0 + 1e-9);
            prop_assert!(distance(&rotation.at(1.0 - 1e-13).orientation, &to) < 1e-11);
            for share in [0.0, 0.3, 0.5, 0.9] {
                let now = rotation.at(share);
                let square = now.orientation * now.orientation.transpose();
                prop_assert!(distance(&square, &Matrix3::identity()) < 1e-12, "no rotation");
                prop_assert!((now.rate.norm().to_degrees() - rotation.angle()).abs() < 1e-9 * (1.0 + rotation.angle()));
            }
        }

        /// The rates agree with differences of the angles.
        #[test]
        fn rates_are_derivatives(from in orientation(), to in orientation(), turns in -1i32..=1, share in 0.1..0.9f64) {
            let rotation = Rotation::new(&rotation(&from), &rotation(&to), turns.into());
            let (speed, acceleration, step) = (0.3, -0.2, 1e-4);
            let at = |t: f64| rotation.at(share + speed * t + 0.5 * acceleration * t * t);
            let now = at(0.0).in_time(speed, acceleration);
            let shown = angles(&now.orientation, &Point::zeros());
            prop_assume!(shown.y.abs() < 70.0);
            let [velocity, change] = angle_rates(&shown, &now.rate, &now.change);
            let [before, after] = [-step, step].map(|t| angles(&at(t).orientation, &shown));
            let slope = (after - before) / (2.0 * step);
            let bend = (after - shown * 2.0 + before) / (step * step);
            prop_assert!((slope - velocity).abs().max() < 1e-4 * (1.0 + velocity.abs().max()), "{slope} {velocity}");
            prop_assert!((bend - change).abs().max() < 1e-3 * (1.0 + change.abs().max() + velocity.norm_squared()), "{bend} {change}");
        }

        #[test]
        fn rates_of_angles_and_back(at in orientation(), v in orientation(), a in orientation()) {
            prop_assume!(at.y.abs() < 80.0);
            let [rate, change] = angular_rates(&at, &v, &a);
            let [velocity, acceleration] = angle_rates(&at, &rate, &change);
            prop_assert!((velocity - v).abs().max() < 1e-9 && (acceleration - a).abs().max() < 1e-7, "{velocity} {acceleration}");
        }

        /// The end of one rotation and the beginning of the next at the same time.
        #[test]
        fn two_at_once(a in orientation(), b in orientation(), c in orientation(), share in 0.1..0.9f64) {
            let [a, b, c] = [a, b, c].map(|angles| rotation(&angles));
            let (first, second) = (Rotation::new(&a, &b, 0.0), Rotation::new(&b, &c, 0.0));
            let both = |u: f64, v: f64| second.at(v).after(&first.at(u), &first.ended());
            prop_assert!(distance(&both(1.0, share).orientation, &second.at(share).orientation) < 1e-12);
            prop_assert!(distance(&both(share, 0.0).orientation, &first.at(share).orientation) < 1e-12);
            let step = 1e-5;
            let now = both(share, share);
            let [before, after] = [-step, step].map(|t| both(share + t, share + t).orientation);
            let slope = (after - before) * now.orientation.transpose() / (2.0 * step);
            prop_assert!(distance(&slope, &now.rate.cross_matrix()) < 1e-5, "{slope} {}", now.rate);
        }
    }
}
