//! The joint optimisation of timing and shape by a barrier method.
//!
//! Minimised is `t * time - sum of log(1 - (quantity / limit)²)` over what [`crate::problem`] limits, for growing `t`, by
//! Gauss-Newton steps on a band matrix; a step that would leave the feasible set is shortened, so **every iterate keeps
//! all limits and the tube**, and the work can end at any time. Units are those of the problem.

use crate::Point;
use crate::banded::Banded;
use crate::ease::MOST_CLOSING;
use crate::problem::Problem;
use crate::steps::smooth_lengths;

/// How hard to work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    pub(crate) first: f64,
    pub(crate) last: f64,
    pub(crate) factor: f64,
    pub(crate) steps: usize,
}

impl Problem<'_> {
    /// Narrows the tube to its target, but leaves room where the curve is outside: some of what there
    /// was, or where that is infinite, a share of the distance.
    fn narrow(&mut self, points: &[Point]) -> bool {
        let mut tube = core::mem::take(&mut self.tube);
        let mut changed = false;
        for row in tube.iter_mut().filter(|row| row.radius > row.target) {
            let off = row.off(self.course, points).norm();
            let slack = if row.radius.is_finite() {
                0.5 * (row.radius - off)
            } else {
                WIDEN * off
            };
            row.radius = row.target.max(off + slack).min(row.radius);
            changed = true;
        }
        self.tube = tube;
        changed
    }

    /// Takes other spans for the points of the curve that are exact; one that comes outside its tube has it widened. Whether there are such.
    fn weigh(&mut self, points: &[Point], spans: &[f64]) -> bool {
        let mut changed = false;
        for row in self.tube.iter_mut().filter(|row| row.is_exact()) {
            row.weigh(spans);
            let off = row.off(self.course, points).norm();
            if off * (1.0 + TOUCHING) > row.radius {
                row.radius = off * (1.0 + REWEIGHED);
            }
            changed = true;
        }
        changed
    }

    fn place(&self, offsets: &[[f64; 2]], points: &mut [Point]) {
        for (i, point) in points.iter_mut().enumerate() {
            *point = self.points[i] + self.normals[i][0] * offsets[i][0] + self.normals[i][1] * offsets[i][1];
        }
    }

    /// The least slack of what is limited at each node.
    fn slacks(&self, points: &[Point], spans: &[f64], slacks: &mut [f64]) {
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
            for row in &self.tube {
                let slack = row.slack(self.course, points);
                slacks[row.first + 1] = slacks[row.first + 1].min(slack);
            }
        }
    }

    /// The function to be minimised; infinite outside the feasible set.
    fn merit(&self, t: f64, points: &[Point], spans: &[f64]) -> f64 {
        let mut sum = 0.0;
        for span in spans {
            if span.is_nan() || *span <= 0.0 {
                return f64::INFINITY;
            }
            sum += t * span;
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
            for row in &self.tube {
                let slack = row.slack(self.course, points);
                if slack.is_nan() || slack <= 0.0 {
                    return f64::INFINITY;
                }
                sum -= libm::log(slack);
            }
        }
        sum
    }

    /// Improves `spans` and `points` in place; returns the number of steps taken.
    pub(crate) fn run(&mut self, effort: Effort) -> usize {
        let count = self.points.len();
        let block = 1 + self.lateral;
        let mut matrix = Banded::new(count * block, 5 * block - 1);
        let mut right = vec![0.0; count * block];
        let mut offsets = vec![[0.0; 2]; count];
        let mut points = self.points.clone();
        let mut spans = self.spans.clone();
        let (mut trial_offsets, mut trial_points, mut trial_spans) = (offsets.clone(), points.clone(), spans.clone());
        let mut t = effort.first;
        let mut steps = 0;
        let (mut slack, mut trial_slack) = (vec![0.0; count], vec![0.0; count]);
        let (mut wanted, mut lengths) = (vec![1.0; count], vec![1.0; count]);
        for row in &mut self.tube {
            row.radius = f64::INFINITY;
        }
        self.weigh(&points, &spans);
        self.narrow(&points);
        self.tighten(&points, &spans);
        loop {
            let mut value = self.merit(t, &points, &spans);
            if !value.is_finite() {
                break;
            }
            let last = t >= effort.last;
            for step in 0..effort.steps + MOST_CLOSING {
                // Before it works harder the limits have to be the full ones.
                if step >= effort.steps && !self.is_eased() {
                    break;
                }
                // Where the start is outside, the tube is wider and closes in from step to step.
                let weighed = self.weigh(&points, &spans);
                let narrower = self.narrow(&points) || weighed;
                if self.tighten(&points, &spans) || narrower {
                    value = self.merit(t, &points, &spans);
                }
                self.assemble(t, &points, &spans, &mut matrix, &mut right);
                let gradient = right.clone();
                matrix.solve(&mut right);
                let decrement: f64 = -gradient.iter().zip(&right).map(|(g, s)| g * s).sum::<f64>();
                steps += 1;
                if !decrement.is_finite() || (-decrement < CONVERGED * count as f64 && !self.is_eased()) {
                    break;
                }
                // Where a step would leave the feasible set it is shortened, there and about there.
                self.slacks(&points, &spans, &mut slack);
                for (i, length) in wanted.iter_mut().enumerate() {
                    *length = (MOST_CHANGE / right[i * block].abs()).min(1.0);
                }
                let mut step = |lengths: &[f64], trial_slack: &mut [f64]| {
                    for i in 0..count {
                        for k in 0..self.lateral {
                            trial_offsets[i][k] = offsets[i][k] + lengths[i] * right[i * block + 1 + k];
                        }
                    }
                    for (i, span) in trial_spans.iter_mut().enumerate() {
                        *span = spans[i] * libm::exp(lengths[i] * right[i * block]);
                    }
                    if self.lateral > 0 {
                        self.place(&trial_offsets, &mut trial_points);
                    }
                    self.slacks(&trial_points, &trial_spans, trial_slack);
                    self.merit(t, &trial_points, &trial_spans)
                };
                let mut improved = false;
                for attempt in 0..24 {
                    smooth_lengths(&wanted, &mut lengths);
                    let trial = step(&lengths, &mut trial_slack);
                    let expected: f64 = (0..right.len())
                        .map(|k| -gradient[k] * right[k] * lengths[k / block])
                        .sum();
                    if trial <= value + 1e-4 * expected {
                        value = trial;
                        improved = true;
                        break;
                    }
                    let mut local = false;
                    if attempt < 16 {
                        for i in 0..count {
                            if trial_slack[i] < NEARER * slack[i] {
                                wanted[i] *= 0.5;
                                local = true;
                            }
                        }
                    }
                    if !local {
                        for length in &mut wanted {
                            *length *= 0.5;
                        }
                    }
                }
                if !improved {
                    break;
                }
                core::mem::swap(&mut offsets, &mut trial_offsets);
                core::mem::swap(&mut points, &mut trial_points);
                core::mem::swap(&mut spans, &mut trial_spans);
            }
            if last {
                break;
            }
            t = (t * effort.factor).min(effort.last);
        }
        self.points = points;
        self.spans = spans;
        steps
    }
}

/// Newton decrement per node at which a stage ends.
const CONVERGED: f64 = 1e-3;
/// A step that leaves less than this share of a slack is shortened.
const NEARER: f64 = 0.03;
/// Room that a point outside the tube is given, as a share of its distance.
const WIDEN: f64 = 0.02;
/// A point that is so near to its tube's wall is outside for other spans, and how much room it is given.
const TOUCHING: f64 = 1e-5;
const REWEIGHED: f64 = 2e-3;
/// The logarithm of a span changes by no more than this in one step.
const MOST_CHANGE: f64 = 1.0;
