//! Motion control tags: the tag of each slot of the controller, and the status of a slot.

use arcline_instruction_set::{ControlSlot, Ending, Flag, MotionControl, predefined};
use arcline_tag::TagType;

use super::{ControlError, Image, MOTION_CONTROL, TagId, TagKind, is_tag_name};
use crate::machine::Machine;
use crate::{CONTROL_SLOTS, Cause, UNNAMED};

impl Image {
    /// The slot of a motion control tag; for an unknown name the image adds a MOTION_INSTRUCTION tag. The name of an instruction tag,
    /// or of its member `MotionControl`, is the slot of that member.
    ///
    /// If every slot is in use, the new tag replaces the motion control tag whose instruction has ended and that instructions have
    /// not named for the longest time; tags of instructions in process and of the configuration stay.
    ///
    /// # Errors
    /// A name of another type of tag, a name that is no tag name, or an instruction in process in every slot.
    pub fn control_slot(&mut self, name: &str) -> Result<ControlSlot, ControlError> {
        if let Some(slot) = self.known_control(name)? {
            self.note_use(slot);
            return Ok(slot);
        }
        if !is_tag_name(name) {
            return Err(ControlError::NotAName {
                name: name.chars().take(MAX_NAME).collect(),
            });
        }
        let slot = match self.free_slot() {
            Some(slot) => slot,
            None => self.reclaim_slot().ok_or(ControlError::NoRoom)?,
        };
        let id = self.add(
            name,
            TagType::scalar(predefined::motion_instruction()),
            TagKind::MotionControl(slot),
        );
        self.use_slot(slot, id, 0);
        self.note_use(slot);
        Ok(slot)
    }

    /// Removes the idle motion control tag whose last use is the oldest. Its slot is then free.
    fn reclaim_slot(&mut self) -> Option<ControlSlot> {
        let idle = self.tags.iter().filter_map(|tag| match tag.kind {
            TagKind::MotionControl(_) if self.table.configured_controls.contains(&tag.id) => None,
            TagKind::MotionControl(slot) if !is_in_process(&self.control(slot)) => Some((slot, tag.id)),
            _ => None,
        });
        let last_use = |slot: ControlSlot| self.last_uses.get(slot.0 as usize).copied().unwrap_or_default();
        let (slot, id) = idle.min_by_key(|(slot, _)| last_use(*slot))?;
        self.remove(id);
        Some(slot)
    }

    /// Records the use of a slot by an instruction.
    fn note_use(&mut self, slot: ControlSlot) {
        self.uses += 1;
        let index = slot.0 as usize;
        if self.last_uses.len() <= index {
            self.last_uses.resize(index + 1, 0);
        }
        self.last_uses[index] = self.uses;
    }

    /// The slot of a motion control tag that exists.
    ///
    /// # Errors
    /// A name of another type of tag.
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
        if let Some(path) = self.placed_name(slot) {
            return path;
        }
        let tag = self.controls.get(slot.0 as usize).and_then(|(id, _)| self.tag(*id));
        tag.map_or("", |tag| &tag.name)
    }

    /// The status in a slot.
    pub fn control(&self, slot: ControlSlot) -> MotionControl {
        let index = self.controls.get(slot.0 as usize);
        let bytes = index.and_then(|(id, offset)| self.bytes(*id).get(*offset..)?.first_chunk());
        bytes.map_or_else(MotionControl::default, |bytes| MotionControl::from_bytes(*bytes))
    }

    /// Sets the status in a slot.
    pub fn set_control(&mut self, slot: ControlSlot, control: MotionControl) {
        let Some((id, offset)) = self.controls.get(slot.0 as usize).copied() else {
            return;
        };
        if let Some(index) = self
            .bytes_mut(id)
            .and_then(|bytes| bytes.get_mut(offset..offset + MotionControl::SIZE))
        {
            index.copy_from_slice(&control.to_bytes());
        }
    }

    /// The cause that ended an instruction, with its names; `None` if the instruction ended on its own.
    pub fn ending(&self, machine: &Machine, cause: Cause) -> Option<Ending> {
        Some(match cause {
            Cause::Itself => return None,
            Cause::Instruction { control, mnemonic, .. } => Ending::Instruction {
                mnemonic,
                tag: self.control_name(control).to_owned(),
            },
            Cause::Fault { axis, faults } => Ending::Fault {
                axis: machine.axes.get(usize::from(axis))?.name.clone(),
                faults,
            },
            Cause::StopAll => Ending::StopAll,
            Cause::Jog(why) => Ending::Jog(why),
        })
    }

    pub(super) fn free_slot(&self) -> Option<ControlSlot> {
        let next = self.controls.len();
        let new = (next < CONTROL_SLOTS && next as u32 != UNNAMED.0).then_some(ControlSlot(next as u32));
        // Late events of a removed tag may still arrive for its slot, so it is the last choice.
        new.or_else(|| self.table.spare_slots.first().copied().map(ControlSlot))
    }

    /// Assigns a slot of [`Image::free_slot`] to an offset of a tag.
    pub(super) fn use_slot(&mut self, slot: ControlSlot, id: TagId, offset: usize) {
        match self.controls.get_mut(slot.0 as usize) {
            Some(index) => {
                *index = (id, offset);
                self.table.spare_slots.retain(|spare| *spare != slot.0);
            }
            None => self.controls.push((id, offset)),
        }
    }
}

/// The instruction of a tag is in process, or is not answered yet.
fn is_in_process(control: &MotionControl) -> bool {
    let answered = control.has(Flag::Dn) || control.has(Flag::Er);
    control.has(Flag::Ip) || control.has(Flag::En) && !answered
}

/// Characters that are shown of an invalid name.
const MAX_NAME: usize = 40;
