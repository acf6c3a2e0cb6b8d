//! The speed at which a point is passed, against plans.

use super::*;

const SMOOTH: Limits = Limits {
    speed: 10.0,
    acceleration: 2.0,
    deceleration: 4.0,
    jerk: Some(Jerk {
        acceleration: 2.0,
        deceleration: 4.0,
    }),
};
const SIMPLE: Limits = Limits { jerk: None, ..SMOOTH };

#[test]
fn places_ahead_are_passed_at_the_nearest_speed() {
    #[rustfmt::skip]
    let cases = [
        // why,                                  v,   a,    distance, wanted, limits,  speed, level
        ("as wanted",                            8.0, 0.0,  10.0, 8.0, &SIMPLE, 8.0, true),
        ("braked to what is wanted",             8.0, 0.0,   8.0, 0.0, &SIMPLE, 0.0, true),
        ("braked as far as it goes",             5.0, 0.0,   2.0, 1.0, &SIMPLE, 3.0, true),
        ("sped up as far as it goes",            0.0, 0.0,   1.0, 5.0, &SIMPLE, 2.0, true),
        ("S-curve: slowed down by 4 in 2 s",     8.0, 0.0,  12.0, 4.0, &SMOOTH, 4.0, true),
        ("no way to bring the acceleration to 0", 8.0, -4.0, 1.0, 8.0, &SMOOTH, 6.0, false),
        ("no distance at all",                        8.0, 0.0,   0.0, 2.0, &SMOOTH, 8.0, true),
        ("what is no number counts as 0",   f64::NAN, 0.0,   1.0, 0.0, &SMOOTH, 0.0, true),
    ];
    for (why, velocity, acceleration, distance, wanted, limits, speed, level) in cases {
        let from = KinematicState {
            position: 3.0,
            velocity,
            acceleration,
        };
        let passing = passing_speed(from, distance, wanted, limits);
        assert!((passing.speed - speed).abs() <= 1e-9, "{why}: {passing:?}");
        assert_eq!(passing.level, level, "{why}: {passing:?}");
    }
}

#[test]
fn the_passing_speed_can_be_planned_and_no_nearer_one() {
    for case in 0..cases(20_000) {
        let mut random = Random(case ^ 0xBEEF);
        let limits = random.limits(2.0);
        let mut from = random.state(&limits);
        from.velocity = from.velocity.abs();
        let relieved = limits
            .jerk
            .map_or(0.0, |jerk| 0.5 * from.acceleration.powi(2) / jerk.deceleration);
        if from.acceleration < 0.0 && from.velocity < relieved {
            // It reverses in any case.
            continue;
        }
        let wanted = random.unit() * limits.speed;
        let stop = Profile::stop(from, &limits).end().position;
        let distance = 1.5 * random.unit() * stop.abs().max(1e-6);
        let told = format!("case {case}: {from:?} over {distance}, {wanted} wanted, {limits:?}");
        let passing = passing_speed(from, distance, wanted, &limits);
        let displacement = |speed: f64| Profile::to_velocity(from, speed, &limits).end().position;
        let fits = |speed: f64| displacement(speed) <= distance * (1.0 + 1e-9);
        assert_eq!(passing.level, fits(passing.speed), "{told}: {passing:?}");
        if stop <= distance && stop >= 0.0 {
            assert!(passing.level, "who can stop can pass: {told}: {passing:?}");
        }
        if !passing.level {
            continue;
        }
        // A speed below `wanted` was reached by speeding up, or by braking to a lower speed.
        let nearer = passing.speed + 1e-3 * (wanted - passing.speed);
        if (passing.speed - wanted).abs() > 1e-6 * limits.speed {
            assert!(
                displacement(nearer) >= distance * (1.0 - 1e-9),
                "{told}: {passing:?} and {nearer}"
            );
        }
        let fast = Limits {
            speed: limits.speed.max(passing.speed),
            ..limits
        };
        let end = Profile::to_position(from, distance, passing.speed, &fast).end();
        assert!((end.position - distance).abs() <= 1e-9 * distance, "{told}: {end:?}");
        assert!(
            (end.velocity - passing.speed).abs() <= 1e-3 * limits.speed,
            "{told}: {passing:?} {end:?}"
        );
    }
}
