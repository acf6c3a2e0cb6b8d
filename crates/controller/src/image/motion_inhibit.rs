//! The tag `MotionInhibit`: TRUE stops all motion and refuses every instruction that begins motion, until it is FALSE again
//! (spec/contract.md §7).

use arcline_tag::{Elementary, TagType};

use super::{Image, TagId, TagKind, WriteEffect, WriteError};

/// Name of the tag.
pub const MOTION_INHIBIT_TAG: &str = "MotionInhibit";

impl Image {
    /// Sets the value of the tag.
    pub fn show_inhibited(&mut self, is_inhibited: bool) {
        let tag = self.tags().iter().find(|tag| tag.kind == TagKind::MotionInhibit);
        let Some(id) = tag.map(|tag| tag.id) else { return };
        if let Some(byte) = self.bytes_mut(id).and_then(|bytes| bytes.first_mut()) {
            *byte = u8::from(is_inhibited);
        }
    }

    /// Adds the tag, if the name is free.
    pub(super) fn add_motion_inhibit(&mut self) {
        if self.find(MOTION_INHIBIT_TAG).is_none() {
            let tag_type = TagType::scalar(Elementary::Bool);
            self.add(MOTION_INHIBIT_TAG, tag_type, TagKind::MotionInhibit);
        }
    }

    /// Writes the tag.
    pub(super) fn write_motion_inhibit(&mut self, id: TagId, data: &[u8]) -> Result<Option<WriteEffect>, WriteError> {
        let on = data.first().is_some_and(|byte| *byte != 0);
        if let Some(byte) = self.bytes_mut(id).and_then(|bytes| bytes.first_mut()) {
            *byte = u8::from(on);
        }
        Ok(Some(WriteEffect::Inhibit(on)))
    }
}
