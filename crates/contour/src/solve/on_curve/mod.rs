//! The optimisation of the timing alone: the curve stays, and only the spans are unknown.
//!
//! The objective is that of [`crate::solve::problem`] with fewer unknowns, computed in one pass over the nodes: with one unknown per node all
//! derivatives are multiples of a few vectors, and the matrix has four entries beside its diagonal. Letters and units are those of
//! [`crate::solve::derivatives`].

mod band;
mod merit;
mod step;

pub(crate) use band::Band;

use crate::Point;
use crate::solve::problem::Problem;

/// Velocities, accelerations and the jerk at interval `i`.
struct Here {
    /// Spans of the intervals `i - 2..=i + 2`.
    spans: [f64; 5],
    /// The factors from a difference of nodes to a velocity, in the intervals `i - 1..=i + 1`.
    wide: [f64; 3],
    velocities: [Point; 3],
    /// The factors from a difference of velocities to an acceleration, at the nodes `i` and `i + 1`.
    rates: [f64; 2],
    accelerations: [Point; 2],
    /// The reciprocal of the span of interval `i`.
    inverse: f64,
    jerk: Point,
}

impl Problem<'_> {
    /// Visits the intervals from -1 to the one behind the last. Beyond the ends the motion rests, with the spans of the ends.
    #[inline(always)]
    fn walk(&self, spans: &[f64], mut visit: impl FnMut(isize, &Here)) {
        let n = self.intervals();
        let span = |k: isize| spans[k.clamp(0, n - 1) as usize];
        let difference = |k: isize| {
            if k < n {
                self.differences[k as usize]
            } else {
                Point::zeros()
            }
        };
        let wide = |a: f64, b: f64, c: f64| 3.0 / (a + b + c);
        let first = span(0);
        let velocity = difference(0) * wide(first, first, span(1));
        let rate = 1.0 / first;
        let mut here = Here {
            spans: [first, first, first, first, span(1)],
            wide: [1.0 / first, 1.0 / first, wide(first, first, span(1))],
            velocities: [Point::zeros(), Point::zeros(), velocity],
            rates: [rate, rate],
            accelerations: [Point::zeros(), velocity * rate],
            inverse: 1.0 / first,
            jerk: velocity * (rate / first),
        };
        let mut i = -1;
        loop {
            visit(i, &here);
            if i == n {
                return;
            }
            i += 1;
            let [_, b, c, d, e] = here.spans;
            let f = span(i + 2);
            here.spans = [b, c, d, e, f];
            let next = wide(d, e, f);
            here.wide = [here.wide[1], here.wide[2], next];
            let velocity = difference(i + 1) * next;
            here.velocities = [here.velocities[1], here.velocities[2], velocity];
            let rate = 2.0 / (d + e);
            here.rates = [here.rates[1], rate];
            here.accelerations = [here.accelerations[1], (velocity - here.velocities[1]) * rate];
            here.inverse = 1.0 / d;
            here.jerk = (here.accelerations[1] - here.accelerations[0]) * here.inverse;
        }
    }

    /// The first intervals whose velocity, acceleration and jerk count; those that depend on given nodes and spans only do not.
    fn firsts(&self) -> [isize; 3] {
        if self.continues { [2, 2, 1] } else { [0, 0, -1] }
    }

    /// The shares of the reciprocal limits at a node, and the weights of their barriers.
    #[inline(always)]
    fn counted(&self, i: isize) -> [[f64; 2]; 3] {
        if self.relaxed.is_empty() {
            return [[1.0, 1.0]; 3];
        }
        self.relaxed[(i + 1) as usize].map(|share| [share, Problem::weight_of(share)])
    }
}
