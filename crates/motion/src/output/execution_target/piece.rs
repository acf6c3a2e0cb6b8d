//! The part of an update in which no instruction changes the motion of an axis.

use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::super::interpolation::Interpolation;

/// A motion of the axis within an update, or a change of its speed at the beginning of one.
pub(super) struct Piece {
    pub(super) from: KinematicState,
    pub(super) to: KinematicState,
    pub(super) jumps: bool,
    pub(super) period: f64,
}

impl Piece {
    /// The position of the axis, `delay` seconds ahead.
    pub(super) fn interpolation(&self, delay: f64) -> Interpolation {
        let [from, to] = [&self.from, &self.to].map(|point| {
            let rate = point.velocity + delay * point.acceleration;
            [point.position + delay * point.velocity, rate]
        });
        if self.jumps {
            Interpolation::step(from[0], to[0])
        } else {
            Interpolation::new(from, to, self.period)
        }
    }
}

/// The instant of a share of an update.
pub(super) fn instant(piece: &Piece, share: f64, clock: &Clock) -> Instant {
    let began = Clock::at(clock.tick.saturating_sub(1), clock.period_ns);
    if piece.jumps {
        return began.now();
    }
    if share >= 1.0 {
        return clock.now();
    }
    began.now().after(share * piece.period, &began)
}
