//! The events of the elements of output cams within an update, in their order, and their effects.
//!
//! Not here: the arming and the end of a cam ([`super::pieces`]). Real-time: nothing allocates.

use arcline_planner::{Clock, Instant};

use super::super::element::{Effect, ElementEvent, ElementState};
use super::super::interpolation::Interpolation;
use super::super::program::{Compensation, Element, MAX_OUTPUT_ELEMENTS, OUTPUT_BITS};
use super::super::windows::{Turns, Window};
use super::ExecutionTarget;
use super::cam_state::{ACTIVE, CamState, PENDING, Phase, TAIL};
use super::piece::{Piece, instant};

/// An event within an update.
#[derive(Clone, Copy, Debug)]
pub(in crate::output) struct Edge {
    share: f64,
    /// Its distance from the position at the beginning of the update.
    along: f64,
    what: ElementEvent,
    cam_index: usize,
    element: usize,
}

/// Events of one update: each element of three cams enters and leaves two ranges.
pub(in crate::output) const MOST_EDGES: usize = 3 * 4 * MAX_OUTPUT_ELEMENTS;

impl ExecutionTarget {
    /// Handles the events between two shares of an update.
    pub(super) fn run(&mut self, piece: &Piece, from: f64, until: f64, clock: &Clock, edges: &mut Vec<Edge>) {
        edges.clear();
        for &cam_index in self.live() {
            for element_index in 0..self.cams[cam_index].states.len() {
                if self.state(cam_index, element_index).passed {
                    continue;
                }
                for latch in [true, false] {
                    let (interpolation, window) = self.signal(piece, cam_index, element_index, latch);
                    let crossed = window.crossed(interpolation.from, interpolation.to);
                    let [entered, left] = if latch {
                        [ElementEvent::LatchEntered, ElementEvent::LatchLeft]
                    } else {
                        [ElementEvent::UnlatchEntered, ElementEvent::UnlatchLeft]
                    };
                    for (value, what) in crossed.into_iter().zip([entered, left]) {
                        let Some(value) = value else { continue };
                        let share = interpolation.share_of(value);
                        if share >= from && share <= until && edges.len() < MOST_EDGES {
                            edges.push(Edge {
                                share,
                                along: (value - interpolation.from).abs(),
                                what,
                                cam_index,
                                element: element_index,
                            });
                        }
                    }
                }
            }
        }
        let key = |edge: &Edge| (edge.share, edge.along, edge.what);
        edges.sort_unstable_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
        for edge in edges.iter() {
            let at = instant(piece, edge.share, clock);
            self.expire(at, clock);
            let again = edge.what == ElementEvent::LatchEntered && self.state(edge.cam_index, edge.element).is_in(true);
            if again {
                // The axis moves by more than one turn in an update.
                self.happens(edge.cam_index, edge.element, ElementEvent::UnlatchLeft, at);
                self.happens(edge.cam_index, edge.element, ElementEvent::UnlatchEntered, at);
            }
            self.happens(edge.cam_index, edge.element, edge.what, at);
        }
        // Corrects the states for rounding at the ends of the ranges.
        for &cam_index in self.live() {
            for element_index in 0..self.cams[cam_index].states.len() {
                if self.state(cam_index, element_index).passed {
                    continue;
                }
                let at = instant(piece, until, clock);
                let inside = [true, false].map(|latch| {
                    let (interpolation, window) = self.signal(piece, cam_index, element_index, latch);
                    window.contains(interpolation.at(until))
                });
                self.correct(cam_index, element_index, inside, at);
            }
        }
    }

