//! Path speed is the speed with which coordinated motion moves the axes, at every tick: in every kind of blend and termination
//! type, for lines and arcs, trapezoids and S-curves, in merges, under overrides and in stops; not that of a jog.

use arcline_tests::bench::{Bench, OK};

fn follow(bench: &mut Bench, ticks: u64, jog: f64, row: &str) -> f64 {
    let mut top = 0.0_f64;
    for tick in 0..ticks {
        bench.tick();
        let [x, y] = ["X", "Y"].map(|axis| bench.axis(axis).command[1]);
        let (shown, axes) = (bench.system("XY").path_speed, x.hypot(y - jog));
        assert!(
            (shown - axes).abs() <= 1e-6 * axes.max(1.0),
            "{row}, tick {tick}: {shown}, the axes {axes}"
        );
        top = top.max(shown);
    }
    top
}

#[test]
fn path_speed_is_that_of_the_axes_in_every_blend() {
    for profile in [0, 1] {
        for termination in 0..=6 {
            for arc in [false, true] {
                for merge in [0, 1, 2] {
                    let row = format!("profile {profile}, type {termination}, arc {arc}, merge {merge}");
                    let mut bench = Bench::new();
                    let rates = format!("100, 0, 2000, 0, 2000, 0, {profile}, 100, 100, 2");
                    assert_eq!(
                        bench.call(&format!("MCLM(XY, M1, 0, [60, 0], {rates}, {termination})")),
                        OK
                    );
                    let second = if arc {
                        format!("MCCM(XY, M2, 0, [60, 60], 0, [90, 30], 0, {rates}, {termination})")
                    } else {
                        format!("MCLM(XY, M2, 0, [60, 60], {rates}, {termination})")
                    };
                    assert_eq!(bench.call(&second), OK, "{row}");
                    let mut top = follow(&mut bench, 500, 0.0, &row);
                    if merge > 0 {
                        let third = format!("MCLM(XY, M3, 0, [0, 20], {rates}, 1, {merge}, 0)");
                        assert_eq!(bench.call(&third), OK, "{row}");
                        top = top.max(follow(&mut bench, 150, 0.0, &row));
                    }
                    bench.set_override("XY", 0.3);
                    top = top.max(follow(&mut bench, 100, 0.0, &row));
                    assert!(top > 50.0, "{row}: {top}");
                    bench.execute(["MCS(XY, S, CoordinatedMove)", "MCS(XY, S, All)"][merge % 2]);
                    follow(&mut bench, 300, 0.0, &row);
                }
            }
        }
    }
}

#[test]
fn a_jog_is_no_part_of_the_path_speed() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.call("MAJ(Y, J, 0, 50, 0, 20000, 0, 20000, 0, 0, 100, 100, 2)"),
        OK
    );
    bench.run(50);
    bench.execute("MCLM(XY, M1, 0, [60, 0], 100, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 1)");
    assert!(follow(&mut bench, 400, 50.0, "with a jog") > 99.0);
}

/// As [`follow`], of the axes of any coordinate system. The highest speed.
fn follow_system(bench: &mut Bench, ticks: u64, system: &str, axes: &[&str], row: &str) -> f64 {
    let mut top = 0.0_f64;
    for tick in 0..ticks {
        bench.tick();
        let squares = axes.iter().map(|axis| bench.axis(axis).command[1].powi(2));
        let (shown, axes) = (bench.system(system).path_speed, squares.sum::<f64>().sqrt());
        assert!(
            (shown - axes).abs() <= 1e-6 * axes.max(1.0),
            "{row}, tick {tick}: {shown}, the axes {axes}"
        );
        top = top.max(shown);
    }
    top
}

