//! S-curve to a position: one monotone family of candidates, one root (spec/motion-core.md §3.4).
//!
//! Works in a frame mirrored so that the needed direction is positive. `x0` is the end of a stop from the start state (or of the ramp to the end
//! speed). The up-run speeds up towards the limit; the profile follows it, then ramps down. If it leaves the up-run while speeding up, the peak
//! speed has a closed solution (`peak`); if it leaves earlier (still slowing down, or turning round), the switch time is the root of a monotone
//! function (`root`).

use crate::KinematicState;
use crate::builder::{Builder, Sink, Trial};
use crate::limits::{SCurve, displacement};
use crate::peak::{self, Peak};
use crate::profile::Profile;
use crate::ramp::{approach, change_by, ramp};
use crate::tolerance::{
    ABOVE_ROUNDING_SHARE, CLOSE_DISPLACEMENT_SHARE, DISPLACEMENT_SHARE, LEAST_VELOCITY_SHARE, ROUNDED_SHARE,
    SAMPLED_POSITION_SHARE,
};
use crate::{early, root};

pub(crate) fn to_position(profile: &mut Profile, target: f64, end_speed: f64, limits: &SCurve) {
    let from = &profile.start();
    if limits.speed == 0.0 {
        return stop(profile, target, limits);
    }
    let end_speed = end_speed.clamp(-limits.speed, limits.speed);
    let x = displacement(from.position, target);
    if end_speed == 0.0 && x.abs() > farthest_stop(from, limits) {
        let sign = x.signum();
        return forward(profile, sign, sign * x, target, 0.0, limits);
    }
    let mut x0 = if end_speed == 0.0 {
        stop_displacement(from, limits)
    } else {
        ramp_displacement(from, end_speed, limits)
    };
    let mut near = nearness(from, target, x, x0);
    if (x - x0).abs() <= CLOSE_DISPLACEMENT_SHARE * x.abs().max(x0.abs()) {
        let farthest;
        (x0, farthest) = ramp_excursion(from, end_speed, limits);
        // A ramp that returns has its end only to the digits of its excursion; the same holds for the caller's end speed.
        near = near.max(4.0 * nearness(from, target, 0.0, farthest));
    }
    if (x - x0).abs() <= near {
        let mut builder = Builder::new(profile, 1.0);
        ramp(&mut builder, end_speed, limits);
        return builder.finish(arrived(target, end_speed), true);
    }
    let sign = if end_speed == 0.0 {
        (x - x0).signum()
    } else {
        end_speed.signum()
    };
    let (x, x0, end_speed) = (sign * x, sign * x0, sign * end_speed);
    if x < x0 {
        // Too short for the end speed: the straight ramp up to the target.
        let mut builder = Builder::new(profile, sign);
        ramp(&mut builder, end_speed, limits);
        if !builder.cut_at(x, target) {
            to_position(profile, target, 0.0, limits);
        }
        return;
    }
    forward(profile, sign, x, target, end_speed, limits)
}

pub(crate) fn to_position_two_stage(profile: &mut Profile, target: f64, limits: &SCurve) {
    let from = &profile.start();
    if limits.speed == 0.0 {
        return stop(profile, target, limits);
    }
    let x = displacement(from.position, target);
    let x0 = ramp_displacement(from, 0.0, limits);
    let direction = if from.velocity != 0.0 {
        from.velocity.signum()
    } else {
        from.acceleration.signum()
    };
    let at_rest = from.velocity == 0.0 && from.acceleration == 0.0;
    if at_rest || (x - x0) * direction >= 0.0 || (x - x0).abs() <= nearness(from, target, x, x0) {
        return to_position(profile, target, 0.0, limits);
    }
    let sign = -direction;
    let mut builder = Builder::new(profile, sign);
    ramp(&mut builder, 0.0, limits);
    let left = sign * x - builder.now.x;
    if let Some(peak) = peak::peak(0.0, 0.0, left, 0.0, limits) {
        run(&mut builder, &peak, 0.0, limits);
    }
    builder.finish(arrived(target, 0.0), true)
}

