//! The orientation handed from one move to the next: queues, blends, merges and stops of moves that turn and moves that keep it
//! (spec/coordinated-instructions.md §6.3, §23.3).

use arcline_geometry::{Point, angular_rates, nearest};
use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::{Random, is_long};
use arcline_tests::robots::{DELTA_J1J2J3J6, RobotMachine};

use super::paths::{MACHINE, MOVE, bench_of, dynamics, path_cases, position};

const AXES: [&str; 6] = ["X", "Y", "Z", "RX", "RY", "RZ"];
/// The operands from Speed on, of the moves of `bench_of`: a trapezoid.
const LINE: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
/// The same as an S-curve.
const SMOOTH: &str = "100, 0, 1000, 0, 1000, 0, 1, 60, 60, 2";

/// Position, velocity and acceleration of each axis at the present tick.
fn shown(bench: &Bench) -> [[f64; 3]; 6] {
    let snapshot = bench.snapshot();
    AXES.map(|axis| {
        let index = bench.machine().axis(axis).expect("the machine has the axis");
        snapshot.axes[usize::from(index)].command
    })
}

fn positions(bench: &Bench) -> [f64; 6] {
    shown(bench).map(|[position, ..]| position)
}

/// The rate of the orientation, degrees/s about each axis of the base.
fn rate(of: &[[f64; 3]; 6]) -> Point {
    let angle = |quantity: usize| Point::new(of[3][quantity], of[4][quantity], of[5][quantity]);
    let [rate, _] = angular_rates(&angle(0), &angle(1), &angle(2));
    rate.map(f64::to_degrees)
}

/// Makes one tick in which no axis jumps: speeds change by no more than rates allow.
fn smoothly(bench: &mut Bench, period: f64, [linear, turn]: [f64; 2], why: &str) {
    let before = shown(bench);
    bench.tick();
    let after = shown(bench);
    for (place, (b, a)) in before.iter().zip(&after).enumerate() {
        let most = if place < 3 { linear } else { 4.0 * turn + 600.0 };
        let mean = 0.5 * (a[1] + b[1]) * period;
        assert!(
            (a[0] - b[0] - mean).abs() <= most * period * period,
            "{why}: {} goes from {} to {} at {}",
            AXES[place],
            b[0],
            a[0],
            a[1]
        );
        assert!(
            place >= 3 || (a[1] - b[1]).abs() <= linear * period * 1.001,
            "{why}: {} goes from {} to {} units/s",
            AXES[place],
            b[1],
            a[1]
        );
    }
    let step = (rate(&after) - rate(&before)).norm();
    // The axis of a turn that is superposed on another one turns with it.
    let most = turn + rate(&after).norm().powi(2).to_radians();
    assert!(
        step <= most * period * 1.001,
        "{why}: the turn steps by {step} degrees/s"
    );
}

/// Writes a path that ends with a termination type.
fn path(bench: &mut Bench, to: [f64; 6], termination: f64, incremental: bool) {
    position(bench, "P", to);
    for (member, value) in [
        ("TerminationType", termination),
        ("CommandToleranceLinear", 6.0),
        ("MoveType", f64::from(u8::from(incremental))),
    ] {
        bench.write(&format!("P.{member}"), value);
    }
}

/// Moves as letters: `a`, `b`, `g` path moves of termination types 1, 6 and 0, digits lines of that type.
fn sequence(kinds: &str, period: f64) {
    let mut bench = bench_of(RobotMachine { period, ..MACHINE });
    dynamics(&mut bench, [200.0, 2000.0, 2000.0], [90.0, 900.0, 900.0]);
    bench.write("D.Profile", f64::from(u8::from(kinds.len() % 2 == 1)));
    let (mut to, mut heading) = ([0.0; 3], [0.0; 3]);
    for (place, kind) in kinds.chars().enumerate() {
        let step = place as f64 + 1.0;
        to[place % 2] += 20.0 - 3.0 * step;
        to[2] += if place == 2 { 12.0 } else { 0.0 };
        let [x, y, z] = to;
        if let Some(termination) = kind.to_digit(10) {
            let call = format!(
                "MCLM(CART, L{place}, 0, [{x}, {y}, {z}], 200, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, {termination}, 0, 0, 6)"
            );
            assert_eq!(bench.call(&call), OK, "{kinds}: {call}");
        } else {
            let termination = match kind {
                'a' => 1.0,
                'b' => 6.0,
                _ => 0.0,
            };
            heading = [5.0 - 4.0 * step, 3.0 * step, if place % 2 == 0 { 10.0 } else { -25.0 }];
            path(
                &mut bench,
                [x, y, z, heading[0], heading[1], heading[2]],
                termination,
                false,
            );
            assert_eq!(bench.call(&format!("MCPM(CART, L{place}, P, 1, D)")), OK, "{kinds}");
        }
    }
    let last = format!("L{}", kinds.len() - 1);
    let mut ticks = 0;
    while !bench.control(&last).has(Flag::Pc) {
        // A corner of type 4 or 5 makes a step of its own.
        let linear = if kinds.contains(['4', '5']) { 1e5 } else { 4000.0 };
        smoothly(&mut bench, period / 1000.0, [linear, 1800.0], kinds);
        ticks += 1;
        assert!(ticks < 10_000, "{kinds} does not end");
    }
    let end = positions(&bench);
    assert_eq!(end[..3], to, "{kinds}");
    assert_eq!(end[3..], heading, "{kinds}: the orientation of the last path move");
}

