//! Extends a trajectory during its execution: its end, at which it brakes to rest, is planned anew together with more moves.
//!
//! From the splice on, the new motion starts with the position, velocity and acceleration of the running one. The part before the splice
//! stays the same, to the last bit. Position units and seconds.

mod continuation;
pub(crate) mod gentle;
pub(crate) mod replan;
mod search;
mod splice;
mod warm_start;
mod warm_start_joined;

use std::cell::Cell;
use std::ops::Range;

use crate::extend::continuation::{Continuation, cut, leave_at};
use crate::extend::search::Search;
use crate::extend::splice::{braking_time, splice};
use crate::limits::Smoothness;
use crate::plan::{between_stops, first_moves, is_dense};
use crate::section::{Missed, too_early};
use crate::solve::stages::Quality;
use crate::solve::work::Budget;
use crate::tuning::{Attempt, SlowDown, TUNING};
use crate::{AxisLimits, ContourMove, Path, Trajectory};

/// A trajectory in execution, and the moves with which its rest is planned.
#[derive(Clone, Copy, Debug)]
pub struct ExtensionRequest<'a> {
    /// The trajectory.
    pub running: &'a Trajectory,
    /// Its moves that are complete.
    pub passed: usize,
    /// Its own remaining moves, from its `passed`-th on, and others that follow.
    pub moves: &'a [ContourMove],
    /// The limits of the axes.
    pub limits: &'a AxisLimits,
    /// The present time of the motion on it, seconds.
    pub now: f64,
    /// The instant until which it must stay unchanged, seconds.
    pub earliest: f64,
}

/// Continues a running trajectory with the moves of a request, of which the plan includes as many as take about a second. The request has seconds of the
/// trajectory's own time.
///
/// The result keeps the time of the running trajectory and numbers its moves from `moves[0]` on. It equals the running one from `now` until
/// [`Trajectory::splice`], so it can replace it at any instant between. `None`: there is no move to extend it with, it is too late, or no plan
/// was found; then the running trajectory continues to its end at rest, which is always safe.
#[must_use]
pub fn extend(request: &ExtensionRequest<'_>) -> Option<Trajectory> {
    extend_at(request, 1.0)
}

/// The same for a trajectory that runs at a constant, low `pace`: it needs so little of its limits that an extension is nearly always found. The result
/// has real time: own seconds divided by the pace, as has the request.
#[must_use]
pub fn extend_slowed(request: &ExtensionRequest<'_>, pace: f64) -> Option<Trajectory> {
    let running = &request.running.at_pace(pace);
    extend_at(&ExtensionRequest { running, ..*request }, pace)
}

