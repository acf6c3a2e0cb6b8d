//! A master axis as its followers read it, and what an instruction says of the lock to it.
//!
//! Units: master units, seconds.

use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::MasterAt;
use arcline_instruction_set::enumerations::Reference;

/// What an instruction says about the lock (Lock Direction and Lock Position).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LockTo {
    pub(crate) sense: Sense,
    /// Where the master is locked to, as it shows its position; `None`: at once.
    pub(crate) position: Option<f64>,
}

/// In which direction the master is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sense {
    Forward,
    Reverse,
}

impl Sense {
    pub(crate) fn sign(self) -> f64 {
        match self {
            Sense::Forward => 1.0,
            Sense::Reverse => -1.0,
        }
    }
}

/// What is read of a master, one tick after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Master {
    pub(crate) axis: u16,
    pub(crate) reference: Reference,
    /// What is read now: a master without torque has no command of its own.
    read: Reference,
    /// Makes one continuous position of both.
    pub(super) offset: f64,
    /// At the tick before.
    pub(super) before: f64,
    pub(super) now: KinematicState,
    tick: u64,
}

impl Master {
    pub(crate) fn new(axis: u16, reference: Reference, at: &MasterAt, clock: &Clock) -> Self {
        Master {
            axis,
            reference,
            read: at.read,
            offset: 0.0,
            before: at.point.position,
            now: at.point,
            tick: clock.tick,
        }
    }

    /// Where it is at the present tick; again, if that has changed within the tick.
    pub(crate) fn read(&mut self, at: &MasterAt, clock: &Clock) {
        if clock.tick != self.tick {
            self.tick = clock.tick;
            self.before = self.now.position;
        }
        if self.read != at.read {
            // Command and actual position differ: nothing jumps from the one to the other.
            self.read = at.read;
            self.offset = self.now.position - at.point.position;
        }
        self.now = KinematicState {
            position: at.point.position + self.offset,
            ..at.point
        };
    }

    /// Master units/s, with a sign.
    pub(crate) fn velocity(&self) -> f64 {
        self.now.velocity
    }

    /// Where it was at an instant of the update that ends now.
    pub(super) fn position_at(&self, at: Instant, clock: &Clock) -> f64 {
        let share = (at.elapsed(clock) / clock.period()).clamp(0.0, 1.0);
        self.now.position - share * (self.now.position - self.before)
    }
}
