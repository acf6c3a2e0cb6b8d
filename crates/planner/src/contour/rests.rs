//! Rests on the way: why a contour came to rest between two moves that go on.
//!
//! Real-time: nothing allocates.

use super::ContourQueue;
use super::run::RunState;
use crate::{Clock, Ending, Move};

/// How often contours have come to rest between moves that go on, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContourRests {
    /// As the queue was empty: the program sent its next move too late.
    pub starved: u32,
    /// As no plan for the moves that waited was found in time.
    pub unplanned: u32,
}

impl<T: Copy> ContourQueue<T> {
    /// Rests on the way since the start.
    pub fn rests(&self) -> ContourRests {
        self.rests
    }

    /// A trajectory is at its end, with its last move.
    pub(super) fn count_end(&mut self, last: Option<&Move<T>>, time: &Clock) {
        let travelling = self.run.as_ref().is_some_and(|run| run.state == RunState::Travelling);
        let Some(last) = last.filter(|last| travelling && last.ending != Ending::Stop) else {
            return;
        };
        match self.moves.front() {
            None => self.open_end = Some(time.now()),
            Some(next) if next.parameter == last.parameter => {
                self.rests.unplanned = self.rests.unplanned.wrapping_add(1);
            }
            Some(_) => {}
        }
    }

    /// A move has come: too late, if a contour that would have gone on has just ended.
    pub(super) fn count_late_move(&mut self, time: &Clock) {
        if self.open_end.take().is_some_and(|end| end.elapsed(time) < LATE) {
            self.rests.starved = self.rests.starved.wrapping_add(1);
            self.is_late = true;
        }
    }
}

/// Seconds after the end of a contour in which another move is one that was to go on with it.
const LATE: f64 = 1.0;
