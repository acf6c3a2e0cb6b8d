//! The corridor about the reference path, as convex conditions on points of the curve.

use crate::Point;
use crate::path::reference::{ReferencePath, nearest};

/// A point of the curve that must be near one piece of the reference path: a knot, or a point between two knots at a joint, which must be
/// near both its pieces. As every piece's corridor is convex (a line's, and nearly an arc's), the curve between the points is inside, too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CorridorRow {
    /// The point is a weighted sum of four nodes from this one on.
    pub(crate) first: usize,
    pub(crate) weights: [f64; 4],
    pub(crate) piece: usize,
    pub(crate) target: f64,
    pub(crate) radius: f64,
    /// The share of the span behind its knot, if the point is exactly that of the curve.
    part: Option<f64>,
}

impl CorridorRow {
    /// The point at a share of the chord from knot `k` to the next, `0 < k`, `k + 2 < count`.
    pub(crate) fn new(k: usize, part: f64, piece: usize, radius: f64) -> CorridorRow {
        let (here, next) = (1.0 - part, part);
        CorridorRow {
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
            part: None,
        }
    }

    /// The same, but the exact point of the curve, at a share of the span behind knot `k`: on an arc, and in a narrow corridor.
    pub(crate) fn exact(k: usize, part: f64, piece: usize, radius: f64) -> CorridorRow {
        CorridorRow {
            part: Some(part),
            ..CorridorRow::new(k, part, piece, radius)
        }
    }

    pub(crate) fn is_exact(&self) -> bool {
        self.part.is_some()
    }

    /// Recalculates the weights for other spans.
    pub(crate) fn weigh(&mut self, spans: &[f64]) {
        let Some(part) = self.part else { return };
        let knot = self.first as isize + 1;
        let span = |k: isize| spans[(knot + k).clamp(0, spans.len() as isize - 1) as usize];
        // Instants of the surrounding knots, from the second one before; the point is at `t`.
        let t = part * span(0);
        let k = [
            -span(-2) - span(-1),
            -span(-1),
            0.0,
            span(0),
            span(0) + span(1),
            span(0) + span(1) + span(2),
        ];
        let share = |from: f64, to: f64| (t - from) / (to - from);
        // De Boor's algorithm on the weights.
        let mix = |a: [f64; 4], b: [f64; 4], share: f64| core::array::from_fn(|i| a[i] + (b[i] - a[i]) * share);
        let unit = |node: usize| core::array::from_fn(|i| if i == node { 1.0 } else { 0.0 });
        let first = mix(unit(0), unit(1), share(k[0], k[3]));
        let second = mix(unit(1), unit(2), share(k[1], k[4]));
        let third = mix(unit(2), unit(3), share(k[2], k[5]));
        let (left, right) = (
            mix(first, second, share(k[1], k[3])),
            mix(second, third, share(k[2], k[4])),
        );
        self.weights = mix(left, right, share(k[2], k[3]));
    }

    /// The offset of the point from the nearest point of the piece.
    pub(crate) fn off(&self, reference: &ReferencePath, points: &[Point]) -> Point {
        let p = &points[self.first..self.first + 4];
        let w = &self.weights;
        let at = p[0] * w[0] + p[1] * w[1] + p[2] * w[2] + p[3] * w[3];
        at - nearest(&reference.pieces[self.piece], &at)
    }

    pub(crate) fn slack(&self, reference: &ReferencePath, points: &[Point]) -> f64 {
        1.0 - self.off(reference, points).norm_squared() / (self.radius * self.radius)
    }
}

/// Weights of the nodes about a knot (for even spans; the corridor leaves room for uneven ones).
const KNOT: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];
