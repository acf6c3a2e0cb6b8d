//! The speeds of the bounds between pending moves: a pass backwards over the queue, within the budget of a tick.
//!
//! Units: position units, seconds. Nothing allocates.

use std::collections::VecDeque;

use arcline_profile::entry_speed;

use super::{MoveNumber, Queue};
use crate::junction::JunctionDemand;

/// A point with a highest speed; at that speed, the acceleration must be 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// Number of the move behind it.
    pub(crate) next: MoveNumber,
    /// Its position on the run before it.
    pub(crate) at: f64,
    pub(crate) demand: JunctionDemand,
    /// The highest speed, with the override for which it was computed.
    pub(super) speed: f64,
    /// The speed from which the corners behind it can be met, whatever the programmed speeds: infinite if the next rest comes before any
    /// corner.
    pub(super) corners: f64,
}

/// The next bound behind a point, or the end of the queue.
#[derive(Clone, Copy, Debug)]
pub(super) struct NextBound {
    at: f64,
    speed: f64,
    corners: f64,
}

/// An unfinished backward pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct BackwardPass {
    /// Bounds up to this number are still to be computed.
    pub(super) next: MoveNumber,
    /// Bounds up to this number are to be computed even if the bound behind them has not changed.
    pub(super) stale: MoveNumber,
    /// Bounds to compute in one tick.
    pub(super) work: usize,
}

/// Bounds to compute in one tick,
pub(super) const WORK: usize = 8;
/// and after a change of all moves: 40 µs, so that the change and its tick together stay below 100 µs with 1000 moves.
pub(super) const WORK_OF_A_CHANGE: usize = 160;
/// Moves whose bounds are computed at once after a change of all moves: at least, and at most.
pub(super) const LEAST: usize = 32;
pub(super) const MOST: usize = 128;

impl<T: Copy> Queue<T> {
    /// Continues a backward pass that was too long for one tick. Returns true if there was one.
    pub(crate) fn continue_pass(&mut self) -> bool {
        let work = self.backward_pass.map(|pass| pass.work);
        self.compute_bounds(work.unwrap_or(0));
        work.is_some()
    }

    /// Continues the backward pass over at most this number of bounds.
    pub(super) fn compute_bounds(&mut self, most: usize) {
        let Some(mut pass) = self.backward_pass.take() else {
            return;
        };
        let mut next = pass.next;
        let mut following = self.following(next);
        for _ in 0..most {
            let Some(bound) = self.before(next) else {
                return;
            };
            let looked_at = Bound {
                speed: self.speed_at(&bound, &following),
                corners: self.corners_from(&bound, &following),
                ..bound
            };
            following = looked_at.as_following();
            next = bound.next.previous();
            let unchanged = looked_at.speed == bound.speed && looked_at.corners == bound.corners;
            self.replace(&looked_at);
            if !unchanged {
                continue;
            }
            if next > pass.stale {
                if pass.stale == MoveNumber::BEFORE_ALL {
                    return;
                }
                next = pass.stale;
                following = self.following(next);
            }
        }
        pass.next = next;
        pass.stale = pass.stale.min(next);
        self.backward_pass = Some(pass);
    }

    /// The speed of a bound, limited to the programmed ones under the present override.
    pub(crate) fn speed(&self, bound: &Bound) -> f64 {
        bound.speed.min(bound.demand.programmed() * self.rate)
    }

    /// The speed that a bound must not exceed, whatever the programmed speeds.
    pub(crate) fn must(&self, bound: &Bound) -> f64 {
        self.bounded(bound, bound.demand.corner(), &self.following(bound.next))
    }

    /// The speed at a bound from which every corner up to the next rest can be met.
    pub(crate) fn corners(&self, bound: &Bound) -> f64 {
        bound.corners
    }

    /// Computes the bounds anew: those of the nearest moves at once, as if the others stayed the same.
    pub(super) fn recompute_bounds(&mut self, count: usize) {
        let nearest = self.first.plus(count);
        let all = |next: MoveNumber| BackwardPass {
            next,
            stale: next,
            work: WORK,
        };
        self.backward_pass = Some(all(nearest));
        self.compute_bounds(count);
        let last = self.behind();
        // `nearest` is a number of moves, of which each has one bound at most.
        self.backward_pass = (last > nearest).then(|| all(last));
    }

    /// The last bound at or before a number.
    fn before(&self, next: MoveNumber) -> Option<Bound> {
        let last = |bounds: &VecDeque<Bound>| {
            let count = bounds.partition_point(|bound| bound.next <= next);
            count.checked_sub(1).map(|bound_index| bounds[bound_index])
        };
        match (last(&self.slower), last(&self.ends)) {
            (Some(slower), Some(end)) => Some(if slower.next > end.next { slower } else { end }),
            (slower, end) => slower.or(end),
        }
    }

    /// The first bound behind a number; if there is none, the end of the queue, at rest.
    pub(super) fn following(&self, next: MoveNumber) -> NextBound {
        let first = |bounds: &VecDeque<Bound>| bounds.get(bounds.partition_point(|bound| bound.next <= next)).copied();
        let bound = match (first(&self.slower), first(&self.ends)) {
            (Some(slower), Some(end)) => Some(if slower.next < end.next { slower } else { end }),
            (slower, end) => slower.or(end),
        };
        let end = || NextBound {
            at: self.end().unwrap_or(0.0),
            speed: 0.0,
            corners: f64::INFINITY,
        };
        bound.map_or_else(end, |bound| bound.as_following())
    }

    pub(super) fn speed_at(&self, bound: &Bound, following: &NextBound) -> f64 {
        let most = (bound.demand.programmed() * self.rate).min(bound.demand.corner());
        self.bounded(bound, most, following)
    }

    /// The speed, at most `most`, from which the move behind a bound can slow down: to all bounds behind it or, for type 5, to the corners behind
    /// it.
    fn bounded(&self, bound: &Bound, most: f64, following: &NextBound) -> f64 {
        if most == 0.0 {
            return most;
        }
        if bound.demand.is_constrained() {
            most.min(self.entry(bound, following.at, following.speed))
        } else {
            most.min(self.entry(bound, following.at, following.corners))
        }
    }

    /// The speed at a bound from which its own corner and those behind it can be met. A rest can always be met: a motion that is too fast for it
    /// overshoots and returns.
    pub(super) fn corners_from(&self, bound: &Bound, following: &NextBound) -> f64 {
        match bound.demand {
            JunctionDemand::Rest => f64::INFINITY,
            demand => demand.corner().min(self.entry(bound, following.at, following.corners)),
        }
    }

    /// The speed at a bound from which the move behind it can slow down to `speed` at `at` on its run.
    fn entry(&self, bound: &Bound, at: f64, speed: f64) -> f64 {
        if speed == f64::INFINITY {
            return speed;
        }
        let Some(behind) = self.moves.get(bound.next.since(self.first)) else {
            return 0.0;
        };
        entry_speed(at - behind.start, speed, &behind.motion.limits)
    }

    /// Replaces the bound before the same move.
    fn replace(&mut self, bound: &Bound) {
        let bounds = match bound.demand {
            JunctionDemand::Slower { .. } => &mut self.slower,
            _ => &mut self.ends,
        };
        let bound_index = bounds.partition_point(|other| other.next < bound.next);
        if let Some(old) = bounds.get_mut(bound_index) {
            *old = *bound;
        }
    }
}

impl Bound {
    fn as_following(&self) -> NextBound {
        NextBound {
            at: self.at,
            speed: self.speed,
            corners: self.corners,
        }
    }
}
