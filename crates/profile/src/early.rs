//! The early exit from the run towards the limit, before it speeds up (spec/motion-core.md §3.4, step 5), to end at rest.
//!
//! Two phases have an early exit: the relaxing of a deceleration (stop relaxing while some is left, and slow down again), and the braking of a
//! motion away from the target (pass through rest with less acceleration, which determines how far the motion returns). Either way the
//! displacement is a closed form of one acceleration, monotone, so that a few Newton steps in a bracket find it.
//!
//! In the frame in which the needed direction is positive; position units and seconds.

use crate::builder::Trial;
use crate::limits::{SCurve, Side};
use crate::numeric::newton;
use crate::peak::{ramp_and_slope, ramp_time};
use crate::tolerance::{NEWTON_STEP_SHARE, ROUNDED_SHARE};

/// While relaxing from `state` (`v > 0`, `a < 0`): the deceleration at which to stop relaxing, so that
/// slowing down again from there ends at rest at `x`.
pub(crate) fn relaxed_to(state: &Trial, x: f64, side: &Side) -> f64 {
    let (v, b) = (state.v, -state.a);
    let j = side.per_jerk;
    let most = b.min(side.most);
    let miss = |left: f64| {
        let (time, time_left) = ((b - left) * j, left * j);
        let v1 = v - 0.5 * time * (b + left);
        let relaxing = time * (v - time * (2.0 * b + left) * (1.0 / 6.0));
        // The stop from there is the later part of one from a higher speed and acceleration 0.
        let from = v1 + 0.5 * left * time_left;
        let before = time_left * (from - left * time_left * (1.0 / 6.0));
        let (stop, slope) = ramp_and_slope(0.0, from, side);
        let by_left = 2.0 * time_left * slope - j * (v1 + from) - 1.5 * time_left * time_left;
        (state.x + relaxing - before + stop - x, by_left)
    };
    solve(most, 0.0, miss)
}

/// While moving away with speed `v > 0` and deceleration `0 <= b <= most`, `x` ahead of the target: the acceleration, at most `c`, with which to
/// pass through rest, so that the motion then levels off, slows down and ends at rest at `x`.
pub(crate) fn passed_with(v: f64, b: f64, x: f64, c: f64, limits: &SCurve) -> f64 {
    let (j, j_up) = (limits.down.per_jerk, limits.up.per_jerk);
    let least = (b * b - 2.0 * limits.down.jerk * v).max(0.0).sqrt();
    // The braking is a part of a ramp with acceleration 0 at both ends.
    let from = v + 0.5 * b * b * j;
    let before = b * j * (from - b * b * j * (1.0 / 6.0));
    let miss = |c: f64| {
        let beyond = 0.5 * c * c * j;
        let (time, by_dv) = ramp_time(from + beyond, &limits.down);
        let mean = 0.5 * (from - beyond);
        let braking = mean * time - before + c * c * c * j * j * (1.0 / 3.0);
        let braking_by_c = c * j * (mean * by_dv - 0.5 * time + c * j);
        let gained = 0.5 * c * c * j_up;
        let (stop, slope) = ramp_and_slope(0.0, gained, &limits.down);
        let levelling = c * c * c * j_up * j_up * (1.0 / 3.0);
        (
            levelling + stop - braking - x,
            c * j_up * (slope + c * j_up) - braking_by_c,
        )
    };
    solve(least, c, miss)
}

/// The zero of `f` between `below`, where `f` is not above 0, and `above`, where it is not below. `f` returns its value and derivative and is not
/// evaluated at the ends. At most `MAX_STEPS` steps.
fn solve(below: f64, above: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    newton(below, above, MAX_STEPS, f, |step| {
        let [low, high] = step.bracket;
        // Quadratic convergence: the step after one this small is below rounding.
        if (step.newton - step.at).abs() <= NEWTON_STEP_SHARE * step.at {
            Some(step.newton.clamp(low, high))
        } else {
            step.is_closed(ROUNDED_SHARE).then_some(step.next)
        }
    })
}

const MAX_STEPS: usize = 64;
