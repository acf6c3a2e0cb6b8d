//! A continuation that is within all limits from the warm start on: first the running motion, then a speed curve at speeds so low that no
//! limit is nearly reached. Position units and seconds.
//!
//! The speed curve is the programmed path with every corner rounded evenly. When the continuation leaves the running motion, its offset from
//! the speed curve fades out in position, velocity and acceleration. For dense chords the speed curve is the smooth curve that continues the
//! running motion, without an offset. A stream of S-curves may begin with a motion from rest along a speed curve.

mod fade;
mod smoothed;
mod speed_curve;

use crate::AxesState;
use crate::extend::warm_start::{Running, followed, knots};
use crate::section::Section;
use crate::solve::work::Budget;
use crate::timing::control_points::{ControlPoints, blossom};
use crate::tuning::TUNING;
use arcline_profile::KinematicState;
use fade::Fade;
use smoothed::Smoothed;
pub(crate) use speed_curve::SpeedCurve;
use speed_curve::SpeedCurveTiming;

/// Control points of a motion that follows the running one and then the speed curve, with shares of the possible values (of the limits along
/// the path, and of the speed). `None`: the running motion is too fast for the path ahead.
pub(crate) fn gentle(speed_curve: &SpeedCurve<'_>, running: Running<'_>, shares: [f64; 2]) -> Option<ControlPoints> {
    let section = speed_curve.section;
    let left = running.leave - running.splice;
    let from = running.trajectory.at(running.leave);
    let route = followed(section, running);
    let state = speed_curve.state(&from, route.last()?.progress);
    let timing = speed_curve.timing(state, &speed_curve.ends(shares), shares)?;
    let (fade, _) = Fade::new(speed_curve, &from, timing.first().1);
    let mut i = 0;
    let before = |time: f64| {
        while i + 2 < route.len() && route[i + 1].time < time {
            i += 1;
        }
        (running.trajectory.at(running.splice + time), route[i].progress)
    };
    let behind = |time: f64| {
        let along = timing.at(time);
        (fade.added_to(&speed_curve.moving(&along), time), along.position)
    };
    let mut grid = knots(section, running);
    let followed = grid.len();
    grid.extend(
        marched(&steps(speed_curve, &timing, fade.duration))
            .into_iter()
            .map(|time| left + time),
    );
    let initial = running.trajectory.at(running.splice);
    control(section, (initial, grid, followed), before, behind)
}

/// The same along the smooth curve of dense chords, with the first possible pair of shares. `None` also if too little follows the kept part.
pub(crate) fn gentle_and_smooth(
    section: &Section<'_>,
    running: Running<'_>,
    budget: &mut Budget,
) -> Option<ControlPoints> {
    let curve = Smoothed::new(section, running, budget)?;
    let initial = running.trajectory.at(running.splice);
    let (state, followed) = (curve.begin(), curve.followed().to_vec());
    let left = *followed.last()?;
    let speed_curve = SpeedCurve::smooth(section, curve);
    let mut shares = TUNING.gentle.smooth_shares.into_iter();
    let timing = shares.find_map(|shares| speed_curve.timing(state, &speed_curve.ends(shares), shares))?;
    let curve = speed_curve.smoothed()?;
    let before = |time: f64| (curve.motion(time), curve.progress(time));
    let behind = |time: f64| {
        let along = timing.at(time);
        (speed_curve.moving(&along), curve.progress_at(along.position))
    };
    let count = followed.len();
    let mut grid = followed;
    grid.extend(
        marched(&steps(&speed_curve, &timing, 0.0))
            .into_iter()
            .map(|time| left + time),
    );
    control(section, (initial, grid, count), before, behind)
}

/// Control points of a motion from rest at the beginning of the section.
pub(crate) fn gentle_from_rest(section: &Section<'_>) -> Option<ControlPoints> {
    let shares = TUNING.gentle.begin_shares;
    let speed_curve = SpeedCurve::new(section);
    let timing = speed_curve.timing(KinematicState::default(), &speed_curve.ends(shares), shares)?;
    let mut grid = marched(&steps(&speed_curve, &timing, 0.0));
    // The motion begins before the first node, and comes to rest behind the last.
    let whole = grid.pop()?;
    let mut control = ControlPoints::from_rest(&grid);
    for (k, &time) in grid.iter().enumerate() {
        let before = k.checked_sub(1).map_or(0.0, |before| grid[before]);
        let behind = grid.get(k + 1).copied().unwrap_or(whole);
        let along = timing.at(time);
        let around = [before - time, 0.0, behind - time];
        control.points.push(blossom(&speed_curve.moving(&along), around));
        control.progress.push(along.position.min(section.reference.length()));
    }
    *control.points.first_mut()? = section.reference.pieces.first()?.start();
    *control.progress.first_mut()? = 0.0;
    Some(control.completed(&section.reference))
}

