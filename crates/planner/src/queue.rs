//! The pending moves, and the speeds at the junctions between them: the look-ahead (spec/motion-core.md §7).
//!
//! Moves that continue smoothly into one another with the same rates are a *run*: one profile may cross all of them, without a rest and with
//! any acceleration in between. Runs end at points that need an acceleration of 0: at corners, rests, and changes of rates. A slower move
//! within a run limits the speed at its start.
//!
//! Every such point, a [`Bound`], holds the highest speed from which all bounds behind it can be met. A new move changes the bounds before it,
//! backwards, until one of them stays the same. A bound of type 5 does not require that the moves behind it can stop, but its speed never
//! exceeds one from which a corner behind it can be met. Work beyond the budget of a tick continues later: bounds are then too low, never too
//! high for the mandatory limits.
//!
//! A change of the dynamics of all pending moves resets all bounds to 0. Those of the nearest moves are computed at once, the others backwards
//! within a few ticks. Position units, seconds.

mod bounds;

use std::collections::VecDeque;

use arcline_geometry::Point;

pub(crate) use bounds::Bound;
use bounds::{BackwardPass, LEAST, MOST, WORK, WORK_OF_A_CHANGE};

use crate::corners::Corners;
use crate::junction::{JunctionDemand, JunctionGeometry};
use crate::running::Move;

/// Pending moves, oldest first, each with a number.
#[derive(Debug)]
pub(crate) struct Queue<T> {
    moves: VecDeque<Waiting<T>>,
    /// The number of the oldest move.
    first: MoveNumber,
    /// The bounds at slower moves within runs.
    slower: VecDeque<Bound>,
    /// The bounds at the ends of runs.
    ends: VecDeque<Bound>,
    backward_pass: Option<BackwardPass>,
    corner_step: Point,
    /// The corners before the newest move.
    corners: Corners,
    /// Share of the programmed speeds.
    rate: f64,
}

/// The number of a move, in the order in which moves were queued.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct MoveNumber(u64);

impl MoveNumber {
    /// The number before the first one.
    const BEFORE_ALL: MoveNumber = MoveNumber(0);

    /// The number of the move that is this many moves later.
    fn plus(self, moves: usize) -> MoveNumber {
        MoveNumber(self.0 + moves as u64)
    }

    /// The number before it.
    fn previous(self) -> MoveNumber {
        MoveNumber(self.0 - 1)
    }

    /// The number of moves from an earlier one to this one.
    fn since(self, earlier: MoveNumber) -> usize {
        (self.0 - earlier.0) as usize
    }
}

/// A pending move.
#[derive(Clone, Copy, Debug)]
struct Waiting<T> {
    motion: Move<T>,
    /// The position on its run at which it begins.
    start: f64,
    /// The previous move blends into it.
    blended: bool,
    /// The junction before it.
    junction: JunctionGeometry,
}

impl<T: Copy> Queue<T> {
    /// The only allocation.
    pub(crate) fn new(depth: usize, corner_step: Point) -> Self {
        Queue {
            moves: VecDeque::with_capacity(depth),
            first: MoveNumber::BEFORE_ALL.plus(1),
            slower: VecDeque::with_capacity(depth),
            ends: VecDeque::with_capacity(depth),
            backward_pass: None,
            corner_step,
            corners: Corners::new(0.0),
            rate: 1.0,
        }
    }

    /// Sets the update period, seconds: corners within one update count together.
    pub(crate) fn set_period(&mut self, period: f64) {
        self.corners = Corners::new(period);
    }

    /// Marks the beginning of a new path.
    pub(crate) fn forget_corners(&mut self) {
        self.corners.clear();
    }

    /// The number of the next move to be queued.
    fn behind(&self) -> MoveNumber {
        self.first.plus(self.moves.len())
    }

    pub(crate) fn len(&self) -> usize {
        self.moves.len()
    }

    pub(crate) fn front(&self) -> Option<&Move<T>> {
        self.moves.front().map(|waiting| &waiting.motion)
    }