/// The fastest profile over `x`, which is at least the displacement of the ramp to `end_speed >= 0`.
fn forward(profile: &mut Profile, sign: f64, x: f64, target: f64, end_speed: f64, limits: &SCurve) {
    let mut builder = Builder::new(profile, sign);
    let end = arrived(target, sign * end_speed);
    let from_above = !approach(&mut builder, limits.speed, limits);
    let Trial { x: run_up, v, a } = builder.now;
    let found = if from_above {
        // The up-run came down to the limit from above and has no rest.
        let down = limits.speed - end_speed;
        let cruise = x - run_up - peak::ramp(end_speed, down, &limits.down);
        (cruise >= 0.0).then_some(Peak {
            up: 0.0,
            top: limits.speed,
            cruise: cruise / limits.speed,
            down,
        })
    } else {
        peak::peak(v, a, x - run_up, end_speed, limits)
    };
    match found {
        Some(peak) => run(&mut builder, &peak, end_speed, limits),
        None => {
            if end_speed != 0.0 || !leave_for_rest(&mut builder, x, limits) {
                leave_early(&mut builder, x, end_speed, limits);
            }
            ramp(&mut builder, end_speed, limits);
        }
    }
    builder.finish(end, true)
}

/// As [`leave_early`] for an end at rest, if the phase of the exit has a closed form; otherwise returns false.
fn leave_for_rest(builder: &mut Builder<'_>, x: f64, limits: &SCurve) -> bool {
    let Some(last) = builder.len.checked_sub(1) else {
        return false;
    };
    let side = &limits.down;
    let (state, jerk) = builder.segment(last);
    if state.v > 0.0 && state.a < 0.0 && jerk > 0.0 {
        let left = early::relaxed_to(&state, x, side);
        builder.rewind(last, state);
        builder.push((-state.a - left) * side.per_jerk, side.jerk);
        return true;
    }
    let c = builder.acceleration();
    if builder.velocity() != 0.0 || c <= 0.0 {
        return false;
    }
    let braking = |&index: &usize| {
        let state = builder.segment(index).0;
        state.v < 0.0 && (0.0..=side.most).contains(&state.a)
    };
    let Some(first) = (0..=last).find(braking) else {
        return false;
    };
    let state = builder.segment(first).0;
    let (v, b) = (-state.v, state.a);
    if v < LEAST_VELOCITY_SHARE * b * b * side.per_jerk {
        return false;
    }
    let c = early::passed_with(v, b, x - state.x, c, limits);
    builder.rewind(first, state);
    change_by(builder, v, b, c, 1.0, side);
    builder.set(0.0, c);
    true
}

/// Rewinds the builder to the instant from which the ramp to `end_speed` ends at `x`.
fn leave_early(builder: &mut Builder<'_>, x: f64, end_speed: f64, limits: &SCurve) {
    let misses_by = |mut trial: Trial| {
        ramp(&mut trial, end_speed, limits);
        trial.x - x
    };
    let segments = builder.len;
    let mut before = f64::NEG_INFINITY;
    for index in 0..segments {
        let next = if index + 1 < segments {
            builder.segment(index + 1).0
        } else {
            builder.now
        };
        let after = misses_by(next);
        if after < 0.0 && index + 1 < segments {
            before = after;
            continue;
        }
        let (state, jerk) = builder.segment(index);
        let length = builder.length_of(index);
        let time = if after <= 0.0 {
            length
        } else {
            if before == f64::NEG_INFINITY {
                before = misses_by(state);
            }
            let tolerance = SAMPLED_POSITION_SHARE * x.abs().max(before.abs()).max(state.x.abs());
            root::solve(length, before.min(0.0), after, tolerance, |u| {
                let mut trial = state;
                trial.push(u, jerk);
                misses_by(trial)
            })
        };
        builder.rewind(index, state);
        builder.push(time, jerk);
        return;
    }
}

/// Adds the rise, the cruise and the fall of a peak.
#[inline(always)]
fn run(builder: &mut Builder<'_>, peak: &Peak, end_speed: f64, limits: &SCurve) {
    let acceleration = builder.acceleration();
    change_by(builder, peak.up, acceleration, 0.0, 1.0, &limits.up);
    builder.set(peak.top, 0.0);
    builder.push(peak.cruise, 0.0);
    change_by(builder, peak.down, 0.0, 0.0, -1.0, &limits.down);
    builder.set(end_speed, 0.0);
}

