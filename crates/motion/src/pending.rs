//! The moves that wait in the planner of a coordinate system: they come, become active, are cancelled, and are owed changes.
//!
//! Real-time: bounded, however many wait.

use arcline_planner::profile::Limits;
use arcline_planner::{Clock, Instant, Move, QueueFull};

use crate::instructions::owed::{Change, Kinds, Owed};
use crate::system::{Planned, System};

/// What is known of all pending moves together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pending {
    owed: Owed,
    kinds: Kinds,
}

impl System {
    /// Puts a move behind the last one.
    ///
    /// # Errors
    /// [`QueueFull`] when all pending places are taken.
    pub(crate) fn enqueue(&mut self, motion: Move<Planned>, clock: &Clock) -> Result<(), QueueFull> {
        self.planner.enqueue(motion, clock)?;
        self.pending.kinds.add(&motion.data);
        Ok(())
    }

    /// The oldest pending move becomes active at an instant, with all changes that it is owed.
    pub(crate) fn hand_over(&mut self, at: Instant, clock: &Clock) {
        let owed = &self.pending.owed;
        self.planner.give_next(|motion, has| owed.give(motion, has));
        if let Some(active) = self.planner.hand_over(at, clock) {
            self.pending.kinds.remove(active);
        }
    }

    /// Takes the oldest pending move out of the queue.
    pub(crate) fn cancel_pending(&mut self) -> Option<Planned> {
        let cancelled = self.planner.cancel_pending()?;
        self.pending.kinds.remove(&cancelled);
        Some(cancelled)
    }

    /// The kinds of the moves that wait.
    pub(crate) fn pending_kinds(&self) -> Kinds {
        debug_assert_eq!(
            self.planner.pending().fold(Kinds::default(), |mut kinds, waiting| {
                kinds.add(&waiting.data);
                kinds
            }),
            self.pending.kinds,
            "every pending move is counted"
        );
        self.pending.kinds
    }

    /// Changes all pending moves: the nearest at once, as far as it takes to stop with the `limits` that the active one is to
    /// have, the others within the next updates.
    pub(crate) fn change_pending(&mut self, change: &[Change; 2], limits: &Limits, clock: &Clock) {
        let number = self.planner.owe();
        self.pending.owed.add(number, change);
        let owed = &self.pending.owed;
        self.planner
            .give_nearest(limits, clock, |motion, has| owed.give(motion, has));
    }

    /// Goes on with what was too long for one update; once in each.
    pub(crate) fn look_on(&mut self, clock: &Clock) {
        if self.planner.owes() {
            let owed = &self.pending.owed;
            self.planner.give_on(clock, |motion, has| owed.give(motion, has));
        } else {
            self.planner.look_on(clock);
        }
    }
}
