//! The ramping out of terminated motion: its limits and directions.
//!
//! A stop of the motion takes no longer distance than one with the old dynamics, does not exceed a speed, and does not pass through rest: its
//! ramps are shortened as little as necessary. Not here: the path beside it (`merge`, `beside`). Position units and seconds. Bounded; no
//! allocation.

use arcline_geometry::Point;
use arcline_profile::numeric::bisect_factor;
use arcline_profile::{AccelerationRemovalPhase, Jerk, KinematicState, Limits, Profile};

use crate::junction::braking;
use crate::move_trajectory::ResidualPart;
use crate::planner::Planner;
use crate::running::{InitialMotion, scaled_limits};
use crate::tolerance::{ASIDE_SHARE, NO_ACCELERATION_SHARE, ROUNDING_SHARE};

/// The terminated motion, and the parameters of its ramping out.
#[derive(Clone, Copy)]
pub(crate) struct RampOut {
    pub(crate) initial: InitialMotion,
    pub(crate) limits: Limits,
    /// The distance of a stop with the limits of the motion.
    pub(crate) widest: f64,
    /// The factor by which an acceleration across the velocity is removed faster; infinite: at once.
    pub(crate) across: f64,
}

impl<T: Copy> Planner<T> {
    /// The limits with which a stop from a motion takes at most a distance, and does not exceed `bound`.
    pub(crate) fn ramping_out(&self, initial: &InitialMotion, own: &Limits, widest: f64, bound: f64) -> Limits {
        let speed = initial.velocity.norm();
        let limits = braking(own, speed);
        if !self.dynamics_bits.overshoot {
            return limits;
        }
        let from = KinematicState {
            position: 0.0,
            velocity: speed,
            acceleration: initial.acceleration.dot(&initial.velocity) / speed,
        };
        let mut limits = relieved(from, &limits, bound);
        let old = initial.before.and_then(|before| before.jerk);
        let mut wider = false;
        let wide = Profile::stop(from, &limits).reach() > widest * (1.0 + ROUNDING_SHARE);
        if let (Some(jerk), Some(old)) = (&mut limits.jerk, old.filter(|_| wide)) {
            // The old jerk removes the acceleration in time; only the braking needs to be shorter.
            jerk.acceleration = jerk.acceleration.max(old.acceleration);
            wider = true;
        }
        let slowed = hastened(from, &limits, widest, wider);
        hastened(from, &slowed, widest, false)
    }
}

impl RampOut {
    pub(crate) fn parts(&self, velocity: Point, acceleration: Point) -> [ResidualPart; 3] {
        let speed = velocity.norm();
        let direction = velocity.try_normalize(0.0).unwrap_or_default();
        let mut along = acceleration.dot(&direction);
        let slow = self
            .limits
            .jerk
            .is_some_and(|jerk| speed < 0.5 * along * along / jerk.deceleration * (1.0 - ROUNDING_SHARE));
        if along < 0.0 && slow {
            along = 0.0;
        }
        let mut across = acceleration - direction * along;
        if across.norm() <= NO_ACCELERATION_SHARE * self.initial.acceleration.norm() || self.across.is_infinite() {
            across = Point::zeros();
        }
        let nothing = ResidualPart::new(Point::zeros(), Profile::rest(0.0));
        let first = if speed > 0.0 {
            let from = KinematicState {
                position: 0.0,
                velocity: speed,
                acceleration: along,
            };
            let limits = hastened(from, &self.limits, self.widest, false);
            ResidualPart::new(direction, Profile::stop(from, &limits))
        } else {
            nothing
        };
        let second = match across.try_normalize(0.0) {
            Some(direction) => {
                let from = KinematicState {
                    acceleration: across.norm(),
                    ..KinematicState::default()
                };
                let limits = Limits {
                    deceleration: self.limits.deceleration,
                    ..removed_by_the_greater_jerk(&self.limits).hastened(self.across)
                };
                let limits = hastened(from, &limits, ASIDE_SHARE * self.widest, false);
                ResidualPart::new(direction, Profile::stop(from, &limits))
            }
            None => nothing,
        };
        [first, second, nothing]
    }

    /// Ramps out all of the motion, and returns.
    pub(crate) fn and_back(&self) -> [ResidualPart; 3] {
        let mut parts = self.parts(self.initial.velocity, self.initial.acceleration);
        for part in &mut parts {
            let from = part.profile.start();
            *part = ResidualPart::new(part.direction, Profile::to_position(from, 0.0, 0.0, &self.limits));
        }
        parts
    }
}

/// Limits with the jerks that remove an acceleration before a motion exceeds `fastest`, or passes through rest.
fn relieved(from: KinematicState, limits: &Limits, fastest: f64) -> Limits {
    let mut limits = *limits;
    let removal_phase = forward(from, &limits, fastest);
    if let (Some(removal_phase), Some(jerk)) = (removal_phase, &mut limits.jerk) {
        if from.acceleration < 0.0 {
            jerk.deceleration = jerk.deceleration.max(removal_phase.jerk);
        } else {
            jerk.acceleration = jerk.acceleration.max(removal_phase.jerk);
        }
    }
    limits
}

