//! The moves that wait, and how fast the places between them may be passed: the look-ahead (spec/motion-core.md §7).
//!
//! Moves that go over into one another smoothly with the same rates are a *run*: one profile may lead over all of them,
//! at rest nowhere and with any acceleration in between. Runs end where the acceleration has to be 0: at corners,
//! rests, and changes of rates. Within a run a slower move is a place that is to be passed at its speed at most.
//!
//! Every such place, a [`Bound`], keeps the speed from which all that lies behind it can be kept. A new move changes
//! the bounds before it, backwards, until one of them stays as it was. A place of type 5 does not ask whether the moves behind
//! it can stop, but no speed is kept for it at which a corner behind it would be passed too fast. What takes longer than a tick should is carried
//! on later: bounds are then too low, never too high for what must be kept.
//!
//! Where the dynamics of all pending moves change, all bounds are found anew and are 0 at first. Those of the nearest moves are computed at
//! once, the others backwards within a few ticks. Position units, seconds.

use std::collections::VecDeque;

use arcline_geometry::Point;
use arcline_profile::entry_speed;

use crate::corners::Corners;
use crate::junction::{Joint, Link};
use crate::planner::Move;

/// Pending moves, oldest first, each known by its number.
#[derive(Debug)]
pub(crate) struct Queue<T> {
    moves: VecDeque<Waiting<T>>,
    /// Number of the oldest move.
    first: u64,
    /// Slower moves within runs.
    slower: VecDeque<Bound>,
    /// Ends of runs.
    ends: VecDeque<Bound>,
    carry: Option<Carry>,
    corner_step: Point,
    /// Those before the newest move.
    corners: Corners,
    /// Share of the programmed speeds.
    rate: f64,
}

/// A pending move.
#[derive(Clone, Copy, Debug)]
struct Waiting<T> {
    motion: Move<T>,
    /// Where on its run it begins.
    start: f64,
    /// Whether the move before it blends into it.
    blended: bool,
    /// The place before it.
    joint: Joint,
}

/// A place that must not be passed faster than at a speed, with acceleration 0 if it is passed at that speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// Number of the move behind it.
    pub(crate) next: u64,
    /// Where on the run before it.
    pub(crate) at: f64,
    pub(crate) link: Link,
    /// The speed, with the rate it was computed for.
    speed: f64,
    /// The speed from which the corners behind it can be met, whatever is programmed: infinite where there is none before
    /// the next rest.
    corners: f64,
}

/// The next bound behind a place, or the end of the queue.
#[derive(Clone, Copy, Debug)]
struct Following {
    at: f64,
    speed: f64,
    corners: f64,
}

/// A backward pass that is not over.
#[derive(Clone, Copy, Debug)]
struct Carry {
    /// Bounds up to this number are still to be looked at.
    next: u64,
    /// Bounds up to this number are to be looked at even where the one behind them has not changed.
    stale: u64,
    /// Bounds that are looked at in one tick.
    work: usize,
}

/// Bounds that are looked at in one tick,
const WORK: usize = 8;
/// and after a change of all moves: 50 µs.
const WORK_OF_A_CHANGE: usize = 256;
/// Moves whose bounds are computed at once after a change of all: at least, and at most.
const LEAST: usize = 32;
const MOST: usize = 128;

impl<T: Copy> Queue<T> {
    /// The only allocation.
    pub(crate) fn new(depth: usize, corner_step: Point) -> Self {
        Queue {
            moves: VecDeque::with_capacity(depth),
            first: 1,
            slower: VecDeque::with_capacity(depth),
            ends: VecDeque::with_capacity(depth),
            carry: None,
            corner_step,
            corners: Corners::new(0.0),
            rate: 1.0,
        }
    }

    /// Corners of one update of this period, seconds, count together.
    pub(crate) fn set_period(&mut self, period: f64) {
        self.corners = Corners::new(period);
    }

    /// The next move begins a path anew.
    pub(crate) fn forget_corners(&mut self) {
        self.corners.clear();
    }

