//! Random moves: limits hold, ends are exact, times are those of closed forms written here, and the trajectory
//! is the same at every update period.
#![allow(missing_docs)]

use arcline_planner::geometry::{Arc, CirclePoint, Dimension, Direction, Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, Ending, Instant, Move, MoveEvent, Parameter, Planner, Sample};
use proptest::prelude::*;

/// Shared instants are compared at multiples of the longest period.
const PERIODS_NS: [u64; 3] = [250_000, 1_000_000, 4_000_000];
/// Longest move that is sampled tick by tick, seconds.
const LONGEST: f64 = 20.0;

fn clock(tick: u64, period_ns: u64) -> Clock {
    Clock::at(tick, period_ns)
}

fn start(path: Path, limits: Limits, period_ns: u64) -> Planner<()> {
    let mut planner = Planner::new(1, Point::zeros());
    let at = clock(0, period_ns);
    planner.start(stopping(path, limits), at.now(), &at);
    planner
}

fn stopping(path: Path, limits: Limits) -> Move<()> {
    let ending = Ending::Stop;
    Move {
        path,
        rotation: None,
        corner: f64::INFINITY,
        limits,
        last_speed: limits.speed,
        ending,
        parameter: Parameter::TIME,
        data: (),
    }
}

/// The instant at which the active move came to its end, if it has.
fn reached(planner: &Planner<()>, clock: &Clock) -> Option<Instant> {
    match planner.event(clock)? {
        MoveEvent::Reached(at) => Some(at),
        MoveEvent::HandOver(_) => panic!("a stop hands nothing over"),
    }
}

fn sample(planner: &Planner<()>, tick: u64, period_ns: u64) -> Sample {
    planner.sample(&clock(tick, period_ns)).expect("a move is active")
}

/// Time and distance of a ramp between rest and `v`: at most `a`, jerk `j` (`None`: no limit).
fn ramp(v: f64, a: f64, j: Option<f64>) -> (f64, f64) {
    let time = match j {
        None => v / a,
        Some(j) if v >= a * a / j => v / a + a / j,
        Some(j) => 2.0 * (v / j).sqrt(),
    };
    (time, v * time / 2.0)
}

