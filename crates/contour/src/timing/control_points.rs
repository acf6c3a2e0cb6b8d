//! The unknowns of a plan: control points of a spline in time, from rest or from the state of a running motion. Position units and
//! seconds.

use crate::path::reference::ReferencePath;
use crate::{AxesState, Point, Trajectory};

/// The curve as control points of a spline. A node is a control point with its instant.
#[derive(Clone, Debug)]
pub(crate) struct ControlPoints {
    pub(crate) points: Vec<Point>,
    /// Arc length of the reference path that corresponds to each node, ascending.
    pub(crate) progress: Vec<f64>,
    /// Seconds from node to node.
    pub(crate) spans: Vec<f64>,
    /// The state of the running motion that it continues, at the knot of node 1. It determines the first three nodes and spans.
    pub(crate) initial: Option<AxesState>,
    /// The number of nodes close to the running motion, which keep their knots from run to run.
    pub(crate) kept_nodes: usize,
    /// The number of nodes that stay on the curve of the running motion in the next smoothing.
    pub(crate) held_nodes: usize,
}

/// Nodes and spans that a running motion determines.
pub(crate) const GIVEN: usize = 3;

impl ControlPoints {
    /// Without control points, on the nodes of a grid, for a motion from rest.
    pub(crate) fn from_rest(grid: &[f64]) -> ControlPoints {
        ControlPoints {
            points: Vec::with_capacity(grid.len()),
            progress: Vec::with_capacity(grid.len()),
            spans: grid.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            initial: None,
            kept_nodes: 0,
            held_nodes: 0,
        }
    }

    /// Without control points, on the nodes of a grid, for the continuation of a motion from a state: its first `followed` nodes
    /// follow the motion.
    pub(crate) fn continuing(initial: AxesState, grid: &[f64], followed: usize) -> ControlPoints {
        ControlPoints {
            points: Vec::with_capacity(grid.len()),
            progress: Vec::with_capacity(grid.len()),
            spans: grid.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            initial: Some(initial),
            // The end of the followed part may become faster.
            kept_nodes: (followed * 2 / 3).max(GIVEN + 1).min(followed - 1),
            held_nodes: followed - 1,
        }
    }

    /// Completes the control points: the last one rests at the end of the reference path, and the first ones follow from the initial state.
    pub(crate) fn completed(mut self, reference: &ReferencePath) -> ControlPoints {
        let last = self.points.len() - 1;
        self.points[last] = reference.pieces[reference.pieces.len() - 1].end();
        self.progress[last] = reference.length();
        self.set_initial();
        self
    }

    /// Makes a continuation take so much longer, at its beginning least.
    pub(crate) fn stretch(&mut self, seconds: f64) {
        let free = self.spans.get_mut(GIVEN + 1..).unwrap_or_default();
        let count = free.len() as f64;
        // From 0 to 1 without a bend at either end.
        let weight = |place: usize| {
            let part = (place as f64 + 0.5) / count;
            part * part * (3.0 - 2.0 * part)
        };
        let whole: f64 = free.iter().enumerate().map(|(k, span)| weight(k) * span).sum();
        for (place, span) in free.iter_mut().enumerate() {
            *span *= 1.0 + seconds / whole * weight(place);
        }
    }

    /// Sets the first nodes such that the curve has the initial state at the knot of node 1.
    pub(crate) fn set_initial(&mut self) {
        let (Some(initial), &[h0, h1, h2, ..]) = (self.initial, self.spans.as_slice()) else {
            return;
        };
        // The span before the first one has the same length.
        self.points[0] = blossom(&initial, [-2.0 * h0, -h0, 0.0]);
        self.points[1] = blossom(&initial, [-h0, 0.0, h1]);
        self.points[2] = blossom(&initial, [0.0, h1, h1 + h2]);
    }

    /// The motion. Its time begins at the initial state, if there is one.
    pub(crate) fn spline(&self, spans: &[f64]) -> Trajectory {
        let mut trajectory = Trajectory::spline(&self.points, spans);
        if let Some(initial) = self.initial {
            // The part before the knot of node 1 does not belong to the motion.
            trajectory.knots.drain(..2);
            let start = trajectory.knots[0].time;
            for knot in &mut trajectory.knots {
                knot.time -= start;
            }
            trajectory.knots[0].state = initial;
        }
        trajectory
    }

    /// The time of each node on the motion.
    pub(crate) fn times(&self, trajectory: &Trajectory) -> Vec<f64> {
        let count = self.points.len();
        match self.initial {
            None => trajectory.knots[1..=count].iter().map(|k| k.time).collect(),
            Some(_) => core::iter::once(-self.spans[0])
                .chain(trajectory.knots[..count - 1].iter().map(|k| k.time))
                .collect(),
        }
    }

    /// The time at which the motion reaches arc length `s` of its reference path; `times` are those of the nodes.
    pub(crate) fn time_of(&self, s: f64, times: &[f64]) -> f64 {
        let k = self.progress.partition_point(|&p| p < s).clamp(1, times.len() - 1);
        let (p0, p1) = (self.progress[k - 1], self.progress[k]);
        let part = if p1 > p0 {
            ((s - p0) / (p1 - p0)).clamp(0.0, 1.0)
        } else {
            1.0
        };
        times[k - 1] + (times[k] - times[k - 1]) * part
    }

    /// The node of a knot of the motion.
    pub(crate) fn node_at(&self, knot: usize) -> usize {
        match self.initial {
            None => knot.saturating_sub(1),
            Some(_) => knot + 1,
        }
    }

    /// The knot of a node; `None` before the initial state.
    pub(crate) fn knot_of(&self, node: usize) -> Option<usize> {
        match self.initial {
            None => Some(node + 1),
            Some(_) => node.checked_sub(1),
        }
    }
}

/// The control point of three knots relative to the instant of a state; one of them must be 0.
pub(crate) fn blossom(state: &AxesState, knots: [f64; 3]) -> Point {
    let [a, b, c] = knots;
    state.position + state.velocity * ((a + b + c) / 3.0) + state.acceleration * ((a * b + b * c + c * a) / 6.0)
}