/// Control points on a grid whose first knots follow the running motion: from the states at instants of it and after its last followed knot,
/// with their progress. `None`: nothing comes after that knot, or too many nodes do.
fn control(
    section: &Section<'_>,
    (initial, mut grid, followed): (AxesState, Vec<f64>, usize),
    mut before: impl FnMut(f64) -> (AxesState, f64),
    behind: impl Fn(f64) -> (AxesState, f64),
) -> Option<ControlPoints> {
    let is_extended = grid.len() > followed;
    if !is_extended || grid.len() > TUNING.gentle.most_nodes {
        return None;
    }
    // Without the last span, in which the motion comes to rest.
    let whole = grid.pop()?;
    let left = grid[followed - 1];
    let mut control = ControlPoints::continuing(initial, &grid, followed);
    for k in 0..grid.len() {
        let span_before = grid[k.max(1)] - grid[k.max(1) - 1];
        let span_behind = grid.get(k + 1).map_or(whole, |&next| next) - grid[k];
        let (state, progress) = if k < followed {
            before(grid[k])
        } else {
            behind(grid[k] - left)
        };
        control.points.push(blossom(&state, [-span_before, 0.0, span_behind]));
        control.progress.push(progress.min(section.reference.length()));
    }
    Some(control.completed(&section.reference))
}

/// The grid of nodes for a motion along the speed curve; one of them is at a cut.
fn steps(speed_curve: &SpeedCurve<'_>, timing: &SpeedCurveTiming, cut: f64) -> Vec<Span> {
    // The first profile may cross several stretches.
    let (first, profile) = timing.first();
    let mut spans: Vec<Span> = Vec::new();
    let mut from = 0.0;
    let behind = speed_curve.parts.len() + 1 - timing.count();
    let passed = &speed_curve.parts[first..behind];
    let ends = passed.iter().enumerate().map(|(k, part)| {
        let is_last = k + 1 == passed.len();
        let passes = profile.time_at_position(part.to).filter(|_| !is_last);
        (part, passes.unwrap_or(profile.duration()))
    });
    for (part, end) in ends.chain(speed_curve.parts[behind..].iter().zip(timing.ends().skip(1))) {
        if end > from {
            let step = speed_curve.step(part, end - from);
            spans.push(Span { end, step, knot: false });
            from = end;
        }
    }
    let cuts = profile.segment_times().iter().copied().chain([cut]);
    for cut in cuts.filter(|&cut| cut > 0.0 && cut < profile.duration()) {
        let k = spans.partition_point(|span| span.end <= cut);
        let step = spans[k].step;
        let part = Span {
            end: cut,
            step,
            knot: true,
        };
        spans.insert(k, part);
    }
    spans
}

/// A stretch of time: its end, seconds from node to node, and whether a change of the motion needs a knot at its end.
struct Span {
    end: f64,
    step: f64,
    knot: bool,
}

/// Instants of nodes after 0, no farther apart than the steps and without sudden changes, until the end of the last stretch.
fn marched(spans: &[Span]) -> Vec<f64> {
    let whole = spans.last().map_or(0.0, |last| last.end);
    let growth = TUNING.grid.spread;
    let begin = |k: usize| if k > 0 { spans[k - 1].end } else { 0.0 };
    // The step at the start of each stretch that the previous one permits, and at its end that the next one permits.
    let mut before = vec![f64::INFINITY; spans.len()];
    let mut behind = vec![f64::INFINITY; spans.len()];
    for k in 1..spans.len() {
        let Span { end, step, .. } = spans[k - 1];
        before[k] = step.min(before[k - 1] + growth * (end - begin(k - 1)));
    }
    for k in (1..spans.len()).rev() {
        let Span { end, step, .. } = spans[k];
        behind[k - 1] = step.min(behind[k] + growth * (end - begin(k)));
    }
    let (mut times, mut t, mut k) = (Vec::new(), 0.0, 0);
    // The node since which the steps do not fit the stretches yet, and its time.
    let (mut fitted, mut since) = (0, 0.0);
    while t < whole {
        let Span { end, step, .. } = spans[k];
        let step = step
            .min(before[k] + growth * (t - begin(k)))
            .min(behind[k] + growth * (end - t).max(0.0));
        let step = step.max(TUNING.grid.finest_s);
        t += step;
        times.push(t);
        while k < spans.len() && spans[k].end <= t {
            let span = &spans[k];
            let is_end = k + 1 == spans.len();
            if is_end || span.knot && span.end - since > step {
                let scale = (span.end - since) / (t - since);
                for time in &mut times[fitted..] {
                    *time = since + (*time - since) * scale;
                }
                (fitted, since, t) = (times.len(), span.end, span.end);
            }
            k += 1;
        }
        if k == spans.len() {
            break;
        }
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::allowance::SectionStart;
    use crate::solve::stages::Quality;
    use crate::{AxisLimits, ContourMove, Deviation, Path, Point};

    /// A running motion that was left at its end: only its own knots are known. This was an index out of bounds in the planner's thread.
    #[test]
    fn nothing_after_the_running_motion_is_no_continuation() {
        let one = ContourMove {
            path: Path::line(Point::zeros(), Point::new(1.0, 0.0, 0.0)),
            speed: 100.0,
            acceleration: 1000.0,
            deceleration: 1000.0,
            jerk: Some(10_000.0),
            tolerance: 0.01,
            deviation: Deviation::default(),
        };
        let limits = AxisLimits {
            speed: Point::repeat(500.0),
            acceleration: Point::repeat(5000.0),
            jerk: Some(Point::repeat(100_000.0)),
        };
        let moves = [one];
        let section = Section::new(&moves, &limits, SectionStart::Running, Quality::Smooth);
        let rest = (AxesState::rest(Point::zeros()), 0.0);
        let grid = |count: usize| (0..count).map(|k| 0.002 * (k as f64 - 1.0)).collect::<Vec<f64>>();
        let found = |count| control(&section, (rest.0, grid(count), 4), |_| rest, |_| rest);
        assert!(found(4).is_none());
        assert!(found(8).is_some());
    }
}
