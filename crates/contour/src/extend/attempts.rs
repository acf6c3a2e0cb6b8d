//! What is tried for an extension, one after the other, until a motion is found. From a slower motion one is found more easily.

use crate::solve::relax::SlowDown;
use crate::solve::stages::Quality;

/// One way to extend a running trajectory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attempt {
    /// Seconds behind the first possible splice.
    pub(crate) later_s: f64,
    /// When the running motion is left: times of braking before its end.
    pub(crate) brakings: f64,
    /// Which part of dense chords is slowed down first.
    pub(crate) slow_down: SlowDown,
}

/// How an extension is looked for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Search<'a> {
    /// From a first guess outside of the limits, by these attempts.
    Attempts(Quality, &'a [Attempt]),
    /// Within all limits from the first guess on, along evenly rounded corners.
    Gentle,
    /// Within all limits from the first guess on, along the smooth curve of dense chords.
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

/// In their order.
pub(crate) const ATTEMPTS: [Attempt; 6] = [
    attempt(0.0, 1.0, SlowDown::Outside),
    attempt(0.0, 1.0, SlowDown::Whole),
    attempt(0.02, 1.0, SlowDown::Outside),
    attempt(0.04, 0.7, SlowDown::Whole),
    attempt(0.06, 0.45, SlowDown::Outside),
    attempt(0.08, 0.25, SlowDown::Whole),
];

/// Where little is left of the running motion: what begins at a slower instant of it is found more often than what only slows down more.
pub(crate) const SHORT_ATTEMPTS: [Attempt; 6] = [
    ATTEMPTS[0],
    ATTEMPTS[3],
    ATTEMPTS[1],
    ATTEMPTS[2],
    ATTEMPTS[4],
    ATTEMPTS[5],
];

const fn attempt(later_s: f64, brakings: f64, slow_down: SlowDown) -> Attempt {
    Attempt {
        later_s,
        brakings,
        slow_down,
    }
}

/// Gentle ways to go on: share of the limits along the path with which the speed changes, and of the speed at which nothing is above a limit.
pub(crate) const GENTLE: [[f64; 2]; 5] = [[0.3, 0.8], [0.5, 0.8], [0.7, 0.8], [0.88, 0.8], [0.88, 0.4]];

/// The same shares along the smooth curve of dense chords.
pub(crate) const GENTLE_AND_SMOOTH: [[f64; 2]; 4] = [[0.2, 0.7], [0.3, 0.8], [0.5, 0.8], [0.8, 0.85]];
