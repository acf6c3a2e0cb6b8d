//! The joint optimisation of timing and shape by a barrier method.
//!
//! The objective is `weight * time - sum of log(1 - (quantity / limit)²)` over the limited quantities of [`crate::solve::problem`]. It is
//! minimised for growing weights by Gauss-Newton steps on a band matrix; a step that would leave the feasible set is shortened, so **every
//! iterate keeps all limits and the corridor**, and the work can end at any time. Units are those of the problem.

use crate::Point;
use crate::solve::banded::Banded;
use crate::solve::on_curve::Band;
use crate::solve::problem::Problem;
use crate::solve::step_lengths::smooth_lengths;
use crate::solve::work::Work;
use crate::tuning::TUNING;

/// Weights of the time, and the largest number of steps for each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BarrierSchedule {
    pub(crate) first: f64,
    pub(crate) last: f64,
    pub(crate) factor: f64,
    pub(crate) steps: usize,
}

/// The weights of the time for one step. For the first step after an increase they differ: the matrix of the optimum for the lower weight gives the
/// tangent of the curve on which all optima are, and the step along it ends near the next one (a predictor step). With the matrix of the new weight, the
/// step would be as many times too long as the weight is larger.
#[derive(Clone, Copy)]
pub(crate) struct Weights {
    pub(crate) matrix: f64,
    pub(crate) gradient: f64,
}

impl Weights {
    /// The length of the step in units of the matrix's own.
    fn share(self) -> f64 {
        self.matrix / self.gradient
    }
}

/// How close relaxed limits have come to the full ones in the last steps.
struct Closing {
    /// The room of the most relaxed limit before each step, 0 to 1.
    rooms: Vec<f64>,
}

impl Closing {
    /// The limits hardly come closer.
    fn is_stalled(&mut self, room: f64) -> bool {
        let before = self.rooms.len().checked_sub(TUNING.relax.stalled_steps);
        let is_stalled = before.is_some_and(|k| room > (1.0 - TUNING.relax.stalled_share) * self.rooms[k]);
        self.rooms.push(room);
        is_stalled
    }
}

/// A motion within all limits.
#[derive(Clone)]
struct Iterate {
    offsets: Vec<[f64; 2]>,
    points: Vec<Point>,
    spans: Vec<f64>,
}

/// The working memory of the steps.
struct Search {
    now: Iterate,
    trial: Iterate,
    /// The matrix of timing and shape, and that of the timing alone; the unused one is empty.
    matrix: Banded,
    band: Band,
    gradient: Vec<f64>,
    /// The step of full length: for each node the logarithm of its span and its offsets.
    step: Vec<f64>,
    /// Least slacks by node.
    slack: Vec<f64>,
    trial_slack: Vec<f64>,
    /// Lengths of the step by node: as each node needs it, and smoothed.
    wanted: Vec<f64>,
    lengths: Vec<f64>,
}

impl Search {
    fn new(problem: &Problem<'_>) -> Search {
        let count = problem.points.len();
        let block = problem.block();
        let now = Iterate {
            offsets: vec![[0.0; 2]; count],
            points: problem.points.clone(),
            spans: problem.spans.clone(),
        };
        Search {
            trial: now.clone(),
            now,
            matrix: Banded::new(if problem.is_timing() { 0 } else { count * block }, 5 * block - 1),
            band: Band::new(if problem.is_timing() { count } else { 0 }),
            gradient: vec![0.0; count * block],
            step: vec![0.0; count * block],
            slack: vec![0.0; count],
            trial_slack: vec![0.0; count],
            wanted: vec![1.0; count],
            lengths: vec![1.0; count],
        }
    }
}

