//! When the active move of a planned contour comes to points before its end, along the curve that it is travelled on.
//!
//! Real-time: nothing allocates, bounded.

use super::ContourQueue;
use super::run::RunState;
use crate::{Clock, EventTime};

impl<T: Copy> ContourQueue<T> {
    /// When so much of the active move is left, at least 0, after it became active. The end is where the next one becomes
    /// active: nearest to the corner where that is rounded.
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
            // A rounded corner may be shorter than what was programmed.
            Some(own) => own.max(from),
            None => return EventTime::Passed,
        };
        match run.pace.until(own, clock) {
            Some(until) => EventTime::At((begun.elapsed(clock) + until).max(0.0)),
            None if own <= run.pace.at(clock).position => EventTime::Passed,
            None => EventTime::Never,
        }
    }

    /// Seconds, or as [`ContourQueue::reaches`], until the next move becomes active, or the contour is at its end; `None` where it is
    /// paused or stops.
    pub fn time_left(&self, clock: &Clock) -> Option<f64> {
        let run = self.run.as_ref().filter(|run| run.state != RunState::Stopping)?;
        let end = run.trajectory.move_end(run.passed).unwrap_or(run.trajectory.duration());
        run.pace.until(end, clock).map(|left| left.max(0.0))
    }

    /// Whether the active move stays at rest before its end, as things are.
    pub fn is_paused(&self) -> bool {
        let Some(run) = &self.run else {
            return true;
        };
        run.state == RunState::Stopping || run.pace.target() == 0.0
    }

    /// A number that changes whenever the active move is another one, or comes to its end at another instant.
    pub fn plans(&self) -> u32 {
        self.plans
    }
}
