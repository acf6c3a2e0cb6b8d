//! The share of the tolerance for the knots, such that the curve between them stays inside.
//!
//! Between two knots the curve may be farther off than at both, most of all where it crosses the bisector of a sharp corner. The excess that
//! is measured there narrows the corridor of the next run.

use arcline_profile::numeric::bisect;

use crate::path::allowance::Allowance;
use crate::path::reference::{ReferencePath, along};
use crate::timing::control_points::ControlPoints;
use crate::tuning::TUNING;
use crate::{Point, Trajectory};

/// Shares of the tolerance by arc length of the reference path.
pub(crate) struct ToleranceMargin {
    /// Stretches with a smaller share: from, to, share.
    tightened: Vec<(f64, f64, f64)>,
    usual: f64,
}

impl ToleranceMargin {
    pub(crate) fn new() -> ToleranceMargin {
        ToleranceMargin {
            tightened: Vec::new(),
            usual: TUNING.margin.usual_share,
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

    /// Narrows the whole corridor in proportion to the measured excess.
    pub(crate) fn narrow(&mut self, worst: f64, allowance: &Allowance) {
        let factor = (TUNING.margin.target / worst).clamp(least_factor(allowance), 1.0);
        self.usual *= factor;
        for entry in &mut self.tightened {
            entry.2 *= factor;
        }
    }

    /// Measures a trajectory and narrows the corridor where it is outside. Returns the largest quotient of a distance from the reference path and
    /// the tolerance.
    pub(crate) fn tighten(
        &mut self,
        trajectory: &Trajectory,
        control: &ControlPoints,
        reference: &ReferencePath,
        allowance: &Allowance,
    ) -> f64 {
        let mut worst = 0.0_f64;
        let last = control.points.len() - 1;
        let old = core::mem::take(&mut self.tightened);
        let mut noted = old.clone();
        let mut edges = edges(trajectory, control, reference, allowance).into_iter().peekable();
        for i in 0..last {
            let Some(knot) = control.knot_of(i) else { continue };
            let s = control.progress[i];
            let piece = reference.piece_at(s);
            let next = trajectory.knots[knot + 1].time;
            let at = |time: f64| trajectory.at(time).position;
            let mut near = piece;
            let mut used = |time: f64| allowance.used(reference, &at(time), (piece, s), &mut near);
            let from = trajectory.knots[knot].time;
            let mut most = most_between(from, next, allowance, &mut used);
            while let Some(edge) = edges.next_if(|&edge| edge < next) {
                most = most.max(used(edge));
            }
            for_each_joint([from, next], reference, piece, at, |time| most = most.max(used(time)));
            worst = worst.max(most);
            if most > TUNING.margin.inside {
                let before = control.progress[i.saturating_sub(1)];
                let behind = control.progress[(i + 2).min(last)];
                let now = old.iter().find(|e| e.0 <= s && s <= e.1).map_or(self.usual, |e| e.2);
                noted.push((
                    before,
                    behind,
                    now * (TUNING.margin.target / most).max(least_factor(allowance)),
                ));
            }
        }
        noted.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.merge(noted);
        worst
    }

    /// Joins overlapping stretches to one with the least share.
    fn merge(&mut self, ascending: Vec<(f64, f64, f64)>) {
        for entry in ascending {
            match self.tightened.last_mut() {
                Some(previous) if entry.0 <= previous.1 => {
                    previous.1 = previous.1.max(entry.1);
                    previous.2 = previous.2.min(entry.2);
                }
                _ => self.tightened.push(entry),
            }
        }
    }
}

/// The largest quotient by `used` from one instant until another.
fn most_between(from: f64, until: f64, allowance: &Allowance, mut used: impl FnMut(f64) -> f64) -> f64 {
    let mut most = 0.0_f64;
    let step = (until - from) / PARTS as f64;
    let mut parts = [0.0; PARTS + 1];
    for (part, quotient) in parts[..PARTS].iter_mut().enumerate() {
        *quotient = used(from + step * part as f64);
        most = most.max(*quotient);
    }
    if most > TUNING.margin.close && allowance.keeps_close_anywhere() {
        parts[PARTS] = used(until);
        most = most.max(used(from + step * peak(&parts)));
    }
    most
}

/// Calls `take` with the instants between two at which the motion is as far from both pieces at a joint: there it is farthest from the reference
/// path, which its samples miss. `hint`: a piece near the motion.
fn for_each_joint(
    [from, until]: [f64; 2],
    reference: &ReferencePath,
    hint: usize,
    at: impl Fn(f64) -> Point,
    mut take: impl FnMut(f64),
) {
    let first = reference.foot(&at(from), hint).1;
    let last = reference.foot(&at(until), first).1;
    for joint in first + 1..=last {
        let (before, behind) = (&reference.pieces[joint - 1], &reference.pieces[joint]);
        let (corner, forward) = (behind.start(), before.end_tangent() + behind.start_tangent());
        let beyond = |time: f64| (at(time) - corner).dot(&forward);
        let (mut low, mut high) = ((from, beyond(from)), (until, beyond(until)));
        // Its own loop, as it divides the bracket in proportion to the values at its ends, and every instant that it tries is a sample.
        for _ in 0..TUNING.margin.joint_steps {
            let part = (low.1 / (low.1 - high.1)).clamp(0.0, 1.0);
            let time = low.0 + (high.0 - low.0) * if part.is_finite() { part } else { 0.5 };
            let side = beyond(time);
            if side < 0.0 {
                low = (time, side);
            } else {
                high = (time, side);
            }
            take(time);
        }
    }
}

/// The instants at which the motion passes the points at which the corridor stops narrowing, ascending.
fn edges(
    trajectory: &Trajectory,
    control: &ControlPoints,
    reference: &ReferencePath,
    allowance: &Allowance,
) -> Vec<f64> {
    let last = control.progress.len() - 1;
    let knot_time = |node: usize| {
        let knot = control.knot_of(node).unwrap_or(0);
        trajectory.knots[knot].time
    };
    let time = |(piece, s): (usize, f64)| {
        let near = control.progress.partition_point(|&p| p < s).clamp(1, last);
        let before = knot_time(near.saturating_sub(TUNING.margin.edge_nodes));
        let behind = knot_time((near + TUNING.margin.edge_nodes).min(last));
        bisect(before, behind, TUNING.margin.edge_halvings, |time| {
            let q = trajectory.at(time).position;
            reference.starts[piece] + along(&reference.pieces[piece], &q) >= s
        })
    };
    let mut times: Vec<f64> = allowance.edges(reference).into_iter().map(time).collect();
    times.sort_by(f64::total_cmp);
    times
}

/// The location of the maximum of values at 0, 1, ..., by the parabola through three of them.
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

/// The least factor of one narrowing.
fn least_factor(allowance: &Allowance) -> f64 {
    if allowance.keeps_close_anywhere() {
        TUNING.margin.least_factor
    } else {
        0.0
    }
}

/// Points measured between two knots.
const PARTS: usize = TUNING.margin.parts;