/// `pace`: that of the trajectory, as a share of the planned one.
fn extend_at(request: &ExtensionRequest<'_>, pace: f64) -> Option<Trajectory> {
    let &ExtensionRequest {
        running,
        passed,
        moves,
        limits,
        now,
        earliest,
    } = request;
    let old = running.moves().checked_sub(passed).filter(|&old| old > 0)?;
    // The moves of the running trajectory give the duration of a move. More moves would take longer to plan; a later extension adds them. One that was
    // extended does not begin at 0.
    let begins = passed
        .checked_sub(1)
        .and_then(|last| running.move_end(last))
        .or_else(|| running.knots.first().map(|knot| knot.time))?;
    let each = pace * (running.duration() - begins) / old as f64;
    // The first extension of a new trajectory is short: the trajectory must not end meanwhile.
    let ahead = (running.duration() - now).clamp(TUNING.extend.least_s, TUNING.extend.most_s);
    let most = ((ahead / each) as usize).max(TUNING.extend.least_moves);
    let moves = &moves[..moves.len().min(old.saturating_add(most))];
    if moves.len() <= old {
        return None;
    }
    // The section of the end begins after the last stop.
    let Range { start: begin, end } = between_stops(moves, old);
    let left = running.duration() - now;
    let is_slowed = pace < 1.0;
    // The estimated time of the searches before.
    let spent = Cell::new(0.0);
    let patience = &TUNING.patience;
    let is_short = left < TUNING.extend.short_s;
    let (attempts, patience_of_smooth, far): (&[Attempt], _, _) = if is_short {
        (&TUNING.attempts.short, patience.smooth_short, TUNING.smooth.far_short)
    } else if left < TUNING.extend.long_s {
        (&TUNING.attempts.usual, patience.smooth, TUNING.smooth.far)
    } else {
        (&TUNING.attempts.long, patience.smooth, TUNING.smooth.far)
    };
    // The first plan found is used. Dense chords are fastest as a smooth curve; a gentle plan is found soonest; fewer moves are easier.
    let plan_for = |search: Search<'_>, share: f64, patience: f64, least: f64| {
        let most = moves.len() - old;
        let more = ((share * most as f64).ceil() as usize).max(TUNING.extend.least_moves.min(most));
        let continuation = Continuation {
            running,
            passed,
            moves: &moves[..old + more],
            limits,
            now,
            begin,
            end: end.min(old + more),
            quality: search.quality(),
            far,
        };
        let rest = (left - spent.get()).clamp(0.0, TUNING.patience.most_rest_s);
        let seconds = (patience * rest).max(least);
        let mut budget = Budget::of(seconds);
        // What is found from a warm start outside of the limits is found soon, but the optimisation of a gentle plan takes its time.
        let takes = match search {
            Search::Attempts(..) => 0.0,
            Search::Gentle | Search::GentleSooner | Search::GentleAndSmooth => TUNING.patience.gentle_takes * seconds,
        };
        let earliest = earliest + spent.get() + takes;
        let sought = Sought {
            search,
            is_slowed,
            is_last: old + more == request.moves.len(),
        };
        let found = extended(&continuation, old, earliest, sought, &mut budget);
        spent.set(spent.get() + budget.seconds());
        found
    };
    let plan = |search, share, patience| plan_for(search, share, patience, 0.0);
    // A long rest leaves time for another request; a short one is continued in any case, if there is time to plan from rest.
    let at_its_end = || {
        let is_in_time = left - spent.get() >= TUNING.extend.least_to_begin_s;
        (is_short && is_in_time).then(|| from_its_end(request, old, moves))
    };
    let last = |search, share| {
        if is_short {
            at_its_end()
        } else {
            plan_for(search, share, patience.last, patience.least_last_s)
        }
    };
    let smooth = Search::Attempts(Quality::Smooth, attempts);
    let arcs = moves[begin..end]
        .iter()
        .filter(|one| matches!(one.path, Path::Arc(_)))
        .count();
    let has_many_arcs = arcs * TUNING.extend.most_arcs > end - begin;
    let sooner = || plan(Search::GentleSooner, TUNING.gentle.sooner_share, patience.gentle_sooner);
    let gently_and_few = |patience| plan(Search::GentleAndSmooth, TUNING.extend.less_share, patience);
    let is_chords = is_dense(&moves[begin..end]) && !has_many_arcs;
    let extended = if is_slowed {
        // What is found soonest is fast enough, and a further search is for nothing: nearly any is within all limits.
        let smoothly = is_chords.then(|| gently_and_few(patience.smooth)).flatten();
        smoothly
            .or_else(|| plan(Search::Gentle, TUNING.gentle.ahead_share, patience.gentle_alone))
            .or_else(|| plan(smooth, TUNING.extend.less_share, patience_of_smooth))
            .or_else(at_its_end)?
    } else if is_chords {
        let found = plan(smooth, 1.0, patience_of_smooth)
            .or_else(|| plan(Search::GentleAndSmooth, 1.0, patience.gentle_and_smooth));
        // What a short rest leaves to the other searches is not enough for them.
        let others = || {
            plan(Search::Gentle, TUNING.gentle.ahead_share, patience.gentle)
                // A smooth curve cannot be left for evenly rounded corners in its course.
                .or_else(sooner)
                .or_else(|| gently_and_few(patience.gentle_and_few))
        };
        found
            .or_else(|| (!is_short).then(others).flatten())
            .or_else(|| last(smooth, 1.0))?
    } else {
        // Sharp corners of lines are faster when timing and shape are optimised together, which takes longest.
        let is_ample = running.duration() - earliest >= TUNING.extend.ample_s;
        let first = &TUNING.attempts.usual[..1];
        let together = (arcs == 0 && is_ample)
            .then(|| plan(Search::Attempts(Quality::Full, first), 1.0, patience.together))
            .flatten();
        together
            .or_else(|| plan(Search::Gentle, TUNING.gentle.ahead_share, patience.gentle_alone))
            .or_else(|| plan(smooth, TUNING.extend.less_share, patience_of_smooth))
            .or_else(sooner)
            .or_else(|| last(Search::Attempts(Quality::Full, attempts), TUNING.extend.less_share))?
    };
    let count = extended.moves();
    Some(extended.planned_for(&moves[..count], limits))
}

/// The simplest extension of a running trajectory with `old` moves: it comes to rest at its end, and the first of the other moves continue from there
/// at once.
fn from_its_end(request: &ExtensionRequest<'_>, old: usize, moves: &[ContourMove]) -> Trajectory {
    let &ExtensionRequest {
        running,
        passed,
        limits,
        now,
        ..
    } = request;
    let others = &moves[old..];
    let first = first_moves(others, limits).unwrap_or(others.len());
    cut(running, now, running.duration(), passed, old).at_rest_then(&others[..first], limits)
}

/// What a search for an extension has to find.
#[derive(Clone, Copy)]
struct Sought<'a> {
    search: Search<'a>,
    /// The running trajectory has a low pace.
    is_slowed: bool,
    /// No other moves are known that follow.
    is_last: bool,
}

