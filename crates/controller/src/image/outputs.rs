//! Output cams and their tags: the arrays of a MAOC enter the tick with the call, the machine receives changes of words that enable an output
//! cam, and the bits of the cam are written to its Output (spec/axis-and-data-types.md §5, §8.9).
//!
//! The values of the arrays are those at the execution of the instruction. Not here: the function of an output cam.

use std::sync::Arc;

use arcline_instruction_set::operands::{Maoc, Operands};
use arcline_instruction_set::{Call, MotionError, TagAddress};
use arcline_motion::{BitCompensation, CallData, CamElement, Input, OUTPUT_BITS, OutputCam, OutputCamError};
use arcline_tag::TagPath;

use super::calls::tag_and_offset;
use super::cam_tags::ElementRange;
use super::cams::{Prepared, Refusal};
use super::shared::Unshared;
use super::structures::{dint, real, word};
use super::{Image, TagId};

/// Output cams that the machine may still use.
#[derive(Clone, Debug, Default)]
pub(super) struct Outputs {
    /// With the tags of their output and their input. An entry stays until it holds the last reference, so that the memory is freed
    /// here and not in the tick.
    used: Unshared<([Option<TagAddress>; 2], Arc<OutputCam>)>,
}

impl Image {
    /// The data of a MAOC that stand in tags.
    pub(super) fn prepare_output_cam(&mut self, call: &Call) -> Prepared {
        self.free_output_cams();
        let Maoc {
            output,
            input,
            output_cam,
            cam_start_position,
            cam_end_position,
            output_compensation,
            ..
        } = Maoc::of(call);
        let cam = self.array_of(&output_cam, OUTPUT_CAM)?;
        let elements: Vec<CamElement> = self.elements(cam, OUTPUT_CAM).map(element).collect();
        let compensation: Vec<BitCompensation> = match *output_compensation {
            None => Vec::new(),
            Some(_) => {
                let range = self.array_of(&output_compensation, OUTPUT_COMPENSATION)?;
                let elements = self.elements(range, OUTPUT_COMPENSATION);
                elements.take(OUTPUT_BITS).map(compensation).collect()
            }
        };
        let range = *cam_start_position..=*cam_end_position;
        let cam = OutputCam::new(range, &elements, &compensation).map_err(|error| match error {
            OutputCamError::Element { element } => Refusal::element(MotionError::IllegalOutputCam, element),
            OutputCamError::Compensation { element } => {
                Refusal::element(MotionError::IllegalOutputCompensation, element)
            }
        })?;
        let cam = Arc::new(cam);
        let tags = [*output, *input];
        let words = tags.map(|tag| tag.map_or(0, |tag| self.word_of(tag)));
        self.outputs.used.push((tags, cam.clone()));
        Ok((CallData::OutputCam(cam, words), None))
    }

    /// Records the words of output cams among written bytes.
    pub(super) fn note_words(&self, id: TagId, offset: usize, length: usize, written: &mut Vec<Input>) {
        for tag in self.outputs.used.iter().flat_map(|(tags, _)| tags.iter().flatten()) {
            let (of, from) = tag_and_offset(*tag);
            let known = |input: &Input| matches!(input, Input::Word { tag: other, .. } if other == tag);
            if of == id && offset < from + WORD && from < offset + length && !written.iter().any(known) {
                let bits = self.word_of(*tag);
                written.push(Input::Word { tag: *tag, bits });
            }
        }
    }

    /// Output cams write the tag.
    pub fn is_output(&self, path: &TagPath) -> bool {
        let Ok((id, at)) = self.locate(path) else {
            return false;
        };
        let outputs = self.outputs.used.iter().filter_map(|([output, _], _)| *output);
        outputs
            .map(tag_and_offset)
            .any(|(of, from)| of == id && (from..from + WORD).contains(&at.offset))
    }

    /// Output cams are in use, so written words matter.
    pub(super) fn watches_words(&self) -> bool {
        !self.outputs.used.is_empty()
    }

    /// Frees output cams that the machine no longer uses.
    pub(super) fn free_output_cams(&mut self) {
        self.outputs.used.retain(|(_, cam)| Arc::strong_count(cam) > 1);
    }

    /// Writes bits of a word; the other bits stay unchanged.
    pub(super) fn apply_bits(&mut self, tag: TagAddress, mask: u32, bits: u32) {
        let (id, from) = tag_and_offset(tag);
        let word = (self.word_of(tag) & !mask) | (bits & mask);
        self.put(id, from, &word.to_le_bytes());
    }

    fn word_of(&self, tag: TagAddress) -> u32 {
        let (id, from) = tag_and_offset(tag);
        u32::from_le_bytes(word(self.bytes(id), from))
    }

    fn elements(&self, range: ElementRange, size: usize) -> impl Iterator<Item = &[u8]> {
        let bytes = self.bytes(range.id).get(range.offset..).unwrap_or_default();
        bytes.chunks_exact(size).take(range.elements)
    }
}

fn element(bytes: &[u8]) -> CamElement {
    CamElement {
        output_bit: dint(bytes, 0),
        latch_type: dint(bytes, 4),
        unlatch_type: dint(bytes, 8),
        left: real(bytes, 12),
        right: real(bytes, 16),
        duration: real(bytes, 20),
        enable_type: dint(bytes, 24),
        enable_bit: dint(bytes, 28),
    }
}

fn compensation(bytes: &[u8]) -> BitCompensation {
    BitCompensation {
        offset: real(bytes, 0),
        latch_delay: real(bytes, 4),
        unlatch_delay: real(bytes, 8),
        mode: dint(bytes, 12),
        cycle_time: real(bytes, 16),
        duty_cycle: real(bytes, 20),
    }
}

/// Bytes of a DINT.
const WORD: usize = 4;
/// Bytes of an OUTPUT_CAM.
const OUTPUT_CAM: usize = 32;
/// Bytes of an OUTPUT_COMPENSATION.
const OUTPUT_COMPENSATION: usize = 24;
