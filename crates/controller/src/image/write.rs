//! Writing: the bytes that clients may write, and the edges of `EnableIn` that result.

use arcline_tag::{DataType, TagPath, Value};

use super::read::not_a_value;
use super::{Access, CallRoom, Image, MOTION_CONTROL, Tag, TagId, TagKind, WriteEffect, WriteError};

impl Image {
    /// Clients may write these bytes of a tag.
    pub fn writable(&self, id: TagId, offset: usize, len: usize) -> bool {
        self.writable_bits(id, offset, len, u8::MAX)
    }

    /// The same for the bits of a mask in a single byte.
    fn writable_bits(&self, id: TagId, offset: usize, len: usize, mask: u8) -> bool {
        let end = offset.saturating_add(len);
        let Some(tag) = self.tag(id) else { return false };
        if end > self.bytes(id).len() {
            return false;
        }
        match tag.kind {
            TagKind::Plain => tag.access == Access::ReadWrite && !tag.tag_type.is_read_only(&(offset..end), mask),
            TagKind::FeedOverride | TagKind::FaultInject | TagKind::MotionInhibit | TagKind::ClockStep => true,
            TagKind::Instruction(_) => {
                let DataType::Structure(template) = &tag.tag_type.data_type else {
                    return false;
                };
                let overlaps = |name: &str| {
                    template.member(name).is_some_and(|member| {
                        let from = member.offset as usize;
                        offset < from + member.size() && from < end
                    })
                };
                // The host byte of EnableIn also holds EnableOut, so clients write it bit by bit.
                !overlaps(MOTION_CONTROL) && !overlaps(ENABLE_OUT)
            }
            TagKind::Axis(_) => {
                // The only member that its page calls "Settable".
                let DataType::Structure(template) = &tag.tag_type.data_type else {
                    return false;
                };
                template.member("InterpolationTime").is_some_and(|member| {
                    let from = member.offset as usize;
                    from <= offset && end <= from + member.size()
                })
            }
            _ => false,
        }
    }

    /// Writes bytes of a tag.
    ///
    /// # Errors
    /// The tag does not exist, or a byte is beyond its end or read-only; nothing is written then.
    pub fn write(&mut self, id: TagId, offset: usize, data: &[u8]) -> Result<Option<WriteEffect>, WriteError> {
        self.check_write(id, offset, data.len(), u8::MAX)?;
        match self.tag(id).map(|tag| tag.kind) {
            Some(TagKind::FeedOverride) => return self.write_feed_override(id, offset, data),
            Some(TagKind::FaultInject) => return self.write_fault_inject(id, offset, data),
            Some(TagKind::MotionInhibit) => return self.write_motion_inhibit(id, data),
            Some(TagKind::ClockStep) => return self.write_clock_step(id, data),
            _ => {}
        }
        self.check_range(id, offset, data)?;
        if let Some(bytes) = self.bytes_mut(id) {
            bytes[offset..offset + data.len()].copy_from_slice(data);
        }
        self.note_written(id, offset, data.len());
        Ok(self.note_inputs(id, offset, data.len()))
    }

    /// Writes a bit of a tag: a BOOL member, or bit 0 to 63 of an integer at `offset`.
    ///
    /// # Errors
    /// As [`Image::write`].
    pub fn write_bit(
        &mut self,
        id: TagId,
        offset: usize,
        bit: u8,
        on: bool,
    ) -> Result<Option<WriteEffect>, WriteError> {
        let (offset, mask) = (offset + usize::from(bit / 8), 1u8 << (bit % 8));
        let enable = self.enable_in(id).filter(|enable| *enable == (offset, mask));
        if enable.is_none() {
            self.check_write(id, offset, 1, mask)?;
        }
        let has_no_bits = |tag: &&Tag| matches!(tag.kind, TagKind::FeedOverride | TagKind::ClockStep);
        if let Some(tag) = self.tag(id).filter(has_no_bits) {
            // One is a REAL, and a write to the other is a whole number of ticks.
            return Err(WriteError::ReadOnly { name: tag.name.clone() });
        }
        if self.tag(id).is_some_and(|tag| tag.kind == TagKind::FaultInject) {
            let mut byte = self.bytes(id).get(offset).copied().unwrap_or_default();
            put_bit(&mut byte, mask, on);
            return self.write_fault_inject(id, offset, &[byte]);
        }
        if self.tag(id).is_some_and(|tag| tag.kind == TagKind::MotionInhibit) {
            return self.write_motion_inhibit(id, &[u8::from(on)]);
        }
        let mut byte = self.bytes(id).get(offset).copied().unwrap_or_default();
        put_bit(&mut byte, mask, on);
        self.check_range(id, offset, &[byte])?;
        let rises = on && self.bytes(id).get(offset).is_some_and(|byte| byte & mask == 0);
        if enable.is_some() && rises {
            self.take_room(id)?;
        }
        let out = self.member_bit(id, ENABLE_OUT);
        let Some(bytes) = self.bytes_mut(id) else {
            return Err(WriteError::NoSuchTag);
        };
        let before = bytes[offset] & mask != 0;
        put_bit(&mut bytes[offset], mask, on);
        if enable.is_none() {
            self.note_written_bits(id, offset, mask);
            return Ok(self.note_inputs(id, offset, 1));
        }
        if let Some((offset, mask)) = out {
            put_bit(&mut bytes[offset], mask, on);
        }
        Ok(match (before, on) {
            (false, true) => Some(WriteEffect::Rising(id)),
            (true, false) => Some(WriteEffect::Falling(id)),
            _ => None,
        })
    }

