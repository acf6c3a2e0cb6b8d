//! Robots behind transforms: the tool stays on its line while the joints move, and the limits of the arm's reach
//! (spec/coordinated-instructions.md §19, §20, §22).

mod guard;
mod lines;
mod mcto;
mod orientation;
pub(super) mod paths;
mod queues;
mod tool;
mod wandering;

use arcline_config::load;
use arcline_controller::machine::KinematicStructure;
use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::motion_status;
use arcline_kinematics::Robot;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::robots::{
    ARTICULATED, ARTICULATED_DEPENDENT, DELTA, DELTA_2, PLANAR, PLANAR_INDEPENDENT, RobotMachine, SCARA, SCARA_DELTA,
};

const LINK: &str = "MCT(CART, ROBOT, T, [0, 0, 0], [0, 0, 0])";
/// The operands from Speed on: a trapezoid at 300 units/s.
const TRAPEZOID: &str = "300, 0, 3000, 0, 3000, 0, 0, 100, 100, 2";
/// The operands from Speed on: an S-curve at 300 units/s.
const S_CURVE: &str = "300, 0, 3000, 0, 3000, 0, 1, 100, 100, 2";

fn geometry(machine: &RobotMachine) -> Robot {
    let project = load(&machine.config(), "robot.toml").expect("the configuration is valid");
    let robot = project.machine.systems[2].robot.expect("the system is a robot");
    let KinematicStructure::Arm(geometry) = robot.structure else {
        panic!("the robot has a wrist");
    };
    Robot::new(geometry, &robot.parameters).expect("the parameters make a robot")
}

fn positions(bench: &Bench, axes: &[&str]) -> [f64; 3] {
    let snapshot = bench.snapshot();
    let mut positions = [0.0; 3];
    for (axis, position) in axes.iter().zip(&mut positions) {
        let index = bench.machine().axis(axis).expect("the machine has the axis");
        *position = snapshot.axes[usize::from(index)].command[0];
    }
    positions
}

fn names(machine: &RobotMachine) -> [&'static [&'static str]; 2] {
    let count = machine.joints.len();
    [&["X", "Y", "Z"][..count], &["J1", "J2", "J3"][..count]]
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// The distance of a point from the line between two others.
fn off_line(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let along = [0, 1, 2].map(|k| to[k] - from[k]);
    let length = along.iter().map(|part| part * part).sum::<f64>();
    let share = (0..3).map(|k| along[k] * (point[k] - from[k])).sum::<f64>() / length.max(1e-12);
    apart(point, [0, 1, 2].map(|k| from[k] + share * along[k]))
}

fn list(point: [f64; 3], count: usize) -> String {
    format!("{:?}", &point[..count])
}

#[test]
fn a_straight_move_keeps_the_tool_on_its_line() {
    let places: [(&str, RobotMachine, &[[f64; 3]]); 8] = [
        (
            "delta",
            DELTA,
            &[
                [0.0, 0.0, -280.0],
                [90.0, -60.0, -300.0],
                [-80.0, 70.0, -260.0],
                [-60.0, -90.0, -310.0],
            ],
        ),
        (
            "scara",
            SCARA,
            &[
                [300.0, 150.0, 20.0],
                [-100.0, 350.0, -50.0],
                [-250.0, -200.0, 0.0],
                [200.0, -250.0, 30.0],
            ],
        ),
        (
            "articulated",
            ARTICULATED,
            &[
                [350.0, 150.0, 120.0],
                [-50.0, 380.0, 300.0],
                [-300.0, 200.0, 0.0],
                [100.0, 400.0, -100.0],
            ],
        ),
        (
            "planar",
            PLANAR,
            &[[350.0, 150.0, 0.0], [150.0, 350.0, 0.0], [400.0, -200.0, 0.0]],
        ),
        (
            "scara delta",
            SCARA_DELTA,
            &[[40.0, 250.0, 20.0], [-70.0, 280.0, -10.0], [0.0, 210.0, 0.0]],
        ),
        (
            "planar, independent",
            PLANAR_INDEPENDENT,
            &[[350.0, 150.0, 0.0], [150.0, 350.0, 0.0], [400.0, -200.0, 0.0]],
        ),
        (
            "articulated, dependent",
            ARTICULATED_DEPENDENT,
            &[[350.0, 150.0, 120.0], [-50.0, 380.0, 300.0], [100.0, 400.0, -100.0]],
        ),
        (
            "delta of two arms",
            DELTA_2,
            &[[30.0, -280.0, 0.0], [80.0, -300.0, 0.0], [-70.0, -260.0, 0.0]],
        ),
    ];
    for (why, machine, points) in places {
        let robot = geometry(&machine);
        let [cart, joints] = names(&machine);
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK, "{why}");
        for (place, point) in points.iter().enumerate() {
            let from = positions(&bench, cart);
            let rates = if place % 2 == 0 { S_CURVE } else { TRAPEZOID };
            let to = list(*point, cart.len());
            assert_eq!(
                bench.call(&format!("MCLM(CART, M, 0, {to}, {rates}, 1)")),
                OK,
                "{why} to {point:?}"
            );
            let mut moved = [0.0_f64; 3];
            let mut before = positions(&bench, joints);
            while !bench.control("M").has(Flag::Pc) {
                assert!(
                    !bench.control("M").has(Flag::Er) && !bench.control("T").has(Flag::Er),
                    "{why} to {point:?}"
                );
                bench.tick();
                let now = positions(&bench, joints);
                let tool = robot.forward(now).expect("joints of a robot");
                assert!(
                    apart(tool, positions(&bench, cart)) < 1e-6,
                    "{why}: the tool is where the source is"
                );
                assert!(off_line(tool, from, *point) < 1e-6, "{why}: on the line at {tool:?}");
                for (k, (now, before)) in now.iter().zip(before).enumerate() {
                    // The reported speed is that of the positions.
                    if let Some(name) = joints.get(k) {
                        let [_, velocity, acceleration] = bench.axis(name).command;
                        let mean = (now - before) / 1e-3;
                        assert!(
                            (mean - velocity).abs() <= 1e-3 * acceleration.abs() + 1.0,
                            "{why}: {mean} {velocity}"
                        );
                    }
                    moved[k] = moved[k].max((now - before).abs());
                }
                before = now;
            }
            assert!(moved[0] > 0.0 && moved[1] > 0.0, "{why}: the joints move");
            assert!(apart(positions(&bench, cart), *point) < 1e-9, "{why} at {point:?}");
        }
    }
}

