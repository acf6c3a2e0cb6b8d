//! What is optimised: timing and shape of one motion, and everything about it that is limited.
//!
//! Unknown are, for every node `p[i] = reference + normals * offset`, its offset, and for every
//! interval between nodes the logarithm of the time `h[i]` that it takes. The nodes are the control
//! points of a cubic B-spline in time, and what is limited are the control points of its derivatives:
//!
//! ```text
//! velocity[i]     = (p[i+1] - p[i]) 3 / (h[i-1] + h[i] + h[i+1])
//! acceleration[i] = (velocity[i] - velocity[i-1]) 2 / (h[i-1] + h[i])      at node i
//! jerk[i]         = (acceleration[i+1] - acceleration[i]) / h[i]           in interval i
//! ```
//!
//! The spline lies within the hull of its control points, so the limits hold at every instant. Not here: how a better one is
//! found ([`crate::optimise`]). Units: the nominal time between two nodes is 1 (limits are scaled to it), lengths are
//! position units.

use crate::Point;
use crate::course::Course;
use crate::ease::EASED;
use crate::tube::TubeRow;

/// Reciprocals of the limits at one node, 0 where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    pub(crate) speed: Point,
    pub(crate) acceleration: Point,
    pub(crate) jerk: Point,
    /// Of the vector.
    pub(crate) vector_speed: f64,
    pub(crate) vector_acceleration: f64,
    pub(crate) vector_jerk: f64,
    /// Along the path.
    pub(crate) speeding_up: f64,
    pub(crate) slowing_down: f64,
}

/// What is optimised. `LATERAL` is how many directions across the path a node may move in:
/// 0 (timing only), 1 (a plane) or 2 (space).
pub(crate) struct Problem<'a> {
    pub(crate) course: &'a Course,
    pub(crate) points: Vec<Point>,
    pub(crate) limits: Vec<Limits>,
    pub(crate) normals: Vec<[Point; 2]>,
    pub(crate) tangents: Vec<Point>,
    /// What keeps the curve near the course.
    pub(crate) tube: Vec<TubeRow>,
    /// Nodes that stay where they are.
    pub(crate) fixed: Vec<bool>,
    pub(crate) spans: Vec<f64>,
    pub(crate) lateral: usize,
    /// It continues a motion: the first nodes and spans are given.
    pub(crate) led: bool,
    /// How many nodes are close to what the running motion does.
    pub(crate) kept: usize,
    /// What is left of the reciprocal limits of speed, acceleration and jerk, by node from -1 on, where the start
    /// is outside of them; empty: all of it.
    pub(crate) ease: Vec<[f64; 3]>,
}