    /// Writes a value at a path, converted to the type there.
    ///
    /// # Errors
    /// As [`Image::locate`] and [`Image::write`].
    pub fn write_value(&mut self, path: &TagPath, value: Value) -> Result<Option<WriteEffect>, WriteError> {
        let (id, location) = self.locate(path)?;
        if let Some(bit) = location.bit {
            return self.write_bit(id, location.offset, bit, value.as_bool());
        }
        let DataType::Elementary(kind) = location.data_type else {
            return Err(not_a_value(path, &location).into());
        };
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..kind.size()];
        value.convert(kind).write(bytes);
        self.write(id, location.offset, bytes)
    }

    /// The bit of a tag is the `EnableIn` of an instruction tag.
    pub fn is_enable_in(&self, id: TagId, offset: usize, bit: u8) -> bool {
        self.enable_in(id) == Some((offset + usize::from(bit / 8), 1 << (bit % 8)))
    }

    /// Sets the number of instructions for which the controller has room.
    pub fn set_call_room(&mut self, room: CallRoom) {
        self.room = room;
    }

    /// Counts an instruction that its tag is about to execute.
    fn take_room(&mut self, id: TagId) -> Result<(), WriteError> {
        let tag = self.tag(id).ok_or(WriteError::NoSuchTag)?;
        let stops = matches!(tag.kind, TagKind::Instruction(kind) if kind.mnemonic.is_stop());
        let room = if stops { self.room.stops } else { self.room.calls };
        if room == 0 {
            return Err(WriteError::NoRoom { name: tag.name.clone() });
        }
        let CallRoom { calls, stops } = self.room;
        self.room = CallRoom {
            calls: calls.saturating_sub(1),
            stops: stops.saturating_sub(1),
        };
        Ok(())
    }

    fn check_write(&self, id: TagId, offset: usize, len: usize, mask: u8) -> Result<(), WriteError> {
        let size = self.bytes(id).len();
        let tag = self.tag(id).ok_or(WriteError::NoSuchTag)?;
        if offset.saturating_add(len) > size {
            return Err(WriteError::BeyondEnd {
                name: tag.name.clone(),
                size,
            });
        }
        if !self.writable_bits(id, offset, len, mask) {
            return Err(WriteError::ReadOnly { name: tag.name.clone() });
        }
        Ok(())
    }

    fn enable_in(&self, id: TagId) -> Option<(usize, u8)> {
        self.member_bit(id, ENABLE_IN)
    }

    /// Byte and mask of a BOOL of an instruction tag.
    fn member_bit(&self, id: TagId, name: &str) -> Option<(usize, u8)> {
        let tag = self.tag(id)?;
        match (&tag.tag_type.data_type, tag.kind) {
            (DataType::Structure(template), TagKind::Instruction(_)) => {
                let member = template.member(name)?;
                Some((member.offset as usize, 1 << member.bit?))
            }
            _ => None,
        }
    }
}

fn put_bit(byte: &mut u8, mask: u8, on: bool) {
    *byte = if on { *byte | mask } else { *byte & !mask };
}

const ENABLE_IN: &str = "EnableIn";
const ENABLE_OUT: &str = "EnableOut";
