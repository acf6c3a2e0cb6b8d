//! What comes into the machine from tags while it runs, and what axes look out for.
//!
//! Real-time: no allocation; bounded by the axes.

use arcline_drive::{DriveInput, Drives, REGISTRATION_LATCHES, Trigger, WrittenInput};
use arcline_instruction_set::TagAddress;
use arcline_instruction_set::{AxisId, Flag};

use super::Motion;
use crate::axis::feed::Fed;
use crate::output::Word;

/// Something that was written to a tag that the machine reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// The position of an axis, as a client wrote it.
    Position {
        /// Index of the axis.
        axis: AxisId,
        /// Position units.
        position: f64,
    },
    /// A registration input of an axis has changed.
    Registration {
        /// Index of the axis.
        axis: AxisId,
        /// Which one, from 0.
        input: u8,
        /// It is active now.
        on: bool,
    },
    /// The home switch of an axis has changed.
    HomeSwitch {
        /// Index of the axis.
        axis: AxisId,
        /// It is active now.
        on: bool,
    },
    /// The enable input of an axis's drive has changed.
    Enable {
        /// Index of the axis.
        axis: AxisId,
        /// It is active now.
        on: bool,
    },
    /// A word that output cams write, or that enables them.
    Word {
        /// The tag, by what the directory calls it.
        tag: TagAddress,
        /// What is in it now.
        bits: u32,
    },
}

impl Motion {
    /// Takes an input at the present tick; that of an axis that does not exist changes nothing. Real-time.
    pub fn input(&mut self, input: Input, drives: &mut dyn Drives) {
        match input {
            Input::Position { axis, position } => self.feed(axis, position),
            Input::Word { tag, bits } => self.share_word(&Word {
                tag,
                mask: u32::MAX,
                bits,
            }),
            Input::Registration { axis, input, on } => self.write_registration(axis, usize::from(input), on, drives),
            Input::HomeSwitch { axis, on } => self.write_level(axis, DriveInput::Home, on, drives),
            Input::Enable { axis, on } => self.write_level(axis, DriveInput::Enable, on, drives),
        }
    }

    /// Gives a written input to the drive, whose next feedback shows what comes of it.
    fn write_level(&mut self, axis: AxisId, input: DriveInput, on: bool, drives: &mut dyn Drives) {
        let (Some(state), Some(feedback)) = (self.axes.get_mut(axis), self.feedback.get_mut(axis.index())) else {
            return;
        };
        let written = WrittenInput {
            axis,
            input,
            on,
            armed: None,
        };
        drives.write_input(&written, feedback);
        state.link.feedback.inputs = feedback.inputs;
    }

    /// Gives a written registration input to the drive, and takes the latch that it closes.
    fn write_registration(&mut self, axis: AxisId, input: usize, on: bool, drives: &mut dyn Drives) {
        let (Some(state), Some(feedback)) = (self.axes.get_mut(axis), self.feedback.get_mut(axis.index())) else {
            return;
        };
        let Some(registration) = state.registrations.get(input) else {
            return;
        };
        let armed = registration.latch();
        let written = WrittenInput {
            axis,
            input: DriveInput::Registration(input),
            on,
            armed,
        };
        drives.write_input(&written, feedback);
        state.link.feedback.inputs = feedback.inputs;
        let place = REGISTRATION_LATCHES[input];
        state.link.feedback.latches[place] = feedback.latches[place].take();
        self.take_registrations(axis);
    }

    /// Registration inputs of the drive whose latches have closed.
    pub(super) fn take_registrations(&mut self, axis: AxisId) {
        let (period, now) = (self.clock.period_ns, self.clock.tick.wrapping_mul(self.clock.period_ns));
        for (input, place) in REGISTRATION_LATCHES.into_iter().enumerate() {
            let state = &mut self.axes[axis];
            let (Some(latch), Some(armed)) = (state.link.feedback.latches[place], state.registrations[input].latch())
            else {
                continue;
            };
            if latch.number != armed.number {
                continue;
            }
            let before = (latch.before_end_s / self.clock.period() * period as f64) as u64;
            let time = (now.saturating_sub(before) / 1000) as i32;
            let position = state.shown(state.latched_at(latch.position));
            let positive = armed.trigger == Trigger::RegistrationOn;
            match state.registrations[input].edge(positive, position, time) {
                Some(execution) => self.end_move(execution, Flag::Pc.mask()),
                None => {
                    let again = state.link.arm(armed.trigger, false);
                    state.registrations[input].arm_again(again);
                }
            }
        }
    }

    fn feed(&mut self, axis: AxisId, position: f64) {
        let clock = self.clock;
        let Some(state) = self.axes.get_mut(axis) else {
            return;
        };
        let unwind = state.unwind;
        let Some(feeding) = state.feeding.as_mut().filter(|_| position.is_finite()) else {
            return;
        };
        if let Fed::Placed(offset) = feeding.take(position, unwind, &clock) {
            state.shift_fed_position(offset);
        }
    }

    /// What axes look out for is looked at.
    pub(super) fn look_out(&mut self, axis: AxisId) {
        let state = &mut self.axes[axis];
        let now = state.actual.position - state.redefined;
        if let Some(execution) = state.watch.look(now) {
            self.end_move(execution, Flag::Pc.mask());
        }
        self.look_at_outputs(axis);
    }

    /// An axis does not look out for anything any more.
    pub(crate) fn disarm(&mut self, axis: AxisId) {
        let state = &mut self.axes[axis];
        let [first, second] = &mut state.registrations;
        for execution in [state.watch.disarm(), first.disarm(), second.disarm()]
            .into_iter()
            .flatten()
        {
            self.end_move(execution, 0);
        }
        for target in 0..self.axes[axis].outputs.len() {
            self.disarm_output(axis, target);
        }
    }
}
