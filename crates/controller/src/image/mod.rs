//! The tag memory: every tag of a running machine by name and permanent instance id, as bytes on the wire.
//!
//! Synchronous and without I/O. Its owner updates it with snapshots, events and the real-time thread's health ([`Image::apply_snapshot`],
//! [`Image::apply_event`], [`Image::apply_health`]); an owner that applies all events up to a snapshot's tick together with the snapshot gets the
//! positions and bits of one tick. It executes nothing: a write to `EnableIn` gives a [`WriteEffect`], from which the caller makes a call
//! ([`Image::call_of`]).
//!
//! All bytes are little-endian, offsets are bytes.

mod attributes;
mod calls;
mod cam_tags;
mod cams;
mod changes;
mod clock_step;
mod contour_rests;
mod controls;
mod encode;
mod error;
mod fault_inject;
mod feed_override;
mod health;
mod inputs;
mod motion_inhibit;
mod names;
mod outputs;
mod program;
mod read;
mod shared;
mod structures;
mod table;
mod tag;
#[cfg(test)]
mod tests;
mod write;
mod write_rule;
mod written;

use std::collections::BTreeMap;
use std::sync::Arc;

use arcline_instruction_set::{
    AxisId, FaultSet, SystemId, instruction_tag_defaults, instruction_tag_template, predefined,
};
use arcline_motion::AxisSet;
use arcline_tag::{DataType, Elementary, TagType, Template, write_string};

use crate::machine::Machine;
use crate::{Event, Snapshot, UNNAMED};

use shared::{Memory, Shared, Unshared};

pub use attributes::MoveProgress;
pub use cams::StagedWrites;
pub use clock_step::{CLOCK_STEP_TAG, MOST_STEPS};
pub use contour_rests::CONTOUR_RESTS_TAG;
pub use error::{ControlError, ReadError, WriteError};
pub use fault_inject::FAULT_INJECT_TAG;
pub use feed_override::{FEED_OVERRIDE_PERCENT, FEED_OVERRIDE_TAG};
pub use health::{Health, MeasuredTime, REAL_TIME_TAG};
pub use motion_inhibit::MOTION_INHIBIT_TAG;
pub use program::{ChangedPart, ForeignChanges, ProjectPart};
pub use table::{ConfiguredTags, MAX_PLAIN_BYTES, MAX_PLAIN_TAGS, TableError, is_tag_name};
pub use tag::{Access, AliasTarget, InstructionKind, InstructionTag, PlainTag, Tag, TagId, TagKind, WriteEffect};
pub use write_rule::{NumberRange, WriteRule, Writers};
pub use written::WrittenPart;

/// The number of instructions for which the controller has room: a write to `EnableIn` beyond that is refused.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CallRoom {
    /// Instructions of any kind.
    pub calls: usize,
    /// Instructions that only stop or disable.
    pub stops: usize,
}

impl Default for CallRoom {
    /// Unlimited.
    fn default() -> Self {
        CallRoom {
            calls: usize::MAX,
            stops: usize::MAX,
        }
    }
}

/// Every tag of a machine. A clone shares the unchanged parts with the original, so that it is cheap.
#[derive(Clone, Debug)]
pub struct Image {
    tags: Shared<Vec<Tag>>,
    bytes: Memory,
    names: Shared<names::Names>,
    programs: Shared<Vec<String>>,
    templates: Shared<BTreeMap<u16, Arc<Template>>>,
    /// The location of the MOTION_INSTRUCTION of each slot: tag and offset.
    controls: Shared<Vec<(TagId, usize)>>,
    /// The number of times that instructions have named a motion control tag.
    uses: u64,
    /// The value of `uses` when each slot was last named; 0: never.
    last_uses: Unshared<u64>,
    encoder: Shared<encode::Encoder>,
    encoded: encode::Encoded,
    /// The history of the table of tags.
    table: Shared<table::Table>,
    snapshot_tick: u64,
    /// The last override of each coordinate system that was not 0, percent.
    before_hold: Vec<f32>,
    /// Written parts of plain tags; `None`: they are not recorded.
    written: Option<Vec<WrittenPart>>,
    /// The causes that can be injected into each axis.
    possible_faults: Vec<FaultSet>,
    /// The number of instructions for which the controller has room.
    room: CallRoom,
    /// The latest tick overran.
    overlapping: bool,
    /// Cam profiles that are being calculated or used.
    profiles: cams::Profiles,
    /// Tags that the machine reads.
    inputs: inputs::InputTags,
    /// Output cams in use.
    outputs: outputs::Outputs,
    /// Settable attributes.
    attributes: Shared<attributes::Attributes>,
    /// The values of the newest snapshot that only attributes show.
    shown: attributes::Shown,
    /// The tags of the controller's own program.
    program_tags: Shared<program::ProgramTags>,
    /// Changes of these tags by others.
    notes: program::Notes,
    /// The tag that shows the tick, on the step clock.
    clock_step: Option<TagId>,
}

