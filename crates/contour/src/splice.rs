//! Extending a trajectory while it runs: its end, where it brakes to rest, is planned anew together with more moves.
//!
//! From the splice on the new motion starts with the position, velocity and acceleration that the running one has there.
//! What lies before stays as it is, to the last bit. Position units and seconds.

use crate::allowance::Begin;
use crate::course::nearest;
use crate::guess::{Running, guess};
use crate::meet::meet;
use crate::plan::{Effort, SHORTEST, bounds, can_pass, plan_with, smoothness};
use crate::rounding::Smoothness;
use crate::section::Section;
use crate::trajectory::{Knot, State};
use crate::{AxisLimits, ContourMove, Point, Trajectory};

/// Plans `moves` on from a running trajectory. The first of them are those that it has left from its `passed`-th on, the
/// others follow, of which so many are planned as about a second takes; `now` is where on it the motion is, and up to `earliest` it must stay as it is. Seconds on its own time.
///
/// The result has its time from the running one and numbers its moves from `moves[0]` on; it equals the running one from
/// `now` until [`Trajectory::splice`], so it can take its place at any instant between. `None`: there is nothing to
/// extend, it is too late, or no plan was found; then the running one goes on to its end at rest, which is always safe.
#[must_use]
pub fn extend(
    running: &Trajectory,
    passed: usize,
    moves: &[ContourMove],
    limits: &AxisLimits,
    now: f64,
    earliest: f64,
) -> Option<Trajectory> {
    let old = running.moves().checked_sub(passed).filter(|&old| old > 0)?;
    // As long as what runs takes for each; more would take longer to plan, and can be extended by in its turn.
    let begins = passed
        .checked_sub(1)
        .and_then(|last| running.move_end(last))
        .unwrap_or(0.0);
    let each = (running.duration() - begins) / old as f64;
    let most = ((MOST_EXTENDED / each) as usize).max(LEAST_EXTENDED);
    let moves = &moves[..moves.len().min(old.saturating_add(most))];
    extended(running, passed, moves, limits, now, earliest).map(|whole| whole.planned_for(moves, limits))
}

fn extended(
    running: &Trajectory,
    passed: usize,
    moves: &[ContourMove],
    limits: &AxisLimits,
    now: f64,
    earliest: f64,
) -> Option<Trajectory> {
    let old = running.moves().checked_sub(passed).filter(|&old| old > 0)?;
    if moves.len() <= old {
        return None;
    }
    // The section that the end belongs to: from behind the last stop on.
    let begin = (1..=old)
        .rev()
        .find(|&k| !can_pass(&moves[k - 1], &moves[k]))
        .unwrap_or(0);
    let stop = begin
        .checked_sub(1)
        .and_then(|last| running.move_end(passed + last))
        .filter(|&stop| stop >= earliest);
    if begin == old {
        let end = running.duration();
        return Some(cut(running, now, end, passed, old).at_rest_then(&moves[old..], limits));
    }
    let latest = running.duration() - reach(&moves[old - 1], limits, 1.5) - SETTLE;
    if let Some(stop) = stop.filter(|&stop| latest <= stop + AFTER_STOP) {
        return Some(cut(running, now, stop, passed, begin).at_rest_then(&moves[begin..], limits));
    }
    let end = (old + 1..moves.len())
        .find(|&k| !can_pass(&moves[k - 1], &moves[k]))
        .unwrap_or(moves.len());
    let first = earliest.max(latest).max(stop.map_or(0.0, |stop| stop + AFTER_STOP));
    let at_rest = running.duration() - reach(&moves[old - 1], limits, 1.0);
    let anew = Anew {
        running,
        passed,
        moves,
        limits,
        now,
        begin,
        end,
    };
    // What is not found from one instant may be from the next.
    (0..ATTEMPTS).find_map(|attempt| {
        let splice = instant(
            running,
            passed,
            &moves[begin..old],
            begin,
            limits,
            first + LATER * f64::from(attempt),
        )?;
        anew.from(splice, at_rest)
    })
}