#[test]
fn the_solution_of_the_arm_is_kept() {
    let left_and_right: [(RobotMachine, &[&'static [f64]]); 4] = [
        (
            ARTICULATED,
            // Left, right, and both mirrors.
            &[
                &[0.0, 70.0, -80.0],
                &[0.0, -10.0, 80.0],
                &[170.0, 190.0, -80.0],
                &[170.0, 110.0, 80.0],
            ],
        ),
        (
            ARTICULATED_DEPENDENT,
            &[
                &[0.0, 70.0, -10.0],
                &[0.0, -10.0, 70.0],
                &[170.0, 190.0, 110.0],
                &[170.0, 110.0, 190.0],
            ],
        ),
        (SCARA, &[&[10.0, 75.0, 10.0], &[10.0, -75.0, 10.0]]),
        (PLANAR, &[&[70.0, -10.0], &[-10.0, 70.0]]),
    ];
    for (machine, solutions) in left_and_right {
        let robot = geometry(&machine);
        let mut seen = Vec::new();
        for &joints in solutions {
            let mut bench = RobotMachine { joints, ..machine }.bench();
            let [cart, names] = names(&machine);
            let why = format!("{:?} {joints:?}", robot.geometry());
            let arm = robot.arm(positions(&bench, names));
            assert!(!seen.contains(&arm), "{why}: {arm:?} is another one's");
            seen.push(arm);
            assert_eq!(bench.call(LINK), OK, "{why}");
            for step in [[25.0, -15.0, -20.0], [-40.0, 30.0, 10.0]] {
                let from = positions(&bench, cart);
                let to = [0, 1, 2].map(|k| if k < cart.len() { from[k] + step[k] } else { 0.0 });
                let call = format!("MCLM(CART, M, 0, {}, {TRAPEZOID}, 1)", list(to, cart.len()));
                assert_eq!(bench.call(&call), OK, "{why}: {call}");
                while !bench.control("M").has(Flag::Pc) {
                    bench.tick();
                    let now = positions(&bench, names);
                    assert_eq!(robot.arm(now), arm, "{why} at {now:?}");
                    let tool = robot.forward(now).expect("joints of a robot");
                    assert!(off_line(tool, from, to) < 1e-6, "{why}: on the line at {tool:?}");
                    assert!(!bench.control("T").has(Flag::Er), "{why}: {:?}", bench.control("T"));
                }
                bench.rung_false("M");
            }
        }
    }
}

#[test]
fn the_update_period_does_not_show() {
    let at = |period: f64| {
        let machine = RobotMachine { period, ..DELTA };
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK);
        assert_eq!(
            bench.call(&format!("MCLM(CART, M, 0, [50, 60, -300], {TRAPEZOID}, 1)")),
            OK
        );
        bench.run((80.0 / period) as u64);
        positions(&bench, &["J1", "J2", "J3"])
    };
    assert!(apart(at(0.5), at(4.0)) < 1e-9);
}

#[test]
fn frames_and_chains_lie_before_the_robot() {
    // WORLD leads CART by a frame, CART leads the robot by another one.
    let robot = geometry(&DELTA);
    let mut bench = DELTA.bench();
    assert_eq!(bench.call("MCT(CART, ROBOT, T2, [0, 0, 0], [0, 0, 0])"), OK);
    assert_eq!(bench.call("MCT(WORLD, CART, T1, [0, 0, 90], [5, 6, 7])"), OK);
    assert_eq!(
        bench.call(&format!("MCLM(WORLD, M, 0, [10, 20, -300], {S_CURVE}, 1)")),
        OK
    );
    bench.until("M", Flag::Pc);
    // A quarter turn makes (10, 20) of it (20, -10).
    let expected = [25.0, -4.0, -293.0];
    assert!(apart(positions(&bench, &["X", "Y", "Z"]), expected) < 1e-9);
    let tool = robot.forward(positions(&bench, &["J1", "J2", "J3"])).expect("joints");
    assert!(apart(tool, expected) < 1e-9);
    // A path that leaves the workspace is refused where the chain begins.
    assert_eq!(
        bench.call(&format!("MCLM(WORLD, M2, 0, [0, 500, -300], {S_CURVE}, 1)")),
        (67, 1)
    );
    // Coordinated Transform stops both.
    assert_eq!(bench.call("MCS(CART, S, 3, 0, 0, 0, 0, 0, 0)"), OK);
    bench.run(2);
    for tag in ["T1", "T2"] {
        assert!(!bench.control(tag).has(Flag::Ip), "{tag}");
    }
}

#[test]
fn joints_lead_the_tool_back() {
    // A joint that moves by itself takes the source along; the source goes straight on from there.
    for (machine, joint, by) in [(DELTA, "J2", -12.0), (SCARA, "J2", -130.0), (ARTICULATED, "J3", 25.0)] {
        let robot = geometry(&machine);
        let [cart, joints] = names(&machine);
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK);
        let target = bench.position(joint) + by;
        assert_eq!(
            bench.call(&format!(
                "MAM({joint}, M, 1, {by}, 60, 0, 600, 0, 600, 0, 1, 100, 100, 2)"
            )),
            OK
        );
        let mut ticks = 0;
        while !bench.control("M").has(Flag::Pc) {
            bench.tick();
            ticks += 1;
            let tool = robot.forward(positions(&bench, joints)).expect("joints");
            assert!(apart(tool, positions(&bench, cart)) < 1e-9, "tick {ticks}");
            assert!(
                !bench.control("T").has(Flag::Er),
                "tick {ticks} {:?}",
                bench.control("T")
            );
        }
        assert_eq!(bench.position(joint), target);
        assert!(bench.axis("X").motion_status & motion_status::TRANSFORM_STATE_STATUS != 0);
        bench.run(2);
        let from = positions(&bench, cart);
        let to = [from[0] - 20.0, from[1] + 15.0, from[2] - 5.0];
        assert_eq!(bench.call(&format!("MCLM(CART, M, 0, {to:?}, {TRAPEZOID}, 1)")), OK);
        while !bench.control("M").has(Flag::Pc) {
            bench.tick();
            let tool = robot.forward(positions(&bench, joints)).expect("joints");
            assert!(apart(tool, positions(&bench, cart)) < 1e-9);
            assert!(off_line(tool, from, to) < 1e-9);
        }
        assert!(apart(positions(&bench, cart), to) < 1e-9);
    }
}