impl Problem<'_> {
    /// Improves `spans` and `points` in place, until the work is used up at the latest.
    pub(crate) fn run(&mut self, schedule: BarrierSchedule, work: &mut Work) {
        let mut search = Search::new(self);
        for row in &mut self.corridor {
            row.radius = f64::INFINITY;
        }
        self.close_in(&search.now);
        let mut weight = schedule.first;
        let mut before = None;
        let mut closing = Closing { rooms: Vec::new() };
        'weights: while !work.is_done() {
            let mut value = self.value(weight, &search.now, &mut search.slack);
            if !value.is_finite() {
                break;
            }
            let steps = if before.is_none() || weight >= schedule.last {
                schedule.steps
            } else {
                TUNING.barrier.steps_between
            };
            for step in 0..steps + TUNING.relax.most_closing {
                let is_relaxed = self.is_relaxed();
                // A higher weight requires the full limits first.
                if step >= steps && !is_relaxed {
                    break;
                }
                if is_relaxed && closing.is_stalled(self.most_relaxed()) {
                    break 'weights;
                }
                if self.close_in(&search.now) {
                    value = self.value(weight, &search.now, &mut search.slack);
                }
                let weights = Weights {
                    matrix: before.filter(|_| step == 0 && !is_relaxed).unwrap_or(weight),
                    gradient: weight,
                };
                let decrement = self.find_step(weights, &mut search);
                work.visit(self.points.len());
                let converged = -decrement < TUNING.barrier.converged * self.points.len() as f64;
                if !decrement.is_finite() || (converged && !self.is_relaxed()) {
                    break;
                }
                let Some(less) = self.take_step(weight, value, &mut search, work) else {
                    break;
                };
                value = less;
                if work.is_done() {
                    break;
                }
            }
            if weight >= schedule.last {
                break;
            }
            before = Some(weight);
            weight = (weight * schedule.factor).min(schedule.last);
        }
        self.points = search.now.points;
        self.spans = search.now.spans;
    }

    /// Unknowns for each node: its span and its offsets.
    pub(crate) fn block(&self) -> usize {
        1 + self.lateral
    }

    /// Tightens the corridor and the limits, which are wider for a start outside of them. Returns true if one of them has changed.
    fn close_in(&mut self, now: &Iterate) -> bool {
        let weighed = self.weigh_corridor(&now.points, &now.spans);
        let narrower = self.narrow_corridor(&now.points) || weighed;
        self.tighten_limits(&now.points, &now.spans) || narrower
    }

    /// Narrows the corridor to its target, but leaves room at a point outside: half of the room that it had or, if that is infinite,
    /// a share of the distance.
    fn narrow_corridor(&mut self, points: &[Point]) -> bool {
        let mut changed = false;
        for row in self.corridor.iter_mut().filter(|row| row.radius > row.target) {
            let off = row.off(self.reference, points).norm();
            let slack = if row.radius.is_finite() {
                0.5 * (row.radius - off)
            } else {
                TUNING.barrier.widen_share * off
            };
            row.radius = row.target.max(off + slack).min(row.radius);
            changed = true;
        }
        changed
    }

    /// Applies other spans to the exact points of the curve, and widens the corridor of a point that comes outside. Returns true if there is one.
    fn weigh_corridor(&mut self, points: &[Point], spans: &[f64]) -> bool {
        let mut changed = false;
        for row in self.corridor.iter_mut().filter(|row| row.is_exact()) {
            row.weigh(spans);
            let off = row.off(self.reference, points).norm();
            if off * (1.0 + TUNING.barrier.touching) > row.radius {
                row.radius = off * (1.0 + TUNING.barrier.reweighed);
            }
            changed = true;
        }
        changed
    }

    /// The Gauss-Newton step of full length; returns its Newton decrement, below 0.
    fn find_step(&self, weights: Weights, search: &mut Search) -> f64 {
        let Search {
            now,
            matrix,
            band,
            gradient,
            step,
            ..
        } = search;
        if self.is_timing() {
            self.assemble_timing(weights, &now.spans, band, step);
            gradient.copy_from_slice(step);
            band.solve(step);
        } else {
            self.assemble(weights, &now.points, &now.spans, matrix, step);
            gradient.copy_from_slice(step);
            matrix.solve(step);
        }
        for part in step.iter_mut() {
            *part *= weights.share();
        }
        -gradient.iter().zip(step.iter()).map(|(g, s)| g * s).sum::<f64>()
    }

    /// Takes the step, shortened near the nodes at which it would leave the feasible set. Returns the new value; `None` if no length of it is an
    /// improvement.
    fn take_step(&self, weight: f64, value: f64, search: &mut Search, work: &mut Work) -> Option<f64> {
        let block = self.block();
        for (i, length) in search.wanted.iter_mut().enumerate() {
            *length = (TUNING.barrier.most_change / search.step[i * block].abs()).min(1.0);
        }
        for attempt in 0..TUNING.barrier.attempts {
            smooth_lengths(&search.wanted, &mut search.lengths);
            let trial = self.try_step(weight, search);
            work.visit(self.points.len());
            let Search {
                gradient,
                step,
                lengths,
                ..
            } = &*search;
            let expected: f64 = (0..step.len())
                .map(|k| -gradient[k] * step[k] * lengths[k / block])
                .sum();
            if trial <= value + TUNING.barrier.sufficient * expected {
                core::mem::swap(&mut search.now, &mut search.trial);
                core::mem::swap(&mut search.slack, &mut search.trial_slack);
                return Some(trial);
            }
            search.shorten(attempt);
        }
        None
    }

    /// Tries the step with its smoothed lengths; returns the value there.
    fn try_step(&self, weight: f64, search: &mut Search) -> f64 {
        let block = self.block();
        let Search {
            now,
            trial,
            step,
            lengths,
            trial_slack,
            ..
        } = search;
        for i in 0..lengths.len() {
            for k in 0..self.lateral {
                trial.offsets[i][k] = now.offsets[i][k] + lengths[i] * step[i * block + 1 + k];
            }
        }
        for (i, span) in trial.spans.iter_mut().enumerate() {
            *span = now.spans[i] * libm::exp(lengths[i] * step[i * block]);
        }
        if self.lateral > 0 {
            for (i, point) in trial.points.iter_mut().enumerate() {
                let [first, second] = trial.offsets[i];
                *point = self.points[i] + self.normals[i][0] * first + self.normals[i][1] * second;
            }
        }
        self.value(weight, trial, trial_slack)
    }

    /// The objective; sets the least slacks by node. Infinite outside the feasible set.
    fn value(&self, weight: f64, at: &Iterate, slacks: &mut [f64]) -> f64 {
        if self.is_timing() {
            return self.timing_merit(weight, &at.spans, slacks);
        }
        self.slacks(&at.points, &at.spans, slacks);
        // Most attempts fail here.
        if slacks.iter().any(|&slack| slack <= 0.0) {
            return f64::INFINITY;
        }
        self.merit(weight, &at.points, &at.spans)
    }
}

impl Search {
    /// Shortens the step near the nodes that come too close to a limit; without such nodes, or after too many attempts, everywhere.
    fn shorten(&mut self, attempt: u32) {
        let mut local = false;
        if attempt < TUNING.barrier.local_attempts {
            for (i, length) in self.wanted.iter_mut().enumerate() {
                if self.trial_slack[i] < TUNING.barrier.nearer_share * self.slack[i] {
                    *length *= 0.5;
                    local = true;
                }
            }
        }
        if !local {
            for length in &mut self.wanted {
                *length *= 0.5;
            }
        }
    }
}
