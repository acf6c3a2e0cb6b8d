//! The parts of an output cam that continue after its end: events that lag behind its axis, and durations.
//!
//! A negative offset or delay can move events behind the position of the axis. They are still pending when the axis leaves the cam: the
//! elements stay until the lagging position of each has passed the end of the cam, or until the axis returns to the point of its exit.
//! Durations run out in any case. Not here: the events of elements ([`super::events`]). Real-time: nothing allocates.

use arcline_planner::Instant;

use super::super::element::ElementEvent;
use super::super::program::OUTPUT_BITS;
use super::super::windows::Turns;
use super::ExecutionTarget;
use super::cam_state::{ACTIVE, PENDING, Phase, TAIL};
use crate::execution::Execution;

/// The exit from a cam.
#[derive(Clone, Copy, Debug)]
pub(super) struct CamExit {
    /// The axis position of its zero.
    pub(super) zero: f64,
    /// The turns in which it was repeated.
    pub(super) turns: Turns,
    forward: bool,
    /// The position at which the axis left it.
    position: f64,
}

impl ExecutionTarget {
    /// Ends the active cam at a position; the pending one takes over. Returns the instruction of the ended cam.
    pub(super) fn end_active(&mut self, position: f64, at: Instant) -> Option<Execution> {
        let zero = self.zero();
        let middle = |start: f64, end: f64| 0.5 * (start + end);
        let forward = self.cams[ACTIVE]
            .cam()
            .is_none_or(|cam| position - zero > middle(cam.start, cam.end));
        let left = CamExit {
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

    /// Ends the elements whose events have all passed at the position of the axis.
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

    /// Events of an ended cam are still pending.
    pub(super) fn lags(&self) -> bool {
        self.trailing.is_some() && self.cams[TAIL].states.iter().any(|state| !state.passed)
    }

    /// The bits of elements that continue.
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

    /// Bits held by elements or durations outside of the active cam.
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

    /// Continues the running durations of a cam without its elements; their bits look the same.
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

    /// Drops all elements and durations that continue.
    pub(super) fn forget(&mut self) {
        self.trailing_bits = [None; OUTPUT_BITS];
        self.cams[TAIL].take();
        self.trailing = None;
    }

    /// Frees the slot of the previous cam for the one that has just ended.
    fn make_room(&mut self, at: Instant) {
        for element_index in 0..self.cams[TAIL].states.len() {
            self.pass(element_index, at);
        }
        self.carry(TAIL);
        self.cams[TAIL].take();
    }

    /// Ends an element, except for a running duration. Bits that its position does not hold keep their values.
    fn pass(&mut self, element_index: usize, at: Instant) {
        let state = self.state(TAIL, element_index);
        if state.passed {
            return;
        }
        if state.is_in(true) {
            self.happens(TAIL, element_index, ElementEvent::LatchLeft, at);
        }
        if state.is_in(false) || state.holds {
            self.happens(TAIL, element_index, ElementEvent::UnlatchLeft, at);
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
