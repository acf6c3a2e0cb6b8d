//! Structure tags that an instruction reads as a whole: the frames of MCTO and MCTPO go with the call into the tick, as
//! they are when it is made (spec/coordinated-instructions.md §22.8, §24).
//!
//! Not here: cams, and what an instruction writes to tags (`cams`).

use arcline_instruction_set::{Call, Detail, MotionError, OperandIndex};
use arcline_motion::{Frame, Frames};

use super::cams::{operand, word};
use super::{Image, TagId};

impl Image {
    /// The frames of a call of MCTO or MCTPO.
    ///
    /// # Errors
    /// A tag that is gone since the call was bound (13), an angle that is none (74).
    pub(super) fn frames(&self, call: &Call) -> Result<Frames, MotionError> {
        let [work, tool] = ["Work Frame", "Tool Frame"].map(|name| self.frame(call, name));
        Ok(Frames {
            work: work?,
            tool: tool?,
        })
    }

    fn frame(&self, call: &Call, name: &str) -> Result<Frame, MotionError> {
        let bytes = self.structure_of(call, name)?;
        let coordinates = [4, 8, 12, 16, 20, 24].map(|at| real(bytes, at));
        if let Some(place) = coordinates.iter().position(|number| !number.is_finite()) {
            return Err(MotionError::InvalidOrientationAngle(Detail(place as i8)));
        }
        Ok(Frame {
            id: i32::from_le_bytes(word(bytes, 0)),
            coordinates,
        })
    }

    /// The bytes from the structure on that an operand names: that and what follows it in its tag.
    ///
    /// # Errors
    /// There is no such tag any more: 13 with the operand.
    pub(super) fn structure_of(&self, call: &Call, name: &str) -> Result<&[u8], MotionError> {
        let place = operand(call.mnemonic, name);
        let bytes = call.tag(place).and_then(|tag| {
            let (id, offset) = (TagId(tag >> 16), (tag & 0xFFFF) as usize * 4);
            self.bytes(id).get(offset..).filter(|bytes| !bytes.is_empty())
        });
        bytes.ok_or(MotionError::ParameterOutOfRange(OperandIndex(place as u8)))
    }
}

/// The REAL at a byte.
pub(super) fn real(bytes: &[u8], at: usize) -> f64 {
    f64::from(f32::from_le_bytes(word(bytes, at)))
}
