//! Which moves are to be planned, and the plan's way into execution: from rest, or on from a trajectory that runs.
//!
//! Real-time: nothing here allocates or frees.

use std::sync::Arc;

use arcline_contour::{AxisLimits, ContourMove, Rates, Trajectory, extend, replan};
use arcline_profile::stop_distance;

use super::ContourQueue;
use super::pace::Pace;
use super::run::{Asked, Run, RunState, least};
use super::tuning::{
    AMPLE_S, FEW_MOVES, FEW_MOVES_LATER, GATHER_S, LEAST_BEGUN_S, LEAST_LEFT_S, LEAST_PACE_SHARE, LONG_MOVE_S,
    LONGEST_GATHER_S, MOST_PLANNING_S, NEAR_S, PLANNING_MARGIN, PLANNING_S, RETRY_ANEW_SHARE, RETRY_SHARE, UNCHANGED_S,
};
use crate::{Clock, Ending, Move};

/// A plan that is asked for.
#[derive(Clone, Debug)]
pub struct ContourBatch {
    /// The plan is expected with it.
    pub generation: u32,
    /// The trajectory that runs meanwhile; `None`: the plan begins at rest.
    pub extends: Option<Extension>,
}

/// A trajectory in execution that is to be extended ([`arcline_contour::extend`]).
#[derive(Clone, Debug)]
pub struct Extension {
    /// The trajectory.
    pub trajectory: Arc<Trajectory>,
    /// Moves of it that are complete.
    pub passed: usize,
    /// Where on it the motion is, seconds on its own time.
    pub now: f64,
    /// Until when it has to stay as it is, seconds on its own time.
    pub earliest: f64,
    /// The pace that it is travelled at, where what is left of it is to be planned anew ([`arcline_contour::replan`]).
    pub anew: Option<f64>,
}

impl Extension {
    /// Plans what is asked for. Not bounded: outside the tick.
    #[must_use]
    pub fn plan(&self, moves: &[ContourMove], limits: &AxisLimits) -> Option<Trajectory> {
        let Extension {
            trajectory,
            passed,
            now,
            earliest,
            anew,
        } = self;
        match *anew {
            Some(pace) => replan(trajectory, pace, *passed, moves, limits, now / pace, earliest / pace),
            None => extend(trajectory, *passed, moves, limits, *now, *earliest),
        }
    }
}

impl<T: Copy> ContourQueue<T> {
    /// The moves that are to be planned now, up to the first that ends in a stop: from rest, or together with what is
    /// left of the trajectory in execution. A queue with room for more is given a moment to grow; `time` shows time for that.
    /// Asks once.
    pub fn batch(&mut self, clock: &Clock, time: &Clock, take: impl FnMut(ContourMove)) -> Option<ContourBatch> {
        if self.asked.is_some() || self.moves.is_empty() {
            return None;
        }
        let extends = match &self.run {
            None => {
                let first = self.moves.front().map(|motion| motion.parameter);
                let goes_on = |motion: &Move<T>| motion.ending != Ending::Stop && Some(motion.parameter) == first;
                let open = !self.is_full() && self.moves.iter().all(goes_on);
                if open && self.is_gathering(time) {
                    return None;
                }
                None
            }
            Some(run) => Some(self.extension(run, clock, time)?),
        };
        let kept = extends.as_ref().is_some_and(|extension| extension.anew.is_none());
        self.take_moves(kept, take);
        self.asked = Some(match extends {
            None => Asked::Contour,
            Some(Extension { passed, anew: None, .. }) => Asked::Extension { passed },
            Some(Extension {
                passed,
                anew: Some(pace),
                ..
            }) => Asked::Anew { passed, pace },
        });
        if let (Some(run), Some(extension)) = (&mut self.run, &extends) {
            run.asked = extension.now;
        }
        self.generation = self.generation.wrapping_add(1);
        Some(ContourBatch {
            generation: self.generation,
            extends,
        })
    }

