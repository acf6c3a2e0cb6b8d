//! What a tag is: its id, name, type, and what it stands for. Its bytes are the image's.

use arcline_instruction_set::{ControlSlot, Mnemonic};
use arcline_tag::TagType;

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
    /// The injected causes of faults of every axis.
    FaultInject,
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
            TagKind::Instruction(_) | TagKind::Plain | TagKind::FeedOverride | TagKind::FaultInject => {
                Access::ReadWrite
            }
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
    /// Its type.
    pub tag_type: TagType,
}

/// A write that the controller is to know of: `EnableIn` of an instruction tag changed, or an override or injected
/// faults were written.
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
}
