//! Which parts of plain tags were written, for the state file, and what they held before.

use super::{Image, TagId, TagKind};

/// A part of a plain tag that was written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Written {
    /// The tag.
    pub id: TagId,
    /// The first byte.
    pub offset: usize,
    /// Bytes, 1 or more.
    pub length: usize,
}

impl Image {
    /// Makes a plain tag hold what it once held. Nothing comes of bytes of another length, or of another tag.
    pub fn restore(&mut self, id: TagId, kept: &[u8]) {
        let plain = self.tag(id).is_some_and(|tag| tag.kind == TagKind::Plain);
        if let Some(bytes) = self.bytes_mut(id).filter(|bytes| plain && bytes.len() == kept.len()) {
            bytes.copy_from_slice(kept);
        }
    }

    /// From now on remembers which parts of plain tags are written, until [`Image::take_written`] takes them.
    pub fn remember_written(&mut self) {
        self.written.get_or_insert_default();
    }

    /// The parts of plain tags that were written since the last call, in order.
    pub fn take_written(&mut self) -> Vec<Written> {
        self.written.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Notes a part that was written, for the retained state and the program.
    pub(super) fn note_written(&mut self, id: TagId, offset: usize, length: usize) {
        self.note_part(id, offset, length, 0xFF);
        self.note_retained(id, offset, length);
    }

    /// As [`Image::note_written`], of some bits of a byte.
    pub(super) fn note_written_bits(&mut self, id: TagId, offset: usize, mask: u8) {
        self.note_part(id, offset, 1, mask);
        self.note_retained(id, offset, 1);
    }

    /// The tags of a program begin as its file has them.
    fn note_retained(&mut self, id: TagId, offset: usize, length: usize) {
        if self.is_of_program(id) {
            return;
        }
        let plain = self.tag(id).is_some_and(|tag| tag.kind == TagKind::Plain);
        if let Some(written) = self.written.as_mut().filter(|_| plain && length > 0) {
            written.push(Written { id, offset, length });
        }
    }
}