    /// Whether the first of the moves that wait has come just now, so that others may be about to come with it, or, behind a contour that
    /// came to rest as the program was too slow, they still come and are not enough to plan on from before the motion is at its end.
    fn is_gathering(&self, time: &Clock) -> bool {
        let Some(waited) = self.gathering.map(|first| first.elapsed(time)) else {
            return false;
        };
        let longer = self.is_late && waited < LONGEST_GATHER_S;
        waited < GATHER_S || (longer && self.is_growing(time) && !self.lasts(LEAST_BEGUN_S))
    }

    /// Whether the moves last for so many seconds at their programmed speeds.
    fn lasts(&self, seconds: f64) -> bool {
        let mut sum = 0.0;
        self.moves.iter().any(|motion| {
            sum += motion.path.length() / motion.limits.speed;
            sum >= seconds
        })
    }

    /// Whether the next move may be about to come.
    fn is_growing(&self, time: &Clock) -> bool {
        self.grown.is_some_and(|grown| grown.elapsed(time) < GATHER_S)
    }

    /// What is to be planned anew, since its moves are to have other speeds or rates and its pace is within them, or what is to
    /// be extended, if it is time to: many moves wait, or nothing has come for a moment and its end is near.
    fn extension(&self, run: &Run, clock: &Clock, time: &Clock) -> Option<Extension> {
        let planned = self.planned();
        let state = run.pace.at(clock);
        let now = state.position;
        let left = run.trajectory.duration() - now;
        if run.state != RunState::Travelling || now < run.retry || left <= 0.0 {
            return None;
        }
        let ask = |anew: Option<f64>| Extension {
            trajectory: Arc::clone(&run.trajectory),
            passed: run.passed,
            now,
            earliest: now + run.lead * anew.unwrap_or(1.0),
            anew,
        };
        let pace = state.velocity;
        let calm = run.changed.elapsed(clock) >= UNCHANGED_S && run.pace.is_settled(clock);
        if run.stale && calm && pace >= LEAST_PACE_SHARE && left >= LEAST_LEFT_S * pace {
            return Some(ask(Some(pace)));
        }
        let waiting = self.moves.len().checked_sub(planned).filter(|&waiting| waiting > 0)?;
        let last = self.moves.get(planned.checked_sub(1)?)?;
        let next = self.moves.get(planned)?;
        // The more of it is left, the more are planned at once: each extension plans the end of what runs anew.
        let few = if left > AMPLE_S { FEW_MOVES_LATER } else { FEW_MOVES };
        let many = waiting * few >= planned;
        let near = left <= NEAR_S && !self.is_growing(time);
        let goes_on = last.ending != Ending::Stop && last.parameter == next.parameter;
        (goes_on && (many || near)).then(|| ask(None))
    }

    /// The share of the programmed speeds that is planned with: all of them where a move is too long to be planned anew when the
    /// override rises again.
    pub(super) fn planned_rate(&self) -> f64 {
        let slowest = self.rate.max(LEAST_PACE_SHARE);
        let long = |motion: &Move<T>| motion.path.length() > LONG_MOVE_S * motion.limits.speed * slowest;
        if self.rate < 1.0 && self.moves.iter().any(long) {
            1.0
        } else {
            self.rate
        }
    }

