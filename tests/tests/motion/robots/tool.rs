//! The position of a robot's tool in snapshots and traces: by the actual positions of its joints, in the frame of its base.

use arcline_config::load;
use arcline_controller::machine::KinematicStructure;
use arcline_controller::samples;
use arcline_instruction_set::Flag;
use arcline_kinematics::{OrientedRobot, Pose, Robot};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::robots::{ARTICULATED, DELTA, DELTA_J1J2J6, PLANAR, RobotMachine, SCARA_J1J2J3J6, SIX_AXES};

const RATES: &str = "100, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 1";

/// The position of the tool at the actual positions of its joints; `tool`: the tool frame.
fn tool(machine: &RobotMachine, bench: &Bench, tool: &Pose) -> [f64; 3] {
    let project = load(&machine.config(), "robot.toml").expect("the configuration is valid");
    let described = project.machine.systems[2].robot.expect("the system is a robot");
    let mut joints = [0.0; 6];
    for (place, joint) in joints.iter_mut().enumerate().take(machine.joints.len()) {
        *joint = bench.axis(&format!("J{}", place + 1)).actual[0];
    }
    match described.structure {
        KinematicStructure::Arm(geometry) => {
            let robot = Robot::new(geometry, &described.parameters).expect("the parameters make a robot");
            robot.forward([joints[0], joints[1], joints[2]]).expect("joints of it")
        }
        KinematicStructure::Wrist(wrist) => {
            let robot = OrientedRobot::new(wrist, &described.parameters).expect("the parameters make a robot");
            let pose = robot.forward(&joints).expect("joints of it").pose;
            (pose.position + pose.rotation * tool.position).into()
        }
    }
}

fn near(is: Option<[f64; 3]>, expected: [f64; 3], why: &str) {
    let is = is.expect("it is a robot");
    let apart = is.iter().zip(expected).map(|(is, expected)| (is - expected).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-9, "{why}: {is:?} is not {expected:?}");
}

#[test]
fn the_tool_is_where_the_joints_really_are() {
    let none = Pose::new([0.0; 6]);
    for machine in [DELTA, ARTICULATED, PLANAR, DELTA_J1J2J6, SCARA_J1J2J3J6, SIX_AXES] {
        let mut bench = machine.bench();
        let why = machine.keys;
        assert_eq!(bench.system("CART").tool, None, "{why}");
        near(bench.system("ROBOT").tool, tool(&machine, &bench, &none), why);
        // The position without any transform.
        assert_eq!(bench.call("MAM(J1, M, 1, 10, 100, 0, 2000, 0, 2000, 0)"), OK, "{why}");
        let mut before = bench.system("ROBOT").tool;
        while !bench.control("M").has(Flag::Pc) {
            bench.tick();
            let now = bench.system("ROBOT").tool;
            near(now, tool(&machine, &bench, &none), why);
            assert_ne!(now, before, "{why}: it moves");
            before = now;
        }
    }
}

#[test]
fn it_is_the_tool_centre_while_mcto_runs() {
    let mut bench = SIX_AXES.bench();
    for (path, value) in [("Work.X", 10.0), ("Tool.Z", 40.0), ("Tool.X", 5.0)] {
        bench.write(path, value);
    }
    let frame = Pose::new([5.0, 0.0, 40.0, 0.0, 0.0, 0.0]);
    assert_eq!(bench.call("MCTO(CART, ROBOT, T, Work, Tool)"), OK);
    bench.run(2);
    near(bench.system("ROBOT").tool, tool(&SIX_AXES, &bench, &frame), "linked");
    // The tool is at the position of the source, in the work frame.
    assert_eq!(bench.call(&format!("MCLM(CART, M, 1, [30, -20, 15], {RATES})")), OK);
    bench.until("M", Flag::Pc);
    let [x, y, z] = bench.system("ROBOT").tool.expect("a robot");
    let apart = [
        x - 10.0 - bench.position("X"),
        y - bench.position("Y"),
        z - bench.position("Z"),
    ];
    assert!(apart.iter().all(|apart| apart.abs() < 1e-6), "{apart:?}");
    assert_eq!(bench.call("MCS(ROBOT, S, 3)"), OK);
    bench.run(2);
    near(
        bench.system("ROBOT").tool,
        tool(&SIX_AXES, &bench, &Pose::new([0.0; 6])),
        "the end of the arm again",
    );
}

#[test]
fn a_row_of_samples_has_the_tool_behind_everything_else() {
    // A second robot, whose measures make none: it has columns all the same.
    let more = "[[coordinate_system]]\nname = \"NONE\"\ntype = \"delta\"\naxes = [\"U\", \"V\"]\nmax_speed = 1.0\n\
                max_acceleration = 1.0\n";
    let mut bench = Bench::with(&(DELTA.config() + more));
    bench.run(3);
    let machine = bench.machine();
    let row: Vec<f64> = samples::row(&bench.snapshot()).collect();
    assert_eq!(row.len(), samples::width(machine));
    let names = samples::names(machine);
    assert_eq!(names.len() + 1, row.len());
    let [x, y, z] = bench.system("ROBOT").tool.expect("a robot");
    for (name, expected) in [("ROBOT.ToolX", x), ("robot.tooly", y), ("ROBOT.ToolZ", z)] {
        let column = samples::find(machine, name).expect("a column");
        assert_eq!(column.of(&row), expected, "{name}");
        let place = names.iter().position(|known| known.eq_ignore_ascii_case(name));
        assert_eq!(column, samples::Column::Number(1 + place.expect("a name")), "{name}");
    }
    let none = samples::find(machine, "NONE.ToolY").expect("a column");
    assert!(none.of(&row).is_nan());
    for name in ["CART.ToolX", "J1.ToolX", "ROBOT.ToolW"] {
        assert_eq!(samples::find(machine, name), None, "{name}");
    }
}
