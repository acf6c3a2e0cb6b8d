//! The prediction of a stop on the path that would begin at an instant.
//!
//! A [`Stopping`] is the future state of the planner, or of a queue of contours, after [`Planner::stop_soonest`]; sampling it changes
//! no state. Nothing here allocates. Position units, seconds.

use arcline_geometry::Path;
use arcline_profile::{DynamicsBits, Limits};

use crate::move_trajectory::MoveTrajectory;
use crate::planner::Planner;
use crate::rotation_residual::RampingOut;
use crate::{Clock, MasterRate, Parameter, Sample};

/// A predicted stop on the path.
#[derive(Clone, Copy, Debug)]
pub struct Stopping {
    active: MoveTrajectory,
    tail: Option<MoveTrajectory>,
    /// The residual of the rotation of a move that a merge ended.
    ramping_out: Option<RampingOut>,
    /// The number of paths of [`Planner::beyond`] that it may cross.
    followed: usize,
    /// Seconds from its beginning to rest.
    duration: f64,
}

impl Stopping {
    /// Seconds from its beginning to rest.
    pub fn duration(&self) -> f64 {
        self.duration
    }
}

impl<T: Copy> Planner<T> {
    /// The stop of [`Planner::stop_soonest`] at `clock`, which may lie ahead of the present tick. Real-time.
    pub fn stopping(&self, limits: &Limits, clock: &Clock) -> Option<Stopping> {
        let limits = &self.allowed(limits);
        let before = self.before();
        let halted = |trajectory: &MoveTrajectory, before: Option<&Limits>| {
            let mut trajectory = *trajectory;
            trajectory.halt(limits, before, self.dynamics_bits, clock);
            trajectory
        };
        let active = halted(&self.active.as_ref()?.trajectory, before.as_ref());
        let tail = self.tail.as_ref().map(|tail| halted(tail, None));
        let followed = active.followed(self.paths_of_stop());
        Some(Stopping::of(active, tail, self.ramping_out, followed, clock))
    }

    /// The stop of [`Planner::stop_in_time`]; `clock` shows the displacement of the master at `time`, and `rate` is the rate of the
    /// displacement. Real-time.
    pub fn stopping_in_time(
        &self,
        limits: &Limits,
        rate: &MasterRate,
        clock: &Clock,
        time: &Clock,
    ) -> Option<Stopping> {
        let halted = |trajectory: &MoveTrajectory| {
            let mut trajectory = *trajectory;
            trajectory.stop_in_time(limits, self.dynamics_bits, rate, clock, time);
            trajectory
        };
        let active = halted(&self.active.as_ref()?.trajectory);
        let tail = self.tail.as_ref().map(halted);
        let out = self.ramping_out_in_time(rate, clock, time);
        let followed = active.followed(self.paths_of_stop());
        Some(Stopping::of(active, tail, out, followed, time))
    }

    /// The motion of the coordinate system at an instant of a predicted stop, which continues along the pending moves up to the first
    /// rest between them. Real-time.
    pub fn sample_stopping(&self, stopping: &Stopping, clock: &Clock) -> Sample {
        let beyond = self.paths_of_stop().map(|(path, _)| path);
        stopping.sample(beyond.take(stopping.followed), clock)
    }

    /// As [`Planner::stop`], but a motion whose own profile comes to rest sooner continues on that: the stop never takes longer than
    /// programmed. Real-time.
    pub fn stop_soonest(&mut self, limits: &Limits, clock: &Clock) {
        self.hand_over_at = None;
        let limits = &self.allowed(limits);
        let (before, dynamics_bits) = (self.before(), self.dynamics_bits);
        let running = self.active.iter_mut().map(|running| (&mut running.trajectory, before));
        for (trajectory, before) in running.chain(self.tail.iter_mut().map(|tail| (tail, None))) {
            trajectory.halt(limits, before.as_ref(), dynamics_bits, clock);
        }
        if let Some(running) = &mut self.active {
            running.motion.parameter = Parameter::TIME;
            running.exit = 0.0;
            running.joined = 0;
            running.stopped = true;
        }
        self.end_trail();
    }
}

impl Stopping {
    fn of(
        active: MoveTrajectory,
        tail: Option<MoveTrajectory>,
        ramping_out: Option<RampingOut>,
        followed: usize,
        clock: &Clock,
    ) -> Self {
        let left = |trajectory: &MoveTrajectory| trajectory.duration(clock) - trajectory.start.elapsed(clock);
        let turning = ramping_out.map_or(0.0, |out| out.rests_after(&clock.now(), clock));
        let duration = tail.iter().map(left).fold(left(&active), f64::max);
        Stopping {
            active,
            tail,
            ramping_out,
            followed,
            duration: duration.max(turning).max(0.0),
        }
    }

    fn sample<'a>(&self, trail: impl Iterator<Item = &'a Path>, clock: &Clock) -> Sample {
        let mut sample = self.active.sample_along(trail, clock);
        if let Some(tail) = &self.tail {
            sample = tail.add_rest(sample, clock);
        }
        if let Some(out) = &self.ramping_out {
            sample.rotation_state = Some(out.beside(sample.rotation_state, clock));
        }
        sample
    }
}

impl MoveTrajectory {
    /// Brakes from the clock's instant on, unless its own profile comes to rest sooner.
    fn halt(&mut self, limits: &Limits, before: Option<&Limits>, dynamics_bits: DynamicsBits, clock: &Clock) {
        let stop = self.stop_from(self.state(clock), limits, before, dynamics_bits);
        let left = self.profile.duration() - self.start.elapsed(clock);
        if self.profile.end().velocity != 0.0 || left > stop.duration() {
            self.replan(stop, clock.now());
        }
    }
}
