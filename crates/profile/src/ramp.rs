//! The S-curve's ramp primitive: from any `(v, a)` to `(vt, 0)` (spec/motion-core.md §3.3).
//!
//! Letters as in the paper: `v, a` state, `vt` wanted velocity, `b = -a` while slowing, `c` the
//! acceleration with which the motion passes through rest, `vz` the velocity if the acceleration is
//! brought to 0 at once.

use crate::builder::Sink;
use crate::limits::{SCurve, Side};
use crate::tolerance::SAME_VELOCITY_SHARE;

/// From the sink's state to velocity `vt` with acceleration 0: at most nine segments.
pub(crate) fn ramp<S: Sink>(sink: &mut S, vt: f64, limits: &SCurve) {
    if approach(sink, vt, limits) {
        rise(sink, vt, limits);
    }
}

/// All of [`ramp`] but its last rise: runs until only a rise towards `vt` (in its direction) with one trapezoid of acceleration remains, and
/// returns true; returns false if the ramp ended without such a rise.
#[inline(always)]
pub(crate) fn approach<S: Sink>(sink: &mut S, vt: f64, limits: &SCurve) -> bool {
    // Every pass but the last ends with v = 0 or a = 0; there are at most five.
    for _ in 0..MAX_PASSES {
        let (v, a) = (sink.velocity(), sink.acceleration());
        let mirrored = if v != 0.0 {
            v < 0.0
        } else if a != 0.0 {
            a < 0.0
        } else {
            vt < 0.0
        };
        let sign = if mirrored { -1.0 } else { 1.0 };
        let (v, a, vt) = (sign * v, sign * a, sign * vt);
        if a > 0.0 || (a == 0.0 && vt >= v) {
            let vz = v + 0.5 * a * a * limits.up.per_jerk;
            if vt >= vz - SAME_VELOCITY_SHARE * vz {
                return true;
            }
            sink.push(a * limits.up.per_jerk, -sign * limits.up.jerk);
            sink.set(sign * vz, 0.0);
        } else if slow_down(sink, v, -a, vt, sign, limits) {
            return false;
        }
    }
    false
}

/// One trapezoid of acceleration up to `vt`, in the direction of motion.
fn rise<S: Sink>(sink: &mut S, vt: f64, limits: &SCurve) {
    let (v, a) = (sink.velocity(), sink.acceleration());
    let mirrored = if v != 0.0 { v < 0.0 } else { vt < 0.0 };
    let sign = if mirrored { -1.0 } else { 1.0 };
    change_by(sink, (vt - v).abs(), sign * a, 0.0, sign, &limits.up);
    sink.set(vt, 0.0);
}

/// Changes the velocity by `dv` in the direction `sign`, from acceleration `a` to `c` (both at least 0,
/// in that direction), with one trapezoid of acceleration, which is possible.
#[inline(always)]
pub(crate) fn change_by<S: Sink>(sink: &mut S, dv: f64, a: f64, c: f64, sign: f64, side: &Side) {
    let &Side {
        most,
        jerk,
        per_most,
        per_jerk,
    } = side;
    if a > most {
        sink.push((a - most) * per_jerk, -sign * jerk);
        sink.set(sink.velocity(), sign * most);
        sink.push((dv - 0.5 * (a * a - c * c) * per_jerk) * per_most, 0.0);
        sink.push((most - c) * per_jerk, -sign * jerk);
        return;
    }
    let peak_squared = jerk * dv + 0.5 * (a * a + c * c);
    if peak_squared <= most * most {
        let peak = peak_squared.max(0.0).sqrt().max(a).max(c);
        sink.push((peak - a) * per_jerk, sign * jerk);
        sink.push((peak - c) * per_jerk, -sign * jerk);
    } else {
        sink.push((most - a) * per_jerk, sign * jerk);
        sink.set(sink.velocity(), sign * most);
        sink.push((dv - (most * most - 0.5 * (a * a + c * c)) * per_jerk) * per_most, 0.0);
        sink.push((most - c) * per_jerk, -sign * jerk);
    }
}

/// One pass with `v >= 0`, deceleration `b >= 0`, mirrored by `sign`. True when the ramp is done.
#[inline(always)]
fn slow_down<S: Sink>(sink: &mut S, v: f64, b: f64, vt: f64, sign: f64, limits: &SCurve) -> bool {
    let side = &limits.down;
    let relieved = 0.5 * b * b * side.per_jerk;
    if vt >= 0.0 {
        let above = v - relieved - vt;
        let slack = SAME_VELOCITY_SHARE * (v + relieved);
        if v < relieved - slack {
            // The speed passes through 0 in any case.
            cross(sink, v, b, sign, side.jerk);
            return false;
        }
        if above < -slack {
            sink.push(b * side.per_jerk, sign * side.jerk);
            sink.set(sign * (v - relieved).max(0.0), 0.0);
            return false;
        }
        change_by(sink, v - vt, b, 0.0, -sign, side);
        sink.set(sign * vt, 0.0);
        return true;
    }
    // The acceleration with which the motion passes through rest: legal on both sides of it, and low enough not to overshoot `vt`.
    let most = limits.up.most.min(side.most);
    let square = -2.0 * limits.up.jerk * vt;
    let c = if square < most * most { square.sqrt() } else { most };
    if b > side.most {
        if v < 0.5 * (b * b - c * c) * side.per_jerk {
            cross(sink, v, b, sign, side.jerk);
            return false;
        }
    } else {
        let largest = b.max(c);
        if side.jerk * v + 0.5 * (b * b + c * c) < largest * largest {
            if b >= c {
                cross(sink, v, b, sign, side.jerk);
            } else {
                let last = (b * b + 2.0 * side.jerk * v).sqrt();
                sink.push(2.0 * v / (b + last), -sign * side.jerk);
                sink.set(0.0, -sign * last);
            }
            return false;
        }
    }
    change_by(sink, v, b, c, -sign, side);
    sink.set(0.0, if c == 0.0 { 0.0 } else { -sign * c });
    false
}

/// Relaxes the deceleration `b` until the velocity is 0.
#[inline(always)]
fn cross<S: Sink>(sink: &mut S, v: f64, b: f64, sign: f64, j: f64) {
    let left = (b * b - 2.0 * j * v).max(0.0).sqrt();
    sink.push(2.0 * v / (b + left), sign * j);
    sink.set(0.0, -sign * left);
}

const MAX_PASSES: usize = 8;
