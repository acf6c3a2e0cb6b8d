//! Merges of both types at both speeds, into lines and arcs, with motion of single axes on top
//! (spec/coordinated-instructions.md §6.2 to §6.4).

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};

#[test]
fn both_types_take_over_at_both_speeds() {
    // XY moves along X at 200, and Y also jogs at 50; the merging move is programmed with 120.
    let present = 200.0_f64.hypot(50.0);
    #[rustfmt::skip]
    let ways = [
        ("a line", "MCLM(XY, M3, 0, [500, 300], 120, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1"),
        ("an arc", "MCCM(XY, M3, 1, [-300, 0], Center, [-150, 0], 1, 120, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1"),
    ];
    for (why, call) in ways {
        for (merge, jogs_on) in [("CoordinatedMotion", true), ("AllMotion", false)] {
            for (speed, expected) in [("Programmed", 120.0), ("Current", present)] {
                let row = format!("{why}, {merge}, {speed}");
                let mut bench = Bench::new();
                assert_eq!(bench.call("MAJ(Y, J, 0, 50, 0, 2000, 0, 2000, 0, 1, 100, 100, 2)"), OK);
                bench.execute("MCLM(XY, M1, 0, [500, 0], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1)");
                bench.execute("MCLM(XY, M2, 0, [0, 0], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1)");
                bench.run(500);
                assert_eq!(bench.call(&format!("{call}, {merge}, {speed})")), OK, "{row}");
                assert_eq!(
                    (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
                    ("EN DN", "EN DN"),
                    "{row}"
                );
                assert_eq!(bench.control("J").has(Flag::Ip), jogs_on, "{row}");
                assert!(!bench.control("J").has(Flag::Pc), "{row}");
                let mut top = 0.0_f64;
                let mut last = ["X", "Y"].map(|axis| bench.axis(axis).command);
                let end = bench.position("X") - 300.0;
                let mut ticks = 0;
                while !bench.control("M3").has(Flag::Pc) {
                    bench.tick();
                    ticks += 1;
                    // The motion along the new path is its beginning, and slows down first.
                    let fast = bench.system("XY").path_speed;
                    // The speed of the path and of its residual together.
                    assert!(fast <= present * 1.25, "{row}: {fast}");
                    if ticks > 250 {
                        top = top.max(fast);
                    }
                    let now = ["X", "Y"].map(|axis| bench.axis(axis).command);
                    for (before, after) in last.iter().zip(now) {
                        // The old and the new rate, and the centripetal acceleration of an arc of 150.
                        let most = (2.0 * 2000.0 + expected * expected / 150.0) * 0.001 * 1.01;
                        assert!(
                            (after[1] - before[1]).abs() <= most,
                            "{row}: {} to {}",
                            before[1],
                            after[1]
                        );
                    }
                    last = now;
                }
                // A little less if the speed of the residual adds to that of the path.
                assert!(
                    top <= expected + 1e-6 && top > 0.95 * expected,
                    "{row}: {top}, not {expected}"
                );
                let x = if why == "an arc" { end } else { 500.0 };
                assert!(
                    (bench.position("X") - x).abs() < 1e-9,
                    "{row}: ends at {}",
                    bench.position("X")
                );
                assert_eq!(bench.axis("Y").command[1], if jogs_on { 50.0 } else { 0.0 }, "{row}");
            }
        }
    }
}
