//! A trajectory in execution, and the plan requested to continue it.
//!
//! Not here: the request of a plan ([`super::requests`]), and changes of the pace ([`super::pace`]).

use std::sync::Arc;

use arcline_contour::Trajectory;
use arcline_geometry::Point;
use arcline_profile::{Jerk, KinematicState, Limits, Phase};

use super::pace::Pace;
use crate::tolerance::{RIPPLE_S, SAME_INSTANT_S, STEADY_SHARE};
use crate::{Clock, Instant, Sample};

/// A requested plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PlanRequest {
    /// A contour from rest.
    Contour,
    /// The continuation of a trajectory in execution.
    Extension {
        /// Its moves that were complete at the request.
        passed: usize,
    },
    /// The rest of a trajectory in execution at a constant pace: for changed moves, or its extension from a low pace.
    Anew {
        /// Its moves that were complete at the request.
        passed: usize,
        /// Its pace at the request.
        pace: f64,
    },
}

/// A trajectory in execution.
#[derive(Debug)]
pub(super) struct RunningTrajectory {
    pub(super) trajectory: Arc<Trajectory>,
    /// Its moves that are complete.
    pub(super) passed: usize,
    /// The instant at which its active move became active, in time and in seconds of the trajectory's own time.
    pub(super) begun: (Instant, f64),
    /// A reference point of the active move: seconds of the trajectory's own time, and the distance covered there, units along the curve.
    pub(super) gone: (f64, f64),
    /// The end of the rounded corner before the active move, seconds of the trajectory's own time.
    pub(super) rounded: f64,
    /// The pace of its own time.
    pub(super) pace: Pace,
    /// Its moves have changed since it was planned.
    pub(super) stale: bool,
    /// Its first move stood at its beginning: its speed was 0.
    pub(super) stood: bool,
    /// The instant of that change.
    pub(super) changed: Instant,
    pub(super) state: RunState,
    /// Its pace is lower, as the plan of its extension is late or was not found.
    pub(super) waits_for_extension: bool,
    /// The position on it from which on an extension may be requested at a low pace, seconds of its own time; `None`: no plan of an extension of it
    /// came too late, or was not found.
    pub(super) slowed_retry: Option<f64>,
    /// The time reserved for planning an extension, seconds of the trajectory's own time.
    pub(super) planning_s: f64,
    /// The position on it at the last request, seconds of its own time.
    pub(super) asked: f64,
    /// The position on it at which the requested plan is late, seconds of its own time.
    pub(super) due: f64,
    /// The position on it from which on an extension may be requested again, seconds of its own time.
    pub(super) retry: f64,
    /// The nominal speed of the master for which it was planned, master units/s; 1 for time.
    pub(super) nominal: f64,
}

/// The meaning of a pace of 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RunState {
    /// A pace of 0 is a hold: the trajectory continues when the pace rises again.
    Travelling,
    /// A pace of 0 is the end.
    Stopping,
}

impl RunningTrajectory {
    /// The trajectory's own time, the pace and its derivative at the present tick.
    pub(super) fn pace_at(&self, clock: &Clock) -> KinematicState {
        self.pace.at(&self.trajectory, clock)
    }

    /// The limits of its active move when it was planned.
    pub(super) fn limits(&self) -> Limits {
        let planned = self
            .trajectory
            .rates(self.passed)
            .unwrap_or(self.trajectory.least_rates());
        Limits {
            speed: planned.speed,
            acceleration: planned.acceleration,
            deceleration: planned.deceleration,
            jerk: planned.jerk.map(both),
        }
    }

    /// Nothing of it has been travelled.
    pub(super) fn is_at_its_beginning(&self, clock: &Clock) -> bool {
        let at = self.pace_at(clock);
        self.passed == 0 && at.position == 0.0 && at.velocity == 0.0
    }

    /// It waits at its beginning for a plan from rest with the speed that its first move, which stood, has now. A plan for another speed would be
    /// travelled at a pace whose square scales the acceleration.
    pub(super) fn waits(&self, clock: &Clock) -> bool {
        self.stood && self.stale && self.is_at_its_beginning(clock)
    }

