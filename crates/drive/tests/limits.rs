//! A servo within limits: against a step-by-step integration of the same laws, and at several update periods.

use std::f64::consts::TAU;

use arcline_drive::Saturation;
use arcline_drive::simulated::{Drive, Settings};
use arcline_profile::KinematicState;

/// `p(t) = c0 + c1 t + c2 t² + c3 t³`: every update period sees the same command.
type Cubic = [f64; 4];

fn command([c0, c1, c2, c3]: Cubic, t: f64) -> KinematicState {
    KinematicState {
        position: c0 + t * (c1 + t * (c2 + t * c3)),
        velocity: c1 + t * (2.0 * c2 + t * 3.0 * c3),
        acceleration: 2.0 * c2 + 6.0 * t * c3,
    }
}

/// Error and velocity at every 4 ms of one second, and everything that limited it.
fn run(settings: &Settings, cubic: Cubic, period: f64) -> (Vec<[f64; 2]>, Vec<Saturation>) {
    let mut drive = Drive::servo(cubic[0], settings);
    let every = (0.004 / period).round() as u32;
    let (mut shown, mut seen) = (Vec::new(), Vec::new());
    for tick in 1..=250 * every {
        drive.cycle(command(cubic, f64::from(tick) * period), period);
        if !seen.contains(&drive.saturation()) {
            seen.push(drive.saturation());
        }
        assert!(drive.actual().velocity.abs() <= settings.speed_limit);
        if tick % every == 0 {
            shown.push([drive.error(), drive.actual().velocity]);
        }
    }
    (shown, seen)
}

/// The laws of the drive in steps of 1 µs: the velocity goes to what the loop asks for as fast as the torque allows.
fn integrated(settings: &Settings, cubic: Cubic) -> Vec<[f64; 2]> {
    const STEP: f64 = 1e-6;
    let (mut position, mut velocity) = (cubic[0], 0.0);
    let mut shown = Vec::new();
    for step in 0..1_000_000_u32 {
        // Half a step ahead for the command: second order in the step.
        let now = command(cubic, (f64::from(step) + 1.0) * STEP);
        let asked = TAU * settings.bandwidth * (now.position - position - 0.5 * STEP * velocity)
            + settings.feedforward * now.velocity;
        let wanted = asked.clamp(-settings.speed_limit, settings.speed_limit);
        let reach = settings.torque_limit * STEP;
        let next = velocity + (wanted - velocity).clamp(-reach, reach);
        position += 0.5 * (velocity + next) * STEP;
        velocity = next;
        if (step + 1) % 4000 == 0 {
            shown.push([now.position - position, velocity]);
        }
    }
    shown
}

fn within(bandwidth: f64, feedforward: f64, speed_limit: f64, torque_limit: f64) -> Settings {
    Settings {
        speed_limit,
        torque_limit,
        ..Settings::unlimited(bandwidth, feedforward)
    }
}

const NONE: f64 = f64::INFINITY;

/// Why, drive, command, what limits it.
#[rustfmt::skip]
fn cases() -> Vec<(&'static str, Settings, Cubic, &'static [Saturation])> {
    use Saturation::{Speed, Torque};
    // There and back: up to 500 u/s at 2000 u/s² and more.
    const SWING: Cubic = [0.0, 0.0, 1200.0, -1200.0];
    vec![
        ("speed alone",             within(40.0, 0.0, 300.0, NONE),   SWING, &[Speed]),
        ("speed, fed forward",      within(40.0, 1.0, 300.0, NONE),   SWING, &[Speed]),
        ("torque alone",            within(40.0, 0.0, NONE, 2000.0),  SWING, &[Torque]),
        ("torque, fed forward",     within(40.0, 0.7, NONE, 1500.0),  SWING, &[Torque]),
        ("torque that swings",      within(40.0, 0.5, NONE, 900.0),   [0.0, 100.0, -60.0, 0.0], &[Torque]),
        ("both",                    within(40.0, 0.5, 350.0, 2100.0), SWING, &[Speed, Torque]),
        ("both, a soft loop",       within(5.0, 0.0, 250.0, 1000.0),  SWING, &[Speed, Torque]),
        ("both, a stiff loop",      within(300.0, 0.9, 380.0, 2300.0), SWING, &[Speed, Torque]),
        ("a start at full speed",   within(40.0, 0.3, 210.0, 3000.0), [7.0, 200.0, 0.0, 0.0], &[Speed, Torque]),
        ("hardly any torque",       within(40.0, 0.0, 100.0, 50.0),   [0.0, 0.0, 300.0, -300.0], &[Torque]),
    ]
}

#[test]
fn a_limited_drive_obeys_its_laws() {
    for (why, settings, cubic, limited_by) in cases() {
        let (shown, seen) = run(&settings, cubic, 0.001);
        for limit in limited_by {
            assert!(seen.contains(limit), "{why}: never {limit:?}");
        }
        for (tick, (found, expected)) in shown.iter().zip(integrated(&settings, cubic)).enumerate() {
            let apart = (found[0] - expected[0]).abs();
            assert!(apart < 2e-3, "{why}: {found:?} {expected:?} at {} ms", 4 * (tick + 1));
        }
    }
}

