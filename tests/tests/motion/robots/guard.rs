//! The guard of a robot's joints: it stops every motion of the source in time, and the joints never leave their limits
//! (spec/coordinated-instructions.md §19.8).

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::robots::{RobotMachine, SIX_AXES};

const LINK: &str = "MCT(CART, ROBOT, T, [0, 0, 0], [0, 0, 0])";
const SPEED: f64 = 360.0;
/// The share by which a joint may be faster than that.
const SLACK: f64 = 0.02;

/// The greatest travel of a joint in an update beyond that of its velocities at both ends, degrees.
const STEP: f64 = 5e-3;

/// Links of 300 and 260; the tool at X 400, Y 39.999 or so.
const SCARA: RobotMachine = RobotMachine {
    keys: "type = \"scara_independent\"\nlink_lengths = [300.0, 260.0]\n",
    joints: &[-33.015_349_581_048_57, 88.200_028_814_965_78, 0.0],
    joint_speed: SPEED,
    cart: "",
    period: 1.0,
};

/// Two links of 300; the tool at X 200, Z 300.
const ARM: RobotMachine = RobotMachine {
    keys: "type = \"articulated_independent\"\nlink_lengths = [300.0, 300.0]\nbase_offsets = [0.0, 0.0, 100.0]\n",
    joints: &[0.0, 106.871_636_883_654_96, -123.746_997_871_943_53],
    ..SCARA
};

/// The observations until all axes stood.
#[derive(Debug, Default)]
struct Seen {
    /// ERR and EXERR of T.
    error: (i16, i8),
    /// The highest speed of a joint.
    speed: f64,
    /// The greatest travel of a joint in an update beyond that of its velocities.
    step: f64,
    /// The positions of the joints.
    joints: Vec<f64>,
}

/// Runs until the source and the joints stand after T has ended, or `ticks` are over, with actions at some of them.
fn watch(bench: &mut Bench, machine: &RobotMachine, ticks: u64, mut at: impl FnMut(&mut Bench, u64)) -> Seen {
    let joints: Vec<String> = (1..=machine.joints.len()).map(|joint| format!("J{joint}")).collect();
    let commands = |bench: &Bench| -> Vec<[f64; 3]> { joints.iter().map(|joint| bench.axis(joint).command).collect() };
    let mut seen = Seen::default();
    let mut before = commands(bench);
    let period = machine.period / 1000.0;
    for tick in 0..ticks {
        at(bench, tick);
        bench.tick();
        let now = commands(bench);
        for ([p0, v0, _], [p1, v1, _]) in before.iter().zip(&now) {
            seen.speed = seen.speed.max(v1.abs());
            let mean = 0.5 * (v0 + v1) * period;
            seen.step = seen.step.max((p1 - p0 - mean).abs() - 0.5 * (v1 - v0).abs() * period);
        }
        before = now;
    }
    let shown = bench.control("T");
    seen.error = (shown.err, shown.exerr);
    seen.joints = before.iter().map(|joint| joint[0]).collect();
    seen
}

fn jog(axis: &str, direction: u8, speed: f64, profile: &str) -> String {
    format!("MAJ({axis}, J, {direction}, {speed}, 0, 5000, 0, 5000, 0, {profile}, 100, 100, 2)")
}

