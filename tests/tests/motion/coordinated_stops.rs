//! The rates of MCS All for each kind of motion, the bits that last until rest, and the bits of a coordinated move that does not move yet
//! (spec/coordinated-instructions.md §10, §15.1, §15.3; the MCS and MCCM seeds).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::{coordinate_motion_status, coordinate_system_status, motion_status};
use arcline_tests::bench::{Bench, OK};

const LINE: &str = "MCLM(XY, M1, 0, [500, 0], 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1)";
const CURVE: &str = "MCLM(XY, M1, 0, [500, 0], 100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2, 1)";
const MOVE: &str = "MAM(Y, M2, 1, 500, 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2)";

/// Maximum Deceleration of XY is 5,000 units/s², that of each axis 10,000.
#[test]
fn a_stop_of_all_brakes_coordinated_motion_with_its_own_rate() {
    #[rustfmt::skip]
    let cases = [
        // why,                        began,            stop,                                    ms
        ("the rate",                   &[LINE][..],      "MCS(XY, S, 0, 1, 200, 0, 1, 100, 2)",   500),
        ("a share of the maximum",     &[LINE],          "MCS(XY, S, 0, 1, 10, 1, 0, 100, 2)",    200),
        ("the system's maximum",       &[LINE],          "MCS(XY, S, 0, 0, 200, 0, 0, 100, 2)",   20),
        ("rate and jerk of a curve",   &[CURVE],         "MCS(XY, S, 0, 1, 200, 0, 1, 100, 2)",   1000),
        ("the axis's own maximum",     &[MOVE],          "MCS(XY, S, 0, 1, 200, 0, 1, 100, 2)",   10),
        ("both together",              &[LINE, MOVE],    "MCS(XY, S, 0, 1, 200, 0, 1, 100, 2)",   500),
        ("a system that shares axes",  &[LINE],          "MCS(CS1, S, 0, 1, 200, 0, 1, 100, 2)",  500),
        ("a gentler one of that kind", &[LINE],          "MCS(XY, S, 2, 1, 200, 0, 1, 100, 2)",   500),
    ];
    for (why, began, stop, expected) in cases {
        let mut bench = Bench::new();
        for call in began {
            assert_eq!(bench.call(call), OK, "{why}");
        }
        bench.run(1000);
        assert_eq!(bench.call(stop), OK, "{why}");
        let mut before = [bench.axis("X").command[1], bench.axis("Y").command[1]];
        let from = bench.now();
        while !bench.control("S").has(Flag::Pc) {
            bench.tick();
            assert!(bench.now() < from + 2000, "{why}: it never stands");
            let now = [bench.axis("X").command[1], bench.axis("Y").command[1]];
            for axis in 0..2 {
                assert!((now[axis] - before[axis]).abs() < 10.001, "{why}: a step of speed");
                assert!(now[axis] >= -1e-9, "{why}: it turns back");
            }
            before = now;
        }
        let took = bench.now() - from;
        assert!(took.abs_diff(expected) <= 2, "{why}: {took} ms");
        assert!(
            !bench.control("M1").has(Flag::Pc) && !bench.control("M2").has(Flag::Pc),
            "{why}"
        );
    }
}

/// An axis with a weak brake, so that a stop lasts.
fn slow() -> Bench {
    Bench::with(&arcline_config::DEFAULT.replace("max_deceleration = 10000.0", "max_deceleration = 200.0"))
}

#[test]
fn coordinated_motion_is_shown_until_the_axes_stand() {
    for stop in [
        "MCS(XY, S, 0, 0, 100, 0, 0, 100, 2)",
        "MCS(XY, S, 2, 1, 200, 0, 0, 100, 2)",
        "MGS(Motion, S, 1)",
        "MAS(X, S, 0, 0, 100, 0, 0, 100, 2)",
    ] {
        let mut bench = slow();
        assert_eq!(bench.call(LINE), OK);
        bench.run(1000);
        assert_eq!(bench.call(stop), OK, "{stop}");
        let mut braked = 0;
        loop {
            bench.tick();
            let moves = bench.axis("X").command[1] != 0.0;
            let coordinated = bench.axis("X").motion_status & motion_status::COORDINATED_MOTION_STATUS != 0;
            let shown = bench.system("XY").status & coordinate_system_status::MOTION_STATUS != 0;
            let move_status = bench.system("XY").motion_status & coordinate_motion_status::MOVE_STATUS != 0;
            assert!(!move_status, "{stop}");
            if !moves {
                assert!(!coordinated && !shown, "{stop}: at rest");
                break;
            }
            braked += 1;
            assert!(coordinated && shown, "{stop}: after {braked} ms");
        }
        assert!(braked > 15, "{stop}: {braked} ms");
        bench.tick();
        assert_eq!(bench.bits("S"), "EN DN PC", "{stop}");
    }
}

#[test]
fn a_move_that_moves_nothing_is_active_but_does_not_move() {
    let shown = |bench: &Bench| {
        let system = bench.system("XY");
        (
            system.status & coordinate_system_status::MOTION_STATUS != 0,
            system.motion_status & coordinate_motion_status::MOVE_STATUS != 0,
        )
    };
    let mut bench = Bench::new();
    assert_eq!(
        bench.call("MCLM(XY, M, 0, [50, 0], 0, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1)"),
        OK
    );
    bench.run(50);
    assert_eq!(shown(&bench), (true, false), "Speed 0");
    assert_eq!(
        bench.call("MCCD(XY, C, 1, 1, 50, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0)"),
        OK
    );
    bench.run(50);
    assert_eq!(shown(&bench), (true, true), "it moves");
    assert_eq!(
        bench.call("MCCD(XY, C, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0)"),
        OK
    );
    bench.run(500);
    assert_eq!(shown(&bench), (true, true), "a pause on the way");

    let mut bench = Bench::new();
    assert_eq!(bench.call("MDCC(XY, A, D, 1, 0)"), OK);
    let waits = "MCLM(XY, M, 0, [40, 0], 2, 4, 1, 4, 1, 4, 0, 100, 100, 6, 1, 0, 0, 0, 10, 3)";
    assert_eq!(bench.call(waits), OK);
    bench.run(50);
    assert_eq!(shown(&bench), (true, false), "it waits for its lock");
    assert_eq!(
        bench.call("MAM(A, Master, 1, 50, 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2)"),
        OK
    );
    bench.run(50);
    assert_eq!(shown(&bench), (true, false), "the master is not there yet");
    bench.run(150);
    assert_eq!(shown(&bench), (true, true), "locked");
}

#[test]
fn a_change_of_dynamics_reports_the_axes_before_missing_motion() {
    let change = "MCCD(XY, C, 1, 1, 50, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0)";
    assert_eq!(Bench::new().call(change), (23, 0));
    let mut bench =
        Bench::with(&arcline_config::DEFAULT.replace("max_deceleration = 10000.0", "max_deceleration = 0.0"));
    assert_eq!(bench.call(change), (54, 0));
}
