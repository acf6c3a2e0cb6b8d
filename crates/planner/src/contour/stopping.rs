//! A stop of a planned contour that begins at once, whatever the limits of the axes, and what it would do before it is needed.
//!
//! [`ContourQueue::stop`] waits for room within the limits of the axes; where a robot must not go on, there is no time for
//! that. Nothing here allocates. Position units, seconds.

use arcline_profile::{KinematicState, Limits};

use super::ContourQueue;
use super::pace::Pace;
use super::run::{Run, RunState};
use crate::tolerance::CREEPING_SHARE;
use crate::{Clock, Sample};

/// A stop at once that has not begun.
#[derive(Clone, Copy, Debug)]
pub struct ContourStopping(Pace);

impl ContourStopping {
    /// Seconds from its beginning to rest.
    pub fn duration(&self) -> f64 {
        self.0.duration()
    }
}

impl<T: Copy> ContourQueue<T> {
    /// The stop of [`ContourQueue::stop_at_once`] at `clock`, which may lie ahead of the present tick. `way`: how what
    /// `clock` shows goes on, where a master leads; `time` then shows time. Real-time.
    pub fn stopping(
        &self,
        limits: &Limits,
        rate: Option<&crate::MasterRate>,
        clock: &Clock,
        time: &Clock,
    ) -> Option<ContourStopping> {
        let run = self.run.as_ref()?;
        Some(ContourStopping(run.stopping(limits, rate, clock, time)))
    }

    /// Where the coordinate system would be at an instant of a stop. Real-time.
    pub fn sample_stopping(&self, stopping: &ContourStopping, clock: &Clock) -> Option<Sample> {
        let run = self.run.as_ref()?;
        Some(run.at(stopping.0.at(clock)))
    }

    /// Brakes on the path from the present tick on at the rates of `limits`, besides what the trajectory itself does there. The
    /// moves are the caller's to end. Real-time.
    pub fn stop_at_once(&mut self, limits: &Limits, clock: &Clock) {
        self.asked = None;
        if let Some(run) = &mut self.run {
            run.pace = run.stopping(limits, None, clock, clock);
            run.state = RunState::Stopping;
        }
    }
}

impl Run {
    fn stopping(&self, limits: &Limits, rate: Option<&crate::MasterRate>, clock: &Clock, time: &Clock) -> Pace {
        let now: KinematicState = self.pace.at(clock);
        let now = rate.map_or(now, |rate| rate.in_time(now));
        let speed = self
            .trajectory
            .at(now.position)
            .velocity
            .norm()
            .max(CREEPING_SHARE * limits.speed);
        let jerk = limits.jerk.map(|jerk| jerk.deceleration / speed);
        Pace::stopping(now, limits.deceleration / speed, jerk, time)
    }
}
