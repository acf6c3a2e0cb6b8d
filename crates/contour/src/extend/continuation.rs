//! A section that is planned from an instant of a running trajectory. Position units and seconds.

use std::ops::Range;

use crate::extend::gentle::{SpeedCurve, gentle, gentle_and_smooth};
use crate::extend::splice::braking_time;
use crate::extend::warm_start::{Running, followed, warm_start};
use crate::extend::warm_start_joined::warm_start_joined;
use crate::path::allowance::SectionStart;
use crate::plan::{PlanningTime, plan_with};
use crate::section::{Mend, Missed, Section};
use crate::solve::stages::Quality;
use crate::solve::work::{Budget, Work};
use crate::timing::control_points::{ControlPoints, GIVEN};
use crate::trajectory::{AxesState, Knot};
use crate::tuning::{SlowDown, TUNING};
use crate::{AxisLimits, ContourMove, Point, Trajectory};

/// A running trajectory and the moves that continue it.
pub(crate) struct Continuation<'a> {
    pub(crate) running: &'a Trajectory,
    /// The move of the running trajectory that is the first of `moves`.
    pub(crate) passed: usize,
    pub(crate) moves: &'a [ContourMove],
    pub(crate) limits: &'a AxisLimits,
    /// The present time on the running trajectory.
    pub(crate) now: f64,
    /// Moves of the section.
    pub(crate) begin: usize,
    pub(crate) end: usize,
    pub(crate) quality: Quality,
    /// The excess beyond which an attempt from a warm start outside of the limits is given up.
    pub(crate) far: f64,
}

