//! A queue whose moves are travelled as planned contours (`corner = "precise"`, `axis_limits = "enforce"`).
//!
//! Planning a contour is not bounded, so it is done elsewhere: the queue says which moves are to be planned
//! ([`ContourQueue::batch`]), gets a finished [`Trajectory`] back ([`ContourQueue::install`]) and evaluates it. A stop
//! slows down the pace at which the trajectory's own time runs, so it never leaves the path
//! (spec/motion-core.md §10.3), and so does an override below 100 % (`pace`), within all limits (`guard`).
//! Nothing here allocates or frees: trajectories are handed back.
//!
//! Moves over a master's displacement are planned by time too, for a master at the speed of their [`crate::Parameter`], and travelled by the
//! time that a master at that speed would have taken for its way: all clocks that a queue is given show that, but where
//! they are said to show time. Limits are by time ([`crate::Parameter::in_time`]).

mod events;
mod guard;
mod pace;
mod requests;
mod rests;
mod stopping;

use std::collections::VecDeque;
use std::sync::Arc;

use arcline_contour::{Deviation, Trajectory};
use arcline_geometry::Point;
use arcline_profile::{Jerk, KinematicState, Limits, Phase};

use crate::{Clock, Instant, Move, QueueFull, Sample};
use pace::{Pace, Wanted};

use crate::tolerance::{CREEPING_SHARE, SAME_INSTANT_S, SAME_SHARE, STEADY_SHARE};
pub use requests::{ContourBatch, Extension, Installed};
pub use rests::ContourRests;
pub use stopping::ContourStopping;

/// One active move and the pending ones, of which the first few are on a planned trajectory.
#[derive(Debug)]
pub struct ContourQueue<T> {
    moves: VecDeque<Move<T>>,
    depth: usize,
    deviation: Deviation,
    run: Option<Run>,
    asked: Option<Asked>,
    generation: u32,
    /// When the last move was queued, and the first of those that wait.
    grown: Option<Instant>,
    gathering: Option<Instant>,
    /// The override: share of the programmed speeds.
    rate: f64,
    /// Counts what changes when moves come to their ends.
    plans: u32,
    /// Rests between moves that go on, and the end of a contour that would have gone on, had there been another move.
    rests: ContourRests,
    open_end: Option<Instant>,
    /// The program was too slow for the last contour: before the next one more moves are waited for.
    is_late: bool,
}

/// A plan under way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Asked {
    /// From rest.
    Contour,
    /// Of what follows a trajectory in execution, of which so many moves had been completed then.
    Extension {
        /// Moves of it that had been completed.
        passed: usize,
    },
    /// Of what is left of a trajectory in execution, with what its moves are to have now.
    Anew {
        /// Moves of it that had been completed.
        passed: usize,
        /// The pace that it was travelled at.
        pace: f64,
    },
}

/// A trajectory in execution.
#[derive(Debug)]
struct Run {
    trajectory: Arc<Trajectory>,
    /// Moves of it that have been completed.
    passed: usize,
    /// When its active move became active, and where that was, seconds on the trajectory's own time.
    begun: (Instant, f64),
    /// How far the active move had gone at a place on the trajectory's own time: that place in seconds, and units along the curve.
    gone: (f64, f64),
    /// Until when the corner before the active move is rounded, seconds on the trajectory's own time.
    rounded: f64,
    /// How fast its own time runs.
    pace: Pace,
    /// It was not planned for what its moves are to have now.
    stale: bool,
    /// Since when they are to have that.
    changed: Instant,
    course: Course,
    /// How long a plan that extends it may take, seconds on the trajectory's own time.
    lead: f64,
    /// Where on it the last one was asked for.
    asked: f64,
    /// Where on it an extension may be asked for again.
    retry: f64,
    /// The speed of the master that it was planned for, master units/s; 1 for time.
    nominal: f64,
}

/// What a pace of 0 means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Course {
    /// A hold: it goes on when the pace rises again.
    Travelling,
    /// The end.
    Stopping,
}

/// What lies at or before the present tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContourEvent {
    /// The active move is complete and the next one of the trajectory is active.
    Next,
    /// The trajectory is at its end, or a stop is.
    End,
}

impl<T: Copy> ContourQueue<T> {
    /// An empty queue with `depth` pending places. The only allocation.
    pub fn new(depth: usize) -> Self {
        ContourQueue {
            moves: VecDeque::with_capacity(depth + 1),
            depth,
            deviation: Deviation::Corners,
            run: None,
            asked: None,
            generation: 0,
            grown: None,
            gathering: None,
            rate: 1.0,
            plans: 0,
            rests: ContourRests::default(),
            open_end: None,
            is_late: false,
        }
    }

