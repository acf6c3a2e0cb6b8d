//! Written parts of plain tags, for the state file, and the restoration of their retained bytes.

use super::{Image, TagId, TagKind};

/// A written part of a plain tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct WrittenPart {
    /// The tag.
    pub id: TagId,
    /// The first byte.
    pub offset: usize,
    /// Number of bytes, 1 or more.
    pub length: usize,
}

impl Image {
    /// Restores the retained bytes of a plain tag. Bytes of another length, or for another kind of tag, are ignored.
    pub fn restore(&mut self, id: TagId, kept: &[u8]) {
        let plain = self.tag(id).is_some_and(|tag| tag.kind == TagKind::Plain);
        if let Some(bytes) = self.bytes_mut(id).filter(|bytes| plain && bytes.len() == kept.len()) {
            bytes.copy_from_slice(kept);
        }
    }

    /// Starts to record written parts of plain tags, until [`Image::take_written`] takes them.
    pub fn remember_written(&mut self) {
        self.written.get_or_insert_default();
    }

    /// Whether parts of plain tags have been written since the last [`Image::take_written`].
    pub fn has_written(&self) -> bool {
        self.written.as_ref().is_some_and(|written| !written.is_empty())
    }

    /// The parts of plain tags written since the last call: without overlaps, and few for each tag.
    pub fn take_written(&mut self) -> Vec<WrittenPart> {
        self.written.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Records a written part, for the retained state and the program.
    pub(super) fn note_written(&mut self, id: TagId, offset: usize, length: usize) {
        self.note_part(id, offset, length, 0xFF);
        self.note_retained(id, offset, length);
    }

    /// As [`Image::note_written`], for some bits of a byte.
    pub(super) fn note_written_bits(&mut self, id: TagId, offset: usize, mask: u8) {
        self.note_part(id, offset, 1, mask);
        self.note_retained(id, offset, 1);
    }

    /// Records a part for the retained state. The tags of a program start with the values of its file.
    fn note_retained(&mut self, id: TagId, offset: usize, length: usize) {
        if self.is_of_program(id) {
            return;
        }
        let plain = self.tag(id).is_some_and(|tag| tag.kind == TagKind::Plain);
        if let Some(written) = self.written.as_mut().filter(|_| plain && length > 0) {
            add_part(written, WrittenPart { id, offset, length });
        }
    }
}

/// Adds a part to those that wait. Parts of one tag that overlap or touch become one, and so do all of a tag that has many, so that
/// what waits is never more than the tags.
fn add_part(written: &mut Vec<WrittenPart>, new: WrittenPart) {
    let mut joined = new;
    let are_many = written.iter().filter(|part| part.id == new.id).count() >= MOST_PARTS;
    written.retain(|part| {
        let touches = part.offset <= joined.end() && joined.offset <= part.end();
        let joins = part.id == joined.id && (touches || are_many);
        if joins {
            joined = joined.with(part);
        }
        !joins
    });
    written.push(joined);
}

impl WrittenPart {
    /// The byte behind it.
    fn end(&self) -> usize {
        self.offset + self.length
    }

    /// The least part that has both.
    fn with(self, other: &WrittenPart) -> WrittenPart {
        let offset = self.offset.min(other.offset);
        WrittenPart {
            length: self.end().max(other.end()) - offset,
            offset,
            ..self
        }
    }
}

/// Parts of one tag that wait apart: more than the writes of one message.
const MOST_PARTS: usize = 1024;
