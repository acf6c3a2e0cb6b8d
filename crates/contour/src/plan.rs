//! From moves to a trajectory: sections from rest to rest, each rounded, timed and improved.

use crate::allowance::Begin;
use crate::rounding::Smoothness;
use crate::section::Section;
use crate::straight::straight;
use crate::trajectory::MoveEnd;
use crate::{AxisLimits, Bounds, ContourMove, Path, Point, Trajectory};

/// How much work a plan may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Timing only, on corners rounded one by one.
    Quick,
    /// Timing and shape together.
    Full,
}

/// Plans the moves from rest to rest; the last one ends exactly. Total: what cannot be rounded is
/// stopped at. An empty list gives a trajectory of no duration at the origin.
#[must_use]
pub fn plan(moves: &[ContourMove], limits: &AxisLimits) -> Trajectory {
    plan_with(moves, limits, Effort::Full)
}

/// [`plan`] with a choice of how much work it may be.
#[must_use]
pub fn plan_with(moves: &[ContourMove], limits: &AxisLimits, effort: Effort) -> Trajectory {
    let start = moves.first().map_or(Point::zeros(), |first| first.path.start());
    let mut whole = Trajectory::rest(start);
    let mut section: Vec<ContourMove> = Vec::new();
    for (index, next) in moves.iter().enumerate() {
        section.push(*next);
        let stops = moves.get(index + 1).is_none_or(|after| !can_pass(next, after));
        if stops {
            whole.append(plan_section(&section, limits, effort));
            section.clear();
        }
    }
    whole.planned_for(moves, limits)
}

/// Whether the joint between two moves can be passed without a stop.
pub(crate) fn can_pass(before: &ContourMove, after: &ContourMove) -> bool {
    if before.jerk.is_some() != after.jerk.is_some() {
        return false;
    }
    let tangent = (before.path.end_tangent() - after.path.start_tangent()).norm() <= TANGENT;
    tangent || before.tolerance > 0.0 || before.path.length() <= 0.0 || after.path.length() <= 0.0
}

/// Plans one section, as well as it can be done: what is outside the tube or the limits is planned
/// again with less freedom, at last with a stop at every joint.
fn plan_section(moves: &[ContourMove], limits: &AxisLimits, effort: Effort) -> Trajectory {
    let smoothness = smoothness(moves);
    let long: Vec<&ContourMove> = moves.iter().filter(|m| m.path.length() > SHORTEST).collect();
    let end = moves.last().map_or(Point::zeros(), |last| last.path.end());
    if let [one] = long.as_slice()
        && let Path::Line(line) = &one.path
    {
        let mut trajectory = straight(line, &bounds(one, limits, smoothness));
        let before = moves.iter().take_while(|m| m.path.length() <= SHORTEST).count();
        trajectory.move_ends = vec![MoveEnd::plain(0.0); before];
        trajectory
            .move_ends
            .resize(moves.len(), MoveEnd::plain(trajectory.duration()));
        trajectory.end = end;
        return trajectory;
    }
    if long.is_empty() {
        let mut rest = Trajectory::rest(end);
        rest.move_ends = vec![MoveEnd::plain(0.0); moves.len()];
        return rest;
    }
    let section = Section::new(moves, limits, Begin::Rest);
    let efforts: &[Effort] = match effort {
        Effort::Full => &[Effort::Full, Effort::Quick],
        Effort::Quick => &[Effort::Quick],
    };
    for &effort in efforts {
        if let Some(trajectory) = section.plan(effort) {
            return trajectory;
        }
    }
    if long.len() == 1 {
        return section.crawl();
    }
    let mut whole = Trajectory::rest(moves[0].path.start());
    for one in moves {
        whole.append(plan_section(core::slice::from_ref(one), limits, effort));
    }
    whole
}

/// How a section is rounded: an S-curve if any of its moves is one.
pub(crate) fn smoothness(moves: &[ContourMove]) -> Smoothness {
    if moves.iter().any(|m| m.jerk.is_some()) {
        Smoothness::SCurve
    } else {
        Smoothness::Trapezoid
    }
}

/// The limits of one move.
pub(crate) fn bounds(one: &ContourMove, axes: &AxisLimits, smoothness: Smoothness) -> Bounds {
    let scurve = smoothness == Smoothness::SCurve;
    Bounds {
        speed: one.speed,
        acceleration: one.acceleration,
        deceleration: one.deceleration,
        jerk: one.jerk.filter(|_| scurve).unwrap_or(f64::INFINITY),
        axes: AxisLimits {
            jerk: axes.jerk.filter(|_| scurve),
            ..*axes
        },
    }
}

/// Tangents that differ by no more than this are equal (spec/motion-core.md §6.3).
const TANGENT: f64 = 1e-6;
/// Shorter moves are done at once, position units.
pub(crate) const SHORTEST: f64 = 1e-9;
