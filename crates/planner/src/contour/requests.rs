//! The selection of moves to plan, and the start of a plan: from rest, or as the continuation of a trajectory in execution.
//!
//! Real-time: nothing here allocates or frees.

use std::sync::Arc;

use arcline_contour::{AxisLimits, ContourMove, ExtensionRequest, Rates, Trajectory, extend, extend_slowed, replan};
use arcline_profile::stop_distance;

use super::ContourQueue;
use super::pace::Pace;
use super::run::{PlanRequest, RunState, RunningTrajectory, least};
use super::tuning::{
    AMPLE_S, ENOUGH_MOVES, ENOUGH_S, FEW_MOVES, FEW_MOVES_LATER, GATHER_S, LATE_S, LEAST_BEGUN_S, LEAST_LEFT_S,
    LEAST_PACE_SHARE, LONG_MOVE_S, LONGEST_GATHER_S, MANY_MOVES, MOST_PLANNING_S, MOST_PLANNING_SHARE, NEAR_S,
    PLANNING_MARGIN, PLANNING_S, RETRY_ANEW_SHARE, RETRY_SHARE, SETTLED_S, UNCHANGED_S, WAITING_PACE,
};
use crate::{Clock, Ending, Move};

/// A requested plan.
#[derive(Clone, Debug)]
pub struct ContourBatch {
    /// The number that the plan must carry.
    pub generation: u32,
    /// The trajectory in execution meanwhile; `None`: the plan begins at rest.
    pub extends: Option<Extension>,
}

/// A trajectory in execution to be extended ([`arcline_contour::extend`]).
#[derive(Clone, Debug)]
pub struct Extension {
    /// The trajectory.
    pub trajectory: Arc<Trajectory>,
    /// Its moves that are complete.
    pub passed: usize,
    /// The present position on it, seconds of its own time.
    pub now: f64,
    /// The instant until which it must stay unchanged, seconds of its own time.
    pub earliest: f64,
    /// What the plan continues.
    pub continues: Continues,
}

/// What the plan of an extension continues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Continues {
    /// The trajectory as it is planned ([`arcline_contour::extend`]).
    AsPlanned,
    /// The trajectory at a constant pace, which waits for an extension ([`arcline_contour::extend_slowed`]).
    Slowed(f64),
    /// The trajectory at a constant pace, whose rest is planned anew for changed moves ([`arcline_contour::replan`]).
    Anew(f64),
}

impl Continues {
    /// The constant pace; `None`: any pace.
    fn pace(self) -> Option<f64> {
        match self {
            Continues::AsPlanned => None,
            Continues::Slowed(pace) | Continues::Anew(pace) => Some(pace),
        }
    }
}

impl Extension {
    /// Plans the extension. Not bounded: outside the tick.
    #[must_use]
    pub fn plan(&self, moves: &[ContourMove], limits: &AxisLimits) -> Option<Trajectory> {
        let Extension {
            trajectory,
            passed,
            now,
            earliest,
            continues,
        } = self;
        let pace = continues.pace().unwrap_or(1.0);
        let request = ExtensionRequest {
            running: trajectory,
            passed: *passed,
            moves,
            limits,
            now: now / pace,
            earliest: earliest / pace,
        };
        match continues {
            Continues::AsPlanned => extend(&request),
            Continues::Slowed(_) => extend_slowed(&request, pace),
            Continues::Anew(_) => replan(&request, pace),
        }
    }
}

impl<T: Copy> ContourQueue<T> {
    /// The moves to plan now, up to the first that ends in a stop: from rest, or together with the rest of the trajectory in execution. A queue
    /// with room waits a moment for further moves; `time` shows time for that. Requests each plan once.
    pub fn batch(&mut self, clock: &Clock, time: &Clock, take: impl FnMut(ContourMove)) -> Option<ContourBatch> {
        if self.asked.is_some() || self.moves.is_empty() {
            return None;
        }
        let extends = match &self.run {
            None => {
                let mut joints = self.moves.iter().zip(self.moves.iter().skip(1));
                let ends = self.moves.back().is_some_and(|last| last.ending == Ending::Stop);
                let open = !self.is_full() && !ends && joints.all(|(before, next)| before.leads_into(next));
                if open && self.is_gathering(time) {
                    return None;
                }
                None
            }
            Some(run) if self.moves[0].limits.speed > 0.0 && run.waits(clock) => None,
            Some(run) => Some(self.extension(run, clock, time)?),
        };
        let as_planned = extends
            .as_ref()
            .is_some_and(|extension| extension.continues == Continues::AsPlanned);
        self.take_moves(as_planned, take);
        let is_s_curve = self.is_s_curve();
        self.asked = Some(match &extends {
            None => PlanRequest::Contour,
            Some(Extension { passed, continues, .. }) => match continues.pace() {
                None => PlanRequest::Extension { passed: *passed },
                Some(pace) => PlanRequest::Anew { passed: *passed, pace },
            },
        });
        if let (Some(run), Some(extension)) = (&mut self.run, &extends) {
            run.asked = extension.now;
            let late = extension.now + LATE_S;
            run.due = if is_s_curve { late.max(extension.earliest) } else { late };
        }
        self.generation = self.generation.wrapping_add(1);
        Some(ContourBatch {
            generation: self.generation,
            extends,
        })
    }

