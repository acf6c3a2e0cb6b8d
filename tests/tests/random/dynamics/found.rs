//! Programs that random ones have found, and their kin.

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};

use super::bounds::PERIOD;
use super::on_contours;

/// Calls, each followed by the ticks until the next one.
struct Found {
    calls: &'static [(&'static str, u64)],
    /// The largest change of the velocity of an axis, units/s².
    hardest: f64,
}

const FOUND: [Found; 6] = [
    // A trapezoid that speeds up with a gentle rate and may brake hard, and a merge with an S-curve: its acceleration was taken away
    // slowly, so that the rest of a stop had to be three times as hard as any programmed one.
    Found {
        calls: &[
            (
                "MCLM(XY, M1, 0, [-42.224, 42.305], 69.346, 0, 233.807, 0, 1512.077, 0, 0, 100, 100, 2, 6, 2, 1, 5)",
                88,
            ),
            (
                "MCLM(XY, M2, 1, [9.802, 26.312], 52.809, 0, 174.321, 0, 1770.456, 0, 1, 51.521, 51.521, 2, 3, 1, 0, 5)",
                155,
            ),
        ],
        hardest: 2.5 * 1770.456,
    },
    // The same onto an arc.
    Found {
        calls: &[
            (
                "MCLM(XY, M1, 0, [41.370, 49.599], 46.046, 0, 439.443, 0, 108.122, 0, 1, 73.877, 73.877, 2, 6, 0, 1, 5)",
                224,
            ),
            (
                "MCCD(XY, C2, 1, 1, 108.414, 0, 0, 381.948, 0, 0, 82.399, 0, 0, 0, 0, 0, 0, 1)",
                96,
            ),
            (
                "MCCM(XY, M3, 1, [-106.386, -33.238], 3, [-53.193, -16.619], 0, 181.083, 0, 161.807, 0, 1762.715, 0, 0, 100, 100, 2, 6, 1, 0, 5)",
                238,
            ),
            (
                "MCCM(XY, M4, 1, [29.620, -92.128], 3, [14.810, -46.064], 0, 151.867, 0, 116.996, 0, 3416.243, 0, 1, 74.790, 74.790, 2, 6, 1, 1, 5)",
                148,
            ),
        ],
        hardest: 2.5 * 3416.243,
    },
    // A merge onto a short line, back against a fast motion: the compensation is 15 times as long as the line. A stop braked the line
    // with all of its rate, and so the axes with 16 times as much.
    Found {
        calls: &[
            (
                "MCLM(XY, M2, 1, [54.521, -2.440], 164.596, 0, 445.258, 0, 260.876, 0, 0, 100, 100, 2, 6, 2, 1, 5)",
                103,
            ),
            (
                "MCLM(XY, M3, 1, [29.942, -31.972], 164.596, 0, 445.258, 0, 260.876, 0, 0, 100, 100, 2, 3, 0, 1, 5)",
                205,
            ),
            (
                "MCLM(XY, M4, 0, [19.008, -0.951], 164.596, 0, 445.258, 0, 260.876, 0, 0, 100, 100, 2, 3, 1, 0, 5)",
                144,
            ),
            ("MCS(XY, S5, 2, 1, 1132.322, 0, 1, 100, 2)", 199),
        ],
        hardest: 1132.322 + 260.876,
    },
    // A merge onto a move that brakes gently: its stop had to be three times as hard, and its return from the overshoot speeded up three
    // times as hard as well.
    Found {
        calls: &[
            (
                "MCLM(XY, M2, 1, [-46.952, -11.316], 111.416, 0, 690.114, 0, 172.045, 0, 0, 100, 100, 2, 1, 1, 0, 5)",
                193,
            ),
            (
                "MCLM(XY, M3, 0, [-30.767, -8.979], 134.871, 0, 3255.478, 0, 54.819, 0, 0, 100, 100, 2, 1, 1, 1, 5)",
                800,
            ),
        ],
        hardest: 1.01 * 3255.478,
    },
    // A merge at the end of a stop: the acceleration across its last velocity was removed with the gentle jerk of an acceleration, and the
    // velocity that this gave was braked four times as hard as programmed.
    Found {
        calls: &[
            (
                "MCLM(XY, M1, 1, [19.761, -54.262], 42.107, 0, 119.587, 0, 693.145, 0, 1, 63.170, 63.170, 2, 1, 1, 0, 5)",
                190,
            ),
            (
                "MCLM(XY, M2, 1, [-18.549, 45.784], 42.107, 0, 119.587, 0, 693.145, 0, 1, 63.170, 63.170, 2, 1, 2, 0, 5)",
                189,
            ),
            (
                "MCCM(XY, M3, 1, [74.546, 30.022], 3, [37.273, 15.011], 0, 42.107, 0, 119.587, 0, 693.145, 0, 1, 63.170, 63.170, 2, 0, 2, 1, 5)",
                157,
            ),
        ],
        hardest: 1.5 * 693.145,
    },
    // A merge of an S-curve onto a trapezoid that speeds up: its rates and its jerks rose together until a stop was short enough, though
    // higher jerks alone suffice.
    Found {
        calls: &[
            (
                "MCLM(XY, M1, 0, [-16.688, 2.576], 29.865, 0, 57.779, 0, 54.104, 0, 0, 100, 100, 2, 2, 2, 0, 5)",
                227,
            ),
            (
                "MCLM(XY, M2, 0, [48.130, 38.138], 198.984, 0, 57.527, 0, 62.796, 0, 1, 35.513, 35.513, 2, 1, 1, 0, 5)",
                200,
            ),
        ],
        hardest: 2.0 * 62.796,
    },
];

