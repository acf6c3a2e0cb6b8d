//! Starts that are outside the limits: from rest everything takes longer; a motion under way is started with relaxed limits
//! that close in from step to step, as the corridor does.

use crate::Point;
use crate::solve::problem::Problem;
use crate::timing::control_points::GIVEN;
use crate::tuning::TUNING;

impl Problem<'_> {
    /// Lengthens all spans until every limit is kept with room to spare.
    pub(crate) fn make_feasible(&mut self) {
        if self.continues {
            // A motion under way cannot be slowed down as a whole: the limits give way instead, and close in.
            self.slow_down();
            self.relaxed = vec![[0.0; 3]; self.points.len() + 1];
            return;
        }
        for _ in 0..TUNING.relax.lengthenings {
            if self.worst() < TUNING.relax.feasible {
                return;
            }
            for span in &mut self.spans {
                *span *= TUNING.relax.lengthen;
            }
        }
    }

    /// Lengthens the spans behind the given beginning, gradually, where most of what comes there is far from its limits.
    fn slow_down(&mut self) {
        let (mut most, mut far) = (0.0_f64, 0);
        self.for_each_quotient(&self.points, &self.spans, |i, [speed, acceleration, jerk]| {
            if i < self.kept as isize {
                return;
            }
            let factor = speed.max(acceleration.sqrt()).max(libm::cbrt(jerk));
            most = most.max(factor);
            far += usize::from(factor > TUNING.relax.far);
        });
        let wide = if self.is_timing() {
            most > TUNING.relax.far_timing
        } else {
            2 * far >= self.points.len() - self.kept
        };
        if !wide {
            return;
        }
        for (k, span) in self.spans.iter_mut().enumerate().skip(self.kept) {
            let u = ((k - self.kept) as f64 / TUNING.relax.ramp_nodes).min(1.0);
            *span *= 1.0 + (most / TUNING.relax.feasible - 1.0) * u * u * (3.0 - 2.0 * u);
        }
    }

    /// The largest quotient of a quantity and its limit.
    fn worst(&self) -> f64 {
        let mut worst = 0.0;
        self.for_each_quotient(&self.points, &self.spans, |_, quotients| {
            worst = quotients.into_iter().fold(worst, f64::max);
        });
        worst
    }

    /// The largest quotients of speed, acceleration and jerk at each node from -1 on.
    fn for_each_quotient(&self, points: &[Point], spans: &[f64], mut take: impl FnMut(isize, [f64; 3])) {
        if self.is_timing() {
            self.timing_quotients(spans, take);
            return;
        }
        for i in -1..=self.intervals() {
            take(i, self.quotients(i, points, spans));
        }
    }

    /// The largest quotients of speed, acceleration and jerk at one node.
    fn quotients(&self, i: isize, points: &[Point], spans: &[f64]) -> [f64; 3] {
        let mut worst = [0.0_f64; 3];
        self.for_each_quantity(i, points, spans, |q| {
            let most = &mut worst[q.kind as usize];
            for axis in 0..3 {
                *most = most.max((q.value[axis] * q.axes[axis]).abs());
            }
            *most = most.max(q.value.norm() * q.vector);
            let along = q.along.0.dot(&q.value);
            *most = most.max(along * q.along.1).max(-along * q.along.2);
        });
        worst
    }

    /// Closes relaxed limits in, as [`Problem::close_in`] does with the corridor. Whether there are such.
    pub(crate) fn tighten_limits(&mut self, points: &[Point], spans: &[f64]) -> bool {
        if !self.relaxed.iter().flatten().any(|&share| share < 1.0) {
            return false;
        }
        // Without them the quotients are those of the full limits.
        let mut relaxed = core::mem::take(&mut self.relaxed);
        self.for_each_quotient(points, spans, |i, worst| {
            let shares = &mut relaxed[(i + 1) as usize];
            for (share, off) in shares.iter_mut().zip(worst).filter(|(share, _)| **share < 1.0) {
                let slack = if *share > 0.0 {
                    (0.5 * (1.0 / *share - off)).max(TUNING.relax.least_share * off)
                } else {
                    first_slack(off)
                };
                *share = (1.0 / (off + slack).max(1.0)).max(*share);
            }
        });
        self.relaxed = relaxed;
        true
    }

    pub(crate) fn is_relaxed(&self) -> bool {
        let full = |k: usize| if k < GIVEN + 2 { TUNING.relax.near_full } else { 1.0 };
        let mut relaxed = self.relaxed.iter().enumerate();
        relaxed.any(|(k, shares)| shares.iter().any(|&share| share < full(k)))
    }
}

/// The room that a quotient of 1 or more is given at first.
fn first_slack(off: f64) -> f64 {
    if off < 1.0 - TUNING.relax.inside {
        0.0
    } else if off < 1.0 + TUNING.relax.least_share {
        TUNING.relax.least_share * off
    } else {
        TUNING.relax.widen_share * off
    }
}
