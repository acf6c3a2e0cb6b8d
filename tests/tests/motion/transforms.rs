//! MCT between Cartesian coordinate systems: the positions of targets and sources, refusals, cancellations, and the bits
//! (spec/coordinated-instructions.md §15, §19, §20).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::{coordinate_motion_status, motion_status};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::{bench, machine};

const NO_TURN: &str = "[0, 0, 0], [0, 0, 0]";
/// The operands from Speed on: a trapezoid at 100 units/s.
const TRAPEZOID: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
/// The operands from Speed on: an S-curve at 100 units/s.
const S_CURVE: &str = "100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2";

fn positions<const N: usize>(bench: &Bench, axes: [&str; N]) -> [f64; N] {
    axes.map(|axis| bench.position(axis))
}

fn velocities<const N: usize>(bench: &Bench, axes: [&str; N]) -> [f64; N] {
    axes.map(|axis| bench.axis(axis).command[1])
}

fn near<const N: usize>(is: [f64; N], expected: [f64; N], why: &str) {
    let apart = is.iter().zip(expected).map(|(is, expected)| (is - expected).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-9, "{why}: {is:?} is not {expected:?}");
}

fn axis_bit(bench: &Bench, axis: &str, bit: u32) -> bool {
    bench.axis(axis).motion_status & bit != 0
}

fn system_bit(bench: &Bench, system: &str, bit: u32) -> bool {
    bench.system(system).motion_status & bit != 0
}

#[test]
fn the_reference_list_of_orientations() {
    // spec/coordinated-instructions.md §19.2: where a source at [1, 2, 3] leads its target.
    #[rustfmt::skip]
    let cases = [
        ("[0, 0, 0]",       [1.0, 2.0, 3.0]),
        ("[90, 0, 0]",      [1.0, 3.0, -2.0]),
        ("[0, 90, 0]",      [-3.0, 2.0, 1.0]),
        ("[0, 0, 90]",      [2.0, -1.0, 3.0]),
        ("[90, 90, 0]",     [-3.0, 1.0, -2.0]),
        ("[90, 0, 90]",     [2.0, 3.0, 1.0]),
        ("[0, 90, 90]",     [-3.0, -1.0, 2.0]),
        ("[90, 90, 90]",    [-3.0, 2.0, 1.0]),
        ("[-90, -90, -90]", [3.0, -2.0, 1.0]),
        ("[360, -360, 90]", [2.0, -1.0, 3.0]),
    ];
    for (orientation, expected) in cases {
        let mut bench = bench();
        assert_eq!(bench.call(&format!("MCT(L1, L2, T, {orientation}, [0, 0, 0])")), OK);
        assert_eq!(bench.call(&format!("MCLM(L1, M, 0, [1, 2, 3], {S_CURVE}, 1)")), OK);
        bench.until("M", Flag::Pc);
        assert_eq!(positions(&bench, ["A2", "B2", "C2"]), expected, "{orientation}");
        assert_eq!(positions(&bench, ["A1", "B1", "C1"]), [1.0, 2.0, 3.0], "{orientation}");
    }
}

#[test]
fn an_orientation_between_quarter_turns_and_in_two_dimensions() {
    let mut bench = bench();
    assert_eq!(bench.call("MCT(FLAT1, FLAT2, T, [0, 0, 30], [0, 0, 0])"), OK);
    assert_eq!(bench.call(&format!("MCLM(FLAT1, M, 0, [10, 0], {TRAPEZOID}, 1)")), OK);
    bench.until("M", Flag::Pc);
    near(
        positions(&bench, ["A2", "B2"]),
        [5.0 * 3.0_f64.sqrt(), -5.0],
        "30 degrees",
    );
}