impl Problem<'_> {
    pub(crate) fn intervals(&self) -> isize {
        self.points.len() as isize - 1
    }

    fn span(spans: &[f64], i: isize) -> f64 {
        spans[i.clamp(0, spans.len() as isize - 1) as usize]
    }

    /// Velocity and jerk of interval `i` and the acceleration at node `i`, `-1 <= i <= intervals`.
    #[inline]
    pub(crate) fn for_each_quantity(&self, i: isize, points: &[Point], spans: &[f64], mut each: impl FnMut(Quantity)) {
        let n = self.intervals();
        let node = |k: isize| points[k.clamp(0, n) as usize];
        let span = |k: isize| Self::span(spans, k);
        let limits = &self.limits[i.clamp(0, n) as usize];
        let zero = Point::zeros();
        let none = (zero, 0.0, 0.0);
        let ease = self.ease.get((i + 1) as usize).copied().unwrap_or([1.0; 3]);
        let weights = ease.map(|ease| if ease < 1.0 { EASED } else { 1.0 });
        // What the given nodes and spans decide alone is not asked for.
        let free = |first: isize| !self.led || i >= first;
        // Index k stands for node or interval i - 2 + k.
        let tau = [span(i - 2), span(i - 1), span(i), span(i + 1), span(i + 2)];
        let p = [node(i - 1), node(i), node(i + 1), node(i + 2)];
        // The velocities of the intervals k = 1, 2, 3.
        let wide = [
            3.0 / (tau[0] + tau[1] + tau[2]),
            3.0 / (tau[1] + tau[2] + tau[3]),
            3.0 / (tau[2] + tau[3] + tau[4]),
        ];
        let v = [
            (p[1] - p[0]) * wide[0],
            (p[2] - p[1]) * wide[1],
            (p[3] - p[2]) * wide[2],
        ];
        let fade = [
            v[0] * (-wide[0] / 3.0),
            v[1] * (-wide[1] / 3.0),
            v[2] * (-wide[2] / 3.0),
        ];
        if i >= 0 && i < n && free(2) {
            each(Quantity {
                kind: 0,
                weight: weights[0],
                value: v[1],
                by_span: [zero, fade[1] * tau[1], fade[1] * tau[2], fade[1] * tau[3], zero],
                by_node: [0.0, -wide[1], wide[1], 0.0],
                axes: limits.speed * ease[0],
                vector: limits.vector_speed * ease[0],
                along: none,
            });
        }
        let (r0, r1) = (2.0 / (tau[1] + tau[2]), 2.0 / (tau[2] + tau[3]));
        let here = (v[1] - v[0]) * r0;
        let here_by = [
            fade[0] * -r0,
            (fade[1] - fade[0] - here * 0.5) * r0,
            (fade[1] - fade[0] - here * 0.5) * r0,
            fade[1] * r0,
        ];
        if i >= 0 && free(2) {
            each(Quantity {
                kind: 1,
                weight: weights[1],
                value: here,
                by_span: [
                    here_by[0] * tau[0],
                    here_by[1] * tau[1],
                    here_by[2] * tau[2],
                    here_by[3] * tau[3],
                    zero,
                ],
                by_node: [wide[0] * r0, -(wide[0] + wide[1]) * r0, wide[1] * r0, 0.0],
                axes: limits.acceleration * ease[1],
                vector: limits.vector_acceleration * ease[1],
                along: (
                    self.tangents[i as usize],
                    limits.speeding_up * ease[1],
                    limits.slowing_down * ease[1],
                ),
            });
        }
        if free(1) && (limits.jerk != zero || limits.vector_jerk > 0.0) {
            let next = (v[2] - v[1]) * r1;
            let next_by = [
                fade[1] * -r1,
                (fade[2] - fade[1] - next * 0.5) * r1,
                (fade[2] - fade[1] - next * 0.5) * r1,
                fade[2] * r1,
            ];
            let inverse = 1.0 / tau[2];
            let value = (next - here) * inverse;
            let relative = [
                tau[0] * inverse,
                tau[1] * inverse,
                1.0,
                tau[3] * inverse,
                tau[4] * inverse,
            ];
            each(Quantity {
                kind: 2,
                weight: weights[2],
                value,
                by_span: [
                    here_by[0] * -relative[0],
                    (next_by[0] - here_by[1]) * relative[1],
                    next_by[1] - here_by[2] - value,
                    (next_by[2] - here_by[3]) * relative[3],
                    next_by[3] * relative[4],
                ],
                by_node: [
                    -wide[0] * r0 * inverse,
                    (wide[1] * r1 + (wide[0] + wide[1]) * r0) * inverse,
                    -((wide[1] + wide[2]) * r1 + wide[1] * r0) * inverse,
                    wide[2] * r1 * inverse,
                ],
                axes: limits.jerk * ease[2],
                vector: limits.vector_jerk * ease[2],
                along: none,
            });
        }
    }
}

/// A vector that is limited, and what it depends on: spans of intervals `i-1..=i+1`, nodes `i-1..=i+2`.
pub(crate) struct Quantity {
    /// 0: velocity, 1: acceleration, 2: jerk.
    pub(crate) kind: usize,
    /// How much its barrier counts.
    pub(crate) weight: f64,
    pub(crate) value: Point,
    pub(crate) by_span: [Point; 5],
    pub(crate) by_node: [f64; 4],
    pub(crate) axes: Point,
    pub(crate) vector: f64,
    pub(crate) along: (Point, f64, f64),
}
