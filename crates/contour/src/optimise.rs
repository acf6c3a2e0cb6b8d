//! The joint optimisation of timing and shape by a barrier method.
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
//! The spline lies within the hull of its control points, so the limits hold at every instant.
//!
//! Minimised is `t * time - sum of log(1 - (quantity / limit)²)` for growing `t`, by Gauss-Newton steps
//! on a band matrix; a step that would leave the feasible set is shortened, so **every iterate keeps
//! all limits and the tube**, and the work can end at any time. Units: the nominal time between two
//! nodes is 1 (limits are scaled to it), lengths are position units.

use crate::Point;
use crate::banded::Banded;
use crate::course::Course;
use crate::ease::{EASED, MOST_CLOSING};
use crate::steps::smooth_lengths;
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

/// How hard to work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    pub(crate) first: f64,
    pub(crate) last: f64,
    pub(crate) factor: f64,
    pub(crate) steps: usize,
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
                let narrower = self.narrow(&points);
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

/// Newton decrement per node at which a stage ends.
const CONVERGED: f64 = 1e-3;
/// A step that leaves less than this share of a slack is shortened.
const NEARER: f64 = 0.03;
/// Room that a point outside the tube is given, as a share of its distance.
const WIDEN: f64 = 0.02;
/// The logarithm of a span changes by no more than this in one step.
const MOST_CHANGE: f64 = 1.0;