impl Continuation<'_> {
    /// Plans from `splice` on; the warm start follows the running motion until `leave`. `work` is that of all attempts on timing and shape
    /// together; the first attempt sets it. All of it is within a budget. Returns the repairs that it took as well.
    ///
    /// # Errors
    /// No motion was found.
    pub(crate) fn plan(
        &self,
        splice: f64,
        leave: f64,
        slow_down: SlowDown,
        holds: bool,
        work: &mut Option<Work>,
        budget: &mut Budget,
    ) -> Result<(Trajectory, usize), Missed> {
        let (mut missed, mut repairs) = (Missed::Near, 0);
        let found = self.then(splice, leave, self.quality, |section, followed, back| {
            let section = section.attempted(slow_down, self.far);
            let mut control = warm_start(&section, followed);
            if !holds {
                control.held_nodes = control.kept_nodes;
            }
            budget.round(section.reference.pieces.len());
            // On a fixed curve, each attempt has the whole budget, which is small.
            if self.quality == Quality::Smooth {
                *work = None;
            }
            let work = work.get_or_insert_with(|| Work::to_continue(control.points.len(), self.quality));
            budget.spend(self.quality, work, |work| match section.improve(control, work) {
                Ok((improved, took)) => {
                    repairs = took;
                    Some(improved)
                }
                Err(why) => {
                    missed = why;
                    self.joined(&section, followed, back, work)
                }
            })
        });
        found.map(|found| (found, repairs)).ok_or(missed)
    }

    /// The same on evenly rounded corners, from a warm start within all limits that leaves the running motion within an interval.
    pub(crate) fn plan_gently(&self, interval: Range<f64>, budget: &mut Budget) -> Option<Trajectory> {
        let &Continuation { running, limits, .. } = self;
        let first = interval.start;
        let mut candidates = Vec::new();
        self.section(first, first, Quality::TimingOnly, |section, from, _| {
            budget.round_gently(section.reference.pieces.len());
            let speed_curve = SpeedCurve::new(&section);
            let ends = TUNING.gentle.shares.map(|shares| speed_curve.ends(shares));
            for leave in leaves(running, interval) {
                let state = running.at(leave);
                let progress = followed(&section, Running { leave, ..from }).last()?.progress;
                for (shares, ends) in TUNING.gentle.shares.into_iter().zip(&ends) {
                    if let Some(off) = speed_curve.goes_on(&state, progress, ends, shares) {
                        candidates.push(((off - 1.0).max(0.0) + in_use(&state, limits) + shares[0], leave, shares));
                        break;
                    }
                }
            }
            candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
            None::<()>
        });
        candidates.truncate(TUNING.gentle.attempts);
        first_within(&candidates, budget, |&(_, leave, shares), mend, budget| {
            let splice = first.max(before(running, leave));
            self.then(splice, leave, Quality::TimingOnly, |section, followed, _| {
                budget.round_gently(section.reference.pieces.len());
                let control = gentle(&SpeedCurve::new(&section), followed, shares)?;
                budget.begin(control.points.len());
                hastened(&section, control, mend, budget)
            })
        })
    }

    /// As [`Continuation::plan_gently`], along the smooth curve of dense chords.
    pub(crate) fn plan_gently_and_smooth(&self, interval: Range<f64>, budget: &mut Budget) -> Option<Trajectory> {
        let &Continuation { running, limits, .. } = self;
        let first = interval.start;
        let mut instants: Vec<(f64, f64)> = leaves(running, interval)
            .map(|leave| (in_use(&running.at(leave), limits), leave))
            .collect();
        instants.sort_by(|a, b| a.0.total_cmp(&b.0));
        instants.truncate(TUNING.gentle.smooth_attempts);
        first_within(&instants, budget, |&(_, leave), mend, budget| {
            let splice = first.max(before(running, leave));
            self.then(splice, leave, Quality::Smooth, |section, followed, _| {
                let control = gentle_and_smooth(&section, followed, budget)?;
                budget.begin_smooth(control.points.len());
                hastened(&section, control, mend, budget)
            })
        })
    }

    /// The running motion until `splice`, then the plan of `tail` for the section from there on.
    fn then(
        &self,
        splice: f64,
        leave: f64,
        quality: Quality,
        tail: impl FnOnce(Section<'_>, Running<'_>, usize) -> Option<Trajectory>,
    ) -> Option<Trajectory> {
        let &Continuation {
            running,
            passed,
            moves,
            limits,
            now,
            end,
            ..
        } = self;
        let here = running.move_at(splice).checked_sub(passed)?;
        let (tail, back) = self.section(splice, leave, quality, |section, followed, back| {
            Some((tail(section, followed, back)?, back))
        })?;
        let mut whole = cut(running, now, splice, passed, here);
        whole.move_ends.extend(
            tail.move_ends[here - back..]
                .iter()
                .map(|end| end.map(|time| (time + splice).max(splice))),
        );
        whole.join(tail, splice);
        if end < moves.len() {
            whole.append(plan_with(&moves[end..], limits, PlanningTime::Streaming));
        }
        Some(whole)
    }

    /// Calls `with` with the section from an instant of the running motion on.
    fn section<R>(
        &self,
        splice: f64,
        leave: f64,
        quality: Quality,
        with: impl FnOnce(Section<'_>, Running<'_>, usize) -> Option<R>,
    ) -> Option<R> {
        let &Continuation {
            running,
            passed,
            moves,
            limits,
            begin,
            end,
            ..
        } = self;
        // The reference path also needs some pieces before the one at the splice: the curve may be near them, too.
        let here = running.move_at(splice).checked_sub(passed).filter(|&here| here < end)?;
        let back = moves[begin.min(here)..here]
            .iter()
            .rposition(ContourMove::has_length)
            .map_or(here, |k| begin + k);
        let section = Section::new(&moves[back..end], limits, SectionStart::Running, quality).beginning(splice);
        let piece = moves[back..here].iter().filter(|m| m.has_length()).count();
        let followed = Running {
            trajectory: running,
            splice,
            leave,
            piece: piece.min(section.reference.pieces.len().checked_sub(1)?),
        };
        with(section, followed, back)
    }

    /// A continuation from a motion over the same moves that begins at rest earlier, joined where both are alike.
    fn joined(&self, section: &Section<'_>, followed: Running<'_>, back: usize, work: &mut Work) -> Option<Trajectory> {
        // Two smooth motions are not alike enough.
        if work.is_done() || self.quality == Quality::Smooth {
            return None;
        }
        let &Continuation {
            running,
            passed,
            moves,
            limits,
            begin,
            end,
            ..
        } = self;
        let run_up = braking_time(&moves[back], limits) + TUNING.extend.settle_s;
        let began = |k: usize| running.move_end((passed + k).checked_sub(1)?);
        let from = (begin.min(back)..back)
            .rev()
            .find(|&k| began(k).is_none_or(|time| time <= followed.splice - run_up))
            .unwrap_or(begin.min(back));
        let long = moves[from..back].iter().filter(|m| m.has_length());
        let before = long.map(|m| m.path.length()).sum();
        let fresh = Section::new(&moves[from..end], limits, SectionStart::Rest, Quality::Full).solve_with(work)?;
        section.repair(warm_start_joined(section, followed, limits, &fresh, before)?, work)
    }
}