    /// The number behind that of the last move.
    fn behind(&self) -> u64 {
        self.first + self.moves.len() as u64
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

    /// Whether the path goes on to the oldest move: no rest before it, and nothing superposed.
    pub(crate) fn is_passed_to(&self) -> bool {
        self.moves.front().is_some_and(|waiting| waiting.joint.is_passed())
    }

    /// The highest speed that the corner before the oldest move leaves, by what that is a function of.
    pub(crate) fn corner(&self) -> f64 {
        self.moves.front().map_or(0.0, |waiting| waiting.joint.corner())
    }

    /// Whether a run ends before the oldest move.
    pub(crate) fn run_ends_here(&self) -> bool {
        self.ends.front().is_some_and(|end| end.next == self.first)
    }

    pub(crate) fn rate(&self) -> f64 {
        self.rate
    }

    /// Pending moves before a bound.
    pub(crate) fn moves_before(&self, bound: &Bound) -> usize {
        (bound.next - self.first) as usize
    }

    /// Puts a move behind the last one. `active` is the move before the first, and where on its run that begins.
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
            joint: Joint::FIRST,
        };
        if let Some((before, blended, start)) = before {
            let mut joint = Joint::new(before, &motion, blended, &self.corner_step);
            if joint.is_passed() {
                let together = self.corners.pass(&before.path, &motion.path, &self.corner_step);
                joint = joint.at_most(together / motion.parameter.speed);
            } else {
                self.corners.clear();
            }
            let end = start + before.path.length();
            let link = joint.link(&before.limits, &motion.limits);
            waiting.blended = joint.blends();
            waiting.joint = joint;
            waiting.start = self.bind(next, end, link);
        }
        self.moves.push_back(waiting);
        let (stale, work) = self.carry.map_or((0, WORK), |carry| (carry.next, carry.work));
        self.carry = Some(Carry { next, stale, work });
        self.carry_on();
    }

    /// Takes the oldest move out.
    pub(crate) fn pop(&mut self) -> Option<Move<T>> {
        let waiting = self.moves.pop_front()?;
        self.first += 1;
        for bounds in [&mut self.slower, &mut self.ends] {
            while bounds.front().is_some_and(|bound| bound.next < self.first) {
                bounds.pop_front();
            }
        }
        Some(waiting.motion)
    }

    /// What lies between the active move and the first pending one is found anew. Returns where on its run the active
    /// move begins.
    pub(crate) fn relink(&mut self, active: &Move<T>, blended: bool) -> f64 {
        let Some(front) = self.moves.front() else {
            return 0.0;
        };
        for bounds in [&mut self.slower, &mut self.ends] {
            while bounds.front().is_some_and(|bound| bound.next <= self.first) {
                bounds.pop_front();
            }
        }
        let joint = Joint::new(active, &front.motion, blended, &self.corner_step).at_most(front.joint.corner());
        let link = joint.link(&active.limits, &front.motion.limits);
        let length = active.path.length();
        let (start, at) = if link.ends_run() {
            (0.0, length)
        } else {
            (front.start - length, front.start)
        };
        let mut bound = Bound {
            next: self.first,
            at,
            link,
            speed: 0.0,
            corners: 0.0,
        };
        let following = self.following(self.first);
        bound.corners = self.corners_from(&bound, &following);
        bound.speed = self.speed_at(&bound, &following);
        match link {
            Link::Free => {}
            Link::Slower { .. } => self.slower.push_front(bound),
            _ => self.ends.push_front(bound),
        }
        start
    }

    /// Changes all moves: what lies between them is found anew. The bounds of the nearest moves, over a distance at least, are computed
    /// at once, the others backwards from the last within [`Queue::ticks_of_a_change`].
    pub(crate) fn change_all(&mut self, distance: f64, mut change: impl FnMut(&mut Move<T>)) {
        self.slower.clear();
        self.ends.clear();
        for waiting in &mut self.moves {
            change(&mut waiting.motion);
        }
        // What lies before the first one is found when the active one is planned.
        for place in 1..self.moves.len() {
            let [before, here] = [&self.moves[place - 1], &self.moves[place]];
            let link = here.joint.link(&before.motion.limits, &here.motion.limits);
            let end = before.start + before.motion.path.length();
            self.moves[place].start = self.bind(self.first + place as u64, end, link);
        }
        let count = self.within(distance, MOST).max(LEAST);
        self.look_again(count);
        if let Some(carry) = &mut self.carry {
            carry.work = WORK_OF_A_CHANGE;
        }
    }

    /// Ticks within which all bounds are computed after a change of all moves.
    pub(crate) fn ticks_of_a_change(&self) -> usize {
        1 + self.moves.len() / WORK_OF_A_CHANGE
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

    /// Takes a share of the programmed speeds.
    pub(crate) fn set_rate(&mut self, rate: f64) {
        self.rate = rate;
        self.look_again(WORK);
    }

    /// Goes on with a backward pass that was too long for one tick; whether there was anything to do.
    pub(crate) fn carry_on(&mut self) -> bool {
        let work = self.carry.map(|carry| carry.work);
        self.look_at(work.unwrap_or(0));
        work.is_some()
    }

    /// Goes on with the backward pass, over so many bounds at most.
    fn look_at(&mut self, most: usize) {
        let Some(mut carry) = self.carry.take() else {
            return;
        };
        let mut next = carry.next;
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
            next = bound.next - 1;
            let unchanged = looked_at.speed == bound.speed && looked_at.corners == bound.corners;
            self.replace(&looked_at);
            if !unchanged {
                continue;
            }
            if next > carry.stale {
                if carry.stale == 0 {
                    return;
                }
                next = carry.stale;
                following = self.following(next);
            }
        }
        carry.next = next;
        carry.stale = carry.stale.min(next);
        self.carry = Some(carry);
    }

    /// Slower moves of the first run, in their order.
    pub(crate) fn slower(&self) -> impl Iterator<Item = &Bound> {
        let end = self.ends.front().map_or(u64::MAX, |end| end.next);
        self.slower.iter().take_while(move |bound| bound.next < end)
    }

    /// The end of the first run; `end` is that of the active move on it.
    pub(crate) fn run_end(&self, end: f64) -> Bound {
        self.ends.front().copied().unwrap_or_else(|| Bound {
            next: self.behind(),
            at: self.end().unwrap_or(end),
            link: Link::Rest,
            speed: 0.0,
            corners: f64::INFINITY,
        })
    }

    /// The speed of a bound, at most what the present rate leaves of the programmed ones.
    pub(crate) fn speed(&self, bound: &Bound) -> f64 {
        bound.speed.min(bound.link.programmed() * self.rate)
    }

    /// The speed that must be kept at a bound whatever is programmed.
    pub(crate) fn must(&self, bound: &Bound) -> f64 {
        self.bounded(bound, bound.link.corner(), &self.following(bound.next))
    }

    /// The speed at a bound from which every corner up to the next rest can be met.
    pub(crate) fn corners(&self, bound: &Bound) -> f64 {
        bound.corners
    }

    /// Bounds have to be computed anew: those of the nearest moves at once, as if the others stayed as they are.
    fn look_again(&mut self, count: usize) {
        let nearest = self.first + count as u64;
        let all = |next: u64| Carry {
            next,
            stale: next,
            work: WORK,
        };
        self.carry = Some(all(nearest));
        self.look_at(count);
        let last = self.behind();
        // `nearest` is a number of moves, of which each has one bound at most.
        self.carry = (last > nearest).then(|| all(last));
    }

    /// Adds the bound before a move, if there is one; `end` is that of the move before it on its run. Returns where on its run
    /// the move begins.
    fn bind(&mut self, next: u64, end: f64, link: Link) -> f64 {
        let bound = Bound {
            next,
            at: end,
            link,
            speed: 0.0,
            corners: 0.0,
        };
        match link {
            Link::Free => {}
            Link::Slower { .. } => self.slower.push_back(bound),
            _ => self.ends.push_back(bound),
        }
        if link.ends_run() { 0.0 } else { end }
    }

    /// Where the last move ends on its run.
    fn end(&self) -> Option<f64> {
        let last = self.moves.back()?;
        Some(last.start + last.motion.path.length())
    }

    /// The last bound up to a number.
    fn before(&self, next: u64) -> Option<Bound> {
        let last = |bounds: &VecDeque<Bound>| {
            let count = bounds.partition_point(|bound| bound.next <= next);
            count.checked_sub(1).map(|place| bounds[place])
        };
        match (last(&self.slower), last(&self.ends)) {
            (Some(slower), Some(end)) => Some(if slower.next > end.next { slower } else { end }),
            (slower, end) => slower.or(end),
        }
    }

    /// The first bound behind a number: the end of the queue, at rest, if there is none.
    fn following(&self, next: u64) -> Following {
        let first = |bounds: &VecDeque<Bound>| bounds.get(bounds.partition_point(|bound| bound.next <= next)).copied();
        let bound = match (first(&self.slower), first(&self.ends)) {
            (Some(slower), Some(end)) => Some(if slower.next < end.next { slower } else { end }),
            (slower, end) => slower.or(end),
        };
        let end = || Following {
            at: self.end().unwrap_or(0.0),
            speed: 0.0,
            corners: f64::INFINITY,
        };
        bound.map_or_else(end, |bound| bound.as_following())
    }

    fn speed_at(&self, bound: &Bound, following: &Following) -> f64 {
        let most = (bound.link.programmed() * self.rate).min(bound.link.corner());
        self.bounded(bound, most, following)
    }

    /// At most `most`, and the speed from which the move behind a bound can slow down: to all that is behind it, or for type 5
    /// to the corners behind it.
    fn bounded(&self, bound: &Bound, most: f64, following: &Following) -> f64 {
        if most == 0.0 {
            return most;
        }
        if bound.link.is_constrained() {
            most.min(self.entry(bound, following.at, following.speed))
        } else {
            most.min(self.entry(bound, following.at, following.corners))
        }
    }

    /// The speed at a bound from which its own corner and those behind it can be met. A rest can always be met: what is too fast
    /// for it goes beyond it and comes back.
    fn corners_from(&self, bound: &Bound, following: &Following) -> f64 {
        match bound.link {
            Link::Rest => f64::INFINITY,
            link => link.corner().min(self.entry(bound, following.at, following.corners)),
        }
    }

    /// The speed at a bound from which the move behind it can slow down to a speed at a place on its run.
    fn entry(&self, bound: &Bound, at: f64, speed: f64) -> f64 {
        if speed == f64::INFINITY {
            return speed;
        }
        let Some(behind) = self.moves.get((bound.next - self.first) as usize) else {
            return 0.0;
        };
        entry_speed(at - behind.start, speed, &behind.motion.limits)
    }

    /// Puts a bound in place of the one before the same move.
    fn replace(&mut self, bound: &Bound) {
        let bounds = match bound.link {
            Link::Slower { .. } => &mut self.slower,
            _ => &mut self.ends,
        };
        let place = bounds.partition_point(|other| other.next < bound.next);
        if let Some(old) = bounds.get_mut(place) {
            *old = *bound;
        }
    }
}

impl Bound {
    fn as_following(&self) -> Following {
        Following {
            at: self.at,
            speed: self.speed,
            corners: self.corners,
        }
    }
}
