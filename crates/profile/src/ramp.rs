//! The S-curve's ramp primitive: from any `(v, a)` to `(vt, 0)` (motion-core §3.3).
//!
//! Letters as in the paper: `v, a` state, `vt` wanted velocity, `b = -a` while slowing, `c` the
//! acceleration with which the motion passes through rest, `vz` the velocity if the acceleration is
//! brought to 0 at once.

use crate::builder::Sink;
use crate::limits::SCurve;

/// From the sink's state to velocity `vt` with acceleration 0: at most nine segments.
pub(crate) fn ramp<S: Sink>(sink: &mut S, vt: f64, limits: &SCurve) {
    if approach(sink, vt, limits) {
        rise(sink, vt, limits);
    }
}

/// All of [`ramp`] but its last rise: runs until what is left is to speed up towards `vt` (in the
/// direction of `vt`) with one trapezoid of acceleration, and returns true; returns false when the
/// ramp ended without such a rise.
pub(crate) fn approach<S: Sink>(sink: &mut S, vt: f64, limits: &SCurve) -> bool {
    // Every pass but the last ends with v = 0 or a = 0; five is the most there are.
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
            let vz = v + a * a / (2.0 * limits.jerk);
            if vt >= vz - SNAP * vz {
                return true;
            }
            sink.push(a / limits.jerk, -sign * limits.jerk);
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
    rise_by(sink, sign * a, (vt - v).abs(), sign, limits);
    sink.set(vt, 0.0);
}

/// Speeds up by `dv` from acceleration `a >= 0` to 0, in the frame mirrored by `sign`.
pub(crate) fn rise_by<S: Sink>(sink: &mut S, a: f64, dv: f64, sign: f64, limits: &SCurve) {
    let (most, j) = (limits.acceleration, limits.jerk);
    if a > most {
        sink.push((a - most) / j, -sign * j);
        sink.set(sink.velocity(), sign * most);
        sink.push((dv - a * a / (2.0 * j)) / most, 0.0);
        sink.push(most / j, -sign * j);
        return;
    }
    let peak = (j * dv + 0.5 * a * a).sqrt().max(a);
    if peak <= most {
        sink.push((peak - a) / j, sign * j);
        sink.push(peak / j, -sign * j);
    } else {
        sink.push((most - a) / j, sign * j);
        sink.set(sink.velocity(), sign * most);
        sink.push((dv - (2.0 * most * most - a * a) / (2.0 * j)) / most, 0.0);
        sink.push(most / j, -sign * j);
    }
}

/// One pass with `v >= 0`, deceleration `b >= 0`, mirrored by `sign`. True when the ramp is done.
fn slow_down<S: Sink>(sink: &mut S, v: f64, b: f64, vt: f64, sign: f64, limits: &SCurve) -> bool {
    let (most, j) = (limits.deceleration, limits.jerk_down);
    let relieved = b * b / (2.0 * j);
    let (e, c);
    if vt >= 0.0 {
        let above = v - relieved - vt;
        let slack = SNAP * (v + relieved);
        if v < relieved - slack {
            // Speed must pass 0 whatever is done.
            cross(sink, v, b, sign, j);
            return false;
        }
        if above < -slack {
            sink.push(b / j, sign * j);
            sink.set(sign * (v - relieved).max(0.0), 0.0);
            return false;
        }
        (e, c) = (vt, 0.0);
    } else {
        (e, c) = (0.0, limits.acceleration.min(most).min((-2.0 * limits.jerk * vt).sqrt()));
    }
    let dv = v - e;
    if b > most {
        let held = dv - (b * b - c * c) / (2.0 * j);
        if held < 0.0 && vt < 0.0 {
            cross(sink, v, b, sign, j);
            return false;
        }
        sink.push((b - most) / j, sign * j);
        sink.set(sink.velocity(), -sign * most);
        sink.push(held / most, 0.0);
        sink.push((most - c) / j, sign * j);
    } else {
        let peak_squared = j * dv + 0.5 * (b * b + c * c);
        let largest = b.max(c);
        if vt < 0.0 && peak_squared < largest * largest {
            if b >= c {
                cross(sink, v, b, sign, j);
            } else {
                let last = (b * b + 2.0 * j * v).sqrt();
                sink.push(2.0 * v / (b + last), -sign * j);
                sink.set(0.0, -sign * last);
            }
            return false;
        }
        let peak = peak_squared.max(0.0).sqrt().max(largest);
        if peak <= most {
            sink.push((peak - b) / j, -sign * j);
            sink.push((peak - c) / j, sign * j);
        } else {
            sink.push((most - b) / j, -sign * j);
            sink.set(sink.velocity(), -sign * most);
            sink.push((dv - (2.0 * most * most - b * b - c * c) / (2.0 * j)) / most, 0.0);
            sink.push((most - c) / j, sign * j);
        }
    }
    sink.set(sign * e, if c == 0.0 { 0.0 } else { -sign * c });
    vt >= 0.0
}

/// Relaxes the deceleration `b` until the velocity is 0.
fn cross<S: Sink>(sink: &mut S, v: f64, b: f64, sign: f64, j: f64) {
    let left = (b * b - 2.0 * j * v).max(0.0).sqrt();
    sink.push(2.0 * v / (b + left), sign * j);
    sink.set(0.0, -sign * left);
}

/// Relative difference of velocities that is rounding: a ramp over it would take a visible time
/// (square root) for an invisible change.
const SNAP: f64 = 2e-15;
const MAX_PASSES: usize = 8;
