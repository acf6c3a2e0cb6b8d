//! The objective and the least slacks for the optimisation of the timing alone.

use super::Here;
use crate::Point;
use crate::solve::problem::{NodeLimits, Problem};
use crate::tuning::TUNING;

/// The logarithm of a product of many factors, calculated as rarely as the range of numbers permits.
struct LogSum {
    product: f64,
    sum: f64,
}

impl LogSum {
    #[inline(always)]
    fn add(&mut self, factor: f64) {
        self.product *= factor;
        if !(TUNING.barrier.least_product..=TUNING.barrier.most_product).contains(&self.product) {
            self.sum += libm::log(self.product);
            self.product = 1.0;
        }
    }

    fn value(&self) -> f64 {
        self.sum + libm::log(self.product)
    }
}

/// Slacks of one node.
struct Slacks {
    least: f64,
    product: f64,
}

impl Slacks {
    #[inline(always)]
    fn take(&mut self, slack: f64) {
        self.least = self.least.min(slack);
        self.product *= slack;
    }

    #[inline(always)]
    fn axes(&mut self, value: &Point, inverse: &Point, share: f64) {
        for axis in 0..3 {
            let x = value[axis] * inverse[axis] * share;
            self.take(1.0 - x * x);
        }
    }

    #[inline(always)]
    fn vector(&mut self, value: &Point, inverse: f64, share: f64) {
        if inverse > 0.0 {
            let inverse = inverse * share;
            self.take(1.0 - value.norm_squared() * inverse * inverse);
        }
    }

    #[inline(always)]
    fn along(&mut self, value: &Point, tangent: &Point, limits: &NodeLimits, share: f64) {
        if limits.speeding_up > 0.0 {
            let along = tangent.dot(value) * share;
            self.take(1.0 - along * limits.speeding_up);
            self.take(1.0 + along * limits.slowing_down);
        }
    }
}

impl Problem<'_> {
    /// [`Problem::merit`] for the timing alone; sets the least slacks by node. Infinite outside the feasible set.
    pub(crate) fn timing_merit(&self, time_weight: f64, spans: &[f64], slacks: &mut [f64]) -> f64 {
        slacks.fill(f64::INFINITY);
        let mut time = 0.0;
        let mut valid = true;
        for span in spans {
            valid &= *span > 0.0;
            time += span;
        }
        let n = self.intervals();
        let firsts = self.firsts();
        let mut logs = LogSum { product: 1.0, sum: 0.0 };
        let mut weighted = 0.0;
        let mut least = f64::INFINITY;
        self.walk(spans, |i, here| {
            let node = i.clamp(0, n) as usize;
            let limits = &self.limits[node];
            let counted = self.counted(i);
            let mut add = |kind: usize, of_kind: Slacks| {
                let [_, weight] = counted[kind];
                slacks[node] = slacks[node].min(of_kind.least);
                least = least.min(of_kind.least);
                if weight == 1.0 {
                    logs.add(of_kind.product);
                } else {
                    weighted += weight * libm::log(of_kind.product);
                }
            };
            for (kind, first) in firsts.into_iter().enumerate() {
                if i >= first
                    && let Some(of_kind) = self.slacks_of(kind, i, here, limits, counted[kind][0])
                {
                    add(kind, of_kind);
                }
            }
        });
        if !valid || least <= 0.0 {
            return f64::INFINITY;
        }
        time_weight * time - logs.value() - weighted
    }

    #[inline(always)]
    fn slacks_of(&self, kind: usize, i: isize, here: &Here, limits: &NodeLimits, share: f64) -> Option<Slacks> {
        let mut slacks = Slacks {
            least: f64::INFINITY,
            product: 1.0,
        };
        match kind {
            0 if i >= 0 && i < self.intervals() => {
                let velocity = &here.velocities[1];
                slacks.axes(velocity, &limits.speed, share);
                slacks.vector(velocity, limits.vector_speed, share);
            }
            1 if i >= 0 => {
                let acceleration = &here.accelerations[0];
                slacks.axes(acceleration, &limits.acceleration, share);
                slacks.vector(acceleration, limits.vector_acceleration, share);
                slacks.along(acceleration, &self.tangents[i as usize], limits, share);
            }
            2 if limits.has_jerk() => {
                slacks.axes(&here.jerk, &limits.jerk, share);
                slacks.vector(&here.jerk, limits.vector_jerk, share);
            }
            _ => return None,
        }
        Some(slacks)
    }

    /// The largest quotients of speed, acceleration and jerk at each node from -1 on.
    pub(crate) fn timing_quotients(&self, spans: &[f64], mut take: impl FnMut(isize, [f64; 3])) {
        let n = self.intervals();
        let [first_velocity, first_acceleration, first_jerk] = self.firsts();
        let most = |value: &Point, inverse: &Point, vector: f64| {
            (0..3).fold(value.norm() * vector, |most, axis| {
                f64::max(most, (value[axis] * inverse[axis]).abs())
            })
        };
        self.walk(spans, |i, here| {
            let limits = &self.limits[i.clamp(0, n) as usize];
            let mut worst = [0.0; 3];
            if i >= first_velocity.max(0) && i < n {
                worst[0] = most(&here.velocities[1], &limits.speed, limits.vector_speed);
            }
            if i >= first_acceleration.max(0) {
                let acceleration = &here.accelerations[0];
                let along = self.tangents[i as usize].dot(acceleration);
                worst[1] = most(acceleration, &limits.acceleration, limits.vector_acceleration)
                    .max(along * limits.speeding_up)
                    .max(-along * limits.slowing_down);
            }
            if i >= first_jerk && limits.has_jerk() {
                worst[2] = most(&here.jerk, &limits.jerk, limits.vector_jerk);
            }
            take(i, worst);
        });
    }
}