    /// Where its contours may deviate from the programmed path.
    #[must_use]
    pub fn deviating(self, deviation: Deviation) -> Self {
        ContourQueue { deviation, ..self }
    }

    /// Whether every pending place is taken.
    pub fn is_full(&self) -> bool {
        self.room(0) == 0
    }

    /// How many moves it takes until `depth` of them wait; `others`: the moves in front of it that are not in this queue.
    pub(crate) fn room(&self, others: usize) -> usize {
        (self.depth + 1).saturating_sub(self.moves.len() + others)
    }

    /// The active move of the trajectory in execution.
    pub(crate) fn active(&self) -> Option<&Move<T>> {
        self.run.as_ref()?;
        self.moves.front()
    }

    /// The next move on the trajectory in execution.
    pub(crate) fn next_planned(&self) -> Option<&Move<T>> {
        let run = self.run.as_ref()?;
        self.moves.get(1).filter(|_| run.passed + 1 < run.trajectory.moves())
    }

    /// The speed of a master that the trajectory in execution, or the next one, is planned for, master units/s; 1 for time.
    pub(crate) fn nominal(&self) -> f64 {
        let next = || self.moves.front().map(|motion| motion.parameter.speed);
        self.run.as_ref().map(|run| run.nominal).or_else(next).unwrap_or(1.0)
    }

    /// The programmed jerk of a trajectory that is being stopped: its moves have left the queue.
    pub(crate) fn jerk_of_stop(&self) -> Option<f64> {
        let run = self.run.as_ref().filter(|run| run.course == Course::Stopping)?;
        run.trajectory.least_rates().jerk
    }

    /// The moves, the active one first.
    pub fn moves(&self) -> impl Iterator<Item = &Move<T>> {
        self.moves.iter()
    }

    /// Takes the first move out.
    pub fn pop(&mut self) -> Option<Move<T>> {
        self.moves.pop_front()
    }

    /// Takes the last move out, unless it is the active one of a trajectory.
    pub fn pop_pending(&mut self) -> Option<Move<T>> {
        if self.is_running() && self.moves.len() <= 1 {
            return None;
        }
        self.moves.pop_back()
    }

    /// Whether a trajectory is being travelled.
    pub fn is_running(&self) -> bool {
        self.run.is_some()
    }

    /// Puts a move behind the last one. `time` shows time, whatever the move is a function of.
    ///
    /// # Errors
    /// [`QueueFull`] when all places are taken.
    pub fn push(&mut self, motion: Move<T>, time: &Clock) -> Result<(), QueueFull> {
        if self.is_full() {
            return Err(QueueFull);
        }
        self.grown = Some(time.now());
        self.count_late_move(time);
        if self.moves.is_empty() {
            self.gathering = self.grown;
        }
        self.moves.push_back(motion);
        Ok(())
    }

    /// Forgets every move and the trajectory, which is handed back to be freed elsewhere.
    pub fn clear(&mut self) -> Option<Arc<Trajectory>> {
        self.moves.clear();
        self.asked = None;
        self.run.take().map(|run| run.trajectory)
    }

    /// The trajectory is at its end, and its last move complete.
    pub(crate) fn end(&mut self, time: &Clock) -> Option<Arc<Trajectory>> {
        self.plans = self.plans.wrapping_add(1);
        let last = self.moves.pop_front();
        self.count_end(last.as_ref(), time);
        self.finish()
    }

    /// The trajectory is at its end: hands it back.
    pub fn finish(&mut self) -> Option<Arc<Trajectory>> {
        self.run.take().map(|run| run.trajectory)
    }

    /// What lies at or before the present tick, one thing at a time.
    pub fn event(&self, clock: &Clock) -> Option<ContourEvent> {
        let run = self.run.as_ref()?;
        let now = run.pace.at(clock);
        if run.course == Course::Stopping && now.velocity == 0.0 && now.acceleration == 0.0 {
            return Some(ContourEvent::End);
        }
        if now.position >= run.trajectory.duration() - SAME_INSTANT_S {
            return Some(ContourEvent::End);
        }
        let next = run.trajectory.move_end(run.passed)?;
        let more = run.passed + 1 < run.trajectory.moves();
        (more && now.position >= next - SAME_INSTANT_S).then_some(ContourEvent::Next)
    }

