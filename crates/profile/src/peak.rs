//! The peak speed of a move: speed up, cruise, slow down, over a given distance (spec/motion-core.md §3.2).
//!
//! The peak speed is the only unknown. Every distance is a closed form of it, so most profiles need this solution only. Units: position
//! units, seconds; all velocities in the direction of the move.

use crate::limits::{SCurve, Side};
use crate::tolerance::{NEWTON_STEP_SHARE, ROUNDED_SHARE};

/// A rise by `up`, a cruise at `top` for `cruise` seconds, a fall by `down`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    pub(crate) up: f64,
    pub(crate) top: f64,
    pub(crate) cruise: f64,
    pub(crate) down: f64,
}

/// The fastest move over `distance` from `(v, a)`, `a >= 0`, to `(vf, 0)`, `vf >= 0`, that begins by
/// speeding up. `None` if even the lowest peak leads beyond `distance`.
///
/// Expects that the acceleration can return to 0 below the speed limit. At most
/// `MAX_STEPS` Newton steps.
pub(crate) fn peak(v: f64, a: f64, distance: f64, vf: f64, limits: &SCurve) -> Option<Peak> {
    // The peak is `low + w`; w is the unknown, and not the speed, to keep the digits of short ramps.
    let relieved = 0.5 * a * a * limits.up.per_jerk;
    let (low, up, down) = if v + relieved >= vf {
        (v + relieved, relieved, v + relieved - vf)
    } else {
        (vf, vf - v, 0.0)
    };
    let rise = Rise::new(v, a, &limits.up);
    let most = (limits.speed - low).max(0.0);
    let top = limits.speed.max(low);
    let left = distance - rise.distance(up + most) - ramp(vf, down + most, &limits.down);
    if left >= 0.0 {
        return Some(Peak {
            up: up + most,
            top,
            cruise: left / top,
            down: down + most,
        });
    }
    let more = distance - rise.distance(up) - ramp(vf, down, &limits.down);
    if more < 0.0 {
        return None;
    }
    let held = limits.up.per_most + limits.down.per_most;
    // (1/sqrt(ja) + 1/sqrt(jd))^2, in terms that scale exactly.
    let (one, other) = (limits.up.per_jerk, limits.down.per_jerk);
    let jerky = one + other + 2.0 * (one * other).sqrt();
    let length = |w: f64| {
        let (x1, d1) = rise.distance_and_slope(up + w);
        let (x2, d2) = ramp_and_slope(vf, down + w, &limits.down);
        (x1 + x2, d1 + d2)
    };
    let w = solve(&length, distance, guess(more, low, held, jerky).min(most), most);
    Some(Peak {
        up: up + w,
        top: low + w,
        cruise: 0.0,
        down: down + w,
    })
}

/// The largest rise of the speed above `v + a^2/(2 ja)` over `distance` from `(v, a)`, `a >= 0`, with
/// acceleration 0 at the end, and not above the limit; `None` if the distance is too short for any rise.
pub(crate) fn rise_within(v: f64, a: f64, distance: f64, limits: &SCurve) -> Option<f64> {
    let relieved = 0.5 * a * a * limits.up.per_jerk;
    let low = v + relieved;
    let rise = Rise::new(v, a, &limits.up);
    let most = (limits.speed - low).max(0.0);
    if rise.distance(relieved + most) <= distance {
        return Some(most);
    }
    let more = distance - rise.distance(relieved);
    if more < 0.0 {
        return None;
    }
    let start = guess(more, low, limits.up.per_most, limits.up.per_jerk).min(most);
    let length = |w: f64| rise.distance_and_slope(relieved + w);
    Some(solve(&length, distance, start, most))
}

/// An estimate, rather too high, of the rise above `low` that takes the distance `more`. The distance of the
/// parts with constant acceleration is `held (low w + w^2/2)`, that of those with jerk at least
/// `sqrt(jerky w^3)`; each alone gives an upper bound.
fn guess(more: f64, low: f64, held: f64, jerky: f64) -> f64 {
    let steady = 2.0 * more / (held * low + (held * (held * low * low + 2.0 * more)).sqrt());
    let jerked = libm::cbrt(more * more / jerky);
    steady.min(jerked)
}

