//! Random programs near the ends of robots' reach and their singularities: with any motion of the source, and however weakly it is
//! stopped, the joints stay together with it, within their speeds and their travel, and nothing steps.
//!
//! `ARCLINE_CASES` sets how many programs are run, `ARCLINE_SEED` the first ([`seeds`]). A program that fails is printed as
//! Structured Text with the machine's configuration.

use arcline_config::load;
use arcline_controller::machine::KinematicStructure;
use arcline_instruction_set::Flag;
use arcline_kinematics::{OrientedRobot, Robot};
use arcline_tests::bench::Bench;
use arcline_tests::random::{Random, seeds};
use arcline_tests::robots::{
    ARTICULATED, ARTICULATED_DEPENDENT, DELTA, DELTA_2, DELTA_J1J2J3J4J5, DELTA_J1J2J3J6, DELTA_J1J2J6, PLANAR,
    PLANAR_INDEPENDENT, RobotMachine, SCARA, SCARA_DELTA, SCARA_J1J2J3J6, SIX_AXES,
};

const MACHINES: [RobotMachine; 13] = [
    DELTA,
    SCARA,
    ARTICULATED,
    PLANAR,
    PLANAR_INDEPENDENT,
    ARTICULATED_DEPENDENT,
    DELTA_2,
    SCARA_DELTA,
    DELTA_J1J2J6,
    DELTA_J1J2J3J6,
    DELTA_J1J2J3J4J5,
    SCARA_J1J2J3J6,
    SIX_AXES,
];

/// The share of Maximum Speed by which a joint may exceed it between two checks of the guard.
const FASTER: f64 = 0.02;
/// Share of a joint's Maximum Speed by which its velocity may change in one update.
const CHANGE: f64 = 1.0;

/// Units between the source and the tool.
const TOGETHER: f64 = 1e-6;
/// The same of a delta in a plane, which takes 1e-3 across its plane for none.
const IN_A_PLANE: f64 = 1.1e-3;

enum Geometry {
    Arm(Robot),
    Wrist(OrientedRobot),
}

/// One program under way.
struct Wanderer {
    random: Random,
    machine: RobotMachine,
    geometry: Geometry,
    bench: Bench,
    config: String,
    program: String,
    joints: Vec<String>,
    axes: Vec<&'static str>,
    /// Travel of the joints.
    travel: Option<Vec<[f64; 2]>>,
    period: f64,
    before: Vec<[f64; 3]>,
    /// A joint moves by itself, or has done.
    joints_move: bool,
    /// The tick of the last MAG without a clutch.
    geared_at: Option<u64>,
    calls: u32,
}