#[test]
fn the_target_says_where_the_source_is_at_the_start() {
    // A source without drives is put there, command and actual, without motion.
    let mut bench = bench();
    assert_eq!(bench.call("MCT(L1, L2, T, [0, 0, 90], [10, 20, 30])"), OK);
    near(
        positions(&bench, ["A1", "B1", "C1"]),
        [20.0, -10.0, -30.0],
        "transposed",
    );
    for axis in ["A1", "B1", "C1", "A2"] {
        let axis = bench.axis(axis);
        assert_eq!(axis.command[0], axis.actual[0]);
        assert_eq!(axis.command[1..], [0.0, 0.0]);
    }
    bench.run(5);
    near(positions(&bench, ["A2", "B2", "C2"]), [0.0; 3], "the target stays");
    assert!(!axis_bit(&bench, "A1", motion_status::CONTROLLED_BY_TRANSFORM_STATUS));
    assert_eq!(bench.call(&format!("MCLM(L1, M, 0, [0, 0, 0], {S_CURVE}, 1)")), OK);
    bench.until("M", Flag::Pc);
    near(
        positions(&bench, ["A2", "B2", "C2"]),
        [10.0, 20.0, 30.0],
        "the translation",
    );

    // A source with drives is where it is.
    let mut bench = self::bench();
    assert_eq!(bench.call("MCT(SERVO, L2, T, [0, 0, 0], [0, 0.002, 0])"), (67, 1));
    assert_eq!(bench.call("MCT(SERVO, L2, T, [0, 0, 0], [0, 0.0009, 0])"), OK);
    assert_eq!(bench.position("Q"), 0.0);
    assert_eq!(bench.call(&format!("MCLM(SERVO, M, 0, [7, 8, 9], {S_CURVE}, 1)")), OK);
    bench.until("M", Flag::Pc);
    near(
        positions(&bench, ["A2", "B2", "C2"]),
        [7.0, 8.0, 9.0],
        "nothing jumped at the start",
    );

    // A source that another transform holds cannot be put anywhere.
    let mut bench = self::bench();
    assert_eq!(bench.call(&format!("MCT(L1, L2, T1, {NO_TURN})")), OK);
    assert_eq!(bench.call("MCT(L1, L3, T2, [0, 0, 0], [0, 0, 1])"), (67, 2));
    assert_eq!(bench.call(&format!("MCT(L1, L3, T2, {NO_TURN})")), OK);
}

/// Why, the earlier calls, the call, and its ERR and EXERR.
type Refusal = (&'static str, Vec<String>, &'static str, (i16, i8));

#[test]
fn invalid_transforms_are_refused() {
    let link = format!("MCT(L1, L2, T1, {NO_TURN})");
    let moves = |system: &str| format!("MCLM({system}, M, 0, [900, 0, 0], {TRAPEZOID}, 1)");
    #[rustfmt::skip]
    let cases: Vec<Refusal> = vec![
        ("orientation too short",        vec![],          "MCT(L1, L2, T, [0, 0], [0, 0, 0])", (13, 3)),
        ("translation too short",        vec![],          "MCT(L1, L2, T, [0, 0, 0], [0, 0])", (13, 4)),
        ("first angle beyond a turn",    vec![],          "MCT(L1, L2, T, [360.1, 0, 0], [0, 0, 0])", (74, 0)),
        ("last angle beyond a turn",     vec![],          "MCT(L1, L2, T, [0, 0, -361], [0, 0, 0])", (74, 2)),
        ("out of the plane",             vec![],          "MCT(FLAT1, FLAT2, T, [0, 90, 0], [0, 0, 0])", (74, 1)),
        ("off the plane",                vec![],          "MCT(FLAT1, FLAT2, T, [0, 0, 90], [0, 0, 1])", (13, 4)),
        ("the same system",              vec![],          "MCT(L1, L1, T, [0, 0, 0], [0, 0, 0])", (61, 2)),
        ("an axis in both",              vec![],          "MCT(L1, ACROSS, T, [0, 0, 0], [0, 0, 0])", (61, 7)),
        ("axes of the target in use",    vec![moves("ACROSS")], "MCT(L4, L2, T, [0, 0, 0], [0, 0, 0])", (61, 8)),
        ("dimensions that differ",       vec![],          "MCT(L1, FLAT2, T, [0, 0, 0], [0, 0, 0])", (61, 17)),
        ("a rotary axis",                vec![],          "MCT(ROUND, L2, T, [0, 0, 0], [0, 0, 0])", (70, 1)),
        ("a rotary axis of the target",  vec![],          "MCT(L2, ROUND, T, [0, 0, 0], [0, 0, 0])", (70, 1)),
        ("a source axis shut down",      vec!["MASD(B1, M)".into()], "MCT(L1, L2, T, [0, 0, 0], [0, 0, 0])", (7, 1)),
        ("a target axis shut down",      vec!["MASD(C2, M)".into()], "MCT(L1, L2, T, [0, 0, 0], [0, 0, 0])", (7, 2)),
        ("a servo that is off",          vec!["MSF(R, M)".into()], "MCT(L1, SERVO, T, [0, 0, 0], [0, 0, 0])", (5, 2)),
        ("the same pair again",          vec![link.clone()], "MCT(L1, L2, T, [0, 0, 90], [0, 0, 0])", (62, 0)),
        ("a second source",              vec![link.clone()], "MCT(L3, L2, T, [0, 0, 0], [0, 0, 0])", (73, 0)),
        ("a second source of one axis",  vec![link.clone()], "MCT(L4, ACROSS, T, [0, 0, 0], [0, 0, 0])", (73, 0)),
        ("against each other",           vec![link.clone()], "MCT(L2, L1, T, [0, 0, 0], [0, 0, 0])", (73, 0)),
        ("in a circle",                  vec![link.clone(), format!("MCT(L2, L3, T2, {NO_TURN})")],
                                                          "MCT(L3, L1, T, [0, 0, 0], [0, 0, 0])", (73, 0)),
        ("the source moves",             vec![moves("L1")], "MCT(L1, L2, T, [0, 0, 0], [0, 0, 0])", (22, 0)),
        ("an axis of the target moves",  vec![format!("MAM(C2, M, 0, 50, {TRAPEZOID})")],
                                                          "MCT(L1, L2, T, [0, 0, 0], [0, 0, 0])", (22, 2)),
        ("the target is led",            vec![link.clone(), moves("L1")], "MCT(L2, L3, T, [0, 0, 0], [0, 0, 0])", (22, 0)),
        ("no group of its own to link",  vec![], "MCT(L1, L2, T, [0, 0, 0], [0, 0, 0])", OK),
    ];
    for (why, before, call, expected) in cases {
        let mut bench = bench();
        for call in &before {
            assert_eq!(bench.call(call), OK, "{why}: {call}");
            bench.run(5);
        }
        if !before.is_empty() {
            bench.run(50);
        }
        assert_eq!(bench.call(call), expected, "{why}: {call}");
        let bits = if expected == OK { "EN DN IP" } else { "EN ER" };
        assert_eq!(bench.bits("T"), bits, "{why}");
    }
    // Every stop of a transform must be possible.
    let weak = machine(1.0).replacen(
        "axes = [\"A2\", \"B2\", \"C2\"]\nmax_speed = 500.0\nmax_acceleration = 5000.0\nmax_deceleration = 2000.0",
        "axes = [\"A2\", \"B2\", \"C2\"]\nmax_speed = 500.0\nmax_acceleration = 5000.0\nmax_deceleration = 0.0",
        1,
    );
    assert_eq!(Bench::with(&weak).call(&link), (54, -1));
}

