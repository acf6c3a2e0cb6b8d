//! Trapezoidal profiles in closed form from any velocity (spec/motion-core.md §2). The acceleration of the
//! start state is not read, as that of a trapezoid may jump.
//!
//! `v0, vf` entry and exit speed, `vp` peak, `V, A, D` limits, as in the paper.

use crate::KinematicState;
use crate::builder::{Builder, Sink};
use crate::limits::{Trapezoid, displacement};
use crate::position::nearness;
use crate::profile::Profile;

pub(crate) fn to_position(profile: &mut Profile, target: f64, end_speed: f64, limits: &Trapezoid) {
    let from = &profile.start();
    let (accel, decel) = (limits.acceleration, limits.deceleration);
    let (per_accel, per_decel) = (limits.per_acceleration, limits.per_deceleration);
    if limits.speed == 0.0 {
        let mut builder = Builder::new(profile, 1.0);
        ramp(&mut builder, 0.0, limits);
        let end = KinematicState {
            velocity: 0.0,
            acceleration: 0.0,
            ..builder.state()
        };
        return builder.finish(end, end.position == target);
    }
    let end_speed = end_speed.clamp(-limits.speed, limits.speed);
    let x = displacement(from.position, target);
    let x0 = 0.5 * from.velocity * from.velocity.abs() * per_decel;
    let end = KinematicState {
        position: target,
        velocity: end_speed,
        acceleration: 0.0,
    };
    if end_speed == 0.0 && (x - x0).abs() <= nearness(from, target, x, x0) {
        let mut builder = Builder::new(profile, 1.0);
        ramp(&mut builder, 0.0, limits);
        return builder.finish(end, true);
    }
    let sign = if end_speed == 0.0 {
        (x - x0).signum()
    } else {
        end_speed.signum()
    };
    let (x, vf) = (sign * x, sign * end_speed);
    let mut builder = Builder::new(profile, sign);
    turn(&mut builder, limits);
    let v0 = builder.velocity();
    let left = x - builder.now.x;
    // Products instead of squares: no loss of digits between similar speeds.
    let excess = (v0 - vf) * (v0 + vf);
    let least = if excess > 0.0 {
        0.5 * excess * per_decel
    } else {
        -0.5 * excess * per_accel
    };
    if left < least && vf > 0.0 && least - left > nearness(from, target, left, least) {
        let mut builder = Builder::new(profile, sign);
        ramp(&mut builder, vf, limits);
        if !builder.cut_at(x, target) {
            to_position(profile, target, 0.0, limits);
        }
        return;
    }
    let v = limits.speed;
    if v0 > v {
        let far = 0.5 * ((v0 - v) * (v0 + v) + (v - vf) * (v + vf)) * per_decel;
        hold(&mut builder, (v0 - v) * per_decel, -decel, v);
        hold(&mut builder, (left - far) / v, 0.0, v);
        hold(&mut builder, (v - vf) * per_decel, -decel, vf);
        return builder.finish(end, true);
    }
    let far = 0.5 * ((v - v0) * (v + v0) * per_accel + (v - vf) * (v + vf) * per_decel);
    if far <= left {
        hold(&mut builder, (v - v0) * per_accel, accel, v);
        hold(&mut builder, (left - far) / v, 0.0, v);
        hold(&mut builder, (v - vf) * per_decel, -decel, vf);
        return builder.finish(end, true);
    }
    // Differences of squares of the peak with entry and exit speed.
    let above_entry = accel * (2.0 * decel * left - excess).max(0.0) / (accel + decel);
    let above_exit = decel * (2.0 * accel * left + excess).max(0.0) / (accel + decel);
    let vp = (above_entry + v0 * v0).sqrt();
    if above_entry > 0.0 {
        hold(&mut builder, above_entry / (vp + v0) * per_accel, accel, vp);
    }
    if above_exit > 0.0 {
        hold(&mut builder, above_exit / (vp + vf) * per_decel, -decel, vf);
    }
    builder.finish(end, true)
}

/// To velocity `vt`.
pub(crate) fn ramp(builder: &mut Builder<'_>, vt: f64, limits: &Trapezoid) {
    let sign = if vt != 0.0 {
        vt.signum()
    } else {
        -builder.velocity().signum()
    };
    let v = sign * builder.velocity();
    let vt = sign * vt;
    if v < 0.0 {
        hold(builder, -v * limits.per_deceleration, sign * limits.deceleration, 0.0);
    }
    let v = v.max(0.0);
    if v < vt {
        hold(
            builder,
            (vt - v) * limits.per_acceleration,
            sign * limits.acceleration,
            sign * vt,
        );
    } else {
        hold(
            builder,
            (v - vt) * limits.per_deceleration,
            -sign * limits.deceleration,
            sign * vt,
        );
    }
    builder.set(sign * vt, 0.0);
}

/// Brakes a motion in the negative direction to rest.
fn turn(builder: &mut Builder<'_>, limits: &Trapezoid) {
    let v = builder.velocity();
    if v < 0.0 {
        hold(builder, -v * limits.per_deceleration, limits.deceleration, 0.0);
    }
}

/// Adds a segment of `time` with constant acceleration and the end velocity `end`.
fn hold(builder: &mut Builder<'_>, time: f64, acceleration: f64, end: f64) {
    let v = builder.velocity();
    builder.set(v, acceleration);
    builder.push(time, 0.0);
    builder.set(end, 0.0);
}
