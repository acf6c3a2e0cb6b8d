//! Time warped at the ends of an S-curve. Seconds.

use crate::limits::{MoveLimits, Smoothness};

/// An S-curve leaves rest with `s = j t³/6`, not `a t²/2`: the warp makes the nodes near both ends follow the cube, so the timing has no
/// singular start.
pub(crate) struct Warp {
    total: f64,
    /// Acceleration over jerk at the start and at the end, seconds; 0: no warp.
    ratios: [f64; 2],
}

impl Warp {
    pub(crate) fn new(total: f64, first: f64, last: f64, bounds: &[MoveLimits], smoothness: Smoothness) -> Warp {
        let ratio = |rate: f64, bound: Option<&MoveLimits>| match (smoothness, bound) {
            (Smoothness::SCurve, Some(bound)) => (rate / bound.least_jerk()).min(total / 2.0),
            _ => 0.0,
        };
        Warp {
            total,
            ratios: [ratio(first, bounds.first()), ratio(last, bounds.last())],
        }
    }

    /// Warped time at a nominal one near one end.
    fn stretch_end(ratio: f64, t: f64) -> f64 {
        if t < 8.0 / 9.0 * ratio {
            libm::cbrt(3.0 * ratio * t * t)
        } else {
            t + 4.0 / 9.0 * ratio
        }
    }

    fn shrink_end(ratio: f64, t: f64) -> f64 {
        if t < 4.0 / 3.0 * ratio {
            (t * t * t / (3.0 * ratio)).sqrt()
        } else {
            t - 4.0 / 9.0 * ratio
        }
    }

    pub(crate) fn stretched(&self, total: f64) -> f64 {
        Warp::stretch_end(self.ratios[0], total / 2.0) + Warp::stretch_end(self.ratios[1], total / 2.0)
    }

    /// Warped time of a nominal one.
    pub(crate) fn warped(&self, t: f64) -> f64 {
        if t <= self.total / 2.0 {
            Warp::stretch_end(self.ratios[0], t)
        } else {
            self.stretched(self.total) - Warp::stretch_end(self.ratios[1], self.total - t)
        }
    }

    /// Nominal time of a warped one.
    pub(crate) fn nominal(&self, t: f64) -> f64 {
        let half = Warp::stretch_end(self.ratios[0], self.total / 2.0);
        if t <= half {
            Warp::shrink_end(self.ratios[0], t)
        } else {
            let rest = self.stretched(self.total) - t;
            self.total - Warp::shrink_end(self.ratios[1], rest.max(0.0))
        }
    }
}