#[test]
fn a_path_that_cannot_be_followed_is_refused_before_anything_moves() {
    #[rustfmt::skip]
    let cases = [
        ("beyond the reach",          DELTA,       "MCLM(CART, M, 0, [0, 0, -450]",    (67, 0)),
        ("beyond it in between",      SCARA,       "MCLM(CART, M, 0, [-300, -310, 0]", (68, 0)),
        ("too far out",               SCARA,       "MCLM(CART, M, 0, [400, 400, 0]",   (67, 1)),
        ("through the base's axis",   ARTICULATED, "MCLM(CART, M, 0, [-300, 0, 200]",  (68, 0)),
        ("round the back of it",      ARTICULATED, "MCLM(CART, M, 0, [-250, -300, 150]", (72, 0)),
        ("within reach",              DELTA,       "MCLM(CART, M, 0, [0, 50, -300]",   OK),
    ];
    for (why, machine, call, expected) in cases {
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK, "{why}");
        let before = positions(&bench, &["X", "Y", "Z"]);
        if expected.0 == 72 {
            assert_eq!(
                bench.call(&format!("MCLM(CART, M0, 0, [-250, 300, 150], {TRAPEZOID}, 1)")),
                OK,
                "{why}"
            );
            bench.until("M0", Flag::Pc);
        }
        if why == "beyond it in between" {
            let [x, y, _] = before;
            let call = format!("MCLM(CART, M, 0, [{:?}, {:?}, 0], {TRAPEZOID}, 1)", -x, -y);
            let refused = bench.call(&call);
            assert!(matches!(refused, (67, 1) | (68, 0)), "{why}: {refused:?}");
            continue;
        }
        assert_eq!(bench.call(&format!("{call}, {TRAPEZOID}, 1)")), expected, "{why}");
        if expected != OK && expected.0 != 72 {
            bench.run(20);
            assert_eq!(positions(&bench, &["X", "Y", "Z"]), before, "{why}: nothing moved");
            assert!(bench.control("T").has(Flag::Ip), "{why}: the transform goes on");
        }
    }
}

