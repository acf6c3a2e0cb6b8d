//! Planning a running trajectory anew, with other speeds or rates. Position units and seconds.

use std::ops::Range;

use crate::extend::continuation::{Continuation, leave_at};
use crate::extend::splice::splice;
use crate::plan::{PlanningTime, between_stops, qualities};
use crate::solve::work::Budget;
use crate::tuning::{SlowDown, TUNING};
use crate::{ExtensionRequest, Trajectory};

/// Plans a running trajectory anew: the moves of the request (the first of them is its active one) have other speeds or rates than those of the
/// plan, and the trajectory runs at a `pace` within all of them.
///
/// As [`crate::extend`], but from the first instant on, for about a second. The result has real time: own seconds divided by the pace, as has
/// the request.
#[must_use]
pub fn replan(request: &ExtensionRequest<'_>, pace: f64) -> Option<Trajectory> {
    let &ExtensionRequest {
        passed,
        moves,
        limits,
        now,
        earliest,
        ..
    } = request;
    let running = request.running.at_pace(pace);
    let old = running
        .moves()
        .checked_sub(passed)
        .filter(|&old| old > 0 && old <= moves.len())?;
    if earliest > running.duration() - TUNING.extend.least_left_s {
        return None;
    }
    // Not all known moves: later extensions add the rest.
    let on = |time: f64| running.move_at(time).saturating_sub(passed);
    let far = on(earliest + TUNING.extend.replan_s).max(on(earliest) + TUNING.extend.replan_least_moves);
    let moves = if far + 1 < old { &moves[..=far] } else { moves };
    let last = running.move_end(passed + (moves.len() - 1).min(old - 1))?;
    if last > earliest + TUNING.extend.replan_most_ahead_s {
        return None;
    }
    let (mut work, mut budget) = (None, Budget::unlimited());
    (0..TUNING.extend.attempts).find_map(|attempt| {
        let first = earliest + TUNING.extend.later_s * f64::from(attempt);
        let here = on(first).min(moves.len() - 1);
        let Range { start: begin, end } = between_stops(moves, here);
        let splice = splice(&running, passed + begin, &moves[begin..end], limits, first)?;
        let whole = qualities(&moves[begin..end], PlanningTime::Unlimited).find_map(|quality| {
            let continuation = Continuation {
                running: &running,
                passed,
                moves,
                limits,
                now,
                begin,
                end,
                quality,
                far: TUNING.smooth.far,
            };
            let leave = leave_at(&running, splice, splice + TUNING.extend.replan_followed_s);
            let planned = continuation.plan(splice, leave, SlowDown::Whole, false, &mut work, &mut budget);
            planned.ok().map(|(found, _)| found)
        })?;
        Some(whole.planned_for(moves, limits))
    })
}