#[test]
fn whatever_leads_the_source_out_of_the_reach_stops_within_it() {
    let line = |end: &str, rates: &str| format!("MCLM(CART, M, 1, {end}, {rates}, 1)");
    let fast = "400, 0, 4000, 0, 4000, 0, 0, 100, 100, 2";
    #[rustfmt::skip]
    let cases: [(&str, String, &str); 9] = [
        ("a jog with a trapezoid",     jog("X", 0, 200.0, "Trapezoidal"), ""),
        ("a jog with an S-curve",      jog("X", 0, 200.0, "S-curve"), ""),
        ("a fast one",                 jog("X", 0, 900.0, "S-curve"), ""),
        ("a slow one",                 jog("X", 0, 50.0, "S-curve"), ""),
        ("MAM",                        "MAM(X, J, 1, 400, 200, 0, 5000, 0, 5000, 0, S-curve, 100, 100, 2)".into(), ""),
        ("MCS with a lower rate",      line("[150, 0, 0]", fast), "MCS(CART, S, 2, 1, 300, 0, 0, 100, 2)"),
        ("MCCD with a lower rate",     line("[150, 0, 0]", fast), "MCCD(CART, S, CoordinatedMove, Yes, 400, 0, No, 100, 0, Yes, 300, 0)"),
        ("MAS with a lower rate",      jog("X", 0, 400.0, "S-curve"), "MAS(X, S, Jog, Yes, 200, 0, No, 100, 2)"),
        ("MAS with a trapezoid",       jog("X", 0, 400.0, "Trapezoidal"), "MAS(X, S, Jog, Yes, 200, 0, No, 100, 2)"),
    ];
    for (why, call, then) in cases {
        let mut bench = SCARA.bench();
        assert_eq!(bench.call(LINK), OK, "{why}");
        assert_eq!(bench.call(&call), OK, "{why}");
        let seen = watch(&mut bench, &SCARA, 9000, |bench, tick| {
            if tick == 300 && !then.is_empty() {
                assert_eq!(bench.call(then), OK, "{why}");
            }
        });
        assert!([67, 69].contains(&seen.error.0), "{why}: {seen:?}");
        assert!(seen.speed <= SPEED * (1.0 + SLACK), "{why}: {seen:?}");
        assert!(seen.step < STEP, "{why}: {seen:?}");
        let (x, y) = (bench.position("X"), bench.position("Y"));
        let reach = x.hypot(y);
        assert!((500.0..=560.0).contains(&reach), "{why}: {reach}, {seen:?}");
        // Still together.
        let [j1, j2] = [seen.joints[0], seen.joints[0] + seen.joints[1]].map(f64::to_radians);
        let tool = 300.0 * j1.cos() + 260.0 * j2.cos();
        assert!((tool - x).abs() < 1e-9, "{why}: {tool}, {x}");
    }
}

#[test]
fn a_singularity_between_two_updates_is_one() {
    // A tick falls on the axis of J1 from 200, and none from elsewhere.
    for (why, from) in [
        ("on the axis", "[0, 0, 0]"),
        ("beside it", "[0.013, 0, 0]"),
        ("another", "[0.0501, 0, 0]"),
    ] {
        for (speed, profile) in [(100.0, "Trapezoidal"), (20.0, "S-curve"), (3.0, "Trapezoidal")] {
            let mut bench = ARM.bench();
            assert_eq!(bench.call(LINK), OK);
            let call = format!("MCLM(CART, M, 1, {from}, 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1)");
            assert_eq!(bench.call(&call), OK);
            bench.run(200);
            assert_eq!(
                bench.call("MCLM(CART, M, 1, [-195, 0, 0], 400, 0, 4000, 0, 4000, 0, 0, 100, 100, 2, 1)"),
                OK
            );
            bench.run(800);
            assert_eq!(bench.call(&jog("X", 1, speed, profile)), OK);
            let seen = watch(&mut bench, &ARM, 3000, |_, _| {});
            assert_eq!(seen.error, (68, 0), "{why} at {speed}: {seen:?}");
            assert!(seen.step < STEP && seen.joints[0] == 0.0, "{why} at {speed}: {seen:?}");
        }
    }
    // J5 of six axes through 0.
    let machine = RobotMachine {
        joints: &[0.0, 40.0, -60.0, 0.0, 20.0, 0.0],
        joint_speed: SPEED,
        ..SIX_AXES
    };
    for speed in [30.0, 31.7, 2.0] {
        let mut bench = machine.bench();
        assert_eq!(bench.call("MCTO(CART, ROBOT, T, NoFrame, NoFrame)"), OK);
        assert_eq!(bench.call(&jog("RY", 0, speed, "Trapezoidal")), OK);
        let seen = watch(&mut bench, &machine, 12_000, |_, _| {});
        assert_eq!(seen.error, (68, 0), "{speed}: {seen:?}");
        assert!(seen.step < STEP && seen.joints[3].abs() < 1.0, "{speed}: {seen:?}");
    }
}

