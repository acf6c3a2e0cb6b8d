//! How much of the tolerance the knots may use, so that the curve between them stays inside.
//!
//! Between two knots the curve may be farther off than at both, most of all where it crosses the
//! bisector of a sharp corner. What is measured there is taken from the tube of the next run.

use crate::Trajectory;
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
    pub(crate) fn narrow(&mut self, worst: f64) {
        let factor = (TARGET / worst).min(1.0);
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
        tolerances: &[f64],
    ) -> f64 {
        let mut worst = 0.0_f64;
        let last = nodes.points.len() - 1;
        let mut noted = core::mem::take(&mut self.tightened);
        let old = noted.clone();
        for i in 0..last {
            let Some(knot) = nodes.knot_of(i) else { continue };
            let s = nodes.progress[i];
            let piece = course.piece_at(s);
            let tolerance = tolerance_at(course, tolerances, piece, s);
            let (here, next) = (&trajectory.knots[knot], &trajectory.knots[knot + 1]);
            let mut most = 0.0_f64;
            for part in 0..PARTS {
                let q = trajectory.at(here.time + (next.time - here.time) * part as f64 / PARTS as f64);
                let foot = course.foot(&q.position, piece).0;
                most = most.max((foot - q.position).norm());
            }
            if tolerance <= 0.0 {
                continue;
            }
            let quotient = most / tolerance;
            worst = worst.max(quotient);
            if quotient > INSIDE {
                let before = nodes.progress[i.saturating_sub(1)];
                let behind = nodes.progress[(i + 2).min(last)];
                let now = old.iter().find(|e| e.0 <= s && s <= e.1).map_or(self.usual, |e| e.2);
                noted.push((before, behind, now * TARGET / quotient));
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

/// The tolerance about the course at arc length `s`: that of the nearer corner of the piece.
pub(crate) fn tolerance_at(course: &Course, tolerances: &[f64], piece: usize, s: f64) -> f64 {
    let middle = 0.5 * (course.starts[piece] + course.starts[piece + 1]);
    let (first, last) = (piece == 0, piece + 1 == course.pieces.len());
    match () {
        () if first && last => 0.0,
        () if first => tolerances[piece],
        () if last => tolerances[piece - 1],
        () if s < middle => tolerances[piece - 1],
        () => tolerances[piece],
    }
}

/// Share of the tolerance that knots use where nothing else is known.
const USUAL: f64 = 0.98;
/// Above this the tube is tightened, so that the quotient becomes `TARGET`.
const INSIDE: f64 = 0.999;
const TARGET: f64 = 0.975;
/// Points measured between two knots.
const PARTS: usize = 4;
