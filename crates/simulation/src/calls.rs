//! The executed instructions: their callers, their lines, and the causes of their ends.

use std::collections::{BTreeMap, VecDeque};

use arcline_controller::{Cause, Ticket};
use arcline_instruction_set::{ControlSlot, Mnemonic};

use crate::end::Erred;
use crate::program::ProgramId;

/// Calls and ends that are stored, so that memory does not grow with the program.
const REMEMBERED: usize = 1 << 16;

/// The origin of a call.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Origin {
    /// The program; `None`: the caller of the simulation.
    pub program: Option<ProgramId>,
    /// Line of the statement, from 1; 0: none.
    pub line: usize,
}

/// An executed call.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Called {
    pub(crate) origin: Origin,
    pub(crate) mnemonic: Mnemonic,
    pub(crate) control: ControlSlot,
}

/// The newest calls.
#[derive(Debug, Default)]
pub(crate) struct Calls {
    /// The number of executed instructions: the newest ticket.
    executed: u64,
    newest_calls: VecDeque<Called>,
    /// The newest execution of a motion control tag.
    newest: BTreeMap<ControlSlot, (Ticket, Mnemonic)>,
    /// The causes of ends before completion.
    causes: BTreeMap<Ticket, Cause>,
    /// The first error of each program.
    erred: BTreeMap<ProgramId, Erred>,
}

impl Calls {
    pub(crate) fn executed(&self) -> u64 {
        self.executed
    }

    /// A ticket for a call.
    pub(crate) fn add(&mut self, called: Called) -> Ticket {
        if self.newest_calls.len() == REMEMBERED {
            self.newest_calls.pop_front();
        }
        self.newest_calls.push_back(called);
        self.executed += 1;
        let ticket = Ticket(self.executed);
        self.newest.insert(called.control, (ticket, called.mnemonic));
        ticket
    }

    /// A call by its ticket; `None` if it is too old.
    pub(crate) fn get(&self, ticket: Ticket) -> Option<&Called> {
        let first = self.executed + 1 - self.newest_calls.len() as u64;
        let index = usize::try_from(ticket.0.checked_sub(first)?).ok()?;
        self.newest_calls.get(index)
    }

    /// Line of a call; 0 if it has none, or is too old.
    pub(crate) fn line_of(&self, ticket: Ticket) -> usize {
        self.get(ticket).map_or(0, |called| called.origin.line)
    }

    /// The newest execution of a motion control tag.
    pub(crate) fn newest(&self, slot: ControlSlot) -> Option<(Ticket, Mnemonic)> {
        self.newest.get(&slot).copied()
    }

    /// The cause of an execution's end before completion.
    pub(crate) fn cause(&self, ticket: Ticket) -> Option<Cause> {
        self.causes.get(&ticket).copied()
    }

    /// Executions that ended before completion, by ticket.
    pub(crate) fn causes(&self) -> impl Iterator<Item = (Ticket, Cause)> {
        self.causes.iter().map(|(ticket, cause)| (*ticket, *cause))
    }

    /// Records the end of an execution before completion.
    pub(crate) fn end(&mut self, ticket: Ticket, cause: Cause) {
        if self.causes.len() == REMEMBERED {
            self.causes.pop_first();
        }
        self.causes.insert(ticket, cause);
    }

    /// Records the error of an execution, if it is the first of its program. An execution that is too old counts as the newest program's,
    /// without a line.
    pub(crate) fn err(&mut self, ticket: Ticket, erred: impl FnOnce(usize) -> Erred) {
        let forgotten = || Origin {
            program: self.newest_calls.back().and_then(|called| called.origin.program),
            line: 0,
        };
        let Origin { program, line } = self.get(ticket).map_or_else(forgotten, |called| called.origin);
        if let Some(program) = program {
            self.erred.entry(program).or_insert_with(|| erred(line));
        }
    }

    /// The first error of a program.
    pub(crate) fn erred(&self, program: ProgramId) -> Option<&Erred> {
        self.erred.get(&program)
    }

    /// The first error of a program, mutable.
    pub(crate) fn erred_mut(&mut self, program: ProgramId) -> Option<&mut Erred> {
        self.erred.get_mut(&program)
    }

    /// Removes the error of a program, and returns it.
    pub(crate) fn take_erred(&mut self, program: ProgramId) -> Option<Erred> {
        self.erred.remove(&program)
    }
}