/// The first plan from one of the candidates, with the mend that takes the least work.
fn first_within<C>(
    candidates: &[C],
    budget: &mut Budget,
    mut plan: impl FnMut(&C, Mend, &mut Budget) -> Option<Trajectory>,
) -> Option<Trajectory> {
    let each = |mend| candidates.iter().map(move |candidate| (candidate, mend));
    [Mend::Smoothing, Mend::Timing]
        .into_iter()
        .flat_map(each)
        .find_map(|(candidate, mend)| {
            if budget.is_spent() {
                return None;
            }
            plan(candidate, mend, budget)
        })
}

/// A warm start that a mend brings within all limits, made faster within a budget.
fn hastened(section: &Section<'_>, control: ControlPoints, mend: Mend, budget: &mut Budget) -> Option<Trajectory> {
    let mut work = Work::to_continue(control.points.len(), Quality::Smooth);
    budget.spend(Quality::Smooth, &mut work, |work| section.hasten(control, mend, work))
}

/// The instant at which a warm start leaves the running trajectory, which it follows until about `leave`: at the last knot before, or at the
/// first one some time after `splice`.
pub(crate) fn leave_at(running: &Trajectory, splice: f64, leave: f64) -> f64 {
    let least = splice + TUNING.extend.least_followed_s;
    let before = running.knots.partition_point(|knot| knot.time <= leave);
    let knot = running.knots[..before].last().map_or(leave, |knot| knot.time);
    if knot > least {
        return knot;
    }
    // A separate knot just behind another one would bend the curve strongly.
    let behind = running.knots.partition_point(|knot| knot.time < least);
    running.knots.get(behind).map_or(running.duration(), |knot| knot.time)
}

/// Knots at which the running trajectory may be left, the last one first.
fn leaves(running: &Trajectory, interval: Range<f64>) -> impl Iterator<Item = f64> + '_ {
    let first = interval.start + TUNING.extend.least_followed_s;
    let from = running.knots.partition_point(|knot| knot.time < first);
    let to = running.knots.partition_point(|knot| knot.time < interval.end);
    let steps = to.saturating_sub(from).div_ceil(TUNING.gentle.leaves).max(1);
    (from..to).rev().step_by(steps).map(|k| running.knots[k].time)
}

/// The largest used share of an acceleration limit.
fn in_use(state: &AxesState, limits: &AxisLimits) -> f64 {
    let share = |axis: usize| state.acceleration[axis].abs() / limits.acceleration[axis];
    (0..3).map(share).fold(0.0, f64::max)
}

/// The instant some knots, and some time, before another instant.
fn before(running: &Trajectory, instant: f64) -> f64 {
    let latest = instant - TUNING.extend.least_followed_s;
    let at = running.knots.partition_point(|knot| knot.time < instant);
    let knot = &running.knots[at.saturating_sub(GIVEN + 2).min(running.knots.len() - 1)];
    knot.time.min(latest)
}

/// The running trajectory between two instants, with the ends of its first `moves` moves from `passed` on.
pub(crate) fn cut(running: &Trajectory, now: f64, until: f64, passed: usize, moves: usize) -> Trajectory {
    let first = running.knots.partition_point(|knot| knot.time <= now).saturating_sub(1);
    let behind = running.knots.partition_point(|knot| knot.time < until);
    Trajectory {
        move_ends: running.move_ends[passed..passed + moves].to_vec(),
        end: running.end,
        splice: until,
        ..Trajectory::of(running.knots[first..behind.max(first)].to_vec())
    }
}

impl Trajectory {
    /// Comes to rest at its end and continues with moves from there.
    pub(crate) fn at_rest_then(mut self, moves: &[ContourMove], limits: &AxisLimits) -> Trajectory {
        self.knots.push(Knot {
            time: self.splice,
            state: AxesState::rest(moves[0].path.start()),
            jerk: Point::zeros(),
        });
        self.append(plan_with(moves, limits, PlanningTime::Streaming));
        self
    }

    /// Appends a motion that begins at an instant in the state of this one.
    fn join(&mut self, tail: Trajectory, at: f64) {
        self.knots.extend(tail.knots.into_iter().map(|knot| Knot {
            time: knot.time + at,
            ..knot
        }));
        self.end = tail.end;
    }
}
