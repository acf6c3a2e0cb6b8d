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

mod change;
mod events;
mod guard;
mod pace;
mod requests;
mod rests;
mod run;
mod stopping;
mod tuning;

use std::collections::VecDeque;
use std::sync::Arc;

use arcline_contour::{Deviation, Trajectory};

use crate::tolerance::SAME_INSTANT_S;
use crate::{Clock, Instant, Move, QueueFull, Sample};
pub use requests::{ContourBatch, Extension, Installed};
pub use rests::ContourRests;
use run::{Asked, Run, RunState};
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

/// An event at or before the present tick.
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
        let run = self.run.as_ref().filter(|run| run.state == RunState::Stopping)?;
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

    /// The next event at or before the present tick.
    pub fn event(&self, clock: &Clock) -> Option<ContourEvent> {
        let run = self.run.as_ref()?;
        let now = run.pace.at(clock);
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
