//! The tag memory: every tag of a running machine by name and permanent instance id, as bytes on the wire.
//!
//! Synchronous and without I/O. It is refreshed from outside with snapshots, events and the real-time thread's
//! health ([`Image::apply_snapshot`], [`Image::apply_event`], [`Image::apply_health`]); whoever applies all events
//! up to a snapshot's tick together with the snapshot shows the positions and bits of one tick. It executes
//! nothing: a write of `EnableIn` gives an [`Edge`], and the caller makes a call of it ([`Image::call_of`]).
//!
//! All bytes are little-endian, offsets are bytes.

mod calls;
mod controls;
mod encode;
mod error;
mod feed_override;
mod health;
mod read;
mod tag;
#[cfg(test)]
mod tests;
mod write;
mod written;

use std::collections::BTreeMap;
use std::sync::Arc;

use arcline_instruction_set::{instruction_tag_defaults, instruction_tag_template, predefined};
use arcline_tag::{DataType, TagType, Template, write_string};

use crate::machine::Machine;
use crate::{Event, Snapshot, UNNAMED};

pub use error::{ControlError, ReadError, WriteError};
pub use feed_override::{FEED_OVERRIDE_PERCENT, FEED_OVERRIDE_TAG};
pub use health::{Health, Measured, REAL_TIME_TAG};
pub use tag::{Access, Edge, InstructionKind, InstructionTag, PlainTag, Tag, TagId, TagKind};
pub use written::Written;

/// Every tag of a machine.
#[derive(Clone, Debug)]
pub struct Image {
    tags: Vec<Tag>,
    bytes: Vec<Vec<u8>>,
    names: BTreeMap<String, TagId>,
    templates: BTreeMap<u16, Arc<Template>>,
    /// Where the MOTION_INSTRUCTION of a slot stands: tag and offset.
    controls: Vec<(TagId, usize)>,
    encoder: encode::Encoder,
    snapshot_tick: u64,
    /// The last override of each coordinate system that was not 0, percent.
    before_hold: Vec<f32>,
    /// Parts of plain tags that were written; `None`: nobody wants to know.
    written: Option<Vec<Written>>,
}

impl Image {
    /// The tags of a machine, at their first values. Names are unique (the configuration saw to that); of two
    /// equal ones the first is found.
    pub fn new(machine: &Machine, instruction_tags: &[InstructionTag], plain_tags: &[PlainTag]) -> Self {
        let mut image = Image {
            tags: Vec::new(),
            bytes: Vec::new(),
            names: BTreeMap::new(),
            templates: BTreeMap::new(),
            controls: Vec::new(),
            encoder: encode::Encoder::new(machine),
            snapshot_tick: 0,
            before_hold: vec![feed_override::AS_PROGRAMMED; machine.systems.len()],
            written: None,
        };
        image.add(
            &machine.group,
            TagType::scalar(predefined::motion_group()),
            TagKind::MotionGroup,
        );
        for (place, axis) in (0..).zip(&machine.axes) {
            let template = if axis.is_virtual() {
                predefined::axis_virtual()
            } else {
                predefined::axis_cip_drive()
            };
            image.add(&axis.name, TagType::scalar(template), TagKind::Axis(place));
        }
        for (place, system) in (0..).zip(&machine.systems) {
            let template = predefined::coordinate_system();
            image.add(
                &system.name,
                TagType::scalar(template),
                TagKind::CoordinateSystem(place),
            );
        }
        for tag in instruction_tags {
            image.add_instruction(tag);
        }
        for tag in plain_tags {
            image.add(&tag.name, tag.tag_type.clone(), TagKind::Plain);
        }
        if image.find(REAL_TIME_TAG).is_none() {
            let id = image.add(
                REAL_TIME_TAG,
                TagType::scalar(predefined::real_time()),
                TagKind::RealTime,
            );
            if let Some(bytes) = image.bytes_mut(id) {
                health::encode_period(machine, bytes);
            }
        }
        image.add_feed_override(machine);
        image.add_template(&predefined::motion_instruction());
        image.encoder.constants(machine, &mut image.bytes);
        image.apply_snapshot(&Snapshot::new(machine));
        image
    }

    /// Every tag, by ascending id.
    pub fn tags(&self) -> &[Tag] {
        &self.tags
    }

