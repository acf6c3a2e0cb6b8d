//! The tag memory: every tag of a running machine by name and permanent instance id, as bytes on the wire.
//!
//! Synchronous and without I/O. It is refreshed from outside with snapshots, events and the real-time thread's
//! health ([`Image::apply_snapshot`], [`Image::apply_event`], [`Image::apply_health`]); whoever applies all events
//! up to a snapshot's tick together with the snapshot shows the positions and bits of one tick. It executes
//! nothing: a write of `EnableIn` gives an [`Edge`], and the caller makes a call of it ([`Image::call_of`]).
//!
//! All bytes are little-endian, offsets are bytes.

mod encode;
mod error;
mod feed_override;
mod health;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::Arc;

use arcline_instruction_set::{
    BindError, Call, ControlSlot, Directory, Mnemonic, MotionControl, Object, bind, instruction_tag_defaults,
    instruction_tag_given, instruction_tag_target, instruction_tag_template, predefined,
};
use arcline_tag::{
    DataType, Elementary, Location, PathError, PathSegment, TagPath, TagType, Template, Value, write_string,
};

use crate::machine::Machine;
use crate::{CONTROL_SLOTS, Event, Snapshot, UNNAMED};

pub use error::{ControlError, ReadError, WriteError};
pub use feed_override::{FEED_OVERRIDE_PERCENT, FEED_OVERRIDE_TAG};
pub use health::{Health, Measured, REAL_TIME_TAG};

/// Symbol instance id of a tag: from 1, never used for another tag while the process runs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct TagId(pub u32);

/// Who may write.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Access {
    /// Nobody but the controller.
    ReadOnly,
    /// Clients too, at least some members.
    ReadWrite,
}

/// What a tag stands for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TagKind {
    /// The motion group.
    MotionGroup,
    /// An axis, by its place in the machine.
    Axis(u16),
    /// A coordinate system, by its place in the machine.
    CoordinateSystem(u16),
    /// A MOTION_INSTRUCTION.
    MotionControl(ControlSlot),
    /// An instruction as a tag.
    Instruction(InstructionKind),
    /// Plain data.
    Plain,
    /// The health of the real-time thread.
    RealTime,
    /// The feed override of every coordinate system.
    FeedOverride,
}

/// The fixed part of an instruction tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct InstructionKind {
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// The slot that its member `MotionControl` shows.
    pub control: ControlSlot,
}

/// A tag.
#[derive(Clone, PartialEq, Debug)]
pub struct Tag {
    /// Its id.
    pub id: TagId,
    /// Its name as it was first spelled.
    pub name: String,
    /// Its type.
    pub tag_type: TagType,
    /// What it stands for.
    pub kind: TagKind,
}

impl Tag {
    /// Whether clients may write at least a part of it.
    pub fn access(&self) -> Access {
        match self.kind {
            TagKind::Instruction(_) | TagKind::Plain | TagKind::FeedOverride => Access::ReadWrite,
            _ => Access::ReadOnly,
        }
    }
}

/// An instruction tag to create.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct InstructionTag {
    /// Name of the tag.
    pub name: String,
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// First value of the member that names the target.
    pub target: String,
}

/// A plain tag to create.
#[derive(Clone, PartialEq, Debug)]
pub struct PlainTag {
    /// Name of the tag.
    pub name: String,
    /// Its type.
    pub tag_type: TagType,
}

/// A write that the controller is to know of: `EnableIn` of an instruction tag changed, or an override was written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Edge {
    /// False to true: the instruction executes.
    Rising(TagId),
    /// True to false.
    Falling(TagId),
    /// The tag `FeedOverride` was written: [`Image::feed_overrides`].
    FeedOverride,
}

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
}

