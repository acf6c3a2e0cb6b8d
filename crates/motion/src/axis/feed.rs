//! An axis that only shows positions which clients write: an encoder (type `feedback`).
//!
//! From one written position to the next the axis moves in a straight line, over the interval at which positions are
//! expected: it lags by that much, and a slave sees no steps. The first position, and the first one after a fault, is
//! where the axis is without having moved there. Units: position units as written, seconds. Nothing allocates.

use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::Axis;
use crate::machine::Feed;
use crate::rotary;

/// The positions of an encoder as a client writes them, and the axis between two of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Feeding {
    /// Time over which the axis goes from one position to the next.
    interval: f64,
    /// How old a position may become.
    timeout: f64,
    /// Where it was when the last position was written, and where it goes.
    from: f64,
    to: f64,
    /// What the axis's position was redefined by, besides what it was placed by.
    offset: f64,
    /// When the last position was written; `None`: the next one is where the axis is.
    since: Option<Instant>,
    /// Too long ago.
    stale: bool,
}

/// What comes of a written position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fed {
    /// The axis moves there.
    Followed,
    /// The axis is there: its position is redefined by so much.
    Placed(f64),
}

impl Feeding {
    pub(crate) fn new(feed: &Feed, position: f64) -> Self {
        Feeding {
            interval: feed.interval,
            timeout: feed.timeout,
            from: position,
            to: position,
            offset: 0.0,
            since: None,
            stale: false,
        }
    }

    /// Takes a position. Of a rotary axis it is a position of the nearest turn.
    pub(crate) fn take(&mut self, position: f64, unwind: Option<f64>, clock: &Clock) -> Fed {
        let now = self.at(clock).position;
        let displacement = match unwind {
            None => position + self.offset - now,
            Some(unwind) => {
                let displacement = rotary::shown(position + self.offset - now, unwind);
                if displacement > 0.5 * unwind {
                    displacement - unwind
                } else {
                    displacement
                }
            }
        };
        let first = self.since.replace(clock.now()).is_none() || self.stale;
        self.stale = false;
        if first {
            (self.from, self.to) = (now + displacement, now + displacement);
            return Fed::Placed(displacement);
        }
        (self.from, self.to) = (now, now + displacement);
        Fed::Followed
    }

    /// The position of the axis is redefined by an offset.
    pub(crate) fn redefine(&mut self, offset: f64) {
        self.offset += offset;
        self.from += offset;
        self.to += offset;
    }

    /// Where the axis is.
    pub(crate) fn at(&self, clock: &Clock) -> KinematicState {
        let elapsed = self.since.map_or(self.interval, |since| since.elapsed(clock));
        let displacement = self.to - self.from;
        let moves = self.since.is_some() && elapsed <= self.interval;
        let share = if self.interval > 0.0 {
            elapsed / self.interval
        } else {
            1.0
        };
        KinematicState {
            position: if share < 1.0 {
                self.from + displacement * share
            } else {
                self.to
            },
            velocity: if moves && self.interval > 0.0 {
                displacement / self.interval
            } else {
                0.0
            },
            acceleration: 0.0,
        }
    }

    /// Whether the last position is too old. It is then for good, until the next one comes.
    pub(crate) fn is_stale(&mut self, clock: &Clock) -> bool {
        self.stale |= self.since.is_some_and(|since| since.elapsed(clock) > self.timeout);
        self.stale
    }
}

impl Axis {
    /// Where an axis that is fed is now.
    pub(crate) fn fed(&self, clock: &Clock) -> Option<KinematicState> {
        Some(self.feeding?.at(clock))
    }

    /// The axis is somewhere else without having moved there.
    pub(crate) fn shift_fed_position(&mut self, offset: f64) {
        self.sum.redefine(offset);
        self.shift(offset);
    }
}
