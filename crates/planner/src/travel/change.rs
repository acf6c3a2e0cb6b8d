//! Changes of the dynamics and of the override during moves.

use arcline_profile::Limits;

use super::Travel;
use crate::{ContourQueue, Move, TimeBase};

impl<T: Copy> Travel<T> {
    /// The override: a share of the programmed speeds of all moves.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Sets the override: a share (at least 0) of the programmed speeds of all moves, from the present tick on; 0 holds.
    pub fn set_rate(&mut self, rate: f64, base: &TimeBase) {
        self.rate = rate;
        let clock = self.contour_clock(base);
        if let Some(contour) = &mut self.contour {
            contour.set_rate(rate, &clock);
        }
        self.planner.set_rate(rate, &base.clock());
    }

    /// Changes all pending moves; `limits` are the future ones of the active move. [`Travel::change_limits`] then puts the change into effect.
    pub fn change_waiting(&mut self, limits: &Limits, base: &TimeBase, mut change: impl FnMut(&mut Move<T>)) {
        let active = usize::from(self.contour_in_force().is_some_and(ContourQueue::is_running));
        if let Some(contour) = &mut self.contour {
            for waiting in contour.moves_mut().skip(active) {
                change(waiting);
                waiting.set_limits(waiting.parameter.in_time(&waiting.limits));
            }
        }
        self.planner.change_pending(limits, &base.clock(), change);
    }

    /// Gives the active move new limits from the present tick on ([`crate::Planner::change_limits`], [`ContourQueue::change`]).
    pub fn change_limits(&mut self, limits: Limits, base: &TimeBase) {
        let clock = self.contour_clock(base);
        match self.contour_in_force_mut() {
            Some(contour) => {
                let in_time = contour.moves().next().map(|active| active.parameter.in_time(&limits));
                contour.change_limits(in_time.unwrap_or(limits), &clock);
            }
            None => self.planner.change_limits(limits, &base.clock()),
        }
    }
}
