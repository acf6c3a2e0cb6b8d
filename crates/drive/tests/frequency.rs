//! The frequency response of a servo, measured from outside, is the configured one.

use std::f64::consts::{SQRT_2, TAU};

use arcline_drive::simulated::{Drive, Settings};
use arcline_profile::KinematicState;

/// Gain and phase, in radians, of the actual position over a sine of the command at a whole number of hertz.
fn response(drive: Drive, hertz: u32, period: f64) -> (f64, f64) {
    let mut drive = drive;
    let omega = TAU * f64::from(hertz);
    let second = (1.0 / period).round() as u32;
    let (mut sine, mut cosine) = (0.0, 0.0);
    for tick in 1..=2 * second {
        let (s, c) = libm::sincos(omega * f64::from(tick) * period);
        let command = KinematicState {
            position: s,
            velocity: omega * c,
            acceleration: -omega * omega * s,
        };
        drive.cycle(command, period);
        // In the first second the start dies away; the other one is a whole number of waves.
        if tick > second {
            sine += drive.actual().position * s;
            cosine += drive.actual().position * c;
        }
    }
    let scale = 2.0 / f64::from(second);
    ((sine * scale).hypot(cosine * scale), libm::atan2(cosine, sine))
}

/// `(K + f s) / (K + s)` at `s = i ω`.
fn configured(bandwidth: f64, feedforward: f64, hertz: u32) -> (f64, f64) {
    let ratio = f64::from(hertz) / bandwidth;
    let led = feedforward * ratio;
    let gain = 1.0_f64.hypot(led) / 1.0_f64.hypot(ratio);
    (gain, libm::atan(led) - libm::atan(ratio))
}

const HERTZ: [u32; 9] = [1, 2, 5, 10, 20, 40, 80, 120, 200];

#[test]
fn gain_and_phase_are_the_configured_ones() {
    for bandwidth in [10.0, 40.0, 100.0] {
        for feedforward in [0.0, 0.5, 0.9, 1.0] {
            for hertz in HERTZ {
                let drive = Drive::servo(0.0, &Settings::unlimited(bandwidth, feedforward));
                let (gain, phase) = response(drive, hertz, 0.00025);
                let (expected_gain, expected_phase) = configured(bandwidth, feedforward, hertz);
                let why = format!("{bandwidth} Hz, {feedforward} fed forward, at {hertz} Hz: {gain} {phase}");
                // 3 % is what is promised; 0.1 % is what it is.
                assert!((gain / expected_gain - 1.0).abs() < 1e-3, "{why} {expected_gain}");
                assert!((phase - expected_phase).abs() < 1e-3, "{why} {expected_phase}");
            }
        }
    }
}

#[test]
fn half_the_power_is_left_at_the_bandwidth() {
    for bandwidth in [10.0, 40.0, 63.5] {
        let drive = Drive::servo(0.0, &Settings::unlimited(bandwidth, 0.0));
        let gains = (1..=200).map(|hertz| (f64::from(hertz), response(drive, hertz, 0.00025).0));
        let mut above = (0.0, 1.0);
        let mut at = None;
        for (hertz, gain) in gains {
            if gain < 1.0 / SQRT_2 {
                let (before, gain_before) = above;
                at = Some(before + (gain_before - 1.0 / SQRT_2) / (gain_before - gain) * (hertz - before));
                break;
            }
            above = (hertz, gain);
        }
        let at = at.expect("it falls below");
        assert!(
            (at / bandwidth - 1.0).abs() < 0.03,
            "-3 dB at {at} Hz of {bandwidth} Hz"
        );
    }
}

/// Between updates the command is a cubic, which differs from the sine by `(ω · period)⁴ / 384`: 0.6 % at the worst here.
#[test]
fn the_response_does_not_depend_on_the_update_period() {
    for feedforward in [0.0, 0.5] {
        let drive = Drive::servo(0.0, &Settings::unlimited(40.0, feedforward));
        for hertz in HERTZ {
            let (gain, phase) = response(drive, hertz, 0.00025);
            for period in [0.0005, 0.001] {
                let (other, shift) = response(drive, hertz, period);
                let sampled = (TAU * f64::from(hertz) * period).powi(4) / 384.0 + 1e-5;
                let apart = (other / gain - 1.0).abs().max((shift - phase).abs());
                assert!(apart < 2.0 * sampled, "{hertz} Hz at {period} s: {apart} of {sampled}");
            }
        }
    }
}

/// Limits that are never reached leave the response as it is; one that is reached takes from the gain.
#[test]
fn limits_take_from_the_gain_only_where_they_are_reached() {
    let limited = |speed_limit| {
        let settings = Settings {
            speed_limit,
            torque_limit: 1e6,
            ..Settings::unlimited(40.0, 0.0)
        };
        Drive::servo(0.0, &settings)
    };
    let (free, _) = configured(40.0, 0.0, 20);
    let (wide, _) = response(limited(1000.0), 20, 0.001);
    let (tight, _) = response(limited(50.0), 20, 0.001);
    assert!((wide / free - 1.0).abs() < 1e-3, "{wide} {free}");
    assert!(tight < 0.6 * free, "{tight} {free}");
}