impl Wanderer {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let mut machine = MACHINES[(seed % MACHINES.len() as u64) as usize];
        machine.joint_speed = *random.one_of(&[150.0, 360.0, 1000.0]);
        machine.period = *random.one_of(&[0.5, 1.0, 2.0]);
        let carts = ["", "", "corner = \"precise\"\n", "joint_limits = \"enforce\"\n"];
        machine.cart = carts[random.below(4) as usize];
        if machine.is_oriented() && machine.cart.contains("precise") {
            machine.cart = "";
        }
        let mut config = machine.config();
        let mut travel = None;
        if random.below(3) == 0 {
            let mut ends = Vec::new();
            for (place, joint) in machine.joints.iter().enumerate() {
                let room = [random.between(5.0, 60.0), random.between(5.0, 60.0)];
                let [min, max] = [joint - room[0], joint + room[1]];
                let start = format!("start = {{ position = {joint:?} }}\n");
                let name = format!("name = \"J{}\"", place + 1);
                let at = config.find(&name).expect("the joint is in the configuration");
                let (head, tail) = config.split_at(at);
                let limited = format!("{start}travel = {{ min = {min:?}, max = {max:?} }}\n");
                config = format!("{head}{}", tail.replacen(&start, &limited, 1));
                ends.push([min, max]);
            }
            travel = Some(ends);
        }
        config += "[[tag]]\nname = \"Way\"\ntype = \"PATH_DATA\"\n\
                   value = { InterpolationType = 1, Position = [10, 0, 0, 0, 0, 10, 0, 0, 0], MoveType = 1, TerminationType = 1 }\n\
                   [[tag]]\nname = \"Pace\"\ntype = \"DYNAMICS_DATA\"\n\
                   value = { UnitsMode = 1, Speed = 50, Acceleration = 500, Deceleration = 500, AccelerationJerk = 100, \
                   DecelerationJerk = 100, OrientationSpeed = 200, OrientationAcceleration = 2000, OrientationDeceleration = 2000 }\n";
        let project = load(&config, "robot.toml").unwrap_or_else(|error| panic!("{error:?}\n{config}"));
        let robot = project.machine.systems[2].robot.expect("the system is a robot");
        let geometry = match robot.structure {
            KinematicStructure::Arm(geometry) => {
                Geometry::Arm(Robot::new(geometry, &robot.parameters).expect("a robot"))
            }
            KinematicStructure::Wrist(wrist) => {
                Geometry::Wrist(OrientedRobot::new(wrist, &robot.parameters).expect("a robot"))
            }
        };
        let count = machine.joints.len();
        let axes: Vec<&str> = if machine.is_oriented() {
            vec!["X", "Y", "Z", "RX", "RY", "RZ"]
        } else {
            ["X", "Y", "Z"][..count].to_vec()
        };
        let mut wanderer = Wanderer {
            bench: Bench::with(&config),
            joints: (1..=count).map(|joint| format!("J{joint}")).collect(),
            period: machine.period / 1000.0,
            before: Vec::new(),
            program: String::new(),
            joints_move: false,
            geared_at: None,
            calls: 0,
            random,
            machine,
            geometry,
            config,
            axes,
            travel,
        };
        wanderer.link();
        wanderer.before = wanderer.commands();
        wanderer
    }

    fn link(&mut self) {
        let link = match self.geometry {
            Geometry::Arm(_) => "MCT(CART, ROBOT, T, [0, 0, 0], [0, 0, 0])",
            Geometry::Wrist(_) => "MCTO(CART, ROBOT, T, NoFrame, NoFrame)",
        };
        self.call(link);
    }

    fn call(&mut self, call: &str) -> (i16, i8) {
        let tick = self.bench.now();
        let result = self.bench.call(call);
        self.program += &format!("{call};    // tick {tick}, {result:?}\n");
        result
    }

    fn commands(&self) -> Vec<[f64; 3]> {
        self.joints.iter().map(|joint| self.bench.axis(joint).command).collect()
    }

    fn tag(&mut self) -> String {
        self.calls += 1;
        format!("K{}", self.calls % 16)
    }

    /// Speed, acceleration, deceleration, profile and jerks.
    fn rates(&mut self) -> String {
        let speed = self.random.between(20.0, 600.0);
        let [up, down] = [0; 2].map(|_| *self.random.one_of(&[500.0, 2000.0, 8000.0]));
        let profile = self.random.below(2);
        let jerk = self.random.one_of(&["100, 100, 2", "60, 80, 2", "30, 30, 2"]);
        format!("{speed}, 0, {up}, 0, {down}, 0, {profile}, {jerk}")
    }

    fn steps(&mut self) -> Vec<f64> {
        let count = self.axes.len().min(3);
        let far = *self.random.one_of(&[30.0, 150.0, 500.0]);
        (0..count).map(|_| self.random.between(-far, far)).collect()
    }

    /// One instruction.
    fn act(&mut self) {
        let tag = self.tag();
        let rates = self.rates();
        let axis = *self.random.one_of(&self.axes.clone());
        let turns = axis.starts_with('R');
        // The test does not include a contour beside single axes' motion.
        let precise = self.machine.cart.contains("precise");
        let kind = if precise {
            *self.random.one_of(&[4, 5, 7, 11, 12, 13, 15])
        } else {
            self.random.below(16)
        };
        match kind {
            0..=2 => {
                let direction = self.random.below(2);
                self.call(&format!("MAJ({axis}, {tag}, {direction}, {rates})"));
            }
            3 => {
                let far = if turns { 120.0 } else { 300.0 };
                let way = self.random.between(-far, far);
                self.call(&format!("MAM({axis}, {tag}, 1, {way}, {rates})"));
            }
            4..=6 => {
                let steps = self.steps();
                let ending = self.random.below(5);
                self.call(&format!("MCLM(CART, {tag}, 1, {steps:?}, {rates}, {ending})"));
            }
            7 if self.machine.is_oriented() => {
                let mut position: Vec<f64> = self.steps();
                for _ in 0..3 {
                    let turn = self.random.between(-90.0, 90.0);
                    position.push(turn);
                }
                for (place, value) in position.iter().enumerate() {
                    self.bench.write(&format!("Way.Position[{place}]"), *value);
                    self.program += &format!("Way.Position[{place}] := {value};\n");
                }
                let speed = self.random.between(20.0, 500.0);
                self.bench.write("Pace.Speed", speed);
                self.program += &format!("Pace.Speed := {speed};\n");
                self.call(&format!("MCPM(CART, {tag}, Way, 1, Pace)"));
            }
            7 => {
                let (end, via) = (self.steps(), self.steps());
                self.call(&format!("MCCM(CART, {tag}, 1, {end:?}, 0, {via:?}, 0, {rates}, 1)"));
            }
            8 => {
                let ratio = self.random.between(-2.0, 2.0).abs();
                let direction = self.random.below(2);
                let clutch = *self.random.one_of(&["Enabled", "Enabled", "Disabled"]);
                let geared = self.call(&format!(
                    "MAG({axis}, U, {tag}, {direction}, {ratio}, 1, 1, Command, Real, {clutch}, 3000, 0)"
                ));
                if clutch == "Disabled" && geared == (0, 0) {
                    self.geared_at = Some(self.bench.now());
                }
                let direction = self.random.below(2);
                self.call(&format!("MAJ(U, JU, {direction}, {rates})"));
            }
            9 => {
                self.call(&format!("MDCC(CART, U, {tag}, Command, 0)"));
                let steps = self.steps();
                let tag = self.tag();
                let [speed, rate] = [self.random.between(0.2, 3.0), self.random.between(0.02, 0.5)];
                let profile = self.random.below(2);
                self.call(&format!(
                    "MCLM(CART, {tag}, 1, {steps:?}, {speed}, 4, {rate}, 4, {rate}, 4, {profile}, 100, 100, 6, 1, Disabled, \
                     Programmed, 0, 0, ImmediateForwardOnly, 0, 0)"
                ));
                self.call(&format!("MAJ(U, JU, 0, {rates})"));
            }
            10 => {
                let kind = self.random.one_of(&["All", "Jog", "Move", "Gear"]);
                let rate = *self.random.one_of(&[100.0, 400.0, 3000.0]);
                self.call(&format!("MAS({axis}, {tag}, {kind}, Yes, {rate}, 0, No, 100, 2)"));
            }
            11 => {
                let rate = *self.random.one_of(&[100.0, 300.0, 3000.0]);
                self.call(&format!("MCS(CART, {tag}, 2, 1, {rate}, 0, 0, 100, 2)"));
            }
            12 => {
                let [speed, rate] = [
                    self.random.between(0.0, 500.0),
                    *self.random.one_of(&[200.0, 1000.0, 6000.0]),
                ];
                self.call(&format!(
                    "MCCD(CART, {tag}, CoordinatedMove, Yes, {speed}, 0, Yes, {rate}, 0, Yes, {rate}, 0)"
                ));
            }
            13 => {
                let share = *self.random.one_of(&[0.0, 0.3, 1.0, 1.5]);
                self.bench.set_override("CART", share);
                self.program += &format!("(* override of CART {share} *)\n");
            }
            14 if self.random.below(2) == 0 => {
                self.joints_move = true;
                let joint = self.random.one_of(&self.joints.clone()).clone();
                let direction = self.random.below(2);
                let speed = self.random.between(5.0, 100.0);
                self.call(&format!(
                    "MAJ({joint}, {tag}, {direction}, {speed}, 0, 2000, 0, 2000, 0, 0, 100, 100, 2)"
                ));
            }
            14 => {
                self.joints_move = true;
                let joint = self.random.one_of(&self.joints.clone()).clone();
                let way = self.random.between(-60.0, 60.0);
                self.call(&format!(
                    "MAM({joint}, {tag}, 1, {way}, 80, 0, 800, 0, 800, 0, 1, 100, 100, 2)"
                ));
            }
            _ => {
                if !self.bench.control("T").has(Flag::Ip) {
                    self.link();
                }
            }
        }
    }

    fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.bench.tick();
            self.check();
        }
    }

    fn check(&mut self) {
        let now = self.commands();
        let at = self.bench.now();
        for place in 0..now.len() {
            let ([p0, v0, _], [p1, v1, _]) = (self.before[place], now[place]);
            let joint = &self.joints[place];
            assert!(p1.is_finite() && v1.is_finite(), "tick {at}: {joint} at {p1}, {v1}/s");
            let most = self.machine.joint_speed;
            let allowed = most * (1.0 + FASTER) + if self.joints_move { 100.0 } else { 0.0 };
            assert!(v1.abs() <= allowed, "tick {at}: {joint} at {v1} units/s of {most}");
            let step = (p1 - p0) - 0.5 * (v0 + v1) * self.period;
            assert!(
                step.abs() <= (0.5 * (v1 - v0).abs() + 0.05 * most) * self.period + 1e-6,
                "tick {at}: {joint} steps from {p0} to {p1} at {v0} and {v1} units/s"
            );
            // A slave without a clutch has the geared speed at once, even from the opposite direction.
            let change = if self.geared_at == Some(at - 1) {
                2.0 * CHANGE
            } else {
                CHANGE
            };
            assert!(
                (v1 - v0).abs() <= change * most,
                "tick {at}: {joint} changes from {v0} to {v1} units/s of {most}"
            );
            // Without a transform, its own faults hold the robot there.
            let kept = !self.joints_move || self.bench.control("T").has(Flag::Ip);
            if let Some(travel) = self.travel.as_ref().filter(|_| kept) {
                let [min, max] = travel[place];
                assert!(
                    p1 >= min - 1e-3 && p1 <= max + 1e-3,
                    "tick {at}: {joint} at {p1}, its travel is {min} to {max}; {v0} and {v1} units/s; {:?}",
                    self.bench.control("T")
                );
            }
        }
        self.before = now;
        if self.bench.control("T").has(Flag::Ip) {
            self.check_agreement();
        }
    }

    fn check_agreement(&self) {
        let joints: Vec<f64> = self.before.iter().map(|joint| joint[0]).collect();
        let source: Vec<f64> = self.axes.iter().map(|axis| self.bench.axis(axis).command[0]).collect();
        let at = |place: usize| joints.get(place).copied().unwrap_or(0.0);
        let tool: Vec<f64> = match &self.geometry {
            Geometry::Arm(robot) => {
                let point = robot.forward([at(0), at(1), at(2)]).expect("joints that are linked");
                point[..source.len()].to_vec()
            }
            Geometry::Wrist(robot) => {
                let taken = robot
                    .forward(&std::array::from_fn::<f64, 6, _>(at))
                    .expect("joints that are linked");
                taken.pose.position.iter().copied().collect()
            }
        };
        let planar = self.machine.is_oriented() && joints.len() == 3;
        let together = if planar { IN_A_PLANE } else { TOGETHER };
        for (place, (tool, source)) in tool.iter().zip(&source).enumerate() {
            assert!(
                (tool - source).abs() < together,
                "tick {}: {} is at {source}, the tool at {tool}",
                self.bench.now(),
                self.axes[place]
            );
        }
    }

    /// Everything is stopped and comes to rest.
    fn finish(&mut self) {
        self.bench.set_override("CART", 1.0);
        self.call("MCS(CART, SA, 2, 0, 100, 0, 0, 100, 2)");
        let joints = self.joints.clone();
        let axes = self.axes.clone();
        for (place, axis) in axes
            .into_iter()
            .chain(["U"])
            .chain(joints.iter().map(String::as_str))
            .enumerate()
        {
            for kind in ["Jog", "Move", "Gear"] {
                self.call(&format!(
                    "MAS({axis}, {}{place}, {kind}, No, 100, 0, No, 100, 2)",
                    &kind[..1]
                ));
            }
        }
        // An MAS with 100 units/s² may have been first.
        for _ in 0..(12.0 / self.period) as u64 {
            self.run(1);
            if self.moving().is_none() {
                break;
            }
        }
        assert_eq!(self.moving(), None, "it still moves");
    }

    /// An axis that moves.
    fn moving(&self) -> Option<String> {
        let mut axes = self.joints.iter().map(String::as_str).chain(self.axes.iter().copied());
        let moving = axes.find(|axis| self.bench.axis(axis).command[1] != 0.0);
        moving.map(str::to_owned)
    }
}

fn wander(wanderer: &mut Wanderer) {
    for _ in 0..wanderer.random.below(6) + 3 {
        wanderer.act();
        let seconds = wanderer.random.between(0.0, 0.4);
        let ticks = (seconds / wanderer.period) as u64;
        wanderer.program += &format!("DELAY({seconds});\n");
        wanderer.run(ticks);
    }
    wanderer.run((0.4 / wanderer.period) as u64);
    wanderer.finish();
}

#[test]
fn joints_stay_within_their_limits_with_any_motion_of_the_source() {
    let cases = seeds(400);
    let mut failed = Vec::new();
    for seed in cases.clone() {
        let mut one = Wanderer::new(seed);
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| wander(&mut one)));
        if let Err(cause) = result {
            let cause = cause.downcast_ref::<String>().cloned().unwrap_or_default();
            if failed.is_empty() {
                println!("seed {seed}:\n{}\n{}\n{cause}\n", one.config, one.program);
            }
            failed.push(format!(
                "{seed} ({}): {cause}",
                one.machine.keys.lines().take(2).collect::<String>()
            ));
        }
    }
    assert!(
        failed.is_empty(),
        "{} of {cases:?}:\n{}",
        failed.len(),
        failed.join("\n")
    );
}