    /// The motion of the coordinate system at an instant of the trajectory's own time and a pace.
    pub(super) fn at(&self, pace: KinematicState) -> Sample {
        let duration = self.trajectory.duration();
        let own = if pace.position >= duration - SAME_INSTANT_S {
            duration
        } else {
            pace.position
        };
        let at = self.trajectory.at(own);
        let velocity: Point = at.velocity * pace.velocity;
        let acceleration = at.acceleration * (pace.velocity * pace.velocity) + at.velocity * pace.acceleration;
        let speed = velocity.norm();
        let tangential = if speed > 0.0 {
            velocity.dot(&acceleration) / speed
        } else {
            0.0
        };
        Sample {
            position: at.position,
            velocity,
            acceleration,
            along: KinematicState {
                position: self.gone_at(own),
                velocity: speed,
                acceleration: tangential,
            },
            phase: self.phase(own, &velocity, tangential, &pace),
            rotation_state: None,
        }
    }

    /// The distance of the active move covered at an instant of the trajectory's own time, units along the curve.
    pub(super) fn gone_at(&self, own: f64) -> f64 {
        let (at, gone) = self.gone;
        (gone + self.trajectory.arc_length(own) - self.trajectory.arc_length(at)).max(0.0)
    }

    /// The phase of the speed along the curve. A planned contour always has a small tangential acceleration: less than a hundredth of the
    /// limits of the move and the axes in that direction, at the present pace, counts as steady, and so does a ripple of the speed, an
    /// acceleration that the time before or after the instant does not continue.
    fn phase(&self, own: f64, velocity: &Point, tangential: f64, pace: &KinematicState) -> Phase {
        let speed = velocity.norm();
        let axes = self.trajectory.axes().acceleration;
        let most = (0..3).fold(f64::INFINITY, |most, axis| {
            most.min(axes[axis] * speed / velocity[axis].abs())
        });
        let rates = self.trajectory.rates(self.passed);
        let rate = if tangential > 0.0 {
            rates.map(|rates| rates.acceleration)
        } else {
            rates.map(|rates| rates.deceleration)
        };
        let rate = rate.map_or(most, |rate| most.min(rate));
        // Close to rest, any acceleration counts.
        let creeps = rates.is_none_or(|rates| speed < STEADY_SHARE * pace.velocity * rates.speed);
        let share = if creeps { 0.0 } else { STEADY_SHARE };
        if tangential.abs() <= share * pace.velocity * pace.velocity * rate {
            return Phase::Steady;
        }
        let lasts = || {
            let means = [own - RIPPLE_S, own + RIPPLE_S].map(|other| self.mean_acceleration(own, other));
            let enough = |mean: f64| mean * tangential.signum() > 2.0 * share * rate;
            means.into_iter().flatten().all(enough)
        };
        match tangential > 0.0 {
            _ if pace.acceleration == 0.0 && !lasts() => Phase::Steady,
            true => Phase::Accelerating,
            false => Phase::Decelerating,
        }
    }

    /// The mean acceleration along the curve between an instant of the trajectory's own time and another one, or an end of the trajectory;
    /// `None` at this end.
    fn mean_acceleration(&self, own: f64, other: f64) -> Option<f64> {
        let other = other.clamp(0.0, self.trajectory.duration());
        let speed = |own: f64| self.trajectory.at(own).velocity.norm();
        ((other - own).abs() > SAME_INSTANT_S).then(|| (speed(other) - speed(own)) / (other - own))
    }
}

/// The same jerk while speeding up and while slowing down.
pub(super) fn both(jerk: f64) -> Jerk {
    Jerk {
        acceleration: jerk,
        deceleration: jerk,
    }
}

/// The jerk for which a contour is planned.
pub(super) fn least(jerk: Jerk) -> f64 {
    jerk.acceleration.min(jerk.deceleration)
}