impl Image {
    /// The tags of a machine, at their first values. The configuration has checked that names are unique.
    pub fn new(machine: &Machine, instruction_tags: &[InstructionTag], plain_tags: &[PlainTag]) -> Self {
        let mut image = Image {
            tags: Shared::default(),
            bytes: Memory::default(),
            names: Shared::default(),
            programs: Shared::default(),
            templates: Shared::default(),
            controls: Shared::default(),
            uses: 0,
            last_uses: Unshared::default(),
            encoder: Shared::new(encode::Encoder::new(machine)),
            encoded: encode::Encoded::default(),
            table: Shared::default(),
            snapshot_tick: 0,
            before_hold: vec![feed_override::AS_PROGRAMMED; machine.systems.len()],
            written: None,
            possible_faults: machine
                .axes
                .iter()
                .map(|axis| FaultSet::possible(!axis.is_virtual()))
                .collect(),
            room: CallRoom::default(),
            overlapping: false,
            profiles: cams::Profiles::default(),
            inputs: inputs::InputTags::new(machine),
            outputs: outputs::Outputs::default(),
            attributes: Shared::new(attributes::Attributes::new(machine)),
            shown: attributes::Shown::default(),
            program_tags: Shared::default(),
            notes: program::Notes::default(),
            clock_step: None,
        };
        image.add(
            &machine.group,
            TagType::scalar(predefined::motion_group()),
            TagKind::MotionGroup,
        );
        for (id, axis) in (0..).map(AxisId).zip(&machine.axes) {
            let template = if axis.is_virtual() {
                predefined::axis_virtual()
            } else {
                predefined::axis_cip_drive()
            };
            image.add(&axis.name, TagType::scalar(template), TagKind::Axis(id));
        }
        for (id, system) in (0..).map(SystemId).zip(&machine.systems) {
            let template = predefined::coordinate_system();
            image.add(&system.name, TagType::scalar(template), TagKind::CoordinateSystem(id));
        }
        for tag in instruction_tags {
            image.add_instruction(tag);
        }
        for tag in plain_tags {
            // The configuration has checked that the target of an alias exists.
            let _ = image.add_configured(tag);
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
        image.add_fault_inject(machine);
        image.add_motion_inhibit();
        image.add_contour_rests(machine);
        image.add_template(&predefined::motion_instruction());
        image.encoder.constants(machine, &mut image.bytes);
        image.apply_snapshot(&Snapshot::new(machine));
        image
    }

    /// Every tag, by ascending id.
    pub fn tags(&self) -> &[Tag] {
        &self.tags
    }

    /// The programs with tags in their scopes.
    pub fn programs(&self) -> &[String] {
        &self.programs
    }

    /// The tag of that name, case ignored: `X` in the controller's scope, `Program:Main.X` in a program's.
    pub fn find(&self, name: &str) -> Option<&Tag> {
        self.tag(self.names.find(name)?)
    }

    /// The name of a tag with its program, as [`Image::find`] takes it.
    pub fn full_name(&self, tag: &Tag) -> String {
        match tag.program.and_then(|row| self.programs.get(usize::from(row))) {
            Some(program) => format!("Program:{program}.{}", tag.name),
            None => tag.name.clone(),
        }
    }

    /// The tag of that id.
    pub fn tag(&self, id: TagId) -> Option<&Tag> {
        self.tags.get(self.row_of(id)?)
    }

    /// The bytes of a tag; empty if there is none of that id.
    pub fn bytes(&self, id: TagId) -> &[u8] {
        self.row_of(id).and_then(|row| self.bytes.get(row)).unwrap_or_default()
    }

    /// The structure types in use, by ascending template instance id.
    pub fn templates(&self) -> impl Iterator<Item = &Arc<Template>> {
        self.templates.values()
    }

    /// The structure type of a template instance id.
    pub fn template(&self, instance: u16) -> Option<Arc<Template>> {
        self.templates.get(&instance).cloned()
    }

    /// The tick of the newest applied snapshot.
    pub fn snapshot_tick(&self) -> u64 {
        self.snapshot_tick
    }

    /// Takes over a change of an instruction's status.
    pub fn apply_event(&mut self, event: &Event) {
        if !event.owner || event.control == UNNAMED {
            return;
        }
        self.note_event(event);
        let mut control = self.control(event.control);
        event.apply(&mut control);
        self.set_control(event.control, control);
    }

    /// Takes over the state of axes, coordinate systems and group at one tick.
    pub fn apply_snapshot(&mut self, snapshot: &Snapshot) {
        self.apply(snapshot, None);
    }

    /// The same for a snapshot of which only these axes differ from the one before ([`crate::Controller::update`]).
    pub fn apply_changes(&mut self, snapshot: &Snapshot, changed: &AxisSet) {
        self.apply(snapshot, Some(changed));
    }

    fn apply(&mut self, snapshot: &Snapshot, changed: Option<&AxisSet>) {
        self.snapshot_tick = snapshot.tick;
        self.show_attributes(snapshot);
        let (encoded, bytes) = (&mut self.encoded, &mut self.bytes);
        self.encoder
            .snapshot(snapshot, changed, self.overlapping, encoded, bytes);
        self.show_contour_rests(snapshot);
        self.show_clock(snapshot.tick);
        self.show_uses();
    }

    /// Takes over the real-time thread's health, into its own tag and the group's Task members.
    pub fn apply_health(&mut self, health: &Health) {
        self.overlapping = health.overlapping;
        self.encoder.health(health, &mut self.bytes);
        let real_time = self.tags.iter().position(|tag| tag.kind == TagKind::RealTime);
        if let Some(bytes) = real_time.and_then(|row| self.bytes.get_mut(row)) {
            health.encode(bytes);
        }
    }

    fn add(&mut self, name: &str, tag_type: TagType, kind: TagKind) -> TagId {
        self.add_in(None, name, tag_type, kind)
    }

    fn add_in(&mut self, program: Option<u16>, name: &str, tag_type: TagType, kind: TagKind) -> TagId {
        let id = self.next_id();
        if let DataType::Structure(template) = &tag_type.data_type {
            self.add_template(template);
        }
        let size = match kind {
            TagKind::Alias(_) => 0,
            kind if kind.is_part_of_project() => 0,
            _ => tag_type.size(),
        };
        // At the end, unless an id is reused.
        let at = self.tags.partition_point(|tag| tag.id < id);
        self.bytes.insert(at, vec![0; size]);
        let scope = program.and_then(|row| self.programs.get(usize::from(row)));
        self.names.insert(scope.map(String::as_str), name, id);
        let tag = Tag {
            id,
            name: name.to_owned(),
            program,
            tag_type,
            kind,
            access: kind.access(),
            rule: WriteRule::default(),
        };
        self.tags.insert(at, tag);
        self.table.changes = self.table.changes.wrapping_add(1);
        id
    }

    /// Adds a tag of the configuration. `None` if the target of an alias does not exist, or no slot is free.
    fn add_configured(&mut self, tag: &PlainTag) -> Option<TagId> {
        if !tag.is_control() {
            return self.add_plain(tag);
        }
        let slot = self.free_slot()?;
        let id = self.add(&tag.name, tag.tag_type.clone(), TagKind::MotionControl(slot));
        self.use_slot(slot, id, 0);
        self.table.configured_controls.insert(id);
        Some(id)
    }

    /// `None` if the target of an alias does not exist.
    fn add_plain(&mut self, tag: &PlainTag) -> Option<TagId> {
        let program = tag.program.as_deref().map(|program| self.add_program(program));
        let kind = match &tag.alias {
            None => TagKind::Plain,
            Some(path) => match self.locate(path) {
                Ok((tag, row)) => TagKind::Alias(AliasTarget {
                    tag,
                    offset: row.offset,
                    bit: row.bit,
                }),
                // The configuration has checked that the path exists.
                Err(_) => return None,
            },
        };
        let id = self.add_in(program, &tag.name, tag.tag_type.clone(), kind);
        if let Some(bytes) = self.bytes_mut(id)
            && bytes.len() == tag.first.len()
        {
            bytes.copy_from_slice(&tag.first);
        }
        let base = match kind {
            TagKind::Alias(alias) => self.tag(alias.tag).map(|tag| tag.access),
            _ => None,
        };
        if let Some(row) = self.row_of(id) {
            self.tags[row].rule = tag.rule;
            self.tags[row].access = match base {
                Some(Access::ReadOnly) => Access::ReadOnly,
                _ => tag.access,
            };
        }
        Some(id)
    }

    /// The index of a program, which is in the list of tags from now on.
    fn add_program(&mut self, name: &str) -> u16 {
        let known = self.programs.iter().position(|known| known.eq_ignore_ascii_case(name));
        let row = known.unwrap_or(self.programs.len()) as u16;
        if known.is_none() {
            self.programs.push(name.to_owned());
        }
        // A program without tags was removed from the list.
        let listed = format!("Program:{name}");
        if self.find(&listed).is_none() {
            self.add(&listed, TagType::scalar(Elementary::Udint), TagKind::Program(row));
        }
        row
    }

    fn add_instruction(&mut self, tag: &InstructionTag) {
        let Some(control) = self.free_slot() else { return };
        let template = instruction_tag_template(tag.mnemonic);
        let row = template
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
        self.use_slot(control, id, row);
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
        self.note_type(template);
        self.templates
            .entry(template.instance)
            .or_insert_with(|| template.clone());
    }

    fn bytes_mut(&mut self, id: TagId) -> Option<&mut Vec<u8>> {
        let row = self.row_of(id)?;
        self.bytes.get_mut(row)
    }
}

fn index(id: TagId) -> Option<usize> {
    (id.0 as usize).checked_sub(1)
}

const MOTION_CONTROL: &str = "MotionControl";
