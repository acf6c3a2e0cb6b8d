//! A stop of a planned contour that begins at once, whatever the limits of the axes, and its prediction.
//!
//! [`ContourQueue::stop`] waits until the limits of the axes leave room; a robot at the end of its reach has no time for that. Nothing here
//! allocates. Position units, seconds.

use arcline_profile::{KinematicState, Limits};

use super::ContourQueue;
use super::pace::Pace;
use super::run::{RunState, RunningTrajectory};
use crate::tolerance::CREEPING_SHARE;
use crate::{Clock, Sample};

/// A predicted immediate stop.
#[derive(Clone, Copy, Debug)]
pub struct ContourStopping(Pace);

impl ContourStopping {
    /// Seconds from its beginning to rest.
    pub fn duration(&self) -> f64 {
        self.0.duration()
    }
}

impl<T: Copy> ContourQueue<T> {
    /// The stop of [`ContourQueue::stop_at_once`] at `clock`, which may lie ahead of the present tick. `rate`: the rate of `clock` if the contour
    /// is master driven; `time` then shows time. Real-time.
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

    /// The motion of the coordinate system at an instant of a predicted stop. Real-time.
    pub fn sample_stopping(&self, stopping: &ContourStopping, clock: &Clock) -> Option<Sample> {
        let run = self.run.as_ref()?;
        Some(run.at(stopping.0.at(&run.trajectory, clock)))
    }

    /// Brakes on the path from the present tick on at the rates of `limits`, in addition to the trajectory's own accelerations. The caller ends
    /// the moves. Real-time.
    pub fn stop_at_once(&mut self, limits: &Limits, clock: &Clock) {
        self.asked = None;
        if let Some(run) = &mut self.run {
            run.pace = run.stopping(limits, None, clock, clock);
            run.state = RunState::Stopping;
        }
    }
}

impl RunningTrajectory {
    /// The pace that brakes at the rates of `limits`; as [`ContourQueue::stopping`].
    pub(super) fn stopping(
        &self,
        limits: &Limits,
        rate: Option<&crate::MasterRate>,
        clock: &Clock,
        time: &Clock,
    ) -> Pace {
        let now: KinematicState = self.pace_at(clock);
        let now = rate.map_or(now, |rate| rate.in_time(now));
        let speed = self.speed_of_a_stop(now.position, limits);
        let jerk = limits.jerk.map(|jerk| jerk.deceleration / speed);
        Pace::stopping(now, limits.deceleration / speed, jerk, time)
    }

    /// The speed at an instant of the trajectory's own time, by which the rates of a stop become those of the pace.
    pub(super) fn speed_of_a_stop(&self, own: f64, limits: &Limits) -> f64 {
        let speed = self.trajectory.at(own).velocity.norm();
        speed.max(CREEPING_SHARE * limits.speed)
    }
}
