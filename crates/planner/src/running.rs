//! A move as it waits, and as it runs: its path, its limits, and what its profile is planned with.
//!
//! Units: position units, seconds.

use arcline_geometry::{Path, Point, Rotation};
use arcline_profile::{Jerk, KinematicState, Lead, Limits};

use crate::Instant;
use crate::junction::Ending;
use crate::move_trajectory::MoveTrajectory;

/// A path to travel and the limits along it. `T` is whatever the owner wants back with it.
#[derive(Clone, Copy, Debug)]
pub struct Move<T> {
    /// The geometric path, by arc length.
    pub path: Path,
    /// How the orientation turns along it, evenly by arc length, or which one it keeps; `None`: no move of the queue turns it.
    pub rotation: Option<Rotation>,
    /// The highest speed at which it may be begun where the path before it does not go over into it without a corner, by what
    /// it is a function of; infinite: what the axes let it.
    pub corner: f64,
    /// Limits of the speed along the path and of its derivatives.
    pub limits: Limits,
    /// The kind of its end, if it has a successor.
    pub ending: Ending,
    /// The variable that it is a function of.
    pub parameter: Parameter,
    /// The owner's own data.
    pub data: T,
}

/// The variable that a move is a function of: time, or one of the ways that its owner numbers. All clocks that a planner is given show
/// that of its active move. Moves of different ones do not go over into each other without rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// 0: time.
    pub number: u32,
    /// How fast a way may go on, master units/s, more than 0: what a corner may ask of the axes is meant at this speed. 1 for
    /// time.
    pub speed: f64,
}

impl Parameter {
    /// Time.
    pub const TIME: Parameter = Parameter { number: 0, speed: 1.0 };

    /// Limits by the displacement as such by time, while it goes on at its speed.
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
    /// When it became active.
    pub(crate) begun: Instant,
    /// Speed with which the profile ends.
    pub(crate) exit: f64,
    /// Pending moves that the profile runs over too.
    pub(crate) joined: usize,
    /// Whether something blended into it.
    pub(crate) blended: bool,
    /// Where on its run of moves it begins.
    pub(crate) run_start: f64,
    /// Whether a stop brakes it: nothing changes that.
    pub(crate) stopped: bool,
    /// The limits that its profile keeps, as programmed: others than those of the move where a pause needs less way with them.
    pub(crate) in_force: Limits,
    /// Whether they are others.
    pub(crate) kept: bool,
    /// How an acceleration is taken away with which its profile begins.
    pub(crate) removal: AccelerationRemoval,
}

/// How an acceleration that is present when a profile begins is taken away.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AccelerationRemoval {
    /// Its jerk is raised so that the speed stays at or below this.
    pub(crate) ceiling: f64,
    /// And so that the motion does not pass through rest: to this at least, units/s³.
    pub(crate) forward: Option<f64>,
}

impl AccelerationRemoval {
    /// By the limits of the profile.
    pub(crate) const NONE: AccelerationRemoval = AccelerationRemoval {
        ceiling: f64::INFINITY,
        forward: None,
    };

    /// The motion does not pass through rest: where the move before it left a deceleration.
    pub(crate) const FORWARD: AccelerationRemoval = AccelerationRemoval {
        ceiling: f64::MAX,
        forward: Some(0.0),
    };

    pub(crate) fn lead(&self, from: KinematicState, limits: &Limits) -> Option<Lead> {
        if self.ceiling.is_infinite() {
            None
        } else if let (Some(least), true) = (self.forward, from.velocity * from.acceleration < 0.0) {
            let lead = Lead::before_rest(from, limits)?;
            let jerk = lead.jerk.max(least);
            Some(Lead { jerk, ..lead })
        } else {
            Lead::below(from, limits, self.ceiling)
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
            kept: false,
            removal: AccelerationRemoval::NONE,
        }
    }

    /// The limits that it keeps, as programmed, at the programmed speed.
    pub(crate) fn keeps(&self) -> Limits {
        Limits {
            speed: self.motion.limits.speed,
            ..if self.kept { self.in_force } else { self.motion.limits }
        }
    }

    /// How the next move takes a deceleration away that this one leaves: it does not pass through rest with it.
    pub(crate) fn removal_of_the_next(&self) -> AccelerationRemoval {
        let kept = self.in_force.jerk.filter(|_| self.kept).map(|jerk| jerk.deceleration);
        match self.removal.forward.or(kept) {
            Some(jerk) => AccelerationRemoval {
                forward: Some(jerk),
                ..AccelerationRemoval::FORWARD
            },
            None => AccelerationRemoval::NONE,
        }
    }
}

/// The motion out of which a merge begins.
#[derive(Clone, Copy, Debug, Default)]
pub struct InitialMotion {
    /// Velocity of the motion that is terminated, units/s.
    pub velocity: Point,
    /// Its acceleration, units/s², without that of a curved path.
    pub acceleration: Point,
    /// The limits that it kept; `None`: unknown.
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
