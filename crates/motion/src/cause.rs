//! Why an instruction ended before its end, and the changes of an axis's faults.
//!
//! Not here: what ends an instruction (`motion`, `instructions`), and names: both hold indices. Nothing allocates.

use arcline_instruction_set::{AxisId, ControlSlot, FaultSet, JogEnd, Mnemonic};

use crate::execution::{Execution, Ticket};

/// The cause of the end of an instruction that did not complete.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cause {
    /// Nothing but the instruction itself, or it has not ended this way.
    #[default]
    Itself,
    /// Another instruction: one that stops, or one that takes its place.
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
    /// A stop of the whole machine, by no instruction.
    StopAll,
    /// The end of a jog, by no instruction.
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
    /// When.
    pub tick: u64,
    /// Index of the axis.
    pub axis: AxisId,
    /// Faults that were raised.
    pub set: FaultSet,
    /// Of those, the ones that a reset had just cleared: their cause had never gone.
    pub again: FaultSet,
    /// Faults that were cleared.
    pub clear: FaultSet,
    /// The cause of the clearing.
    pub by: Cause,
    /// Of a command limit fault: the command that did not go out.
    pub refused: Option<RefusedCommand>,
}

/// A command that an axis could not have followed, and that its drive never got (spec/axis-and-data-types.md §12). Position units,
/// position units/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefusedCommand {
    /// The instruction that asked for it; [`Cause::Itself`]: none.
    pub by: Cause,
    /// The kind of motion that asked for it, as a person calls it.
    pub source: &'static str,
    /// Position and velocity of the last set-point.
    pub last: [f64; 2],
    /// Position and velocity that were asked for.
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