/// Longest name of a tag that a client may create, characters.
const MAX_NAME: usize = 40;

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
            image.add(
                REAL_TIME_TAG,
                TagType::scalar(predefined::real_time()),
                TagKind::RealTime,
            );
        }
        image.add_feed_override(machine);
        image.add_template(&predefined::motion_instruction());
        image.initialise(machine);
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

    /// Where a path leads. A status bit of an instruction tag is found without naming `MotionControl`:
    /// `Move1.PC` is `Move1.MotionControl.PC`.
    ///
    /// # Errors
    /// [`ReadError::NoSuchTag`], or what the path's rest is wrong about.
    pub fn locate(&self, path: &TagPath) -> Result<(TagId, Location), ReadError> {
        let name = path.tag().ok_or(PathError::Empty)?;
        let tag = self
            .find(name)
            .ok_or_else(|| ReadError::NoSuchTag { name: name.to_owned() })?;
        Ok((tag.id, self.locate_in(tag, path.rest())?))
    }

    /// Where the segments behind a tag's name lead.
    ///
    /// # Errors
    /// Names the member, index or bit that does not exist.
    pub fn locate_in(&self, tag: &Tag, rest: &[PathSegment]) -> Result<Location, PathError> {
        let found = tag.tag_type.locate(rest);
        match (&found, tag.kind) {
            (Err(PathError::NoSuchMember { .. }), TagKind::Instruction(_)) => {
                let mut inner = vec![PathSegment::Symbol(MOTION_CONTROL.to_owned())];
                inner.extend_from_slice(rest);
                tag.tag_type.locate(&inner).or(found)
            }
            _ => found,
        }
    }

    /// The value at a path: of an array its first element from there on.
    ///
    /// # Errors
    /// [`ReadError::NotAValue`] for a structure, else see [`Image::locate`].
    pub fn read(&self, path: &TagPath) -> Result<Value, ReadError> {
        let (id, place) = self.locate(path)?;
        value_at(self.bytes(id), &place).ok_or_else(|| not_a_value(path, &place))
    }

    /// The numbers from a path to the end of its array.
    ///
    /// # Errors
    /// As [`Image::read`].
    pub fn read_numbers(&self, path: &TagPath) -> Result<Vec<f64>, ReadError> {
        let (id, place) = self.locate(path)?;
        let DataType::Elementary(kind) = place.data_type else {
            return Err(not_a_value(path, &place));
        };
        if place.bit.is_some() {
            let value = value_at(self.bytes(id), &place).ok_or_else(|| not_a_value(path, &place))?;
            return Ok(vec![value.as_f64()]);
        }
        let bytes = self.bytes(id).get(place.offset..).unwrap_or_default();
        let elements = bytes.chunks_exact(kind.size()).take(place.elements as usize);
        Ok(elements
            .filter_map(|bytes| Value::read(kind, bytes))
            .map(Value::as_f64)
            .collect())
    }

    /// Whether clients may write these bytes of a tag.
    pub fn writable(&self, id: TagId, offset: usize, len: usize) -> bool {
        let end = offset.saturating_add(len);
        let Some(tag) = self.tag(id) else { return false };
        if end > self.bytes(id).len() {
            return false;
        }
        match tag.kind {
            TagKind::Plain | TagKind::FeedOverride => true,
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
                // The host byte of EnableIn holds EnableOut too: it is written bit by bit.
                !overlaps(MOTION_CONTROL) && !overlaps(ENABLE_OUT)
            }
            TagKind::Axis(_) => {
                // "Settable" on its page, and the only such member.
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
    /// Nothing is written when there is no such tag, or a byte of it is beyond its end or read-only.
    pub fn write(&mut self, id: TagId, offset: usize, data: &[u8]) -> Result<Option<Edge>, WriteError> {
        self.check_write(id, offset, data.len())?;
        if self.tag(id).is_some_and(|tag| tag.kind == TagKind::FeedOverride) {
            return self.write_feed_override(id, offset, data);
        }
        if let Some(bytes) = self.bytes_mut(id) {
            bytes[offset..offset + data.len()].copy_from_slice(data);
        }
        Ok(None)
    }

    /// Writes a bit of a tag: a BOOL member, or bit 0 to 63 of an integer at `offset`.
    ///
    /// # Errors
    /// As [`Image::write`].
    pub fn write_bit(&mut self, id: TagId, offset: usize, bit: u8, on: bool) -> Result<Option<Edge>, WriteError> {
        let (offset, mask) = (offset + usize::from(bit / 8), 1u8 << (bit % 8));
        let enable = self.enable_in(id).filter(|enable| *enable == (offset, mask));
        if enable.is_none() {
            self.check_write(id, offset, 1)?;
        }
        if let Some(tag) = self.tag(id).filter(|tag| tag.kind == TagKind::FeedOverride) {
            // A REAL has no bits.
            return Err(WriteError::ReadOnly { name: tag.name.clone() });
        }
        let out = self.member_bit(id, ENABLE_OUT);
        let Some(bytes) = self.bytes_mut(id) else {
            return Err(WriteError::NoSuchTag);
        };
        let before = bytes[offset] & mask != 0;
        put_bit(&mut bytes[offset], mask, on);
        if enable.is_none() {
            return Ok(None);
        }
        if let Some((offset, mask)) = out {
            put_bit(&mut bytes[offset], mask, on);
        }
        Ok(match (before, on) {
            (false, true) => Some(Edge::Rising(id)),
            (true, false) => Some(Edge::Falling(id)),
            _ => None,
        })
    }

    /// Writes a value at a path, converted to the type that is there.
    ///
    /// # Errors
    /// As [`Image::locate`] and [`Image::write`].
    pub fn write_value(&mut self, path: &TagPath, value: Value) -> Result<Option<Edge>, WriteError> {
        let (id, place) = self.locate(path)?;
        if let Some(bit) = place.bit {
            return self.write_bit(id, place.offset, bit, value.as_bool());
        }
        let DataType::Elementary(kind) = place.data_type else {
            return Err(not_a_value(path, &place).into());
        };
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..kind.size()];
        value.convert(kind).write(bytes);
        self.write(id, place.offset, bytes)
    }

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

    /// The instruction of an instruction tag with the target and operands that it holds now. A target that does
    /// not exist gives a call without one, which errs with 13, 0 as it does from everywhere.
    ///
    /// # Errors
    /// A name among the operands that means nothing. `None`: not an instruction tag.
    pub fn call_of(&self, id: TagId) -> Option<Result<Call, BindError>> {
        let tag = self.tag(id)?;
        let TagKind::Instruction(kind) = tag.kind else {
            return None;
        };
        let bytes = self.bytes(id);
        let target = instruction_tag_target(kind.mnemonic, bytes);
        let target = self.object(kind.mnemonic.instruction().object, &target);
        let given = instruction_tag_given(kind.mnemonic, &tag.name, bytes);
        Some(bind(kind.mnemonic, target, kind.control, &given, self))
    }

    /// Takes over what happened to an instruction.
    pub fn apply_event(&mut self, event: &Event) {
        if !event.owner || event.control == UNNAMED {
            return;
        }
        let mut control = self.control(event.control);
        control.flags = (control.flags & !event.clear) | event.set;
        control.err = event.err;
        control.exerr = event.exerr;
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

    /// Where a REAL array that an instruction writes stands: `tag` is what [`Directory::real_array`] gave.
    /// Tag, byte offset and number of elements.
    pub fn written_array(&self, tag: u32) -> Option<(TagId, usize, usize)> {
        let (id, offset) = (TagId(tag >> 16), (tag & 0xFFFF) as usize * 4);
        let tag = self.tag(id)?;
        let end = match &tag.tag_type.data_type {
            DataType::Structure(template) => {
                let member = template.members.iter().find(|member| {
                    let from = member.offset as usize;
                    (from..from + member.size()).contains(&offset) && member.dimension > 0
                })?;
                member.offset as usize + member.size()
            }
            DataType::Elementary(_) => tag.tag_type.size(),
        };
        Some((id, offset, end.checked_sub(offset)? / 4))
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

    /// The tag of the overrides, where there is something to override and the name is free.
    fn add_feed_override(&mut self, machine: &Machine) {
        let systems = machine.systems.len() as u32;
        if systems == 0 || self.find(FEED_OVERRIDE_TAG).is_some() {
            return;
        }
        let tag_type = TagType::array(DataType::Elementary(Elementary::Real), systems);
        let id = self.add(FEED_OVERRIDE_TAG, tag_type, TagKind::FeedOverride);
        if let Some(bytes) = self.bytes_mut(id) {
            bytes
                .chunks_exact_mut(4)
                .for_each(|element| element.copy_from_slice(&feed_override::AS_PROGRAMMED.to_le_bytes()));
        }
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

    /// Members that never change, and the default of the settable one.
    fn initialise(&mut self, machine: &Machine) {
        self.encoder.constants(machine, &mut self.bytes);
    }

    fn free_slot(&self) -> Option<ControlSlot> {
        let next = self.controls.len();
        (next < CONTROL_SLOTS && next as u32 != UNNAMED.0).then_some(ControlSlot(next as u32))
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

    fn check_write(&self, id: TagId, offset: usize, len: usize) -> Result<(), WriteError> {
        let size = self.bytes(id).len();
        let tag = self.tag(id).ok_or(WriteError::NoSuchTag)?;
        if offset.saturating_add(len) > size {
            return Err(WriteError::BeyondEnd {
                name: tag.name.clone(),
                size,
            });
        }
        if !self.writable(id, offset, len) {
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

impl Directory for Image {
    fn object(&self, object: Object, name: &str) -> Option<u16> {
        match (self.find(name)?.kind, object) {
            (TagKind::MotionGroup, Object::MotionGroup) => Some(0),
            (TagKind::Axis(place), Object::Axis) | (TagKind::CoordinateSystem(place), Object::CoordinateSystem) => {
                Some(place)
            }
            _ => None,
        }
    }

    fn real_array(&self, name: &str) -> Option<u32> {
        let (id, place) = self.locate(&name.parse().ok()?).ok()?;
        let offset = u32::try_from(place.offset / 4)
            .ok()
            .filter(|offset| *offset <= 0xFFFF)?;
        let real = place.data_type == DataType::Elementary(Elementary::Real) && place.bit.is_none();
        let for_instructions = self.tag(id)?.kind != TagKind::FeedOverride;
        let writable = for_instructions && self.writable(id, place.offset, 4 * place.elements as usize);
        (real && writable && id.0 <= 0xFFFF).then_some(id.0 << 16 | offset)
    }
}

fn index(id: TagId) -> Option<usize> {
    (id.0 as usize).checked_sub(1)
}

fn put_bit(byte: &mut u8, mask: u8, on: bool) {
    *byte = if on { *byte | mask } else { *byte & !mask };
}

fn value_at(bytes: &[u8], place: &Location) -> Option<Value> {
    let DataType::Elementary(kind) = place.data_type else {
        return None;
    };
    if let Some(bit) = place.bit {
        let byte = bytes.get(place.offset + usize::from(bit / 8))?;
        return Some(Value::Bool(byte & 1 << (bit % 8) != 0));
    }
    Value::read(kind, bytes.get(place.offset..)?)
}

fn not_a_value(path: &TagPath, place: &Location) -> ReadError {
    ReadError::NotAValue {
        path: path.to_string(),
        data_type: place.data_type.name().to_owned(),
    }
}

const MOTION_CONTROL: &str = "MotionControl";
const ENABLE_IN: &str = "EnableIn";
const ENABLE_OUT: &str = "EnableOut";
