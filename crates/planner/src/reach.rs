//! Speeds that can be reached over a length, and where a profile turns.

use arcline_profile::{Limits, Phase, Profile, State};

/// Halvings of a speed: to the last bits of a double.
const BISECTIONS: u32 = 60;

/// The largest speed from which `end_speed` is reachable within a length.
pub(crate) fn entry_speed(length: f64, end_speed: f64, limits: &Limits) -> f64 {
    let distance = |speed: f64| {
        let change = (speed - end_speed).max(0.0);
        let d = limits.deceleration;
        let time = match limits.jerk {
            None => change / d,
            Some(jerk) if change >= d * d / jerk.deceleration => change / d + d / jerk.deceleration,
            Some(jerk) => 2.0 * (change / jerk.deceleration).sqrt(),
        };
        0.5 * (speed + end_speed) * time
    };
    let mut high = limits.speed.max(end_speed);
    if distance(high) <= length {
        return high;
    }
    let mut low = end_speed;
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if distance(middle) <= length {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The largest speed up to the limit that is reachable over a length from a state, without acceleration there.
pub(crate) fn exit_speed(from: State, length: f64, limits: &Limits) -> f64 {
    let distance = |speed: f64| Profile::to_velocity(from, speed, limits).end().position - from.position;
    if distance(limits.speed) <= length {
        return limits.speed;
    }
    // Slower than what is left when the acceleration is ramped out takes a longer way again.
    let released = limits.jerk.map_or(0.0, |jerk| {
        let jerk = if from.acceleration > 0.0 {
            jerk.acceleration
        } else {
            jerk.deceleration
        };
        from.acceleration * from.acceleration.abs() / (2.0 * jerk)
    });
    let (mut low, mut high) = ((from.velocity + released).clamp(0.0, limits.speed), limits.speed);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if distance(middle) <= length {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Seconds until a profile first stops speeding up.
pub(crate) fn accelerates_until(profile: &Profile) -> f64 {
    let turns = profile.segment_times().iter();
    turns
        .copied()
        .find(|time| profile.phase(*time) != Phase::Accelerating)
        .unwrap_or(profile.duration())
}

/// Seconds after which a profile only slows down.
pub(crate) fn brakes_from(profile: &Profile) -> f64 {
    let turns = profile.segment_times().iter().rev();
    turns
        .copied()
        .take_while(|time| profile.phase(*time) == Phase::Decelerating)
        .last()
        .unwrap_or(profile.duration())
}