#[test]
fn near_a_singularity_it_stops_on_the_path() {
    // A line that passes the base's axis at 3 mm: the base would have to turn too fast.
    let machine = RobotMachine {
        joint_speed: 200.0,
        ..ARTICULATED
    };
    let robot = geometry(&machine);
    let mut bench = machine.bench();
    assert_eq!(bench.call(LINK), OK);
    assert_eq!(
        bench.call(&format!("MCLM(CART, M0, 0, [200, 3, 350], {TRAPEZOID}, 1)")),
        OK
    );
    bench.until("M0", Flag::Pc);
    let from = positions(&bench, &["X", "Y", "Z"]);
    let to = [-200.0, 3.0, 350.0];
    assert_eq!(bench.call(&format!("MCLM(CART, M, 0, {to:?}, {TRAPEZOID}, 1)")), OK);
    let mut ticks = 0;
    while bench.control("T").err == 0 || bench.axis("X").command[1] != 0.0 {
        bench.tick();
        ticks += 1;
        assert!(ticks < 5000, "it never stops");
        let tool = robot.forward(positions(&bench, &["J1", "J2", "J3"])).expect("joints");
        assert!(off_line(tool, from, to) < 1e-6, "on the path");
        assert!(
            bench.axis("J1").command[1].abs() <= 200.0 + 1e-6,
            "{:?}",
            bench.axis("J1").command
        );
    }
    let shown = bench.control("T");
    assert_eq!((shown.err, shown.exerr), (69, 0));
    assert!(shown.has(Flag::Er) && !shown.has(Flag::Ip));
    assert!(!bench.control("M").has(Flag::Ip) && !bench.control("M").has(Flag::Pc));
    let stopped = positions(&bench, &["X", "Y", "Z"]);
    assert!(stopped[0] > 3.0, "before the axis of the base: {stopped:?}");
    bench.run(5);
    assert_eq!(
        bench.axis("J1").motion_status & motion_status::TRANSFORM_STATE_STATUS,
        0
    );
    // The robot can be linked again from its present position.
    assert_eq!(bench.call(LINK), OK);
}

#[test]
fn motion_without_a_known_end_stops_at_the_end_of_reach() {
    // A jog of the source out of the workspace.
    for (machine, axis, expected) in [(DELTA, "Z", (67, 0)), (SCARA, "X", (67, 1))] {
        let robot = geometry(&machine);
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK);
        let direction = if axis == "Z" { 1 } else { 0 };
        assert_eq!(
            bench.call(&format!(
                "MAJ({axis}, J, {direction}, 200, 0, 2000, 0, 2000, 0, 0, 100, 100, 2)"
            )),
            OK
        );
        let mut ticks = 0;
        while bench.control("T").err == 0 || bench.axis(axis).command[1] != 0.0 {
            bench.tick();
            ticks += 1;
            assert!(ticks < 5000, "{axis} never stops");
            let tool = robot.forward(positions(&bench, &["J1", "J2", "J3"])).expect("joints");
            assert!(
                apart(tool, positions(&bench, &["X", "Y", "Z"])) < 1e-6,
                "{axis}: still together"
            );
        }
        let shown = bench.control("T");
        assert_eq!((shown.err, shown.exerr), expected, "{axis}");
        assert!(!bench.control("J").has(Flag::Ip));
        bench.run(3);
        assert_eq!(bench.call(LINK), OK, "{axis}: within the workspace still");
    }
}

