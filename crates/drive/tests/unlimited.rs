//! A drive without limits computes what it always has, to the last bit: traces and clients rely on it.

use arcline_drive::simulated::{Drive, Settings};
use arcline_profile::KinematicState;

/// A command that speeds up, cruises, brakes, stands, and leaps once.
fn command(tick: u32, period: f64) -> KinematicState {
    let t = f64::from(tick) * period;
    let (position, velocity, acceleration) = match t {
        t if t < 0.25 => (1000.0 * t * t, 2000.0 * t, 2000.0),
        t if t < 0.5 => (62.5 + 500.0 * (t - 0.25), 500.0, 0.0),
        t if t < 0.75 => {
            let left = 0.75 - t;
            (250.0 - 1000.0 * left * left, 2000.0 * left, -2000.0)
        }
        t if t < 1.0 => (250.0, 0.0, 0.0),
        _ => (251.0, 0.0, 0.0),
    };
    KinematicState {
        position,
        velocity,
        acceleration,
    }
}

/// FNV-1a over the bits of everything a drive shows.
fn fingerprint(bandwidth: f64, feedforward: f64, period: f64) -> u64 {
    let mut drive = Drive::servo(0.0, &Settings::unlimited(bandwidth, feedforward));
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for tick in 1..=(1.5 / period).round() as u32 {
        drive.cycle(command(tick, period), period);
        let KinematicState {
            position,
            velocity,
            acceleration,
        } = drive.actual();
        let shown = [
            position,
            velocity,
            acceleration,
            drive.error(),
            drive.error_before(0.3 * period),
        ];
        for byte in shown.iter().flat_map(|value| value.to_bits().to_le_bytes()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

#[test]
fn the_bits_are_those_of_the_first_release() {
    #[rustfmt::skip]
    let cases = [
        // bandwidth, feed-forward, period, fingerprint
        (40.0, 0.0, 0.001, 0xbc42_2692_9e4d_1a49_u64),
        (40.0, 0.5, 0.00025, 0xe271_b0b9_d5a4_c9b6),
        (25.0, 0.4, 0.004, 0x4692_d099_e008_25d3),
        (40.0, 1.0, 0.001, 0x389b_c329_ed6b_7239),
    ];
    for (bandwidth, feedforward, period, expected) in cases {
        let found = fingerprint(bandwidth, feedforward, period);
        assert_eq!(
            found, expected,
            "{bandwidth} Hz, {feedforward}, {period} s: {found:#018x}"
        );
    }
}