    /// The queue waits for further moves: the first unplanned move has just arrived, so others may follow at once. After a contour that came to
    /// rest because the program was too slow, it waits longer, while moves keep arriving and are too short to plan the next contour in time.
    fn is_gathering(&self, time: &Clock) -> bool {
        let Some(waited) = self.gathering.map(|first| first.elapsed(time)) else {
            return false;
        };
        let longer = self.is_late && waited < LONGEST_GATHER_S;
        let count = self.moves.len();
        let suffice = count >= MANY_MOVES || (count >= ENOUGH_MOVES && self.lasts(ENOUGH_S));
        (waited < GATHER_S && !suffice) || (longer && self.is_growing(time) && !self.lasts(LEAST_BEGUN_S))
    }

    /// The moves last for at least this many seconds at their programmed speeds.
    fn lasts(&self, seconds: f64) -> bool {
        let mut sum = 0.0;
        self.moves.iter().any(|motion| {
            sum += motion.path.length() / motion.limits.speed;
            sum >= seconds
        })
    }

    /// A move has arrived so recently that the next one may follow at once.
    fn is_growing(&self, time: &Clock) -> bool {
        self.grown.is_some_and(|grown| grown.elapsed(time) < GATHER_S)
    }

    /// No move has arrived for so long that the next ones are not waited for.
    fn is_settled(&self, time: &Clock) -> bool {
        self.grown.is_none_or(|grown| grown.elapsed(time) >= SETTLED_S)
    }

    /// The part of the trajectory to plan anew, if its moves have changed speeds or rates and its pace is within them; or the trajectory to
    /// extend, if many moves wait, or if no move has arrived for a moment and its end is near.
    fn extension(&self, run: &RunningTrajectory, clock: &Clock, time: &Clock) -> Option<Extension> {
        let planned = self.planned();
        let state = run.pace_at(clock);
        let (now, pace) = (state.position, state.velocity);
        let left = run.trajectory.duration() - now;
        let is_settled = run.pace.is_settled(clock);
        // At the low pace, an extension is found as soon as the pace is constant.
        let slowed_retry = run.slowed_retry.filter(|_| run.waits_for_extension);
        let is_slow = is_settled && pace >= LEAST_PACE_SHARE * WAITING_PACE;
        let is_s_curve = self.is_s_curve();
        let waits = match slowed_retry {
            Some(retry) if is_slow => now < retry,
            // The pace of trapezoids is soon low; that of S-curves may take all of the rest.
            Some(_) if !is_s_curve && !is_settled && run.pace.is_under_way() => true,
            _ => now < run.retry,
        };
        if run.state != RunState::Travelling || waits || left <= 0.0 {
            return None;
        }
        let ask = |continues: Continues| {
            let pace = continues.pace().unwrap_or(1.0);
            let planning = run.planning_s.min(MOST_PLANNING_SHARE * left / pace).max(PLANNING_S);
            Extension {
                trajectory: Arc::clone(&run.trajectory),
                passed: run.passed,
                now,
                earliest: now + planning * pace,
                continues,
            }
        };
        let calm = run.changed.elapsed(clock) >= UNCHANGED_S && is_settled;
        if run.stale && calm && pace >= LEAST_PACE_SHARE && left >= LEAST_LEFT_S * pace {
            return Some(ask(Continues::Anew(pace)));
        }
        let waiting = self.moves.len().checked_sub(planned).filter(|&waiting| waiting > 0)?;
        let last = self.moves.get(planned.checked_sub(1)?)?;
        let next = self.moves.get(planned)?;
        if !last.leads_into(next) {
            return None;
        }
        if slowed_retry.is_some() && is_slow {
            return Some(ask(Continues::Slowed(pace)));
        }
        // While there is time, more moves are waited for: each extension plans the end of the trajectory anew.
        let until_braking = run.trajectory.brakes_from() - now;
        let few = if until_braking > AMPLE_S + run.planning_s {
            FEW_MOVES_LATER
        } else {
            FEW_MOVES
        };
        let many = waiting * few >= planned;
        let near = (left <= NEAR_S || self.is_settled(time)) && !self.is_growing(time);
        (many || near).then(|| ask(Continues::AsPlanned))
    }

