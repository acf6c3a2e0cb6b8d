//! An axis that only shows positions written by clients: an encoder (type `feedback`).
//!
//! From one written position to the next the axis moves in a straight line, over the interval at which positions are expected. It
//! therefore lags by one interval, and a slave sees no steps. The first position, and the first one after a fault, redefines the
//! position of the axis without motion. Units: position units as written, seconds. Nothing allocates.

use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::Axis;
use crate::machine::FeedTag;
use crate::rotary;

/// The positions of an encoder as a client writes them, and the axis between two of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EncoderFeed {
    /// Time over which the axis goes from one position to the next.
    interval: f64,
    /// The age at which the last position is stale.
    timeout: f64,
    /// The position of the axis when the last position was written, and the written position.
    from: f64,
    to: f64,
    /// The offset by which the axis's position was redefined, besides the one that the first position caused.
    offset: f64,
    /// The instant at which the last position was written; `None`: the next one redefines the position of the axis.
    since: Option<Instant>,
    /// The last position is older than the timeout.
    stale: bool,
}

/// The effect of a written position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FeedEffect {
    /// The axis moves to it.
    Followed,
    /// The axis is at the position at once; its position is redefined by this offset.
    Placed(f64),
}

impl EncoderFeed {
    pub(crate) fn new(feed: &FeedTag, position: f64) -> Self {
        EncoderFeed {
            interval: feed.interval,
            timeout: feed.timeout,
            from: position,
            to: position,
            offset: 0.0,
            since: None,
            stale: false,
        }
    }

    /// Takes a written position. A rotary axis takes it on the turn nearest to its last one.
    pub(crate) fn take(&mut self, position: f64, unwind: Option<f64>, clock: &Clock) -> FeedEffect {
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
            return FeedEffect::Placed(displacement);
        }
        (self.from, self.to) = (now, now + displacement);
        FeedEffect::Followed
    }

    /// The position of the axis is redefined by an offset.
    pub(crate) fn redefine(&mut self, offset: f64) {
        self.offset += offset;
        self.from += offset;
        self.to += offset;
    }

    /// The position and velocity of the axis at the present tick.
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

    /// The last position is too old. A stale position stays stale until a client writes the next one.
    pub(crate) fn is_stale(&mut self, clock: &Clock) -> bool {
        self.stale |= self.since.is_some_and(|since| since.elapsed(clock) > self.timeout);
        self.stale
    }
}

impl Axis {
    /// The position and velocity of an axis fed by a tag; `None` for other axes.
    pub(crate) fn fed(&self, clock: &Clock) -> Option<KinematicState> {
        Some(self.feeding?.at(clock))
    }

    /// Shifts the position of the axis without motion.
    pub(crate) fn shift_fed_position(&mut self, offset: f64) {
        self.sum.redefine(offset);
        self.shift(offset);
    }
}
