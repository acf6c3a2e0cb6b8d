//! How much of the tolerance the knots may use, so that the curve between them stays inside.
//!
//! Between two knots the curve may be farther off than at both, most of all where it crosses the
//! bisector of a sharp corner. What is measured there is taken from the tube of the next run.

use crate::Trajectory;
use crate::allowance::Allowance;
use crate::course::Course;
use crate::nodes::Nodes;

/// Shares of the tolerance by arc length of the course.
pub(crate) struct Share {
    /// Where it is less than usual: from, to, share.
    tightened: Vec<(f64, f64, f64)>,
    usual: f64,
}

impl Share {
    pub(crate) fn new() -> Share {
        Share {
            tightened: Vec::new(),
            usual: USUAL,
        }
    }

    /// The share at arc length `s`.
    pub(crate) fn at(&self, s: f64) -> f64 {
        let next = self.tightened.partition_point(|entry| entry.1 < s);
        match self.tightened.get(next) {
            Some(&(from, _, share)) if from <= s => share,
            _ => self.usual,
        }
    }

    /// Narrows the whole tube in proportion to what was measured.
    pub(crate) fn narrow(&mut self, worst: f64, allowance: &Allowance) {
        let factor = (TARGET / worst).clamp(allowance.least_share(), 1.0);
        self.usual *= factor;
        for entry in &mut self.tightened {
            entry.2 *= factor;
        }
    }

    /// Measures a trajectory and tightens the tube where it is outside; returns the largest quotient
    /// of a distance from the course and the tolerance.
    pub(crate) fn tighten(
        &mut self,
        trajectory: &Trajectory,
        nodes: &Nodes,
        course: &Course,
        allowance: &Allowance,
    ) -> f64 {
        let mut worst = 0.0_f64;
        let last = nodes.points.len() - 1;
        let mut noted = core::mem::take(&mut self.tightened);
        let old = noted.clone();
        for i in 0..last {
            let Some(knot) = nodes.knot_of(i) else { continue };
            let s = nodes.progress[i];
            let piece = course.piece_at(s);
            let (here, next) = (&trajectory.knots[knot], &trajectory.knots[knot + 1]);
            let mut most = 0.0_f64;
            for part in 0..PARTS {
                let q = trajectory.at(here.time + (next.time - here.time) * part as f64 / PARTS as f64);
                most = most.max(allowance.used(course, &q.position, piece, s));
            }
            worst = worst.max(most);
            if most > INSIDE {
                let before = nodes.progress[i.saturating_sub(1)];
                let behind = nodes.progress[(i + 2).min(last)];
                let now = old.iter().find(|e| e.0 <= s && s <= e.1).map_or(self.usual, |e| e.2);
                noted.push((before, behind, now * (TARGET / most).max(allowance.least_share())));
            }
        }
        noted.sort_by(|a, b| a.0.total_cmp(&b.0));
        for entry in noted {
            match self.tightened.last_mut() {
                Some(previous) if entry.0 <= previous.1 => {
                    previous.1 = previous.1.max(entry.1);
                    previous.2 = previous.2.min(entry.2);
                }
                _ => self.tightened.push(entry),
            }
        }
        worst
    }
}

/// Share of the tolerance that knots use where nothing else is known.
const USUAL: f64 = 0.98;
/// Above this the tube is tightened, so that the quotient becomes `TARGET`.
const INSIDE: f64 = 0.999;
const TARGET: f64 = 0.975;
/// Points measured between two knots.
const PARTS: usize = 4;
