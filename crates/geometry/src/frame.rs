//! The position of one Cartesian frame in another: a rotation and a translation.
//!
//! Not here: the kinematics of robots. Angles are degrees, since they come from operands; lengths are position units.

use nalgebra::Matrix3;

use crate::Point;
use crate::rotation::rotation;

/// The location of the coordinates of one frame in another one (spec/coordinated-instructions.md §19.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// From the first frame into the second.
    rotation: Matrix3<f64>,
    translation: Point,
}

impl Frame {
    /// `transpose(Q) * p + translation` with `Q = Rz(o3) * Ry(o2) * Rx(o1)`; `orientation` in degrees about the three
    /// axes. Quarter turns are exact.
    #[must_use]
    pub fn new(orientation: Point, translation: Point) -> Frame {
        Frame {
            rotation: rotation(&orientation).transpose(),
            translation,
        }
    }

    /// A point of the first frame in the second.
    #[must_use]
    pub fn transform_point(&self, point: &Point) -> Point {
        self.rotation * point + self.translation
    }

    /// A point of the second frame in the first.
    #[must_use]
    pub fn inverse_transform_point(&self, point: &Point) -> Point {
        self.inverse_transform_vector(&(point - self.translation))
    }

    /// A difference, velocity or acceleration of the first frame in the second.
    #[must_use]
    pub fn transform_vector(&self, difference: &Point) -> Point {
        self.rotation * difference
    }

    /// A difference, velocity or acceleration of the second frame in the first.
    #[must_use]
    pub fn inverse_transform_vector(&self, difference: &Point) -> Point {
        self.rotation.tr_mul(difference)
    }
}

/// Sine and cosine of an angle in degrees, exact for quarter turns.
pub(crate) fn sin_cos(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let (s, c) = libm::sincos((degrees - 90.0 * quarters).to_radians());
    // The remainder of a whole number by 4 is one of these.
    match quarters.rem_euclid(4.0) as u8 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_results_that_the_reference_lists() {
        // spec/coordinated-instructions.md §19.2: an orientation, and the transformed [1, 2, 3].
        #[rustfmt::skip]
        let cases = [
            ([0.0, 0.0, 0.0],       [1.0, 2.0, 3.0]),
            ([90.0, 0.0, 0.0],      [1.0, 3.0, -2.0]),
            ([0.0, 90.0, 0.0],      [-3.0, 2.0, 1.0]),
            ([0.0, 0.0, 90.0],      [2.0, -1.0, 3.0]),
            ([90.0, 90.0, 0.0],     [-3.0, 1.0, -2.0]),
            ([90.0, 0.0, 90.0],     [2.0, 3.0, 1.0]),
            ([0.0, 90.0, 90.0],     [-3.0, -1.0, 2.0]),
            ([90.0, 90.0, 90.0],    [-3.0, 2.0, 1.0]),
            ([-90.0, -90.0, -90.0], [3.0, -2.0, 1.0]),
        ];
        for (orientation, expected) in cases {
            let frame = Frame::new(Point::from(orientation), Point::zeros());
            let placed = frame.transform_point(&Point::new(1.0, 2.0, 3.0));
            assert_eq!(placed, Point::from(expected), "{orientation:?}");
        }
    }

    #[test]
    fn rotation_comes_before_translation() {
        let frame = Frame::new(Point::new(0.0, 0.0, 90.0), Point::new(10.0, 20.0, 30.0));
        assert_eq!(
            frame.transform_point(&Point::new(1.0, 2.0, 3.0)),
            Point::new(12.0, 19.0, 33.0)
        );
        assert_eq!(
            frame.transform_vector(&Point::new(1.0, 2.0, 3.0)),
            Point::new(2.0, -1.0, 3.0)
        );
    }

    fn triple(range: f64) -> impl Strategy<Value = Point> {
        prop::array::uniform3(-range..range).prop_map(Point::from)
    }

    proptest! {
        #[test]
        fn there_and_back_is_where_it_was(o in triple(360.0), t in triple(1e3), p in triple(1e3)) {
            let frame = Frame::new(o, t);
            prop_assert!((frame.inverse_transform_point(&frame.transform_point(&p)) - p).abs().max() < 1e-11);
            prop_assert!((frame.inverse_transform_vector(&frame.transform_vector(&p)) - p).abs().max() < 1e-11);
            // Lengths stay.
            prop_assert!((frame.transform_vector(&p).norm() - p.norm()).abs() < 1e-10);
        }
    }
}