    pub(crate) fn back(&self) -> Option<&Move<T>> {
        self.moves.back().map(|waiting| &waiting.motion)
    }

    pub(crate) fn iter(&self) -> impl DoubleEndedIterator<Item = &Move<T>> {
        self.moves.iter().map(|waiting| &waiting.motion)
    }

    /// The path continues to the oldest move: without a rest before it, and without superposition.
    pub(crate) fn is_passed_to(&self) -> bool {
        self.moves.front().is_some_and(|waiting| waiting.junction.is_passed())
    }

    /// The highest speed at the corner before the oldest move, in its variable.
    pub(crate) fn corner(&self) -> f64 {
        self.moves.front().map_or(0.0, |waiting| waiting.junction.corner())
    }

    /// The pending moves, the oldest first: whether the path continues to each ([`Queue::is_passed_to`]), and the highest speed at the corner
    /// before it ([`Queue::corner`]).
    pub(crate) fn junctions(&self) -> impl Iterator<Item = (&Move<T>, bool, f64)> {
        self.moves
            .iter()
            .map(|waiting| (&waiting.motion, waiting.junction.is_passed(), waiting.junction.corner()))
    }

    /// A run ends before the oldest move.
    pub(crate) fn run_ends_here(&self) -> bool {
        self.ends.front().is_some_and(|end| end.next == self.first)
    }

    pub(crate) fn rate(&self) -> f64 {
        self.rate
    }

    /// Pending moves before a bound.
    pub(crate) fn moves_before(&self, bound: &Bound) -> usize {
        bound.next.since(self.first)
    }

    /// Adds a move at the end. `active` is the move before the first one, with its beginning on its run.
    pub(crate) fn push(&mut self, motion: Move<T>, active: Option<(&Move<T>, bool, f64)>) {
        let next = self.behind();
        let before = match self.moves.back() {
            Some(last) => Some((&last.motion, last.blended, last.start)),
            None => active,
        };
        let mut waiting = Waiting {
            motion,
            start: 0.0,
            blended: false,
            junction: JunctionGeometry::FIRST,
        };
        if let Some((before, blended, start)) = before {
            let mut junction = JunctionGeometry::new(before, &motion, blended, &self.corner_step);
            if junction.is_passed() {
                let together = self.corners.pass(&before.path, &motion.path, &self.corner_step);
                junction = junction.at_most(together / motion.parameter.speed);
            } else {
                self.corners.clear();
            }
            let end = start + before.path.length();
            let demand = junction.demand(&before.limits, &motion.limits);
            waiting.blended = junction.blends();
            waiting.junction = junction;
            waiting.start = self.bind(next, end, demand);
        }
        self.moves.push_back(waiting);
        let (stale, work) = self
            .backward_pass
            .map_or((MoveNumber::BEFORE_ALL, WORK), |pass| (pass.next, pass.work));
        self.backward_pass = Some(BackwardPass { next, stale, work });
        self.continue_pass();
    }

    /// A backward pass was too long for one tick, and continues in the next one.
    pub(crate) fn is_passing(&self) -> bool {
        self.backward_pass.is_some()
    }

    /// Removes the oldest move.
    pub(crate) fn pop(&mut self) -> Option<Move<T>> {
        let waiting = self.moves.pop_front()?;
        self.first = self.first.plus(1);
        for bounds in [&mut self.slower, &mut self.ends] {
            while bounds.front().is_some_and(|bound| bound.next < self.first) {
                bounds.pop_front();
            }
        }
        Some(waiting.motion)
    }