    /// The active move of the trajectory is complete: takes it out.
    pub fn pass(&mut self, clock: &Clock) -> Option<Move<T>> {
        if let Some(run) = &mut self.run {
            let own = run.trajectory.move_end(run.passed).unwrap_or(run.trajectory.duration());
            run.begun = (run.pace.instant_of(own, clock), own);
            run.gone = (own, 0.0);
            run.rounded = run.trajectory.rounding(run.passed).map_or(own, |rounding| rounding[1]);
            run.passed += 1;
        }
        self.plans = self.plans.wrapping_add(1);
        self.moves.pop_front()
    }

    /// The active move's data, to change.
    pub fn active_data(&mut self) -> Option<&mut T> {
        self.run.as_ref()?;
        self.moves.front_mut().map(|motion| &mut motion.data)
    }

    /// The moves, the active one first, to change; [`ContourQueue::change`] makes it take effect.
    pub fn moves_mut(&mut self) -> impl Iterator<Item = &mut Move<T>> {
        self.asked = None;
        self.moves.iter_mut()
    }

    /// How many moves are on the trajectory in execution, or still to come on it.
    fn planned(&self) -> usize {
        self.run.as_ref().map_or(0, |run| run.trajectory.moves() - run.passed)
    }

    /// Takes an override: a share of the programmed speeds, 0 holds.
    pub fn set_rate(&mut self, rate: f64, clock: &Clock) {
        self.rate = rate;
        if matches!(self.asked, Some(Asked::Anew { .. })) {
            self.asked = None;
        }
        self.change(clock);
    }

    /// Speeds or rates of moves have changed, or the override has. A trajectory in execution is slowed down to a pace that is
    /// within all of them, or comes back to its own; then what is left of it is planned anew.
    pub fn change(&mut self, clock: &Clock) {
        self.change_pace(clock);
    }

    /// Goes on with what the pace is to come to, where that was not possible at once. At every tick, before all else.
    pub fn steer(&mut self, clock: &Clock) {
        if let Some(run) = &mut self.run
            && run.pace.steer(&run.trajectory, clock)
        {
            self.plans = self.plans.wrapping_add(1);
        }
    }

    /// Brings the pace to one, at most 1, with which every move is within its speed and rates.
    fn change_pace(&mut self, clock: &Clock) {
        let rate = self.planned_rate();
        let Some(run) = self.run.as_mut().filter(|run| run.course == Course::Travelling) else {
            return;
        };
        let left = run.trajectory.moves() - run.passed;
        let (mut target, mut stale) = (1.0_f64, false);
        for (place, motion) in self.moves.iter().take(left).enumerate() {
            let Some(planned) = run.trajectory.rates(run.passed + place) else {
                break;
            };
            let wanted = motion.limits;
            let own = wanted.jerk.map(least);
            let own_speed = requests::planned_speed(wanted.speed, rate);
            stale |= (own_speed / planned.speed - 1.0).abs() > SAME_SHARE;
            target = share_of(target, self.rate * wanted.speed / planned.speed);
            let shares = [
                (wanted.acceleration / planned.acceleration).sqrt(),
                (wanted.deceleration / planned.deceleration).sqrt(),
                own.zip(planned.jerk)
                    .map_or(1.0, |(own, planned)| libm::cbrt(own / planned)),
            ];
            for share in shares {
                stale |= (share - 1.0).abs() > SAME_SHARE;
                target = share_of(target, share);
            }
        }
        run.stale = stale;
        run.changed = clock.now();
        let speed = run.trajectory.peaks().speed.max(f64::MIN_POSITIVE);
        let rates = run.trajectory.least_rates();
        let wanted = Wanted {
            target,
            rate: rates.acceleration.min(rates.deceleration) / speed,
            jerk: rates.jerk.map(|jerk| jerk / speed),
            extra: [0.0; 2],
        };
        run.pace.ask(wanted, &run.trajectory, clock);
        self.plans = self.plans.wrapping_add(1);
    }

    /// As [`ContourQueue::stop`], where a master leads: `clock` shows its way as time, and `way` how that goes on. From now on the
    /// queue's clock is `time`. The master may have been faster than what was planned for, so no limits but those of the stop
    /// are looked at.
    pub fn stop_in_time(&mut self, limits: &Limits, rate: &crate::MasterRate, clock: &Clock, time: &Clock) {
        self.asked = None;
        let Some(run) = &mut self.run else {
            return;
        };
        let now = rate.in_time(run.pace.at(clock));
        let speed = run
            .trajectory
            .at(now.position)
            .velocity
            .norm()
            .max(CREEPING_SHARE * limits.speed);
        let jerk = limits.jerk.map(|jerk| jerk.deceleration / speed);
        run.course = Course::Stopping;
        run.pace = Pace::stopping(now, limits.deceleration / speed, jerk, time);
    }

