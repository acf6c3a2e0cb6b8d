//! MCS with a deceleration and a jerk of its own, begun in every state of a move and inside a blend
//! (spec/coordinated-instructions.md §15, spec/motion-core.md §10.3).

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};

const STOP: &str = "MCS(XY, S1, CoordinatedMove, Yes, 900, Unitspersec2, Yes, 9000, Unitspersec3)";
const PERIOD: f64 = 0.001;

/// Prevent S-Curve Velocity Reversals is off: a stop keeps its own jerk.
fn reversing() -> Bench {
    Bench::replacing("name = \"XY\"", "name = \"XY\"\ndynamics_configuration_bits = 5")
}

/// Stops the machine; the largest jerk with which an axis slowed down, and the furthest that X went.
fn stopped(bench: &mut Bench, why: &str) -> (f64, f64) {
    let mut last = ["X", "Y"].map(|axis| bench.axis(axis).command);
    let began = last.map(|axis| axis[2].abs().max(900.0));
    assert_eq!(bench.call(STOP), OK, "{why}");
    let (mut jerk, mut furthest) = (0.0_f64, 0.0_f64);
    while !bench.control("S1").has(Flag::Pc) {
        bench.tick();
        let now = ["X", "Y"].map(|axis| bench.axis(axis).command);
        for ((before, after), most) in last.iter().zip(&now).zip(began) {
            // An acceleration ends with the jerk of the move, and so does its rest beyond standstill.
            if [before, after].iter().all(|state| state[1] > 0.0 && state[2] <= 0.0) {
                jerk = jerk.max(((after[2] - before[2]) / PERIOD).abs());
            }
            assert!(after[2].abs() <= most * (1.0 + 1e-9), "{why}: {} of {most}", after[2]);
            let mean = 0.5 * (after[1] + before[1]) * PERIOD;
            assert!(
                (after[0] - before[0] - mean).abs() < 1e-5,
                "{why}: a step of the position"
            );
        }
        furthest = furthest.max(now[0][0]);
        last = now;
    }
    assert!(jerk <= 9000.0 * (1.0 + 1e-6), "{why}: {jerk}");
    for axis in ["X", "Y"] {
        assert_eq!(bench.axis(axis).command[1..], [0.0, 0.0], "{why}");
    }
    (jerk, furthest)
}

#[test]
fn its_own_deceleration_and_jerk_from_every_state_of_a_move() {
    // 2000 / 50,000: 40 ms to full acceleration; 100 ms at it; back to 0 by 140 ms; and the same before the end, from 500 ms on.
    #[rustfmt::skip]
    let cases = [
        ("just begun",                     1),
        ("the acceleration rises",        20),
        ("full acceleration",             60),
        ("the acceleration falls",       120),
        ("cruising",                     300),
        ("the deceleration rises",       520),
        ("full deceleration",            580),
        ("the deceleration falls",       630),
    ];
    for (why, at) in cases {
        let mut bench = reversing();
        bench.execute("MCLM(XY, M1, 0, [100, 0], 200, 0, 2000, 0, 2000, 0, 1, 50000, 50000, 0, 1)");
        bench.run(at);
        let [place, speed, acceleration] = bench.axis("X").command;
        let (jerk, furthest) = stopped(&mut bench, why);
        assert!((jerk - 9000.0).abs() < 1e-2, "{why}: {jerk}");
        assert_eq!(bench.bits("M1"), "EN DN", "{why}");
        assert_eq!(bench.position("Y"), 0.0, "{why}: on the path");
        if acceleration == 0.0 && speed > 0.0 {
            // v/2 (v/d + d/j)
            let way = 0.5 * speed * (speed / 900.0 + 900.0 / 9000.0);
            assert!((furthest - place - way).abs() < 1e-9, "{why}: {furthest}");
        }
    }
}

#[test]
fn its_own_deceleration_and_jerk_inside_a_blend() {
    // The ends of both moves overlap by 140 ms; both stop, each on its own path.
    for after in [1, 15, 45, 70, 100, 125] {
        let why = format!("{after} ms into the blend");
        let mut bench = reversing();
        bench.execute("MCLM(XY, M1, 0, [100, 0], 200, 0, 2000, 0, 2000, 0, 1, 50000, 50000, 0, 3)");
        bench.execute("MCLM(XY, M2, 0, [100, 100], 200, 0, 2000, 0, 2000, 0, 1, 50000, 50000, 0, 1)");
        bench.until("M1", Flag::Pc);
        bench.run(after);
        let moving = ["X", "Y"].map(|axis| bench.axis(axis).command[1]);
        assert!(moving.iter().all(|speed| *speed > 0.0), "{why}: both move, {moving:?}");
        stopped(&mut bench, &why);
        assert_eq!(
            (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
            ("EN DN PC", "EN DN"),
            "{why}"
        );
    }
}

#[test]
fn a_stop_in_a_deep_queue_rests_on_the_path_and_cancels_all_of_it() {
    for at in [30, 700] {
        let mut bench = Bench::replacing("name = \"XY\"", "name = \"XY\"\nqueue_depth = 300");
        let point = |place: i32| {
            let angle = 0.004 * f64::from(place);
            (100.0 * angle.sin(), 100.0 * (1.0 - angle.cos()))
        };
        let pieces = 301;
        for place in 1..=pieces {
            let (x, y) = point(place);
            let call = format!("MCLM(XY, M{place}, 0, [{x}, {y}], 150, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 4)");
            assert_eq!(bench.call(&call), OK);
        }
        bench.run(at);
        assert_eq!(bench.call(STOP), OK);
        let mut last = bench.system("XY").path_speed;
        while !bench.control("S1").has(Flag::Pc) {
            bench.tick();
            let speed = bench.system("XY").path_speed;
            assert!(
                (last - speed) / PERIOD <= 2000.0 * 1.01,
                "at {at} ms: {last} to {speed}"
            );
            last = speed;
        }
        let last = bench.bits(&format!("M{pieces}"));
        assert_eq!(last, "EN DN", "at {at} ms");
        // Every end of a chord lies on the circle, its middle by 0.0002 inside.
        let off = (bench.position("X").hypot(bench.position("Y") - 100.0) - 100.0).abs();
        assert!(off < 2.1e-4, "at {at} ms: {off} off the path");
        assert_eq!(
            bench.call("MCLM(XY, N1, 1, [5, 0], 150, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1)"),
            OK
        );
        bench.until("N1", Flag::Pc);
    }
}

#[test]
fn a_gentle_stop_of_a_braking_move_does_not_reverse() {
    // 200²/v of jerk cannot take 1720 units/s² away before rest: without bit 1 the stop drives backwards.
    for (bits, reverses) in [(7, false), (5, true)] {
        let system = format!("name = \"XY\"\ndynamics_configuration_bits = {bits}");
        let mut bench = Bench::replacing("name = \"XY\"", &system);
        bench.execute("MCLM(XY, M1, 0, [300, 0], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1)");
        while bench.position("X") < 295.0 {
            bench.tick();
        }
        bench.execute("MCS(XY, S1, CoordinatedMove, Yes, 200, Unitspersec2, Yes, 100, %ofTime)");
        let mut slowest = 0.0_f64;
        while !bench.control("S1").has(Flag::Pc) {
            bench.tick();
            slowest = slowest.min(bench.axis("X").command[1]);
        }
        assert_eq!(slowest < -50.0, reverses, "bits {bits}: {slowest}");
        assert!(reverses || slowest > -1e-9, "bits {bits}: {slowest}");
    }
}
