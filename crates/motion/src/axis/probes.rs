//! The events that an axis waits for: a position that it passes (MAW), and edges of its registration inputs (MAR)
//! (spec/axis-and-data-types.md §5).
//!
//! A watch compares the actual motion once an update, with the position at which the axis turns back within it. Positions are position
//! units, times microseconds since the first tick. Nothing allocates.

use arcline_drive::{ArmLatch, Trigger};
use arcline_profile::KinematicState;

use crate::execution::Execution;
use crate::masters::displacement::Crossing;

/// The watch of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    armed: Option<ArmedWatch>,
    /// The event of the last MAW came.
    pub(crate) seen: bool,
    /// The position that was passed: WatchPosition.
    pub(crate) position: f64,
}

#[derive(Clone, Copy, Debug)]
struct ArmedWatch {
    execution: Execution,
    /// The watched position and direction, without the offset of redefined positions.
    crossing: Crossing,
    /// The position as it was programmed.
    position: f64,
    /// The actual motion at the last update, without the offset of redefined positions.
    last: KinematicState,
}

impl Watch {
    pub(crate) fn is_armed(&self) -> bool {
        self.armed.is_some()
    }

    /// `now`: the actual motion, without the offset of redefined positions.
    pub(crate) fn arm(&mut self, execution: Execution, crossing: Crossing, position: f64, now: KinematicState) {
        self.seen = false;
        self.armed = Some(ArmedWatch {
            execution,
            crossing,
            position,
            last: now,
        });
    }

    /// Ends the watch. Returns the execution of its MAW.
    pub(crate) fn disarm(&mut self) -> Option<Execution> {
        self.armed.take().map(|armed| armed.execution)
    }

    /// Compares the actual motion of an update of `period` seconds with the watched position; an update of 0 seconds is a straight line from
    /// position to position. Returns the execution whose event has come.
    pub(crate) fn check(&mut self, now: KinematicState, period: f64) -> Option<Execution> {
        let armed = self.armed.as_mut()?;
        let before = std::mem::replace(&mut armed.last, now);
        let turn = turning_position(&before, &now, period).unwrap_or(now.position);
        let is_crossed = |from, to| armed.crossing.crossed(from, to).is_some();
        if !is_crossed(before.position, turn) && !is_crossed(turn, now.position) {
            return None;
        }
        self.position = armed.position;
        self.seen = true;
        self.disarm()
    }
}

/// The position at which an axis turns back within an update of `period` seconds, by the cubic through both positions and velocities.
fn turning_position(before: &KinematicState, now: &KinematicState, period: f64) -> Option<f64> {
    let (leaving, arriving) = (before.velocity * period, now.velocity * period);
    if leaving * arriving >= 0.0 {
        return None;
    }
    let distance = now.position - before.position;
    let square = 3.0 * distance - 2.0 * leaving - arriving;
    let cube = leaving + arriving - 2.0 * distance;
    // The velocity `leaving + 2 square s + 3 cube s²` changes its sign once within the update.
    let root = square * square - 3.0 * cube * leaving;
    let sum = -(square + root.sqrt().copysign(square));
    let inside = |share: &f64| (0.0..=1.0).contains(share);
    let share = [leaving / sum, sum / (3.0 * cube)].into_iter().find(inside)?;
    Some(before.position + share * (leaving + share * (square + share * cube)))
}

/// One registration input of an axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Registration {
    /// There is such an input.
    pub(crate) exists: bool,
    armed: Option<ArmedRegistration>,
    /// The event of the last MAR came.
    pub(crate) seen: bool,
    /// Positions at the last event, the last one of a positive edge, and of a negative one.
    pub(crate) positions: [f64; 3],
    /// The times of the same events.
    pub(crate) times: [i32; 3],
}

#[derive(Clone, Copy, Debug)]
struct ArmedRegistration {
    execution: Execution,
    /// The edge that it waits for is positive.
    positive: bool,
    /// The window of positions within which an edge counts.
    window: Option<[f64; 2]>,
    /// The latch of the drive.
    latch: ArmLatch,
}

impl Registration {
    pub(crate) fn new(exists: bool) -> Self {
        Registration {
            exists,
            ..Registration::default()
        }
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.armed.is_some()
    }

    pub(crate) fn arm(&mut self, execution: Execution, latch: ArmLatch, window: Option<[f64; 2]>) {
        self.seen = false;
        self.armed = Some(ArmedRegistration {
            execution,
            positive: latch.trigger == Trigger::RegistrationOn,
            window,
            latch,
        });
    }

    /// The latch that is armed at the drive.
    pub(crate) fn latch(&self) -> Option<ArmLatch> {
        Some(self.armed?.latch)
    }

    /// Arms another latch for the next edge, since the last one closed outside of the window.
    pub(crate) fn arm_again(&mut self, latch: ArmLatch) {
        if let Some(armed) = &mut self.armed {
            armed.latch = latch;
        }
    }

    /// Ends the wait for an edge. Returns the execution of its MAR.
    pub(crate) fn disarm(&mut self) -> Option<Execution> {
        self.armed.take().map(|armed| armed.execution)
    }

    /// Takes an edge at a position that the axis shows. Returns the execution whose event has come.
    pub(crate) fn edge(&mut self, positive: bool, position: f64, time: i32) -> Option<Execution> {
        let armed = self.armed?;
        let inside = |[from, to]: [f64; 2]| (from..=to).contains(&position);
        if armed.positive != positive || !armed.window.is_none_or(inside) {
            return None;
        }
        for slot in [0, if positive { 1 } else { 2 }] {
            self.positions[slot] = position;
            self.times[slot] = time;
        }
        self.seen = true;
        self.disarm()
    }
}