#[test]
fn beside_a_singularity_no_joint_exceeds_its_speed() {
    for cart in ["", "corner = \"precise\"\n"] {
        for profile in ["Trapezoidal", "S-curve"] {
            for distance in [60.0, 20.0, 5.0, 0.5, 0.1] {
                let why = format!("{distance} mm beside the axis, {profile}, {cart}");
                let machine = RobotMachine { cart, ..ARM };
                let mut bench = machine.bench();
                assert_eq!(bench.call(LINK), OK, "{why}");
                let line = |end: [f64; 3], speed: f64, profile: &str| {
                    format!("MCLM(CART, M, 0, {end:?}, {speed}, 0, 5000, 0, 5000, 0, {profile}, 100, 100, 2, 1)")
                };
                assert_eq!(
                    bench.call(&line([200.0, distance, 300.0], 100.0, "Trapezoidal")),
                    OK,
                    "{why}"
                );
                bench.run(1500);
                assert_eq!(
                    bench.call(&line([-200.0, distance, 300.0], 500.0, profile)),
                    OK,
                    "{why}"
                );
                let seen = watch(&mut bench, &machine, 2500, |_, _| {});
                assert_eq!(seen.error, (69, 0), "{why}: {seen:?}");
                assert!(
                    seen.speed <= SPEED * (1.0 + SLACK) && seen.step < STEP,
                    "{why}: {seen:?}"
                );
                // The stop is not much too early: the joint reached that speed on the way, or is near the limit.
                let x = bench.position("X");
                assert!(
                    seen.speed > 0.8 * SPEED || (-1.0..30.0).contains(&x),
                    "{why}: {x}, {seen:?}"
                );
            }
        }
    }
}

#[test]
fn joints_stay_within_their_travel() {
    // J2 down to 40 by a jog of the source.
    for (speed, profile) in [
        (200.0, "Trapezoidal"),
        (200.0, "S-curve"),
        (400.0, "S-curve"),
        (300.0, "S-curve"),
    ] {
        let why = format!("{profile} at {speed}");
        let start = "start = { position = 88.20002881496578 }\n";
        let config = SCARA.config();
        assert!(config.contains(start));
        let mut bench =
            Bench::with(&config.replace(start, &format!("{start}travel = {{ min = 40.0, max = 170.0 }}\n")));
        assert_eq!(bench.call(LINK), OK, "{why}");
        assert_eq!(bench.call(&jog("X", 0, speed, profile)), OK, "{why}");
        let seen = watch(&mut bench, &SCARA, 4000, |_, _| {});
        assert_eq!(seen.error, (72, 1), "{why}: {seen:?}");
        assert!((40.0 - 1e-9..42.0).contains(&seen.joints[1]), "{why}: {seen:?}");
    }
    // J1 of an articulated robot by itself beyond half a turn.
    let machine = RobotMachine {
        joints: &[165.963_756_532_073_52, 105.530_333_559_942_86, -122.797_168_295_823_64],
        ..ARM
    };
    for (why, call) in [
        ("a jog", jog("J1", 0, 50.0, "Trapezoidal")),
        ("a jog with an S-curve", jog("J1", 0, 120.0, "S-curve")),
        (
            "MAM",
            "MAM(J1, J, 1, 30, 50, 0, 500, 0, 500, 0, Trapezoidal, 100, 100, 2)".into(),
        ),
    ] {
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK, "{why}");
        assert_eq!(bench.call(&call), OK, "{why}");
        let seen = watch(&mut bench, &machine, 5000, |_, _| {});
        assert_eq!(seen.error, (72, 0), "{why}: {seen:?}");
        assert!((178.0..=180.0 + 1e-9).contains(&seen.joints[0]), "{why}: {seen:?}");
        assert!(!bench.control("J").has(Flag::Ip), "{why}");
    }
}

