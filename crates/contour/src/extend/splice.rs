//! The splice: the instant at which an extension leaves the running trajectory. Position units and seconds.

use crate::limits::{MoveLimits, Smoothness};
use crate::path::reference::nearest;
use crate::tuning::TUNING;
use crate::{AxisLimits, ContourMove, Trajectory};

/// The instant from `earliest` on, within a short time, at which the motion uses the least of its limits. `moves` are those of the running
/// trajectory from its `first`-th on.
pub(crate) fn splice(
    running: &Trajectory,
    first: usize,
    moves: &[ContourMove],
    limits: &AxisLimits,
    earliest: f64,
) -> Option<f64> {
    let last = running.duration() - TUNING.extend.least_left_s;
    if earliest > last {
        return None;
    }
    let mut best = (f64::INFINITY, earliest);
    for k in 0..=TUNING.extend.choice {
        let t = near_knot(running, earliest + f64::from(k) * TUNING.extend.choice_step_s);
        if t > last {
            break;
        }
        let on = running.move_at(t).checked_sub(first)?;
        if on >= moves.len() {
            break;
        }
        let near = &moves[on.saturating_sub(1)..(on + 2).min(moves.len())];
        let used = in_use(running, near, limits, t);
        if used < best.0 {
            best = (used, t);
        }
    }
    Some(best.1)
}

/// The used share of the tolerance and the acceleration limits at an instant near some moves.
fn in_use(running: &Trajectory, near: &[ContourMove], limits: &AxisLimits, t: f64) -> f64 {
    let state = running.at(t);
    let off = near
        .iter()
        .filter(|m| m.has_length())
        .map(|m| (nearest(&m.path, &state.position) - state.position).norm())
        .fold(f64::INFINITY, f64::min);
    let tolerance = near.iter().map(|m| m.tolerance).fold(f64::INFINITY, f64::min);
    let mut used = if tolerance > 0.0 { off / tolerance } else { 0.0 };
    for axis in 0..3 {
        used += TUNING.extend.acceleration_weight * state.acceleration[axis].abs() / limits.acceleration[axis];
    }
    used
}

/// The next knot, if it is close.
fn near_knot(running: &Trajectory, t: f64) -> f64 {
    let next = running.knots.partition_point(|knot| knot.time < t);
    let near = running.knots.get(next).map(|knot| knot.time);
    near.filter(|&near| near < t + 2.0 * TUNING.extend.choice_step_s)
        .unwrap_or(t)
}

/// The duration of a motion's braking at its end, seconds.
pub(crate) fn braking_time(last: &ContourMove, limits: &AxisLimits) -> f64 {
    let smoothness = Smoothness::of(core::slice::from_ref(last));
    let bounds = MoveLimits::new(last, limits, smoothness);
    let rate = bounds.deceleration.min(bounds.axes.acceleration.min());
    let speed = bounds.speed.min(bounds.axes.speed.norm());
    if smoothness == Smoothness::Trapezoid {
        return speed / rate;
    }
    let jerk = bounds.least_jerk();
    if speed * jerk >= rate * rate {
        speed / rate + rate / jerk
    } else {
        2.0 * (speed / jerk).sqrt()
    }
}