#[test]
fn joint_limits_slow_the_path_down() {
    let cart = "joint_limits = \"enforce\"\n";
    let machine = RobotMachine {
        joint_speed: 40.0,
        cart,
        ..SCARA
    };
    let robot = geometry(&machine);
    let mut bench = machine.bench();
    assert_eq!(bench.call(LINK), OK);
    for point in [[300.0, 150.0, 20.0], [-100.0, 350.0, -50.0], [-40.0, 120.0, 0.0]] {
        for rates in [S_CURVE, TRAPEZOID] {
            let from = positions(&bench, &["X", "Y", "Z"]);
            let to = if rates == S_CURVE {
                [0, 1, 2].map(|k| 0.5 * (from[k] + point[k]))
            } else {
                point
            };
            assert_eq!(bench.call(&format!("MCLM(CART, M, 0, {to:?}, {rates}, 1)")), OK);
            while !bench.control("M").has(Flag::Pc) {
                bench.tick();
                for joint in ["J1", "J2"] {
                    let [_, speed, acceleration] = bench.axis(joint).command;
                    assert!(speed.abs() <= 40.0 + 1e-6, "{joint}: {speed}");
                    assert!(acceleration.abs() <= 800.0 + 1e-6, "{joint}: {acceleration}");
                }
                assert!(!bench.control("T").has(Flag::Er));
                let tool = robot.forward(positions(&bench, &["J1", "J2", "J3"])).expect("joints");
                assert!(off_line(tool, from, to) < 1e-6);
            }
        }
    }
    // Neither a change of dynamics nor an override makes it faster.
    bench.set_override("CART", 2.0);
    assert_eq!(
        bench.call(&format!("MCLM(CART, M, 0, [300, 150, 20], {TRAPEZOID}, 1)")),
        OK
    );
    bench.run(20);
    assert_eq!(bench.call("MCCD(CART, D, 1, 1, 900, 0, 1, 9000, 0)"), OK);
    while !bench.control("M").has(Flag::Pc) {
        bench.tick();
        for joint in ["J1", "J2"] {
            let [_, speed, acceleration] = bench.axis(joint).command;
            assert!(speed.abs() <= 40.0 + 1e-6, "{joint}: {speed}");
            assert!(acceleration.abs() <= 800.0 + 1e-6, "{joint}: {acceleration}");
        }
        assert!(!bench.control("T").has(Flag::Er));
    }
    // Without the limit, the same is too fast.
    let machine = RobotMachine {
        joint_speed: 40.0,
        ..SCARA
    };
    let mut bench = machine.bench();
    assert_eq!(bench.call(LINK), OK);
    assert_eq!(
        bench.call(&format!("MCLM(CART, M, 0, [-100, 350, -50], {TRAPEZOID}, 1)")),
        OK
    );
    bench.until_rest();
    assert_eq!(bench.control("T").err, 69);
}

#[test]
fn joint_limits_hold_at_corners() {
    // Acceleration of a joint: 800 degrees/s², so 0.8 degrees/s in an update; the axes of the source could do 40 mm/s.
    let steps = |cart: &'static str, kind: u8| {
        let machine = RobotMachine {
            joint_speed: 40.0,
            cart,
            ..SCARA
        };
        let mut bench = machine.bench();
        assert_eq!(bench.call(LINK), OK);
        let [x, y, z] = positions(&bench, &["X", "Y", "Z"]);
        let line = |name: &str, to: [f64; 3], kind: u8| {
            format!("MCLM(CART, {name}, 0, {to:?}, 60, 0, 600, 0, 600, 0, 0, 100, 100, 2, {kind})")
        };
        assert_eq!(bench.call(&line("M", [x - 30.0, y, z], kind)), OK);
        assert_eq!(bench.call(&line("M2", [x - 30.0, y + 30.0, z], 1)), OK);
        let (mut before, mut most, mut slowest) = ([0.0; 2], 0.0_f64, f64::INFINITY);
        while !bench.control("M2").has(Flag::Pc) {
            bench.tick();
            assert!(!bench.control("T").has(Flag::Er));
            let now = ["J1", "J2"].map(|joint| bench.axis(joint).command[1]);
            for (now, before) in now.iter().zip(before) {
                most = most.max((now - before).abs());
            }
            before = now;
            let corner = (bench.position("X") - x + 30.0)
                .abs()
                .max((bench.position("Y") - y).abs())
                < 0.5;
            if corner {
                let speed = ["X", "Y"].map(|axis| bench.axis(axis).command[1]);
                slowest = slowest.min(speed[0].hypot(speed[1]));
            }
        }
        [most, slowest]
    };
    for kind in [4, 5] {
        let [most, slowest] = steps("joint_limits = \"enforce\"\n", kind);
        // The step, and the change that the paths themselves need in the same update.
        assert!(most <= 1.6 + 1e-6, "type {kind}: a step of {most} degrees/s");
        assert!(slowest > 0.1, "type {kind}: it comes to rest");
    }
    let [most, _] = steps("", 5);
    assert!(most > 3.0, "without it the joints step by {most} degrees/s");
}

