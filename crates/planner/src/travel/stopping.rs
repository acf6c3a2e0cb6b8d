//! Stops on the path, and their prediction.

use arcline_geometry::{Path, Rotation};
use arcline_profile::Limits;

use super::Travel;
use crate::contour::ContourStopping;
use crate::stopping::Stopping;
use crate::{Clock, Sample, TimeBase};

/// A predicted stop on the path.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate in the tick")]
pub enum PathStopping {
    /// A stop of superposed moves.
    Superposed(Stopping),
    /// A stop of a contour.
    Contour(ContourStopping),
}

impl PathStopping {
    /// Seconds from its beginning to rest.
    pub fn duration(&self) -> f64 {
        match self {
            PathStopping::Superposed(stopping) => stopping.duration(),
            PathStopping::Contour(stopping) => stopping.duration(),
        }
    }
}

impl<T: Copy> Travel<T> {
    /// Brakes on the path, by time from now on. The caller ends the moves.
    pub fn stop(&mut self, limits: &Limits, base: &TimeBase) {
        let (clock, rate) = (self.contour_clock(base), self.contour_rate(base));
        match (self.contour_in_force_mut(), &base.master) {
            (Some(contour), None) => contour.stop(limits, &clock),
            (Some(contour), Some(_)) => contour.stop_in_time(limits, &rate, &clock, &base.time),
            (None, None) => self.planner.stop(limits, &base.time),
            (None, Some(master)) => self
                .planner
                .stop_in_time(limits, &master.rate, &base.clock(), &base.time),
        }
    }

    /// As [`Travel::stop`] of a move by time, for a robot at the end of its reach: a contour brakes without waiting for room within the limits of
    /// the axes, and a motion whose own profile comes to rest sooner continues on that.
    pub fn stop_soonest(&mut self, limits: &Limits, time: &Clock) {
        match self.contour_in_force_mut() {
            Some(contour) => contour.stop_at_once(limits, time),
            None => self.planner.stop_soonest(limits, time),
        }
    }

    /// The stop of [`Travel::stop_soonest`], or of [`Travel::stop`] of a driven move, at the instant of `base`, which may lie ahead.
    pub fn stopping(&self, limits: &Limits, base: &TimeBase) -> Option<PathStopping> {
        let time = &base.time;
        match (self.contour_in_force(), &base.master) {
            (Some(contour), master) => {
                let rate = master.as_ref().map(|_| self.contour_rate(base));
                let stopping = contour.stopping(limits, rate.as_ref(), &self.contour_clock(base), time);
                stopping.map(PathStopping::Contour)
            }
            (None, None) => self.planner.stopping(limits, time).map(PathStopping::Superposed),
            (None, Some(master)) => {
                let stopping = self.planner.stopping_in_time(limits, &master.rate, &base.clock(), time);
                stopping.map(PathStopping::Superposed)
            }
        }
    }

    /// The motion of the coordinate system at an instant of a predicted stop.
    pub fn sample_stopping(&self, stopping: &PathStopping, time: &Clock) -> Option<Sample> {
        match stopping {
            PathStopping::Superposed(stopping) => Some(self.planner.sample_stopping(stopping, time)),
            PathStopping::Contour(stopping) => self.contour.as_ref()?.sample_stopping(stopping, time),
        }
    }

    /// The path and the rotation of the move with which the active one blends.
    pub fn tail(&self) -> Option<(&Path, Option<&Rotation>)> {
        self.planner.tail()
    }

    /// Brakes the move with which the active one blends, with limits of its own; a stop of all has just begun.
    pub fn stop_tail(&mut self, limits: &Limits, time: &Clock) {
        self.planner.stop_tail(limits, time);
    }
}
