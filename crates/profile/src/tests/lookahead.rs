//! The look-ahead's tools and the profile's ramp times, against plans and bisection.

use super::*;

const SIMPLE: Limits = Limits {
    speed: 10.0,
    acceleration: 2.0,
    deceleration: 4.0,
    jerk: None,
};
/// Speeding up by 2 takes 2 s over 2 units from rest; slowing down by 4 takes 2 s over 4 units.
const SMOOTH: Limits = Limits {
    jerk: Some(Jerk {
        acceleration: 2.0,
        deceleration: 4.0,
    }),
    ..SIMPLE
};

fn moving(velocity: f64, acceleration: f64) -> KinematicState {
    KinematicState {
        position: 0.0,
        velocity,
        acceleration,
    }
}

fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 1e-12 * expected.abs()
}

#[test]
fn stop_distances() {
    #[rustfmt::skip]
    let cases = [
        // why,                       speed, limits,  distance
        ("at rest",                     0.0, &SIMPLE, 0.0),
        ("trapezoid: v^2/2D",           8.0, &SIMPLE, 8.0),
        ("either direction",           -8.0, &SIMPLE, 8.0),
        ("jerk only",                   1.0, &SMOOTH, 0.5),
        ("D is just reached",           4.0, &SMOOTH, 4.0),
        ("D is held: v/2 (v/D + D/j)",  8.0, &SMOOTH, 12.0),
        ("not a number",           f64::NAN, &SMOOTH, 0.0),
    ];
    for (why, speed, limits, distance) in cases {
        assert!(near(stop_distance(speed, limits), distance), "{why}");
    }
}

#[test]
fn entry_speeds() {
    #[rustfmt::skip]
    let cases = [
        // why,                length, end, limits,  speed
        ("no distance",           0.0, 3.0, &SIMPLE, 3.0),
        ("trapezoid",             8.0, 0.0, &SIMPLE, 8.0),
        ("trapezoid to a speed",  2.0, 3.0, &SIMPLE, 5.0),
        ("no distance",           0.0, 3.0, &SMOOTH, 3.0),
        ("to rest, jerk only",    0.5, 0.0, &SMOOTH, 1.0),
        ("to rest, D held",      12.0, 0.0, &SMOOTH, 8.0),
        ("to a speed, jerk only", 3.5, 3.0, &SMOOTH, 4.0),
        ("to a speed, D held",   24.0, 4.0, &SMOOTH, 12.0),
        ("above the speed limit", 125.5e3, 0.0, &SMOOTH, 1000.0),
        ("negative distance",         -1.0, 2.0, &SMOOTH, 2.0),
    ];
    for (why, length, end, limits, speed) in cases {
        let found = entry_speed(length, end, limits);
        assert!(
            (found - speed).abs() <= 1e-11 * speed,
            "{why}: {found}, expected {speed}"
        );
    }
}

#[test]
fn exit_speeds() {
    #[rustfmt::skip]
    let cases = [
        // why,                       from,             length, limits,  speed
        ("no way",                    moving(3.0, 0.0),   0.0, &SIMPLE, 3.0),
        ("trapezoid",                 moving(3.0, 0.0),   4.0, &SIMPLE, 5.0),
        ("trapezoid up to the limit", moving(3.0, 0.0), 400.0, &SIMPLE, 10.0),
        ("trapezoid, moving away",    moving(-4.0, 0.0),  2.0, &SIMPLE, 4.0),
        ("no way",                    moving(3.0, 0.0),   0.0, &SMOOTH, 3.0),
        ("from rest, jerk only",      moving(0.0, 0.0),   2.0, &SMOOTH, 2.0),
        ("from rest, A held",         moving(0.0, 0.0),   6.0, &SMOOTH, 4.0),
        ("from a speed",              moving(3.0, 0.0),   8.0, &SMOOTH, 5.0),
        ("up to the limit",           moving(3.0, 0.0),  1e3,  &SMOOTH, 10.0),
        ("later part of a ramp",      moving(1.0, 2.0),   5.0 / 3.0, &SMOOTH, 2.0),
        ("too short to level off",    moving(1.0, 2.0),   1.0, &SMOOTH, 2.0),
        ("above the limit, room",     moving(12.0, 0.0), 1e3,  &SMOOTH, 10.0),
        ("above the limit, no room",  moving(12.0, 0.0),  1.0, &SMOOTH, 10.0),
        ("slowing, levelled off",     moving(3.0, -4.0), 3.0 - 1.0 - 2.0 / 3.0 + 0.0, &SMOOTH, 1.0),
        ("speed limit 0",             moving(0.0, 0.0),   1.0, &Limits { speed: 0.0, ..SMOOTH }, 0.0),
    ];
    for (why, from, length, limits, speed) in cases {
        let found = exit_speed(from, length, limits);
        assert!(near(found, speed), "{why}: {found}, expected {speed}");
    }
}