#[test]
fn robots_lead_cartesian_systems_too() {
    // Joints as the source: their tool leads a Cartesian system.
    let robot = geometry(&SCARA);
    let mut bench = SCARA.bench();
    let joints = positions(&bench, &["J1", "J2", "J3"]);
    let tool = robot.forward(joints).expect("joints");
    for (axis, position) in ["X", "Y", "Z"].into_iter().zip(tool) {
        assert_eq!(
            bench.call(&format!(
                "MAM({axis}, M, 0, {position:?}, 500, 0, 5000, 0, 5000, 0, 0, 100, 100, 2)"
            )),
            OK
        );
        bench.until("M", Flag::Pc);
    }
    assert_eq!(bench.call("MCT(ROBOT, CART, T, [0, 0, 0], [0, 0, 0])"), OK);
    assert_eq!(
        bench.call("MCLM(ROBOT, M, 0, [40, -30, 0], 60, 0, 600, 0, 600, 0, 0, 100, 100, 2, 1)"),
        OK
    );
    while !bench.control("M").has(Flag::Pc) {
        bench.tick();
        let tool = robot.forward(positions(&bench, &["J1", "J2", "J3"])).expect("joints");
        assert!(apart(tool, positions(&bench, &["X", "Y", "Z"])) < 1e-3);
        assert!(!bench.control("T").has(Flag::Er), "{:?}", bench.control("T"));
    }
}

#[test]
fn mct_refuses_invalid_robots() {
    let keys = |keys: &'static str| RobotMachine { keys, ..SCARA };
    #[rustfmt::skip]
    let cases = [
        ("no link lengths",     keys("type = \"scara_independent\"\n"), LINK, (61, 9)),
        ("a delta of equals",   keys("type = \"delta\"\nlink_lengths = [100.0, 100.0]\n"), LINK, (61, 9)),
        ("offsets without room", keys("type = \"delta\"\nlink_lengths = [100.0, 200.0]\nbase_offsets = [150.0, 0.0, 0.0]\n"), LINK, (61, 10)),
        ("neither Cartesian",   keys("type = \"delta\"\nlink_lengths = [100.0, 200.0]\n"), "MCT(ROBOT, ROBOT2, T, [0, 0, 0], [0, 0, 0])", (61, 5)),
        ("stretched",           RobotMachine { joints: &[0.0, -5.0, 0.0], ..SCARA }, LINK, (67, 1)),
        ("folded on the base",  RobotMachine { keys: "type = \"scara_independent\"\nlink_lengths = [200.0, 200.0]\n", joints: &[0.0, 180.0, 0.0], ..SCARA }, LINK, (68, 0)),
    ];
    for (why, machine, call, expected) in cases {
        let more = machine.config()
            + "[[coordinate_system]]\nname = \"ROBOT2\"\naxes = [\"U\", \"V\", \"W\"]\nmax_speed = 1.0\nmax_acceleration = 1.0\n\
               type = \"delta\"\nlink_lengths = [100.0, 200.0]\n";
        assert_eq!(Bench::with(&more).call(call), expected, "{why}");
    }
}

