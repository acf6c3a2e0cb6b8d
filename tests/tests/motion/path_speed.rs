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
