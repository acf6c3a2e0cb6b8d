//! MCTO and MCTPO: a robot with a wrist behind X, Y, Z, Rx, Ry, Rz (spec/coordinated-instructions.md §19, §22.8, §24, §25).

use super::paths;
use arcline_config::load;
use arcline_controller::machine::KinematicStructure;
use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status::{
    TOOL_CHANGE_ALLOWED_STATUS, TRANSFORM_SOURCE_STATUS, TRANSFORM_TARGET_STATUS,
};
use arcline_instruction_set::predefined::motion_status::{CONTROLLED_BY_TRANSFORM_STATUS, TRANSFORM_STATE_STATUS};
use arcline_kinematics::{OrientedRobot, Pose, tool_centre};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::robots::{DELTA_J1J2J3J4J5, DELTA_J1J2J3J6, DELTA_J1J2J6, RobotMachine, SCARA_J1J2J3J6, SIX_AXES};

/// Tags and their values.
type Values<'a> = &'a [(&'a str, f64)];
/// Why, the machine, the earlier calls, values of tags, the call, ERR and EXERR.
type Refused<'a> = (&'a str, &'a str, &'a [&'a str], Values<'a>, &'a str, (i16, i8));

const LINK: &str = "MCTO(CART, ROBOT, T, Work, Tool)";
const CARTESIAN: [&str; 6] = ["X", "Y", "Z", "RX", "RY", "RZ"];
const JOINTS: [&str; 6] = ["J1", "J2", "J3", "J4", "J5", "J6"];
/// The operands from Speed on: a trapezoid at 100 units/s.
const RATES: &str = "100, 0, 2000, 0, 2000, 0, 0, 100, 100, 2";
/// The same at 400 units/s.
const FAST: &str = "400, 0, 8000, 0, 8000, 0, 0, 100, 100, 2";

/// A machine with a work that is tilted by some degrees in the plane of X and Z, and a tool, both of which every robot can have.
fn bench(machine: &RobotMachine, tilt: f64) -> Bench {
    with_frames(machine.bench(), tilt)
}

fn with_frames(mut bench: Bench, tilt: f64) -> Bench {
    for (path, value) in [
        ("Work.ID", 7.0),
        ("Work.X", 10.0),
        ("Work.Z", -5.0),
        ("Work.Ry", tilt),
        ("Tool.ID", 3.0),
        ("Tool.Z", 40.0),
        ("Tool.Rz", 15.0),
    ] {
        bench.write(path, value);
    }
    bench
}

/// The pose of the tool in the work frame by the robot's joints.
struct Tool {
    robot: OrientedRobot,
    joints: usize,
    frames: [Pose; 2],
}

impl Tool {
    fn of(machine: &RobotMachine, tilt: f64) -> Tool {
        let project = load(&machine.config(), "robot.toml").expect("the configuration is valid");
        let described = project.machine.systems[2].robot.expect("the system is a robot");
        let KinematicStructure::Wrist(wrist) = described.structure else {
            panic!("the robot has no wrist");
        };
        Tool {
            robot: OrientedRobot::new(wrist, &described.parameters).expect("the parameters make a robot"),
            joints: wrist.joints(),
            frames: [[10.0, 0.0, -5.0, 0.0, tilt, 0.0], [0.0, 0.0, 40.0, 0.0, 0.0, 15.0]].map(Pose::new),
        }
    }

    fn at(&self, bench: &Bench) -> Pose {
        let mut joints = [0.0; 6];
        for (joint, axis) in joints.iter_mut().zip(JOINTS).take(self.joints) {
            *joint = bench.position(axis);
        }
        let taken = self.robot.forward(&joints).expect("joints of the robot");
        tool_centre(&self.frames[0], &taken.pose, &self.frames[1])
    }
}

fn source(bench: &Bench) -> Pose {
    Pose::new(CARTESIAN.map(|axis| bench.position(axis)))
}

fn apart(a: &Pose, b: &Pose) -> [f64; 2] {
    [(a.position - b.position).norm(), (a.rotation - b.rotation).abs().max()]
}

#[test]
fn a_straight_move_keeps_the_tool_on_its_line_and_turned_as_it_was() {
    for machine in [DELTA_J1J2J6, DELTA_J1J2J3J6, DELTA_J1J2J3J4J5, SCARA_J1J2J3J6, SIX_AXES] {
        let tool = Tool::of(&machine, 10.0);
        let why = tool.robot.wrist().definition();
        let mut bench = bench(&machine, 10.0);
        let plane = machine.joints.len() == 3;
        assert_eq!(bench.call(LINK), OK, "{why}");
        let began = tool.at(&bench);
        assert!(
            apart(&source(&bench), &began).iter().all(|apart| *apart < 1e-9),
            "{why}"
        );
        for [x, y, z] in [[30.0, -20.0, 15.0], [-55.0, 10.0, -20.0], [10.0, 25.0, 10.0]] {
            let y = if plane { 0.0 } else { y };
            let from = source(&bench).position;
            let call = format!("MCLM(CART, M, 1, [{x}, {y}, {z}], {RATES}, 1)");
            assert_eq!(bench.call(&call), OK, "{why}: {call}");
            let along = [x, y, z];
            let length = along.iter().map(|part| part * part).sum::<f64>();
            while !bench.control("M").has(Flag::Pc) {
                bench.tick();
                let now = tool.at(&bench);
                let gone = now.position - from;
                let share = (0..3).map(|k| gone[k] * along[k]).sum::<f64>() / length;
                let off = (0..3).map(|k| (gone[k] - share * along[k]).powi(2)).sum::<f64>().sqrt();
                assert!(off < 1e-6, "{why}: {off} off its line");
                let [_, turned] = apart(&now, &began);
                assert!(turned < 1e-9, "{why}: turned by {turned}");
                assert!(apart(&source(&bench), &now).iter().all(|apart| *apart < 1e-6), "{why}");
            }
            bench.rung_false("M");
        }
        assert_eq!(bench.bits("T"), "EN DN IP", "{why}");
    }
}

#[test]
fn a_path_move_takes_the_tool_along_and_round() {
    // The turn of the tool about X, Y and Z beside its line, as far as each robot can turn it.
    for (machine, turn) in [
        (DELTA_J1J2J6, [0.0, 0.0, 150.0]),
        (DELTA_J1J2J3J6, [0.0, 0.0, -170.0]),
        (SCARA_J1J2J3J6, [0.0, 0.0, 80.0]),
        (DELTA_J1J2J3J4J5, [0.0, 0.0, 60.0]),
        (SIX_AXES, [20.0, 15.0, -40.0]),
    ] {
        let machine = RobotMachine {
            cart: paths::MACHINE.cart,
            ..machine
        };
        let tool = Tool::of(&machine, 0.0);
        let why = tool.robot.wrist().definition();
        let mut bench = with_frames(paths::bench_of(machine), 0.0);
        assert_eq!(bench.call(LINK), OK, "{why}");
        let began = CARTESIAN.map(|axis| bench.position(axis));
        // A robot with fewer than six joints reaches the REAL values only approximately.
        let within = if machine.joints.len() == 6 { 1e-9 } else { 1e-5 };
        let plane = machine.joints.len() == 3;
        let along = [30.0, if plane { 0.0 } else { -20.0 }, 15.0];
        // PATH_DATA holds REALs.
        let end: [f64; 6] = std::array::from_fn(|place| {
            let step = if place < 3 { along[place] } else { turn[place - 3] };
            f64::from((began[place] + step) as f32)
        });
        paths::position(&mut bench, "P", end);
        assert_eq!(bench.call(paths::MOVE), OK, "{why}");
        while !bench.control("M").has(Flag::Pc) {
            bench.tick();
            assert_eq!(bench.bits("T"), "EN DN IP", "{why}");
            let [moved, turned] = apart(&source(&bench), &tool.at(&bench));
            assert!(moved < within && turned < within, "{why}: {moved} {turned}");
        }
        let [moved, turned] = apart(&tool.at(&bench), &Pose::new(end));
        assert!(
            moved < within && turned < within,
            "{why}: ends {moved} and {turned} away"
        );
    }
    // Turned as the robot cannot be, at the end or on the way (a turn about one axis, of a tool that only tilts and turns): refused
    // before any axis moves.
    let machine = RobotMachine {
        cart: paths::MACHINE.cart,
        ..DELTA_J1J2J3J4J5
    };
    let mut bench = with_frames(paths::bench_of(machine), 0.0);
    assert_eq!(bench.call(LINK), OK);
    let end = CARTESIAN.map(|axis| bench.position(axis));
    for (why, turn) in [("at the end", [-30.0, 0.0, 0.0]), ("on the way", [0.0, 15.0, 60.0])] {
        let mut turned = end;
        for (angle, by) in turned[3..].iter_mut().zip(turn) {
            *angle += by;
        }
        paths::position(&mut bench, "P", turned);
        assert_eq!(bench.call(paths::MOVE), (67, 3), "{why}");
        bench.rung_false("M");
    }
}

#[test]
fn both_sides_lead() {
    for machine in [DELTA_J1J2J3J6, SCARA_J1J2J3J6, DELTA_J1J2J6, SIX_AXES] {
        let tool = Tool::of(&machine, 0.0);
        let why = tool.robot.wrist().definition();
        let mut bench = bench(&machine, 0.0);
        assert_eq!(bench.call(LINK), OK, "{why}");
        let last = JOINTS[machine.joints.len() - 1];
        // The last joint by itself, through half a turn and more: its position goes on, and so does the source.
        let from = bench.position(last);
        assert_eq!(bench.call(&format!("MAM({last}, A, 1, 300, {FAST})")), OK, "{why}");
        let mut before = source(&bench);
        while !bench.control("A").has(Flag::Pc) {
            bench.tick();
            assert!(
                apart(&source(&bench), &tool.at(&bench))
                    .iter()
                    .all(|apart| *apart < 1e-6),
                "{why}"
            );
            let step = apart(&source(&bench), &before);
            assert!(step[1] < 0.01, "{why}: {step:?}");
            before = source(&bench);
        }
        assert!((bench.position(last) - from - 300.0).abs() < 1e-9, "{why}");
        assert_eq!(bench.system("ROBOT").turns[2], 1, "{why}");
        assert_eq!(bench.system("CART").turns, bench.system("ROBOT").turns, "{why}");
        if machine.joints.len() == 6 {
            continue;
        }
        // The source turns it back.
        let joint = bench.position(last);
        assert_eq!(bench.call(&format!("MAM(RZ, B, 1, -300, {FAST})")), OK, "{why}");
        bench.run(200);
        assert_ne!(
            bench.axis(last).motion_status & CONTROLLED_BY_TRANSFORM_STATUS,
            0,
            "{why}"
        );
        bench.until("B", Flag::Pc);
        bench.run(2);
        assert!((bench.position(last) - joint + 300.0).abs() < 1e-6, "{why}");
        assert!(
            apart(&source(&bench), &tool.at(&bench))
                .iter()
                .all(|apart| *apart < 1e-6),
            "{why}"
        );
    }
}

#[test]
fn systems_show_frames_turns_and_solutions() {
    let mut bench = bench(&SIX_AXES, 10.0);
    let shown = |bench: &Bench, name: &str| {
        let system = bench.system(name);
        (system.frames, system.configuration, system.motion_status)
    };
    let bits = TOOL_CHANGE_ALLOWED_STATUS | TRANSFORM_SOURCE_STATUS | TRANSFORM_TARGET_STATUS;
    // J5 is negative: flip; the elbow is above.
    assert_eq!(shown(&bench, "CART"), ([0, 0], 0, 0));
    assert_eq!(shown(&bench, "ROBOT"), ([0, 0], 8, 0));
    assert_eq!(bench.call(LINK), OK);
    bench.run(2);
    let (frames, configuration, status) = shown(&bench, "CART");
    assert_eq!((frames, configuration), ([3, 7], 8));
    assert_eq!(status & bits, TOOL_CHANGE_ALLOWED_STATUS | TRANSFORM_SOURCE_STATUS);
    let (frames, configuration, status) = shown(&bench, "ROBOT");
    assert_eq!((frames, configuration), ([3, 7], 8));
    assert_eq!(status & bits, TOOL_CHANGE_ALLOWED_STATUS | TRANSFORM_TARGET_STATUS);
    for axis in CARTESIAN.iter().chain(&JOINTS) {
        assert_ne!(bench.axis(axis).motion_status & TRANSFORM_STATE_STATUS, 0, "{axis}");
    }
    assert_eq!(bench.call(&format!("MCLM(CART, M, 1, [50, 0, 0], {RATES}, 1)")), OK);
    bench.run(50);
    assert_eq!(shown(&bench, "CART").2 & TOOL_CHANGE_ALLOWED_STATUS, 0, "it moves");
    bench.until("M", Flag::Pc);
    assert_eq!(bench.call("MCS(ROBOT, S, 3)"), OK);
    bench.run(2);
    assert_eq!(bench.bits("T"), "EN DN");
    let (frames, configuration, status) = shown(&bench, "CART");
    assert_eq!((frames, configuration, status & bits), ([0, 0], 0, 0));
    assert_eq!(bench.axis("J6").motion_status & TRANSFORM_STATE_STATUS, 0);
}

#[test]
fn every_cause_that_cancels_mct_cancels_it() {
    let causes = [
        "MCS(CART, S, 0)",
        "MCS(ROBOT, S, 0)",
        "MCS(CART, S, 3)",
        "MAS(J4, S, 0)",
        "MAS(RZ, S, 0)",
        "MCSD(CART, S)",
        "MASD(J6, S)",
        "MGS(Motion, S, 0)",
        "MGSD(Motion, S)",
    ];
    for cause in causes {
        let mut bench = bench(&SIX_AXES, 10.0);
        assert_eq!(bench.call(LINK), OK);
        assert_eq!(bench.call(&format!("MCLM(CART, M, 1, [50, 0, 0], {RATES}, 1)")), OK);
        bench.run(100);
        assert_eq!(bench.call(cause), OK, "{cause}");
        bench.until_rest();
        bench.run(2);
        assert!(!bench.control("T").has(Flag::Ip), "{cause}: {}", bench.bits("T"));
        assert!(!bench.control("T").has(Flag::Er), "{cause}: {}", bench.bits("T"));
    }
    let mut bench = bench(&SIX_AXES, 10.0);
    assert_eq!(bench.call(LINK), OK);
    assert_eq!(bench.call(&format!("MCLM(CART, M, 1, [50, 0, 0], {RATES}, 1)")), OK);
    bench.run(100);
    assert_eq!(bench.call("MCS(CART, S, 2)"), OK, "of the move only");
    bench.until_rest();
    assert_eq!(bench.bits("T"), "EN DN IP");
}

#[test]
fn mcto_refuses_before_anything_changes() {
    let machine = SIX_AXES.config();
    let turning = machine.replacen("name = \"RZ\"\n", "name = \"RZ\"\nunwind = 360.0\n", 1);
    let servo = machine.replacen(
        "name = \"RZ\"\ntype = \"virtual\"",
        "name = \"RZ\"\ntype = \"servo\"",
        1,
    );
    let straight = machine.replacen("position = -60.0", "position = 0.0", 1);
    let short = machine.replacen("link_lengths = [300.0, 250.0]", "link_lengths = [0.0, 250.0]", 1);
    let delta = DELTA_J1J2J3J6
        .config()
        .replacen("base_offsets = [60.0", "base_offsets = [600.0", 1);
    let off = DELTA_J1J2J3J6
        .config()
        .replacen("position = 23.0", "position = 150.0", 1);
    for (changed, original) in [
        (&turning, &machine),
        (&servo, &machine),
        (&straight, &machine),
        (&short, &machine),
    ] {
        assert_ne!(changed, original);
    }
    #[rustfmt::skip]
    let cases: [Refused<'_>; 23] = [
        // why,                            machine,   before,                              tags,                call,                                 status
        ("no Cartesian system",            &machine,  &[],                                 &[],                 "MCTO(Nobody, ROBOT, T, Work, Tool)", (13, 0)),
        ("onto itself",                    &machine,  &[],                                 &[],                 "MCTO(CART, CART, T, Work, Tool)",    (61, 2)),
        ("from a system without turns",    &machine,  &[],                                 &[],                 "MCTO(WORLD, ROBOT, T, Work, Tool)",  (61, 5)),
        ("from a robot",                   &machine,  &[],                                 &[],                 "MCTO(ROBOT, CART, T, Work, Tool)",   (61, 5)),
        ("to no robot",                    &machine,  &[],                                 &[],                 "MCTO(CART, WORLD, T, Work, Tool)",   (61, 6)),
        ("links of no length",             &short,    &[],                                 &[],                 LINK,                                 (61, 9)),
        ("offsets without a workspace",    &delta,    &[],                                 &[],                 LINK,                                 (61, 10)),
        ("the robot moves in coordination", &machine, &["MCLM(ROBOT, M, 1, [9, 9, 9], 10, 0, 100, 0, 100, 0, 0, 100, 100, 2, 1)"], &[], LINK,            (22, 0)),
        ("a work that is turned too far",  &machine,  &[],                                 &[("Work.Rx", 181.0)], LINK,                               (74, 0)),
        ("-180 is 180",                    &machine,  &[],                                 &[("Work.Rz", -180.0)], LINK,                              (74, 2)),
        ("a tool that is turned too far",  &machine,  &[],                                 &[("Tool.Ry", 90.5)], LINK,                                (74, 4)),
        ("ends of the ranges",             &machine,  &[],                                 &[("Tool.Ry", -90.0), ("Tool.Rz", 180.0)], LINK,           OK),
        ("a rotary axis",                  &turning,  &[],                                 &[],                 LINK,                                 (70, 5)),
        ("a joint is shut down",           &machine,  &["MASD(J2, S)"],                    &[],                 LINK,                                 (7, 1)),
        ("a joint is off",                 &servo,    &["MSF(RZ, S)"],                     &[],                 LINK,                                 (5, 5)),
        ("a joint moves",                  &machine,  &["MAJ(J5, J, 0, 5, 0, 100, 0, 100, 0)"], &[],            LINK,                                 (22, 4)),
        ("the source moves",               &machine,  &["MAJ(RX, J, 0, 5, 0, 100, 0, 100, 0)"], &[],            LINK,                                 (22, 3)),
        ("twice",                          &machine,  &["MCTO(CART, ROBOT, U, Work, Tool)"], &[],               LINK,                                 (62, 0)),
        ("while it is being cancelled",    &machine,  &["MCTO(CART, ROBOT, U, Work, Tool)", "MAJ(J6, J, 0, 50, 0, 100, 0, 100, 0)", "+100", "MAS(J6, S, 0)"], &[], LINK, (71, 0)),
        ("the source cannot be put there", &servo,    &[],                                 &[],                 LINK,                                 (67, 5)),
        ("a wrist that is straight",       &straight, &[],                                 &[],                 LINK,                                 (68, 0)),
        ("joints that cannot be",          &off,      &[],                                 &[],                 LINK,                                 (67, 0)),
        ("nothing against it",             &machine,  &[],                                 &[],                 LINK,                                 OK),
    ];
    for (why, config, before, tags, call, expected) in cases {
        let mut bench = Bench::with(config);
        for (path, value) in tags {
            bench.write(path, *value);
        }
        for call in before {
            match call.strip_prefix('+') {
                Some(ticks) => bench.run(ticks.parse().expect("ticks")),
                None => assert_eq!(bench.call(call), OK, "{why}: {call}"),
            }
        }
        let positions = CARTESIAN.map(|axis| bench.position(axis));
        assert_eq!(bench.call(call), expected, "{why}: {call}");
        if expected != OK {
            assert_eq!(CARTESIAN.map(|axis| bench.position(axis)), positions, "{why}");
        }
    }
}

#[test]
fn where_the_robot_cannot_go() {
    let begun = |machine: &RobotMachine| {
        let mut bench = bench(machine, 10.0);
        assert_eq!(bench.call(LINK), OK);
        bench
    };
    // Known before any axis moves.
    let mut robot = begun(&DELTA_J1J2J3J6);
    let call = format!("MCLM(CART, M, 1, [900, 0, 0], {RATES}, 1)");
    assert_eq!(robot.call(&call).0, 67);
    assert_eq!(robot.bits("T"), "EN DN IP");
    // An orientation that the robot does not have is found when it turns away.
    assert_eq!(robot.call(&format!("MAM(RX, A, 1, 30, {RATES})")), OK);
    robot.until("T", Flag::Er);
    let shown = robot.control("T");
    assert_eq!((shown.err, robot.bits("T").contains("IP")), (67, false));
    robot.until_rest();
    // A joint that is too fast: the tool stays on its line to the end of the stop.
    let slow = RobotMachine {
        joint_speed: 12.0,
        ..SIX_AXES
    };
    let tool = Tool::of(&slow, 10.0);
    let mut robot = begun(&slow);
    let from = tool.at(&robot);
    assert_eq!(robot.call(&format!("MCLM(CART, M, 1, [0, 150, 0], {RATES}, 1)")), OK);
    robot.until("T", Flag::Er);
    assert_eq!(robot.control("T").err, 69);
    while robot.snapshot().axes.iter().any(|axis| axis.command[1] != 0.0) {
        robot.tick();
        let [_, turned] = apart(&tool.at(&robot), &from);
        let gone = tool.at(&robot).position - from.position;
        assert!(gone.x.hypot(gone.z) < 1e-6 && turned < 1e-6, "{gone:?} {turned}");
        for axis in JOINTS {
            assert!(robot.axis(axis).command[1].abs() <= 12.0 + 1e-6, "{axis}");
        }
    }
    robot.run(2);
    assert!(!robot.control("M").has(Flag::Pc) && !robot.control("T").has(Flag::Ip));
}

#[test]
fn joint_limits_slow_a_robot_with_a_wrist_down() {
    let machine = |cart: &'static str| RobotMachine {
        joint_speed: 8.0,
        cart,
        ..SIX_AXES
    };
    const MAXIMA: &str = "max_orientation_speed = 90.0\nmax_orientation_acceleration = 900.0\n";
    const LIMITED: &str =
        "joint_limits = \"enforce\"\nmax_orientation_speed = 90.0\nmax_orientation_acceleration = 900.0\n";
    for (why, cart) in [("it is kept", LIMITED), ("it is not asked for", MAXIMA)] {
        for turned in [false, true] {
            let mut bench = with_frames(paths::bench_of(machine(cart)), 0.0);
            assert_eq!(bench.call(LINK), OK, "{why}");
            let began = CARTESIAN.map(|axis| bench.position(axis));
            let end: [f64; 6] = std::array::from_fn(|place| {
                let step = [40.0, 120.0, -30.0, 20.0, 15.0, -30.0][place];
                f64::from((began[place] + step) as f32)
            });
            let call = if turned {
                paths::position(&mut bench, "P", end);
                paths::MOVE.to_owned()
            } else {
                format!("MCLM(CART, M, 1, [40, 120, -30], {RATES}, 1)")
            };
            assert_eq!(bench.call(&call), OK, "{why}: {call}");
            if cart == MAXIMA {
                bench.until("T", Flag::Er);
                assert_eq!(bench.control("T").err, 69, "{why}: {call}");
                continue;
            }
            let mut fastest = 0.0_f64;
            while !bench.control("M").has(Flag::Pc) {
                bench.tick();
                assert_eq!(bench.bits("T"), "EN DN IP", "{why}: {call}");
                for axis in JOINTS {
                    let [_, speed, acceleration] = bench.axis(axis).command;
                    assert!(speed.abs() <= 8.0 + 1e-6, "{why}: {call}: {axis} at {speed}");
                    assert!(
                        acceleration.abs() <= 160.0 + 1e-6,
                        "{why}: {call}: {axis}, {acceleration}"
                    );
                    fastest = fastest.max(speed.abs());
                }
            }
            assert!(
                fastest > 5.0,
                "{why}: {call}: as fast as the joints allow, not {fastest}"
            );
        }
    }
}

#[test]
fn one_source_leads_two_robots() {
    let mut text = SIX_AXES.config();
    for (place, joint) in SIX_AXES.joints.iter().enumerate() {
        text += &format!(
            "[[axis]]\nname = \"K{}\"\ntype = \"virtual\"\nmax_speed = 4000.0\nmax_acceleration = 80000.0\nstart = {{ position = {joint:?} }}\n",
            place + 1
        );
    }
    text += &format!(
        "[[coordinate_system]]\nname = \"TWIN\"\naxes = [\"K1\", \"K2\", \"K3\", \"K4\", \"K5\", \"K6\"]\nmax_speed = 1000.0\nmax_acceleration = 10000.0\n{}",
        SIX_AXES.keys
    );
    let mut bench = Bench::with(&text);
    assert_eq!(bench.call(LINK), OK);
    assert_eq!(bench.call("MCTO(CART, TWIN, U, Work, Tool)"), OK);
    assert_eq!(bench.call("MCTO(CART, TWIN, V, Work, Tool)"), (62, 0));
    assert_eq!(bench.call(&format!("MCLM(CART, M, 1, [40, 30, -20], {RATES}, 1)")), OK);
    bench.until("M", Flag::Pc);
    bench.run(2);
    for (joint, twin) in JOINTS.iter().zip(["K1", "K2", "K3", "K4", "K5", "K6"]) {
        assert!((bench.position(joint) - bench.position(twin)).abs() < 1e-9, "{joint}");
    }
}

#[test]
fn positions_with_orientation_are_calculated() {
    let place = |bench: &mut Bench| [0, 1, 2, 3, 4, 5].map(|k| bench.read(&format!("Place[{k}]")));
    let call = |direction: u8, reference: [f64; 6]| {
        format!("MCTPO(CART, ROBOT, C, Work, Tool, {direction}, {reference:?}, Place, Bits, Turns)")
    };
    for machine in [DELTA_J1J2J6, DELTA_J1J2J3J6, DELTA_J1J2J3J4J5, SCARA_J1J2J3J6, SIX_AXES] {
        let tool = Tool::of(&machine, 10.0);
        let why = tool.robot.wrist().definition();
        let mut bench = bench(&machine, 10.0);
        let mut joints = [0.0; 6];
        joints[..machine.joints.len()].copy_from_slice(machine.joints);
        // The joint that turns the tool, two turns on.
        let turning = match why {
            "J1J2J3J4J5" => 3,
            _ => machine.joints.len() - 1,
        };
        joints[turning] += 720.0;
        assert_eq!(bench.call(&call(0, joints)), OK, "{why}");
        let point = place(&mut bench);
        let taken = tool.robot.forward(&joints).expect("joints of the robot");
        let expected = tool_centre(&tool.frames[0], &taken.pose, &tool.frames[1]);
        assert!(
            apart(&Pose::new(point), &expected).iter().all(|apart| *apart < 1e-4),
            "{why}: {point:?}"
        );
        assert_eq!(bench.read("Bits"), f64::from(taken.configuration.bits()), "{why}");
        let counter = if why == "J1J2J3J4J5" { 1 } else { 2 };
        assert_eq!(bench.read(&format!("Turns[{counter}]")), 2.0, "{why}");
        // And back, with the written values.
        assert_eq!(bench.call(&call(1, point)), OK, "{why}");
        let back = place(&mut bench);
        for (back, joint) in back.iter().zip(joints) {
            assert!((back - joint).abs() < 1e-2, "{why}: {back} is not {joint}");
        }
        bench.run(3);
        assert_eq!(bench.position("J1"), machine.joints[0], "nothing moves");
    }
}

#[test]
fn turns_counters_choose_the_joint() {
    // spec/coordinated-instructions.md §22.8: Rz = 45 with counter 0, 1, -1 is joint 45, 405, -315.
    let machine = DELTA_J1J2J3J6
        .config()
        .replace("zero_angles = [3.0, -4.0, 2.0, 5.0]\n", "");
    let mut bench = Bench::with(&machine);
    for (turns, joint) in [(0.0, 45.0), (1.0, 405.0), (-1.0, -315.0)] {
        bench.write("Turns[2]", turns);
        let call = "MCTPO(CART, ROBOT, C, NoFrame, NoFrame, Inverse, [10, 20, -300, 180, 0, 45], Place, Bits, Turns)";
        assert_eq!(bench.call(call), OK);
        assert!((bench.read("Place[3]") - joint).abs() < 1e-4, "{turns}");
    }
}

#[test]
fn a_frame_of_0_is_no_frame() {
    let machine = DELTA_J1J2J3J6.config();
    let calculated = |frames: &str| {
        let mut bench = Bench::with(&machine);
        bench.write("Work.X", 5.0);
        let call = format!("MCTPO(CART, ROBOT, C, {frames}, Forward, [20, 20, 20, 30, 0, 0], Place, Bits, Turns)");
        assert_eq!(bench.call(&call), OK, "{frames}");
        (0..6)
            .map(|place| bench.read(&format!("Place[{place}]")))
            .collect::<Vec<_>>()
    };
    let without = calculated("NoFrame, NoFrame");
    for frames in ["0, 0", "None, NoFrame", "NoFrame, 0"] {
        assert_eq!(calculated(frames), without, "{frames}");
    }
    assert_ne!(calculated("Work, 0"), without, "one frame is one");
    let linked = |frames: &str| {
        let mut bench = Bench::with(&machine);
        assert_eq!(bench.call(&format!("MCTO(CART, ROBOT, C, {frames})")), OK, "{frames}");
        bench.run(3);
        ["X", "Y", "Z", "RZ"].map(|axis| bench.position(axis))
    };
    assert_eq!(linked("0, 0"), linked("NoFrame, NoFrame"));
}

#[test]
fn mctpo_refuses_invalid_calls() {
    #[rustfmt::skip]
    let cases: [(&str, Values<'_>, &str, (i16, i8)); 13] = [
        ("onto itself",               &[],                  "MCTPO(CART, CART, C, Work, Tool, 0, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",    (61, 2)),
        ("no orientation",            &[],                  "MCTPO(WORLD, ROBOT, C, Work, Tool, 0, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",  (61, 5)),
        ("no robot",                  &[],                  "MCTPO(CART, WORLD, C, Work, Tool, 0, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",   (61, 6)),
        ("a direction of MCTP",       &[],                  "MCTPO(CART, ROBOT, C, Work, Tool, 2, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",   (77, 0)),
        ("no direction",              &[],                  "MCTPO(CART, ROBOT, C, Work, Tool, 6, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",   (13, 5)),
        ("five numbers",              &[],                  "MCTPO(CART, ROBOT, C, Work, Tool, 0, [0, 0, 0, 0, 0], Place, Bits, Turns)",      (13, 6)),
        ("room for three",            &[],                  "MCTPO(CART, ROBOT, C, Work, Tool, 0, [20, 20, 20, 0, 0, 0], Place[3], Bits, Turns)", (13, 7)),
        ("a work beyond its range",   &[("Work.Rx", 200.0)], "MCTPO(CART, ROBOT, C, Work, Tool, 0, [20, 20, 20, 0, 0, 0], Place, Bits, Turns)", (74, 0)),
        ("a delta has one solution",  &[("Bits", 2.0)],     "MCTPO(CART, ROBOT, C, NoFrame, NoFrame, 1, [0, 0, -300, 180, 0, 0], Place, Bits, Turns)", (13, 8)),
        ("a delta's J1 has no turns", &[("Turns[0]", 1.0)], "MCTPO(CART, ROBOT, C, NoFrame, NoFrame, 1, [0, 0, -300, 180, 0, 0], Place, Bits, Turns)", (13, 9)),
        ("out of reach",              &[],                  "MCTPO(CART, ROBOT, C, NoFrame, NoFrame, 1, [900, 0, -300, 180, 0, 0], Place, Bits, Turns)", (67, 0)),
        ("tilted",                    &[],                  "MCTPO(CART, ROBOT, C, NoFrame, NoFrame, 1, [0, 0, -300, 180, 20, 0], Place, Bits, Turns)", (67, 4)),
        ("possible",                  &[],                  "MCTPO(CART, ROBOT, C, NoFrame, NoFrame, 1, [0, 0, -300, 180, 0, 0], Place, Bits, Turns)", OK),
    ];
    for (why, tags, call, expected) in cases {
        let mut bench = DELTA_J1J2J3J6.bench();
        for (path, value) in tags {
            bench.write(path, *value);
        }
        let (err, exerr) = bench.call(call);
        let exerr = if err == 67 && expected.1 == 0 { 0 } else { exerr };
        assert_eq!((err, exerr), expected, "{why}: {call}");
        assert!(
            expected == OK || bench.read("Place[0]") == 0.0,
            "{why}: something was written"
        );
    }
}
