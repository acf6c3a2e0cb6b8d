//! How fast a place ahead is passed with acceleration 0, when it cannot be passed as fast, or as slowly, as wanted.
//!
//! Position units and seconds; speeds along the direction of the move. Not a plan: nothing here makes a profile.
//! Real-time safe: at most a fixed number of ramps is tried. What is not finite counts as 0.

use crate::KinematicState;
use crate::builder::Trial;
use crate::limits::{Limits, SCurve, Shape, sane};
use crate::lookahead::exit_speed;
use crate::ramp::ramp;
use crate::root;
use crate::tolerance::DISTANCE_SHARE;

/// How a place ahead is passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passing {
    /// Position units per second.
    pub speed: f64,
    /// Whether the acceleration is 0 there: the way is long enough for that.
    pub level: bool,
}

/// The speed nearest to `wanted` (at least 0) at which the place `length` ahead of `from` can be passed with
/// acceleration 0. `limits.speed` bounds what is sped up to; `from.position` is not read.
///
/// Too slow for `wanted`, it is [`exit_speed`]. Too fast, it is the least speed above `wanted` that braking leads to,
/// unless braking to rest takes less way than there is: then it is the highest one below `wanted`. (With limited jerk a
/// lower speed may be met within a way that is too short for a higher one.) A motion that can stop before the place
/// can stop behind it too from what this returns. Where the way is too short even to bring the acceleration to 0, it
/// is the speed that results when that is begun at once.
#[must_use]
pub fn passing_speed(from: KinematicState, length: f64, wanted: f64, limits: &Limits) -> Passing {
    let (length, wanted) = (sane(length).max(0.0), sane(wanted).max(0.0));
    let upwards = Limits {
        speed: wanted,
        ..*limits
    };
    let wanted = if wanted > 0.0 {
        exit_speed(from, length, &upwards)
    } else {
        wanted
    };
    let now = Trial {
        x: 0.0,
        v: sane(from.velocity),
        a: sane(from.acceleration),
    };
    match limits.shape() {
        Shape::Trapezoid(limits) => {
            let square = now.v * now.v - 2.0 * limits.deceleration * length * (1.0 + DISTANCE_SHARE);
            let slow = now.v <= wanted || square <= wanted * wanted;
            Passing {
                speed: if slow { wanted } else { square.max(0.0).sqrt() },
                level: true,
            }
        }
        Shape::SCurve(limits) => brake(now, length, wanted, &limits),
    }
}

/// As [`passing_speed`] where `wanted` is not too much to speed up to.
fn brake(now: Trial, length: f64, wanted: f64, limits: &SCurve) -> Passing {
    let misses_by = |speed: f64| {
        let mut trial = now;
        ramp(&mut trial, speed, limits);
        trial.x - length
    };
    let at = |speed: f64, level: bool| Passing { speed, level };
    let missed = misses_by(wanted);
    let tolerance = DISTANCE_SHARE * length;
    if missed <= tolerance {
        return at(wanted, true);
    }
    let at_rest = misses_by(0.0);
    if at_rest <= tolerance {
        let speed = root::solve(wanted, at_rest.min(0.0), missed, tolerance, misses_by);
        return at(speed, true);
    }
    // Levelled off at once.
    let side = if now.a > 0.0 { &limits.up } else { &limits.down };
    let level = (now.v + 0.5 * now.a * now.a.abs() * side.per_jerk).max(0.0);
    let levelled = misses_by(level);
    if level <= wanted || levelled > tolerance {
        return at(level.max(wanted), false);
    }
    let less = root::solve(level - wanted, levelled.min(0.0), missed, tolerance, |less| {
        misses_by(level - less)
    });
    at(level - less, true)
}
