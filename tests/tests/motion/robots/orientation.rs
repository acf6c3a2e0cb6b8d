//! Coordinate systems with orientation: X, Y, Z are a vector as ever, Rx, Ry, Rz stand beside it
//! (spec/coordinated-instructions.md §4.4, §13, §19.4, §23.3).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::motion_status::COORDINATED_MOTION_STATUS;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::robots::{DELTA_J1J2J3J6, DELTA_J1J2J6, SIX_AXES};

const RATES: &str = "50, 0, 500, 0, 500, 0, 0, 100, 100, 2";

#[test]
fn a_linear_move_keeps_the_orientation() {
    let mut bench = SIX_AXES.bench();
    assert_eq!(bench.call(&format!("MAM(RY, A, 0, 20, {RATES})")), OK);
    bench.until("A", Flag::Pc);
    for position in ["[10, 20, 30]", "[30, 40, 50, 7, 8, 9]"] {
        assert_eq!(
            bench.call(&format!("MCLM(CART, M, 0, {position}, {RATES}, 1)")),
            OK,
            "{position}"
        );
        bench.run(5);
        assert_ne!(bench.axis("X").motion_status & COORDINATED_MOTION_STATUS, 0);
        assert_eq!(bench.axis("RY").motion_status & COORDINATED_MOTION_STATUS, 0);
        bench.until("M", Flag::Pc);
        bench.rung_false("M");
    }
    bench.run(2);
    let shown = bench.system("CART");
    assert_eq!(shown.actual, [30.0, 40.0, 50.0, 0.0, 20.0, 0.0]);
    assert_eq!(shown.axes_servo_on, 0x3F);
    assert_eq!(bench.call(&format!("MCLM(CART, M, 0, [1, 2], {RATES}, 1)")), (13, 3));
}

#[test]
fn a_move_of_a_robots_first_joints_keeps_the_others() {
    let mut bench = DELTA_J1J2J3J6.bench();
    assert_eq!(bench.call(&format!("MCLM(ROBOT, M, 1, [1, 2, 3], {RATES}, 1)")), OK);
    bench.until("M", Flag::Pc);
    assert_eq!(
        ["J1", "J2", "J3", "J4"].map(|axis| bench.position(axis)),
        [24.0, 18.0, 25.0, 40.0]
    );
    let mut bench = DELTA_J1J2J6.bench();
    assert_eq!(bench.call(&format!("MCLM(ROBOT, M, 1, [1, 2, 3], {RATES}, 1)")), OK);
    bench.until("M", Flag::Pc);
    assert_eq!(["J1", "J2", "J3"].map(|axis| bench.position(axis)), [24.0, 18.0, 43.0]);
}

#[test]
fn instructions_refused_by_a_system_with_orientation() {
    #[rustfmt::skip]
    let cases = [
        // why,                               call,                                                        status
        ("a circle",                          format!("MCCM(CART, M, 0, [1, 2, 3], 0, [4, 5, 6], 0, {RATES})"), (75, 0)),
        ("MCT from it",                       "MCT(CART, ROBOT, M, [0, 0, 0], [0, 0, 0])".into(),          (61, 5)),
        ("MCT to it",                         "MCT(WORLD, CART, M, [0, 0, 0], [0, 0, 0])".into(),          (61, 6)),
        ("MCT to a robot with a wrist",       "MCT(WORLD, ROBOT, M, [0, 0, 0], [0, 0, 0])".into(),         (61, 6)),
        ("MCTP too",                          "MCTP(CART, ROBOT, M, [0, 0, 0], [0, 0, 0], 0, [0, 0, 0], R9)".into(), (61, 5)),
        ("a stop at a rate of its own",       "MCS(CART, M, 0, Yes, 100, 0)".into(),                       (13, 5)),
        ("a stop at a jerk of its own",       "MCS(CART, M, 0, Yes, 50, 1, Yes, 50, 1)".into(),            (13, 8)),
        ("a stop at shares of the maxima",    "MCS(CART, M, 0, Yes, 50, 1, Yes, 50, 2)".into(),            OK),
        ("a stop as configured",              "MCS(CART, M, 0)".into(),                                    OK),
        ("a stop of a robot",                 "MCS(ROBOT, M, 0, Yes, 100, 0)".into(),                      OK),
    ];
    for (why, call, expected) in cases {
        assert_eq!(SIX_AXES.bench().call(&call), expected, "{why}: {call}");
    }
}

#[test]
fn a_stop_of_all_and_a_shutdown_take_every_axis() {
    let begun = || {
        let mut bench = SIX_AXES.bench();
        assert_eq!(bench.call(&format!("MAM(RZ, A, 0, 200, {RATES})")), OK);
        assert_eq!(bench.call(&format!("MCLM(CART, M, 0, [100, 0, 0], {RATES}, 1)")), OK);
        bench.run(300);
        bench
    };
    let stands = |bench: &Bench| ["X", "RZ"].map(|axis| bench.axis(axis).command[1]) == [0.0; 2];
    let mut bench = begun();
    assert_eq!(bench.call("MCS(CART, S, 2)"), OK, "of the move");
    bench.until("S", Flag::Pc);
    assert_eq!(bench.axis("RZ").command[1], 50.0, "the turn is no part of the move");
    let mut bench = begun();
    assert_eq!(bench.call("MCS(CART, S, 0)"), OK, "of all");
    bench.until("S", Flag::Pc);
    assert!(stands(&bench));
    let mut bench = begun();
    assert_eq!(bench.call("MCSD(CART, S)"), OK);
    bench.run(3);
    assert!(stands(&bench));
    assert_eq!(bench.system("CART").axes_shutdown, 0x3F);
}
