//! How fast a move gets: speed up, cruise, slow down, over a given distance (motion-core §3.2).
//!
//! One unknown, the peak speed. Every distance here is a closed form of it, so this one solve is all
//! that most profiles need. Units: position units, seconds; all velocities in the direction of the move.

use crate::limits::SCurve;

/// A rise by `up`, a cruise at `top` for `cruise` seconds, a fall by `down`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    pub(crate) up: f64,
    pub(crate) top: f64,
    pub(crate) cruise: f64,
    pub(crate) down: f64,
}

/// The fastest move over `distance` from `(v, a)`, `a >= 0`, to `(vf, 0)`, `vf >= 0`, that begins by
/// speeding up. `None` when even the lowest peak leads beyond `distance`.
///
/// Expects that the acceleration can return to 0 below the speed limit. At most
/// `MAX_STEPS` Newton steps.
pub(crate) fn peak(v: f64, a: f64, distance: f64, vf: f64, limits: &SCurve) -> Option<Peak> {
    // The peak is `low + w`; w is the unknown, and not the speed, to keep the digits of short ramps.
    let relieved = a * a / (2.0 * limits.jerk);
    let (low, up, down) = if v + relieved >= vf {
        (v + relieved, relieved, v + relieved - vf)
    } else {
        (vf, vf - v, 0.0)
    };
    let rise = Rise::new(v, a, limits);
    let length = |w: f64| {
        let (x1, d1) = rise.distance(up + w);
        let (x2, d2) = ramp(vf, down + w, limits.deceleration, limits.jerk_down);
        (x1 + x2, d1 + d2)
    };
    let most = (limits.speed - low).max(0.0);
    let at_most = length(most).0;
    if at_most <= distance {
        return Some(Peak {
            up: up + most,
            top: limits.speed.max(low),
            cruise: (distance - at_most) / limits.speed.max(low),
            down: down + most,
        });
    }
    let at_least = length(0.0).0;
    let more = distance - at_least;
    if more < 0.0 {
        return None;
    }
    let held = 1.0 / limits.acceleration + 1.0 / limits.deceleration;
    // (1/sqrt(ja) + 1/sqrt(jd))^2, in terms that scale exactly.
    let jerky = 1.0 / limits.jerk + 1.0 / limits.jerk_down + 2.0 / (limits.jerk * limits.jerk_down).sqrt();
    let w = solve(&length, distance, guess(more, low, held, jerky).min(most), most);
    Some(Peak {
        up: up + w,
        top: low + w,
        cruise: 0.0,
        down: down + w,
    })
}

/// How far the speed can rise above `v + a^2/(2 ja)` over `distance` from `(v, a)`, `a >= 0`, with
/// acceleration 0 at the end, and not above the limit; 0 if the distance is too short for any rise.
pub(crate) fn rise_within(v: f64, a: f64, distance: f64, limits: &SCurve) -> f64 {
    let relieved = a * a / (2.0 * limits.jerk);
    let low = v + relieved;
    let rise = Rise::new(v, a, limits);
    let more = distance - rise.distance(relieved).0;
    let most = limits.speed - low;
    if more <= 0.0 || most <= 0.0 {
        return 0.0;
    }
    let start = guess(more, low, 1.0 / limits.acceleration, 1.0 / limits.jerk).min(most);
    solve(&|w: f64| rise.distance(relieved + w), distance, start, most)
}

/// About the rise above `low` that takes the distance `more`, rather too much. The distance of the
/// parts with constant acceleration is `held (low w + w^2/2)`, that of those with jerk at least
/// `sqrt(jerky w^3)`; each alone gives an upper bound.
fn guess(more: f64, low: f64, held: f64, jerky: f64) -> f64 {
    let steady = 2.0 * more / (held * (low + (low * low + 2.0 * more / held).sqrt()));
    let jerked = libm::cbrt(more * more / jerky);
    steady.min(jerked)
}

/// Solves `length(w) = distance` for `0 <= w <= most`, starting at `start`. From above Newton is
/// monotone, since the length is convex in `y = sqrt(w)`.
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
        // The step in y as a factor, so that no root of w is needed.
        let step = error / (2.0 * w * slope);
        let newton = w * (1.0 - step) * (1.0 - step);
        let inside = step < 1.0 && newton >= below && newton <= above;
        w = if inside { newton } else { 0.5 * (below + above) };
        // Quadratic convergence: the step after this one is below rounding.
        if step.abs() <= 1e-9 || above - below <= 2e-16 * above {
            break;
        }
    }
    w
}

/// Distance of a ramp between `slow` and `slow + dv` with acceleration 0 at both ends, and its
/// derivative by `dv`.
pub(crate) fn ramp(slow: f64, dv: f64, acceleration: f64, jerk: f64) -> (f64, f64) {
    let (time, by_dv) = ramp_time(dv, acceleration, jerk);
    let mean = slow + 0.5 * dv;
    (mean * time, 0.5 * time + mean * by_dv)
}

fn ramp_time(dv: f64, acceleration: f64, jerk: f64) -> (f64, f64) {
    if dv * jerk >= acceleration * acceleration {
        (dv / acceleration + acceleration / jerk, 1.0 / acceleration)
    } else {
        let peak = (dv * jerk).sqrt();
        (2.0 * peak / jerk, 1.0 / peak)
    }
}

/// The way up from `(v, a)` with one trapezoid of acceleration.
enum Rise {
    /// The later part of a ramp that began with acceleration 0 at a lower speed.
    Ramp {
        from: f64,
        before: f64,
        raised: f64,
        acceleration: f64,
        jerk: f64,
    },
    /// The acceleration is above its limit and is lowered first.
    Lowered {
        spent: f64,
        v: f64,
        x: f64,
        acceleration: f64,
        jerk: f64,
    },
}

impl Rise {
    fn new(v: f64, a: f64, limits: &SCurve) -> Rise {
        let (acceleration, jerk) = (limits.acceleration, limits.jerk);
        if a <= acceleration {
            let time = a / jerk;
            let raised = 0.5 * a * time;
            let from = v - raised;
            Rise::Ramp {
                from,
                before: time * (from + raised / 3.0),
                raised,
                acceleration,
                jerk,
            }
        } else {
            let time = (a - acceleration) / jerk;
            Rise::Lowered {
                spent: a * a / (2.0 * jerk),
                v: v + time * 0.5 * (a + acceleration),
                x: time * (v + time * (0.5 * a - jerk * time / 6.0)),
                acceleration,
                jerk,
            }
        }
    }

    /// Distance until the speed has risen by `dv` and the acceleration is 0, and its derivative.
    fn distance(&self, dv: f64) -> (f64, f64) {
        match *self {
            Rise::Ramp {
                from,
                before,
                raised,
                acceleration,
                jerk,
            } => {
                let (x, slope) = ramp(from, dv + raised, acceleration, jerk);
                (x - before, slope)
            }
            Rise::Lowered {
                spent,
                v,
                x,
                acceleration,
                jerk,
            } => {
                let held = (dv - spent).max(0.0) / acceleration;
                let released = acceleration / jerk;
                let v2 = v + acceleration * held;
                let length = x + 0.5 * (v + v2) * held + released * (v2 + acceleration * released / 3.0);
                (length, v2 / acceleration + released)
            }
        }
    }
}

const MAX_STEPS: usize = 64;
