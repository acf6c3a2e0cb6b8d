//! A trajectory in execution, and the plan requested to continue it.
//!
//! Not here: the request of a plan ([`super::requests`]), and changes of the pace ([`super::pace`]).

use std::sync::Arc;

use arcline_contour::Trajectory;
use arcline_geometry::Point;
use arcline_profile::{Jerk, KinematicState, Phase};

use super::pace::Pace;
use crate::tolerance::{SAME_INSTANT_S, STEADY_SHARE};
use crate::{Instant, Sample};

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
    /// The rest of a trajectory in execution, for changed moves.
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
    /// The instant of that change.
    pub(super) changed: Instant,
    pub(super) state: RunState,
    /// The time reserved for planning an extension, seconds of the trajectory's own time.
    pub(super) planning_s: f64,
    /// The position on it at the last request, seconds of its own time.
    pub(super) asked: f64,
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
            phase: self.phase(&velocity, tangential, pace.velocity),
            rotation_state: None,
        }
    }

    /// The distance of the active move covered at an instant of the trajectory's own time, units along the curve.
    pub(super) fn gone_at(&self, own: f64) -> f64 {
        let (at, gone) = self.gone;
        (gone + self.trajectory.arc_length(own) - self.trajectory.arc_length(at)).max(0.0)
    }

    /// The phase of the speed along the curve. A planned contour always has a small tangential acceleration: less than a hundredth of the
    /// limits of the move and the axes in that direction, at the present pace, counts as steady.
    fn phase(&self, velocity: &Point, tangential: f64, pace: f64) -> Phase {
        let speed = velocity.norm();
        let axes = self.trajectory.axes().acceleration;
        let most = (0..3).fold(f64::INFINITY, |most, axis| {
            most.min(axes[axis] * speed / velocity[axis].abs())
        });
        let rates = self.trajectory.rates(self.passed);
        // Close to rest, any acceleration counts.
        let creeps = rates.is_none_or(|rates| speed < STEADY_SHARE * pace * rates.speed);
        let share = if creeps { 0.0 } else { STEADY_SHARE * pace * pace };
        let slight = |programmed: Option<f64>| share * programmed.map_or(most, |rate| most.min(rate));
        if tangential > slight(rates.map(|rates| rates.acceleration)) {
            Phase::Accelerating
        } else if -tangential > slight(rates.map(|rates| rates.deceleration)) {
            Phase::Decelerating
        } else {
            Phase::Steady
        }
    }
}

/// The jerk for which a contour is planned.
pub(super) fn least(jerk: Jerk) -> f64 {
    jerk.acceleration.min(jerk.deceleration)
}
