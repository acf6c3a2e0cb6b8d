//! How fast a place ahead is passed with acceleration 0, when it cannot be passed as fast, or as slowly, as wanted.
//!
//! Position units and seconds; speeds along the direction of the move. Not a plan: nothing here makes a profile.
//! Real-time safe: at most a fixed number of ramps is tried. What is not finite counts as 0.

use crate::builder::Trial;
use crate::limits::{Limits, SCurve, Shape, sane};
use crate::lookahead::exit_speed;
use crate::profile::State;
use crate::ramp::ramp;
use crate::root;

/// The speed nearest to `wanted` (at least 0) at which the place `length` ahead of `from` can be passed with
/// acceleration 0. `limits.speed` bounds what is sped up to; `from.position` is not read.
///
/// Too slow for `wanted`, it is [`exit_speed`]. Too fast, it is the least speed above `wanted` that braking leads to,
/// unless braking to rest takes less way than there is: then it is the highest one below `wanted`. (With limited jerk a
/// lower speed may be met within a way that is too short for a higher one.) A motion that can stop before the place
/// can stop behind it too from what this returns. Where the way is too short even to bring the acceleration to 0, it
/// is the speed that results when that is begun at once.
#[must_use]
pub fn passing_speed(from: State, length: f64, wanted: f64, limits: &Limits) -> f64 {
    let (length, wanted) = (sane(length).max(0.0), sane(wanted).max(0.0));
    let upwards = Limits {
        speed: wanted,
        ..*limits
    };
    if wanted > 0.0 {
        let reached = exit_speed(from, length, &upwards);
        if reached < wanted {
            return reached;
        }
    }
    let now = Trial {
        x: 0.0,
        v: sane(from.velocity),
        a: sane(from.acceleration),
    };
    match limits.shape() {
        Shape::Trapezoid(limits) => {
            let square = now.v * now.v - 2.0 * limits.deceleration * length * (1.0 + ROUNDING);
            if now.v <= wanted || square <= wanted * wanted {
                wanted
            } else {
                square.max(0.0).sqrt()
            }
        }
        Shape::SCurve(limits) => brake(now, length, wanted, &limits),
    }
}

/// As [`passing_speed`] where `wanted` is not too high.
fn brake(now: Trial, length: f64, wanted: f64, limits: &SCurve) -> f64 {
    let misses_by = |speed: f64| {
        let mut trial = now;
        ramp(&mut trial, speed, limits);
        trial.x - length
    };
    let missed = misses_by(wanted);
    let tolerance = ROUNDING * length;
    if missed <= tolerance {
        return wanted;
    }
    // Levelled off at once.
    let side = if now.a > 0.0 { &limits.up } else { &limits.down };
    let level = now.v + 0.5 * now.a * now.a.abs() * side.per_jerk;
    if level <= wanted {
        return wanted;
    }
    let at_rest = misses_by(0.0);
    if at_rest <= tolerance {
        return root::solve(wanted, at_rest.min(0.0), missed, tolerance, misses_by);
    }
    let levelled = misses_by(level);
    if levelled >= 0.0 {
        return level;
    }
    level - root::solve(level - wanted, levelled, missed, tolerance, |less| misses_by(level - less))
}

/// Share of a way that is rounding.
const ROUNDING: f64 = 1e-12;