#[test]
fn programs_with_a_former_velocity_step_have_none() {
    for Found { calls, hardest } in &FOUND {
        let mut bench = Bench::new();
        for (call, ticks) in *calls {
            assert_eq!(bench.call(call).0, 0, "{call}");
            for _ in 0..*ticks {
                let before = ["X", "Y"].map(|axis| bench.axis(axis).command[1]);
                bench.tick();
                for (axis, before) in ["X", "Y"].into_iter().zip(before) {
                    let rate = (bench.axis(axis).command[1] - before) / PERIOD;
                    assert!(rate.abs() <= hardest + 1e-6, "{axis}: {rate} units/s² behind {call}");
                }
            }
        }
    }
}

/// A move that was merged onto blends with its successor while the residual of the merge still ramps out: the successor's ramp ended with the
/// move's own, and its full speed came on top of the residual's (spec/coordinated-instructions.md §7.4).
#[test]
fn a_blend_waits_for_the_residual_beside_the_move() {
    let dynamics = "101.298, 0, 471.359, 0, 127.712, 0, 0, 100, 100, 2";
    let mut bench = Bench::new();
    let calls = [
        (
            format!("MCLM(XY, M2, 1, [-39.635, -28.315], {dynamics}, 3, 2, 1, 5)"),
            149,
        ),
        (format!("MCLM(XY, M3, 1, [-8.810, 1.246], {dynamics}, 3, 2, 0, 5)"), 212),
        (
            format!("MCLM(XY, M4, 1, [-56.580, -5.441], {dynamics}, 2, 0, 1, 5)"),
            400,
        ),
    ];
    let mut fastest = 0.0_f64;
    for (call, ticks) in calls {
        assert_eq!(bench.call(&call).0, 0, "{call}");
        for _ in 0..ticks {
            bench.tick();
            let [x, y] = ["X", "Y"].map(|axis| bench.axis(axis).command[1]);
            fastest = fastest.max(x.hypot(y));
        }
    }
    assert!(fastest > 101.2 && fastest < 101.298 * (1.0 + 1e-9), "{fastest}");
}

/// An S-curve with long jerks is merged onto a planned contour that speeds up hard. The merge did not know the dynamics of the contour, so
/// its acceleration was taken away slowly and led 46 mm past the end point. A stop with the old dynamics needs 1 mm.
#[test]
fn a_merge_onto_a_contour_leads_no_further_than_its_stop() {
    let mut bench = on_contours();
    let first = "MCLM(XY, M1, 1, [0, -22], 209.938, 0, 1985.69, 0, 785.215, 0, 0, 100, 100, 2, 1, 0, 0, 5)";
    let merged = "MCLM(XY, M2, 1, [-12, -10], 259.273, 0, 746.074, 0, 902.296, 0, 1, 93.244, 93.244, 2, 1, 1, 0, 5)";
    assert_eq!(bench.call(first).0, 0);
    for _ in 0..20 {
        bench.tick();
    }
    let [_, speed, acceleration] = bench.axis("Y").command;
    assert!(
        speed < -30.0 && acceleration < -1900.0,
        "{speed} units/s, {acceleration} units/s²"
    );
    let stop = speed * speed / (2.0 * 785.215);
    let end = [bench.position("X") - 12.0, bench.position("Y") - 10.0];
    assert_eq!(bench.call(merged).0, 0);
    let mut furthest = 0.0_f64;
    for _ in 0..2000 {
        bench.tick();
        furthest = furthest.min(bench.position("Y") - end[1]);
    }
    assert!(furthest > -(stop + 0.1), "{furthest} units, a stop takes {stop}");
    assert_eq!(["X", "Y"].map(|axis| bench.position(axis)), end);
}

