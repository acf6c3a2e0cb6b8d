//! The identity of one execution of one instruction.
//!
//! Not here: its status bits ([`crate::control`]) and the causes of its end ([`crate::cause`]).

use arcline_instruction_set::{ControlSlot, Mnemonic};

/// One execution of one instruction, for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Ticket(pub u64);

/// The location of the status bits that an execution writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Execution {
    pub(crate) ticket: Ticket,
    pub(crate) control: ControlSlot,
    pub(crate) mnemonic: Mnemonic,
}