/// Plans a running trajectory anew: `moves` (the first of them the one that it is on, its `passed`-th) with other speeds or rates
/// than it was planned with, at the `pace` that it is travelled at, with which it is within all of them.
///
/// As [`extend`], but from the first instant on, for a second or so, and the result has the time that passes: own seconds
/// divided by the pace, as have `now` and `earliest`.
#[must_use]
pub fn replan(
    running: &Trajectory,
    pace: f64,
    passed: usize,
    moves: &[ContourMove],
    limits: &AxisLimits,
    now: f64,
    earliest: f64,
) -> Option<Trajectory> {
    let running = running.at_pace(pace);
    let old = running
        .moves()
        .checked_sub(passed)
        .filter(|&old| old > 0 && old <= moves.len())?;
    if earliest > running.duration() - LEAST_LEFT {
        return None;
    }
    // Not all that is known: the rest extends it later.
    let on = |time: f64| running.move_at(time).saturating_sub(passed);
    let far = on(earliest + WINDOW).max(on(earliest) + LEAST_MOVES);
    let moves = if far + 1 < old { &moves[..=far] } else { moves };
    let last = running.move_end(passed + (moves.len() - 1).min(old - 1))?;
    if last > earliest + MOST_AHEAD {
        return None;
    }
    (0..ATTEMPTS).find_map(|attempt| {
        let first = earliest + LATER * f64::from(attempt);
        let here = on(first).min(moves.len() - 1);
        let begin = (1..=here)
            .rev()
            .find(|&k| !can_pass(&moves[k - 1], &moves[k]))
            .unwrap_or(0);
        let end = (here + 1..moves.len())
            .find(|&k| !can_pass(&moves[k - 1], &moves[k]))
            .unwrap_or(moves.len());
        let splice = instant(&running, passed, &moves[begin..end], begin, limits, first)?;
        let anew = Anew {
            running: &running,
            passed,
            moves,
            limits,
            now,
            begin,
            end,
        };
        let whole = anew.from(splice, splice + FOLLOWED)?;
        Some(whole.planned_for(moves, limits))
    })
}

/// A section that is planned anew from an instant of a running trajectory on.
struct Anew<'a> {
    running: &'a Trajectory,
    passed: usize,
    moves: &'a [ContourMove],
    limits: &'a AxisLimits,
    now: f64,
    /// Moves of the section.
    begin: usize,
    end: usize,
}

impl Anew<'_> {
    /// From `splice` on; the first guess follows what runs until `leave`.
    fn from(&self, splice: f64, leave: f64) -> Option<Trajectory> {
        let &Anew {
            running,
            passed,
            moves,
            limits,
            now,
            begin,
            end,
        } = self;
        // Some pieces before the one at the splice belong to the course: the curve there may be near them too.
        let here = running.move_at(splice).checked_sub(passed).filter(|&here| here < end)?;
        let back = moves[begin.min(here)..here]
            .iter()
            .rposition(|m| m.path.length() > SHORTEST)
            .map_or(here, |k| begin + k);
        let section = Section::new(&moves[back..end], limits, Begin::Running);
        let piece = moves[back..here].iter().filter(|m| m.path.length() > SHORTEST).count();
        let running_on = Running {
            trajectory: running,
            splice,
            leave: leave.max(splice + LEAST_FOLLOWED).min(running.duration()),
            piece: piece.min(section.course.pieces.len().checked_sub(1)?),
        };
        let tail = section
            .improve(guess(&section, running_on), Effort::Full)
            .or_else(|| self.met(&section, running_on, back))?;
        let mut whole = cut(running, now, splice, passed, here);
        whole.move_ends.extend(
            tail.move_ends[here - back..]
                .iter()
                .map(|end| end.map(|time| (time + splice).max(splice))),
        );
        whole.join(tail, splice);
        if end < moves.len() {
            whole.append(plan_with(&moves[end..], limits, Effort::Full));
        }
        Some(whole)
    }
}

impl Anew<'_> {
    /// As a motion over the same moves that begins at rest earlier, where both are alike.
    fn met(&self, section: &Section<'_>, running_on: Running<'_>, back: usize) -> Option<Trajectory> {
        let &Anew {
            running,
            passed,
            moves,
            limits,
            begin,
            end,
            ..
        } = self;
        let run_up = reach(&moves[back], limits, 1.0) + SETTLE;
        let began = |k: usize| running.move_end((passed + k).checked_sub(1)?);
        let from = (begin.min(back)..back)
            .rev()
            .find(|&k| began(k).is_none_or(|time| time <= running_on.splice - run_up))
            .unwrap_or(begin.min(back));
        let long = |m: &&ContourMove| m.path.length() > SHORTEST;
        let before = moves[from..back].iter().filter(long).map(|m| m.path.length()).sum();
        let fresh = Section::new(&moves[from..end], limits, Begin::Rest).solve(Effort::Full)?;
        section.repair(meet(section, running_on, limits, &fresh, before)?)
    }
}

/// The running trajectory between two instants, with the ends of its first `kept` moves from `passed` on.
fn cut(running: &Trajectory, now: f64, until: f64, passed: usize, kept: usize) -> Trajectory {
    let first = running.knots.partition_point(|knot| knot.time <= now).saturating_sub(1);
    let behind = running.knots.partition_point(|knot| knot.time < until);
    Trajectory {
        move_ends: running.move_ends[passed..passed + kept].to_vec(),
        end: running.end,
        splice: until,
        ..Trajectory::of(running.knots[first..behind.max(first)].to_vec())
    }
}