#[test]
fn a_limited_response_does_not_depend_on_the_update_period() {
    for (why, settings, cubic, _) in cases() {
        let (reference, _) = run(&settings, cubic, 0.00025);
        for period in [0.001, 0.004] {
            let (shown, _) = run(&settings, cubic, period);
            for (tick, (a, b)) in shown.iter().zip(&reference).enumerate() {
                let apart = (a[0] - b[0]).abs();
                assert!(
                    apart < 1e-9,
                    "{why}: {apart:e} apart at {} ms, period {period}",
                    4 * (tick + 1)
                );
            }
        }
    }
}

#[test]
fn a_limit_that_is_not_reached_changes_no_bit() {
    for feedforward in [0.0, 0.4, 1.0] {
        let limited = within(40.0, feedforward, 2000.0, 1e5);
        let (mut free, mut drive) = (
            Drive::servo(0.0, &Settings::unlimited(40.0, feedforward)),
            Drive::servo(0.0, &limited),
        );
        for tick in 1..=1000 {
            let next = command([0.0, 0.0, 1200.0, -1200.0], f64::from(tick) * 0.001);
            free.cycle(next, 0.001);
            drive.cycle(next, 0.001);
            assert_eq!((drive.actual(), drive.error()), (free.actual(), free.error()));
            assert_eq!(drive.error_before(0.0004), free.error_before(0.0004));
        }
    }
}

#[test]
fn a_limited_drive_settles_and_tells_since_when() {
    // A leap of 20 u: more than the torque can do at once, so it swings over and back, and rests.
    let settings = within(40.0, 0.0, 300.0, 4000.0);
    let at = |position| KinematicState {
        position,
        ..KinematicState::default()
    };
    let run = |period: f64| {
        let mut drive = Drive::servo(0.0, &settings);
        let mut entered = None;
        for tick in 1..=(1.0 / period).round() as u32 {
            drive.cycle(at(20.0), period);
            let now = f64::from(tick) * period;
            // The latest instant at which the error came within 0.01.
            if drive.error().abs() > 0.01 {
                entered = None;
            } else if entered.is_none() {
                let mut inside = [0.0, period];
                for _ in 0..60 {
                    let middle = 0.5 * (inside[0] + inside[1]);
                    inside[usize::from(drive.error_before(middle).abs() > 0.01)] = middle;
                }
                entered = Some(now - inside[0]);
            }
        }
        assert_eq!((drive.error(), drive.saturation()), (0.0, Saturation::None));
        entered
    };
    // The command leaps within the first period, so the periods differ in what they command: by that, and no more.
    let reference = run(0.00025).expect("it settles");
    for period in [0.0005, 0.001] {
        let entered = run(period).expect("it settles");
        assert!(
            (entered - reference).abs() < period,
            "{entered} {reference} at {period}"
        );
    }
}

mod any {
    use super::*;
    use proptest::prelude::*;

    /// The cubic through both ends of a period, as the drive takes it, `t` after its beginning.
    fn between([a, b]: [KinematicState; 2], period: f64, t: f64) -> KinematicState {
        let slope = (b.position - a.position) / period;
        let c2 = (3.0 * slope - 2.0 * a.velocity - b.velocity) / period;
        let c3 = (a.velocity + b.velocity - 2.0 * slope) / (period * period);
        command([a.position, a.velocity, c2, c3], t)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: ProptestConfig::default().cases * 8, ..ProptestConfig::default() })]

        /// One long period or up to a hundred short ones of any length: the same axis.
        #[test]
        fn period_and_drive_and_command(
            [bandwidth, feedforward] in [1.0..500.0, 0.0..1.0],
            [speed, torque] in [1.0..1000.0, 10.0..1e5],
            period in 0.00025..0.032,
            positions in [-1.0..1.0, -1.0..1.0],
            velocities in [-500.0..500.0, -500.0..500.0],
            leap in prop::sample::select(vec![0.0, 0.01, 1.0, 100.0]),
            cuts in prop::collection::vec(0.001..1.0, 1..100),
        ) {
            let settings = within(bandwidth, feedforward, speed, torque);
            let at = |index: usize| KinematicState {
                position: leap * positions[index] + velocities[0] * period * index as f64,
                velocity: velocities[index],
                acceleration: 0.0,
            };
            let mut whole = Drive::servo(0.0, &settings);
            whole.cycle(at(0), period);
            let before = whole.actual().velocity;
            let mut parts = whole;
            whole.cycle(at(1), period);
            let total: f64 = cuts.iter().sum();
            let (mut done, mut now) = (0.0, 0.0);
            for (index, cut) in cuts.iter().enumerate() {
                done += cut / total;
                let next = if index + 1 == cuts.len() { period } else { (period * done).min(period) };
                if next > now {
                    parts.cycle(between([at(0), at(1)], period, next), next - now);
                }
                now = next;
            }
            // A leap within a period is a steep cubic: what of it a soft loop lets through is a small difference.
            let gain = TAU * bandwidth;
            let scale = 1.0 + 1e-3 * leap / (gain * period).powi(3);
            prop_assert!((whole.error() - parts.error()).abs() < 1e-9 * scale, "{whole:?} {parts:?}");
            let gone = (whole.actual().velocity - before).abs();
            prop_assert!(gone <= torque * period * (1.0 + 1e-6), "{gone} {}", torque * period);
            prop_assert!(whole.actual().velocity.abs() <= speed);
        }
    }
}