    /// The active move is an S-curve.
    pub(super) fn is_s_curve(&self) -> bool {
        self.moves.front().is_some_and(|active| active.limits.jerk.is_some())
    }

    /// The override for which moves are planned: 1 if a move is too long to be planned anew when the override rises again.
    pub(super) fn planned_rate(&self) -> f64 {
        let slowest = self.rate.max(LEAST_PACE_SHARE);
        let long = |motion: &Move<T>| motion.path.length() > LONG_MOVE_S * motion.limits.speed * slowest;
        if self.rate < 1.0 && self.moves.iter().any(long) {
            1.0
        } else {
            self.rate
        }
    }

    /// Passes the moves to a plan. `as_planned`: the moves on the trajectory stay as they were planned.
    fn take_moves(&self, as_planned: bool, mut take: impl FnMut(ContourMove)) {
        let running = self.run.as_ref().filter(|_| as_planned);
        // New moves behind moves that wait to be planned anew get the same share of their speed.
        let like = running.filter(|run| run.stale).and_then(|run| {
            let last = self.moves.get(self.planned().checked_sub(1)?)?;
            let planned = run.trajectory.rates(run.trajectory.moves().checked_sub(1)?)?;
            (last.limits.speed > 0.0).then_some(planned.speed / last.limits.speed)
        });
        let rate = like.unwrap_or_else(|| self.planned_rate());
        for (move_index, motion) in self.moves.iter().enumerate() {
            let (tolerance, last) = match motion.ending {
                Ending::Stop => (0.0, true),
                Ending::Blend { tolerance } if tolerance.is_finite() => (tolerance, false),
                Ending::Blend { .. } => (
                    self.moves
                        .get(move_index + 1)
                        .map_or(0.0, |next| no_decel(motion, next)),
                    false,
                ),
                Ending::Contour { .. } => (0.0, false),
            };
            let planned = running.and_then(|run| run.trajectory.rates(run.passed + move_index));
            let own = planned.copied().unwrap_or(Rates {
                speed: planned_speed(motion, rate),
                acceleration: motion.limits.acceleration,
                deceleration: motion.limits.deceleration,
                jerk: motion.limits.jerk.map(least),
            });
            take(ContourMove {
                path: motion.path,
                speed: own.speed,
                acceleration: own.acceleration,
                deceleration: own.deceleration,
                jerk: own.jerk,
                tolerance,
                deviation: self.deviation,
            });
            let next = self.moves.get(move_index + 1);
            if last || next.is_some_and(|next| !motion.leads_into(next)) {
                break;
            }
        }
    }

    /// Takes a plan at the present tick: starts it, or continues with it if it extends the trajectory in execution, which is returned. `None`:
    /// no plan was found, and the trajectory in execution continues to its end.
    ///
    /// # Errors
    /// The plan itself if it cannot be used: the moves were cancelled or changed meanwhile, or the motion is already beyond the splice.
    pub fn install(
        &mut self,
        generation: u32,
        planned: Option<Arc<Trajectory>>,
        clock: &Clock,
    ) -> Result<InstalledPlan, Option<Arc<Trajectory>>> {
        let Some(asked) = self.asked.filter(|_| generation == self.generation) else {
            return Err(planned);
        };
        self.asked = None;
        match asked {
            PlanRequest::Contour => match planned {
                Some(plan) if plan.moves() <= self.moves.len() => {
                    let before = self.run.take();
                    self.start(plan, clock);
                    Ok(before.map_or(InstalledPlan::Started, |before| {
                        InstalledPlan::Extended(before.trajectory)
                    }))
                }
                unwanted => {
                    // The trajectory that stands is travelled as it is.
                    if let Some(run) = &mut self.run {
                        run.stood = false;
                    }
                    self.change_pace(clock);
                    Err(unwanted)
                }
            },
            PlanRequest::Extension { passed } => self.extend(passed, None, planned, clock),
            PlanRequest::Anew { passed, pace } => self.extend(passed, Some(pace), planned, clock),
        }
    }

