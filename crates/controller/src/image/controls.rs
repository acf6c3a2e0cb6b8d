//! Motion control tags: which slot of the controller shows where, and what a slot shows.

use arcline_instruction_set::{ControlSlot, Ending, Flag, MotionControl, predefined};
use arcline_tag::TagType;

use super::{ControlError, Image, MOTION_CONTROL, TagId, TagKind, is_tag_name};
use crate::machine::Machine;
use crate::{CONTROL_SLOTS, Cause, UNNAMED};

impl Image {
    /// The slot of a motion control tag; a name that is not known yet becomes a MOTION_INSTRUCTION tag. The name
    /// of an instruction tag, or of its member `MotionControl`, is the slot of that member.
    ///
    /// When every slot is in use, the new tag takes the place of the motion control tag that has not been named by an instruction
    /// for the longest time and whose own instruction has ended; tags of instructions in process and of the configuration stay.
    ///
    /// # Errors
    /// A name of something else, a name that cannot be a tag's, or every slot has an instruction in process.
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

    /// Removes the idle motion control tag whose last use is the oldest. Its slot is free then.
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

    /// Notes that an instruction names a slot.
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
        if let Some(path) = self.placed_name(slot) {
            return path;
        }
        let tag = self.controls.get(slot.0 as usize).and_then(|(id, _)| self.tag(*id));
        tag.map_or("", |tag| &tag.name)
    }

    /// What a slot shows.
    pub fn control(&self, slot: ControlSlot) -> MotionControl {
        let index = self.controls.get(slot.0 as usize);
        let bytes = index.and_then(|(id, offset)| self.bytes(*id).get(*offset..)?.first_chunk());
        bytes.map_or_else(MotionControl::default, |bytes| MotionControl::from_bytes(*bytes))
    }

    /// Makes a slot show something.
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

    /// The cause that ended an instruction, with its names; `None`: the instruction ended by itself.
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
        // One whose tag has gone may still hear of its last instruction: only when there is no other.
        new.or_else(|| self.table.spare_slots.first().copied().map(ControlSlot))
    }

    /// Makes a slot that [`Image::free_slot`] gave show at an offset of a tag.
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

/// Whether the instruction of a tag goes on, or is not answered yet.
fn is_in_process(control: &MotionControl) -> bool {
    let answered = control.has(Flag::Dn) || control.has(Flag::Er);
    control.has(Flag::Ip) || control.has(Flag::En) && !answered
}

/// Of a name that is none, what is shown, characters.
const MAX_NAME: usize = 40;
