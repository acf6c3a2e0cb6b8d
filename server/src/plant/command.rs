//! Every change of the machine, as one enum, with its outcomes and refusals.
//!
//! A new command does not compile before [`policy`](super::policy) has the right that it needs, the owner of the motion that it begins,
//! its part of the retained state, and its counter.

use std::sync::Arc;

use arcline_config::{ConnectionLoss, Role};
use arcline_controller::image::{ConfiguredTags, PlainTag, TableError, TagId, WriteError};
use arcline_instruction_set::{Attribute, AxisId, ControlSlot, Mnemonic, SystemId, UnboundOperand};
use arcline_tag::TagPath;

use super::{CallRefused, Executed, Force, ForceError, LossOutcome, Mode, Mover, Principal, Right};
use crate::retained::NotPersisted;

/// A change of the machine.
#[derive(Clone, Debug)]
pub enum Command<'a> {
    /// Writes bytes of a tag.
    WriteTag {
        /// The tag.
        tag: TagId,
        /// Offset of the first byte.
        offset: usize,
        /// The bytes.
        data: &'a [u8],
    },
    /// Writes a bit of a tag; of `EnableIn`, an edge executes the instruction with the operands at the end of the transaction.
    WriteBit {
        /// The tag.
        tag: TagId,
        /// Offset of the number with the bit, bytes.
        offset: usize,
        /// The bit of that number.
        bit: u8,
        /// Its value.
        on: bool,
    },
    /// Sets an attribute of a motion object.
    SetAttribute {
        /// The attribute.
        attribute: &'static Attribute,
        /// The index of its object.
        index: u16,
        /// Its value.
        value: f64,
    },
    /// Injects faults into an axis.
    InjectFaults {
        /// The index of the axis.
        axis: AxisId,
        /// The faults, a bit each.
        bits: u32,
    },
    /// Sets the feed override of a coordinate system.
    SetFeedOverride {
        /// The index of the system.
        system: SystemId,
        /// The override, percent.
        percent: f32,
    },
    /// Sets feed overrides to 0, and remembers those before.
    Hold(Systems),
    /// Gives held coordinate systems the override that they had before.
    Resume(Systems),
    /// Executes an instruction.
    Call(Call<'a>),
    /// Executes an instruction whose operands are bound already: one of the controller's program.
    Execute(&'a arcline_instruction_set::Call),
    /// The rung condition of an instruction of the controller's program is false.
    RungFalse(Mnemonic, ControlSlot),
    /// Lets the controller's program run, or stops it.
    SetMode(Mode),
    /// Forces an input of a module: the controller's program sees this value.
    Force(&'a Force),
    /// Removes the force of an input by its name, or all forces.
    RemoveForce(Option<&'a str>),
    /// Creates a tag.
    CreateTag(&'a PlainTag),
    /// Deletes a tag that was created.
    DeleteTag(TagId),
    /// Takes over the tags and types of another configuration.
    Reload {
        /// The configuration of the present tags.
        old: ConfiguredTags<'a>,
        /// The other one.
        new: ConfiguredTags<'a>,
    },
    /// A principal is lost: the motion that it began and that still runs is stopped, held or goes on.
    Lose {
        /// The principal.
        lost: Principal,
        /// The reaction of its motion.
        reaction: ConnectionLoss,
    },
    /// A principal has closed its connection in order: its motion goes on without an owner.
    Disown(Principal),
    /// Stops everything that moves, every axis by itself.
    StopAll,
    /// STOP: stops everything that moves and inhibits motion until [`Command::Release`].
    Inhibit,
    /// Inhibits motion no more.
    Release,
    /// Lets ticks pass on the step clock, behind all else of the transaction.
    Step {
        /// The greatest number of ticks.
        ticks: u32,
        /// The tag that ends the steps when it is not 0.
        until: Option<TagPath>,
    },
}

/// Coordinate systems.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Systems {
    /// One coordinate system, by its index.
    One(SystemId),
    /// All that there are.
    All,
}

/// An instruction that is to be executed.
#[derive(Clone, Debug)]
pub struct Call<'a> {
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// The index of the object it acts on; `None`: there is no such object.
    pub target: Option<u16>,
    /// Its motion control tag, made if it is not there; `None`: none.
    pub control: Option<&'a str>,
    /// The operands behind target and motion control.
    pub operands: &'a [UnboundOperand],
    /// Its Structured Text, for the events.
    pub text: Option<Arc<str>>,
}

/// The outcome of a command.
#[derive(Clone, PartialEq, Debug)]
pub enum Outcome {
    /// The plant has executed the command.
    Done,
    /// A tag was created.
    Created(TagId),
    /// An instruction was sent; this is its instance of class 0x0303.
    Begun(u32),
    /// An instruction was executed; its motion control tag may show an error.
    Executed(Executed),
    /// The objects of a lost principal that were stopped or held.
    Lost(LossOutcome),
}

/// The reason for which a command was not executed. It has changed nothing, except with [`Refused::NotPersisted`] and [`CallRefused::NoAnswer`].
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum Refused {
    /// The role of the principal does not have the right.
    #[error("the role {} may not {}: the least that may is {}", role.word(), right.name(), right.least().word())]
    Role {
        /// The right that was missing.
        right: Right,
        /// The role of the principal.
        role: Role,
    },
    /// A viewer of the page does not have control of the object that it would move.
    #[error("there is no control of {object}")]
    NoControl {
        /// The name of the object.
        object: String,
        /// The name of the viewer that has control of it.
        holder: Option<String>,
    },
    /// An axis that a jog button was to move is moved by another principal.
    #[error("{object} is moved by {mover}; it can be jogged when that motion has ended")]
    MovedByAnother {
        /// The name of the axis.
        object: String,
        /// The principal that moves it.
        mover: Mover,
    },
    /// A tag was not written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The table of tags was not changed.
    #[error(transparent)]
    Table(#[from] TableError),
    /// An instruction was not executed.
    #[error(transparent)]
    Call(#[from] CallRefused),
    /// There is no program to run or to stop.
    #[error(
        "the controller has no program: start it with one (arcline-server run PROJECT.L5X, or `program` in [controller])"
    )]
    NoProgram,
    /// An input was not forced.
    #[error(transparent)]
    Force(#[from] ForceError),
    /// Ticks pass by themselves.
    #[error("the machine is on the real clock: a server that was started with `--clock step` can be stepped")]
    NotStepped,
    /// The plant has executed the command, but a restart may undo it.
    #[error(transparent)]
    NotPersisted(#[from] NotPersisted),
}
