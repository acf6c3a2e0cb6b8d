//! A simulated servo in the whole machine: its following error, its limits and its encoder, and what they do to settling.

use std::f64::consts::TAU;

use arcline_instruction_set::Flag;
use arcline_tests::bench::Bench;

/// The default machine with every axis a servo with this drive, at an update period in ms.
fn machine(drive: &str, period_ms: f64) -> Bench {
    let dynamics = "max_deceleration_jerk = 200000.0";
    let config = arcline_config::DEFAULT
        .replace(dynamics, &format!("{dynamics}\ndrive = {{ {drive} }}"))
        .replace("type = \"virtual\"", "type = \"servo\"");
    Bench::with(&config.replace(
        "coarse_update_period_ms = 1.0",
        &format!("coarse_update_period_ms = {period_ms}"),
    ))
}

/// When a move that waits for the axis hands over to its successor, seconds.
fn handed_over(drive: &str, profile: u8, period_ms: f64) -> f64 {
    let mut bench = machine(drive, period_ms);
    bench.execute(&format!("MCLM(CS1, M1, 0, [31.7, 0, 0], 200, 0, 2000, 0, 2000, 0, {profile}, 100, 100, 2, 0)"));
    bench.execute("MCLM(CS1, M2, 0, [31.7, 100, 0], 200, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 1)");
    bench.until("M1", Flag::Pc);
    while bench.axis("Y").command[1] < 100.0 {
        bench.tick();
    }
    bench.now() as f64 * period_ms / 1000.0 - bench.axis("Y").command[1] / 2000.0
}

#[test]
fn tmp() {
    for drive in ["position_bandwidth_hz = 40.0, velocity_feedforward = 0.0", "position_bandwidth_hz = 5.0, velocity_feedforward = 0.2", "position_bandwidth_hz = 40.0, velocity_feedforward = 0.5", "position_bandwidth_hz = 40.0, velocity_feedforward = 1.0",
    "position_bandwidth_hz = 40.0, velocity_feedforward = 0.0, torque_limit=1500.0", "position_bandwidth_hz = 40.0, velocity_feedforward = 0.0, encoder_resolution=100.0"] {
        for profile in [0, 1] {
            let at = [0.25, 0.5, 1.0, 2.0, 4.0].map(|p| handed_over(drive, profile, p));
            println!("{drive} {profile}: {at:?}");
        }
    }
}