/// Merge Speed Current programs no speed: a present speed that overshoots the programmed one by half does not raise the bound of the next merge.
#[test]
fn a_chain_of_merges_at_the_present_speed_keeps_the_bound_of_one() {
    for speed in [200, 10] {
        for merge in [
            format!("MAJ(X, J#, 0, {speed}, 0, 50, 0, 50, 0, 1, 100, 100, 2, 1, 1)"),
            format!("MAM(X, J#, 0, 50000, {speed}, 0, 50, 0, 50, 0, 1, 100, 100, 2, 1, 1)"),
            format!("MAJ(X, J#, 0, {speed}, 0, 2000, 0, 50, 0, 1, 5, 100, 2, 1, 1)"),
        ] {
            let mut bench = Bench::new();
            bench.call("MAM(X, M0, 0, 50000, 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1, 0)");
            let mut fastest = 0.0_f64;
            for number in 0..60 {
                for _ in 0..100 {
                    bench.tick();
                    fastest = fastest.max(bench.axis("X").command[1].abs());
                }
                let call = merge.replace('#', &number.to_string());
                assert_eq!(bench.call(&call).0, 0, "{call}");
            }
            assert!(
                fastest <= 300.0 + 1e-6,
                "{merge}: {fastest} units/s, programmed are 200"
            );
        }
    }
}

/// A line of XY to a position with a trapezoid.
fn line(tag: &str, to: [f64; 2], speed: f64, termination: u32) -> String {
    format!("MCLM(XY, {tag}, 0, {to:?}, {speed}, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, {termination}, 0, 0, 5)")
}

/// MCCD of XY that changes the speed of the active move, or of the pending ones too (scope 1).
fn change_speed(bench: &mut Bench, tag: &str, speed: u32, scope: u32) {
    let call = format!("MCCD(XY, {tag}, 1, 1, {speed}, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, {scope})");
    assert_eq!(bench.call(&call), OK);
}

#[test]
fn a_move_that_stands_when_its_contour_is_planned_takes_its_speed_later() {
    // A change of active and pending moves to 0 holds the second one before it is planned; random programs found it at 1 unit/s for ever.
    let mut bench = on_contours();
    assert_eq!(bench.call(&line("M1", [10.0, 0.0], 100.0, 1)), OK);
    bench.run(20);
    assert_eq!(bench.call(&line("M2", [110.0, 0.0], 100.0, 1)), OK);
    bench.run(150);
    change_speed(&mut bench, "C1", 0, 1);
    bench.run(500);
    let held = bench.position("X");
    assert!(held < 109.0 && bench.axis("X").command[1] == 0.0, "at {held}");
    change_speed(&mut bench, "C2", 50, 1);
    bench.run(((110.0 - held) / 50.0 * 1000.0) as u64 + 150);
    assert!(bench.control("M2").has(Flag::Pc), "{}", bench.bits("M2"));
    assert_eq!(bench.position("X"), 110.0);
}

#[test]
fn a_pending_move_of_speed_0_lets_the_contour_before_it_end() {
    let mut bench = on_contours();
    assert_eq!(bench.call(&line("M1", [50.0, 0.0], 100.0, 6)), OK);
    assert_eq!(bench.call(&line("M2", [50.0, 40.0], 0.0, 6)), OK);
    bench.run(900);
    assert_eq!((bench.position("X"), bench.position("Y")), (50.0, 0.0));
    assert!(
        bench.control("M1").has(Flag::Pc) && bench.control("M2").has(Flag::Ac),
        "{}",
        bench.bits("M2")
    );
    change_speed(&mut bench, "C", 80, 0);
    bench.run(900);
    assert!(bench.control("M2").has(Flag::Pc), "{}", bench.bits("M2"));
    assert_eq!((bench.position("X"), bench.position("Y")), (50.0, 40.0));
}

#[test]
fn a_contour_goes_on_up_to_a_move_that_a_change_left_at_speed_0() {
    let mut bench = on_contours();
    assert_eq!(bench.call(&line("M1", [90.0, 0.0], 100.0, 6)), OK);
    assert_eq!(bench.call(&line("M2", [90.0, 90.0], 100.0, 6)), OK);
    bench.run(200);
    change_speed(&mut bench, "C1", 0, 1);
    bench.run(300);
    // The active move alone goes on.
    change_speed(&mut bench, "C2", 50, 0);
    bench.run(2500);
    // The second move has braked from its beginning on.
    let at = [bench.position("X"), bench.position("Y")];
    assert!(
        (at[0] - 90.0).hypot(at[1]) < 10.0 && bench.axis("Y").command[1] == 0.0,
        "at {at:?}, {}",
        bench.bits("M1")
    );
    change_speed(&mut bench, "C3", 50, 1);
    bench.run(2500);
    assert!(bench.control("M2").has(Flag::Pc), "{}", bench.bits("M2"));
    assert_eq!((bench.position("X"), bench.position("Y")), (90.0, 90.0));
}
