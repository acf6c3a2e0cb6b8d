//! Velocity, acceleration and jerk of the spline as control points, with their derivatives by nodes and spans.
//!
//! ```text
//! velocity[i]     = (p[i+1] - p[i]) 3 / (h[i-1] + h[i] + h[i+1])
//! acceleration[i] = (velocity[i] - velocity[i-1]) 2 / (h[i-1] + h[i])      at node i
//! jerk[i]         = (acceleration[i+1] - acceleration[i]) / h[i]           in interval i
//! ```

use crate::Point;
use crate::solve::problem::{NodeLimits, Problem};

/// A limited vector, and its dependence on the spans of intervals `i-2..=i+2` and the nodes `i-1..=i+2`.
pub(crate) struct Quantity {
    pub(crate) kind: Kind,
    /// The weight of its barrier.
    pub(crate) weight: f64,
    pub(crate) value: Point,
    pub(crate) by_span: [Point; 5],
    pub(crate) by_node: [f64; 4],
    /// Reciprocal limits of the axes and of the vector.
    pub(crate) axes: Point,
    pub(crate) vector: f64,
    /// A direction, and the reciprocal limits along and against it; 0 for none.
    pub(crate) along: (Point, f64, f64),
}

/// The kind of a limited quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Velocity,
    Acceleration,
    Jerk,
}

/// The nodes and spans about one interval. Index `k` stands for node or interval `i - 2 + k`.
struct Stencil {
    spans: [f64; 5],
    /// The factors from a difference of nodes to the velocity of the intervals `k` = 1, 2, 3.
    wide: [f64; 3],
    velocities: [Point; 3],
    /// Derivatives of the velocities by each of their spans.
    fade: [Point; 3],
}

impl Stencil {
    #[inline]
    fn new(points: [Point; 4], spans: [f64; 5]) -> Stencil {
        let [p0, p1, p2, p3] = points;
        let wide = [
            3.0 / (spans[0] + spans[1] + spans[2]),
            3.0 / (spans[1] + spans[2] + spans[3]),
            3.0 / (spans[2] + spans[3] + spans[4]),
        ];
        let velocities = [(p1 - p0) * wide[0], (p2 - p1) * wide[1], (p3 - p2) * wide[2]];
        let fade = [
            velocities[0] * (-wide[0] / 3.0),
            velocities[1] * (-wide[1] / 3.0),
            velocities[2] * (-wide[2] / 3.0),
        ];
        Stencil {
            spans,
            wide,
            velocities,
            fade,
        }
    }

    /// The velocity in the middle interval.
    #[inline]
    fn velocity(&self, limits: &NodeLimits, [share, weight]: [f64; 2]) -> Quantity {
        let Stencil { spans, wide, fade, .. } = self;
        Quantity {
            kind: Kind::Velocity,
            weight,
            value: self.velocities[1],
            by_span: [
                Point::zeros(),
                fade[1] * spans[1],
                fade[1] * spans[2],
                fade[1] * spans[3],
                Point::zeros(),
            ],
            by_node: [0.0, -wide[1], wide[1], 0.0],
            axes: limits.speed * share,
            vector: limits.vector_speed * share,
            along: (Point::zeros(), 0.0, 0.0),
        }
    }

    /// The acceleration between the intervals `k` and `k + 1`, its factor, and its derivatives by spans from `k - 1` on.
    #[inline]
    fn change(&self, k: usize) -> (Point, f64, [Point; 4]) {
        let Stencil {
            spans,
            velocities,
            fade,
            ..
        } = self;
        let rate = 2.0 / (spans[k] + spans[k + 1]);
        let value = (velocities[k] - velocities[k - 1]) * rate;
        let both = (fade[k] - fade[k - 1] - value * 0.5) * rate;
        (value, rate, [fade[k - 1] * -rate, both, both, fade[k] * rate])
    }

    /// The acceleration at the node before the middle interval.
    #[inline]
    fn acceleration(&self, limits: &NodeLimits, tangent: Point, [share, weight]: [f64; 2]) -> Quantity {
        let Stencil { spans, wide, .. } = self;
        let (value, rate, by) = self.change(1);
        Quantity {
            kind: Kind::Acceleration,
            weight,
            value,
            by_span: [
                by[0] * spans[0],
                by[1] * spans[1],
                by[2] * spans[2],
                by[3] * spans[3],
                Point::zeros(),
            ],
            by_node: [wide[0] * rate, -(wide[0] + wide[1]) * rate, wide[1] * rate, 0.0],
            axes: limits.acceleration * share,
            vector: limits.vector_acceleration * share,
            along: (tangent, limits.speeding_up * share, limits.slowing_down * share),
        }
    }

    /// The jerk in the middle interval.
    #[inline]
    fn jerk(&self, limits: &NodeLimits, [share, weight]: [f64; 2]) -> Quantity {
        let Stencil { spans, wide, .. } = self;
        let (here, r0, here_by) = self.change(1);
        let (next, r1, next_by) = self.change(2);
        let inverse = 1.0 / spans[2];
        let value = (next - here) * inverse;
        let relative = [
            spans[0] * inverse,
            spans[1] * inverse,
            1.0,
            spans[3] * inverse,
            spans[4] * inverse,
        ];
        Quantity {
            kind: Kind::Jerk,
            weight,
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
            axes: limits.jerk * share,
            vector: limits.vector_jerk * share,
            along: (Point::zeros(), 0.0, 0.0),
        }
    }
}

impl Problem<'_> {
    /// Velocity and jerk of interval `i` and the acceleration at node `i`, `-1 <= i <= intervals`.
    #[inline]
    pub(crate) fn for_each_quantity(&self, i: isize, points: &[Point], spans: &[f64], mut each: impl FnMut(Quantity)) {
        let n = self.intervals();
        let node = |k: isize| points[k.clamp(0, n) as usize];
        let span = |k: isize| spans[k.clamp(0, spans.len() as isize - 1) as usize];
        let limits = &self.limits[i.clamp(0, n) as usize];
        let relaxed = self.relaxed.get((i + 1) as usize).copied().unwrap_or([1.0; 3]);
        let counted = relaxed.map(|share| [share, Problem::weight_of(share)]);
        // Quantities that depend on given nodes and spans only are left out.
        let free = |first: isize| !self.continues || i >= first;
        let stencil = Stencil::new(
            [node(i - 1), node(i), node(i + 1), node(i + 2)],
            [span(i - 2), span(i - 1), span(i), span(i + 1), span(i + 2)],
        );
        if i >= 0 && i < n && free(2) {
            each(stencil.velocity(limits, counted[0]));
        }
        if i >= 0 && free(2) {
            each(stencil.acceleration(limits, self.tangents[i as usize], counted[1]));
        }
        if free(1) && limits.has_jerk() {
            each(stencil.jerk(limits, counted[2]));
        }
    }
}
