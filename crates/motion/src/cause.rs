//! The causes for which instructions end before completion, and the changes of an axis's faults.
//!
//! Not here: the stops and merges that end an instruction (`motion`, `instructions`), and names: both hold indices. Nothing allocates.

use arcline_instruction_set::{AxisId, ControlSlot, FaultSet, JogEnd, Mnemonic};

use crate::execution::{Execution, Ticket};

/// The cause of the end of an instruction that did not complete.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cause {
    /// No other cause than the instruction itself, or the instruction has not ended this way.
    #[default]
    Itself,
    /// Another instruction: a stop, or one that replaces it.
    Instruction {
        /// The other execution.
        ticket: Ticket,
        /// Its motion control tag.
        control: ControlSlot,
        /// The other instruction.
        mnemonic: Mnemonic,
    },
    /// Faults of an axis.
    Fault {
        /// Index of the axis.
        axis: AxisId,
        /// The faults, of one update.
        faults: FaultSet,
    },
    /// A stop of the whole machine that no instruction caused.
    StopAll,
    /// The end of a jog that no instruction caused.
    Jog(JogEnd),
}

impl From<Execution> for Cause {
    fn from(execution: Execution) -> Self {
        Cause::Instruction {
            ticket: execution.ticket,
            control: execution.control,
            mnemonic: execution.mnemonic,
        }
    }
}

/// A change of the faults of one axis within one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultChange {
    /// The tick.
    pub tick: u64,
    /// Index of the axis.
    pub axis: AxisId,
    /// Faults that were raised.
    pub set: FaultSet,
    /// Faults among them that a reset had just cleared: their cause was still present.
    pub again: FaultSet,
    /// Faults that were cleared.
    pub clear: FaultSet,
    /// The cause of the clearing.
    pub by: Cause,
    /// Of a command limit fault: the command that did not go out.
    pub refused: Option<RefusedCommand>,
}

/// A command that the axis could not have followed, and that did not reach its drive (spec/axis-and-data-types.md §12). Position units,
/// position units/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefusedCommand {
    /// The instruction of the command; [`Cause::Itself`]: none.
    pub by: Cause,
    /// The name of the kind of motion in messages.
    pub source: &'static str,
    /// Position and velocity of the last set-point.
    pub last: [f64; 2],
    /// Position and velocity of the command.
    pub asked: [f64; 2],
}

impl std::fmt::Display for RefusedCommand {
    /// As `MAJ asked for 12.5 at 4000/s behind 10.1 at 300/s`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([position, velocity], [asked, speed]) = (self.last, self.asked);
        let source = self.source;
        write!(
            f,
            "{source} asked for {asked} at {speed}/s behind {position} at {velocity}/s"
        )
    }
}