#[test]
fn every_sequence_of_four_moves_keeps_the_orientation_it_came_to() {
    let kinds = ['a', 'b', '1', '4', '6'];
    for number in (0..625_usize).step_by(if is_long() { 1 } else { 7 }) {
        let kinds: String = [125, 25, 5, 1].map(|unit| kinds[number / unit % 5]).iter().collect();
        sequence(&kinds, 4.0);
    }
}

#[test]
fn longer_sequences_of_all_termination_types() {
    let kinds = ['a', 'b', 'b', 'g', '0', '1', '2', '3', '4', '5', '6'];
    for seed in 0..if is_long() { 200 } else { 30 } {
        let mut random = Random(seed);
        let kinds: String = (0..5 + random.below(4)).map(|_| *random.one_of(&kinds)).collect();
        sequence(&kinds, *random.one_of(&[1.0, 2.0, 4.0]));
    }
}

#[test]
fn a_pending_path_move_includes_rotation_that_other_motion_adds() {
    #[rustfmt::skip]
    let cases = [
        // why,                       earlier call,                             turn,                              Rz at the end
        ("behind a line",                          "MCLM(CART, L, 0, [60, 0, 0], LINE, 1)",     "MAM(RZ, R, 1, 45, LINE)",                      85.0),
        ("behind a line that blends",              "MCLM(CART, L, 0, [60, 0, 0], LINE, 2)",     "MAM(RZ, R, 1, 45, LINE)",                      85.0),
        ("behind a path move",                     "MCPM(CART, L, Many[0], 1, D)",              "MAM(RZ, R, 1, 45, LINE)",                      85.0),
        ("a jog that is stopped",                  "MCLM(CART, L, 0, [60, 0, 0], LINE, 1)",     "MAJ(RZ, R, 0, LINE); MAS(RZ, S, 1)",           40.0),
        ("positions redefined, no motion",         "MCLM(CART, L, 0, [60, 0, 0], LINE, 1)",     "MRP(RZ, R, 0, 0, 30)",                         70.0),
        ("the same behind a path move",            "MCPM(CART, L, Many[0], 1, D)",              "MRP(RZ, R, 0, 0, 30)",                         70.0),
    ];
    for (why, before, turns, at) in cases {
        let mut bench = bench_of(MACHINE);
        position(&mut bench, "Many[0]", [60.0, 0.0, 0.0, 0.0, 0.0, 20.0]);
        path(&mut bench, [120.0, 0.0, 0.0, 0.0, 0.0, 40.0], 1.0, false);
        assert_eq!(bench.call(&before.replace("LINE", LINE)), OK, "{why}");
        assert_eq!(bench.call(MOVE), OK, "{why}");
        for call in turns.split("; ") {
            assert_eq!(bench.call(&call.replace("LINE", LINE)), OK, "{why}: {call}");
        }
        while !bench.control("M").has(Flag::Pc) {
            smoothly(&mut bench, 0.001, [2100.0, 2000.0], why);
        }
        bench.until_rest();
        let rest = bench.position("RZ") - at;
        assert!(rest.abs() < 1e-6, "{why}: Rz ends at {}", bench.position("RZ"));
        assert_eq!(bench.position("X"), 120.0, "{why}");
    }
}

