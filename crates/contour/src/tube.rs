//! The tube about the course, as convex conditions on points of the curve.

use crate::Point;
use crate::course::{Course, nearest};

/// A point of the curve that must be near one piece of the course: a knot, or the point between two
/// knots that stands for a joint and must be near both its pieces. As every piece's tube is convex
/// (a line's, and nearly an arc's), the curve between the points is inside too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TubeRow {
    /// The point is a weighted sum of four nodes from this one on.
    pub(crate) first: usize,
    pub(crate) weights: [f64; 4],
    pub(crate) piece: usize,
    pub(crate) target: f64,
    pub(crate) radius: f64,
}

impl TubeRow {
    /// The curve at a part of the way from knot `k` to the next, `0 < k`, `k + 2 < count`.
    pub(crate) fn new(k: usize, part: f64, piece: usize, radius: f64) -> TubeRow {
        let (here, next) = (1.0 - part, part);
        TubeRow {
            first: k - 1,
            weights: [
                KNOT[0] * here,
                KNOT[1] * here + KNOT[0] * next,
                KNOT[2] * here + KNOT[1] * next,
                KNOT[2] * next,
            ],
            piece,
            target: radius,
            radius,
        }
    }

    /// From the nearest point of the piece.
    pub(crate) fn off(&self, course: &Course, points: &[Point]) -> Point {
        let p = &points[self.first..self.first + 4];
        let w = &self.weights;
        let at = p[0] * w[0] + p[1] * w[1] + p[2] * w[2] + p[3] * w[3];
        at - nearest(&course.pieces[self.piece], &at)
    }

    pub(crate) fn slack(&self, course: &Course, points: &[Point]) -> f64 {
        1.0 - self.off(course, points).norm_squared() / (self.radius * self.radius)
    }
}

/// Weights of the nodes about a knot (for even spans; the tube leaves room for uneven ones).
const KNOT: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];
