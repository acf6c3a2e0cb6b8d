//! Single-axis motion, alone and superimposed on coordinated motion (spec/axis-and-data-types.md §1.6, §3).

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};

/// Speed, rates and profile of every move here: a trapezoid at 100 units/s.
const RATES: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";

#[test]
fn a_move_ends_exactly_and_reports_once() {
    let mut bench = Bench::new();
    assert_eq!(bench.call(&format!("MAM(X, M1, 0, 33.3, {RATES})")), OK);
    assert_eq!(bench.bits("M1"), "EN DN IP");
    bench.tick();
    assert_eq!(bench.bits("M1"), "EN DN IP ACCEL");
    // 33.3 / 100 + 100 / 1000 seconds, and the tick that reports.
    assert_eq!(bench.until("M1", Flag::Pc), 433 - 1);
    assert_eq!(bench.bits("M1"), "EN DN PC");
    assert_eq!(bench.axis("X").command, [33.3, 0.0, 0.0]);
}

#[test]
fn a_move_is_superimposed_on_coordinated_motion_and_both_end_exactly() {
    let mut bench = Bench::new();
    let dynamics = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1";
    assert_eq!(bench.call(&format!("MCLM(CS1, M1, 0, [100, 50, 0], {dynamics})")), OK);
    bench.run(200);
    assert_eq!(bench.call(&format!("MAM(X, M2, 1, 7, {RATES})")), OK);
    bench.run(50);
    let (x, y) = (bench.axis("X"), bench.axis("Y"));
    assert!((x.command[1] - (2.0 * y.command[1] + 50.0)).abs() < 1e-9, "{x:?} {y:?}");
    bench.until_rest();
    assert_eq!(bench.position("X"), 107.0);
    assert_eq!(bench.position("Y"), 50.0);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN PC", "EN DN PC")
    );
}

#[test]
fn a_stop_of_one_kind_leaves_the_other_and_a_stop_of_all_takes_both() {
    let start = || {
        let mut bench = Bench::new();
        let dynamics = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1";
        bench.call(&format!("MCLM(CS2, M1, 0, [1000, 1000, 0], {dynamics})"));
        bench.call(&format!("MAM(Y, M2, 1, 900, {RATES})"));
        bench.call(&format!("MAM(S, M3, 1, 900, {RATES})"));
        bench.run(500);
        bench
    };
    let mut bench = start();
    assert_eq!(bench.call("MAS(Y, S1, Move, No, 100, 0, No, 100, 2)"), OK);
    bench.until("S1", Flag::Pc);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN IP AC", "EN DN")
    );
    assert!((bench.axis("Y").command[1] - bench.axis("X").command[1]).abs() < 1e-9);

    let mut bench = start();
    assert_eq!(bench.call("MAS(Y, S1, All, Yes, 500, 0, No, 100, 2)"), OK);
    bench.until("S1", Flag::Pc);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN", "EN DN")
    );
    assert_eq!(["X", "Y"].map(|axis| bench.axis(axis).command[1]), [0.0, 0.0]);
    assert!((bench.axis("S").command[1] - 100.0).abs() < 1e-9, "MAM on S goes on");
}
