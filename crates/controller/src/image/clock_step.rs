//! The tag `ClockStep` of a machine on the step clock: it shows the tick, and a number written to it executes that number of ticks

use arcline_tag::{Elementary, TagType};

use super::{Image, TagId, TagKind, WriteEffect, WriteError};

/// Name of the tag.
pub const CLOCK_STEP_TAG: &str = "ClockStep";
/// Most ticks that one write executes.
pub const MOST_STEPS: u32 = 1_000_000;

impl Image {
    /// Adds the tag, if the name is free.
    pub fn add_clock_step(&mut self) {
        if self.find(CLOCK_STEP_TAG).is_none() {
            let tag_type = TagType::scalar(Elementary::Dint);
            self.clock_step = Some(self.add(CLOCK_STEP_TAG, tag_type, TagKind::ClockStep));
        }
    }

    /// Shows the tick, modulo 2^31.
    pub(super) fn show_clock(&mut self, tick: u64) {
        let Some(id) = self.clock_step else { return };
        if let Some(bytes) = self.bytes_mut(id) {
            bytes.copy_from_slice(&((tick & 0x7FFF_FFFF) as u32).to_le_bytes());
        }
    }

    /// Writes the tag.
    pub(super) fn write_clock_step(&mut self, id: TagId, data: &[u8]) -> Result<Option<WriteEffect>, WriteError> {
        let name = || self.tag(id).map(|tag| tag.name.clone()).unwrap_or_default();
        let Ok(bytes) = <[u8; 4]>::try_from(data) else {
            return Err(WriteError::ReadOnly { name: name() });
        };
        let ticks = i32::from_le_bytes(bytes);
        match u32::try_from(ticks) {
            Ok(ticks) if ticks <= MOST_STEPS => Ok(Some(WriteEffect::Steps(ticks))),
            _ => Err(WriteError::OutOfRange {
                name: name(),
                value: ticks as f32,
                low: 0.0,
                high: MOST_STEPS as f32,
            }),
        }
    }
}
