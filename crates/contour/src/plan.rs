//! The plan of a trajectory from moves: sections from rest to rest, each rounded, timed and optimised.

use std::ops::Range;

use crate::extend::gentle::gentle_from_rest;
use crate::limits::{MoveLimits, Smoothness};
use crate::path::allowance::SectionStart;
use crate::path::straight::straight;
use crate::section::Section;
use crate::solve::stages::{Limited, Quality};
use crate::tolerance::SAME_TANGENT_SINE;
use crate::trajectory::MoveEnd;
use crate::tuning::TUNING;
use crate::{AxisLimits, ContourMove, Path, Point, Trajectory};

/// Plans the moves from rest to rest; the last one ends exactly. The plan never fails: the motion stops at a corner that cannot be rounded. An
/// empty list gives a trajectory of no duration at the origin.
#[must_use]
pub fn plan(moves: &[ContourMove], limits: &AxisLimits) -> Trajectory {
    plan_with(moves, limits, PlanningTime::Unlimited)
}

/// Plans the moves with a stop at each joint: the simplest plan, if [`plan`] has a defect.
#[must_use]
pub fn plan_with_stops(moves: &[ContourMove], limits: &AxisLimits) -> Trajectory {
    let start = moves.first().map_or(Point::zeros(), |first| first.path.start());
    stops_between(Trajectory::rest(start), moves, limits, PlanningTime::Unlimited).planned_for(moves, limits)
}

/// Appends the moves with a stop behind each.
fn stops_between(
    mut whole: Trajectory,
    moves: &[ContourMove],
    limits: &AxisLimits,
    planning_time: PlanningTime,
) -> Trajectory {
    for one in moves {
        whole.append(plan_section(core::slice::from_ref(one), limits, planning_time));
    }
    whole
}

/// The time for planning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlanningTime {
    /// The plan is the fastest motion.
    Unlimited,
    /// More moves arrive during the motion: planning takes a small part of its duration.
    Streaming,
}

/// The same, within a planning time.
pub(crate) fn plan_with(moves: &[ContourMove], limits: &AxisLimits, planning_time: PlanningTime) -> Trajectory {
    let start = moves.first().map_or(Point::zeros(), |first| first.path.start());
    let mut whole = Trajectory::rest(start);
    let mut section: Vec<ContourMove> = Vec::new();
    for (index, next) in moves.iter().enumerate() {
        section.push(*next);
        let stops = moves.get(index + 1).is_none_or(|after| !can_pass(next, after));
        if stops {
            whole.append(plan_section(&section, limits, planning_time));
            section.clear();
        }
    }
    whole.planned_for(moves, limits)
}

/// Plans the first moves from rest to rest, so few that the motion begins soon; [`crate::extend`] adds the others during the motion. It plans
/// all moves if they are few, or if they form a whole contour with many sharp corners, which is faster when it is planned at once.
#[must_use]
pub fn begin(moves: &[ContourMove], limits: &AxisLimits) -> Trajectory {
    match first_moves(moves, limits) {
        None => plan(moves, limits),
        Some(first) => plan_with(&moves[..first], limits, PlanningTime::Streaming),
    }
}

/// The number of moves on which a motion from rest is within some seconds, by the speeds of its first guess.
fn passed_within(moves: &[ContourMove], limits: &AxisLimits, seconds: f64, limited: Limited) -> usize {
    let (mut begin, mut left) = (0, seconds);
    while begin < moves.len() {
        let end = between_stops(moves, begin).end;
        let passes = if moves[begin..end].iter().any(ContourMove::has_length) {
            Section::new(&moves[begin..end], limits, SectionStart::Rest, Quality::TimingOnly).passes(limited)
        } else {
            Vec::new()
        };
        let passed = passes.partition_point(|&time| time < left);
        if passed < passes.len() {
            let mut long = (begin..end).filter(|&k| moves[k].has_length());
            return long.nth(passed).map_or(end, |k| k + 1);
        }
        left -= passes.last().unwrap_or(&0.0);
        begin = end;
    }
    moves.len()
}

