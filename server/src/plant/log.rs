//! The newest changes of instructions and of the faults of axes, numbered, for later readers.

use std::collections::VecDeque;
use std::time::{Duration, SystemTime};

use arcline_controller::{Event, FaultChange};
use arcline_instruction_set::SystemId;

use super::wall_clock::WallClock;

/// The newest changes.
#[derive(Debug)]
pub(super) struct Log {
    events: VecDeque<Logged>,
    next: u64,
    period: Duration,
    wall: WallClock,
}

/// A change with its number.
#[derive(Clone, Copy, Debug)]
pub struct Logged {
    /// Its number, from 1.
    pub number: u64,
    /// When, by the system's clock.
    pub at: SystemTime,
    /// The change.
    pub change: Change,
}

/// The change of an instruction, of an axis's faults, or of a contour.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// A change of an instruction.
    Instruction {
        /// The change.
        event: Event,
        /// The object that the instruction acts on, by its place.
        target: Option<u16>,
    },
    /// A change of the faults of an axis.
    Fault(FaultChange),
    /// A planned contour came to rest between moves that go on.
    Rest(ContourRest),
}

/// The rest of a planned contour between moves that go on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ContourRest {
    /// The tick in which it was counted.
    pub tick: u64,
    /// The coordinate system.
    pub system: SystemId,
    /// The cause of the rest.
    pub cause: RestCause,
    /// Rests of the system from that cause since the start.
    pub count: u32,
}

/// The cause for which a planned contour came to rest between moves that go on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RestCause {
    /// The queue was empty: the program sent its next move too late.
    Starved,
    /// The plan of the moves that waited was not ready in time.
    Unplanned,
}

impl Change {
    /// The tick in which it happened.
    pub fn tick(&self) -> u64 {
        match self {
            Change::Instruction { event, .. } => event.tick,
            Change::Fault(change) => change.tick,
            Change::Rest(rest) => rest.tick,
        }
    }
}

impl Log {
    /// Makes the log of a machine with this coarse update period, with the dates of a clock.
    pub(super) fn new(period: Duration, wall: WallClock) -> Self {
        Log {
            events: VecDeque::new(),
            next: 0,
            period,
            wall,
        }
    }

    /// The time of a tick by the system's clock, which shows now when the newest tick is `newest`.
    pub(super) fn time_of(&self, tick: u64, newest: u64) -> SystemTime {
        let ticks = u32::try_from(newest.saturating_sub(tick)).unwrap_or(u32::MAX);
        let now = self.wall.now();
        now.checked_sub(self.period.saturating_mul(ticks)).unwrap_or(now)
    }

    pub(super) fn push(&mut self, change: Change, at: SystemTime) {
        if self.events.len() == KEPT {
            self.events.pop_front();
        }
        self.next += 1;
        self.events.push_back(Logged {
            number: self.next,
            at,
            change,
        });
    }

    /// The changes behind a number, oldest first.
    pub(super) fn since(&self, number: u64) -> impl Iterator<Item = &Logged> {
        let from = self.events.partition_point(|logged| logged.number <= number);
        self.events.range(from..)
    }
}

/// The most changes in the log.
const KEPT: usize = 4096;
