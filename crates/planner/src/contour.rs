//! A queue whose moves are executed as planned contours (`corner = "precise"`, `axis_limits = "enforce"`).
//!
//! The planning time of a contour is not bounded, so it is planned elsewhere: the queue selects the moves to plan ([`ContourQueue::batch`]),
//! receives the finished [`Trajectory`] ([`ContourQueue::install`]) and evaluates it. A stop lowers the pace of the trajectory's own time, so
//! it never leaves the path (spec/motion-core.md §10.3); so does an override below 100 % (`pace`), within all limits (`guard`).
//! Nothing here allocates or frees: the queue returns trajectories to its caller.
//!
//! Moves over a master's displacement are planned by time as well, for a master at the nominal speed of their [`crate::Parameter`]. Their
//! variable is the time that a master at that speed needs for the displacement: all clocks passed to a queue show it, unless they are
//! documented to show time. Limits are by time ([`crate::Parameter::in_time`]).

mod change;
mod events;
mod guard;
mod pace;
mod ramp;
mod requests;
mod rests;
mod run;
mod stopping;
mod tuning;

use std::collections::VecDeque;
use std::sync::Arc;

use arcline_contour::{Deviation, Trajectory};
use arcline_profile::{DynamicsBits, Limits};

use crate::tolerance::SAME_INSTANT_S;
use crate::{Clock, Instant, Move, QueueFull, Sample};
pub use requests::{Continues, ContourBatch, Extension, InstalledPlan};
pub use rests::ContourRests;
use run::{PlanRequest, RunState, RunningTrajectory};
pub use stopping::ContourStopping;

/// One active move and the pending ones, of which the first few are on a planned trajectory.
#[derive(Debug)]
pub struct ContourQueue<T> {
    moves: VecDeque<Move<T>>,
    depth: usize,
    deviation: Deviation,
    dynamics_bits: DynamicsBits,
    /// The limits of the active move before the change that paused it.
    paused_from: Option<Limits>,
    run: Option<RunningTrajectory>,
    asked: Option<PlanRequest>,
    generation: u32,
    /// The instants at which the last move was queued, and the first of the unplanned ones.
    grown: Option<Instant>,
    gathering: Option<Instant>,
    /// The override: share of the programmed speeds.
    rate: f64,
    /// Counts the plans that change the ends of moves.
    plans: u32,
    /// Rests between moves that should follow without one, and the end of the last contour whose last move would have permitted a successor.
    rests: ContourRests,
    open_end: Option<Instant>,
    /// The program was too slow for the last contour: the next one waits for more moves.
    is_late: bool,
}

/// An event at or before the present tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContourEvent {
    /// The active move is complete and the next one of the trajectory is active.
    Next,
    /// The trajectory has reached its end, or a stop its rest.
    End,
}