/// The number of moves of a stream to plan first; `None`: the moves form a whole contour.
pub(crate) fn first_moves(moves: &[ContourMove], limits: &AxisLimits) -> Option<usize> {
    // The last known move ends in a stop, or at a corner without a tolerance.
    let is_whole = moves.last().is_none_or(|last| last.tolerance <= 0.0);
    let dense = || {
        let section = 1 + moves.windows(2).take_while(|pair| can_pass(&pair[0], &pair[1])).count();
        is_dense(&moves[..section.min(moves.len())])
    };
    if is_whole && !dense() {
        return None;
    }
    // No motion is faster than the programmed speeds: only these moves need a guess.
    let mut seconds = 0.0;
    let most = moves.iter().take_while(|one| {
        let before = seconds;
        seconds += one.path.length() / one.speed;
        before < TUNING.extend.first_s
    });
    let known = &moves[..most.count()];
    let within = |seconds, limited| passed_within(known, limits, seconds, limited);
    let first = match Smoothness::of(known) {
        Smoothness::Trapezoid => within(TUNING.extend.first_s, Limited::Acceleration),
        // The guess with limits of the jerk is too slow at flat corners, and that without them too fast at sharp ones.
        Smoothness::SCurve => within(TUNING.extend.first_s, Limited::Jerk)
            .max(within(TUNING.extend.first_without_jerk_s, Limited::Acceleration)),
    };
    Some(first.max(TUNING.extend.first_moves).min(moves.len()))
}

/// The motion can pass the joint between two moves without a stop.
pub(crate) fn can_pass(before: &ContourMove, after: &ContourMove) -> bool {
    if before.jerk.is_some() != after.jerk.is_some() {
        return false;
    }
    let tangent = (before.path.end_tangent() - after.path.start_tangent()).norm() <= SAME_TANGENT_SINE;
    tangent || before.tolerance > 0.0 || before.path.length() <= 0.0 || after.path.length() <= 0.0
}

/// The moves around one of them between which the motion does not stop.
pub(crate) fn between_stops(moves: &[ContourMove], around: usize) -> Range<usize> {
    let stops_before = |&k: &usize| !can_pass(&moves[k - 1], &moves[k]);
    let begin = (1..=around).rev().find(stops_before).unwrap_or(0);
    let end = (around + 1..moves.len()).find(stops_before).unwrap_or(moves.len());
    begin..end
}

/// Plans one section as well as possible. If a plan is outside the corridor or the limits, the section is planned again with less freedom,
/// finally with a stop at every joint.
fn plan_section(moves: &[ContourMove], limits: &AxisLimits, planning_time: PlanningTime) -> Trajectory {
    let long: Vec<&ContourMove> = moves.iter().filter(|m| m.has_length()).collect();
    let end = moves.last().map_or(Point::zeros(), |last| last.path.end());
    if let [one] = long.as_slice()
        && let Path::Line(line) = &one.path
    {
        let mut trajectory = straight(line, &MoveLimits::new(one, limits, Smoothness::of(moves)));
        let before = moves.iter().take_while(|m| !m.has_length()).count();
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
    for quality in qualities(moves, planning_time).chain([Quality::TimingOnly]) {
        let section = Section::new(moves, limits, SectionStart::Rest, quality);
        let begins = quality == Quality::TimingOnly && planning_time == PlanningTime::Streaming && !is_dense(moves);
        let begun = begins.then(|| begun_gently(&section)).flatten();
        if let Some(trajectory) = begun.or_else(|| section.plan(planning_time)) {
            return trajectory;
        }
    }
    if long.len() == 1 {
        return Section::new(moves, limits, SectionStart::Rest, Quality::TimingOnly).slowed();
    }
    stops_between(Trajectory::rest(moves[0].path.start()), moves, limits, planning_time)
}

/// The first S-curves of a stream on evenly rounded corners, within all limits from their first guess on: found sooner than from a guess without
/// limits of the jerk. `None` for trapezoids, which need no such guess. Dense chords have too many corners for it.
fn begun_gently(section: &Section<'_>) -> Option<Trajectory> {
    match section.smoothness {
        Smoothness::Trapezoid => None,
        Smoothness::SCurve => section.hasten_to_begin(gentle_from_rest(section)?),
    }
}

/// The order of the plans of a section, before the stops at every joint: dense chords as a smooth curve first.
pub(crate) fn qualities(moves: &[ContourMove], planning_time: PlanningTime) -> impl Iterator<Item = Quality> {
    let dense = is_dense(moves).then_some(Quality::Smooth);
    dense
        .into_iter()
        .chain((planning_time == PlanningTime::Unlimited).then_some(Quality::Full))
}

/// The moves are many, and most of their corners have a small change of direction.
pub(crate) fn is_dense(moves: &[ContourMove]) -> bool {
    let turn = |pair: &[ContourMove]| (pair[1].path.start_tangent() - pair[0].path.end_tangent()).norm();
    let sharp = moves.windows(2).filter(|pair| turn(pair) > TUNING.smooth.sharp).count();
    moves.len() >= TUNING.smooth.least_moves && sharp * TUNING.smooth.most_sharp <= moves.len()
}
