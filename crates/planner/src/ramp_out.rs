//! How terminated motion ramps out: with which limits, along which directions.
//!
//! A stop out of the motion takes no more distance than one with the old dynamics, is no faster than a bound, and does not pass
//! through rest: its ramps are hastened, as little as need be. Not here: the path beside it (`merge`, `beside`). Position units and
//! seconds. Bounded; no allocation.

use arcline_geometry::Point;
use arcline_profile::{Jerk, KinematicState, Lead, Limits, Profile};

use crate::junction::braking;
use crate::move_trajectory::Part;
use crate::planner::Planner;
use crate::running::{InitialMotion, scaled_limits};
use crate::tolerance::{NO_ACCELERATION_SHARE, ROUNDING_SHARE};

/// The motion that is terminated, and how it ramps out.
#[derive(Clone, Copy)]
pub(crate) struct RampOut {
    pub(crate) initial: InitialMotion,
    pub(crate) limits: Limits,
    /// The way of a stop with the limits that the motion had.
    pub(crate) widest: f64,
    /// How many times faster an acceleration across the velocity is taken away; infinite: at once.
    pub(crate) across: f64,
}

impl<T: Copy> Planner<T> {
    /// The limits of a move with which a stop out of a motion takes no more than a way, and is no faster than `bound`.
    pub(crate) fn ramping_out(&self, initial: &InitialMotion, own: &Limits, widest: f64, bound: f64) -> Limits {
        let speed = initial.velocity.norm();
        let limits = braking(own, speed);
        if !self.bounds.overshoot {
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
            // The old jerk takes the acceleration away in time; the rest of the way is the braking's.
            jerk.acceleration = jerk.acceleration.max(old.acceleration);
            wider = true;
        }
        let slowed = hastened(from, &limits, widest, wider);
        hastened(from, &slowed, widest, false)
    }
}

impl RampOut {
    pub(crate) fn parts(&self, velocity: Point, acceleration: Point) -> [Part; 3] {
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
        let nothing = Part::new(Point::zeros(), Profile::rest(0.0));
        let first = if speed > 0.0 {
            let from = KinematicState {
                position: 0.0,
                velocity: speed,
                acceleration: along,
            };
            let limits = hastened(from, &self.limits, self.widest, false);
            Part::new(direction, Profile::stop(from, &limits))
        } else {
            nothing
        };
        let second = match across.try_normalize(0.0) {
            Some(direction) => {
                let from = KinematicState {
                    acceleration: across.norm(),
                    ..KinematicState::default()
                };
                let limits = self.limits.hastened(self.across);
                let limits = hastened(from, &limits, ASIDE * self.widest, false);
                Part::new(direction, Profile::stop(from, &limits))
            }
            None => nothing,
        };
        [first, second, nothing]
    }

    /// All of the motion ramps out, and comes back.
    pub(crate) fn and_back(&self) -> [Part; 3] {
        let mut parts = self.parts(self.initial.velocity, self.initial.acceleration);
        for part in &mut parts {
            let from = part.profile.start();
            *part = Part::new(part.direction, Profile::to_position(from, 0.0, 0.0, &self.limits));
        }
        parts
    }
}

/// Limits with the jerks that take an acceleration away before a motion is faster than `fastest`, or passes through rest.
fn relieved(from: KinematicState, limits: &Limits, fastest: f64) -> Limits {
    let mut limits = *limits;
    let lead = forward(from, &limits, fastest);
    if let (Some(lead), Some(jerk)) = (lead, &mut limits.jerk) {
        if from.acceleration < 0.0 {
            jerk.deceleration = jerk.deceleration.max(lead.jerk);
        } else {
            jerk.acceleration = jerk.acceleration.max(lead.jerk);
        }
    }
    limits
}

/// Limits whose ramps are hastened, as little as need be, until a stop takes no more than a way.
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
    // Of the braking alone, or of all.
    let faster = |factor: f64| {
        let all = limits.hastened(factor);
        let Some((own, all_jerk)) = limits.jerk.zip(all.jerk).filter(|_| braking) else {
            return all;
        };
        Limits {
            acceleration: limits.acceleration,
            jerk: Some(Jerk {
                acceleration: own.acceleration,
                ..all_jerk
            }),
            ..all
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
    faster(least(less, more, |factor| fits(&faster(factor))))
}

/// The least of the factors between two, of which the greater one fits, that fits.
fn least(mut less: f64, mut more: f64, fits: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = (less * more).sqrt();
        if fits(middle) {
            more = middle;
        } else {
            less = middle;
        }
    }
    more
}

/// Limits that take an acceleration away sooner, as little as need be, and with no more than the jerk of the deceleration. To take it
/// away slowly and hasten the braking behind it would need a far harder deceleration.
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
    with(least(jerk.acceleration, jerk.deceleration, |removal| {
        fits(&with(removal))
    }))
}

/// The way of a stop that does not pass through rest.
fn stop_way(from: KinematicState, limits: &Limits) -> f64 {
    Profile::led(Lead::before_rest(from, limits), from, |from| {
        Profile::stop(from, limits)
    })
    .reach()
}

/// Limits with which a stop, on a path that is travelled with a share of them, takes no more than a way.
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

/// The lead that keeps a motion below a speed, and from passing through rest.
pub(crate) fn forward(from: KinematicState, limits: &Limits, ceiling: f64) -> Option<Lead> {
    if from.velocity * from.acceleration < 0.0 {
        Lead::before_rest(from, limits)
    } else {
        Lead::below(from, limits, ceiling)
    }
}

/// How wide an acceleration across the velocity may lead, as a share of the stop.
const ASIDE: f64 = 0.1;
/// The most that braking alone is hastened.
const MOST_HASTE: f64 = 1e6;
/// How often a stop is hastened twofold at most, and how exactly the least haste is found.
const DOUBLINGS: usize = 24;
const HALVINGS: usize = 20;