    /// Brakes on the path from the present tick on, as the limits of the axes allow. The moves are the caller's to end.
    pub fn stop(&mut self, limits: &Limits, clock: &Clock) {
        self.asked = None;
        let Some(run) = &mut self.run else {
            return;
        };
        let now = run.pace.at(clock);
        let speed = run
            .trajectory
            .at(now.position)
            .velocity
            .norm()
            .max(CREEPING_SHARE * limits.speed);
        let jerk = limits.jerk.map(|jerk| jerk.deceleration);
        let wanted = Wanted {
            target: 0.0,
            rate: limits.deceleration / speed,
            jerk: jerk.map(|jerk| jerk / speed),
            extra: [limits.deceleration, jerk.unwrap_or(0.0)],
        };
        run.course = Course::Stopping;
        run.pace.ask(wanted, &run.trajectory, clock);
    }

    /// Length of the curve on which the active move is travelled, units: its part of rounded corners, not what was programmed.
    pub fn length(&self) -> f64 {
        self.run.as_ref().map_or(0.0, |run| {
            let end = run.trajectory.move_end(run.passed).unwrap_or(run.trajectory.duration());
            run.gone_at(end)
        })
    }

    /// Whether the corner before or behind the active move is being rounded at the present tick.
    pub fn in_transition(&self, clock: &Clock) -> bool {
        self.run.as_ref().is_some_and(|run| {
            let own = run.pace.at(clock).position;
            let next = run.trajectory.rounding(run.passed);
            own < run.rounded || next.is_some_and(|[from, to]| from < to && own >= from)
        })
    }

    /// Where the coordinate system is at the present tick.
    pub fn sample(&self, clock: &Clock) -> Option<Sample> {
        let run = self.run.as_ref()?;
        Some(run.at(run.pace.at(clock)))
    }
}

impl Run {
    /// Where the coordinate system is at a place of the trajectory's own time that goes on like this.
    fn at(&self, pace: KinematicState) -> Sample {
        let duration = self.trajectory.duration();
        let own = if pace.position >= duration - SAME_INSTANT_S {
            duration
        } else {
            pace.position
        };
        let at = self.trajectory.at(own);
        let velocity: Point = at.velocity * pace.velocity;
        let acceleration = at.acceleration * (pace.velocity * pace.velocity) + at.velocity * pace.acceleration;
        let speed = velocity.norm();
        let tangential = if speed > 0.0 {
            velocity.dot(&acceleration) / speed
        } else {
            0.0
        };
        Sample {
            position: at.position,
            velocity,
            acceleration,
            along: KinematicState {
                position: self.gone_at(own),
                velocity: speed,
                acceleration: tangential,
            },
            phase: self.phase(&velocity, tangential, pace.velocity),
            rotation_state: None,
        }
    }
}

impl Run {
    /// How far the active move has gone along the curve at an instant of the trajectory's own time, units.
    fn gone_at(&self, own: f64) -> f64 {
        let (at, gone) = self.gone;
        (gone + self.trajectory.arc_length(own) - self.trajectory.arc_length(at)).max(0.0)
    }

    /// What the speed along the curve does: a tangential acceleration of less than a hundredth of what the move and the axes may have
    /// in that direction, at the present pace, is none, as a planned contour is never quite without one.
    fn phase(&self, velocity: &Point, tangential: f64, pace: f64) -> Phase {
        let speed = velocity.norm();
        let axes = self.trajectory.axes().acceleration;
        let most = (0..3).fold(f64::INFINITY, |most, axis| {
            most.min(axes[axis] * speed / velocity[axis].abs())
        });
        let rates = self.trajectory.rates(self.passed);
        // Where it is about to start or has all but stopped, any is one.
        let creeps = rates.is_none_or(|rates| speed < STEADY_SHARE * pace * rates.speed);
        let share = if creeps { 0.0 } else { STEADY_SHARE * pace * pace };
        let slight = |programmed: Option<f64>| share * programmed.map_or(most, |rate| most.min(rate));
        if tangential > slight(rates.map(|rates| rates.acceleration)) {
            Phase::Accelerating
        } else if -tangential > slight(rates.map(|rates| rates.deceleration)) {
            Phase::Decelerating
        } else {
            Phase::Steady
        }
    }
}

/// The lesser of two shares; what is 1 but for rounding is 1.
fn share_of(target: f64, share: f64) -> f64 {
    if share < 1.0 - SAME_SHARE {
        target.min(share)
    } else {
        target
    }
}

/// The jerk that a contour is planned with.
fn least(jerk: Jerk) -> f64 {
    jerk.acceleration.min(jerk.deceleration)
}