fn stop(profile: &mut Profile, target: f64, limits: &SCurve) {
    let mut builder = Builder::new(profile, 1.0);
    ramp(&mut builder, 0.0, limits);
    let end = KinematicState {
        velocity: 0.0,
        acceleration: 0.0,
        ..builder.state()
    };
    builder.finish(end, end.position == target)
}

/// No stop from this state ends farther away than this, to either side: the acceleration is brought to 0 at
/// most twice (the motion passes through rest between), and the rest is less than a stop from the
/// largest possible speed.
fn farthest_stop(from: &KinematicState, limits: &SCurve) -> f64 {
    let relieving = from.acceleration.abs() * limits.up.per_jerk.max(limits.down.per_jerk);
    let fastest = from.velocity.abs() + 0.5 * from.acceleration.abs() * relieving;
    (1.0 + ABOVE_ROUNDING_SHARE) * fastest * (2.0 * relieving + 0.5 * peak::ramp_time(fastest, &limits.down).0)
}

/// Displacement of the stop from this state in closed form, with a few digits less than [`ramp_displacement`].
fn stop_displacement(from: &KinematicState, limits: &SCurve) -> f64 {
    let (up, down) = (&limits.up, &limits.down);
    let mirrored = from.velocity < 0.0 || (from.velocity == 0.0 && from.acceleration < 0.0);
    let sign = if mirrored { -1.0 } else { 1.0 };
    let (v, a) = (sign * from.velocity, sign * from.acceleration);
    // From (v, a) with a >= 0: level off, then stop.
    let levelled = |v: f64, a: f64| {
        let time = a * up.per_jerk;
        let gained = a * time;
        time * (v + gained * (1.0 / 3.0)) + peak::ramp(0.0, v + 0.5 * gained, down)
    };
    if a >= 0.0 {
        return sign * levelled(v, a);
    }
    let b = -a;
    let relaxing = b * down.per_jerk;
    let relieved = 0.5 * b * relaxing;
    if v < relieved {
        // Relax until the motion passes through rest, then level off on the other side.
        let left = (b * b - 2.0 * down.jerk * v).max(0.0).sqrt();
        let time = 2.0 * v / (b + left);
        let out = time * (v - time * (2.0 * b + left) * (1.0 / 6.0));
        return sign * (out - levelled(0.0, left));
    }
    if b > down.most {
        return ramp_displacement(from, 0.0, limits);
    }
    // The later part of a stop from a higher speed and acceleration 0.
    let higher = v + relieved;
    sign * (peak::ramp(0.0, higher, down) - relaxing * (higher - relieved * (1.0 / 3.0)))
}

fn ramp_displacement(from: &KinematicState, velocity: f64, limits: &SCurve) -> f64 {
    ramp_excursion(from, velocity, limits).0
}

/// The displacement of a ramp, and its largest magnitude at the ends of the segments.
fn ramp_excursion(from: &KinematicState, velocity: f64, limits: &SCurve) -> (f64, f64) {
    let mut excursion = Excursion {
        trial: Trial {
            x: 0.0,
            v: from.velocity,
            a: from.acceleration,
        },
        farthest: 0.0,
    };
    ramp(&mut excursion, velocity, limits);
    (excursion.trial.x, excursion.farthest)
}

/// A trial that records its largest displacement.
struct Excursion {
    trial: Trial,
    farthest: f64,
}

impl Sink for Excursion {
    fn velocity(&self) -> f64 {
        self.trial.v
    }

    fn acceleration(&self) -> f64 {
        self.trial.a
    }

    #[inline(always)]
    fn push(&mut self, time: f64, jerk: f64) {
        self.trial.push(time, jerk);
        self.farthest = self.farthest.max(self.trial.x.abs());
    }

    #[inline(always)]
    fn set(&mut self, velocity: f64, acceleration: f64) {
        self.trial.set(velocity, acceleration);
    }
}

/// Differences of displacement below this are rounding.
pub(crate) fn nearness(from: &KinematicState, target: f64, x: f64, x0: f64) -> f64 {
    DISPLACEMENT_SHARE * x.abs().max(x0.abs()) + ROUNDED_SHARE * from.position.abs().max(target.abs())
}

fn arrived(target: f64, velocity: f64) -> KinematicState {
    KinematicState {
        position: target,
        velocity,
        acceleration: 0.0,
    }
}
