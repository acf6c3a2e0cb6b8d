//! How much of the tolerance the knots may use, so that the curve between them stays inside.
//!
//! Between two knots the curve may be farther off than at both, most of all where it crosses the
//! bisector of a sharp corner. What is measured there is taken from the tube of the next run.

use crate::Trajectory;
use crate::allowance::Allowance;
use crate::course::{Course, along};
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
        let mut edges = edges(trajectory, nodes, course, allowance).into_iter().peekable();
        for i in 0..last {
            let Some(knot) = nodes.knot_of(i) else { continue };
            let s = nodes.progress[i];
            let piece = course.piece_at(s);
            let (here, next) = (&trajectory.knots[knot], &trajectory.knots[knot + 1]);
            let used = |time: f64| allowance.used(course, &trajectory.at(time).position, piece, s);
            let mut most = 0.0_f64;
            let step = (next.time - here.time) / PARTS as f64;
            let mut parts = [0.0; PARTS + 1];
            for (part, share) in parts[..PARTS].iter_mut().enumerate() {
                *share = used(here.time + step * part as f64);
                most = most.max(*share);
            }
            if most > CLOSE && allowance.keeps_any() {
                parts[PARTS] = used(next.time);
                most = most.max(used(here.time + step * peak(&parts)));
            }
            while let Some(edge) = edges.next_if(|&edge| edge < next.time) {
                most = most.max(used(edge));
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

/// When the motion passes the places at which the tube stops narrowing, ascending.
fn edges(trajectory: &Trajectory, nodes: &Nodes, course: &Course, allowance: &Allowance) -> Vec<f64> {
    let last = nodes.progress.len() - 1;
    let knot_time = |node: usize| {
        let knot = nodes.knot_of(node).unwrap_or(0);
        trajectory.knots[knot].time
    };
    let time = |(piece, s): (usize, f64)| {
        let near = nodes.progress.partition_point(|&p| p < s).clamp(1, last);
        let (mut low, mut high) = (
            knot_time(near.saturating_sub(ABOUT)),
            knot_time((near + ABOUT).min(last)),
        );
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let q = trajectory.at(middle).position;
            if course.starts[piece] + along(&course.pieces[piece], &q) < s {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    };
    let mut times: Vec<f64> = allowance.edges(course).into_iter().map(time).collect();
    times.sort_by(f64::total_cmp);
    times
}

/// Where the largest of some values at 0, 1, ... is, by the parabola through the three about it.
fn peak(values: &[f64; PARTS + 1]) -> f64 {
    let best = (0..=PARTS)
        .max_by(|&a, &b| values[a].total_cmp(&values[b]))
        .unwrap_or(0);
    let middle = best.clamp(1, PARTS - 1);
    let [before, here, behind] = [values[middle - 1], values[middle], values[middle + 1]];
    let bend = before - 2.0 * here + behind;
    if bend >= 0.0 {
        return best as f64;
    }
    (middle as f64 + 0.5 * (before - behind) / bend).clamp(0.0, PARTS as f64)
}

/// Share of the tolerance that knots use where nothing else is known.
const USUAL: f64 = 0.98;
/// Above this the tube is tightened, so that the quotient becomes `TARGET`.
const INSIDE: f64 = 0.999;
const TARGET: f64 = 0.975;
/// Points measured between two knots.
const PARTS: usize = 4;
/// From this share on, the largest one between the measured points is looked for, where any piece is kept to.
const CLOSE: f64 = 0.5;
/// Nodes about a place between which the motion passes it.
const ABOUT: usize = 3;
const HALVINGS: u32 = 40;