/// Limits with braking ramps shortened as little as necessary for a stop within a distance. The deceleration rises to at most
/// [`PEAK_SHARE`] of the mean one that the distance needs; beyond it the jerk alone does. The acceleration stays, for a return after an
/// overshoot. `braking`: the jerk that removes an acceleration stays, too.
fn hastened(from: KinematicState, limits: &Limits, widest: f64, braking: bool) -> Limits {
    let widest = widest * (1.0 + ROUNDING_SHARE);
    let fits = |limits: &Limits| stop_way(from, limits) <= widest;
    if widest.is_nan() || widest <= 0.0 || fits(limits) {
        return *limits;
    }
    let limits = &(if braking {
        *limits
    } else {
        removed_sooner(limits, &fits)
    });
    if fits(limits) {
        return *limits;
    }
    let most = limits
        .deceleration
        .max(PEAK_SHARE * mean_deceleration(from, limits, widest, braking));
    let faster = |factor: f64| {
        let all = limits.hastened(factor);
        Limits {
            acceleration: limits.acceleration,
            deceleration: all.deceleration.min(most),
            jerk: all.jerk.zip(limits.jerk).map(|(all, own)| Jerk {
                acceleration: if braking { own.acceleration } else { all.acceleration },
                ..all
            }),
            ..*limits
        }
    };
    if braking && !fits(&faster(MOST_HASTE)) {
        return *limits;
    }
    let (mut less, mut more) = (1.0, 2.0);
    for _ in 0..DOUBLINGS {
        if fits(&faster(more)) {
            break;
        }
        (less, more) = (more, 2.0 * more);
    }
    faster(bisect_factor(less, more, HALVINGS, |factor| fits(&faster(factor))))
}

/// The mean deceleration of a stop within a distance; `braking`: behind the removal of the acceleration.
fn mean_deceleration(from: KinematicState, limits: &Limits, widest: f64, braking: bool) -> f64 {
    let removal = limits
        .jerk
        .filter(|_| braking && from.acceleration > 0.0)
        .map(|jerk| AccelerationRemovalPhase {
            from,
            jerk: jerk.acceleration,
            hold: 0.0,
        });
    let at = removal.map_or(from, |removal| removal.end());
    let left = widest - (at.position - from.position);
    if left > 0.0 {
        0.5 * at.velocity * at.velocity / left
    } else {
        0.0
    }
}

/// Limits that remove an acceleration with the greater of their jerks: across the velocity, it may be the rest of a deceleration.
fn removed_by_the_greater_jerk(limits: &Limits) -> Limits {
    Limits {
        jerk: limits.jerk.map(|jerk| Jerk {
            acceleration: jerk.acceleration.max(jerk.deceleration),
            ..jerk
        }),
        ..*limits
    }
}

/// Limits that remove an acceleration earlier, as little as necessary, and with no more than the jerk of the deceleration. A slow removal
/// with a shorter braking behind it would need a far higher deceleration.
fn removed_sooner(limits: &Limits, fits: &impl Fn(&Limits) -> bool) -> Limits {
    let with = |removal: f64| Limits {
        jerk: limits.jerk.map(|jerk| Jerk {
            acceleration: removal,
            ..jerk
        }),
        ..*limits
    };
    let Some(jerk) = limits.jerk.filter(|jerk| jerk.acceleration < jerk.deceleration) else {
        return *limits;
    };
    if !fits(&with(jerk.deceleration)) {
        return with(jerk.deceleration);
    }
    let removal = bisect_factor(jerk.acceleration, jerk.deceleration, HALVINGS, |removal| {
        fits(&with(removal))
    });
    with(removal)
}

/// The distance of a stop that does not pass through rest.
pub(crate) fn stop_way(from: KinematicState, limits: &Limits) -> f64 {
    Profile::after_removal(AccelerationRemovalPhase::before_rest(from, limits), from, |from| {
        Profile::stop(from, limits)
    })
    .reach()
}

/// Limits with which a stop takes at most a distance on a path that has a share of them.
pub(crate) fn short(from: KinematicState, limits: &Limits, share: f64, widest: f64) -> Limits {
    let own = scaled_limits(limits, 1.0, share);
    if stop_way(from, &own) <= widest * (1.0 + ROUNDING_SHARE) {
        return *limits;
    }
    let own = hastened(from, &own, widest, false);
    Limits {
        speed: limits.speed,
        acceleration: own.acceleration / share,
        deceleration: own.deceleration / share,
        jerk: own.jerk.map(|jerk| Jerk {
            acceleration: jerk.acceleration / share,
            deceleration: jerk.deceleration / share,
        }),
    }
}

/// The removal phase that keeps a motion below a speed, and from passing through rest.
pub(crate) fn forward(from: KinematicState, limits: &Limits, ceiling: f64) -> Option<AccelerationRemovalPhase> {
    if from.velocity * from.acceleration < 0.0 {
        AccelerationRemovalPhase::before_rest(from, limits)
    } else {
        AccelerationRemovalPhase::below(from, limits, ceiling)
    }
}

/// The largest factor for braking alone.
const MOST_HASTE: f64 = 1e6;
/// The highest deceleration of a shortened stop, a share of the mean one: the rest of its time is left for a limited jerk.
const PEAK_SHARE: f64 = 1.5;
/// Most doublings of the factor for a stop, and halvings to find the smallest one.
const DOUBLINGS: usize = 24;
const HALVINGS: usize = 20;