    /// Indices of the cams that depend on the position of the axis.
    fn live(&self) -> &'static [usize] {
        if self.phase == Phase::Armed {
            &[ACTIVE, PENDING, TAIL]
        } else {
            &[TAIL]
        }
    }

    /// The position that an element compares, over the update, and the window with which it compares it.
    fn signal(&self, piece: &Piece, cam_index: usize, element_index: usize, latch: bool) -> (Interpolation, Window) {
        let Some((element, compensation)) = self.cams[cam_index].element(element_index) else {
            return (Interpolation::step(0.0, 0.0), Window::NONE);
        };
        let delay = compensation.delay(latch);
        (
            piece.interpolation(delay),
            self.window(cam_index, element, compensation),
        )
    }

    /// The range of an element, in positions of the axis.
    pub(super) fn window(&self, cam_index: usize, element: &Element, compensation: &Compensation) -> Window {
        let Some(cam) = self.cams[cam_index].cam() else {
            return Window::NONE;
        };
        let (zero, turns) = match (cam_index, self.trailing, self.cams[ACTIVE].cam()) {
            (TAIL, Some(left), _) => (left.zero, left.turns),
            (PENDING, _, Some(active)) => {
                let behind = if self.forward {
                    active.end - cam.start
                } else {
                    active.start - cam.end
                };
                (self.zero() + behind, Turns::ONE)
            }
            _ => (self.zero(), self.turns_of_active()),
        };
        let shift = zero + compensation.offset;
        Window {
            left: shift + element.left,
            right: shift + element.right,
            cycle: cam.end - cam.start,
            turns,
        }
    }

    pub(super) fn arm_enabled(&mut self, at: Instant) {
        for element_index in 0..self.cams[ACTIVE].states.len() {
            let CamState { program, states } = &mut self.cams[ACTIVE];
            let Some(program) = program else { return };
            let effect = states[element_index].arm(&program.cam.elements[element_index]);
            self.take(ACTIVE, element_index, effect, at);
        }
    }

    /// Corrects an element that should be in its ranges, or outside of them.
    pub(super) fn correct(&mut self, cam_index: usize, element_index: usize, [latch, unlatch]: [bool; 2], at: Instant) {
        let events = [
            (false, unlatch, ElementEvent::UnlatchLeft, ElementEvent::UnlatchEntered),
            (true, latch, ElementEvent::LatchLeft, ElementEvent::LatchEntered),
        ];
        for (which, inside, left, entered) in events {
            if self.state(cam_index, element_index).is_in(which) != inside {
                self.happens(cam_index, element_index, if inside { entered } else { left }, at);
            }
        }
    }

    pub(super) fn happens(&mut self, cam_index: usize, element_index: usize, what: ElementEvent, at: Instant) {
        let CamState { program, states } = &mut self.cams[cam_index];
        let (Some(program), Some(state)) = (program, states.get_mut(element_index)) else {
            return;
        };
        let effect = state.happens(&program.cam.elements[element_index], what);
        self.take(cam_index, element_index, effect, at);
    }

    /// Takes the effect of an event.
    pub(super) fn take(&mut self, cam_index: usize, element_index: usize, effect: Effect, at: Instant) {
        let Some((element, _)) = self.cams[cam_index].element(element_index) else {
            return;
        };
        let (bit, duration) = (usize::from(element.bit), element.duration);
        let ends = element.unlatch.by_duration();
        match effect {
            Effect::Nothing => {}
            Effect::Latches => {
                if ends {
                    self.cams[cam_index].states[element_index].off_at = Some(at.after(duration, &self.ticks));
                }
                if self.on & (1 << bit) == 0 {
                    self.on |= 1 << bit;
                    self.since[bit] = at;
                }
            }
            Effect::Unlatches => self.release(bit),
        }
    }

    /// Clears a bit, unless an element holds it.
    pub(super) fn release(&mut self, bit: usize) {
        let holds = |cam_index: &CamState| {
            let of_bit = |element_index: usize| {
                cam_index
                    .element(element_index)
                    .is_some_and(|(own, _)| usize::from(own.bit) == bit)
            };
            let mut states = cam_index.states.iter().enumerate();
            states.any(|(element_index, state)| state.holds && of_bit(element_index))
        };
        if self.trailing_bits[bit].is_none() && !self.cams.iter().any(holds) {
            self.on &= !(1 << bit);
        }
    }

    /// Ends the durations that are over at an instant.
    pub(super) fn expire(&mut self, at: Instant, clock: &Clock) {
        let is_over = |off_at: Instant| off_at.elapsed(clock) >= at.elapsed(clock);
        for bit in 0..OUTPUT_BITS {
            if self.trailing_bits[bit].is_some_and(is_over) {
                self.trailing_bits[bit] = None;
                self.release(bit);
            }
        }
        for cam_index in [ACTIVE, PENDING, TAIL] {
            for element_index in 0..self.cams[cam_index].states.len() {
                let state = &mut self.cams[cam_index].states[element_index];
                if state.off_at.is_some_and(is_over) {
                    let effect = state.release();
                    self.take(cam_index, element_index, effect, at);
                }
            }
        }
    }

    /// Updates the enable conditions of all cams.
    pub(super) fn enable_all(&mut self, at: Instant) {
        for cam_index in [ACTIVE, PENDING, TAIL] {
            self.enable(cam_index, at);
        }
    }

    /// Updates the enable conditions of one cam.
    pub(super) fn enable(&mut self, cam_index: usize, at: Instant) {
        let own = self.written;
        let output = (self.output.bits & !own.mask) | (own.bits & own.mask);
        let input = self.input.map_or(0, |input| input.bits);
        let armed = cam_index == ACTIVE && self.phase == Phase::Armed;
        for element_index in 0..self.cams[cam_index].states.len() {
            let Some((element, _)) = self.cams[cam_index].element(element_index) else {
                continue;
            };
            if self.state(cam_index, element_index).is_over() {
                continue;
            }
            let element = *element;
            let word = if element.enable.of_output { output } else { input };
            let enabled = (word & (1 << element.enable.bit) != 0) != element.enable.inverted;
            let effect = self.cams[cam_index].states[element_index].enable(&element, enabled, armed);
            self.take(cam_index, element_index, effect, at);
        }
    }

    pub(super) fn state(&self, cam_index: usize, element_index: usize) -> ElementState {
        self.cams[cam_index]
            .states
            .get(element_index)
            .copied()
            .unwrap_or_default()
    }
}
