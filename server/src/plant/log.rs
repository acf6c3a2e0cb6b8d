//! The newest changes of instructions, numbered, for whoever looks at them later.

use std::collections::VecDeque;

use arcline_controller::Event;

/// The newest events.
#[derive(Debug, Default)]
pub(super) struct Log {
    events: VecDeque<Logged>,
    next: u64,
}

/// An event with its number.
#[derive(Clone, Copy, Debug)]
pub struct Logged {
    /// Its number, from 1.
    pub number: u64,
    /// What happened.
    pub event: Event,
    /// The object that the instruction acts on, by its place.
    pub target: Option<u16>,
}

impl Log {
    pub(super) fn push(&mut self, event: Event, target: Option<u16>) {
        if self.events.len() == KEPT {
            self.events.pop_front();
        }
        self.next += 1;
        self.events.push_back(Logged {
            number: self.next,
            event,
            target,
        });
    }

    /// The events behind a number, oldest first.
    pub(super) fn since(&self, number: u64) -> impl Iterator<Item = &Logged> {
        let from = self.events.partition_point(|logged| logged.number <= number);
        self.events.range(from..)
    }
}

/// Events that are kept.
const KEPT: usize = 4096;