/// Solves `length(w) = distance` for `0 <= w <= most`, starting at `start`. From above Newton is
/// monotone, since the length is convex in `y = sqrt(w)`.
///
/// Its own loop beside [`crate::numeric::newton`], as its steps are in `y`, begin at an estimate, and may end on an end of the bracket.
fn solve(length: &impl Fn(f64) -> (f64, f64), distance: f64, start: f64, most: f64) -> f64 {
    let (mut below, mut above) = (0.0, most);
    let mut w = start.max(0.0);
    for _ in 0..MAX_STEPS {
        if w <= 0.0 {
            break;
        }
        let (x, slope) = length(w);
        let error = x - distance;
        if error < 0.0 {
            below = w;
        } else {
            above = w;
        }
        // The step in y as a factor, to avoid a root of w.
        let step = error / (2.0 * w * slope);
        let newton = w * (1.0 - step) * (1.0 - step);
        let inside = step < 1.0 && newton >= below && newton <= above;
        w = if inside { newton } else { 0.5 * (below + above) };
        // Quadratic convergence: the step after this one is below rounding.
        if step.abs() <= NEWTON_STEP_SHARE || above - below <= ROUNDED_SHARE * above {
            break;
        }
    }
    w
}

/// Distance of a ramp between `slow` and `slow + dv` with acceleration 0 at both ends.
#[inline(always)]
pub(crate) fn ramp(slow: f64, dv: f64, side: &Side) -> f64 {
    (slow + 0.5 * dv) * ramp_time(dv, side).0
}

/// The distance of [`ramp`], and its derivative by `dv > 0`.
#[inline(always)]
pub(crate) fn ramp_and_slope(slow: f64, dv: f64, side: &Side) -> (f64, f64) {
    let (time, by_dv) = ramp_time(dv, side);
    let mean = slow + 0.5 * dv;
    (mean * time, 0.5 * time + mean * by_dv)
}

/// Duration of a ramp over `dv` with acceleration 0 at both ends, and its derivative by `dv > 0`.
#[inline(always)]
pub(crate) fn ramp_time(dv: f64, side: &Side) -> (f64, f64) {
    let rise = side.most * side.per_jerk;
    if dv >= side.most * rise {
        (dv * side.per_most + rise, side.per_most)
    } else {
        let half = (dv * side.per_jerk).sqrt();
        (2.0 * half, half / dv)
    }
}

/// The rise from `(v, a)` with one trapezoid of acceleration.
enum Rise<'a> {
    /// The later part of a ramp that began with acceleration 0 at a lower speed.
    Ramp {
        from: f64,
        before: f64,
        raised: f64,
        side: &'a Side,
    },
    /// The acceleration is above its limit and decreases to it first.
    Lowered { spent: f64, v: f64, x: f64, side: &'a Side },
}

impl Rise<'_> {
    #[inline]
    fn new(v: f64, a: f64, side: &Side) -> Rise<'_> {
        if a <= side.most {
            let time = a * side.per_jerk;
            let raised = 0.5 * a * time;
            let from = v - raised;
            Rise::Ramp {
                from,
                before: time * (from + raised * (1.0 / 3.0)),
                raised,
                side,
            }
        } else {
            let time = (a - side.most) * side.per_jerk;
            Rise::Lowered {
                spent: 0.5 * a * a * side.per_jerk,
                v: v + time * 0.5 * (a + side.most),
                x: time * (v + time * (0.5 * a - side.jerk * time * (1.0 / 6.0))),
                side,
            }
        }
    }

    /// Distance until the speed has risen by `dv` and the acceleration is 0.
    #[inline]
    fn distance(&self, dv: f64) -> f64 {
        match *self {
            Rise::Ramp {
                from,
                before,
                raised,
                side,
            } => ramp(from, dv + raised, side) - before,
            Rise::Lowered { .. } => self.distance_and_slope(dv).0,
        }
    }

    /// The distance, and its derivative by `dv`.
    #[inline]
    fn distance_and_slope(&self, dv: f64) -> (f64, f64) {
        match *self {
            Rise::Ramp {
                from,
                before,
                raised,
                side,
            } => {
                let (x, slope) = ramp_and_slope(from, dv + raised, side);
                (x - before, slope)
            }
            Rise::Lowered { spent, v, x, side } => {
                let held = (dv - spent).max(0.0) * side.per_most;
                let released = side.most * side.per_jerk;
                let v2 = v + side.most * held;
                let length = x + 0.5 * (v + v2) * held + released * (v2 + side.most * released * (1.0 / 3.0));
                (length, v2 * side.per_most + released)
            }
        }
    }
}

const MAX_STEPS: usize = 64;
