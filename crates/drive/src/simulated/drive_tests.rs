//! Drives without limits: following, settling, coasting.

use std::f64::consts::TAU;

use super::*;

const PERIOD: f64 = 0.001;

/// A command at constant speed from rest at 0.
fn at_speed(k: u32, period: f64, speed: f64) -> KinematicState {
    KinematicState {
        position: speed * f64::from(k) * period,
        velocity: speed,
        acceleration: 0.0,
    }
}

#[test]
fn a_loop_without_feedforward_follows_at_speed_over_gain() {
    for period in [0.00025, PERIOD, 0.004] {
        let mut drive = Drive::servo(0.0, &Settings::unlimited(40.0, 0.0));
        for k in 1..=(1.0 / period) as u32 {
            drive.cycle(at_speed(k, period, 500.0), period);
        }
        let expected = 500.0 / (TAU * 40.0);
        assert!(
            (drive.error() - expected).abs() < 1e-9 * expected,
            "{} at {period} s",
            drive.error()
        );
        assert!((drive.actual().velocity - 500.0).abs() < 1e-6);
    }
}

#[test]
fn the_response_does_not_depend_on_the_update_period() {
    let run = |period: f64| {
        let mut drive = Drive::servo(0.0, &Settings::unlimited(25.0, 0.4));
        // x(t) = t² (3 - 2 t): a cubic, so the command is the same for every period.
        for k in 1..=(1.0 / period).round() as u32 {
            let t = f64::from(k) * period;
            let command = KinematicState {
                position: t * t * (3.0 - 2.0 * t),
                velocity: 6.0 * t * (1.0 - t),
                acceleration: 6.0 - 12.0 * t,
            };
            drive.cycle(command, period);
        }
        drive.error()
    };
    let reference = run(0.000_25);
    for period in [0.001, 0.004, 0.025] {
        assert!(
            (run(period) - reference).abs() < 1e-12,
            "{period}: {} {reference}",
            run(period)
        );
    }
}

#[test]
fn full_feedforward_and_ideal_drives_have_no_error() {
    for mut drive in [Drive::servo(0.0, &Settings::unlimited(40.0, 1.0)), Drive::ideal(0.0)] {
        for k in 1..100 {
            let command = at_speed(k, PERIOD, 300.0);
            drive.cycle(command, PERIOD);
            assert_eq!((drive.error(), drive.actual()), (0.0, command));
        }
    }
}

#[test]
fn an_error_decays_with_the_gain_and_can_be_asked_for_backwards() {
    let mut drive = Drive::servo(0.0, &Settings::unlimited(40.0, 0.0));
    drive.cycle(at_speed(1, PERIOD, 100.0), PERIOD);
    let at = KinematicState {
        velocity: 0.0,
        ..at_speed(1, PERIOD, 100.0)
    };
    drive.cycle(at, PERIOD);
    let before = drive.error();
    drive.cycle(at, PERIOD);
    assert!((drive.error() - before * libm::exp(-TAU * 40.0 * PERIOD)).abs() < 1e-15);
    assert!((drive.error_before(PERIOD) - before).abs() < 1e-12);
}

#[test]
fn a_coasting_axis_comes_to_rest_and_takes_the_command_along() {
    let mut drive = Drive::servo(0.0, &Settings::unlimited(40.0, 0.0));
    for k in 1..200 {
        drive.cycle(at_speed(k, PERIOD, 100.0), PERIOD);
    }
    let from = drive.actual();
    for _ in 0..4000 {
        assert_eq!(drive.coast(PERIOD), drive.actual());
    }
    let now = drive.actual();
    assert_eq!((now.velocity, drive.error()), (0.0, 0.0));
    assert!((now.position - from.position - 100.0 * COAST_TIME_CONSTANT).abs() < 0.1);
    drive.halt();
    assert_eq!(drive.actual().position, now.position);
}

#[test]
fn an_encoder_shows_whole_counts_and_the_loop_acts_between_them() {
    let settings = Settings {
        encoder_resolution: Some(8.0),
        ..Settings::unlimited(40.0, 0.0)
    };
    let (mut seen, mut true_) = (
        Drive::servo(0.0, &settings),
        Drive::servo(0.0, &Settings::unlimited(40.0, 0.0)),
    );
    for k in 1..300 {
        let command = at_speed(k, PERIOD, 10.0);
        seen.cycle(command, PERIOD);
        true_.cycle(command, PERIOD);
        let position = seen.actual().position;
        assert_eq!((position * 8.0).fract(), 0.0);
        assert!((position - true_.actual().position).abs() <= 0.5 / 8.0);
        assert_eq!(seen.error(), command.position - position);
        assert_eq!(seen.actual().velocity, true_.actual().velocity);
    }
    // Disabled and enabled again: no jump, and no error remains.
    seen.halt();
    let at = seen.actual();
    assert_eq!((at.velocity, seen.error()), (0.0, 0.0));
    seen.cycle(at, PERIOD);
    assert_eq!((seen.actual(), seen.error()), (at, 0.0));
}

#[test]
fn a_command_that_comes_to_rest_within_a_period_is_followed_as_it_is() {
    // Down from 100 u/s at 10,000 u/s²: at rest after 10 ms, within a period of 4 ms or not.
    let command = |t: f64| {
        let left = (0.01 - t).max(0.0);
        KinematicState {
            position: 0.5 - 5000.0 * left * left,
            velocity: 10_000.0 * left,
            acceleration: 0.0,
        }
    };
    let run = |period: f64| {
        let mut drive = Drive::servo(0.0, &Settings::unlimited(40.0, 0.3));
        drive.set_state(command(0.0));
        for k in 1..=(0.02 / period).round() as u32 {
            let now = f64::from(k) * period;
            drive.rest_for(now - 0.01);
            drive.cycle(command(now), period);
        }
        [drive.error(), drive.actual().velocity]
    };
    let [error, velocity] = run(0.0005);
    for period in [0.001, 0.004] {
        let other = run(period);
        assert!(
            (other[0] - error).abs() < 1e-14 && (other[1] - velocity).abs() < 1e-12,
            "{period}"
        );
    }
}