/// spec/coordinated-instructions.md §27.9, through the instructions.
#[test]
fn the_vectors_of_the_specification() {
    let tag = "[[tag]]\nname = \"P\"\ntype = \"REAL[3]\"\n";
    let machine = |keys: &'static str, joints: &'static [f64]| RobotMachine { keys, joints, ..DELTA };
    #[rustfmt::skip]
    let cases = [
        // the geometry and its joints,                                                                                              its solution, the tool
        (machine("type = \"articulated_independent\"\nlink_lengths = [10.0, 10.0]\n", &[0.0, 90.0, -90.0]),                            2, [10.0, 0.0, 10.0]),
        (machine("type = \"articulated_dependent\"\nlink_lengths = [10.0, 10.0]\n", &[0.0, 90.0, 0.0]),                                2, [10.0, 0.0, 10.0]),
        (machine("type = \"scara_independent\"\nlink_lengths = [10.0, 10.0]\n", &[0.0, 90.0, 5.0]),                                    4, [10.0, 10.0, 5.0]),
        (machine("type = \"delta\"\nlink_lengths = [100.0, 200.0]\nbase_offsets = [30.0, 0.0, 0.0]\nend_effector_offsets = [30.0, 0.0, 0.0]\n", &[0.0; 3]), 1, [0.0, 0.0, -173.205_081]),
    ];
    for (machine, solution, tool) in cases {
        let why = machine.keys;
        let mut bench = Bench::with(&(machine.config() + tag));
        let read = |bench: &mut Bench| [0, 1, 2].map(|k| bench.read(&format!("P[{k}]")));
        let joints = [0, 1, 2].map(|k| machine.joints[k]);
        for (direction, from, to) in [(0, joints, tool), (1, tool, joints), (solution, tool, joints)] {
            let call = format!("MCTP(CART, ROBOT, C, [0, 0, 0], [0, 0, 0], {direction}, {from:?}, P)");
            assert_eq!(bench.call(&call), OK, "{why}: {call}");
            assert!(
                apart(read(&mut bench), to) < 2e-5,
                "{why}: {call}: {:?}",
                read(&mut bench)
            );
        }
        assert_eq!(bench.call(LINK), OK, "{why}");
        assert!(apart(positions(&bench, &["X", "Y", "Z"]), tool) < 1e-6, "{why}");
    }
    // The limits of a delta's joints: 97.514 and -55.482. MCT needs arms that are bent.
    let keys = "type = \"delta\"\nlink_lengths = [50.0, 80.0]\nbase_offsets = [20.0, 0.0, 0.0]\n\
                end_effector_offsets = [3.0, 0.0, 0.0]\n";
    for (angle, expected) in [(97.51, OK), (97.52, (67, 0)), (-55.48, OK), (-55.49, (67, 0))] {
        let mut bench = Bench::with(&(machine(keys, &[20.0; 3]).config() + tag));
        let joints = [angle; 3];
        let call = format!("MCTP(CART, ROBOT, C, [0, 0, 0], [0, 0, 0], Forward, {joints:?}, P)");
        assert_eq!(bench.call(&call), expected, "{call}");
    }
    let linked = [
        (&[97.4; 3], OK),
        (&[97.52; 3], (67, 0)),
        (&[-55.3; 3], OK),
        (&[-55.49; 3], (67, 0)),
    ];
    for (joints, expected) in linked {
        assert_eq!(machine(keys, joints).bench().call(LINK), expected, "{joints:?}");
    }
}

#[test]
fn a_joint_does_not_leave_its_soft_travel() {
    let whole = DELTA.config();
    let held = whole.replacen(
        "name = \"J2\"\n",
        "name = \"J2\"\ntravel = { min = -20.0, max = 30.0 }\n",
        1,
    );
    assert_ne!(held, whole);
    for (config, expected) in [(whole, OK), (held, (72, 1))] {
        let mut bench = Bench::with(&config);
        assert_eq!(bench.call(LINK), OK);
        let [x, y, z] = positions(&bench, &["X", "Y", "Z"]);
        // All arms go down.
        let call = format!("MCLM(CART, M, 0, [{x:?}, {y:?}, {:?}], {TRAPEZOID}, 1)", z - 60.0);
        assert_eq!(bench.call(&call), expected, "{call}");
        bench.run(20);
        let moved = positions(&bench, &["X", "Y", "Z"]) != [x, y, z];
        assert_eq!(moved, expected == OK);
        assert!(bench.control("T").has(Flag::Ip), "the transform goes on");
    }
}