impl<T: Copy> ContourQueue<T> {
    /// An empty queue with room for `depth` pending moves. The only allocation.
    pub fn new(depth: usize) -> Self {
        ContourQueue {
            moves: VecDeque::with_capacity(depth + 1),
            depth,
            deviation: Deviation::Corners,
            dynamics_bits: DynamicsBits::ALL,
            paused_from: None,
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

    /// Sets the permitted deviation of its contours from the programmed path.
    #[must_use]
    pub fn deviating(self, deviation: Deviation) -> Self {
        ContourQueue { deviation, ..self }
    }

    /// Sets the Dynamics Configuration Bits for later stops.
    pub(crate) fn set_dynamics_bits(&mut self, dynamics_bits: DynamicsBits) {
        self.dynamics_bits = dynamics_bits;
    }

    /// The queue has no room for a further pending move.
    pub fn is_full(&self) -> bool {
        self.room(0) == 0
    }

    /// The number of further moves until `depth` of them wait; `others`: moves in front of it that are not in this queue.
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

    /// The nominal speed of a master for the trajectory in execution, or the next one, master units/s; 1 for time.
    pub(crate) fn nominal(&self) -> f64 {
        let next = || self.moves.front().map(|motion| motion.parameter.speed);
        self.run.as_ref().map(|run| run.nominal).or_else(next).unwrap_or(1.0)
    }

    /// The programmed jerk of a trajectory that brakes: its moves have left the queue.
    pub(crate) fn jerk_of_stop(&self) -> Option<f64> {
        let run = self.run.as_ref().filter(|run| run.state == RunState::Stopping)?;
        run.trajectory.least_rates().jerk
    }

    /// The moves, the active one first.
    pub fn moves(&self) -> impl Iterator<Item = &Move<T>> {
        self.moves.iter()
    }

    /// Removes the first move.
    pub fn pop(&mut self) -> Option<Move<T>> {
        self.moves.pop_front()
    }

    /// Removes the last move, unless it is the active one of a trajectory.
    pub fn pop_pending(&mut self) -> Option<Move<T>> {
        if self.is_running() && self.moves.len() <= 1 {
            return None;
        }
        self.moves.pop_back()
    }

    /// A trajectory is in execution.
    pub fn is_running(&self) -> bool {
        self.run.is_some()
    }

    /// Adds a move at the end. `time` shows time, whatever the variable of the move.
    ///
    /// # Errors
    /// [`QueueFull`] if the queue has no room.
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

    /// Removes every move and the trajectory; the caller frees the trajectory elsewhere.
    pub fn clear(&mut self) -> Option<Arc<Trajectory>> {
        self.moves.clear();
        self.asked = None;
        self.run.take().map(|run| run.trajectory)
    }

    /// Ends the trajectory at its end, where its last move is complete.
    pub(crate) fn end(&mut self, time: &Clock) -> Option<Arc<Trajectory>> {
        self.plans = self.plans.wrapping_add(1);
        let last = self.moves.pop_front();
        self.count_end(last.as_ref(), time);
        self.finish()
    }

    /// Ends the trajectory at its end and returns it.
    pub fn finish(&mut self) -> Option<Arc<Trajectory>> {
        self.run.take().map(|run| run.trajectory)
    }

    /// The next event at or before the present tick.
    pub fn event(&self, clock: &Clock) -> Option<ContourEvent> {
        let run = self.run.as_ref()?;
        let now = run.pace_at(clock);
        if run.state == RunState::Stopping && now.velocity == 0.0 && now.acceleration == 0.0 {
            return Some(ContourEvent::End);
        }
        if now.position >= run.trajectory.duration() - SAME_INSTANT_S {
            return Some(ContourEvent::End);
        }
        let next = run.trajectory.move_end(run.passed)?;
        let more = run.passed + 1 < run.trajectory.moves();
        (more && now.position >= next - SAME_INSTANT_S).then_some(ContourEvent::Next)
    }

    /// Removes the active move of the trajectory, which is complete.
    pub fn pass(&mut self, clock: &Clock) -> Option<Move<T>> {
        if let Some(run) = &mut self.run {
            let own = run.trajectory.move_end(run.passed).unwrap_or(run.trajectory.duration());
            run.begun = (run.pace.instant_of(own, &run.trajectory, clock), own);
            run.gone = (own, 0.0);
            run.rounded = run.trajectory.rounding(run.passed).map_or(own, |rounding| rounding[1]);
            run.passed += 1;
        }
        self.plans = self.plans.wrapping_add(1);
        let passed = self.moves.pop_front();
        self.paused_from = None;
        if self.moves.front().is_some_and(|active| active.limits.speed == 0.0) {
            self.change_pace(clock);
        }
        passed
    }

    /// The active move's data, mutable.
    pub fn active_data(&mut self) -> Option<&mut T> {
        self.run.as_ref()?;
        self.moves.front_mut().map(|motion| &mut motion.data)
    }

    /// The moves, the active one first, mutable; [`ContourQueue::change`] puts a change into effect.
    pub fn moves_mut(&mut self) -> impl Iterator<Item = &mut Move<T>> {
        self.asked = None;
        self.moves.iter_mut()
    }

    /// The number of moves on the trajectory in execution that are not complete.
    fn planned(&self) -> usize {
        self.run.as_ref().map_or(0, |run| run.trajectory.moves() - run.passed)
    }

    /// Length of the planned curve of the active move, units: with its part of rounded corners, not the programmed length.
    pub fn length(&self) -> f64 {
        self.run.as_ref().map_or(0.0, |run| {
            let end = run.trajectory.move_end(run.passed).unwrap_or(run.trajectory.duration());
            run.gone_at(end)
        })
    }

    /// The motion is in the rounded corner before or after the active move at the present tick.
    pub fn in_transition(&self, clock: &Clock) -> bool {
        self.run.as_ref().is_some_and(|run| {
            let own = run.pace_at(clock).position;
            let next = run.trajectory.rounding(run.passed);
            own < run.rounded || next.is_some_and(|[from, to]| from < to && own >= from)
        })
    }

    /// The motion of the coordinate system at the present tick.
    pub fn sample(&self, clock: &Clock) -> Option<Sample> {
        let run = self.run.as_ref()?;
        Some(run.at(run.pace_at(clock)))
    }
}