#[test]
fn positions_redefined_while_a_queue_turns_are_those_of_later_moves() {
    let mut bench = bench_of(MACHINE);
    path(&mut bench, [60.0, 0.0, 0.0, 0.0, 0.0, 20.0], 1.0, false);
    assert_eq!(bench.call(MOVE), OK);
    bench.run(50);
    assert_eq!(bench.call("MRP(RZ, R, 0, 0, 100)"), OK);
    let at = bench.position("RZ");
    assert!(at > 99.0 && at < 125.0, "redefined to {at}");
    path(&mut bench, [60.0, 60.0, 0.0, 0.0, 0.0, 50.0], 1.0, false);
    assert_eq!(bench.call("MCPM(CART, M2, P, 1, D)"), OK);
    bench.until("M2", Flag::Pc);
    let end = bench.position("RZ");
    assert!((end - 50.0).abs() < 1e-9, "as the operands say: {end}");
}

#[test]
fn a_joint_that_turns_meanwhile_is_taken_along() {
    let machine = RobotMachine {
        cart: MACHINE.cart,
        ..DELTA_J1J2J3J6
    };
    let mut bench = bench_of(machine);
    assert_eq!(bench.call("MCTO(CART, ROBOT, T, NoFrame, NoFrame)"), OK);
    bench.run(2);
    let from = positions(&bench);
    let line = format!("MCLM(CART, L, 1, [30, 0, 0], {LINE}, 1)");
    assert_eq!(bench.call(&line), OK);
    path(&mut bench, [0.0, 20.0, 0.0, 0.0, 0.0, 30.0], 1.0, true);
    assert_eq!(bench.call(MOVE), OK);
    assert_eq!(bench.call(&format!("MAM(J4, J, 1, 25, {LINE})")), OK);
    while !bench.control("M").has(Flag::Pc) {
        smoothly(&mut bench, 0.001, [2100.0, 3000.0], "a joint");
    }
    let turned = bench.position("RZ") - from[5];
    assert!((turned - 55.0).abs() < 1e-6, "turned by {turned}");
    assert!(!bench.control("T").has(Flag::Er));
}

/// The guard of the joints checks a stop in which the residual of the turn still ramps out, from its present position.
#[test]
fn a_robot_follows_a_turn_that_ramps_out() {
    for (why, master) in [("by time", false), ("by a master", true)] {
        let mut bench = bench_of(RobotMachine {
            cart: MACHINE.cart,
            ..DELTA_J1J2J3J6
        });
        assert_eq!(bench.call("MCTO(CART, ROBOT, T, NoFrame, NoFrame)"), OK, "{why}");
        bench.run(2);
        path(&mut bench, [5.0, 0.0, 0.0, 0.0, 0.0, 60.0], 1.0, true);
        let (mut turn, mut merge) = (MOVE, format!("MCLM(CART, N, 1, [20, 0, 0], {LINE}, 1, 1)"));
        if master {
            bench.write("D.TimeUnits", 1.0);
            dynamics(&mut bench, [2.0, 0.5, 0.5], [1.5, 0.4, 0.4]);
            assert_eq!(bench.call("MDCC(CART, U, L, 1, 40)"), OK, "{why}");
            assert_eq!(bench.call("MAJ(U, J, 0, 40, 0, 400, 0, 400, 0)"), OK, "{why}");
            turn = "MCPM(CART, M, P, 1, D, 0, 1)";
            merge = "MCLM(CART, N, 1, [20, 0, 0], 2, 4, 0.5, 4, 0.5, 4, 0, 100, 100, 6, 1, 1, 0, 0, 0, 1)".into();
        }
        assert_eq!(bench.call(turn), OK, "{why}");
        bench.run(500);
        assert!(rate(&shown(&bench)).norm() > 20.0, "{why}");
        assert_eq!(bench.call(&merge), OK, "{why}");
        let turned = bench.position("RZ");
        for _ in 0..1000 {
            smoothly(&mut bench, 0.001, [3000.0, 3000.0], why);
            let shown = bench.control("T");
            assert!(shown.has(Flag::Ip), "{why}: {shown:?} at RZ {}", bench.position("RZ"));
        }
        assert!(bench.control("N").has(Flag::Pc), "{why}");
        assert!((bench.position("RZ") - turned).abs() > 1.0, "{why}: it ramped out");
    }
}