/// The instant from `first` on, within a short time, at which the motion has the most freedom left.
fn instant(
    running: &Trajectory,
    passed: usize,
    moves: &[ContourMove],
    begin: usize,
    limits: &AxisLimits,
    first: f64,
) -> Option<f64> {
    let last = running.duration() - LEAST_LEFT;
    if first > last {
        return None;
    }
    let mut best = (f64::INFINITY, first);
    for k in 0..=CHOICE {
        let t = near_knot(running, first + f64::from(k) * CHOICE_STEP);
        if t > last {
            break;
        }
        let state = running.at(t);
        let place = running.move_at(t).checked_sub(passed + begin)?;
        if place >= moves.len() {
            break;
        }
        let near = &moves[place.saturating_sub(1)..(place + 2).min(moves.len())];
        let off = near
            .iter()
            .filter(|m| m.path.length() > SHORTEST)
            .map(|m| (nearest(&m.path, &state.position) - state.position).norm())
            .fold(f64::INFINITY, f64::min);
        let tolerance = near.iter().map(|m| m.tolerance).fold(f64::INFINITY, f64::min);
        let mut used = if tolerance > 0.0 { off / tolerance } else { 0.0 };
        for axis in 0..3 {
            used += ACCELERATION_SHARE * state.acceleration[axis].abs() / limits.acceleration[axis];
        }
        if used < best.0 {
            best = (used, t);
        }
    }
    Some(best.1)
}

/// The next knot, if it is near.
fn near_knot(running: &Trajectory, t: f64) -> f64 {
    let next = running.knots.partition_point(|knot| knot.time < t);
    let near = running.knots.get(next).map(|knot| knot.time);
    near.filter(|&near| near < t + 2.0 * CHOICE_STEP).unwrap_or(t)
}

/// How long before its end a motion brakes, seconds, times a factor.
fn reach(last: &ContourMove, limits: &AxisLimits, factor: f64) -> f64 {
    let smoothness = smoothness(core::slice::from_ref(last));
    let bounds = bounds(last, limits, smoothness);
    let rate = bounds.deceleration.min(bounds.axes.acceleration.min());
    let speed = bounds.speed.min(bounds.axes.speed.norm());
    let mut time = speed / rate;
    if smoothness == Smoothness::SCurve {
        let jerk = bounds.least_jerk();
        time = if speed * jerk >= rate * rate {
            time + rate / jerk
        } else {
            2.0 * (speed / jerk).sqrt()
        };
    }
    factor * time
}

impl Trajectory {
    /// Comes to rest at the end of what was kept and goes on with moves from there.
    fn at_rest_then(mut self, moves: &[ContourMove], limits: &AxisLimits) -> Trajectory {
        self.knots.push(Knot {
            time: self.splice,
            state: State::rest(moves[0].path.start()),
            jerk: Point::zeros(),
        });
        self.append(plan_with(moves, limits, Effort::Full));
        self
    }

    /// Goes on with a motion that begins at an instant in the state that this one has there.
    fn join(&mut self, tail: Trajectory, at: f64) {
        self.knots.extend(tail.knots.into_iter().map(|knot| Knot {
            time: knot.time + at,
            ..knot
        }));
        self.end = tail.end;
    }
}

/// Seconds before the braking at which a splice is looked for.
const SETTLE: f64 = 0.06;
/// Seconds behind a stop before which it is simpler to start at the stop.
const AFTER_STOP: f64 = 0.01;
/// Seconds by which a trajectory is extended at once, about, but at least so many moves.
const MOST_EXTENDED: f64 = 0.8;
const LEAST_EXTENDED: usize = 12;
/// Seconds that the running motion is followed at least, and that are left of it at least.
const LEAST_FOLLOWED: f64 = 0.004;
const LEAST_LEFT: f64 = 0.008;
/// Seconds that a trajectory which is planned anew is followed.
const FOLLOWED: f64 = 0.01;
/// Seconds, and at least so many moves, for which a trajectory is planned anew.
const WINDOW: f64 = 1.0;
const LEAST_MOVES: usize = 4;
/// Seconds beyond which planning anew would take too long: the motion goes on at its pace.
const MOST_AHEAD: f64 = 4.0;
/// Splices that are tried, and seconds between them.
const ATTEMPTS: u32 = 3;
const LATER: f64 = 0.02;
/// Instants that are looked at for a splice, and seconds between them.
const CHOICE: u32 = 30;
const CHOICE_STEP: f64 = 0.001;
/// What a used up acceleration counts, compared with a used up tolerance.
const ACCELERATION_SHARE: f64 = 0.3;
