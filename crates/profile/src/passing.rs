//! The speed at which a point ahead is passed with acceleration 0, if it cannot be passed as fast, or as slowly, as wanted.
//!
//! Position units and seconds; speeds along the direction of the move. Not a plan: no function makes a profile.
//! Real-time safe: at most a fixed number of ramps is tried. Non-finite input counts as 0.

use crate::KinematicState;
use crate::builder::Trial;
use crate::limits::{Limits, ProfileShape, SCurve, sane};
use crate::lookahead::exit_speed;
use crate::ramp::ramp;
use crate::root;
use crate::tolerance::DISTANCE_SHARE;

/// The state at which a point ahead is passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passing {
    /// Position units per second.
    pub speed: f64,
    /// The acceleration is 0 there: the distance suffices for that.
    pub level: bool,
}

/// The speed nearest to `wanted` (at least 0) at which a point `length` ahead of `from` can be passed with
/// acceleration 0. `limits.speed` bounds the speed after an acceleration; `from.position` is not read.
///
/// If the motion is too slow for `wanted`, the result is [`exit_speed`]. If it is too fast, the result is the least speed above `wanted` that
/// braking leads to, unless braking to rest takes a shorter distance: then it is the highest one below `wanted`. (With limited jerk a
/// lower speed may be met within a distance that is too short for a higher one.) A motion that can stop before the point can also stop behind
/// it from this speed. If the distance is too short even to bring the acceleration to 0, the result is the speed at which an immediate removal
/// ends.
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
        ProfileShape::Trapezoid(limits) => {
            let square = now.v * now.v - 2.0 * limits.deceleration * length * (1.0 + DISTANCE_SHARE);
            let slow = now.v <= wanted || square <= wanted * wanted;
            Passing {
                speed: if slow { wanted } else { square.max(0.0).sqrt() },
                level: true,
            }
        }
        ProfileShape::SCurve(limits) => brake(now, length, wanted, &limits),
    }
}

/// As [`passing_speed`] if `wanted` is not above the reachable speed.
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
