//! MAG: the positions of a slave, its start at its master, its end, and the bits (spec/axis-and-data-types.md §3.5).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::motion_status::{GEARING_LOCK_STATUS, GEARING_STATUS};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::{bench, machine, without_command_limits};

/// The operands from Speed on: a trapezoid at 100 units/s.
const TRAPEZOID: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
/// The operands from Speed on: an S-curve at 100 units/s.
const S_CURVE: &str = "100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2";
/// The operands from Slave Counts on: a real ratio of the command position, no clutch.
const COMMAND: &str = "1, 1, Command, Real, Disabled, 0, 0";
/// The same with a clutch of 1000 units/s².
const CLUTCH: &str = "1, 1, Command, Real, Enabled, 1000, Unitspersec2";

fn position(bench: &Bench, axis: &str) -> f64 {
    bench.position(axis)
}

fn velocity(bench: &Bench, axis: &str) -> f64 {
    bench.axis(axis).command[1]
}

/// Whether the axis is geared, and locked.
fn gearing(bench: &Bench, axis: &str) -> (bool, bool) {
    let word = bench.axis(axis).motion_status;
    (word & GEARING_STATUS != 0, word & GEARING_LOCK_STATUS != 0)
}

#[track_caller]
fn near(is: f64, expected: f64, why: &str) {
    assert!((is - expected).abs() < 1e-9, "{why}: {is} is not {expected}");
}

#[test]
fn ratios_and_directions() {
    #[rustfmt::skip]
    let cases = [
        // why,                       from Direction on,                                ratio
        ("same",                      "Same, 0.5, 1, 1, Command, Real, Disabled",          0.5),
        ("opposite",                  "Opposite, 2.5, 1, 1, Command, Real, Disabled",     -2.5),
        ("actual position",           "Same, 0.5, 1, 1, Actual, Real, Disabled",           0.5),
        ("counts",                    "Same, 0, 3, 8, Command, Fraction, Disabled",        0.375),
        ("counts, opposite",          "Opposite, 0, 32767, 1, Command, Fraction_slave_master_counts, Disabled", -32767.0),
        ("the counts are not read",   "Same, 9.99999, 0, 0, Command, Real, Disabled",      9.99999),
        ("a clutch while at rest",    "Same, 0.00001, 1, 1, Command, Real, Enabled, 10, 0", 0.00001),
        ("a clutch in percent",       "Same, 1.5, 1, 1, Command, Real, Enabled, 1, %ofMaximum", 1.5),
    ];
    for (why, operands, ratio) in cases {
        let mut bench = Bench::with(&without_command_limits(1.0));
        assert_eq!(bench.call(&format!("MAG(A1, B1, G, {operands})")), OK, "{why}");
        assert_eq!(bench.bits("G"), "EN DN IP", "{why}");
        assert_eq!(gearing(&bench, "A1"), (true, true), "{why}: the master stands");
        assert_eq!(bench.call(&format!("MAM(B1, M, 0, 33.3, {S_CURVE})")), OK);
        bench.run(150);
        near(velocity(&bench, "A1"), ratio * velocity(&bench, "B1"), why);
        bench.until("M", Flag::Pc);
        // The slave follows the master's whole displacement, not a sum of steps.
        assert_eq!(position(&bench, "A1"), ratio * 33.3, "{why}");
        assert_eq!(bench.bits("G"), "EN DN IP", "{why}: it never completes");
    }
}

