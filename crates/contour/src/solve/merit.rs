//! The objective of the optimisation: `weight * time - sum of log(slack)` over all limited quantities.

use crate::Point;
use crate::solve::problem::Problem;

impl Problem<'_> {
    /// The least slack of the limited quantities at each node.
    pub(crate) fn slacks(&self, points: &[Point], spans: &[f64], slacks: &mut [f64]) {
        slacks.fill(f64::INFINITY);
        for i in -1..=self.intervals() {
            let mut least = f64::INFINITY;
            self.for_each_quantity(i, points, spans, |q| {
                for axis in 0..3 {
                    let x = q.value[axis] * q.axes[axis];
                    least = least.min(1.0 - x * x);
                }
                least = least.min(1.0 - q.value.norm_squared() * q.vector * q.vector);
                let along = q.along.0.dot(&q.value);
                least = least.min(1.0 - along * q.along.1).min(1.0 + along * q.along.2);
            });
            let k = i.max(0) as usize;
            slacks[k] = slacks[k].min(least);
        }
        if self.lateral > 0 {
            for row in &self.corridor {
                let slack = row.slack(self.reference, points);
                slacks[row.first + 1] = slacks[row.first + 1].min(slack);
            }
        }
    }

    /// The objective; infinite outside the feasible set.
    pub(crate) fn merit(&self, time_weight: f64, points: &[Point], spans: &[f64]) -> f64 {
        let mut sum = 0.0;
        for span in spans {
            if span.is_nan() || *span <= 0.0 {
                return f64::INFINITY;
            }
            sum += time_weight * span;
        }
        for i in -1..=self.intervals() {
            let mut product = 1.0;
            let mut inside = true;
            let mut weighted = 0.0;
            self.for_each_quantity(i, points, spans, |q| {
                let others = core::mem::replace(&mut product, 1.0);
                for axis in 0..3 {
                    let x = q.value[axis] * q.axes[axis];
                    let slack = 1.0 - x * x;
                    inside &= slack > 0.0;
                    product *= slack;
                }
                if q.vector > 0.0 {
                    let slack = 1.0 - q.value.norm_squared() * q.vector * q.vector;
                    inside &= slack > 0.0;
                    product *= slack;
                }
                if q.along.1 > 0.0 {
                    let along = q.along.0.dot(&q.value);
                    let (up, down) = (1.0 - along * q.along.1, 1.0 + along * q.along.2);
                    inside &= up > 0.0 && down > 0.0;
                    product *= up * down;
                }
                if q.weight > 1.0 {
                    weighted += q.weight * libm::log(product);
                    product = 1.0;
                }
                product *= others;
            });
            if !inside {
                return f64::INFINITY;
            }
            sum -= libm::log(product) + weighted;
        }
        if self.lateral > 0 {
            for row in &self.corridor {
                let slack = row.slack(self.reference, points);
                if slack.is_nan() || slack <= 0.0 {
                    return f64::INFINITY;
                }
                sum -= libm::log(slack);
            }
        }
        sum
    }
}
