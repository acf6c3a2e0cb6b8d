//! A trajectory in execution, and the plan that is to continue it.
//!
//! Not here: when a plan is asked for ([`super::requests`]), and how the pace changes ([`super::pace`]).

use std::sync::Arc;

use arcline_contour::Trajectory;
use arcline_geometry::Point;
use arcline_profile::{Jerk, KinematicState, Phase};

use super::pace::Pace;
use crate::tolerance::{SAME_INSTANT_S, STEADY_SHARE};
use crate::{Instant, Sample};

/// A plan under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Asked {
    /// From rest.
    Contour,
    /// Of what follows a trajectory in execution, of which so many moves had been completed then.
    Extension {
        /// Moves of it that had been completed.
        passed: usize,
    },
    /// Of what is left of a trajectory in execution, with what its moves are to have now.
    Anew {
        /// Moves of it that had been completed.
        passed: usize,
        /// The pace that it was travelled at.
        pace: f64,
    },
}

/// A trajectory in execution.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) trajectory: Arc<Trajectory>,
    /// Moves of it that have been completed.
    pub(super) passed: usize,
    /// When its active move became active, and where that was, seconds on the trajectory's own time.
    pub(super) begun: (Instant, f64),
    /// How far the active move had gone at a place on the trajectory's own time: that place in seconds, and units along the curve.
    pub(super) gone: (f64, f64),
    /// Until when the corner before the active move is rounded, seconds on the trajectory's own time.
    pub(super) rounded: f64,
    /// How fast its own time runs.
    pub(super) pace: Pace,
    /// It was not planned for what its moves are to have now.
    pub(super) stale: bool,
    /// Since when they are to have that.
    pub(super) changed: Instant,
    pub(super) state: RunState,
    /// How long a plan that extends it may take, seconds on the trajectory's own time.
    pub(super) lead: f64,
    /// Where on it the last one was asked for.
    pub(super) asked: f64,
    /// Where on it an extension may be asked for again.
    pub(super) retry: f64,
    /// The speed of the master that it was planned for, master units/s; 1 for time.
    pub(super) nominal: f64,
}

/// Whether a trajectory in execution is travelled or stopped: the meaning of a pace of 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RunState {
    /// A pace of 0 is a hold: the trajectory goes on when the pace rises again.
    Travelling,
    /// A pace of 0 is the end.
    Stopping,
}

impl Run {
    /// Where the coordinate system is at a place of the trajectory's own time that goes on like this.
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

    /// How far the active move has gone along the curve at an instant of the trajectory's own time, units.
    pub(super) fn gone_at(&self, own: f64) -> f64 {
        let (at, gone) = self.gone;
        (gone + self.trajectory.arc_length(own) - self.trajectory.arc_length(at)).max(0.0)
    }

    /// Whether the speed along the curve rises or falls: a tangential acceleration of less than a hundredth of what the move and the axes may have
    /// in that direction, at the present pace, is none, as a planned contour is never quite without one.
    fn phase(&self, velocity: &Point, tangential: f64, pace: f64) -> Phase {
        let speed = velocity.norm();
        let axes = self.trajectory.axes().acceleration;
        let most = (0..3).fold(f64::INFINITY, |most, axis| {
            most.min(axes[axis] * speed / velocity[axis].abs())
        });
        let rates = self.trajectory.rates(self.passed);
        // Where it is about to start or has all but stopped, any is one.
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

/// The jerk that a contour is planned with.
pub(super) fn least(jerk: Jerk) -> f64 {
    jerk.acceleration.min(jerk.deceleration)
}