#[test]
fn the_target_leads_the_source_back() {
    // A quarter turn: the target's second axis is against the source's first.
    let mut bench = bench();
    assert_eq!(bench.call("MCT(L1, L2, T, [0, 0, 90], [0, 0, 0])"), OK);
    assert_eq!(bench.call(&format!("MAM(B2, M, 1, 30, {S_CURVE})")), OK);
    bench.run(100);
    let [b2, a1] = velocities(&bench, ["B2", "A1"]);
    assert!(b2 > 10.0 && a1 == -b2, "{b2} {a1}");
    assert!(axis_bit(&bench, "A1", motion_status::CONTROLLED_BY_TRANSFORM_STATUS));
    assert!(!axis_bit(&bench, "B2", motion_status::CONTROLLED_BY_TRANSFORM_STATUS));
    bench.until("M", Flag::Pc);
    assert_eq!(positions(&bench, ["A2", "B2", "C2"]), [0.0, 30.0, 0.0]);
    assert_eq!(positions(&bench, ["A1", "B1", "C1"]), [-30.0, 0.0, 0.0]);
    bench.tick();
    assert!(!axis_bit(&bench, "A1", motion_status::CONTROLLED_BY_TRANSFORM_STATUS));

    // Both move: increments add up, and both sides are at the same point at every update.
    let mut bench = self::bench();
    assert_eq!(bench.call(&format!("MCT(L1, L2, T, {NO_TURN})")), OK);
    assert_eq!(bench.call(&format!("MCLM(L1, M1, 0, [50, 20, 10], {S_CURVE}, 1)")), OK);
    bench.run(70);
    assert_eq!(bench.call(&format!("MAM(A2, M2, 1, 25, {TRAPEZOID})")), OK);
    assert_eq!(bench.call(&format!("MAM(A1, M3, 1, -8, {TRAPEZOID})")), OK);
    for _ in 0..800 {
        bench.tick();
        near(
            positions(&bench, ["A2", "B2", "C2"]),
            positions(&bench, ["A1", "B1", "C1"]),
            "one point",
        );
        near(
            velocities(&bench, ["A2", "B2"]),
            velocities(&bench, ["A1", "B1"]),
            "one velocity",
        );
    }
    near(positions(&bench, ["A1", "B1", "C1"]), [67.0, 20.0, 10.0], "50 + 25 - 8");
    for tag in ["M1", "M2", "M3"] {
        assert_eq!(bench.bits(tag), "EN DN PC", "{tag}");
    }
}

