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
}

/// Nodes and spans that a running motion gives.
pub(crate) const LEAD: usize = 3;

impl Nodes {
    /// Sets the first nodes, so that the curve is in the state of the lead at the knot of node 1.
    pub(crate) fn set_lead(&mut self) {
        let Some(lead) = self.lead else { return };
        let h = self.spans[0];
        let middle = lead.position - lead.acceleration * (h * h / 6.0);
        let half = lead.acceleration * (h * h / 2.0);
        self.points[0] = middle - lead.velocity * h + half;
        self.points[1] = middle;
        self.points[2] = middle + lead.velocity * h + half;
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

/// [`grid`] for a motion that continues another one: its first spans are equal, and the second node is at 0.
pub(crate) fn led_grid(whole: f64, busy: &[(f64, f64)]) -> Vec<f64> {
    let mut shifted = vec![(0.0, 2.0 * LEAD as f64 * NODE_TIME)];
    shifted.extend(busy.iter().map(|(from, to)| (from + NODE_TIME, to + NODE_TIME)));
    let mut times = grid(whole + NODE_TIME, &shifted);
    let last = times.len() - 1;
    let (start, scale) = (times[1], whole / (times[last] - times[1]));
    for time in &mut times {
        *time = (*time - start) * scale;
    }
    let span = times[2];
    for (k, time) in times.iter_mut().enumerate().take(LEAD + 1) {
        *time = (k as f64 - 1.0) * span;
    }
    times[last] = whole;
    times
}
