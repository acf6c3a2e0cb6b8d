//! The searches for an extension. Not here: their attempts and shares ([`crate::tuning::Attempts`], [`crate::tuning::Gentle`]).

use crate::solve::stages::Quality;
use crate::tuning::Attempt;

/// The search for an extension.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Search<'a> {
    /// From a warm start outside of the limits, by these attempts.
    Attempts(Quality, &'a [Attempt]),
    /// Within all limits from the warm start on, along evenly rounded corners.
    Gentle,
    /// As `Gentle`, also from instants long before the running motion brakes for its end.
    GentleSooner,
    /// Within all limits from the warm start on, along the smooth curve of dense chords.
    GentleAndSmooth,
}

impl Search<'_> {
    pub(crate) fn quality(self) -> Quality {
        match self {
            Search::Attempts(quality, _) => quality,
            Search::Gentle | Search::GentleSooner => Quality::TimingOnly,
            Search::GentleAndSmooth => Quality::Smooth,
        }
    }
}