#[test]
fn one_source_leads_several_targets_and_any_of_them_leads_all_back() {
    let mut bench = bench();
    assert_eq!(bench.call(&format!("MCT(L1, L2, T1, {NO_TURN})")), OK);
    assert_eq!(bench.call("MCT(L1, L3, T2, [0, 0, 180], [0, 0, 0])"), OK);
    assert_eq!(bench.call(&format!("MCLM(L1, M1, 0, [40, 30, 0], {S_CURVE}, 1)")), OK);
    assert_eq!(bench.call(&format!("MAM(A3, M2, 1, 5, {S_CURVE})")), OK);
    for _ in 0..900 {
        bench.tick();
        let [a1, b1] = positions(&bench, ["A1", "B1"]);
        near(positions(&bench, ["A2", "B2"]), [a1, b1], "first");
        near(positions(&bench, ["A3", "B3"]), [-a1, -b1], "second");
    }
    near(positions(&bench, ["A1", "A2", "A3"]), [35.0, 35.0, -35.0], "40 - 5");
}

/// L1 leads L2 leads L3 leads L4.
fn chain() -> Bench {
    let mut bench = bench();
    for (tag, call) in [
        ("T1", "MCT(L1, L2, T1, [0, 0, 90], [0, 0, 0])"),
        ("T2", "MCT(L2, L3, T2, [0, 0, -90], [0, 0, 0])"),
        ("T3", "MCT(L3, L4, T3, [0, 0, 0], [0, 0, 0])"),
    ] {
        assert_eq!(bench.call(call), OK, "{tag}");
    }
    bench
}

#[test]
fn a_chain_is_at_one_point_within_every_update() {
    let mut bench = chain();
    assert_eq!(bench.call(&format!("MCLM(L1, M1, 0, [60, 20, 10], {S_CURVE}, 1)")), OK);
    assert_eq!(bench.call(&format!("MAM(B3, M2, 1, 5, {S_CURVE})")), OK);
    assert_eq!(bench.call(&format!("MCLM(L4, M3, 1, [0, 0, 3], {S_CURVE}, 1)")), OK);
    for _ in 0..1200 {
        bench.tick();
        let [a1, b1, c1] = positions(&bench, ["A1", "B1", "C1"]);
        near(positions(&bench, ["A2", "B2", "C2"]), [b1, -a1, c1], "first link");
        near(positions(&bench, ["A3", "B3", "C3"]), [a1, b1, c1], "second link");
        near(positions(&bench, ["A4", "B4", "C4"]), [a1, b1, c1], "third link");
    }
    near(
        positions(&bench, ["A1", "B1", "C1"]),
        [60.0, 25.0, 13.0],
        "all motions add up",
    );
    assert_eq!(bench.bits("M3"), "EN DN PC");
}