/// A merge during a turn, and the calls before and behind it.
struct Merged<'a> {
    why: &'a str,
    /// Ticks before the merge.
    after: u64,
    profile: f64,
    /// Calls at once, before it.
    before: &'a [&'a str],
    line: &'a str,
    /// Later calls, each with its number of ticks.
    then: &'a [(u64, &'a str)],
}

#[test]
fn a_merge_ramps_a_turn_out() {
    let plain = Merged {
        why: "",
        after: 300,
        profile: 0.0,
        before: &[MOVE],
        line: "MCLM(CART, N, 1, [50, 0, 0], LINE, 1, 1)",
        then: &[],
    };
    const BLEND: &[&str] = &[MOVE, "MCPM(CART, M2, Many[0], 1, D)"];
    const BACK: &str = "MCLM(CART, N2, 1, [0, 30, 0], LINE, 1, 1)";
    #[rustfmt::skip]
    let cases = [
        Merged { why: "a trapezoid", ..plain },
        Merged { why: "all motion", line: "MCLM(CART, N, 1, [50, 0, 0], LINE, 1, 2)", ..plain },
        Merged { why: "to and fro", line: "MCLM(CART, N, 1, [-50, 0, 0], LINE, 1, 1, 1)", ..plain },
        Merged { why: "an S-curve", profile: 1.0, line: "MCLM(CART, N, 1, [50, 0, 0], SMOOTH, 1, 1)", ..plain },
        Merged { why: "while it speeds up", after: 40, profile: 1.0, ..plain },
        Merged { why: "a very short line", line: "MCLM(CART, N, 1, [0.5, 0, 0], LINE, 1, 1)", ..plain },
        Merged { why: "nowhere", line: "MCLM(CART, N, 1, [0, 0, 0], LINE, 1, 1)", ..plain },
        Merged { why: "in a blend of two turns", after: 650, before: BLEND, ..plain },
        Merged { why: "in a blend of two S-curves", after: 720, profile: 1.0, before: BLEND, line: "MCLM(CART, N, 1, [5, 40, 0], SMOOTH, 1, 1)", ..plain },
        Merged { why: "and again", then: &[(15, BACK)], ..plain },
        Merged { why: "and a stop", then: &[(15, "MCS(CART, S, 2)")], ..plain },
        Merged { why: "and a stop of everything", then: &[(15, "MCS(CART, S, 0)")], ..plain },
        Merged { why: "and another speed", then: &[(15, "MCCD(CART, C, 1, Yes, 30, 0, No, 0, 0, No, 0, 0, No, 0, No, 0, 2, 0)")], ..plain },
        Merged { why: "and a path move", then: &[(15, "MCPM(CART, M3, Many[0], 1, D)")], ..plain },
        Merged { why: "which blends into a path move", line: "MCLM(CART, N, 1, [3, 0, 0], LINE, 2, 1)", then: &[(0, "MCPM(CART, M3, Many[0], 1, D)")], ..plain },
        Merged { why: "which passes into a line", line: "MCLM(CART, N, 1, [3, 0, 0], LINE, 4, 1)", then: &[(0, "MCLM(CART, N3, 1, [30, 0, 0], LINE, 1)"), (9, "MCPM(CART, M3, Many[0], 1, D)")], ..plain },
        Merged { why: "behind a path move that was merged", line: "MCLM(CART, N, 1, [3, 0, 0], LINE, 2, 1)", then: &[(0, "MCPM(CART, M3, Many[0], 1, D)"), (40, BACK)], ..plain },
    ];
    for case in cases {
        let why = case.why;
        let mut bench = bench_of(MACHINE);
        dynamics(&mut bench, [100.0, 1000.0, 1000.0], [80.0, 800.0, 800.0]);
        bench.write("D.Profile", case.profile);
        path(&mut bench, [20.0, 0.0, 0.0, 0.0, 0.0, 50.0], 6.0, false);
        position(&mut bench, "Many[0]", [20.0, 40.0, 0.0, 20.0, 25.0, 50.0]);
        for call in case.before {
            assert_eq!(bench.call(call), OK, "{why}: {call}");
        }
        bench.run(case.after);
        let turned = rate(&shown(&bench)).norm();
        assert!(turned > 5.0, "{why}: it turns at {turned} degrees/s");
        let calls = std::iter::once((0, case.line)).chain(case.then.iter().copied());
        for (ticks, call) in calls {
            for _ in 0..ticks {
                smoothly(&mut bench, 0.001, [3000.0, 3600.0], why);
            }
            let call = call.replace("LINE", LINE).replace("SMOOTH", SMOOTH);
            assert_eq!(bench.call(&call), OK, "{why}: {call}");
        }
        let mut before = rate(&shown(&bench)).norm();
        // A stop has the Maximum Decelerations.
        let bounds = match why {
            "and a stop of everything" => [45_000.0, 80_000.0],
            "and a stop" => [13_000.0, 3600.0],
            _ => [3000.0, 3600.0],
        };
        for tick in 0..4000 {
            smoothly(&mut bench, 0.001, bounds, why);
            let now = rate(&shown(&bench)).norm();
            // Alone, it ramps out with the deceleration of the move that turned.
            let alone = case.then.is_empty() && case.before.len() == 1;
            assert!(
                !alone || before - now <= 0.8 * 1.001,
                "{why}: {before} to {now} at {tick}"
            );
            assert!(!alone || case.profile > 0.0 || now <= before, "{why}: it turns faster");
            if bench.control("N").has(Flag::Pc) && alone {
                assert_eq!(now, 0.0, "{why}: complete while it turns");
            }
            before = now;
        }
        bench.until_rest();
        let end = positions(&bench);
        let queued = case.then.iter().any(|(_, call)| call.contains("M3")) && bench.control("M3").has(Flag::Pc);
        if queued {
            assert_eq!(end[3..], [20.0, 25.0, 50.0], "{why}");
        }
        bench.run(5);
        assert_eq!(positions(&bench), end, "{why}");
        // A line behind it keeps the position that it has reached.
        assert_eq!(
            bench.call(&format!("MCLM(CART, Q, 1, [1, 1, 1], {LINE}, 1)")),
            OK,
            "{why}"
        );
        bench.until("Q", Flag::Pc);
        assert_eq!(positions(&bench)[3..], end[3..], "{why}");
    }
}

