//! A master axis as its followers read it.
//!
//! Not here: its followers. Units: master units, seconds.

use arcline_instruction_set::AxisId;
use arcline_instruction_set::enumerations::Reference;
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::MasterAt;

/// A master axis, and the position that its followers read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Master {
    pub(crate) axis: AxisId,
    pub(crate) reference: Reference,
    pub(super) reader: PositionReader,
}

impl Master {
    /// `at`: the axis at the clock's tick.
    pub(crate) fn new(axis: AxisId, reference: Reference, at: &MasterAt, clock: &Clock) -> Self {
        Master {
            axis,
            reference,
            reader: PositionReader::new(at, clock),
        }
    }

    /// Reads the master at the clock's tick, or again if the master has changed within the tick.
    pub(crate) fn read(&mut self, at: &MasterAt, clock: &Clock) {
        self.reader.read(at, clock);
    }

    /// Master units/s, with a sign.
    pub(crate) fn velocity(&self) -> f64 {
        self.reader.now.velocity
    }
}

/// The position of a master, or time, tick by tick. It stays continuous when the followers change between the command and the actual
/// position of the axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct PositionReader {
    /// The position that followers read at present; a master without torque has only its actual position.
    read: Reference,
    /// The offset that makes the position continuous across changes between the two.
    pub(super) offset: f64,
    /// The position at the previous tick.
    pub(super) before: f64,
    pub(super) now: KinematicState,
    tick: u64,
}

impl PositionReader {
    pub(super) fn new(at: &MasterAt, clock: &Clock) -> Self {
        PositionReader {
            read: at.read,
            offset: 0.0,
            before: at.point.position,
            now: at.point,
            tick: clock.tick,
        }
    }

    pub(super) fn read(&mut self, at: &MasterAt, clock: &Clock) {
        if clock.tick != self.tick {
            self.tick = clock.tick;
            self.before = self.now.position;
        }
        if self.read != at.read {
            // Command and actual position differ; the offset prevents a jump of the followers.
            self.read = at.read;
            self.offset = self.now.position - at.point.position;
        }
        self.now = KinematicState {
            position: at.point.position + self.offset,
            ..at.point
        };
    }

    /// Its position at an instant of the update that ends now: linear between the positions of two ticks.
    pub(super) fn position_at(&self, at: Instant, clock: &Clock) -> f64 {
        let share = (at.elapsed(clock) / clock.period()).clamp(0.0, 1.0);
        self.now.position - share * (self.now.position - self.before)
    }
}
