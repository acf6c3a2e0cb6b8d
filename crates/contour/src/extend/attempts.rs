//! The attempts of an extension, in their order, until one yields a motion. A slower motion is found more easily.

use crate::solve::relax::SlowDown;
use crate::solve::stages::Quality;

/// The parameters of one attempt to extend a running trajectory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attempt {
    /// Seconds after the first possible splice.
    pub(crate) later_s: f64,
    /// The instant at which the warm start leaves the running motion: times of braking before its end.
    pub(crate) brakings: f64,
    /// The part of dense chords that is slowed down first.
    pub(crate) slow_down: SlowDown,
    /// The smooth curve begins where the warm start leaves the running motion, not before.
    pub(crate) holds: bool,
}

/// The search for an extension.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Search<'a> {
    /// From a warm start outside of the limits, by these attempts.
    Attempts(Quality, &'a [Attempt]),
    /// Within all limits from the warm start on, along evenly rounded corners.
    Gentle,
    /// Within all limits from the warm start on, along the smooth curve of dense chords.
    GentleAndSmooth,
}

impl Search<'_> {
    pub(crate) fn quality(self) -> Quality {
        match self {
            Search::Attempts(quality, _) => quality,
            Search::Gentle => Quality::TimingOnly,
            Search::GentleAndSmooth => Quality::Smooth,
        }
    }
}

/// The attempts in their order.
pub(crate) const ATTEMPTS: [Attempt; 6] = [
    attempt(0.0, 1.0, SlowDown::Outside, false),
    attempt(0.0, 1.0, SlowDown::Whole, true),
    attempt(0.02, 1.0, SlowDown::Outside, false),
    attempt(0.04, 0.7, SlowDown::Whole, true),
    attempt(0.06, 0.45, SlowDown::Outside, false),
    attempt(0.08, 0.25, SlowDown::Whole, true),
];

/// For a short rest of the running motion: a splice at a slower instant succeeds more often than a slower motion only.
pub(crate) const SHORT_ATTEMPTS: [Attempt; 6] = [
    ATTEMPTS[0],
    ATTEMPTS[3],
    ATTEMPTS[1],
    ATTEMPTS[2],
    ATTEMPTS[4],
    ATTEMPTS[5],
];

const fn attempt(later_s: f64, brakings: f64, slow_down: SlowDown, holds: bool) -> Attempt {
    Attempt {
        later_s,
        brakings,
        slow_down,
        holds,
    }
}

/// Shares of gentle continuations: of the limits along the path for changes of the speed, and of the speed within all limits.
pub(crate) const GENTLE: [[f64; 2]; 5] = [[0.3, 0.8], [0.5, 0.8], [0.7, 0.8], [0.88, 0.8], [0.88, 0.4]];

/// The same shares along the smooth curve of dense chords.
pub(crate) const GENTLE_AND_SMOOTH: [[f64; 2]; 4] = [[0.2, 0.7], [0.3, 0.8], [0.5, 0.8], [0.8, 0.85]];