#[test]
fn a_hold_holds_the_path_while_a_turn_ramps_out() {
    let mut bench = bench_of(MACHINE);
    path(&mut bench, [20.0, 0.0, 0.0, 0.0, 0.0, 50.0], 1.0, false);
    assert_eq!(bench.call(MOVE), OK);
    bench.run(300);
    assert_eq!(bench.call(&format!("MCLM(CART, N, 1, [50, 0, 0], {LINE}, 1, 1)")), OK);
    bench.run(20);
    bench.set_override("CART", 0.0);
    for _ in 0..500 {
        smoothly(&mut bench, 0.001, [2000.0, 900.0], "a hold");
    }
    assert_eq!(rate(&shown(&bench)).norm(), 0.0);
    let held = positions(&bench);
    bench.set_override("CART", 1.0);
    bench.until("N", Flag::Pc);
    assert_eq!(positions(&bench)[3..], held[3..]);
}

#[test]
fn a_master_driven_merge_ramps_a_turn_out() {
    let mut bench = bench_of(MACHINE);
    bench.write("D.TimeUnits", 1.0);
    dynamics(&mut bench, [2.0, 0.5, 0.5], [1.5, 0.4, 0.4]);
    path(&mut bench, [100.0, 0.0, 0.0, 0.0, 0.0, 80.0], 1.0, false);
    assert_eq!(bench.call("MDCC(CART, U, L, 1, 40)"), OK);
    assert_eq!(bench.call("MCPM(CART, M, P, 1, D, 0, 1)"), OK);
    assert_eq!(bench.call("MAJ(U, J, 0, 40, 0, 400, 0, 400, 0)"), OK);
    bench.run(700);
    assert!(rate(&shown(&bench)).norm() > 30.0);
    let by_master = "2, 4, 0.5, 4, 0.5, 4, 0, 100, 100, 6";
    let call = format!("MCLM(CART, N, 1, [50, 0, 0], {by_master}, 1, 1, 0, 0, 0, 1)");
    assert_eq!(bench.call(&call), OK);
    let limits = [2000.0, 0.4 * 40.0 * 40.0];
    for _ in 0..40 {
        smoothly(&mut bench, 0.001, limits, "by a master");
    }
    // Its stop is one by time.
    assert!(rate(&shown(&bench)).norm() > 1.0);
    assert_eq!(bench.call("MCS(CART, S, 2)"), OK);
    while !bench.control("S").has(Flag::Pc) {
        smoothly(&mut bench, 0.001, [11_000.0, limits[1]], "a stop by time");
    }
    assert_eq!(rate(&shown(&bench)).norm(), 0.0);
}

