//! A move as queued, and in execution: its path, its limits, and the parameters of its profile.
//!
//! Units: position units, seconds.

use arcline_geometry::{Path, Point, Rotation};
use arcline_profile::{AccelerationRemovalPhase, Jerk, KinematicState, Limits};

use crate::Instant;
use crate::junction::Ending;
use crate::move_trajectory::MoveTrajectory;

/// A path and the limits along it. `T` is the owner's own data.
#[derive(Clone, Copy, Debug)]
pub struct Move<T> {
    /// The geometric path, by arc length.
    pub path: Path,
    /// The rotation of the orientation along the path, even by arc length, or the constant orientation; `None`: no move of the queue rotates it.
    pub rotation: Option<Rotation>,
    /// The highest speed at its start if there is a corner before it, in its variable; infinite: the limits of the axes decide.
    pub corner: f64,
    /// Limits of the speed along the path and of its derivatives.
    pub limits: Limits,
    /// The last speed of `limits` that was not 0: a contour is planned for it while the move stands.
    pub last_speed: f64,
    /// The kind of its end, if it has a successor.
    pub ending: Ending,
    /// The variable that it is a function of.
    pub parameter: Parameter,
    /// The owner's own data.
    pub data: T,
}

impl<T> Move<T> {
    /// One contour may lead from it into the next move: both are functions of the same variable, and the next one does not stand where this one moves.
    pub(crate) fn leads_into(&self, next: &Move<T>) -> bool {
        let stands = next.limits.speed == 0.0 && self.limits.speed > 0.0;
        self.ending != Ending::Stop && self.parameter == next.parameter && !stands
    }

    /// Changes its limits; a speed of 0 leaves the last speed as it was.
    pub(crate) fn set_limits(&mut self, limits: Limits) {
        self.limits = limits;
        if limits.speed > 0.0 {
            self.last_speed = limits.speed;
        }
    }
}

/// The variable of a move: time, or one of the master displacements that its owner numbers. All clocks passed to a planner show that of its
/// active move. Between moves with different variables there is a rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// The number of the displacement; 0: time.
    pub number: u32,
    /// The nominal speed of the master, master units/s, more than 0, for which corners are limited; 1 for time.
    pub speed: f64,
}

impl Parameter {
    /// Time.
    pub const TIME: Parameter = Parameter { number: 0, speed: 1.0 };

    /// Converts limits over the displacement to limits over time, at the nominal speed.
    #[must_use]
    pub fn in_time(&self, limits: &Limits) -> Limits {
        let (once, twice) = (self.speed, self.speed * self.speed);
        Limits {
            speed: limits.speed * once,
            acceleration: limits.acceleration * twice,
            deceleration: limits.deceleration * twice,
            jerk: limits.jerk.map(|jerk| Jerk {
                acceleration: jerk.acceleration * twice * once,
                deceleration: jerk.deceleration * twice * once,
            }),
        }
    }
}

/// The move being interpolated.
#[derive(Clone, Copy, Debug)]
pub struct Running<T> {
    /// The move itself.
    pub motion: Move<T>,
    pub(crate) trajectory: MoveTrajectory,
    /// The instant at which it became active.
    pub(crate) begun: Instant,
    /// Speed at the end of the profile.
    pub(crate) exit: f64,
    /// Pending moves that the profile crosses, too.
    pub(crate) joined: usize,
    /// Another move blended into it.
    pub(crate) blended: bool,
    /// Its beginning on its run of moves.
    pub(crate) run_start: f64,
    /// A stop brakes it; no change affects that.
    pub(crate) stopped: bool,
    /// The programmed limits of its profile: not those of the move if a pause is shorter with others.
    pub(crate) in_force: Limits,
    /// The limits in force are not those of the move.
    pub(crate) has_other_limits: bool,
    /// The removal of an acceleration at the beginning of its profile.
    pub(crate) removal: AccelerationRemoval,
}

/// The removal of an acceleration that is present when a profile begins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AccelerationRemoval {
    /// Raises the jerk such that the speed does not exceed this.
    pub(crate) ceiling: f64,
    /// Raises the jerk to at least this, units/s³, such that the motion does not pass through rest.
    pub(crate) forward: Option<f64>,
}

impl AccelerationRemoval {
    /// With the limits of the profile.
    pub(crate) const NONE: AccelerationRemoval = AccelerationRemoval {
        ceiling: f64::INFINITY,
        forward: None,
    };

    /// For a deceleration from the previous move: the motion does not pass through rest.
    pub(crate) const FORWARD: AccelerationRemoval = AccelerationRemoval {
        ceiling: f64::MAX,
        forward: Some(0.0),
    };

    pub(crate) fn phase(&self, from: KinematicState, limits: &Limits) -> Option<AccelerationRemovalPhase> {
        if self.ceiling.is_infinite() {
            None
        } else if let (Some(least), true) = (self.forward, from.velocity * from.acceleration < 0.0) {
            let removal_phase = AccelerationRemovalPhase::before_rest(from, limits)?;
            let jerk = removal_phase.jerk.max(least);
            Some(AccelerationRemovalPhase { jerk, ..removal_phase })
        } else {
            AccelerationRemovalPhase::below(from, limits, self.ceiling)
        }
    }
}

impl<T: Copy> Running<T> {
    /// A move that becomes active as its trajectory starts, not yet planned.
    pub(crate) fn new(motion: Move<T>, trajectory: MoveTrajectory) -> Self {
        Running {
            motion,
            trajectory,
            begun: trajectory.start,
            exit: 0.0,
            joined: 0,
            blended: false,
            run_start: 0.0,
            stopped: false,
            in_force: motion.limits,
            has_other_limits: false,
            removal: AccelerationRemoval::NONE,
        }
    }

    /// The programmed limits of its profile, at the programmed speed.
    pub(crate) fn profile_limits(&self) -> Limits {
        Limits {
            speed: self.motion.limits.speed,
            ..if self.has_other_limits {
                self.in_force
            } else {
                self.motion.limits
            }
        }
    }

    /// The removal of a deceleration that this move leaves to the next one, which must not pass through rest.
    pub(crate) fn removal_of_the_next(&self) -> AccelerationRemoval {
        let other = self
            .in_force
            .jerk
            .filter(|_| self.has_other_limits)
            .map(|jerk| jerk.deceleration);
        match self.removal.forward.or(other) {
            Some(jerk) => AccelerationRemoval {
                forward: Some(jerk),
                ..AccelerationRemoval::FORWARD
            },
            None => AccelerationRemoval::NONE,
        }
    }
}

/// The motion from which a merge begins.
#[derive(Clone, Copy, Debug, Default)]
pub struct InitialMotion {
    /// Velocity of the terminated motion, units/s.
    pub velocity: Point,
    /// Its acceleration, units/s², without that of a curved path.
    pub acceleration: Point,
    /// Its limits; `None`: unknown.
    pub before: Option<Limits>,
}

/// Limits with a share of the speed, and a share of all.
pub(crate) fn scaled_limits(limits: &Limits, rate: f64, share: f64) -> Limits {
    let speed = limits.speed * rate;
    if share >= 1.0 {
        return Limits { speed, ..*limits };
    }
    Limits {
        speed: speed * share,
        acceleration: limits.acceleration * share,
        deceleration: limits.deceleration * share,
        jerk: limits.jerk.map(|jerk| Jerk {
            acceleration: jerk.acceleration * share,
            deceleration: jerk.deceleration * share,
        }),
    }
}