#[test]
fn a_stop_of_transforms_in_a_chain_stops_the_motion_of_their_targets() {
    // spec/coordinated-instructions.md §15.4: T1 and T2 are cancelled, T3 stays; L1 goes on, L2 and L3 stop, L4 follows L3.
    for shape in [TRAPEZOID, S_CURVE] {
        let mut bench = chain();
        assert_eq!(bench.call(&format!("MCLM(L1, M1, 0, [600, 200, 100], {shape}, 1)")), OK);
        bench.run(800);
        assert_eq!(
            bench.call("MCS(L2, S, CoordinatedTransform, Yes, 500, 0, No, 0, 0)"),
            OK
        );
        assert_eq!(bench.bits("T1"), "EN DN");
        assert_eq!(bench.bits("T2"), "EN DN");
        let mut before = velocities(&bench, ["A2", "B2", "A3", "B3", "A4", "B4"]);
        let took = {
            let from = bench.now();
            while !bench.control("S").has(Flag::Pc) {
                bench.tick();
                let now = velocities(&bench, ["A2", "B2", "A3", "B3", "A4", "B4"]);
                for (was, is) in before.iter().zip(now) {
                    assert!((was - is).abs() <= 0.5 + 1e-9, "500 units/s²: {was} to {is}");
                }
                before = now;
                near(
                    positions(&bench, ["A4", "B4", "C4"]),
                    positions(&bench, ["A3", "B3", "C3"]),
                    "T3",
                );
            }
            bench.now() - from
        };
        // Speed along A: 100 · 600 / √(600² + 200² + 100²).
        let least = 100.0 * 600.0 / 410_000.0_f64.sqrt() / 500.0;
        assert!(took as f64 * 1e-3 >= least, "{took} ms is below {least} s");
        assert_eq!(bench.bits("T3"), "EN DN IP");
        assert_eq!(bench.bits("M1"), "EN DN IP AC");
        near(
            velocities(&bench, ["A2", "B2", "A3", "B3", "A4", "B4"]),
            [0.0; 6],
            "stopped",
        );
        assert!(bench.axis("A1").command[1] > 90.0);
        // The rest of the chain is one still.
        assert_eq!(bench.call(&format!("MAM(C3, M4, 1, 12, {shape})")), OK);
        bench.until("M4", Flag::Pc);
        near(positions(&bench, ["C4"]), positions(&bench, ["C3"]), "T3 still leads");
        assert!(!axis_bit(&bench, "C2", motion_status::TRANSFORM_STATE_STATUS));
    }
}

#[test]
fn bits_of_a_transform_at_rest_in_motion_and_cancelled() {
    let mut bench = bench();
    let state = motion_status::TRANSFORM_STATE_STATUS;
    let controlled = motion_status::CONTROLLED_BY_TRANSFORM_STATUS;
    let source = coordinate_motion_status::TRANSFORM_SOURCE_STATUS;
    let target = coordinate_motion_status::TRANSFORM_TARGET_STATUS;
    assert!(!axis_bit(&bench, "A1", state) && !system_bit(&bench, "L1", source));
    bench.call(&format!("MCT(L1, L2, T, {NO_TURN})"));
    for axis in ["A1", "B1", "C1", "A2", "B2", "C2"] {
        assert!(
            axis_bit(&bench, axis, state) && !axis_bit(&bench, axis, controlled),
            "{axis}"
        );
    }
    assert!(!axis_bit(&bench, "A3", state));
    assert!(system_bit(&bench, "L1", source) && !system_bit(&bench, "L1", target));
    assert!(system_bit(&bench, "L2", target) && !system_bit(&bench, "L2", source));
    bench.run(3);
    bench.call(&format!("MAM(B1, M, 1, 1, {TRAPEZOID})"));
    bench.tick();
    assert!(axis_bit(&bench, "A2", controlled) && axis_bit(&bench, "B2", controlled));
    assert!(!axis_bit(&bench, "B1", controlled), "nothing leads the source");
    bench.until("M", Flag::Pc);
    bench.tick();
    assert!(!axis_bit(&bench, "B2", controlled) && axis_bit(&bench, "B2", state));
    // A stop of coordinated moves leaves the transform, and its target is controlled until the axes stand.
    bench.call(&format!("MCLM(L1, M2, 0, [900, 0, 0], {TRAPEZOID}, 1)"));
    bench.run(300);
    bench.call("MCS(L1, S, CoordinatedMove, No, 0, 0, No, 0, 0)");
    bench.run(20);
    assert!(axis_bit(&bench, "A2", controlled));
    bench.until("S", Flag::Pc);
    bench.tick();
    assert!(!axis_bit(&bench, "A2", controlled) && axis_bit(&bench, "A2", state));
    assert_eq!(bench.bits("T"), "EN DN IP");
    bench.call("MCS(L2, S2, CoordinatedTransform, No, 0, 0, No, 0, 0)");
    bench.tick();
    for axis in ["A1", "B1", "C1", "A2", "B2", "C2"] {
        assert!(
            !axis_bit(&bench, axis, state) && !axis_bit(&bench, axis, controlled),
            "{axis}"
        );
    }
    assert!(!system_bit(&bench, "L1", source) && !system_bit(&bench, "L2", target));
    assert_eq!((bench.bits("T"), bench.bits("S2")), ("EN DN".into(), "EN DN PC".into()));
}