    /// The tag of that name, case ignored.
    pub fn find(&self, name: &str) -> Option<&Tag> {
        self.tag(*self.names.get(&name.to_ascii_lowercase())?)
    }

    /// The tag of that id.
    pub fn tag(&self, id: TagId) -> Option<&Tag> {
        self.tags.get(index(id)?)
    }

    /// The bytes of a tag; empty when there is none of that id.
    pub fn bytes(&self, id: TagId) -> &[u8] {
        index(id)
            .and_then(|place| self.bytes.get(place))
            .map_or(&[], Vec::as_slice)
    }

    /// The structure types in use, by ascending template instance id.
    pub fn templates(&self) -> impl Iterator<Item = &Arc<Template>> {
        self.templates.values()
    }

    /// The structure type of a template instance id.
    pub fn template(&self, instance: u16) -> Option<Arc<Template>> {
        self.templates.get(&instance).cloned()
    }

    /// The tick of the newest snapshot that was applied.
    pub fn snapshot_tick(&self) -> u64 {
        self.snapshot_tick
    }

    /// Takes over what happened to an instruction.
    pub fn apply_event(&mut self, event: &Event) {
        if !event.owner || event.control == UNNAMED {
            return;
        }
        let mut control = self.control(event.control);
        event.apply(&mut control);
        self.set_control(event.control, control);
    }

    /// Takes over the state of axes, coordinate systems and group at one tick.
    pub fn apply_snapshot(&mut self, snapshot: &Snapshot) {
        self.snapshot_tick = snapshot.tick;
        self.encoder.snapshot(snapshot, &mut self.bytes);
    }

    /// Takes over the real-time thread's health, into its own tag and the group's Task members.
    pub fn apply_health(&mut self, health: &Health) {
        self.encoder.health(health, &mut self.bytes);
        let real_time = self.tags.iter().position(|tag| tag.kind == TagKind::RealTime);
        if let Some(bytes) = real_time.and_then(|place| self.bytes.get_mut(place)) {
            health.encode(bytes);
        }
    }

    fn add(&mut self, name: &str, tag_type: TagType, kind: TagKind) -> TagId {
        let id = TagId(self.tags.len() as u32 + 1);
        if let DataType::Structure(template) = &tag_type.data_type {
            self.add_template(template);
        }
        self.bytes.push(vec![0; tag_type.size()]);
        self.names.entry(name.to_ascii_lowercase()).or_insert(id);
        self.tags.push(Tag {
            id,
            name: name.to_owned(),
            tag_type,
            kind,
        });
        id
    }

    fn add_instruction(&mut self, tag: &InstructionTag) {
        let Some(control) = self.free_slot() else { return };
        let template = instruction_tag_template(tag.mnemonic);
        let place = template
            .member(MOTION_CONTROL)
            .map_or(0, |member| member.offset as usize);
        let target = template
            .member(tag.mnemonic.instruction().object.member())
            .map(|member| member.offset as usize);
        let kind = TagKind::Instruction(InstructionKind {
            mnemonic: tag.mnemonic,
            control,
        });
        let id = self.add(&tag.name, TagType::scalar(template), kind);
        self.controls.push((id, place));
        if let Some(bytes) = self.bytes_mut(id) {
            let first = instruction_tag_defaults(tag.mnemonic);
            let len = first.len().min(bytes.len());
            bytes[..len].copy_from_slice(&first[..len]);
            if let Some(bytes) = target.and_then(|target| bytes.get_mut(target..)) {
                // A name longer than a STRING cannot be configured.
                let _ = write_string(bytes, &tag.target);
            }
        }
    }

    fn add_template(&mut self, template: &Arc<Template>) {
        for member in &template.members {
            if let DataType::Structure(inner) = &member.data_type {
                self.add_template(inner);
            }
        }
        self.templates
            .entry(template.instance)
            .or_insert_with(|| template.clone());
    }

    fn bytes_mut(&mut self, id: TagId) -> Option<&mut Vec<u8>> {
        self.bytes.get_mut(index(id)?)
    }
}

fn index(id: TagId) -> Option<usize> {
    (id.0 as usize).checked_sub(1)
}

const MOTION_CONTROL: &str = "MotionControl";
