//! The Gauss-Newton step of the timing alone.

use super::{Band, Here};
use crate::Point;
use crate::solve::optimise::Weights;
use crate::solve::problem::Problem;
use crate::timing::control_points::GIVEN;
use crate::tuning::TUNING;

/// The contribution of a barrier: its slope, and its curvature by axis and along two directions.
struct Barrier {
    slope: Point,
    axes: Point,
    /// Directions, each times the root of its curvature.
    along: [Point; 2],
    /// The number of directions in use.
    directions: usize,
}

impl Barrier {
    /// The barrier of the limits of the axes and of the vector.
    #[inline(always)]
    fn new(value: &Point, inverse: &Point, vector: f64, share: f64) -> Barrier {
        let mut barrier = Barrier {
            slope: Point::zeros(),
            axes: Point::zeros(),
            along: [Point::zeros(); 2],
            directions: 0,
        };
        for axis in 0..3 {
            let inverse = inverse[axis] * share;
            let x = value[axis] * inverse;
            let by = inverse / (1.0 - x * x);
            barrier.slope[axis] = 2.0 * x * by;
            barrier.axes[axis] = 2.0 * (1.0 + x * x) * by * by;
        }
        if vector > 0.0 {
            let square = vector * share * vector * share;
            let scale = 2.0 * square / (1.0 - value.norm_squared() * square);
            barrier.slope += value * scale;
            barrier.axes.add_scalar_mut(scale);
            barrier.push(value * scale);
        }
        barrier
    }

    #[inline(always)]
    fn push(&mut self, direction: Point) {
        self.along[self.directions] = direction;
        self.directions += 1;
    }

    /// Adds the limits along a tangent and against it.
    #[inline(always)]
    fn tangential(&mut self, value: &Point, tangent: &Point, [up, down]: [f64; 2]) {
        if up > 0.0 {
            let x = tangent.dot(value);
            let (a, b) = (up / (1.0 - x * up), down / (1.0 + x * down));
            self.slope += tangent * (a - b);
            self.push(tangent * libm::sqrt(a * a + b * b));
        }
    }

    /// Adds slope and curvature for derivatives of the value by the spans from the `from`-th of five on.
    #[inline(always)]
    fn add<const N: usize>(&self, weight: f64, by: &[Point; N], from: usize, local: &mut Local) {
        for r in 0..N {
            local.slopes[from + r] += weight * self.slope.dot(&by[r]);
            let weighted = self.axes.component_mul(&by[r]) * weight;
            for c in 0..=r {
                local.values[from + r][r - c] += weighted.dot(&by[c]);
            }
        }
        for direction in &self.along[..self.directions] {
            let parts: [f64; N] = core::array::from_fn(|k| direction.dot(&by[k]));
            for r in 0..N {
                let weighted = parts[r] * weight;
                for c in 0..=r {
                    local.values[from + r][r - c] += weighted * parts[c];
                }
            }
        }
    }
}

/// The part of matrix and gradient for one interval: the spans `i - 2..=i + 2`.
struct Local {
    values: [[f64; 5]; 5],
    slopes: [f64; 5],
}

impl Here {
    /// Derivatives of the velocity of interval `i` by the logarithms of the spans `i - 1..=i + 1`.
    #[inline(always)]
    fn velocity_by(&self) -> [Point; 3] {
        let fade = self.velocities[1] * (-self.wide[1] / 3.0);
        [fade * self.spans[1], fade * self.spans[2], fade * self.spans[3]]
    }

    /// Derivatives of the acceleration at node `i + k` by the spans from `i - 2 + k` on.
    #[inline(always)]
    fn acceleration_by(&self, k: usize) -> [Point; 4] {
        let before = self.velocities[k] * (-self.wide[k] / 3.0);
        let behind = self.velocities[k + 1] * (-self.wide[k + 1] / 3.0);
        let rate = self.rates[k];
        let both = (behind - before - self.accelerations[k] * 0.5) * rate;
        [before * -rate, both, both, behind * rate]
    }
}

impl Problem<'_> {
    /// The matrix, and the negative gradient, for the timing alone.
    pub(crate) fn assemble_timing(&self, weights: Weights, spans: &[f64], matrix: &mut Band, right: &mut [f64]) {
        matrix.clear();
        right.fill(0.0);
        for (i, &span) in spans.iter().enumerate() {
            right[i] = -weights.gradient * span;
            matrix.row(i)[0] = weights.matrix * span;
        }
        let n = self.intervals();
        let [first_velocity, first_acceleration, first_jerk] = self.firsts();
        self.walk(spans, |i, here| {
            let limits = &self.limits[i.clamp(0, n) as usize];
            let counted = self.counted(i);
            let mut local = Local {
                values: [[0.0; 5]; 5],
                slopes: [0.0; 5],
            };
            if i >= first_velocity.max(0) && i < n {
                let [share, weight] = counted[0];
                let barrier = Barrier::new(&here.velocities[1], &limits.speed, limits.vector_speed, share);
                barrier.add(weight, &here.velocity_by(), 1, &mut local);
            }
            let early = here.acceleration_by(0);
            let by = |k: usize| early[k] * here.spans[k];
            if i >= first_acceleration.max(0) {
                let [share, weight] = counted[1];
                let acceleration = &here.accelerations[0];
                let (axes, vector) = (&limits.acceleration, limits.vector_acceleration);
                let mut barrier = Barrier::new(acceleration, axes, vector, share);
                let along = [limits.speeding_up * share, limits.slowing_down * share];
                barrier.tangential(acceleration, &self.tangents[i as usize], along);
                barrier.add(weight, &[by(0), by(1), by(2), by(3)], 0, &mut local);
            }
            if i >= first_jerk && limits.has_jerk() {
                let [share, weight] = counted[2];
                let late = here.acceleration_by(1);
                let part = |k: usize| here.spans[k] * here.inverse;
                let by = [
                    early[0] * -part(0),
                    (late[0] - early[1]) * part(1),
                    late[1] - early[2] - here.jerk,
                    (late[2] - early[3]) * part(3),
                    late[3] * part(4),
                ];
                let barrier = Barrier::new(&here.jerk, &limits.jerk, limits.vector_jerk, share);
                barrier.add(weight, &by, 0, &mut local);
            }
            scatter(i, n, &local, matrix, right);
        });
        if self.continues {
            for k in 0..GIVEN {
                matrix.fix(k);
                right[k] = 0.0;
            }
        }
        let last = self.points.len() - 1;
        matrix.fix(last);
        right[last] = 0.0;
        matrix.lift(TUNING.barrier.lift);
    }
}

/// Adds the part for one interval to the whole. Beyond the ends the span is that of the end.
#[inline(always)]
fn scatter(i: isize, n: isize, local: &Local, matrix: &mut Band, right: &mut [f64]) {
    if i >= 2 && i + 2 < n {
        let first = (i - 2) as usize;
        for r in 0..5 {
            right[first + r] -= local.slopes[r];
            let row = matrix.row(first + r);
            for left in 0..=r {
                row[left] += local.values[r][left];
            }
        }
        return;
    }
    let variable = |k: usize| (i - 2 + k as isize).clamp(0, n - 1) as usize;
    for r in 0..5 {
        let row = variable(r);
        right[row] -= local.slopes[r];
        for left in 0..=r {
            let column = variable(r - left);
            let both = if row == column && left > 0 { 2.0 } else { 1.0 };
            matrix.row(row)[row - column] += both * local.values[r][left];
        }
    }
}