#[test]
fn instructions_that_cancel_a_transform_and_those_that_do_not() {
    #[rustfmt::skip]
    let cases = [
        // why,                             call,                                                 cancelled
        ("a stop of all of the source",     "MCS(SERVO, S, All, No, 0, 0, No, 0, 0)",             true),
        ("a stop of all of the target",     "MCS(L2, S, All, No, 0, 0, No, 0, 0)",                true),
        ("a stop of all that shares an axis", "MCS(FLAT2, S, All, No, 0, 0, No, 0, 0)",           true),
        ("a stop of all elsewhere",         "MCS(L1, S, All, No, 0, 0, No, 0, 0)",                false),
        ("a stop of the source's transforms", "MCS(SERVO, S, CoordinatedTransform, No, 0, 0, No, 0, 0)", true),
        ("a stop of the target's transforms", "MCS(L2, S, CoordinatedTransform, No, 0, 0, No, 0, 0)", true),
        ("a stop of transforms that only shares an axis", "MCS(ACROSS, S, CoordinatedTransform, No, 0, 0, No, 0, 0)", false),
        ("a stop of coordinated moves",     "MCS(SERVO, S, CoordinatedMove, No, 0, 0, No, 0, 0)", false),
        ("a stop of a source axis",         "MAS(Q, S, All, No, 0, 0, No, 0, 0)",                 true),
        ("a stop of a target axis",         "MAS(C2, S, All, No, 0, 0, No, 0, 0)",                true),
        ("a stop of a move of a target axis", "MAS(C2, S, Move, No, 0, 0, No, 0, 0)",             false),
        ("a stop of another axis",          "MAS(C1, S, All, No, 0, 0, No, 0, 0)",                false),
        ("servo off",                       "MSF(P, S)",                                          true),
        ("shutdown of a source axis",       "MASD(R, S)",                                         true),
        ("shutdown of a target axis",       "MASD(A2, S)",                                        true),
        ("shutdown of the source",          "MCSD(SERVO, S)",                                     true),
        ("shutdown of the target",          "MCSD(L2, S)",                                        true),
        ("a stop of the group",             "MGS(Motion, S, 1)",                                  true),
        ("shutdown of the group",           "MGSD(Motion, S)",                                    true),
    ];
    for moving in [false, true] {
        for (why, call, cancelled) in cases {
            let why = format!("{why}, {}", if moving { "moving" } else { "at rest" });
            let mut bench = bench();
            assert_eq!(bench.call(&format!("MCT(SERVO, L2, T, {NO_TURN})")), OK);
            if moving {
                assert_eq!(
                    bench.call(&format!("MCLM(SERVO, M, 0, [500, 300, 400], {S_CURVE}, 1)")),
                    OK
                );
                bench.run(700);
            }
            assert_eq!(bench.call(call), OK, "{why}");
            assert_eq!(bench.control("T").has(Flag::Ip), !cancelled, "{why}");
            assert!(!bench.control("T").has(Flag::Pc), "{why}");
            assert_eq!(
                axis_bit(&bench, "B2", motion_status::TRANSFORM_STATE_STATUS),
                !cancelled,
                "{why}"
            );
            // No axis with torque jumps.
            let mut last = velocities(&bench, ["A2", "B2", "C2"]);
            for _ in 0..400 {
                bench.tick();
                let now = velocities(&bench, ["A2", "B2", "C2"]);
                let step = last
                    .iter()
                    .zip(now)
                    .map(|(was, is)| (was - is).abs())
                    .fold(0.0, f64::max);
                assert!(step <= 4.0 + 1e-9, "{why}: {last:?} to {now:?}");
                last = now;
            }
            if cancelled {
                assert_eq!(last, [0.0; 3], "{why}");
            }
        }
    }
}

#[test]
fn redefinitions_and_homing_of_transformed_axes_are_refused() {
    let mut bench = bench();
    assert_eq!(bench.call(&format!("MCT(SERVO, L2, T, {NO_TURN})")), OK);
    for call in [
        "MRP(P, R, Relative, Command, 5)",
        "MRP(B2, R, Absolute, Actual, 5)",
        "MAH(Q, H)",
        "MAH(A2, H)",
    ] {
        assert_eq!(bench.call(call), (63, 0), "{call}");
    }
    assert_eq!(bench.call("MCS(L2, S, CoordinatedTransform, No, 0, 0, No, 0, 0)"), OK);
    assert_eq!(bench.call("MRP(P, R, Relative, Command, 5)"), OK);
}

