//! The newest executions by ticket and by instance of class 0x0303; their tags may show later executions.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::SystemTime;

use arcline_controller::{Cause, Event, Ticket};
use arcline_instruction_set::{Flag, MotionControl};

use super::client::ClientIdentity;
use super::principal::Principal;

#[derive(Clone, Debug)]
struct Record {
    control: MotionControl,
    /// The index of the object it acts on.
    target: Option<u16>,
    origin: Origin,
    ended: Option<Ended>,
}

/// The principal that began an execution, and the text that it gave.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Origin {
    /// The principal.
    pub(crate) principal: Principal,
    /// Its client as it was known then; empty: it was no client.
    pub(crate) client: Arc<ClientIdentity>,
    /// The Structured Text of the instruction.
    pub(crate) text: Option<Arc<str>>,
}

/// The end of an execution that did not come to its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ended {
    pub(super) cause: Cause,
    pub(super) tick: u64,
    pub(super) at: SystemTime,
}

/// The newest executions.
#[derive(Debug, Default)]
pub(crate) struct Executions {
    ring: VecDeque<Record>,
    newest: u64,
}

impl Executions {
    /// Makes place for the next ticket. Tickets are in sequence.
    pub(super) fn begin(&mut self, ticket: Ticket, target: Option<u16>, origin: Origin) {
        if self.ring.len() == RECORDS {
            self.ring.pop_front();
        }
        // An execution begins with EN, and no event repeats that when the tag's EN was set before.
        let mut begun = MotionControl::default();
        begun.set(Flag::En);
        self.ring.push_back(Record {
            control: begun,
            target,
            origin,
            ended: None,
        });
        self.newest = ticket.0;
    }

    pub(super) fn get(&self, ticket: Ticket) -> Option<&MotionControl> {
        self.ring.get(self.place(ticket)?).map(|record| &record.control)
    }

    pub(super) fn get_mut(&mut self, ticket: Ticket) -> Option<&mut MotionControl> {
        let place = self.place(ticket)?;
        self.ring.get_mut(place).map(|record| &mut record.control)
    }

    /// Notes why an execution ended, if a change says so.
    pub(super) fn note_end(&mut self, event: &Event, at: SystemTime) {
        let Event { cause, tick, .. } = *event;
        if cause == Cause::Itself {
            return;
        }
        if let Some(record) = self.place(event.ticket).and_then(|place| self.ring.get_mut(place)) {
            record.ended = Some(Ended { cause, tick, at });
        }
    }

    /// The object that an execution acts on.
    pub(super) fn target(&self, ticket: Ticket) -> Option<u16> {
        self.ring.get(self.place(ticket)?)?.target
    }

    /// The origin of an execution.
    pub(crate) fn origin(&self, ticket: Ticket) -> Option<&Origin> {
        self.ring.get(self.place(ticket)?).map(|record| &record.origin)
    }

    fn place(&self, ticket: Ticket) -> Option<usize> {
        let age = usize::try_from(self.newest.checked_sub(ticket.0)?).ok()?;
        self.ring.len().checked_sub(age + 1)
    }

    pub(super) fn by_instance(&self, instance: u32) -> Option<MotionControl> {
        self.of_instance(instance).map(|record| record.control)
    }

    /// The cause that ended an execution before its end.
    pub(super) fn end_of(&self, instance: u32) -> Option<Ended> {
        self.of_instance(instance)?.ended
    }

    fn of_instance(&self, instance: u32) -> Option<&Record> {
        // Instances are the low half of a ticket.
        let age = (self.newest as u32).wrapping_sub(instance) as usize;
        let place = self.ring.len().checked_sub(age.checked_add(1)?)?;
        self.ring.get(place)
    }

    pub(super) fn newest(&self) -> Option<Ticket> {
        (!self.ring.is_empty()).then_some(Ticket(self.newest))
    }

    pub(super) fn oldest(&self) -> Option<Ticket> {
        self.newest()
            .map(|newest| Ticket(newest.0 + 1 - self.ring.len() as u64))
    }
}

/// Instance of class 0x0303.
pub(super) fn instance_of(ticket: Ticket) -> u32 {
    ticket.0 as u32
}

/// Executions that class 0x0303 keeps (spec/contract.md §4).
pub(super) const RECORDS: usize = 4096;
