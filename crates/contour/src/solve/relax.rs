//! Starts outside the limits: a motion from rest is slowed down as a whole; a running motion starts with relaxed limits that tighten from step
//! to step, as the corridor does.

use crate::Point;
use crate::solve::problem::Problem;
use crate::timing::control_points::GIVEN;
use crate::tuning::{SlowDown, TUNING};

impl Problem<'_> {
    /// Lengthens all spans until every limit is kept with a margin.
    pub(crate) fn make_feasible(&mut self) {
        if self.continues {
            // A running motion cannot be slowed down as a whole: the limits are relaxed instead, and tighten.
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

    /// Lengthens the spans behind the given beginning, gradually. For the timing of an S-curve, it lengthens those near nodes outside the limits.
    /// Otherwise it lengthens all of them: for timing alone if any node is outside the limits, for timing and shape if at least half of the nodes
    /// exceed them by far.
    fn slow_down(&mut self) {
        let mut factors = vec![0.0; self.points.len()];
        self.for_each_quotient(&self.points, &self.spans, |i, [speed, acceleration, jerk]| {
            if let Some(factor) = usize::try_from(i).ok().and_then(|i| factors.get_mut(i)) {
                *factor = speed.max(acceleration.sqrt()).max(libm::cbrt(jerk));
            }
        });
        let behind = &mut factors[self.kept_nodes..];
        let count = behind.len();
        let outside = |most: f64| behind.iter().filter(|&&factor| factor > most).count();
        let slow = |factor: f64| factor / TUNING.relax.feasible;
        if self.is_timing() && self.slow_down == SlowDown::Outside && self.limits[0].has_jerk() {
            // At its rest, few nodes are slow, and they come inside without help.
            behind[count.saturating_sub(TUNING.relax.end_nodes)..].fill(0.0);
            for factor in behind.iter_mut() {
                *factor = if *factor > 1.0 { slow(*factor) } else { 1.0 };
            }
            spread(behind, TUNING.relax.spread_nodes);
        } else {
            let is_far = if self.is_timing() {
                outside(1.0) > 0
            } else {
                2 * outside(TUNING.relax.far) >= count
            };
            if !is_far {
                return;
            }
            let most = behind.iter().copied().fold(0.0, f64::max);
            behind.fill(slow(most));
        }
        for (k, (span, factor)) in self.spans[self.kept_nodes..].iter_mut().zip(behind).enumerate() {
            let u = (k as f64 / TUNING.relax.ramp_nodes).min(1.0);
            *span *= 1.0 + (*factor - 1.0) * u * u * (3.0 - 2.0 * u);
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

    /// Tightens relaxed limits, as [`Problem::close_in`] does with the corridor. Returns true if there are relaxed limits.
    pub(crate) fn tighten_limits(&mut self, points: &[Point], spans: &[f64]) -> bool {
        if !self.relaxed.iter().flatten().any(|&share| share < 1.0) {
            return false;
        }
        // Without relaxed limits, the quotients are those of the full limits.
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

    /// How far the most relaxed limit is from the full one: 0 to 1, as a share of the relaxed limit.
    pub(crate) fn most_relaxed(&self) -> f64 {
        1.0 - self.relaxed.iter().flatten().copied().fold(1.0, f64::min)
    }

    pub(crate) fn is_relaxed(&self) -> bool {
        let full = |k: usize| if k < GIVEN + 2 { TUNING.relax.near_full } else { 1.0 };
        let mut relaxed = self.relaxed.iter().enumerate();
        relaxed.any(|(k, shares)| shares.iter().any(|&share| share < full(k)))
    }
}

/// Replaces each value by the largest one within this number of nodes to either side, and evens the transitions.
fn spread(values: &mut [f64], nodes: usize) {
    let about = |k: usize| k.saturating_sub(nodes)..(k + nodes + 1).min(values.len());
    let most: Vec<f64> = (0..values.len())
        .map(|k| values[about(k)].iter().copied().fold(0.0, f64::max))
        .collect();
    let half = nodes / 2;
    let means = |values: &[f64]| -> Vec<f64> {
        let about = |k: usize| k.saturating_sub(half)..(k + half + 1).min(values.len());
        (0..values.len())
            .map(|k| values[about(k)].iter().sum::<f64>() / about(k).len() as f64)
            .collect()
    };
    values.copy_from_slice(&means(&means(&most)));
}

/// The initial room for a quotient of 1 or more.
fn first_slack(off: f64) -> f64 {
    if off < 1.0 - TUNING.relax.inside {
        0.0
    } else if off < 1.0 + TUNING.relax.least_share {
        TUNING.relax.least_share * off
    } else {
        TUNING.relax.widen_share * off
    }
}
