//! The tag `ContourRests`: CONTOUR_RESTS, an element for each coordinate system in configuration order. Read-only: the controller counts.

use arcline_instruction_set::predefined;
use arcline_motion::SystemSnapshot;
use arcline_tag::TagType;

use super::{Image, TagKind};
use crate::Snapshot;
use crate::machine::Machine;

/// Name of the tag.
pub const CONTOUR_RESTS_TAG: &str = "ContourRests";
/// Bytes of an element: Starved and Unplanned, DINT.
const SIZE: usize = 8;

impl Image {
    /// Adds the tag, if there are coordinate systems and the name is free.
    pub(super) fn add_contour_rests(&mut self, machine: &Machine) {
        let systems = machine.systems.len() as u32;
        if systems > 0 && self.find(CONTOUR_RESTS_TAG).is_none() {
            let tag_type = TagType::array(predefined::contour_rests(), systems);
            self.add(CONTOUR_RESTS_TAG, tag_type, TagKind::ContourRests);
        }
    }

    /// Shows the counters of a snapshot.
    pub(super) fn show_contour_rests(&mut self, snapshot: &Snapshot) {
        let Some(row) = self.tags.iter().position(|tag| tag.kind == TagKind::ContourRests) else {
            return;
        };
        let numbers = |system: &SystemSnapshot| {
            let rests = system.contour_rests;
            let mut element = [0; SIZE];
            let (starved, unplanned) = element.split_at_mut(SIZE / 2);
            starved.copy_from_slice(&rests.starved.to_le_bytes());
            unplanned.copy_from_slice(&rests.unplanned.to_le_bytes());
            element
        };
        let shown: Vec<u8> = snapshot.systems.iter().flat_map(numbers).collect();
        // A write would stop the sharing of the tag's memory.
        if self.bytes.get(row).is_some_and(|bytes| bytes != shown.as_slice())
            && let Some(bytes) = self.bytes.get_mut(row).filter(|bytes| bytes.len() == shown.len())
        {
            bytes.copy_from_slice(&shown);
        }
    }
}