/// Why, the earlier calls, the call, and its ERR and EXERR.
type Refusal = (&'static str, Vec<String>, String, (i16, i8));

#[test]
fn invalid_gears_are_refused() {
    let ratio = |operands: &str| format!("MAG(A1, B1, G, {operands})");
    let gear = |slave: &str, master: &str| format!("MAG({slave}, {master}, G0, Same, 1, {COMMAND})");
    let stopping = format!("MAM(A1, M, 0, 500, {TRAPEZOID})");
    #[rustfmt::skip]
    let cases: Vec<Refusal> = vec![
        ("direction",                vec![], ratio("4, 1, 1, 1, Command, Real, Disabled"), (13, 3)),
        ("ratio too small",          vec![], ratio("Same, 0.000009, 1, 1, Command, Real, Disabled"), (13, 4)),
        ("ratio too large",          vec![], ratio("Same, 10, 1, 1, Command, Real, Disabled"), (13, 4)),
        ("slave counts",             vec![], ratio("Same, 1, 0, 1, Command, Fraction, Disabled"), (13, 5)),
        ("master counts",            vec![], ratio("Same, 1, 1, 32768, Command, Fraction, Disabled"), (13, 6)),
        ("reference",                vec![], ratio("Same, 1, 1, 1, 2, Real, Disabled"), (13, 7)),
        ("format",                   vec![], ratio("Same, 1, 1, 1, Command, 2, Disabled"), (13, 8)),
        ("clutch",                   vec![], ratio("Same, 1, 1, 1, Command, Real, 2"), (13, 9)),
        ("no rate for the clutch",   vec![], ratio("Same, 1, 1, 1, Command, Real, Enabled, 0, 0"), (13, 10)),
        ("units",                    vec![], ratio("Same, 1, 1, 1, Command, Real, Enabled, 10, 2"), (13, 11)),
        ("its own master",           vec![], gear("A1", "A1"), (10, 0)),
        ("a ring of two",            vec![gear("B1", "A1")], gear("A1", "B1"), (10, 0)),
        ("a ring of three",          vec![gear("B1", "A1"), gear("C1", "B1")], gear("A1", "C1"), (10, 0)),
        ("a source to its target",   vec!["MCT(L1, L2, T, [0, 0, 0], [0, 0, 0])".into()], gear("A1", "A2"), (10, 0)),
        ("a target to its source",   vec!["MCT(L1, L2, T, [0, 0, 0], [0, 0, 0])".into()], gear("A2", "B1"), (10, 0)),
        ("a source to its source",   vec!["MCT(L1, L2, T, [0, 0, 0], [0, 0, 0])".into()], gear("A1", "B1"), OK),
        ("nothing to reverse",       vec![], ratio("Reverse, 1, 1, 1, Command, Real, Disabled"), (23, 0)),
        ("nothing to leave unchanged", vec![], ratio("Unchanged, 1, 1, 1, Command, Real, Disabled"), (23, 0)),
        ("a gearing that is stopped", vec![gear("A1", "B1"), "MAS(A1, S, Gear)".into()],
                                             ratio("Reverse, 1, 1, 1, Command, Real, Disabled"), (23, 0)),
        ("shutdown",                 vec!["MASD(A1, S)".into()], gear("A1", "B1"), (7, 0)),
        ("servo off",                vec!["MSF(P, S)".into()], gear("P", "B1"), (5, 0)),
        ("a stop of all",            vec![stopping, "MAS(A1, S, All, Yes, 10, 0)".into()], gear("A1", "B1"), (78, 0)),
        ("a master whose servo is off", vec!["MSF(P, S)".into()], gear("A1", "P"), OK),
        ("a master in shutdown",     vec!["MASD(B1, S)".into()], gear("A1", "B1"), OK),
    ];
    for (why, before, call, expected) in cases {
        let mut bench = bench();
        for call in &before {
            assert_eq!(bench.call(call), OK, "{why}: {call}");
            bench.run(20);
        }
        assert_eq!(bench.call(&call), expected, "{why}: {call}");
    }
    let weak = machine(1.0).replacen("max_deceleration = 4000.0", "max_deceleration = 0.0", 1);
    assert_eq!(Bench::with(&weak).call(&gear("A1", "B1")), (54, 0));
}

#[test]
fn the_clutch_ramps_to_the_geared_speed() {
    // A master at 100 units/s, a ratio of 0.5, 1000 units/s²: 0.05 s, and 1.25 units that are not made up.
    for (direction, sign) in [("Same", 1.0), ("Opposite", -1.0)] {
        let mut bench = bench();
        bench.call(&format!("MAM(B1, M, 0, 900, {TRAPEZOID})"));
        bench.run(500);
        let met = position(&bench, "B1");
        assert_eq!(bench.call(&format!("MAG(A1, B1, G, {direction}, 0.5, {CLUTCH})")), OK);
        assert_eq!(gearing(&bench, "A1"), (true, false));
        for ms in 1..50 {
            bench.tick();
            near(velocity(&bench, "A1"), sign * f64::from(ms), "the ramp");
            assert_eq!(gearing(&bench, "A1"), (true, false), "at {ms} ms");
        }
        bench.tick();
        assert_eq!(gearing(&bench, "A1"), (true, true), "locked at 50 ms");
        bench.run(200);
        near(velocity(&bench, "A1"), sign * 50.0, "geared");
        bench.until("M", Flag::Pc);
        near(
            position(&bench, "A1"),
            sign * (0.5 * (900.0 - met) - 1.25),
            "the clutch's loss",
        );
    }
}

#[test]
fn without_a_clutch_the_speed_steps() {
    let mut bench = bench();
    bench.call(&format!("MAM(B1, M, 0, 900, {TRAPEZOID})"));
    bench.run(500);
    let met = position(&bench, "B1");
    assert_eq!(bench.call(&format!("MAG(A1, B1, G, Same, 0.5, {COMMAND})")), OK);
    bench.tick();
    assert_eq!(gearing(&bench, "A1"), (true, true));
    near(velocity(&bench, "A1"), 50.0, "at once");
    bench.until("M", Flag::Pc);
    near(position(&bench, "A1"), 0.5 * (900.0 - met), "nothing is lost");
}

#[test]
fn another_gearing_supersedes_and_clutches_from_the_speed_that_it_had() {
    let mut bench = bench();
    assert_eq!(bench.call(&format!("MAG(A1, B1, G1, Same, 0.5, {COMMAND})")), OK);
    bench.call(&format!("MAM(B1, M, 0, 900, {TRAPEZOID})"));
    bench.run(500);
    for (tag, direction, ratio, speed) in [
        ("G2", "Same", 0.9, 90.0),
        ("G3", "Reverse", 0.2, -20.0),
        ("G4", "Unchanged", 0.3, -30.0),
        ("G5", "Opposite", 0.1, -10.0),
        ("G6", "Reverse", 0.4, 40.0),
    ] {
        let before = velocity(&bench, "A1");
        assert_eq!(
            bench.call(&format!("MAG(A1, B1, {tag}, {direction}, {ratio}, {CLUTCH})")),
            OK,
            "{tag}"
        );
        let old = format!("G{}", tag[1..].parse::<u32>().expect("a number") - 1);
        assert_eq!((bench.bits(&old), bench.bits(tag)), ("EN DN".into(), "EN DN IP".into()));
        bench.tick();
        near(
            (velocity(&bench, "A1") - before).abs(),
            1.0,
            "the ramp begins where it was",
        );
        bench.run(130);
        near(velocity(&bench, "A1"), speed, tag);
        assert_eq!(gearing(&bench, "A1"), (true, true));
    }
}

#[test]
fn instructions_of_one_update_find_the_slave_in_motion() {
    let geared = || {
        let mut bench = bench();
        bench.call(&format!("MAM(B1, M, 0, 900, {TRAPEZOID})"));
        bench.run(500);
        assert_eq!(bench.call(&format!("MAG(A1, B1, G1, Same, 0.5, {COMMAND})")), OK);
        bench
    };
    let mut bench = geared();
    assert_eq!(bench.call(&format!("MAG(A1, B1, G2, Same, 0.6, {CLUTCH})")), OK);
    bench.tick();
    near(velocity(&bench, "A1"), 51.0, "another gearing");
    let mut bench = geared();
    assert_eq!(bench.call("MAS(A1, S, All, Yes, 500, 0, No, 0, 0)"), OK);
    bench.tick();
    near(velocity(&bench, "A1"), 49.5, "a stop");
}

#[test]
fn a_stop_of_the_gearing_brakes_from_the_geared_speed() {
    for stop_type in ["Gear", "All"] {
        let mut bench = bench();
        assert_eq!(bench.call(&format!("MAG(A1, B1, G, Same, 0.5, {COMMAND})")), OK);
        bench.call(&format!("MAM(B1, M, 0, 900, {S_CURVE})"));
        bench.run(500);
        assert_eq!(
            bench.call(&format!("MAS(A1, S, {stop_type}, Yes, 500, 0, No, 0, 0)")),
            OK
        );
        assert_eq!((bench.bits("G"), bench.bits("S")), ("EN DN".into(), "EN DN IP".into()));
        assert_eq!(gearing(&bench, "A1"), (false, false));
        bench.run(50);
        near(velocity(&bench, "A1"), 25.0, "trapezoidal");
        bench.run(50);
        assert_eq!(bench.bits("S"), "EN DN PC", "{stop_type}");
        assert_eq!((velocity(&bench, "A1"), velocity(&bench, "B1")), (0.0, 100.0));
    }
    // Other stop types leave it alone.
    let mut bench = bench();
    bench.call(&format!("MAG(A1, B1, G, Same, 0.5, {COMMAND})"));
    for stop_type in [
        "Jog",
        "Move",
        "Home",
        "Tune",
        "Test",
        "TimeCam",
        "PositionCam",
        "MasterOffsetMove",
        "DirectControl",
    ] {
        assert_eq!(bench.call(&format!("MAS(A1, S, {stop_type})")), OK, "{stop_type}");
        assert_eq!(
            (bench.bits("G"), bench.bits("S")),
            ("EN DN IP".into(), "EN DN PC".into()),
            "{stop_type}"
        );
    }
}

#[test]
fn gearing_is_superimposed_and_merges_end_it() {
    let mut bench = bench();
    bench.call(&format!("MAG(A1, B1, G, Same, 0.5, {COMMAND})"));
    bench.call(&format!("MAM(B1, M1, 0, 200, {S_CURVE})"));
    bench.call(&format!("MAM(A1, M2, 0, 10, {S_CURVE})"));
    bench.call(&format!("MCLM(L1, M3, 1, [5, 0, 7], {S_CURVE}, 1)"));
    bench.until_rest();
    near(position(&bench, "A1"), 0.5 * 200.0 + 10.0 + 5.0, "all add up");
    for tag in ["M1", "M2", "M3"] {
        assert_eq!(bench.bits(tag), "EN DN PC", "{tag}");
    }
    bench.call(&format!("MAM(B1, M4, 1, 200, {TRAPEZOID})"));
    bench.run(500);
    let speed = velocity(&bench, "A1");
    near(speed, 50.0, "geared");
    assert_eq!(bench.call(&format!("MAM(A1, M5, 1, 80, {TRAPEZOID}, 1, 0)")), OK);
    assert_eq!(
        (bench.bits("G"), gearing(&bench, "A1")),
        ("EN DN".into(), (false, false))
    );
    bench.tick();
    near(velocity(&bench, "A1"), 51.0, "it goes on from the speed that it had");
    let from = position(&bench, "A1") - 0.0505;
    bench.until("M5", Flag::Pc);
    near(position(&bench, "A1"), from + 80.0, "and to its own target");
}

#[test]
fn slaves_of_slaves_are_where_their_masters_are_within_the_same_update() {
    // Against the order of the configuration, and with it.
    let mut bench = bench();
    for (slave, master) in [("A1", "B1"), ("B1", "C5"), ("Q", "A1"), ("R", "Q")] {
        assert_eq!(
            bench.call(&format!("MAG({slave}, {master}, G{slave}, Same, 2, {COMMAND})")),
            OK,
            "{slave}"
        );
    }
    bench.call(&format!("MAM(C5, M, 0, 40, {S_CURVE})"));
    for _ in 0..600 {
        bench.tick();
        let c5 = position(&bench, "C5");
        for (axis, ratio) in [("B1", 2.0), ("A1", 4.0), ("Q", 8.0), ("R", 16.0)] {
            near(position(&bench, axis), ratio * c5, axis);
        }
    }
    assert_eq!(position(&bench, "R"), 640.0);
}

#[test]
fn gears_and_transforms_follow_each_other_within_the_same_update() {
    let mut bench = bench();
    assert_eq!(bench.call("MCT(L2, L1, T, [0, 0, 90], [0, 0, 0])"), OK);
    // A master behind the transform, and a source that is geared.
    assert_eq!(bench.call(&format!("MAG(A5, B1, G1, Same, 3, {COMMAND})")), OK);
    assert_eq!(bench.call(&format!("MAG(A2, C5, G2, Same, 0.5, {COMMAND})")), OK);
    bench.call(&format!("MAM(C5, M1, 0, 100, {S_CURVE})"));
    bench.call(&format!("MAM(B1, M2, 1, 6, {S_CURVE})"));
    for _ in 0..1300 {
        bench.tick();
        let [c5, a2, b1, a5] = ["C5", "A2", "B1", "A5"].map(|axis| position(&bench, axis));
        near(b1, -a2, "the transform");
        near(a5, 3.0 * b1, "the gear behind it");
        assert!(a2 <= 0.5 * c5 + 1e-9);
    }
    near(position(&bench, "A2"), 50.0 - 6.0, "led back by the target's own move");
}

#[test]
fn a_master_without_torque_is_followed_where_it_really_is() {
    for reference in ["Actual", "Command"] {
        let mut bench = bench();
        assert_eq!(
            bench.call(&format!("MAG(A1, P, G, Same, 2, 1, 1, {reference}, Real, Disabled)")),
            OK
        );
        bench.call(&format!("MAM(P, M, 0, 500, {TRAPEZOID})"));
        bench.run(400);
        bench.call("MSF(P, S)");
        let mut before = position(&bench, "A1");
        for _ in 0..3000 {
            bench.tick();
            let now = position(&bench, "A1");
            assert!(
                now >= before - 1e-9 && now - before <= 0.2 + 1e-9,
                "{reference}: from {before} to {now}"
            );
            before = now;
        }
        near(position(&bench, "A1"), 2.0 * bench.axis("P").actual[0], reference);
        assert_eq!(bench.bits("G"), "EN DN IP");
        assert_eq!(bench.call("MSO(P, S2)"), OK);
        bench.run(5);
        near(position(&bench, "A1"), before, "switching on moves nothing");
        bench.call(&format!("MAM(P, M2, 1, -20, {TRAPEZOID})"));
        bench.until("M2", Flag::Pc);
        near(position(&bench, "A1"), before - 40.0, "and on");
    }
}

#[test]
fn the_actual_position_of_a_lagging_master() {
    let lagging = machine(1.0).replacen(
        "start = { position = 0.0, servo_on = true, homed = true }\n",
        "start = { position = 0.0, servo_on = true, homed = true }\ndrive = { velocity_feedforward = 0.0 }\n",
        1,
    );
    let mut bench = Bench::with(&lagging);
    assert_eq!(bench.call("MAG(A1, P, G1, Same, 2, 1, 1, Actual, Real, Disabled)"), OK);
    assert_eq!(bench.call("MAG(A2, P, G2, Same, 2, 1, 1, Command, Real, Disabled)"), OK);
    bench.call(&format!("MAM(P, M, 0, 50, {S_CURVE})"));
    let mut lag = 0.0;
    for _ in 0..400 {
        bench.tick();
        let master = bench.axis("P");
        // The set-point of the slave goes out before the feedback of this update comes.
        near(
            position(&bench, "A1"),
            2.0 * (master.command[0] - lag),
            "as far behind as at the last update",
        );
        lag = master.command[0] - master.actual[0];
        near(position(&bench, "A2"), 2.0 * master.command[0], "command");
    }
    assert!(
        (position(&bench, "A1") - position(&bench, "A2")).abs() > 0.1,
        "they differ"
    );
}

#[test]
fn redefining_a_position_moves_no_slave() {
    let mut bench = bench();
    assert_eq!(bench.call(&format!("MAG(A1, P, G1, Same, 2, {COMMAND})")), OK);
    assert_eq!(bench.call("MAG(A2, P, G2, Same, 2, 1, 1, Actual, Real, Disabled)"), OK);
    bench.call(&format!("MAM(P, M, 0, 50, {S_CURVE})"));
    for step in 0..4 {
        bench.run(100);
        let before = ["P", "A1", "A2"].map(|axis| position(&bench, axis));
        let slave = if step % 2 == 0 { "P" } else { "A1" };
        assert_eq!(bench.call(&format!("MRP({slave}, R, Relative, Command, 1000)")), OK);
        bench.tick();
        let after = ["P", "A1", "A2"].map(|axis| position(&bench, axis));
        for (place, (before, after)) in before.into_iter().zip(after).enumerate() {
            let redefined = place == step % 2;
            assert!(
                (after - before - if redefined { 1000.0 } else { 0.0 }).abs() < 0.5,
                "{place} at {step}"
            );
        }
    }
    bench.until_rest();
    near(position(&bench, "P"), 2050.0, "the end is shifted too");
    near(
        position(&bench, "A1"),
        2100.0,
        "redefined itself, and geared over the whole way",
    );
    near(position(&bench, "A2"), 100.0, "geared over the whole way");
}

#[test]
fn instructions_that_end_a_gearing() {
    for call in [
        "MASD(P, E)",
        "MSF(P, E)",
        "MCSD(SERVO, E)",
        "MGS(Motion, E, 1)",
        "MCS(SERVO, E, All)",
    ] {
        let mut bench = bench();
        assert_eq!(bench.call(&format!("MAG(P, B1, G, Same, 0.5, {COMMAND})")), OK);
        bench.call(&format!("MAM(B1, M, 0, 900, {TRAPEZOID})"));
        bench.run(300);
        assert_eq!(bench.call(call), OK, "{call}");
        assert_eq!(
            (bench.bits("G"), gearing(&bench, "P")),
            ("EN DN".into(), (false, false)),
            "{call}"
        );
        bench.run(2000);
        assert_eq!(velocity(&bench, "P"), 0.0, "{call}");
    }
}

#[test]
fn the_update_period_does_not_show() {
    // Clutches that end between updates, while the master speeds up, brakes, reverses and is itself superposed.
    let run = |period: f64| {
        let mut bench = Bench::with(&machine(period));
        let ticks = |ms: f64| (ms / period).round() as u64;
        let mut seen = Vec::new();
        for step in 0..260 {
            let call = match step {
                0 => format!("MAM(B1, M1, 0, 37, {S_CURVE})"),
                3 => "MAG(A1, B1, G1, Same, 0.7, 1, 1, Command, Real, Enabled, 313, 0)".into(),
                5 => "MAG(C1, A1, G2, Opposite, 1.3, 1, 1, Actual, Real, Enabled, 777, 0)".into(),
                12 => format!("MAM(B1, M2, 1, -50, {TRAPEZOID}, 0, 0)"),
                30 => format!("MCLM(FLAT1, M3, 1, [3, 20], {S_CURVE}, 1)"),
                40 => "MAG(A1, B1, G3, Reverse, 0.33, 1, 1, Command, Real, Enabled, 211, 0)".into(),
                90 => "MAG(C1, A1, G4, Same, 0.9, 1, 1, Command, Real, Disabled)".into(),
                100 => format!("MAM(B1, M4, 1, 70, {S_CURVE})"),
                110 => "MAS(A1, S, Gear, Yes, 150, 0, No, 0, 0)".into(),
                _ => String::new(),
            };
            if !call.is_empty() {
                assert_eq!(bench.call(&call), OK, "{call}");
            }
            bench.run(ticks(8.0));
            seen.push(["A1", "B1", "C1"].map(|axis| position(&bench, axis)));
        }
        seen
    };
    let [fine, plain, coarse] = [0.25, 1.0, 4.0].map(run);
    for (place, expected) in fine.into_iter().enumerate() {
        for (axis, expected) in expected.into_iter().enumerate() {
            near(plain[place][axis], expected, "1 ms");
            near(coarse[place][axis], expected, "4 ms");
        }
    }
}

#[test]
fn a_locked_slave_does_not_drift() {
    let mut bench = bench();
    bench.call(&format!("MAG(A1, B1, G, Same, 0.3, {CLUTCH})"));
    for turn in 0..200 {
        let to = if turn % 2 == 0 { 33.7 } else { -0.1 };
        bench.call(&format!("MAM(B1, M, 0, {to}, {S_CURVE})"));
        bench.run(331);
    }
    bench.until_rest();
    near(position(&bench, "A1"), 0.3 * position(&bench, "B1"), "after 200 moves");
}
