//! The unknown of a plan: control points of a spline in time, from rest or from the state of a running motion.

use crate::nominal::{NODE_TIME, grid};
use crate::{Point, State, Trajectory};

/// The curve as control points of a spline, evenly spaced in (nominal) time.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    pub(crate) points: Vec<Point>,
    /// Arc length of the course that each node stands for, ascending.
    pub(crate) progress: Vec<f64>,
    /// Seconds from node to node.
    pub(crate) spans: Vec<f64>,
    /// The motion that it continues, at the knot of node 1. The first three nodes and spans are given by it.
    pub(crate) lead: Option<State>,
    /// How many nodes are close to what the running motion does, and keep their knots from run to run.
    pub(crate) kept: usize,
}

/// Nodes and spans that a running motion gives.
pub(crate) const LEAD: usize = 3;

impl Nodes {
    /// Sets the first nodes, so that the curve is in the state of the lead at the knot of node 1.
    pub(crate) fn set_lead(&mut self) {
        let (Some(lead), &[h0, h1, h2, ..]) = (self.lead, self.spans.as_slice()) else {
            return;
        };
        // The span before the first one is as long as that.
        self.points[0] = blossom(&lead, [-2.0 * h0, -h0, 0.0]);
        self.points[1] = blossom(&lead, [-h0, 0.0, h1]);
        self.points[2] = blossom(&lead, [0.0, h1, h1 + h2]);
    }

    /// The motion. Its time begins at the lead where there is one.
    pub(crate) fn spline(&self, spans: &[f64]) -> Trajectory {
        let mut trajectory = Trajectory::spline(&self.points, spans);
        if let Some(lead) = self.lead {
            // What lies before the knot of node 1 is no part of it.
            trajectory.knots.drain(..2);
            let start = trajectory.knots[0].time;
            for knot in &mut trajectory.knots {
                knot.time -= start;
            }
            trajectory.knots[0].state = lead;
        }
        trajectory
    }

    /// The time of each node on the motion.
    pub(crate) fn times(&self, trajectory: &Trajectory) -> Vec<f64> {
        let count = self.points.len();
        match self.lead {
            None => trajectory.knots[1..=count].iter().map(|k| k.time).collect(),
            Some(_) => core::iter::once(-self.spans[0])
                .chain(trajectory.knots[..count - 1].iter().map(|k| k.time))
                .collect(),
        }
    }

    /// When the motion comes to a place of its course; `times` of the nodes.
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
        match self.lead {
            None => knot.saturating_sub(1),
            Some(_) => knot + 1,
        }
    }

    /// The knot of a node; `None` before the lead.
    pub(crate) fn knot_of(&self, node: usize) -> Option<usize> {
        match self.lead {
            None => Some(node + 1),
            Some(_) => node.checked_sub(1),
        }
    }
}

/// The control point of three knots, given relative to the instant of a state; one of them must be 0.
pub(crate) fn blossom(state: &State, knots: [f64; 3]) -> Point {
    let [a, b, c] = knots;
    state.position + state.velocity * ((a + b + c) / 3.0) + state.acceleration * ((a * b + b * c + c * a) / 6.0)
}

/// Knots of a motion that goes on from `kept` ones (at least [`LEAD`]` + 1`, ascending) until `whole`, close together where
/// it is busy. The last span is left out: there the motion comes to rest.
pub(crate) fn led_grid(mut kept: Vec<f64>, whole: f64, busy: &[(f64, f64)], fine: &[(f64, f64)]) -> Vec<f64> {
    let from = kept[kept.len() - 1];
    let mut shifted = vec![(0.0, NODE_TIME)];
    let later = busy.iter().filter(|(_, to)| *to > from);
    shifted.extend(later.map(|(begin, end)| ((begin - from).max(0.0), end - from)));
    let ahead = fine.iter().filter(|(_, to)| *to > from);
    let fine: Vec<(f64, f64)> = ahead.map(|(begin, end)| (begin - from, end - from)).collect();
    kept.extend(
        grid(whole - from, &shifted, &fine)
            .into_iter()
            .skip(1)
            .map(|time| time + from),
    );
    kept.pop();
    kept
}
