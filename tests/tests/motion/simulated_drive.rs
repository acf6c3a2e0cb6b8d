//! A simulated servo in the whole machine: its following error, limits and encoder, and their effect on settling.

use std::f64::consts::TAU;

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::cip_axis_status;
use arcline_tests::bench::{Bench, OK};

/// The default machine with this drive behind every axis, at an update period in ms. However far it lags, it does not
/// fault.
fn machine(drive: &str, period_ms: f64) -> Bench {
    let dynamics = "max_deceleration_jerk = 200000.0";
    let period = format!("coarse_update_period_ms = {period_ms}");
    let config = arcline_config::DEFAULT
        .replace(
            dynamics,
            &format!("{dynamics}\ndrive = {{ {drive}, position_error_tolerance = 0.0 }}"),
        )
        .replace("type = \"virtual\"", "type = \"servo\"")
        .replace("coarse_update_period_ms = 1.0", &period);
    Bench::with(&config)
}

/// 400 mm at 500 mm/s, S-curve: 0.2 s up, 0.6 s of cruise, 0.2 s down.
const S_CURVE: &str = "MCLM(CS1, M1, 0, [400, 0, 0], 500, 0, 5000, 0, 5000, 0, 1, 100, 100, 2, 1)";

/// Command velocity of X every 0.25 ms during [`S_CURVE`] and half a second more, independent of the drive.
fn velocities() -> Vec<f64> {
    let mut bench = machine("velocity_feedforward = 1.0", 0.25);
    bench.execute(S_CURVE);
    let sample = |_| {
        let velocity = bench.axis("X").command[1];
        bench.tick();
        velocity
    };
    (0..6000).map(sample).collect()
}

/// The response `(1 - f) / (K + s)` of the following error to a velocity: the convolution with its impulse response
/// `(1 - f) exp(-K t)`, by Simpson's rule over two samples at a time. One value every 0.5 ms.
fn predicted(velocities: &[f64], gain: f64, feedforward: f64) -> Vec<f64> {
    const STEP: f64 = 0.00025;
    let left = |steps: f64| (-gain * STEP * steps).exp();
    let mut error = 0.0;
    let mut errors = vec![0.0];
    for place in (2..velocities.len()).step_by(2) {
        let [a, b, c] = [velocities[place - 2], velocities[place - 1], velocities[place]];
        error = error * left(2.0) + (1.0 - feedforward) * STEP / 3.0 * (a * left(2.0) + 4.0 * b * left(1.0) + c);
        errors.push(error);
    }
    errors
}

#[test]
fn the_following_error_is_the_one_the_transfer_function_predicts() {
    let velocities = velocities();
    let gain = TAU * 40.0;
    for feedforward in [0.0, 0.5] {
        let expected = predicted(&velocities, gain, feedforward);
        let steady = (1.0 - feedforward) * 500.0 / gain;
        for (period_ms, stride) in [(0.5, 1), (1.0, 2), (4.0, 8)] {
            let drive = format!("position_bandwidth_hz = 40.0, velocity_feedforward = {feedforward}");
            let mut bench = machine(&drive, period_ms);
            bench.execute(S_CURVE);
            let mut worst: f64 = 0.0;
            for expected in expected.iter().step_by(stride) {
                let axis = bench.axis("X");
                assert!((axis.position_error - (axis.command[0] - axis.actual[0])).abs() < 1e-12);
                // Within 1 % of the error itself; below a thousandth of the steady error, within 1 % of that thousandth.
                let apart = (axis.position_error - expected).abs() / expected.abs().max(steady / 1000.0);
                worst = worst.max(apart);
                assert!(
                    apart < 0.01,
                    "{} mm, not {expected}, at tick {} of {period_ms} ms",
                    axis.position_error,
                    bench.now()
                );
                if (0.3..0.7).contains(&(bench.now() as f64 * period_ms / 1000.0)) {
                    assert!((axis.position_error / steady - 1.0).abs() < 1e-6, "steady at {steady}");
                }
                bench.tick();
            }
            println!(
                "feed-forward {feedforward}, {period_ms} ms: {:.4} % apart at most",
                100.0 * worst
            );
        }
    }
}

/// The time at which a move that waits for the axis hands over to its successor, seconds, by the successor's speed.
fn handed_over(drive: &str, profile: u8, period_ms: f64) -> f64 {
    let mut bench = machine(drive, period_ms);
    let first = format!("MCLM(CS1, M1, 0, [31.7, 0, 0], 200, 0, 4000, 0, 1500, 0, {profile}, 100, 100, 2, 0)");
    assert_eq!(bench.call(&first), OK);
    bench.execute("MCLM(CS1, M2, 0, [31.7, 100, 0], 200, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 1)");
    bench.until("M1", Flag::Pc);
    while bench.axis("Y").command[1] < 100.0 {
        bench.tick();
    }
    bench.now() as f64 * period_ms / 1000.0 - bench.axis("Y").command[1] / 2000.0
}