/// Largest value in `low..=high` for which `fits`, which turns from true to false once.
fn bisect(mut low: f64, mut high: f64, fits: impl Fn(f64) -> bool) -> f64 {
    if fits(high) {
        return high;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if fits(middle) { low = middle } else { high = middle }
    }
    low
}

fn random_limits(random: &mut Random, case: u64) -> Limits {
    let limits = random.limits(2.0);
    if case.is_multiple_of(4) {
        Limits { jerk: None, ..limits }
    } else {
        limits
    }
}

fn displacement(from: KinematicState, velocity: f64, limits: &Limits) -> f64 {
    Profile::to_velocity(from, velocity, limits).end().position
}

#[test]
fn entry_speeds_against_plans() {
    for case in 0..cases(5_000) {
        let mut random = Random(case ^ 0x1234);
        let limits = random_limits(&mut random, case);
        let length = random.target(&limits).abs();
        let end = match random.bits() % 4 {
            0 => 0.0,
            _ => random.unit() * limits.speed,
        };
        let speed = entry_speed(length, end, &limits);
        let told = format!("case {case}: {speed} over {length} to {end}, {limits:?}");
        let expected = bisect(end, 1e6, |v| displacement(moving(v, 0.0), end, &limits) <= length);
        assert!(
            (speed - expected).abs() <= 1e-9 * expected + 1e-29,
            "{told}, expected {expected}"
        );
        let profile = Profile::to_position(moving(speed, 0.0), length, end, &Limits { speed: 1e7, ..limits });
        assert_eq!(
            profile.end(),
            KinematicState {
                position: length,
                ..moving(end, 0.0)
            },
            "{told}"
        );
        let stop = stop_distance(speed, &limits);
        assert!(
            (stop - displacement(moving(speed, 0.0), 0.0, &limits)).abs() <= 1e-12 * stop,
            "{told}"
        );
        // Not monotone in the end speed: the final part of the deceleration is shorter at a lower speed.
        assert!(entry_speed(1.01 * length, end, &limits) >= speed, "{told}");
    }
}

#[test]
fn exit_speeds_against_plans() {
    let (mut met, mut turned) = (0, 0);
    // The last case returns to its start: its end has fewer digits.
    for case in (0..cases(5_000)).chain([1_451_939]) {
        let mut random = Random(case ^ 0x4321);
        let limits = random_limits(&mut random, case);
        let mut from = random.state(&limits);
        if limits.jerk.is_none() {
            from.acceleration = 0.0;
        }
        let length = random.target(&limits).abs();
        let speed = exit_speed(from, length, &limits);
        let told = format!("case {case}: {speed} over {length} from {from:?}, {limits:?}");
        assert!((0.0..=limits.speed).contains(&speed), "{told}");
        // The speed if the acceleration is brought to 0 at once: below it the distance grows again.
        let a = from.acceleration;
        let level = match limits.jerk {
            Some(j) if from.velocity < 0.0 && a > 0.0 => {
                (0.5 * a * a + from.velocity * j.deceleration) / j.acceleration
            }
            Some(j) if a > 0.0 => from.velocity + 0.5 * a * a / j.acceleration,
            Some(j) => from.velocity - 0.5 * a * a / j.deceleration,
            None => from.velocity,
        };
        let least = level.clamp(0.0, limits.speed);
        let reach = |w: f64| displacement(from, w, &limits);
        if reach(least) > length * (1.0 + 1e-14) {
            assert!(
                (speed - least).abs() <= 1e-9 * least,
                "{told}, expected the least {least}"
            );
            continue;
        }
        let expected = bisect(least, limits.speed, |w| reach(w) <= length);
        let resolved = (reach(speed) - length).abs() <= 1e-13 * length.abs().max(reach(0.0).abs());
        assert!(
            (speed - expected).abs() <= 1e-9 * expected || resolved,
            "{told}, expected {expected}"
        );
        let end = Profile::to_position(from, length, speed, &limits).end();
        let wanted = KinematicState {
            position: length,
            ..moving(speed, 0.0)
        };
        // Out and nearly back again: the difference has only the digits of the excursion.
        let ramp = Profile::to_velocity(from, speed, &limits);
        let farthest = ramp.segments[..ramp.len]
            .iter()
            .fold(0.0, |most: f64, segment| most.max(segment.state.position.abs()));
        let cancelled = ramp.end().position != length && length < 0.01 * farthest;
        assert!(end == wanted || cancelled, "{told}, ends as {end:?}");
        met += 1;
        turned += i32::from(from.velocity < 0.0);
    }
    assert!(met > 1000 && turned > 100, "{met} {turned}");
}