/// A complete blend stays at its end, in any time base of the moves behind it.
#[test]
fn a_blend_that_is_over_does_not_come_back_on_another_clock() {
    let mut bench = bench_of(MACHINE);
    bench.run(1000);
    assert_eq!(bench.call("MDCC(CART, U, L, 1, 40)"), OK);
    let by_master = "2, 4, 0.5, 4, 0.5, 4, 0, 100, 100, 6";
    for call in [
        format!("MCLM(CART, A, 0, [40, 0, 0], {LINE}, 2)"),
        format!("MCLM(CART, B, 0, [40, 40, 0], {LINE}, 1)"),
        format!("MCLM(CART, C, 0, [0, 40, 0], {by_master}, 1, 0, 0, 0, 0, 1)"),
    ] {
        assert_eq!(bench.call(&call), OK, "{call}");
    }
    assert_eq!(bench.call("MAJ(U, J, 0, 40, 0, 400, 0, 400, 0)"), OK);
    while !bench.control("C").has(Flag::Pc) {
        smoothly(&mut bench, 0.001, [2100.0, 1.0], "a queue");
    }
    assert_eq!(positions(&bench)[..3], [0.0, 40.0, 0.0]);
}

#[test]
fn a_stop_in_a_blend_brakes_each_part_with_its_own_rates() {
    for (why, first, second) in [
        (
            "a line into what only turns",
            [8.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [8.0, 0.0, 0.0, 0.0, 0.0, 60.0],
        ),
        (
            "what only turns into a line",
            [0.0, 0.0, 0.0, 0.0, 0.0, 9.0],
            [60.0, 0.0, 0.0, 0.0, 0.0, 9.0],
        ),
        (
            "a wide turn on a short way",
            [1.0, 0.0, 0.0, 0.0, 0.0, 9.0],
            [60.0, 40.0, 0.0, 0.0, 0.0, 9.0],
        ),
        (
            "a small turn on a long way into a wide one on a short way",
            [8.0, 0.0, 0.0, 0.0, 0.0, 5.0],
            [9.0, 0.0, 0.0, 0.0, 0.0, 140.0],
        ),
    ] {
        for after in [60, 110, 150, 180, 210, 240] {
            let mut bench = bench_of(MACHINE);
            path(&mut bench, first, 6.0, false);
            position(&mut bench, "Many[0]", second);
            assert_eq!(bench.call(MOVE), OK, "{why}");
            assert_eq!(bench.call("MCPM(CART, M2, Many[0], 1, D)"), OK, "{why}");
            bench.run(after);
            assert_eq!(bench.call("MCS(CART, S, 2)"), OK, "{why}");
            let stopped = bench.now();
            while !bench.control("S").has(Flag::Pc) {
                smoothly(&mut bench, 0.001, [20_000.0, 1800.0], &format!("{why} at {after}"));
                assert!(bench.now() < stopped + 700, "{why} at {after}: it does not stop");
            }
        }
    }
}

/// A master that is shut down breaks the link: both moves of a blend brake in time, each with its own share of the maxima.
#[test]
fn a_master_that_is_lost_in_a_blend_brakes_each_part_with_its_own_rates() {
    for (why, first, second) in [
        (
            "a line into what only turns",
            [8.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [8.0, 0.0, 0.0, 0.0, 0.0, 60.0],
        ),
        (
            "a small turn on a long way into a wide one on a short way",
            [8.0, 0.0, 0.0, 0.0, 0.0, 5.0],
            [9.0, 0.0, 0.0, 0.0, 0.0, 140.0],
        ),
    ] {
        let mut blended = 0;
        for after in (120..400).step_by(20) {
            let mut bench = bench_of(MACHINE);
            bench.write("D.TimeUnits", 1.0);
            dynamics(&mut bench, [2.0, 0.5, 0.5], [1.5, 0.4, 0.4]);
            path(&mut bench, first, 6.0, false);
            position(&mut bench, "Many[0]", second);
            assert_eq!(bench.call("MDCC(CART, U, L, 1, 40)"), OK, "{why}");
            assert_eq!(bench.call("MCPM(CART, M, P, 1, D, 0, 1)"), OK, "{why}");
            assert_eq!(bench.call("MCPM(CART, M2, Many[0], 1, D, 0, 1)"), OK, "{why}");
            assert_eq!(bench.call("MAJ(U, J, 0, 40, 0, 400, 0, 400, 0)"), OK, "{why}");
            bench.run(after);
            blended += usize::from(bench.system("CART").motion_status & (1 << 7) != 0);
            assert_eq!(bench.call("MASD(U, S)"), OK, "{why}");
            for _ in 0..700 {
                smoothly(&mut bench, 0.001, [20_000.0, 1800.0], &format!("{why} at {after}"));
            }
            let speeds = shown(&bench).map(|[_, velocity, _]| velocity);
            assert_eq!(speeds, [0.0; 6], "{why} at {after}: it does not stop");
        }
        assert!(blended > 1, "{why}: {blended} in a blend");
    }
}

#[test]
fn half_a_turn_goes_about_the_positive_axis_from_everywhere() {
    for number in (-24..24).step_by(if is_long() { 1 } else { 3 }) {
        let from = 7.5 * f64::from(number);
        for (axis, name) in [(5, "RZ"), (3, "RX")] {
            let mut bench = bench_of(MACHINE);
            let mut to = [0.0; 6];
            to[axis] = from;
            path(&mut bench, to, 1.0, false);
            assert_eq!(bench.call(MOVE), OK);
            bench.until("M", Flag::Pc);
            to[axis] = 180.0;
            path(&mut bench, to, 1.0, true);
            assert_eq!(bench.call("MCPM(CART, M2, P, 1, D)"), OK);
            bench.run(300);
            let (at, begun) = (bench.position(name), if from <= -180.0 { from + 360.0 } else { from });
            assert!(at > begun, "{name} from {begun}: it goes to {at}");
            bench.until("M2", Flag::Pc);
            assert_eq!(bench.position(name), begun + 180.0, "{name} from {begun}");
        }
    }
}

#[test]
fn angles_go_on_without_a_whole_turn_at_once() {
    for seed in 0..=path_cases(60, 10) {
        let mut random = Random(seed);
        let [first, second] = [(); 2].map(|()| {
            let mut within = |bound: f64| f64::from(random.between(-bound, bound) as f32);
            [20.0, 0.0, 0.0, within(179.0), within(85.0), within(179.0)]
        });
        let [first, second] = if seed == 0 {
            // Found by an audit: Rx goes on beyond -180.
            [[20.0, 0.0, 0.0, -56.0, 76.0, 62.0], [20.0, 0.0, 0.0, 52.0, -3.0, -43.0]]
        } else {
            [first, second]
        };
        let mut bench = bench_of(MACHINE);
        dynamics(&mut bench, [100.0, 1000.0, 1000.0], [90.0, 900.0, 900.0]);
        for (tag, to) in [("M", first), ("M2", second)] {
            path(&mut bench, to, 1.0, false);
            assert_eq!(bench.call(&format!("MCPM(CART, {tag}, P, 1, D)")), OK);
            while !bench.control(tag).has(Flag::Pc) {
                let before = positions(&bench);
                bench.tick();
                let after = positions(&bench);
                for place in 3..6 {
                    let step = (after[place] - before[place]).abs();
                    // Straight up Rx and Rz turn by half a turn on a short way.
                    assert!(
                        step < 185.0,
                        "seed {seed}, {first:?} to {second:?}: {} steps by {step}",
                        AXES[place]
                    );
                }
            }
            let end = positions(&bench);
            let apart = |place: usize| (end[place] - nearest(to[place], end[place])).abs();
            assert!(
                (3..6).all(|place| apart(place) < 1e-9),
                "seed {seed}: {end:?} is not {to:?}"
            );
        }
    }
}

#[test]
fn percent_by_a_master_need_its_nominal_velocity() {
    for (nominal, units, expected) in [(0.0, 0.0, (13, 4)), (50.0, 0.0, OK), (0.0, 1.0, OK)] {
        let mut bench = bench_of(MACHINE);
        bench.write("D.UnitsMode", units);
        bench.write("D.TimeUnits", 1.0);
        dynamics(&mut bench, [50.0, 50.0, 50.0], [50.0, 50.0, 50.0]);
        path(&mut bench, [60.0, 0.0, 0.0, 0.0, 0.0, 4.0], 1.0, false);
        assert_eq!(bench.call(&format!("MDCC(CART, U, L, 1, {nominal})")), OK);
        assert_eq!(
            bench.call("MCPM(CART, M, P, 1, D, 0, 1)"),
            expected,
            "{nominal} {units}"
        );
    }
}