#[test]
fn a_cancelled_transform_must_stand_before_the_next_one() {
    for (stop, moving_on) in [
        ("MCS(L2, S, CoordinatedTransform, Yes, 400, 0, No, 0, 0)", true),
        ("MCS(L1, S, All, Yes, 400, 0, No, 0, 0)", false),
    ] {
        let mut bench = bench();
        assert_eq!(bench.call(&format!("MCT(L1, L2, T, {NO_TURN})")), OK);
        assert_eq!(bench.call(&format!("MCLM(L1, M, 0, [900, 0, 0], {TRAPEZOID}, 1)")), OK);
        bench.run(500);
        assert_eq!(bench.call(stop), OK);
        bench.run(5);
        assert_eq!(bench.call(&format!("MCT(L1, L2, T2, {NO_TURN})")), (71, 0), "{stop}");
        bench.until("S", Flag::Pc);
        bench.run(2);
        let then = if moving_on { (22, 0) } else { OK };
        assert_eq!(bench.call(&format!("MCT(L1, L2, T3, {NO_TURN})")), then, "{stop}");
    }
}

#[test]
fn a_target_with_feedback_brakes_together_with_its_source() {
    // The target's own jog-like move leads the source; without the transform the source brakes, the target goes on.
    let mut bench = bench();
    assert_eq!(bench.call(&format!("MCT(L1, L2, T, {NO_TURN})")), OK);
    assert_eq!(bench.call(&format!("MAM(A2, M, 1, 500, {TRAPEZOID})")), OK);
    bench.run(400);
    assert_eq!(velocities(&bench, ["A1", "A2"]), [100.0, 100.0]);
    assert_eq!(
        bench.call("MCS(L1, S, CoordinatedTransform, Yes, 500, 0, No, 0, 0)"),
        OK
    );
    bench.run(100);
    near(
        velocities(&bench, ["A1", "A2"]),
        [50.0, 100.0],
        "500 units/s² for 0.1 s",
    );
    bench.until("S", Flag::Pc);
    assert_eq!(velocities(&bench, ["A1", "A2"]), [0.0, 100.0]);
    bench.until("M", Flag::Pc);
    assert_eq!(bench.position("A2"), 500.0);
}

#[test]
fn stops_supersede_each_other() {
    let start = |shape: &str| {
        let mut bench = bench();
        assert_eq!(bench.call(&format!("MCT(L1, L2, T, {NO_TURN})")), OK);
        assert_eq!(bench.call(&format!("MCLM(L1, M, 0, [900, 0, 0], {shape}, 1)")), OK);
        assert_eq!(bench.call(&format!("MAM(B1, MB, 1, 900, {shape})")), OK);
        bench.run(500);
        bench
    };
    // A stronger one takes over: the move brakes with the system's maximum from then on, B1's own motion with the axis's.
    let mut bench = start(TRAPEZOID);
    assert_eq!(bench.call("MCS(L1, S1, CoordinatedMove, Yes, 200, 0, No, 0, 0)"), OK);
    bench.run(20);
    near(
        velocities(&bench, ["A1", "B1", "A2"]),
        [96.0, 100.0, 96.0],
        "along the path",
    );
    assert_eq!(bench.call("MCS(L1, S2, All, No, 0, 0, No, 0, 0)"), OK);
    assert_eq!(
        (bench.bits("S1"), bench.bits("S2")),
        ("EN DN".into(), "EN DN IP".into())
    );
    bench.run(10);
    // The move of L1 and its followers at the 2000 units/s² of the system, B1 at its own 4000 units/s².
    near(
        velocities(&bench, ["A1", "B1", "A2"]),
        [76.0, 60.0, 76.0],
        "by themselves",
    );
    bench.until("S2", Flag::Pc);
    assert_eq!(velocities(&bench, ["A1", "B1", "A2", "B2"]), [0.0; 4]);

    // A weaker one takes the bits; the stop of all goes on to rest, and the weaker one reports it.
    for weaker in ["CoordinatedMove", "CoordinatedTransform"] {
        let mut bench = start(S_CURVE);
        assert_eq!(bench.call("MCS(L1, S1, All, No, 0, 0, No, 0, 0)"), OK);
        bench.run(5);
        assert_eq!(bench.call(&format!("MCS(L1, S2, {weaker}, No, 0, 0, No, 0, 0)")), OK);
        assert_eq!(
            (bench.bits("S1"), bench.bits("S2")),
            ("EN DN".into(), "EN DN IP".into())
        );
        bench.run(2);
        assert!(bench.axis("B1").command[1] > 1.0, "{weaker}: it has not stopped yet");
        assert_eq!(bench.bits("S2"), "EN DN IP", "{weaker}");
        bench.until("S2", Flag::Pc);
        assert_eq!(velocities(&bench, ["A1", "B1", "A2", "B2"]), [0.0; 4], "{weaker}");
    }

    // A stop of transforms during one of the move: both go on to their ends.
    let mut bench = start(TRAPEZOID);
    assert_eq!(bench.call("MCS(L1, S1, CoordinatedMove, Yes, 200, 0, No, 0, 0)"), OK);
    bench.run(20);
    assert_eq!(bench.call("MCS(L1, S2, CoordinatedTransform, No, 0, 0, No, 0, 0)"), OK);
    assert_eq!(
        bench.call(&format!("MCLM(L1, M2, 1, [5, 0, 0], {TRAPEZOID}, 1)")),
        (78, 0),
        "the move still stops"
    );
    bench.run(100);
    near(
        velocities(&bench, ["A1", "A2"]),
        [76.0, 0.0],
        "the move stops along its path",
    );
    bench.until("S2", Flag::Pc);
    assert_eq!(velocities(&bench, ["A1", "B1"]), [0.0, 100.0]);

    // A stop of transforms alone does not keep other axes from moving.
    let mut bench = start(TRAPEZOID);
    assert_eq!(
        bench.call("MCS(L1, S1, CoordinatedTransform, Yes, 50, 0, No, 0, 0)"),
        OK
    );
    bench.run(5);
    assert_eq!(bench.call(&format!("MCLM(L1, M2, 1, [5, 0, 0], {TRAPEZOID}, 1)")), OK);
    assert_eq!(bench.bits("S1"), "EN DN IP");
}

