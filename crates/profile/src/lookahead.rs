//! Tools of a look-ahead over a queue (spec/motion-core.md §3.5, §7): distances, and the highest speeds, between two points at which the
//! acceleration is 0. They are not plans: none of them makes a profile.
//!
//! Units: position units and seconds; speeds along the direction of the move. Real-time safe:
//! constant time but for one case of [`exit_speed`], which is bounded. Non-finite input counts as 0.

use crate::KinematicState;
use crate::builder::Trial;
use crate::limits::{Limits, ProfileShape, SCurve, Side, Trapezoid, sane};
use crate::ramp::{approach, ramp};
use crate::tolerance::LOOKAHEAD_SHARE;
use crate::{peak, root};

/// Distance (units, at least 0) from `speed` with acceleration 0 to rest.
#[must_use]
pub fn stop_distance(speed: f64, limits: &Limits) -> f64 {
    slowing_distance(sane(speed).abs(), 0.0, &limits.shape())
}

/// The largest speed from which `end_speed` can be reached within `length`, slowing down with
/// acceleration 0 at both ends; `end_speed` for a length of 0. The speed limit is not read: the caller
/// has its own bounds. The speed grows with `length`, but not always with `end_speed`: with limited jerk the
/// final part of the deceleration is shorter at a lower speed.
///
/// Rounded such that the deceleration is not longer than `length`.
#[must_use]
pub fn entry_speed(length: f64, end_speed: f64, limits: &Limits) -> f64 {
    let (length, slow) = (sane(length).max(0.0), sane(end_speed).abs());
    let shape = limits.shape();
    let more = match &shape {
        ProfileShape::Trapezoid(limits) => gained(length, slow, limits.deceleration),
        ProfileShape::SCurve(limits) => gained_with_jerk(length, slow, &limits.down),
    };
    rounded_down(slow + more, slow, |fast| slowing_distance(fast, slow, &shape) <= length)
}

/// The largest speed, at most `limits.speed`, that is reached with acceleration 0 exactly `length`
/// ahead of `from` (which may accelerate, slow down or move away; a trapezoid's acceleration is not
/// read). In the direction of positive positions; `from.position` is not read.
///
/// If `length` is too short even to bring the acceleration to 0, the result is the speed at which an
/// immediate removal ends; if it is too short to slow down to the speed limit, the result is that limit.
/// [`Profile::to_position`](crate::Profile::to_position) then ends with a higher speed than requested, and the
/// next move must brake.
#[must_use]
pub fn exit_speed(from: KinematicState, length: f64, limits: &Limits) -> f64 {
    let length = sane(length).max(0.0);
    let now = Trial {
        x: 0.0,
        v: sane(from.velocity),
        a: sane(from.acceleration),
    };
    match limits.shape() {
        ProfileShape::Trapezoid(limits) => exit_by_trapezoid(now.v, length, &limits),
        ProfileShape::SCurve(limits) => exit_by_s_curve(now, length, &limits),
    }
}

fn slowing_distance(fast: f64, slow: f64, shape: &ProfileShape) -> f64 {
    let dv = fast - slow;
    match shape {
        ProfileShape::Trapezoid(limits) => 0.5 * dv * (fast + slow) / limits.deceleration,
        ProfileShape::SCurve(limits) => {
            // As a plan computes it, to its last digit.
            let mut trial = Trial {
                x: 0.0,
                v: fast,
                a: 0.0,
            };
            ramp(&mut trial, slow, limits);
            trial.x
        }
    }
}

/// The change of a speed above `slow` over `length` with a constant acceleration.
fn gained(length: f64, slow: f64, acceleration: f64) -> f64 {
    let square = 2.0 * acceleration * length;
    if square > 0.0 {
        square / (slow + (slow * slow + square).sqrt())
    } else {
        0.0
    }
}

/// The speed gained over a length with limited jerk and acceleration 0 at both ends.
fn gained_with_jerk(length: f64, slow: f64, side: &Side) -> f64 {
    if length <= 0.0 {
        return 0.0;
    }
    let time = side.most * side.per_jerk;
    let dv = side.most * time;
    if length >= (2.0 * slow + dv) * time {
        // With a phase of constant acceleration: w^2 + b w = c. In this case c is at least half its minuend.
        let b = 2.0 * slow + dv;
        let c = 2.0 * (side.most * length - slow * dv);
        return 2.0 * c / (b + (b * b + 4.0 * c).sqrt());
    }
    // (2 slow + w) sqrt(w / jerk) = length with w = unit z^2: z^3 + p z = 1. Newton from above on a
    // convex function; the start is at most 26 % too high, so that five steps reach rounding.
    let unit = libm::cbrt(length * length * side.jerk);
    let p = 2.0 * slow / unit;
    let mut z = (1.0 / p).min(1.0);
    for _ in 0..5 {
        z = (1.0 + 2.0 * z * z * z) / (3.0 * z * z + p);
    }
    unit * z * z
}

fn exit_by_trapezoid(v: f64, length: f64, limits: &Trapezoid) -> f64 {
    if v >= limits.speed {
        return limits.speed;
    }
    let (slow, length) = if v < 0.0 {
        (0.0, length + 0.5 * v * v / limits.deceleration)
    } else {
        (v, length)
    };
    let most = limits.acceleration;
    let speed = (slow + gained(length, slow, most)).min(limits.speed);
    rounded_down(speed, slow, |w| 0.5 * (w - slow) * (w + slow) / most <= length)
}

fn exit_by_s_curve(now: Trial, length: f64, limits: &SCurve) -> f64 {
    let most = limits.speed;
    let mut rising = now;
    if !approach(&mut rising, most, limits) {
        return most;
    }
    let reach = |w: f64| {
        let mut trial = now;
        ramp(&mut trial, w, limits);
        trial.x
    };
    let fits = |w: f64| reach(w) <= length;
    let low = (rising.v + 0.5 * rising.a * rising.a * limits.up.per_jerk).min(most);
    if let Some(more) = peak::rise_within(rising.v, rising.a, length - rising.x, limits) {
        return rounded_down((low + more).min(most), low, fits);
    }
    // Half the square of the acceleration: over the jerk, the change of velocity that brings it to 0.
    let spent = 0.5 * now.a * now.a;
    let turns = now.v < 0.0 || (now.a < 0.0 && now.v * limits.down.jerk < spent);
    if !turns {
        return low;
    }
    // The acceleration with which the motion passes through rest depends on the speed wanted, unless
    // it is already too high.
    let least = if now.a > 0.0 {
        (spent + now.v * limits.down.jerk).max(0.0) * limits.up.per_jerk
    } else {
        0.0
    };
    let (at_least, at_low) = (reach(least) - length, reach(low) - length);
    if least >= low || at_least >= 0.0 {
        return least.min(low);
    }
    let tolerance = LOOKAHEAD_SHARE * length.max(at_least.abs());
    let more = root::solve(low - least, at_least, at_low.max(0.0), tolerance, |w| {
        reach(least + w) - length
    });
    rounded_down(least + more, least, fits)
}

/// Removes rounding errors of `speed`, never below `least`.
fn rounded_down(mut speed: f64, least: f64, fits: impl Fn(f64) -> bool) -> f64 {
    let mut ulps = 1.0;
    for _ in 0..ROUNDING_STEPS {
        if speed <= least || fits(speed) {
            break;
        }
        speed = (speed - ulps * (f64::EPSILON * speed)).max(least);
        ulps *= 2.0;
    }
    speed
}

const ROUNDING_STEPS: usize = 8;
