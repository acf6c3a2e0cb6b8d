//! What a tag is: its id, name, type, and what it stands for. Its bytes are the image's.

use arcline_instruction_set::{AxisId, ControlSlot, Mnemonic, SystemId, predefined};
use arcline_tag::{DataType, TagPath, TagType};

use super::WriteRule;

/// Symbol instance id of a tag: from 1, never used for another tag while the process runs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct TagId(pub u32);

/// Who may write.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Access {
    /// Only the controller.
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
    Axis(AxisId),
    /// A coordinate system, by its place in the machine.
    CoordinateSystem(SystemId),
    /// A MOTION_INSTRUCTION.
    MotionControl(ControlSlot),
    /// An instruction as a tag.
    Instruction(InstructionKind),
    /// Plain data.
    Plain,
    /// Another name for a plain tag or a part of one.
    Alias(AliasOf),
    /// A program: the scope of tags, by its place in [`Image::programs`](super::Image::programs).
    Program(u16),
    /// The health of the real-time thread.
    RealTime,
    /// The feed override of every coordinate system.
    FeedOverride,
    /// The injected causes of faults of every axis.
    FaultInject,
    /// Whether motion is inhibited.
    MotionInhibit,
    /// The tick, and the ticks that are to pass, on the step clock.
    ClockStep,
    /// How often the planned contours of every coordinate system have come to rest between moves that go on.
    ContourRests,
}

/// What an alias stands for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct AliasOf {
    /// The tag.
    pub tag: TagId,
    /// Byte in it.
    pub offset: usize,
    /// Bit, where it stands for one: 0 to 63 of the integer at `offset`.
    pub bit: Option<u8>,
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
    /// The program in whose scope it is, by its place; `None`: the controller's.
    pub program: Option<u16>,
    /// Its type.
    pub tag_type: TagType,
    /// What it stands for.
    pub kind: TagKind,
    /// Whether clients may write at least a part of it.
    pub access: Access,
    /// What it asks of those who write it.
    pub rule: WriteRule,
}

/// Type word of a program in the list of tags (spec/ethernet-ip.md §10).
const PROGRAM_TYPE: u16 = 0x1068;

impl Tag {
    /// The type word that clients see.
    pub fn symbol_type(&self) -> u16 {
        match self.kind {
            TagKind::Program(_) => PROGRAM_TYPE,
            _ => self.tag_type.symbol_type(),
        }
    }
}

impl TagKind {
    /// Whether clients may write at least a part of such a tag.
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

/// An instruction as a tag: what the image makes one of.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct InstructionTag {
    /// Name of the tag.
    pub name: String,
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// The coordinate system, axis or group that it acts on at first, spelled as in the machine.
    pub target: String,
}

/// Plain data: what the image makes a tag of.
#[derive(Clone, PartialEq, Debug)]
pub struct PlainTag {
    /// Name of the tag.
    pub name: String,
    /// The program in whose scope it is; `None`: the controller's.
    pub program: Option<String>,
    /// Its type.
    pub tag_type: TagType,
    /// Who may write.
    pub access: Access,
    /// What it asks of those who write it.
    pub rule: WriteRule,
    /// Its first bytes; empty: zeros.
    pub first: Vec<u8>,
    /// What it stands for; `None`: itself.
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

    /// Whether it is a motion control tag: a MOTION_INSTRUCTION of the controller's scope.
    pub fn is_control(&self) -> bool {
        let control = DataType::Structure(predefined::motion_instruction());
        self.alias.is_none() && self.program.is_none() && self.tag_type == TagType::scalar(control)
    }
}

/// A write that the controller is to know of: `EnableIn` of an instruction tag changed, or an override, injected
/// faults or Dynamics Configuration Bits were written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Edge {
    /// False to true: the instruction executes.
    Rising(TagId),
    /// True to false.
    Falling(TagId),
    /// The tag `FeedOverride` was written: [`Image::feed_overrides`](super::Image::feed_overrides).
    FeedOverride,
    /// The tag `FaultInject` was written: [`Image::injected_faults`](super::Image::injected_faults).
    FaultInject,
    /// Dynamics Configuration Bits were set: [`Image::dynamics_bits`](super::Image::dynamics_bits).
    DynamicsBits,
    /// The tag `MotionInhibit` was written: motion stops and stays inhibited, or is released.
    Inhibit(bool),
    /// The tag `ClockStep` was written: so many ticks are to pass.
    Steps(u32),
    /// A plain tag that the machine reads was written: [`Image::take_inputs`](super::Image::take_inputs).
    Input,
}
