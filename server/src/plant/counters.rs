//! The numbers of executed and refused commands, by their kind.

use std::sync::atomic::{AtomicU64, Ordering};

/// A kind of commands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Counter {
    /// Writes of tags.
    Writes,
    /// Attributes that were set.
    Attributes,
    /// Injected faults.
    InjectedFaults,
    /// Overrides, holds and resumes.
    Overrides,
    /// Instructions, but for those that writes of `EnableIn` execute.
    Instructions,
    /// Changes of the table of tags.
    Tables,
    /// Clients that were lost or have closed in order.
    Owners,
    /// Stops of everything.
    Stops,
    /// Changes of the controller's mode.
    Modes,
    /// Steps of the clock, but for those that writes of `ClockStep` ask for.
    Steps,
}

impl Counter {
    /// Every kind, in their order.
    pub const ALL: [Counter; 10] = [
        Counter::Writes,
        Counter::Attributes,
        Counter::InjectedFaults,
        Counter::Overrides,
        Counter::Instructions,
        Counter::Tables,
        Counter::Owners,
        Counter::Stops,
        Counter::Modes,
        Counter::Steps,
    ];

    /// Its name, for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Writes => "tag writes",
            Self::Attributes => "attributes",
            Self::InjectedFaults => "injected faults",
            Self::Overrides => "overrides",
            Self::Instructions => "instructions",
            Self::Tables => "tag tables",
            Self::Owners => "ended clients",
            Self::Stops => "stops",
            Self::Modes => "modes",
            Self::Steps => "clock steps",
        }
    }
}

/// The commands or requests of one kind since the start.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct OutcomeCount {
    /// The executed ones.
    pub done: u64,
    /// The refused ones.
    pub refused: u64,
}

/// A kind of EtherNet/IP requests.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum RequestKind {
    /// Reads of tags.
    TagReads,
    /// Writes of tags.
    TagWrites,
    /// Services of motion objects.
    Instructions,
    /// Services of other objects.
    Objects,
    /// Requests to objects that do not exist.
    Unknown,
}

impl RequestKind {
    /// Every kind, in their order.
    pub(crate) const ALL: [RequestKind; 5] = [
        RequestKind::TagReads,
        RequestKind::TagWrites,
        RequestKind::Instructions,
        RequestKind::Objects,
        RequestKind::Unknown,
    ];

    /// Its name, for people.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::TagReads => "tag reads",
            Self::TagWrites => "tag writes",
            Self::Instructions => "instructions",
            Self::Objects => "objects",
            Self::Unknown => "unknown",
        }
    }
}

/// The requests of EtherNet/IP clients, those in packets of requests one by one.
#[derive(Debug, Default)]
pub(super) struct Requests([[AtomicU64; 2]; RequestKind::ALL.len()]);

impl Requests {
    pub(super) fn count(&self, kind: RequestKind, is_done: bool) {
        self.0[kind as usize][usize::from(!is_done)].fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn of(&self, kind: RequestKind) -> OutcomeCount {
        let [done, refused] = self.0[kind as usize]
            .each_ref()
            .map(|count| count.load(Ordering::Relaxed));
        OutcomeCount { done, refused }
    }
}

/// The counters.
#[derive(Debug, Default)]
pub(super) struct Counters([[AtomicU64; 2]; Counter::ALL.len()]);

impl Counters {
    pub(super) fn count(&self, counter: Counter, is_done: bool) {
        if let Some(counts) = self.0.get(counter as usize) {
            counts[usize::from(!is_done)].fetch_add(1, Ordering::Relaxed);
        }
    }

    pub(super) fn of(&self, counter: Counter) -> OutcomeCount {
        let counts = self.0.get(counter as usize);
        let [done, refused] = counts.map_or([0, 0], |counts| {
            counts.each_ref().map(|count| count.load(Ordering::Relaxed))
        });
        OutcomeCount { done, refused }
    }
}