    fn start(&mut self, trajectory: Arc<Trajectory>, clock: &Clock) {
        let nominal = self.nominal();
        self.is_late = false;
        self.run = Some(RunningTrajectory {
            pace: Pace::constant(0.0, 0.0, clock),
            trajectory,
            passed: 0,
            begun: (clock.now(), 0.0),
            gone: (0.0, 0.0),
            rounded: 0.0,
            stale: false,
            stood: false,
            waits_for_extension: false,
            slowed_retry: None,
            changed: clock.now(),
            state: RunState::Travelling,
            planning_s: PLANNING_S,
            asked: 0.0,
            due: 0.0,
            retry: 0.0,
            nominal,
        });
        self.change_pace(clock);
        // It begins at rest, so any pace is possible.
        if let Some(run) = &mut self.run {
            run.pace = Pace::constant(0.0, run.pace.target(), clock);
        }
    }

    fn extend(
        &mut self,
        passed: usize,
        pace: Option<f64>,
        planned: Option<Arc<Trajectory>>,
        clock: &Clock,
    ) -> Result<InstalledPlan, Option<Arc<Trajectory>>> {
        let left = self.moves.len();
        let Some(run) = &mut self.run else {
            return Err(planned);
        };
        // A plan made anew takes as much of the trajectory's own time as it takes time.
        let own = run.pace_at(clock).position;
        let now = own / pace.unwrap_or(1.0);
        let since = run.passed.saturating_sub(passed);
        // The next plan has time for as long again.
        let took = PLANNING_MARGIN * (own - run.asked) / pace.unwrap_or(1.0);
        let fits = |plan: &Arc<Trajectory>| {
            let in_time = now <= plan.splice() && since < plan.moves() && plan.moves() - since <= left;
            in_time && (pace.is_some() || run.pace.suits(plan, &run.trajectory, clock))
        };
        match planned {
            Some(plan) if fits(&plan) => {
                run.gone = (now, run.gone_at(own));
                run.rounded /= pace.unwrap_or(1.0);
                run.pace = run.pace.on(&plan, &run.trajectory, clock);
                let old = std::mem::replace(&mut run.trajectory, plan);
                run.passed = since;
                run.slowed_retry = None;
                run.planning_s = took.clamp(PLANNING_S, MOST_PLANNING_S);
                if pace.is_some() {
                    run.pace = Pace::constant(now, 1.0, clock);
                    run.begun.1 /= pace.unwrap_or(1.0);
                    run.retry = 0.0;
                }
                self.change_pace(clock);
                Ok(InstalledPlan::Extended(old))
            }
            unfit => {
                // A late plan doubles the time for the next one, which is planned at once. A failed plan is retried later, and so is one that does not suit the
                // pace, which may be changing.
                let is_late = unfit.as_ref().is_some_and(|plan| now > plan.splice());
                let longer = if unfit.is_some() {
                    2.0 * run.planning_s
                } else {
                    PLANNING_S
                };
                let share = match pace {
                    _ if is_late => 0.0,
                    Some(_) => RETRY_ANEW_SHARE,
                    None => RETRY_SHARE,
                };
                run.planning_s = longer.max(took).min(MOST_PLANNING_S);
                let retry = own + share * (run.trajectory.duration() - own);
                // One that does not suit the pace which falls because of it has failed as well.
                let has_failed = is_late || unfit.is_none() || run.waits_for_extension;
                run.slowed_retry = match pace {
                    Some(_) => run.slowed_retry.map(|_| retry),
                    None => has_failed.then_some(own).or(run.slowed_retry),
                };
                run.retry = retry;
                Err(unfit)
            }
        }
    }
}

/// The speed for which a move is planned; a move that is held, or whose speed was changed to 0, is planned at full speed, with a pace of 0.
pub(super) fn planned_speed<T>(motion: &Move<T>, rate: f64) -> f64 {
    let rate = if rate > 0.0 { rate.max(LEAST_PACE_SHARE) } else { 1.0 };
    let speed = motion.limits.speed;
    rate * if speed > 0.0 { speed } else { motion.last_speed }
}

/// The use of a plan.
#[derive(Debug)]
pub enum InstalledPlan {
    /// Its first move is active.
    Started,
    /// The trajectory continues with it; this is the replaced one, to be freed elsewhere.
    Extended(Arc<Trajectory>),
}

/// The deviation from a corner by superposition without a tolerance, and thus the rounding that No Decel permits
/// (spec/motion-core.md §6.1; the lower bound, which holds for S-curves too).
fn no_decel<T>(first: &Move<T>, second: &Move<T>) -> f64 {
    let turn = (second.path.start_tangent() - first.path.end_tangent()).norm();
    0.125 * turn * stop_distance(first.limits.speed, &first.limits)
}