#[test]
fn an_axis_settles_at_the_same_instant_at_every_update_period() {
    #[rustfmt::skip]
    let cases = [
        // why,                        profile, drive
        ("a plain loop",                     0, "position_bandwidth_hz = 40.0, velocity_feedforward = 0.0"),
        ("some feed-forward",                0, "position_bandwidth_hz = 40.0, velocity_feedforward = 0.5"),
        ("full feed-forward",                0, "position_bandwidth_hz = 40.0, velocity_feedforward = 1.0"),
        ("a soft loop",                      0, "position_bandwidth_hz = 5.0, velocity_feedforward = 0.2"),
        ("a soft loop, S-curve",             1, "position_bandwidth_hz = 5.0, velocity_feedforward = 0.2"),
        ("a tight speed limit",              0, "velocity_feedforward = 0.0, speed_limit = 150.0"),
        ("a tight torque limit",             0, "position_bandwidth_hz = 20.0, velocity_feedforward = 0.0, torque_limit = 3500.0"),
        ("a torque that lets it swing",      0, "velocity_feedforward = 0.0, torque_limit = 2500.0"),
        ("hardly any torque",                0, "velocity_feedforward = 0.0, torque_limit = 1400.0"),
        ("both limits, fed forward",         0, "velocity_feedforward = 1.0, torque_limit = 2500.0, speed_limit = 190.0"),
        ("an encoder",                       0, "velocity_feedforward = 0.0, encoder_resolution = 250.0"),
        ("an encoder and limits",            1, "velocity_feedforward = 0.0, speed_limit = 150.0, encoder_resolution = 1000.0"),
    ];
    for (why, profile, drive) in cases {
        let fine = handed_over(drive, profile, 0.25);
        for period_ms in [1.0, 4.0] {
            let apart = (handed_over(drive, profile, period_ms) - fine).abs();
            assert!(apart < 1e-7, "{why}: {apart:e} s apart at {period_ms} ms");
        }
    }
}

#[test]
fn limits_hold_the_axis_back_and_show() {
    let mut bench = machine(
        "velocity_feedforward = 0.0, speed_limit = 150.0, torque_limit = 3000.0",
        1.0,
    );
    bench.execute("MCLM(CS1, M1, 0, [100, 0, 0], 200, 0, 5000, 0, 5000, 0, 0, 100, 100, 2, 0)");
    let (mut shown, mut velocity) = (0, 0.0);
    while !bench.control("M1").has(Flag::Pc) {
        bench.tick();
        let axis = bench.axis("X");
        shown |= axis.cip_status;
        assert!(axis.actual[1].abs() <= 150.0);
        assert!((axis.actual[1] - velocity).abs() <= 3.0 + 1e-6, "in a millisecond");
        velocity = axis.actual[1];
    }
    assert_ne!(shown & cip_axis_status::VELOCITY_LIMIT_STATUS, 0);
    assert_ne!(shown & cip_axis_status::TORQUE_LIMIT_STATUS, 0);
    bench.run(500);
    let limits = cip_axis_status::VELOCITY_LIMIT_STATUS | cip_axis_status::TORQUE_LIMIT_STATUS;
    assert_eq!(bench.axis("X").cip_status & limits, 0, "none at rest");
    assert!((100.0 - bench.axis("X").actual[0]).abs() <= 0.01);
    assert!(bench.now() > 667, "100 mm at 150 mm/s");
}

#[test]
fn an_encoder_decides_whether_an_axis_is_within_its_tolerance() {
    let to =
        |position: &str| format!("MCLM(CS1, M1, 0, [{position}, 0, 0], 200, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 0)");
    // 40 counts per mm: 12.5 is one; 12.51 lies 0.01 from the next and is reached, 12.512 never is.
    let drive = "velocity_feedforward = 0.0, encoder_resolution = 40.0";
    for (position, completes) in [("12.5", true), ("12.509", true), ("12.512", false)] {
        let mut bench = machine(drive, 1.0);
        bench.execute(&to(position));
        for _ in 0..2000 {
            bench.tick();
            assert_eq!((bench.axis("X").actual[0] * 40.0).fract(), 0.0);
        }
        assert_eq!(bench.control("M1").has(Flag::Pc), completes, "{position}");
        assert_eq!(bench.axis("X").actual[0], 12.5);
    }
    let mut bench = machine(drive, 1.0);
    bench.execute(&to("12.512").replace("2, 0)", "2, 1)"));
    bench.until("M1", Flag::Pc);
    bench.run(200);
    assert_eq!(bench.call("MSF(X, M2)"), OK);
    bench.run(2);
    assert_eq!(
        (bench.axis("X").position_error, bench.axis("X").command[0]),
        (0.0, 12.5)
    );
    assert_eq!(bench.call("MSO(X, M3)"), OK);
    bench.run(2);
    assert_eq!((bench.axis("X").position_error, bench.axis("X").actual[0]), (0.0, 12.5));
}
