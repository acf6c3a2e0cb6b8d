//! Inputs of the machine from tags while it runs, and the events that axes wait for.
//!
//! Real-time: no allocation; bounded by the axes.

use arcline_drive::{DriveInput, Drives, REGISTRATION_LATCHES, WrittenInput};
use arcline_instruction_set::AxisId;
use arcline_instruction_set::TagAddress;

use super::Motion;
use crate::axis::feed::FeedEffect;
use crate::output::TagBits;

/// A value written to a tag that the machine reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// The position of an axis, from a client.
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
        /// The number of the input, from 0.
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
        /// The tag, by its address in the directory.
        tag: TagAddress,
        /// Its new value.
        bits: u32,
    },
}

impl Motion {
    /// Takes an input at the present tick; an input of an axis that does not exist changes nothing. Real-time.
    pub fn input(&mut self, input: Input, drives: &mut dyn Drives) {
        match input {
            Input::Position { axis, position } => self.feed(axis, position),
            Input::Word { tag, bits } => self.share_word(&TagBits {
                tag,
                mask: u32::MAX,
                bits,
            }),
            Input::Registration { axis, input, on } => self.write_registration(axis, usize::from(input), on, drives),
            Input::HomeSwitch { axis, on } => self.write_level(axis, DriveInput::Home, on, drives),
            Input::Enable { axis, on } => self.write_level(axis, DriveInput::Enable, on, drives),
        }
    }

    /// Passes a written input to the drive; its next feedback shows the effect.
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

    /// Passes a written registration input to the drive, and takes the latch that it closes.
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
        let latch_index = REGISTRATION_LATCHES[input];
        state.link.feedback.latches[latch_index] = feedback.latches[latch_index].take();
        state.take_registrations(&mut self.controls, &self.clock);
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
        if let FeedEffect::Placed(offset) = feeding.take(position, unwind, &clock) {
            state.shift_fed_position(offset);
        }
    }

    /// Checks the events that an axis waits for.
    pub(super) fn check_events(&mut self, axis: AxisId) {
        self.axes[axis].take_registrations(&mut self.controls, &self.clock);
        self.axes[axis].check_watch(&mut self.controls, &self.clock);
        self.update_outputs(axis);
    }
}