#[test]
fn a_short_part_of_a_path_out_of_the_reach_is_found_before_anything_moves() {
    let machine = RobotMachine {
        joints: &[-30.737_986_404_897_494, 78.775_942_623_663_18, 0.0],
        ..SCARA
    };
    // The hole in the middle has a radius of 40.
    for (height, expected) in [(39.999, (67, 1)), (39.999_999, (67, 1)), (39.0, (67, 1)), (40.01, OK)] {
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK);
        let [x, y] = ["X", "Y"].map(|axis| bench.position(axis));
        let there = format!("MCLM(CART, A, 0, [{x}, {height}, 0], 50, 0, 5000, 0, 5000, 0, 0, 100, 100, 2, 1)");
        assert_eq!(bench.call(&there), OK, "from {y}");
        bench.run(200);
        let across = format!("MCLM(CART, M, 0, [-433.3, {height}, 0], 50, 0, 5000, 0, 5000, 0, 0, 100, 100, 2, 1)");
        assert_eq!(bench.call(&across), expected, "{height}");
    }
}

#[test]
fn a_transform_of_a_tree_is_cancelled_without_a_step() {
    let machine = RobotMachine {
        joint_speed: 1720.0,
        joints: &[10.0, 20.0, 15.0],
        ..arcline_tests::robots::DELTA
    };
    let mut config = machine.config();
    let mut bench = machine.bench();
    assert_eq!(bench.call(LINK), OK);
    bench.run(3);
    for (axis, source) in [("GX", "X"), ("GY", "Y"), ("GZ", "Z")] {
        let position = bench.position(source);
        config = format!(
            "{config}[[axis]]\nname = \"{axis}\"\ntype = \"virtual\"\nmax_speed = 2000.0\nmax_acceleration = 40000.0\n\
             start = {{ position = {position:?} }}\n"
        );
    }
    config += "[[coordinate_system]]\nname = \"GANT\"\naxes = [\"GX\", \"GY\", \"GZ\"]\nmax_speed = 1000.0\n\
               max_acceleration = 10000.0\n";
    for turn in [8.0, 20.0] {
        let mut bench = Bench::with(&config);
        for link in [
            LINK,
            "MCT(WORLD, CART, T2, [0, 0, 0], [0, 0, 0])",
            "MCT(WORLD, GANT, T3, [0, 0, 0], [0, 0, 0])",
        ] {
            assert_eq!(bench.call(link), OK, "{link}");
            bench.run(3);
        }
        assert_eq!(
            bench.call("MCLM(GANT, A, 1, [0, -40, 0], 100, 0, 2000, 0, 2000, 0, 1, 80, 80, 2, 1)"),
            OK
        );
        assert_eq!(
            bench.call(&format!("MAM(J1, E, 1, {turn}, 50, 0, 500, 0, 500, 0, 0, 69, 69, 2)")),
            OK
        );
        let axes = ["U", "V", "W", "X", "Y", "Z", "J1", "J2", "J3", "GX", "GY", "GZ"];
        let commands = |bench: &Bench| axes.map(|axis| bench.axis(axis).command);
        let mut before = commands(&bench);
        for tick in 0..1500 {
            if tick == 350 {
                assert_eq!(bench.call("MCS(GANT, S, 3)"), OK);
            }
            if tick == 1200 {
                // Linked systems stay together.
                let line = "MCLM(WORLD, B, 1, [10, 5, 3], 100, 0, 2000, 0, 2000, 0, 1, 80, 80, 2, 1)";
                assert_eq!(bench.call(line), OK);
            }
            bench.tick();
            let now = commands(&bench);
            for ((axis, [p0, v0, _]), [p1, v1, _]) in axes.iter().zip(before).zip(now) {
                let step = p1 - p0 - 0.5e-3 * (v0 + v1);
                assert!(
                    step.abs() <= 1e-6 + 0.5e-3 * (10.0 + (v1 - v0).abs()) && (v1 - v0).abs() < 25.0,
                    "{turn} degrees, tick {tick}: {axis} from {p0} at {v0} to {p1} at {v1}"
                );
            }
            before = now;
        }
        assert!(
            bench.control("T").has(Flag::Ip) && bench.control("T2").has(Flag::Ip),
            "{turn}"
        );
        for (cart, world) in [("X", "U"), ("Y", "V"), ("Z", "W")] {
            assert!(
                (bench.position(cart) - bench.position(world)).abs() < 1e-9,
                "{turn}: {cart}"
            );
        }
    }
}
