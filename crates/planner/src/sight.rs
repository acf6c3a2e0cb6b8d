//! Changes of the dynamics of all pending moves, over many ticks where there are many moves (MCCD of Active and Pending Motion).
//!
//! Each change has a number, and each move knows the last one that is in its limits. A change makes the queue forget its moves and
//! all bounds between them; then they are *seen* again in their order, each of which is given at that moment what it is owed: all
//! changes since, as its owner puts them together. The queue ends at rest behind the last that is seen, so what the look-ahead
//! tells is safe at every instant, and grows. The nearest moves are seen at once, as far as the motion needs to stop; those behind
//! in windows that double what is seen, so that all backward passes together cost about twice one of them.
//!
//! Real-time: each call works on a fixed number of moves and places, however deep the queue is.

use arcline_profile::{Limits, stop_distance};

use crate::Clock;
use crate::planner::{Move, Planner};
use crate::queue::{Carry, Queue};

/// What is seen of the pending moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    /// Number of the first move that is not seen.
    pub(crate) to: u64,
    /// The window that is being added begins with this move,
    from: u64,
    /// and ends before this one.
    aim: u64,
    /// Number of the last change.
    pub(crate) changes: u64,
}

impl Default for Sight {
    fn default() -> Self {
        Sight {
            to: 1,
            from: 1,
            aim: 1,
            changes: 0,
        }
    }
}

/// Moves and places that are worked on in one tick.
const WORK: usize = 64;
/// Moves that are seen at once at least, and at most; as many places besides.
const LEAST: usize = 32;
const MOST: usize = 128;

impl<T: Copy> Planner<T> {
    /// All pending moves are owed another change of their dynamics; its number, 1 for the first one ever.
    /// [`Planner::give_nearest`] and then [`Planner::change_limits`] make it take effect.
    pub fn owe(&mut self) -> u64 {
        self.queue.owe()
    }

    /// Whether pending moves are still owed changes: [`Planner::give_on`] is to be called at every tick.
    pub fn owes(&self) -> bool {
        self.queue.owes()
    }

    /// The nearest pending moves are given what they are owed, as far as it takes to stop with the `limits` that the active one is to
    /// have. `give` is told the number of the last change that a move has, and gives it all since.
    pub fn give_nearest(&mut self, limits: &Limits, clock: &Clock, give: impl FnMut(&mut Move<T>, u64)) {
        let reach = self.active.map_or(0.0, |running| {
            let now = running.track.state(clock);
            let top = now.velocity.max(limits.speed * self.queue.rate());
            stop_distance(top, limits) - (running.motion.path.length() - now.position)
        });
        let count = self.queue.within(reach, MOST).max(LEAST);
        self.queue.see_first(count, give);
    }

    /// Before [`Planner::hand_over`]: the move that is to become active, and the one behind it, are given what they are owed.
    pub fn give_next(&mut self, give: impl FnMut(&mut Move<T>, u64)) {
        self.queue.see_at_least(2, give);
    }

    /// More of the pending moves are given what they are owed: in place of [`Planner::look_on`], at every tick until
    /// no move is owed anything.
    pub fn give_on(&mut self, clock: &Clock, give: impl FnMut(&mut Move<T>, u64)) {
        self.queue.see(WORK, give);
        self.raise_exit(clock);
        self.schedule(clock.now(), clock);
    }
}

impl<T: Copy> Queue<T> {
    /// The number behind that of the last move.
    pub(crate) fn behind(&self) -> u64 {
        self.first + self.moves.len() as u64
    }

    /// Number of the first move that is not seen.
    pub(crate) fn seen_to(&self) -> u64 {
        self.sight.to
    }

    fn owe(&mut self) -> u64 {
        self.forget_bounds();
        self.sight = Sight {
            to: self.first,
            from: self.first,
            aim: self.first,
            changes: self.sight.changes + 1,
        };
        self.sight.changes
    }

    fn owes(&self) -> bool {
        self.sight.to < self.behind()
    }

    /// The number of moves that reach over a distance, at most so many.
    fn within(&self, mut distance: f64, most: usize) -> usize {
        let mut count = 0;
        for motion in self.iter().take(most) {
            if distance <= 0.0 {
                break;
            }
            distance -= motion.path.length();
            count += 1;
        }
        count
    }

    /// After [`Queue::owe`]: sees so many moves, and looks at as many places.
    fn see_first(&mut self, count: usize, give: impl FnMut(&mut Move<T>, u64)) {
        self.sight.aim = self.sight.to + count as u64;
        self.see(2 * count, give);
    }

    /// Sees the first so many moves; the places between them are looked at with the window that they are in.
    fn see_at_least(&mut self, count: u64, mut give: impl FnMut(&mut Move<T>, u64)) {
        let to = self.behind().min(self.first + count);
        let missing = to.saturating_sub(self.sight.to);
        self.show(missing as usize, &mut give);
    }

    /// Sees more moves and looks at bounds, so many of both at most.
    fn see(&mut self, work: usize, mut give: impl FnMut(&mut Move<T>, u64)) {
        let mut left = work;
        while left > 0 {
            if self.carry.is_some() {
                left -= self.look_at(left);
                continue;
            }
            if !self.owes() {
                break;
            }
            if self.sight.to >= self.sight.aim {
                let seen = self.sight.to - self.first;
                self.sight.aim = self.sight.to + seen.max(LEAST as u64);
            }
            let window = self.sight.aim.min(self.behind());
            let count = left.min((window - self.sight.to) as usize);
            self.show(count, &mut give);
            left -= count;
            if self.sight.to == window {
                self.carry = Some(Carry {
                    next: window,
                    stale: window,
                    least: self.sight.from,
                });
                self.sight.from = window;
                self.sight.aim = window;
            }
        }
    }

    /// The next so many moves are given what they are owed, and what lies before each of them is found.
    fn show(&mut self, count: usize, give: &mut impl FnMut(&mut Move<T>, u64)) {
        let changes = self.sight.changes;
        for number in self.sight.to..self.sight.to + count as u64 {
            let place = (number - self.first) as usize;
            let Some(waiting) = self.moves.get_mut(place) else {
                return;
            };
            if waiting.has < changes {
                give(&mut waiting.motion, waiting.has);
                waiting.has = changes;
            }
            self.sight.to = number + 1;
            // What lies before the first one is found when the active one is planned.
            let Some(before) = place.checked_sub(1).map(|place| &self.moves[place]) else {
                continue;
            };
            let here = &self.moves[place];
            let link = here.joint.link(&before.motion.limits, &here.motion.limits);
            let end = before.start + before.motion.path.length();
            self.moves[place].start = self.bind(number, end, link);
        }
    }
}
