//! The parts of an output cam that go on when it is over: edges that lag behind its axis, and durations.
//!
//! An offset or a delay below 0 can put edges behind where the axis is. When it leaves the cam these are still to come: the elements
//! stay until each of them has come past the end of the cam, or until the axis comes back to where it left. Durations run out in
//! any case. Not here: what happens to elements ([`super::events`]). Real-time: nothing allocates.

use arcline_planner::Instant;

use super::super::element::Happens;
use super::super::program::OUTPUT_BITS;
use super::super::windows::Turns;
use super::Target;
use super::cam_state::{ACTIVE, PENDING, Phase, TAIL};
use crate::execution::Execution;

/// How a cam was left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trailing {
    /// Where its positions begin.
    pub(super) zero: f64,
    /// Of those that it was repeated in.
    pub(super) turns: Turns,
    forward: bool,
    /// Where the axis left it.
    position: f64,
}

impl Target {
    /// The armed cam is over at a position; the pending one takes over. Returns whose is over.
    pub(super) fn leave(&mut self, position: f64, at: Instant) -> Option<Execution> {
        let zero = self.zero();
        let middle = |start: f64, end: f64| 0.5 * (start + end);
        let forward = self.cams[ACTIVE]
            .cam()
            .is_none_or(|cam| position - zero > middle(cam.start, cam.end));
        let left = Trailing {
            zero,
            turns: self.turns_of_active(),
            forward,
            position,
        };
        self.make_room(at);
        let over = self.cams[ACTIVE].program.as_ref().map(|program| program.execution);
        self.cams.swap(ACTIVE, TAIL);
        self.trailing = Some(left);
        if self.cams[PENDING].program.is_none() {
            self.phase = Phase::Ending;
            return over;
        }
        self.cams.swap(ACTIVE, PENDING);
        let entry = self.cams[ACTIVE]
            .cam()
            .map_or(0.0, |cam| if forward { cam.start } else { cam.end });
        (self.base, self.turns) = (position - entry, 0.0);
        self.came_forward = Some(forward);
        self.arm_enabled(at);
        over
    }

    /// Elements whose edges have all come are over where the axis is now.
    pub(super) fn let_pass(&mut self, at: Instant) {
        let Some(left) = self.trailing else { return };
        let axis = self.last;
        let is_back = (axis.position < left.position) == left.forward && axis.position != left.position;
        let mut goes_on = false;
        for element_index in 0..self.cams[TAIL].states.len() {
            let Some(cam) = self.cams[TAIL].cam() else { break };
            let compensation = &cam.compensation[usize::from(cam.elements[element_index].bit)];
            let bound = left.zero + compensation.offset + if left.forward { cam.end } else { cam.start };
            let is_beyond = [true, false].into_iter().all(|latch| {
                let compared = axis.position + compensation.delay(latch) * axis.velocity;
                (compared >= bound) == left.forward
            });
            if is_back || is_beyond {
                self.pass(element_index, at);
            }
            goes_on |= !self.state(TAIL, element_index).is_over();
        }
        if !goes_on {
            self.trailing = None;
        }
    }

    /// Whether edges of a cam that is over are still to come.
    pub(super) fn lags(&self) -> bool {
        self.trailing.is_some() && self.cams[TAIL].states.iter().any(|state| !state.passed)
    }

    /// The bits of what goes on.
    pub(super) fn tail(&self) -> u32 {
        let cam_index = &self.cams[TAIL];
        let elements = cam_index
            .states
            .iter()
            .enumerate()
            .filter(|(_, state)| !state.is_over());
        let bits = elements.filter_map(|(element_index, _)| Some(1 << cam_index.element(element_index)?.0.bit));
        bits.fold(self.trailing_bits(), |all, bit: u32| all | bit)
    }

    /// Bits that something other than the armed cam holds.
    pub(super) fn held(&self) -> u32 {
        let mut bits = self.trailing_bits();
        for cam_index in [&self.cams[PENDING], &self.cams[TAIL]] {
            for (element_index, _) in cam_index.states.iter().enumerate().filter(|(_, state)| state.holds) {
                bits |= cam_index
                    .element(element_index)
                    .map_or(0, |(element, _)| 1 << element.bit);
            }
        }
        bits
    }

    /// Durations that are under way go on without the elements of a cam, and bits show as they did.
    pub(super) fn carry(&mut self, cam_index: usize) {
        for element_index in 0..self.cams[cam_index].states.len() {
            let Some((element, compensation)) = self.cams[cam_index].element(element_index) else {
                continue;
            };
            let bit = usize::from(element.bit);
            self.trailing_bits_as[bit] = *compensation;
            let state = &mut self.cams[cam_index].states[element_index];
            let Some(off_at) = state.off_at.take() else { continue };
            state.holds = false;
            let is_later = |other: &Instant| other.elapsed(&self.ticks) < off_at.elapsed(&self.ticks);
            self.trailing_bits[bit] = self.trailing_bits[bit].filter(is_later).or(Some(off_at));
        }
    }

    /// Nothing goes on.
    pub(super) fn forget(&mut self) {
        self.trailing_bits = [None; OUTPUT_BITS];
        self.cams[TAIL].take();
        self.trailing = None;
    }

    /// The cam before the one that is over makes room for that one.
    fn make_room(&mut self, at: Instant) {
        for element_index in 0..self.cams[TAIL].states.len() {
            self.pass(element_index, at);
        }
        self.carry(TAIL);
        self.cams[TAIL].take();
    }

    /// An element is over, but for a duration. Bits that it does not hold by its position stay as they are.
    fn pass(&mut self, element_index: usize, at: Instant) {
        let state = self.state(TAIL, element_index);
        if state.passed {
            return;
        }
        if state.is_in(true) {
            self.happens(TAIL, element_index, Happens::LatchLeft, at);
        }
        if state.is_in(false) || state.holds {
            self.happens(TAIL, element_index, Happens::UnlatchLeft, at);
        }
        let state = &mut self.cams[TAIL].states[element_index];
        state.passed = true;
        state.holds = state.off_at.is_some();
    }

    fn trailing_bits(&self) -> u32 {
        let bits = self.trailing_bits.iter().enumerate();
        bits.fold(0, |all, (bit, trailing_bits)| {
            all | u32::from(trailing_bits.is_some()) << bit
        })
    }
}
