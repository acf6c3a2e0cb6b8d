//! Motion control tags: which slot of the controller shows where, and what a slot shows.

use arcline_instruction_set::{ControlSlot, MotionControl, predefined};
use arcline_tag::TagType;

use super::{ControlError, Image, MOTION_CONTROL, TagKind};
use crate::{CONTROL_SLOTS, UNNAMED};

impl Image {
    /// The slot of a motion control tag; a name that is not known yet becomes a MOTION_INSTRUCTION tag. The name
    /// of an instruction tag, or of its member `MotionControl`, is the slot of that member.
    ///
    /// # Errors
    /// A name of something else, a name that cannot be a tag's, or no slot left.
    pub fn control_slot(&mut self, name: &str) -> Result<ControlSlot, ControlError> {
        if let Some(slot) = self.known_control(name)? {
            return Ok(slot);
        }
        let mut letters = name.chars();
        let starts = letters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
        if !starts || !letters.all(|c| c.is_ascii_alphanumeric() || c == '_') || name.len() > MAX_NAME {
            return Err(ControlError::NotAName {
                name: name.chars().take(MAX_NAME).collect(),
            });
        }
        let slot = self.free_slot().ok_or(ControlError::NoRoom)?;
        let id = self.add(
            name,
            TagType::scalar(predefined::motion_instruction()),
            TagKind::MotionControl(slot),
        );
        self.controls.push((id, 0));
        Ok(slot)
    }

    /// The slot of a motion control tag that exists.
    ///
    /// # Errors
    /// A name of something else.
    pub fn known_control(&self, name: &str) -> Result<Option<ControlSlot>, ControlError> {
        let (first, member) = name
            .split_once('.')
            .map_or((name, None), |(first, rest)| (first, Some(rest)));
        let wrong = || ControlError::NotAMotionControl { name: name.to_owned() };
        match (self.find(first).map(|tag| tag.kind), member) {
            (None, None) => Ok(None),
            (Some(TagKind::MotionControl(slot)), None) => Ok(Some(slot)),
            (Some(TagKind::Instruction(kind)), None) => Ok(Some(kind.control)),
            (Some(TagKind::Instruction(kind)), Some(member)) if member.eq_ignore_ascii_case(MOTION_CONTROL) => {
                Ok(Some(kind.control))
            }
            _ => Err(wrong()),
        }
    }

    /// The name of the tag that shows a slot; empty for the unnamed one.
    pub fn control_name(&self, slot: ControlSlot) -> &str {
        let tag = self.controls.get(slot.0 as usize).and_then(|(id, _)| self.tag(*id));
        tag.map_or("", |tag| &tag.name)
    }

    /// What a slot shows.
    pub fn control(&self, slot: ControlSlot) -> MotionControl {
        let place = self.controls.get(slot.0 as usize);
        let bytes = place.and_then(|(id, offset)| self.bytes(*id).get(*offset..)?.first_chunk());
        bytes.map_or_else(MotionControl::default, |bytes| MotionControl::from_bytes(*bytes))
    }

    /// Makes a slot show something.
    pub fn set_control(&mut self, slot: ControlSlot, control: MotionControl) {
        let Some((id, offset)) = self.controls.get(slot.0 as usize).copied() else {
            return;
        };
        if let Some(place) = self
            .bytes_mut(id)
            .and_then(|bytes| bytes.get_mut(offset..offset + MotionControl::SIZE))
        {
            place.copy_from_slice(&control.to_bytes());
        }
    }

    pub(super) fn free_slot(&self) -> Option<ControlSlot> {
        let next = self.controls.len();
        (next < CONTROL_SLOTS && next as u32 != UNNAMED.0).then_some(ControlSlot(next as u32))
    }
}

/// Longest name of a tag that a client may create, characters.
const MAX_NAME: usize = 40;
