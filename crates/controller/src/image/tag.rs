//! The description of a tag: its id, name, type and kind. The image holds its bytes.

use arcline_instruction_set::{AxisId, ControlSlot, Mnemonic, SystemId, predefined};
use arcline_tag::{DataType, TagPath, TagType};

use super::WriteRule;

/// Symbol instance id of a tag: from 1, never reused for another tag while the process runs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct TagId(pub u32);

/// The writers of a tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Access {
    /// Only the controller.
    ReadOnly,
    /// Clients as well, at least for some members.
    ReadWrite,
}

/// The object of a tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TagKind {
    /// The motion group.
    MotionGroup,
    /// An axis, by its index in the machine.
    Axis(AxisId),
    /// A coordinate system, by its index in the machine.
    CoordinateSystem(SystemId),
    /// A MOTION_INSTRUCTION.
    MotionControl(ControlSlot),
    /// An instruction as a tag.
    Instruction(InstructionKind),
    /// Plain data.
    Plain,
    /// Another name for a plain tag or a part of one.
    Alias(AliasTarget),
    /// A program: the scope of tags, by its index in [`Image::programs`](super::Image::programs).
    Program(u16),
    /// A task of a project, which has no data.
    Task,
    /// A routine of a project, which has no data.
    Routine,
    /// The health of the real-time thread.
    RealTime,
    /// The feed override of every coordinate system.
    FeedOverride,
    /// The injected causes of faults of every axis.
    FaultInject,
    /// The inhibition of motion.
    MotionInhibit,
    /// On the step clock: the tick, and the number of ticks to execute.
    ClockStep,
    /// The rests of the planned contours of every coordinate system between moves that should follow without one.
    ContourRests,
}

/// The target of an alias.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct AliasTarget {
    /// The tag.
    pub tag: TagId,
    /// Byte in it.
    pub offset: usize,
    /// A bit, if the target is one: 0 to 63 of the integer at `offset`.
    pub bit: Option<u8>,
}

/// The fixed part of an instruction tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct InstructionKind {
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// The slot of its member `MotionControl`.
    pub control: ControlSlot,
}

/// A tag.
#[derive(Clone, PartialEq, Debug)]
pub struct Tag {
    /// Its id.
    pub id: TagId,
    /// Its name in its first spelling.
    pub name: String,
    /// The program of its scope, by its index; `None`: the controller's.
    pub program: Option<u16>,
    /// Its type.
    pub tag_type: TagType,
    /// Its object.
    pub kind: TagKind,
    /// The writers of at least a part of it.
    pub access: Access,
    /// Its restrictions for writers.
    pub rule: WriteRule,
}

/// Type words of programs, routines and tasks in the list of tags (spec/ethernet-ip.md §10).
const PROGRAM_TYPE: u16 = 0x1068;
const ROUTINE_TYPE: u16 = 0x106D;
const TASK_TYPE: u16 = 0x1070;

impl Tag {
    /// The type word that clients see.
    pub fn symbol_type(&self) -> u16 {
        match self.kind {
            TagKind::Program(_) => PROGRAM_TYPE,
            TagKind::Routine => ROUTINE_TYPE,
            TagKind::Task => TASK_TYPE,
            _ => self.tag_type.symbol_type(),
        }
    }
}

impl TagKind {
    /// Whether the entry of the list of tags is a part of a project instead of a tag: it has no data.
    pub fn is_part_of_project(self) -> bool {
        matches!(self, TagKind::Program(_) | TagKind::Task | TagKind::Routine)
    }

    /// The writers of such a tag, at least of a part.
    pub(super) fn access(self) -> Access {
        match self {
            TagKind::Instruction(_)
            | TagKind::Plain
            | TagKind::FeedOverride
            | TagKind::FaultInject
            | TagKind::MotionInhibit
            | TagKind::ClockStep => Access::ReadWrite,
            _ => Access::ReadOnly,
        }
    }
}

/// An instruction tag in the configuration.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct InstructionTag {
    /// Name of the tag.
    pub name: String,
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// The coordinate system, axis or group of its first target, spelled as in the machine.
    pub target: String,
}

/// A plain tag or alias in the configuration.
#[derive(Clone, PartialEq, Debug)]
pub struct PlainTag {
    /// Name of the tag.
    pub name: String,
    /// The program of its scope; `None`: the controller's.
    pub program: Option<String>,
    /// Its type.
    pub tag_type: TagType,
    /// Its writers.
    pub access: Access,
    /// Its restrictions for writers.
    pub rule: WriteRule,
    /// Its first bytes; empty: zeros.
    pub first: Vec<u8>,
    /// The path of an alias's target; `None`: not an alias.
    pub alias: Option<TagPath>,
}

impl PlainTag {
    /// A tag of the controller's scope that clients may write, at zero.
    pub fn new(name: impl Into<String>, tag_type: TagType) -> Self {
        Self {
            name: name.into(),
            program: None,
            tag_type,
            access: Access::ReadWrite,
            rule: WriteRule::default(),
            first: Vec::new(),
            alias: None,
        }
    }

    /// The tag is a motion control tag: a MOTION_INSTRUCTION of the controller's scope.
    pub fn is_control(&self) -> bool {
        let control = DataType::Structure(predefined::motion_instruction());
        self.alias.is_none() && self.program.is_none() && self.tag_type == TagType::scalar(control)
    }
}

/// The effect of a write that the controller must know: a change of `EnableIn` of an instruction tag, or a write of an override, injected faults
/// or an attribute.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum WriteEffect {
    /// False to true: the instruction executes.
    Rising(TagId),
    /// True to false.
    Falling(TagId),
    /// The tag `FeedOverride` was written: [`Image::feed_overrides`](super::Image::feed_overrides).
    FeedOverride,
    /// The tag `FaultInject` was written: [`Image::injected_faults`](super::Image::injected_faults).
    FaultInject,
    /// An attribute of an axis or a coordinate system was set: [`Image::settings`](super::Image::settings).
    Setting,
    /// The tag `MotionInhibit` was written: motion stops and stays inhibited, or is permitted again.
    Inhibit(bool),
    /// The tag `ClockStep` was written: the number of ticks to execute.
    Steps(u32),
    /// A plain tag that the machine reads was written: [`Image::take_inputs`](super::Image::take_inputs).
    Input,
}
