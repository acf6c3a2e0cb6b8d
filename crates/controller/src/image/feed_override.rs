//! The tag `FeedOverride`: REAL, an element for each coordinate system in configuration order, in percent.
//!
//! The tag is the only copy of an override outside the controller: every interface that sets one writes it, and the caller sends the
//! controller the change ([`WriteEffect::FeedOverride`]).

use arcline_instruction_set::SystemId;
use arcline_tag::{DataType, Elementary, TagType};

use super::{Image, TagId, TagKind, WriteEffect, WriteError};
use crate::machine::Machine;

/// Name of the tag.
pub const FEED_OVERRIDE_TAG: &str = "FeedOverride";
/// The range of an override, percent.
pub const FEED_OVERRIDE_PERCENT: std::ops::RangeInclusive<f32> = 0.0..=200.0;
/// The first value: as programmed.
pub(super) const AS_PROGRAMMED: f32 = 100.0;
/// Bytes of an element.
const SIZE: usize = 4;

impl Image {
    /// The override of every coordinate system, in percent, in configuration order.
    pub fn feed_overrides(&self) -> impl Iterator<Item = f32> {
        let tag = self.tags().iter().find(|tag| tag.kind == TagKind::FeedOverride);
        elements(tag.map_or(&[], |tag| self.bytes(tag.id)))
    }

    /// The last override of a coordinate system that was not 0, in percent, to which it returns when it resumes.
    pub fn feed_override_before_hold(&self, system: SystemId) -> Option<f32> {
        self.before_hold.get(usize::from(system)).copied()
    }

    /// Sets the override of a coordinate system, in percent.
    ///
    /// # Errors
    /// [`WriteError::OutOfRange`] outside of 0 to 200; [`WriteError::NoSuchTag`] if the system does not exist.
    pub fn set_feed_override(&mut self, system: SystemId, percent: f32) -> Result<Option<WriteEffect>, WriteError> {
        let tag = self.tags().iter().find(|tag| tag.kind == TagKind::FeedOverride);
        let id = tag.ok_or(WriteError::NoSuchTag)?.id;
        self.write(id, SIZE * usize::from(system), &percent.to_le_bytes())
    }

    /// Adds the tag of the overrides, if there are coordinate systems and the name is free.
    pub(super) fn add_feed_override(&mut self, machine: &Machine) {
        let systems = machine.systems.len() as u32;
        if systems == 0 || self.find(FEED_OVERRIDE_TAG).is_some() {
            return;
        }
        let tag_type = TagType::array(DataType::Elementary(Elementary::Real), systems);
        let id = self.add(FEED_OVERRIDE_TAG, tag_type, TagKind::FeedOverride);
        if let Some(bytes) = self.bytes_mut(id) {
            bytes
                .chunks_exact_mut(SIZE)
                .for_each(|element| element.copy_from_slice(&AS_PROGRAMMED.to_le_bytes()));
        }
    }

    /// Writes bytes of the tag, if every element is then in range.
    pub(super) fn write_feed_override(
        &mut self,
        id: TagId,
        offset: usize,
        data: &[u8],
    ) -> Result<Option<WriteEffect>, WriteError> {
        let mut next = self.bytes(id).to_vec();
        if let Some(bytes) = next.get_mut(offset..offset.saturating_add(data.len())) {
            bytes.copy_from_slice(data);
        }
        if let Some(value) = elements(&next).find(|value| !FEED_OVERRIDE_PERCENT.contains(value)) {
            return Err(WriteError::OutOfRange {
                name: FEED_OVERRIDE_TAG.to_owned(),
                value,
                low: *FEED_OVERRIDE_PERCENT.start(),
                high: *FEED_OVERRIDE_PERCENT.end(),
            });
        }
        for (kept, value) in self.before_hold.iter_mut().zip(elements(&next)) {
            if value > 0.0 {
                *kept = value;
            }
        }
        if let Some(bytes) = self.bytes_mut(id) {
            bytes.copy_from_slice(&next);
        }
        Ok(Some(WriteEffect::FeedOverride))
    }
}

fn elements(bytes: &[u8]) -> impl Iterator<Item = f32> {
    bytes
        .chunks_exact(SIZE)
        .filter_map(|bytes| bytes.first_chunk().copied().map(f32::from_le_bytes))
}