#[test]
fn a_stop_near_the_end_comes_to_rest_beyond_it() {
    // 100 units/s and 1000 units/s²: 5 units to brake. Stopped 4 units before the end at a quarter of the rate, the axes
    // go 100 · 100 / (2 · 250) = 20 units minus the distance already braked, and stay there.
    let mut bench = bench();
    assert_eq!(bench.call(&format!("MCT(L1, L2, T, {NO_TURN})")), OK);
    assert_eq!(bench.call(&format!("MCLM(L1, M, 0, [100, 0, 0], {TRAPEZOID}, 1)")), OK);
    while bench.position("A1") < 96.0 {
        bench.tick();
    }
    let [from, speed, _] = bench.axis("A1").command;
    assert_eq!(bench.call("MCS(L1, S, CoordinatedMove, Yes, 250, 0, No, 0, 0)"), OK);
    bench.until("S", Flag::Pc);
    let expected = from + speed * speed / 500.0;
    assert!(expected > 105.0);
    near(positions(&bench, ["A1", "A2"]), [expected; 2], "beyond the end");
    bench.run(50);
    near(positions(&bench, ["A1", "A2"]), [expected; 2], "no return");
    assert_eq!(bench.bits("M"), "EN DN");
}

#[test]
fn the_update_period_does_not_show() {
    let run = |period: f64| {
        let mut bench = Bench::with(&machine(period));
        let ticks = |ms: f64| (ms / period).round() as u64;
        let mut seen = Vec::new();
        assert_eq!(bench.call("MCT(L1, L2, T1, [10, 20, 30], [0, 0, 0])"), OK);
        assert_eq!(bench.call("MCT(L2, L3, T2, [0, -40, 5], [0, 0, 0])"), OK);
        assert_eq!(bench.call(&format!("MCLM(L1, M1, 0, [60, 20, 10], {S_CURVE}, 3)")), OK);
        assert_eq!(bench.call(&format!("MCLM(L1, M2, 0, [0, 90, 10], {S_CURVE}, 1)")), OK);
        assert_eq!(bench.call(&format!("MAM(A2, M3, 1, 15, {S_CURVE})")), OK);
        for step in 0..300 {
            if step == 150 {
                assert_eq!(bench.call("MCS(L3, S, CoordinatedTransform, No, 0, 0, No, 0, 0)"), OK);
            }
            bench.run(ticks(8.0));
            seen.push(positions(
                &bench,
                ["A1", "B1", "C1", "A2", "B2", "C2", "A3", "B3", "C3"],
            ));
        }
        seen
    };
    let [fine, plain, coarse] = [0.25, 1.0, 4.0].map(run);
    for (place, expected) in fine.into_iter().enumerate() {
        near(plain[place], expected, "1 ms");
        near(coarse[place], expected, "4 ms");
    }
}
