//! The times at which the active move of a planned contour reaches points before its end, along the planned curve.
//!
//! Real-time: nothing allocates, bounded.

use super::ContourQueue;
use super::run::RunState;
use crate::{Clock, EventTime};

impl<T: Copy> ContourQueue<T> {
    /// The time, after it became active, at which the active move has `distance` (at least 0) left. Its end is the point at which the next move
    /// becomes active: in a rounded corner, the one nearest to the corner.
    pub fn reaches(&self, distance: f64, clock: &Clock) -> EventTime {
        let (Some(run), Some(active)) = (&self.run, self.moves.front()) else {
            return EventTime::Never;
        };
        if distance > active.path.length() {
            return EventTime::At(0.0);
        }
        let (begun, from) = run.begun;
        let end = run.trajectory.move_end(run.passed).unwrap_or(run.trajectory.duration());
        let own = match run.trajectory.time_before(end, distance) {
            // The distance may be programmed longer than a curve with rounded corners is.
            Some(own) => own.max(from),
            None => return EventTime::Passed,
        };
        match run.pace.until(own, &run.trajectory, clock) {
            Some(until) => EventTime::At((begun.elapsed(clock) + until).max(0.0)),
            None if own <= run.pace_at(clock).position => EventTime::Passed,
            None => EventTime::Never,
        }
    }

    /// Seconds, or as [`ContourQueue::reaches`], until the next move becomes active or the contour ends; `None` while it is paused or
    /// stops.
    pub fn time_left(&self, clock: &Clock) -> Option<f64> {
        let run = self.run.as_ref().filter(|run| run.state != RunState::Stopping)?;
        let end = run.trajectory.move_end(run.passed).unwrap_or(run.trajectory.duration());
        run.pace.until(end, &run.trajectory, clock).map(|left| left.max(0.0))
    }

    /// The active move, at the present pace target, comes to rest before its end.
    pub fn is_paused(&self) -> bool {
        let Some(run) = &self.run else {
            return true;
        };
        run.state == RunState::Stopping || run.pace.target() == 0.0
    }

    /// A number that changes with the active move, and with the instant of its end.
    pub fn plans(&self) -> u32 {
        self.plans
    }
}