#[test]
fn a_masters_speed_and_its_changes_are_in_the_path_speed() {
    for corner in ["logix", "precise"] {
        for termination in 0..=6 {
            let row = format!("{corner}, type {termination}");
            let mut bench = Bench::replacing("name = \"XY\"", &format!("name = \"XY\"\ncorner = \"{corner}\""));
            assert_eq!(bench.call("MDCC(XY, A, D, Command, 50)"), OK);
            for (tag, to) in [("M1", "[30, 0]"), ("M2", "[30, 30]")] {
                let call = format!("MCLM(XY, {tag}, 0, {to}, 2, 4, 0.8, 4, 0.8, 4, 1, 0.32, 0.32, 4, {termination}");
                assert_eq!(bench.call(&format!("{call}, 0, 0, 2.0, 0, 1)")), OK, "{row}");
            }
            let jog = |speed: u32| format!("MAJ(A, J, 0, {speed}, 0, 400, 0, 400, 0, 1, 100, 100, 2)");
            assert_eq!(bench.call(&jog(30)), OK);
            let mut top = follow_system(&mut bench, 300, "XY", &["X", "Y"], &row);
            assert_eq!(
                bench.call("MCD(A, C, 0, 1, 80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0)").0,
                0,
                "{row}"
            );
            top = top.max(follow_system(&mut bench, 150, "XY", &["X", "Y"], &row));
            assert!(top > 40.0, "{row}: {top}");
            assert_eq!(bench.call("MCS(XY, S, CoordinatedMove)"), OK, "{row}");
            follow_system(&mut bench, 200, "XY", &["X", "Y"], &row);
        }
    }
}

#[test]
fn a_hold_has_no_path_speed_and_a_resumed_move_has() {
    for corner in ["logix", "precise"] {
        let keys = format!("name = \"XY\"\nqueue_depth = 4\ncorner = \"{corner}\"");
        let mut bench = Bench::replacing("name = \"XY\"", &keys);
        for (tag, to, ending) in [("M1", "[60, 0]", 6), ("M2", "[60, 40]", 6), ("M3", "[0, 40]", 1)] {
            let call =
                format!("MCLM(XY, {tag}, 0, {to}, 100, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, {ending}, 0, 0, 2.0)");
            assert_eq!(bench.call(&call), OK);
        }
        // One hold in the middle of a side, one at the first corner.
        for (share, ticks) in [(1.0, 300), (0.0, 400), (1.0, 370), (0.0, 400), (1.0, 100)] {
            bench.set_override("XY", share);
            follow_system(&mut bench, ticks, "XY", &["X", "Y"], corner);
            let speed = bench.system("XY").path_speed;
            assert!((share == 0.0) == (speed == 0.0), "{corner}, {share}: {speed}");
        }
    }
}

#[test]
fn a_source_of_a_robot_shows_the_speed_of_its_own_axes() {
    let machine = arcline_tests::robots::DELTA;
    let mut bench = machine.bench();
    assert_eq!(bench.call("MCT(CART, ROBOT, T, [0, 0, 0], [0, 0, 0])"), OK);
    let axes = ["X", "Y", "Z"];
    for (tag, to, ending) in [
        ("M1", "[40, 0, 0]", 6),
        ("M2", "[0, 40, 0]", 2),
        ("M3", "[0, 0, -20]", 3),
    ] {
        let call = format!("MCLM(CART, {tag}, 1, {to}, 100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2, {ending}, 0, 0, 5.0)");
        assert_eq!(bench.call(&call), OK, "{tag}");
    }
    assert!(follow_system(&mut bench, 700, "CART", &axes, "blends") > 50.0);
    assert_eq!(bench.call("MCS(CART, S, CoordinatedMove)"), OK);
    follow_system(&mut bench, 300, "CART", &axes, "a stop");
}

#[test]
fn path_moves_show_the_speed_of_x_y_and_z_in_their_blends() {
    let mut bench = super::robots::paths::bench_of(super::robots::paths::MACHINE);
    bench.write("P.TerminationType", 6.0);
    bench.write("P.CommandToleranceLinear", 10.0);
    bench.write("P.MoveType", 1.0);
    for (tag, way) in [
        ("M1", [60.0, 0.0, 0.0, 20.0, 0.0, 0.0]),
        ("M2", [0.0, 60.0, 0.0, 0.0, 20.0, 0.0]),
        ("M3", [0.0, 0.0, 30.0, 0.0, 0.0, 10.0]),
    ] {
        super::robots::paths::position(&mut bench, "P", way);
        assert_eq!(bench.call(&format!("MCPM(CART, {tag}, P, 1, D)")), OK, "{tag}");
    }
    let axes = ["X", "Y", "Z"];
    assert!(follow_system(&mut bench, 1500, "CART", &axes, "path moves") > 50.0);
    bench.until_rest();
}