    /// `kept`: what is on the trajectory stays as it was planned.
    fn take_moves(&self, kept: bool, mut take: impl FnMut(ContourMove)) {
        let running = self.run.as_ref().filter(|_| kept);
        // What comes behind moves that are to be planned anew is planned like them.
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
                speed: planned_speed(motion.limits.speed, rate),
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
            if last || next.is_some_and(|next| next.parameter != motion.parameter) {
                break;
            }
        }
    }

    /// Takes a plan at the present tick: begins to travel it, or goes on with it where it extends the trajectory in
    /// execution, which is handed back. `None`: nothing was found; what runs goes on to its end.
    ///
    /// # Errors
    /// The plan itself when it cannot be used: the moves were cancelled or changed meanwhile, or the motion is already
    /// beyond the instant up to which both are the same.
    pub fn install(
        &mut self,
        generation: u32,
        planned: Option<Arc<Trajectory>>,
        clock: &Clock,
    ) -> Result<Installed, Option<Arc<Trajectory>>> {
        let Some(asked) = self.asked.filter(|_| generation == self.generation) else {
            return Err(planned);
        };
        self.asked = None;
        match asked {
            Asked::Contour => match planned {
                Some(plan) if plan.moves() <= self.moves.len() => {
                    self.start(plan, clock);
                    Ok(Installed::Started)
                }
                unwanted => Err(unwanted),
            },
            Asked::Extension { passed } => self.extend(passed, None, planned, clock),
            Asked::Anew { passed, pace } => self.extend(passed, Some(pace), planned, clock),
        }
    }

    fn start(&mut self, trajectory: Arc<Trajectory>, clock: &Clock) {
        let nominal = self.nominal();
        self.is_late = false;
        self.run = Some(Run {
            pace: Pace::constant(0.0, 0.0, clock),
            trajectory,
            passed: 0,
            begun: (clock.now(), 0.0),
            gone: (0.0, 0.0),
            rounded: 0.0,
            stale: false,
            changed: clock.now(),
            state: RunState::Travelling,
            lead: PLANNING_S,
            asked: 0.0,
            retry: 0.0,
            nominal,
        });
        self.change_pace(clock);
        // It begins at rest, so its pace may be anything.
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
    ) -> Result<Installed, Option<Arc<Trajectory>>> {
        let left = self.moves.len();
        let Some(run) = &mut self.run else {
            return Err(planned);
        };
        // A plan made anew has the time that passes.
        let own = run.pace.at(clock).position;
        let now = own / pace.unwrap_or(1.0);
        let since = run.passed.saturating_sub(passed);
        // The next one has time for as much again.
        let took = PLANNING_MARGIN * (own - run.asked) / pace.unwrap_or(1.0);
        let fits = |plan: &Arc<Trajectory>| {
            let in_time = now <= plan.splice() && since < plan.moves() && plan.moves() - since <= left;
            in_time && (pace.is_some() || run.pace.suits(plan, clock))
        };
        match planned {
            Some(plan) if fits(&plan) => {
                run.gone = (now, run.gone_at(own));
                run.rounded /= pace.unwrap_or(1.0);
                let old = std::mem::replace(&mut run.trajectory, plan);
                run.passed = since;
                run.lead = took.clamp(PLANNING_S, MOST_PLANNING_S);
                if pace.is_some() {
                    run.pace = Pace::constant(now, 1.0, clock);
                    run.begun.1 /= pace.unwrap_or(1.0);
                    run.retry = 0.0;
                }
                self.change_pace(clock);
                Ok(Installed::Extended(old))
            }
            late => {
                // Too late: the next one has more time. No plan: a later one begins later by itself.
                let lead = if late.is_some() { 2.0 * run.lead } else { PLANNING_S };
                run.lead = lead.max(took).min(MOST_PLANNING_S);
                let share = if pace.is_some() { RETRY_ANEW_SHARE } else { RETRY_SHARE };
                run.retry = own + share * (run.trajectory.duration() - own);
                Err(late)
            }
        }
    }
}

/// The speed that a move is planned with: one that is held is planned all the same, and its pace is 0.
pub(super) fn planned_speed(speed: f64, rate: f64) -> f64 {
    let rate = if rate > 0.0 { rate.max(LEAST_PACE_SHARE) } else { 1.0 };
    if speed > 0.0 { speed * rate } else { 1.0 }
}

/// The use that is made of a plan.
#[derive(Debug)]
pub enum Installed {
    /// Its first move is active.
    Started,
    /// The trajectory goes on with it; this is the one before, to be freed elsewhere.
    Extended(Arc<Trajectory>),
}

/// How far from a corner superposition without a tolerance would pass it: what No Decel may round by
/// (spec/motion-core.md §6.1; the lower bound, which holds for S-curves too).
fn no_decel<T>(first: &Move<T>, second: &Move<T>) -> f64 {
    let turn = (second.path.start_tangent() - first.path.end_tangent()).norm();
    0.125 * turn * stop_distance(first.limits.speed, &first.limits)
}