    /// Determines the junction between the active move and the first pending one anew. Returns the position on its run at which the active move
    /// begins.
    pub(crate) fn relink(&mut self, active: &Move<T>, blended: bool) -> f64 {
        let Some(front) = self.moves.front() else {
            return 0.0;
        };
        for bounds in [&mut self.slower, &mut self.ends] {
            while bounds.front().is_some_and(|bound| bound.next <= self.first) {
                bounds.pop_front();
            }
        }
        let junction =
            JunctionGeometry::new(active, &front.motion, blended, &self.corner_step).at_most(front.junction.corner());
        let demand = junction.demand(&active.limits, &front.motion.limits);
        let length = active.path.length();
        let (start, at) = if demand.ends_run() {
            (0.0, length)
        } else {
            (front.start - length, front.start)
        };
        let mut bound = Bound {
            next: self.first,
            at,
            demand,
            speed: 0.0,
            corners: 0.0,
        };
        let following = self.following(self.first);
        bound.corners = self.corners_from(&bound, &following);
        bound.speed = self.speed_at(&bound, &following);
        match demand {
            JunctionDemand::Free => {}
            JunctionDemand::Slower { .. } => self.slower.push_front(bound),
            _ => self.ends.push_front(bound),
        }
        start
    }

    /// Changes all moves, and determines the joints between them anew. The bounds of the nearest moves, over at least `distance`, are computed
    /// at once, the others backwards from the last within [`Queue::ticks_of_a_change`].
    pub(crate) fn change_all(&mut self, distance: f64, mut change: impl FnMut(&mut Move<T>)) {
        self.slower.clear();
        self.ends.clear();
        for waiting in &mut self.moves {
            change(&mut waiting.motion);
        }
        // The plan of the active move determines the junction before the first one.
        for move_index in 1..self.moves.len() {
            let [before, here] = [&self.moves[move_index - 1], &self.moves[move_index]];
            let demand = here.junction.demand(&before.motion.limits, &here.motion.limits);
            let end = before.start + before.motion.path.length();
            self.moves[move_index].start = self.bind(self.first.plus(move_index), end, demand);
        }
        let count = self.within(distance, MOST).max(LEAST);
        self.recompute_bounds(count);
        if let Some(pass) = &mut self.backward_pass {
            pass.work = WORK_OF_A_CHANGE;
        }
    }

    /// Ticks within which all bounds are computed after a change of all moves.
    pub(crate) fn ticks_of_a_change(&self) -> usize {
        1 + self.moves.len() / WORK_OF_A_CHANGE
    }

    /// The number of moves that cover a distance, at most `most`.
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

    /// Sets the override: a share of the programmed speeds.
    pub(crate) fn set_rate(&mut self, rate: f64) {
        self.rate = rate;
        self.recompute_bounds(WORK);
    }

    /// Bounds at slower moves of the first run, in their order.
    pub(crate) fn slower(&self) -> impl Iterator<Item = &Bound> {
        let end = self.ends.front().map(|end| end.next);
        self.slower
            .iter()
            .take_while(move |bound| end.is_none_or(|end| bound.next < end))
    }

    /// The end of the first run; `end` is the end of the active move on it.
    pub(crate) fn run_end(&self, end: f64) -> Bound {
        self.ends.front().copied().unwrap_or_else(|| Bound {
            next: self.behind(),
            at: self.end().unwrap_or(end),
            demand: JunctionDemand::Rest,
            speed: 0.0,
            corners: f64::INFINITY,
        })
    }

    /// Adds the bound before a move, if there is one; `end` is the end of the previous move on its run. Returns the position on its run at which
    /// the move begins.
    fn bind(&mut self, next: MoveNumber, end: f64, demand: JunctionDemand) -> f64 {
        let bound = Bound {
            next,
            at: end,
            demand,
            speed: 0.0,
            corners: 0.0,
        };
        match demand {
            JunctionDemand::Free => {}
            JunctionDemand::Slower { .. } => self.slower.push_back(bound),
            _ => self.ends.push_back(bound),
        }
        if demand.ends_run() { 0.0 } else { end }
    }

    /// The end of the last move on its run.
    fn end(&self) -> Option<f64> {
        let last = self.moves.back()?;
        Some(last.start + last.motion.path.length())
    }
}
