//! Rests of a contour between two moves that should follow without one, and their causes.
//!
//! Real-time: nothing allocates.

use super::ContourQueue;
use super::run::RunState;
use crate::{Clock, Ending, Move};

/// Rests of contours between moves that should follow without one, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContourRests {
    /// The queue was empty: the program sent its next move too late.
    pub starved: u32,
    /// No plan for the waiting moves was ready in time.
    pub unplanned: u32,
}

impl<T: Copy> ContourQueue<T> {
    /// The rests since the start.
    pub fn rests(&self) -> ContourRests {
        self.rests
    }

    /// Records the end of a trajectory, after its last move.
    pub(super) fn count_end(&mut self, last: Option<&Move<T>>, time: &Clock) {
        let travelling = self.run.as_ref().is_some_and(|run| run.state == RunState::Travelling);
        let Some(last) = last.filter(|last| travelling && last.ending != Ending::Stop) else {
            return;
        };
        match self.moves.front() {
            None => self.open_end = Some(time.now()),
            Some(next) if last.leads_into(next) => {
                self.rests.unplanned = self.rests.unplanned.wrapping_add(1);
            }
            Some(_) => {}
        }
    }

    /// Records the arrival of a move: it is late if the contour that it should have continued has just ended.
    pub(super) fn count_late_move(&mut self, time: &Clock) {
        if self.open_end.take().is_some_and(|end| end.elapsed(time) < LATE_S) {
            self.rests.starved = self.rests.starved.wrapping_add(1);
            self.is_late = true;
        }
    }
}

/// Seconds after the end of a contour within which an arriving move counts as its late continuation.
const LATE_S: f64 = 1.0;