/// `old`: the number of moves of the running trajectory.
fn extended(
    continuation: &Continuation<'_>,
    old: usize,
    earliest: f64,
    sought: Sought<'_>,
    budget: &mut Budget,
) -> Option<Trajectory> {
    let &Continuation {
        running,
        passed,
        moves,
        limits,
        now,
        begin,
        quality,
        ..
    } = continuation;
    let Sought {
        search,
        is_slowed,
        is_last,
    } = sought;
    if begin == old {
        let end = running.duration();
        return Some(cut(running, now, end, passed, old).at_rest_then(&moves[old..], limits));
    }
    let stop = begin
        .checked_sub(1)
        .and_then(|last| running.move_end(passed + last))
        .filter(|&stop| stop >= earliest);
    let braking = braking_time(&moves[old - 1], limits);
    let latest = running.duration() - TUNING.extend.brakings * braking - TUNING.extend.settle_s;
    let after_stop = |stop: f64| stop + TUNING.extend.after_stop_s;
    if let Some(stop) = stop.filter(|&stop| latest <= after_stop(stop)) {
        return Some(cut(running, now, stop, passed, begin).at_rest_then(&moves[begin..], limits));
    }
    let first = earliest.max(latest).max(stop.map_or(0.0, after_stop));
    let soonest = earliest.max(stop.map_or(0.0, after_stop));
    let leaves = || {
        // A low pace need not be kept until the end.
        if is_slowed {
            return soonest..soonest + TUNING.gentle.before_s;
        }
        let brakes = running.brakes_from();
        let first = match search {
            Search::GentleSooner => soonest,
            _ => soonest.max(brakes - TUNING.gentle.before_s),
        };
        first..brakes + TUNING.gentle.latest_share * (running.duration() - brakes)
    };
    let attempts = match search {
        Search::Gentle | Search::GentleSooner => return continuation.plan_gently(leaves(), budget),
        Search::GentleAndSmooth => return continuation.plan_gently_and_smooth(leaves(), budget),
        Search::Attempts(_, attempts) => attempts,
    };
    // A search that fails from one instant of the running motion may succeed from another one.
    let (mut work, mut tried, mut soonest_later) = (None, Vec::new(), f64::NEG_INFINITY);
    let is_s_curve = Smoothness::of(moves) == Smoothness::SCurve;
    // The axes come to rest at the end of the last extension only: the next one replaces the end of any other.
    let seen_too_early = |found: &Trajectory| {
        if is_s_curve && is_last {
            too_early(found.duration())
        } else {
            0.0
        }
    };
    let costs = |found: &Trajectory| found.duration() + TUNING.end.weight * seen_too_early(found);
    let mut best: Option<Trajectory> = None;
    for attempt in attempts {
        // Another attempt takes about the time of those before it.
        let is_due = |best: &Trajectory| earliest + 2.0 * budget.seconds() > best.splice;
        if best.as_ref().is_some_and(is_due) || budget.is_spent() {
            break;
        }
        let from = first + attempt.later_s;
        let is_skipped = (0.0..soonest_later).contains(&attempt.later_s);
        if is_skipped || from < soonest {
            continue;
        }
        let Some(splice) = splice(running, passed + begin, &moves[begin..old], limits, from) else {
            continue;
        };
        let leave = leave_at(
            running,
            splice,
            running.duration() - attempt.brakings * braking + attempt.later_s.min(0.0),
        );
        let slow_down = match quality {
            Quality::Smooth => attempt.slow_down,
            Quality::Full | Quality::TimingOnly => SlowDown::Whole,
        };
        let same = (splice, leave, slow_down, attempt.holds);
        if tried.contains(&same) {
            continue;
        }
        tried.push(same);
        match continuation.plan(splice, leave, slow_down, attempt.holds, &mut work, budget) {
            Ok((found, repairs)) => {
                // An S-curve is slow where its curve was repaired; from another instant it may need no repair. Before another attempt was made, a spiral of
                // chords of 0.08 mm fell to half its speed for 0.1 s in one run of four.
                // Where the first attempt fails, the next one that succeeds may be slow; the faster of two is used. By that `rows` takes 1 % less time in the mean of
                // 60 runs, and its slowest run 2 % less, for half as much planning again.
                let is_sure = tried.len() == 1 || best.is_some();
                let is_good = !is_s_curve || is_sure && repairs == 0 && seen_too_early(&found) == 0.0;
                if best.as_ref().is_none_or(|best| costs(&found) < costs(best)) {
                    best = Some(found);
                }
                if is_good {
                    break;
                }
            }
            Err(Missed::Far) => soonest_later = attempt.later_s + TUNING.extend.slower_s,
            Err(Missed::Near) => {}
        }
    }
    best
}