#[test]
fn positions_are_calculated_without_motion() {
    let tag = "[[tag]]\nname = \"P\"\ntype = \"REAL[3]\"\n[[tag]]\nname = \"Short\"\ntype = \"REAL[2]\"\n";
    let frames = "[0, 0, 0], [0, 0, 0]";
    let read = |bench: &mut Bench| [0, 1, 2].map(|k| bench.read(&format!("P[{k}]")));
    // spec/coordinated-instructions.md §27.9, and the solutions of §21: left, left mirror, right, right mirror.
    let arm = RobotMachine {
        keys: "type = \"articulated_independent\"\nlink_lengths = [10.0, 10.0]\n",
        joints: &[0.0, 90.0, -90.0],
        ..ARTICULATED
    };
    let mut bench = Bench::with(&(arm.config() + tag));
    let robot = geometry(&arm);
    #[rustfmt::skip]
    let cases = [
        (0, [0.0, 90.0, -90.0], [10.0, 0.0, 10.0]),
        (1, [10.0, 0.0, 10.0],  [0.0, 90.0, -90.0]),
        (2, [10.0, 0.0, 10.0],  [0.0, 90.0, -90.0]),
        (3, [10.0, 0.0, 10.0],  [180.0, 180.0, -90.0]),
        (4, [10.0, 0.0, 10.0],  [0.0, 0.0, 90.0]),
        (5, [10.0, 0.0, 10.0],  [180.0, 90.0, 90.0]),
    ];
    for (direction, from, expected) in cases {
        let call = format!("MCTP(CART, ROBOT, C, {frames}, {direction}, {from:?}, P)");
        assert_eq!(bench.call(&call), OK, "{call}");
        assert_eq!(bench.bits("C"), "EN DN", "{call}");
        let is = read(&mut bench);
        assert!(apart(is, expected) < 1e-5, "{call}: {is:?}");
        if direction > 0 {
            let tool = robot.forward(is).expect("joints");
            assert!(apart(tool, from) < 1e-5, "{call}");
        }
    }
    // A frame before it, and Cartesian systems alone.
    let turned = "[0, 0, 90], [0, 0, 3]";
    assert_eq!(
        bench.call(&format!("MCTP(CART, ROBOT, C, {turned}, 0, [90, 90, -90], P)")),
        OK
    );
    assert!(apart(read(&mut bench), [-10.0, 0.0, 7.0]) < 1e-5);
    assert_eq!(
        bench.call(&format!("MCTP(CART, WORLD, C, {turned}, 1, [1, 2, 3], P)")),
        OK
    );
    assert_eq!(read(&mut bench), [2.0, -1.0, 6.0]);
    assert_eq!(
        bench.call(&format!("MCTP(CART, WORLD, C, {turned}, 0, [2, -1, 6], P)")),
        OK
    );
    assert_eq!(read(&mut bench), [1.0, 2.0, 3.0]);
    // A robot as the source.
    assert_eq!(
        bench.call(&format!("MCTP(ROBOT, CART, C, {frames}, 1, [0, 90, -90], P)")),
        OK
    );
    assert!(apart(read(&mut bench), [10.0, 0.0, 10.0]) < 1e-5);
    #[rustfmt::skip]
    let refused = [
        (format!("MCTP(CART, ROBOT, C, {frames}, 1, [20.1, 0, 0], P)"), (67, 2)),
        (format!("MCTP(CART, ROBOT, C, {frames}, 4, [0, 0, 5], P)"), (68, 0)),
        (format!("MCTP(CART, ROBOT, C, {frames}, 6, [1, 0, 5], P)"), (13, 5)),
        (format!("MCTP(CART, ROBOT, C, {frames}, 1, [1, 0], P)"), (13, 6)),
        (format!("MCTP(CART, ROBOT, C, {frames}, 1, [10, 0, 10], Short)"), (13, 7)),
        (format!("MCTP(CART, WORLD, C, {frames}, 2, [1, 0, 5], P)"), (77, 0)),
        (format!("MCTP(ROBOT, CART, C, {frames}, 4, [1, 0, 5], P)"), (77, 0)),
        ("MCTP(CART, ROBOT, C, [361, 0, 0], [0, 0, 0], 1, [1, 0, 5], P)".into(), (74, 0)),
        (format!("MCTP(CART, CART, C, {frames}, 1, [1, 0, 5], P)"), (61, 2)),
    ];
    for (call, expected) in refused {
        assert_eq!(bench.call(&call), expected, "{call}");
        assert!(
            apart(read(&mut bench), [10.0, 0.0, 10.0]) < 1e-5,
            "{call} writes nothing"
        );
    }
    // Without a tag for the answer the call is verified too.
    assert_eq!(
        bench.call(&format!("MCTP(CART, ROBOT, C, {frames}, 1, [10, 0, 10], 0)")),
        OK
    );
    let delta =
        Bench::with(&(DELTA.config() + tag)).call(&format!("MCTP(CART, ROBOT, C, {frames}, 4, [0, 0, -280], P)"));
    assert_eq!(delta, (77, 0));
    let scara =
        Bench::with(&(SCARA.config() + tag)).call(&format!("MCTP(CART, ROBOT, C, {frames}, 5, [300, 0, 0], P)"));
    assert_eq!(scara, (77, 0));
}