/// Least time from rest to rest over a length, by bisection of the peak speed.
fn rest_to_rest(length: f64, limits: &Limits) -> f64 {
    let (ja, jd) = (
        limits.jerk.map(|jerk| jerk.acceleration),
        limits.jerk.map(|jerk| jerk.deceleration),
    );
    let ramps = |v: f64| (ramp(v, limits.acceleration, ja), ramp(v, limits.deceleration, jd));
    let (up, down) = ramps(limits.speed);
    if up.1 + down.1 <= length {
        return up.0 + down.0 + (length - up.1 - down.1) / limits.speed;
    }
    let (mut low, mut high) = (0.0, limits.speed);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        let (up, down) = ramps(middle);
        if up.1 + down.1 <= length {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (up, down) = ramps(low);
    up.0 + down.0
}

prop_compose! {
    fn limits()(
        speed in 10.0..600.0_f64,
        acceleration in 200.0..8000.0_f64,
        deceleration in 200.0..8000.0_f64,
        jerks in prop::option::of((2e3..5e5_f64, 2e3..5e5_f64)),
    ) -> Limits {
        let jerk = jerks.map(|(acceleration, deceleration)| Jerk { acceleration, deceleration });
        Limits { speed, acceleration, deceleration, jerk }
    }
}

fn point() -> impl Strategy<Value = Point> {
    [-300.0..300.0_f64, -300.0..300.0, -300.0..300.0].prop_map(|[x, y, z]| Point::new(x, y, z))
}

fn line() -> impl Strategy<Value = Path> {
    (point(), point()).prop_map(|(from, to)| Path::line(from, to))
}

fn arc() -> impl Strategy<Value = Path> {
    let circle =
        (point(), point(), point(), 0..4).prop_filter_map("three points on a line", |(from, via, to, word)| {
            let direction = Direction::from_word(word)?;
            Arc::new(Dimension::Three, from, to, CirclePoint::Via(via), direction).ok()
        });
    circle
        .prop_filter("too large a circle", |arc| arc.radius() < 2000.0)
        .prop_map(Path::Arc)
}

fn path() -> impl Strategy<Value = Path> {
    prop_oneof![line(), arc()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases * 3 / 2))]

    #[test]
    fn the_time_is_the_closed_form_and_the_end_is_exact(path in path(), limits in limits()) {
        let expected = rest_to_rest(path.length(), &limits);
        for period_ns in PERIODS_NS {
            let planner = start(path, limits, period_ns);
            let over = clock((expected * 1e9) as u64 / period_ns + 2, period_ns);
            let end = reached(&planner, &over).expect("the move is over");
            let took = over.seconds() - end.elapsed(&over);
            prop_assert!((took - expected).abs() < 1e-9, "took {took}, expected {expected}");
            let early = clock(((expected - 2e-9) * 1e9) as u64 / period_ns, period_ns);
            prop_assert!(reached(&planner, &early).is_none());
            prop_assert_eq!(sample(&planner, over.tick, period_ns).position, path.end());
            prop_assert_eq!(sample(&planner, over.tick, period_ns).velocity, Point::zeros());
            prop_assert_eq!(sample(&planner, 0, period_ns).position, path.start());
        }
    }

    #[test]
    fn the_limits_hold(path in path(), limits in limits()) {
        let planner = start(path, limits, 1_000_000);
        let mut last: Option<Sample> = None;
        let jerk = limits.jerk.map_or(f64::INFINITY, |jerk| jerk.acceleration.max(jerk.deceleration));
        for tick in 0..=(rest_to_rest(path.length(), &limits).min(LONGEST) * 1e3) as u64 + 1 {
            let now = sample(&planner, tick, 1_000_000);
            let (v, a) = (now.along.velocity, now.along.acceleration);
            prop_assert!((-1e-9..=limits.speed * (1.0 + 1e-9)).contains(&v), "speed {v}");
            let bounds = -limits.deceleration * (1.0 + 1e-9)..=limits.acceleration * (1.0 + 1e-9);
            prop_assert!(bounds.contains(&a), "acceleration {a}");
            prop_assert!((now.velocity.norm() - v.abs()).abs() < 1e-9 * limits.speed);
            if let Some(last) = last {
                let rise = (a - last.along.acceleration).abs() / 0.001;
                prop_assert!(rise <= jerk * (1.0 + 1e-6), "jerk {rise}");
                prop_assert!(now.along.position >= last.along.position - 1e-12 * path.length(), "it goes back");
                let gone = (now.position - last.position).norm();
                prop_assert!(gone <= limits.speed * 0.001 * (1.0 + 1e-6), "moved {gone} in a tick");
            }
            last = Some(now);
        }
    }

    #[test]
    fn every_update_period_samples_one_trajectory(path in path(), limits in limits()) {
        let planners = PERIODS_NS.map(|period_ns| (period_ns, start(path, limits, period_ns)));
        let longest = PERIODS_NS[PERIODS_NS.len() - 1];
        for shared in 0..=(rest_to_rest(path.length(), &limits).min(LONGEST) * 1e9) as u64 / longest + 1 {
            let [first, others @ ..] = &planners;
            let reference = sample(&first.1, shared * longest / first.0, first.0);
            for (period_ns, planner) in others {
                let now = sample(planner, shared * longest / period_ns, *period_ns);
                prop_assert!((now.position - reference.position).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn a_successor_starts_at_the_instant_its_predecessor_ends(path in path(), limits in limits()) {
        let duration = rest_to_rest(path.length(), &limits);
        prop_assume!(duration < LONGEST);
        let ends = PERIODS_NS.map(|period_ns| {
            let mut planner = start(path, limits, period_ns);
            let back = Path::line(path.end(), path.start());
            planner.enqueue(stopping(back, limits), &clock(0, period_ns)).expect("one place is free");
            let over = clock((duration * 1e9) as u64 / period_ns + 1, period_ns);
            let end = reached(&planner, &over).expect("the move is over");
            planner.hand_over(end, &over);
            let later = clock(over.tick + 40_000_000_000 / period_ns, period_ns);
            reached(&planner, &later).map(|end| later.seconds() - end.elapsed(&later))
        });
        let expected = duration + rest_to_rest((path.end() - path.start()).norm(), &limits);
        for end in ends {
            prop_assert!((end.expect("it has ended") - expected).abs() < 1e-9);
        }
    }
}

/// An orientation of fixed angles.
fn oriented(x: f64, y: f64, z: f64) -> arcline_planner::geometry::Rotation {
    use arcline_planner::geometry::{Rotation, rotation};
    Rotation::new(&rotation(&Point::zeros()), &rotation(&Point::new(x, y, z)), 0.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.div_ceil(4)))]

    /// Position and orientation begin and end together, at every update period alike.
    #[test]
    fn a_turn_goes_along(
        length in prop::option::of(1.0..500.0f64), x in -170.0..170.0f64, y in -80.0..80.0f64, z in -170.0..170.0f64,
    ) {
        let rotation = oriented(x, y, z);
        let path = match length {
            Some(length) => Path::line(Point::zeros(), Point::new(length, 0.0, 0.0)),
            None => Path::stationary(Point::zeros(), rotation.angle()),
        };
        let limits = Limits { speed: 200.0, acceleration: 3000.0, deceleration: 2000.0, jerk: None };
        let motion = Move { rotation: Some(rotation), ..stopping(path, limits) };
        let duration = rest_to_rest(path.length(), &limits);
        let mut rows = Vec::new();
        for period_ns in [250_000, 1_000_000, 4_000_000] {
            let mut planner = Planner::new(1, Point::zeros());
            let at = clock(0, period_ns);
            planner.start(motion, at.now(), &at);
            let ticks = (0..=2 + (duration * 1e9) as u64 / 4_000_000).map(|n| n * 4_000_000 / period_ns);
            rows.push(ticks.map(|tick| sample(&planner, tick, period_ns)).collect::<Vec<_>>());
        }
        let last = rows[0].last().expect("a row").rotation_state.expect("it turns");
        prop_assert_eq!(&last.orientation, rotation.end());
        prop_assert_eq!(last.rate.norm(), 0.0);
        for (place, sample) in rows[0].iter().enumerate() {
            let rotation_state = sample.rotation_state.expect("it turns");
            let share = sample.along.velocity / path.length() * rotation.angle();
            prop_assert!((rotation_state.rate.norm().to_degrees() - share).abs() < 1e-9 * (1.0 + share), "not evenly");
            for other in &rows[1..] {
                let there = other[place].rotation_state.expect("it turns");
                prop_assert!((there.orientation - rotation_state.orientation).abs().max() < 1e-9);
            }
        }
    }
}

#[test]
fn turns_blend_and_rest_at_corners() {
    let limits = Limits {
        speed: 90.0,
        acceleration: 900.0,
        deceleration: 900.0,
        jerk: None,
    };
    let (first, second) = (oriented(0.0, 0.0, 90.0), {
        use arcline_planner::geometry::{Rotation, rotation};
        Rotation::new(
            &rotation(&Point::new(0.0, 0.0, 90.0)),
            &rotation(&Point::new(60.0, 0.0, 90.0)),
            0.0,
        )
    });
    let directions = [
        Path::stationary(Point::zeros(), 90.0),
        Path::stationary(Point::zeros(), 60.0),
    ];
    let duration = |ending| {
        let mut planner = Planner::new(1, Point::zeros());
        let period = 1_000_000;
        let at = clock(0, period);
        planner.start(
            Move {
                rotation: Some(first),
                ending,
                ..stopping(directions[0], limits)
            },
            at.now(),
            &at,
        );
        let next = Move {
            rotation: Some(second),
            ..stopping(directions[1], limits)
        };
        planner.enqueue(next, &at).expect("there is room");
        let mut before: Option<Sample> = None;
        for tick in 0..5000 {
            let at = clock(tick, period);
            while let Some(MoveEvent::HandOver(instant)) = planner.event(&at) {
                planner.hand_over(instant, &at);
            }
            if let Some(MoveEvent::Reached(instant)) = planner.event(&at) {
                if planner.next().is_none() {
                    let end = sample(&planner, tick, period).rotation_state.expect("it turns");
                    assert!((end.orientation - second.end()).abs().max() < 1e-12);
                    return instant.elapsed(&clock(0, period)).abs();
                }
                planner.hand_over(instant, &at);
            }
            let now = sample(&planner, tick, period);
            if let (Some(was), Some(is)) = (before.and_then(|sample| sample.rotation_state), now.rotation_state) {
                let most = (2.0 * limits.speed * 1e-3).to_radians();
                assert!(
                    (is.orientation - was.orientation).abs().max() <= most,
                    "a step at {tick}"
                );
                let most = (2.1 * limits.acceleration * 1e-3).to_radians();
                assert!((is.rate - was.rate).norm() <= most, "a step of the rate at {tick}");
            }
            before = Some(now);
        }
        panic!("no end");
    };
    let ramp = 0.1;
    let apart = 90.0 / 90.0 + 60.0 / 90.0 + 2.0 * ramp;
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-9, "{found} s are not {wanted} s");
    near(duration(Ending::Stop), apart);
    near(duration(Ending::Contour { constrained: false }), apart);
    // The second ramps up while the first one ramps down.
    near(duration(Ending::Blend { tolerance: f64::MAX }), apart - ramp);
}
