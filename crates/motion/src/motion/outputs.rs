//! Output cams of axes from one tick to the next, and the words that they write.
//!
//! Real-time: no allocation; bounded by the axes and their execution targets.

use arcline_instruction_set::{AxisId, Flag};

use super::{Motion, WORDS};
use crate::events::{InstructionWrite, WrittenValues};
use crate::output::TagBits;

impl Motion {
    /// Updates the output cams of an axis with its position at the present tick.
    pub(super) fn update_outputs(&mut self, axis: AxisId) {
        for target in 0..self.axes[axis].outputs.len() {
            let Some(reference) = self.axes[axis].outputs.reference(target) else {
                continue;
            };
            let point = self.axes.master_at(axis, reference, &self.clock).point;
            let outcome = self.axes[axis].outputs.update(target, point, &self.clock);
            for execution in outcome.ended.into_iter().flatten() {
                self.controls.end_move(execution, Flag::Pc.mask());
            }
            self.write_word(outcome.written);
        }
    }

    /// Ends the tick for output cams: words that its instructions changed reach the output cams that they enable, and the next update begins
    /// with the present velocities of the axes.
    pub(super) fn finish_outputs(&mut self) {
        // Words that change as a result belong to the next tick.
        let count = self.words.len();
        for word_index in 0..count {
            let word = self.words[word_index];
            self.share_word(&word);
        }
        self.words.drain(..count);
        if !self.axes.have_output_cams {
            return;
        }
        for axis in self.axes.ids() {
            for target in 0..self.axes[axis].outputs.len() {
                if let Some(reference) = self.axes[axis].outputs.reference(target) {
                    let point = self.axes.master_at(axis, reference, &self.clock).point;
                    self.axes[axis].outputs.begin_update(target, point);
                }
            }
        }
    }

    /// Passes bits of a tag to the output cams that they enable.
    pub(super) fn share_word(&mut self, word: &TagBits) {
        for axis in self.axes.ids() {
            for target in 0..self.axes[axis].outputs.len() {
                let written = self.axes[axis].outputs.take_word(target, word, &self.clock);
                self.write_word(written);
            }
        }
    }

    /// Writes bits to a tag.
    pub(crate) fn write_word(&mut self, word: Option<TagBits>) {
        let Some(word) = word else { return };
        if self.controls.has_room_for_instruction_write() && self.words.len() < WORDS {
            self.controls.write_to_tag(InstructionWrite {
                tick: self.clock.tick,
                tag: word.tag,
                values: WrittenValues::Bits {
                    mask: word.mask,
                    bits: word.bits,
                },
            });
            self.words.push(word);
        }
    }
}