#[test]
fn ramp_times() {
    let far = Profile::to_position(KinematicState::default(), 100.0, 0.0, &SMOOTH);
    assert!(near(far.accelerates_until(), 6.0) && near(far.duration() - far.brakes_from(), 3.5));
    let braking = Profile::stop(moving(3.0, 0.0), &SMOOTH);
    assert_eq!((braking.accelerates_until(), braking.brakes_from()), (0.0, 0.0));
    let up = Profile::to_velocity(KinematicState::default(), 3.0, &SMOOTH);
    assert_eq!(
        (up.accelerates_until(), up.brakes_from()),
        (up.duration(), up.duration())
    );
    let rest = Profile::rest(1.0);
    assert_eq!((rest.accelerates_until(), rest.brakes_from()), (0.0, 0.0));
    for case in 0..cases(5_000) {
        let mut random = Random(case ^ 0x5678);
        let limits = random_limits(&mut random, case);
        let (from, target) = (random.state(&limits), random.target(&limits));
        let profile = Profile::to_position(from, target, 0.0, &limits);
        let (up, down, whole) = (profile.accelerates_until(), profile.brakes_from(), profile.duration());
        assert!(
            0.0 <= up && up <= down && down <= whole,
            "case {case}: {up} {down} {whole}"
        );
        assert!(
            down < whole || whole == 0.0,
            "case {case}: {down} {whole} {from:?} -> {target}, {limits:?}"
        );
        for share in 0..64 {
            let t = whole * (f64::from(share) + random.unit()) / 64.0;
            let phase = profile.phase(t);
            let told = format!("case {case} at {t}: {phase:?}, {up} {down} {whole}\n{from:?} -> {target}, {limits:?}");
            assert!(
                t > up || t >= whole || phase == Phase::Accelerating || t == up,
                "{told}"
            );
            assert!(t < down || t >= whole || phase == Phase::Decelerating, "{told}");
        }
    }
}

#[test]
fn any_number_gives_a_speed() {
    for case in 0..cases(20_000) {
        let mut random = Random(case ^ 0x8765);
        let mut wild = || match random.bits() % 8 {
            0 => 0.0,
            1 => f64::MAX,
            2 => f64::NAN,
            3 => -f64::INFINITY,
            4 => f64::from_bits(random.bits()),
            _ => random.decades(-12.0, 12.0),
        };
        let limits = Limits {
            speed: wild(),
            acceleration: wild(),
            deceleration: wild(),
            jerk: (case % 3 != 0).then_some(Jerk {
                acceleration: wild(),
                deceleration: wild(),
            }),
        };
        let (length, speed, acceleration) = (wild(), wild(), wild());
        for value in [
            stop_distance(speed, &limits),
            entry_speed(length, speed, &limits),
            exit_speed(moving(speed, acceleration), length, &limits),
        ] {
            assert!(
                value >= 0.0 && value.is_finite(),
                "case {case}: {value} {length} {speed} {acceleration} {limits:?}"
            );
        }
    }
}
