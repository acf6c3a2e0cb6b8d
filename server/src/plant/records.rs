//! The executions by ticket and by instance of class 0x0303: the newest ones, and older ones that still run. Their tags may show later
//! executions.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::SystemTime;

use arcline_controller::{Cause, Event, Ticket};
use arcline_instruction_set::{Flag, MotionControl};

use super::client::ClientIdentity;
use super::principal::Principal;
use super::state::may_run;

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

/// The newest executions, and older ones that still run or have ended since they were old.
///
/// The ring has the newest [`RECORDS`]. One that leaves it while it may run goes to `older`, and stays there for the next [`RECORDS`] ends of
/// such executions. What can run at a time (the queues of the machine, and the calls that wait for the controller) bounds `older`;
/// [`MOST_OLDER`] bounds it should the controller's changes get lost.
#[derive(Debug, Default)]
pub(crate) struct Executions {
    ring: VecDeque<Record>,
    newest: u64,
    older: BTreeMap<Ticket, Record>,
    /// Those of `older` that have ended, in the order of their ends.
    over: VecDeque<Ticket>,
    /// Changes of executions up to this one were lost: a record of them may show for ever that it runs, so it leaves with the ring.
    uncertain: u64,
}

impl Executions {
    /// Makes place for the next ticket. Tickets are in sequence.
    pub(super) fn begin(&mut self, ticket: Ticket, target: Option<u16>, origin: Origin) {
        if self.ring.len() == RECORDS {
            let oldest = Ticket(self.newest + 1 - RECORDS as u64);
            let record = self.ring.pop_front();
            if let Some(record) = record.filter(|record| oldest.0 > self.uncertain && may_run(&record.control)) {
                self.keep(oldest, record);
            }
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

    /// Keeps a record that leaves the ring while it may run.
    fn keep(&mut self, ticket: Ticket, record: Record) {
        if self.older.len() >= MOST_OLDER {
            match self.over.pop_front() {
                Some(ended) => self.older.remove(&ended),
                None => self.older.pop_first().map(|(_, oldest)| oldest),
            };
        }
        self.older.insert(ticket, record);
    }

    /// Changes of executions were lost. Records that show an execution up to now as running are not kept beyond the ring.
    pub(super) fn changes_lost(&mut self) {
        self.uncertain = self.newest;
        self.older.clear();
        self.over.clear();
    }

    pub(super) fn get(&self, ticket: Ticket) -> Option<&MotionControl> {
        self.record(ticket).map(|record| &record.control)
    }

    /// Whether an execution runs or may yet run; so may one whose changes were lost.
    pub(super) fn may_run(&self, ticket: Ticket) -> bool {
        self.get(ticket).map_or(ticket.0 <= self.uncertain, may_run)
    }

    /// Changes the status of an execution. The value of `change`; `None`: the execution was dropped.
    pub(super) fn update<R>(&mut self, ticket: Ticket, change: impl FnOnce(&mut MotionControl) -> R) -> Option<R> {
        if let Some(place) = self.place(ticket) {
            return self.ring.get_mut(place).map(|record| change(&mut record.control));
        }
        let control = &mut self.older.get_mut(&ticket)?.control;
        let ran = may_run(control);
        let changed = change(control);
        if ran && !may_run(control) {
            self.over.push_back(ticket);
            if self.over.len() > RECORDS
                && let Some(oldest) = self.over.pop_front()
            {
                self.older.remove(&oldest);
            }
        }
        Some(changed)
    }

    /// Notes why an execution ended, if a change says so.
    pub(super) fn note_end(&mut self, event: &Event, at: SystemTime) {
        let Event { cause, tick, .. } = *event;
        if cause == Cause::Itself {
            return;
        }
        let record = match self.place(event.ticket) {
            Some(place) => self.ring.get_mut(place),
            None => self.older.get_mut(&event.ticket),
        };
        if let Some(record) = record {
            record.ended = Some(Ended { cause, tick, at });
        }
    }

    /// The object that an execution acts on.
    pub(super) fn target(&self, ticket: Ticket) -> Option<u16> {
        self.record(ticket)?.target
    }

    /// The origin of an execution.
    pub(crate) fn origin(&self, ticket: Ticket) -> Option<&Origin> {
        self.record(ticket).map(|record| &record.origin)
    }

    fn record(&self, ticket: Ticket) -> Option<&Record> {
        match self.place(ticket) {
            Some(place) => self.ring.get(place),
            None => self.older.get(&ticket),
        }
    }

    /// The place of an execution in the ring.
    fn place(&self, ticket: Ticket) -> Option<usize> {
        let age = usize::try_from(self.newest.checked_sub(ticket.0)?).ok()?;
        self.ring.len().checked_sub(age.checked_add(1)?)
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
        let age = (self.newest as u32).wrapping_sub(instance);
        self.record(Ticket(self.newest.checked_sub(age.into())?))
    }

    pub(super) fn newest(&self) -> Option<Ticket> {
        (!self.ring.is_empty()).then_some(Ticket(self.newest))
    }

    /// The number of executions in the records.
    pub(super) fn count(&self) -> usize {
        self.ring.len() + self.older.len()
    }
}

/// Instance of class 0x0303.
pub(super) fn instance_of(ticket: Ticket) -> u32 {
    ticket.0 as u32
}

/// The newest executions that class 0x0303 keeps (spec/contract.md §4).
pub(super) const RECORDS: usize = 4096;
/// Older executions that it keeps at most, running or ended.
const MOST_OLDER: usize = 1 << 16;
