//! Random programs of robots: path moves, lines, arcs and single axes, merges, changes of dynamics, overrides and stops on a
//! Cartesian system behind which a robot of any geometry moves.
//!
//! A seed and a [`Scope`] make one program; [`run`] makes many, and prints one that fails as Structured Text behind its
//! configuration. At every tick the velocity of each axis is that of its positions and changes by no more than the programmed
//! rates allow, each joint keeps its Maximum Speed, and the joints are where the source says. Afterwards every instruction has
//! ended in one way and nothing moves.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use arcline_config::load;
use arcline_controller::Snapshot;
use arcline_controller::machine::KinematicStructure;
use arcline_geometry::{Frame, Point};
use arcline_instruction_set::Flag;
use arcline_kinematics::{OrientedRobot, Pose, Robot, end_of_arm, tool_centre};

use crate::bench::Bench;
use crate::random::{Random, seeds};
use crate::robots::{
    ARTICULATED, ARTICULATED_DEPENDENT, DELTA, DELTA_2, DELTA_J1J2J3J4J5, DELTA_J1J2J3J6, DELTA_J1J2J6, PLANAR,
    PLANAR_INDEPENDENT, RobotMachine, SCARA, SCARA_DELTA, SCARA_J1J2J3J6, SIX_AXES,
};

/// The scope of the programs.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    /// The machines that take turns.
    pub machines: &'static [RobotMachine],
    /// Keys of the source of a robot without orientation.
    pub cart: &'static str,
    /// The tool stays within this distance of where it begins, in each coordinate, position units.
    pub reach: f64,
    /// It turns about Z within this angle of where it begins, degrees, and tilts within a third of that. A joint that only turns the
    /// tool takes it four times as far.
    pub turn: f64,
    /// A joint is moved by itself by at most this angle, degrees.
    pub joint: f64,
    /// Errors of moves that programs may make.
    pub refused: &'static [i16],
    /// Whether the transform may end with an error.
    pub may_fail: bool,
    /// Ticks of a program before everything is stopped, at most.
    pub ticks: u64,
}

impl Scope {
    /// Well inside the reach of every robot and away from its singularities.
    pub const INSIDE: Scope = Scope {
        machines: &[
            DELTA_J1J2J6,
            SIX_AXES,
            DELTA_J1J2J3J6,
            DELTA,
            SCARA_J1J2J3J6,
            SIX_AXES,
            DELTA_J1J2J3J4J5,
            SCARA,
            ARTICULATED,
            SIX_AXES,
            PLANAR,
            PLANAR_INDEPENDENT,
            ARTICULATED_DEPENDENT,
            DELTA_2,
            SCARA_DELTA,
        ],
        cart: "",
        reach: 25.0,
        turn: 24.0,
        joint: 6.0,
        refused: &[],
        may_fail: false,
        ticks: 400,
    };

    /// The same with lines and arcs as planned contours, of every robot whose source has no orientation: MCPM errs with 99 there.
    pub const PRECISE: Scope = Scope {
        machines: &[
            DELTA,
            SCARA,
            ARTICULATED,
            PLANAR,
            PLANAR_INDEPENDENT,
            ARTICULATED_DEPENDENT,
            DELTA_2,
            SCARA_DELTA,
        ],
        cart: "corner = \"precise\"\n",
        ..Scope::INSIDE
    };
}

/// Largest programmed rate along lines, units/s².
const RATE: f64 = 2000.0;
/// Largest programmed rate of turns and of joints, degrees/s².
const TURN_RATE: f64 = 1000.0;
/// Maxima of the turn, degrees/s and degrees/s².
const MAX_TURN: [f64; 2] = [360.0, 3600.0];
/// A stop has this share of the Maximum Decelerations, which are 10000 units/s² and [`MAX_TURN`].
const STOP: f64 = 0.25;
/// The further travel of a joint within a tick beyond its velocity, degrees/s², away from singularities.
const JOINT_RATE: f64 = 150_000.0;
/// A J5 below this angle, degrees, is near the singularity of a wrist.
const SINGULAR: f64 = 8.0;
/// The velocity that a corner may change, units/s.
const CORNER: f64 = 700.0;
/// Full queues, stops under way, and stops of objects at rest.
const USUAL: [i16; 4] = [0, 23, 43, 78];

const CARTESIAN: [&str; 6] = ["X", "Y", "Z", "RX", "RY", "RZ"];
const JOINTS: [&str; 6] = ["J1", "J2", "J3", "J4", "J5", "J6"];
const TAGS: &str = "[[tag]]\nname = \"Way\"\ntype = \"PATH_DATA\"\nvalue = { InterpolationType = 1 }\n\
                    [[tag]]\nname = \"Pace\"\ntype = \"DYNAMICS_DATA\"\nvalue = { UnitsMode = 1 }\n";
const CART: &str = "actual_tolerance = 0.01\nmax_orientation_speed = 360.0\nmax_orientation_acceleration = 3600.0\n";

/// The kinematics from a robot's joints to its tool.
enum Mechanism {
    /// The arm, behind the frame of the source.
    Arm(Robot, Frame),
    /// The robot with a wrist, with the frames of work and tool.
    Wrist(OrientedRobot, [Pose; 2]),
}

/// One random program on its machine.
pub struct RobotProgram {
    /// The machine it runs on.
    pub bench: Bench,
    /// The instructions so far, as Structured Text.
    pub text: String,
    /// Its configuration.
    pub config: String,
    scope: Scope,
    random: Random,
    mechanism: Mechanism,
    /// Axes of `CART` and of the robot, by place in the machine.
    axes: [Vec<usize>; 2],
    /// Maximum Speed of the joints, degrees/s.
    joint_speed: f64,
    /// Seconds.
    period: f64,
    /// The pose of the tool at the beginning.
    base: [f64; 6],
    /// The joint of a robot that cannot do both at once tilts, and does not turn.
    tilts: bool,
    /// Termination types 4 and 5 make a declared step of the velocity in a corner.
    corners: bool,
    /// Whether single axes move too: the sum on an axis has a wider bound.
    singles: bool,
    /// It came near the singularity of a wrist: the transform may fail, and only the speed bounds its joints.
    was_singular: bool,
    executed: u32,
    ticks: u64,
}

impl RobotProgram {
    /// The machine of a seed, with its transform under way.
    pub fn new(seed: u64, scope: &Scope) -> Self {
        let mut random = Random(seed.wrapping_mul(0x2545_F491_4F6C_DD1D) ^ 0x6A09_E667);
        let machine = scope.machines[(seed % scope.machines.len() as u64) as usize];
        let period = *random.one_of(&[1.0, 1.0, 2.0, 4.0]);
        let machine = RobotMachine {
            cart: if machine.is_oriented() { CART } else { scope.cart },
            period,
            ..machine
        };
        let config = format!("{}{TAGS}", machine.config());
        let project = load(&config, "robot.toml").expect("the configuration is valid");
        let described = project.machine.systems[2].robot.expect("the system is a robot");
        let mechanism = match described.structure {
            KinematicStructure::Arm(geometry) => {
                let robot = Robot::new(geometry, &described.parameters).expect("the parameters make a robot");
                Mechanism::Arm(robot, Frame::new(Point::zeros(), Point::zeros()))
            }
            KinematicStructure::Wrist(wrist) => Mechanism::Wrist(
                OrientedRobot::new(wrist, &described.parameters).expect("the parameters make a robot"),
                [Pose::identity(); 2],
            ),
        };
        let bench = Bench::of(project);
        let places = |names: &[&str]| -> Vec<usize> {
            let found = names.iter().filter_map(|name| bench.machine().axis(name));
            found.map(usize::from).collect()
        };
        let joints = machine.joints.len();
        let source = if machine.is_oriented() { 6 } else { joints };
        let mut program = RobotProgram {
            axes: [places(&CARTESIAN[..source]), places(&JOINTS[..joints])],
            bench,
            text: String::new(),
            config,
            scope: *scope,
            mechanism,
            joint_speed: machine.joint_speed,
            period: period / 1000.0,
            base: [0.0; 6],
            tilts: random.below(2) == 0,
            singles: random.below(2) == 0,
            was_singular: false,
            corners: random.below(4) == 0,
            random,
            executed: 0,
            ticks: 0,
        };
        program.link();
        program
    }

    /// Whether the source turns the tool too.
    fn is_oriented(&self) -> bool {
        matches!(self.mechanism, Mechanism::Wrist(..))
    }

    /// An arm of six joints, which can do everything.
    fn is_free(&self) -> bool {
        self.is_oriented() && self.axes[1].len() == 6
    }

    /// A delta whose tool either tilts or turns along a path.
    fn swings(&self) -> bool {
        self.is_oriented() && self.axes[1].len() == 5
    }

    fn is_planar(&self) -> bool {
        self.axes[0].len() == 2 || (self.is_oriented() && self.axes[1].len() == 3)
    }

    /// Links the robot, with frames that make the angles of its tool unambiguous.
    fn link(&mut self) {
        if !self.is_oriented() {
            let mut turned = Point::new(0.0, 0.0, self.random.between(-50.0, 50.0));
            let mut moved = Point::new(5.0, -3.0, 7.0);
            if self.is_planar() {
                (turned.z, moved.z) = (0.0, 0.0);
            }
            if let Mechanism::Arm(_, frame) = &mut self.mechanism {
                *frame = Frame::new(turned, moved);
            }
            self.execute(&format!(
                "MCT(CART, ROBOT, Link, [0, 0, {:?}], [5, -3, {:?}])",
                turned.z, moved.z
            ));
        } else {
            let mut work = [10.0, 0.0, -5.0, 0.0, 0.0, 0.0];
            // A tool that swings only tilts where the angles of its frame do.
            let tool = [0.0, 0.0, 40.0, 0.0, 0.0, if self.swings() { 0.0 } else { 15.0 }];
            while self.is_free() {
                for angle in &mut work[3..] {
                    *angle = f64::from(self.random.between(-89.0, 89.0) as f32);
                }
                self.frames(work, tool);
                let joints = self.joints();
                if self.tool(&joints).coordinates()[4].abs() < 40.0 {
                    break;
                }
            }
            self.frames(work, tool);
            for (tag, values) in [("Work", work), ("Tool", tool)] {
                for (member, value) in ["X", "Y", "Z", "Rx", "Ry", "Rz"].iter().zip(values) {
                    self.write(&format!("{tag}.{member}"), value);
                }
            }
            self.execute("MCTO(CART, ROBOT, Link, Work, Tool)");
        }
        assert!(self.bench.control("Link").has(Flag::Ip), "the transform begins");
        self.run_for(1);
        for (place, axis) in self.axes[0].clone().into_iter().enumerate() {
            self.base[place] = self.bench.snapshot().axes[axis].command[0];
        }
    }

    fn frames(&mut self, work: [f64; 6], tool: [f64; 6]) {
        if let Mechanism::Wrist(_, frames) = &mut self.mechanism {
            *frames = [work, tool].map(Pose::new);
        }
    }

    fn joints(&self) -> [f64; 6] {
        let snapshot = self.bench.snapshot();
        let mut joints = [0.0; 6];
        for (joint, axis) in joints.iter_mut().zip(&self.axes[1]) {
            *joint = snapshot.axes[*axis].command[0];
        }
        joints
    }

    /// The pose of the tool in the work frame, of a robot with a wrist with these joints.
    fn tool(&self, joints: &[f64; 6]) -> Pose {
        let Mechanism::Wrist(robot, [work, tool]) = &self.mechanism else {
            panic!("the robot has no wrist");
        };
        let taken = robot.forward(joints).expect("joints of the robot");
        tool_centre(work, &taken.pose, tool)
    }

    /// Executes an instruction with a motion control tag of its own: `{tag}` stands for it.
    fn execute(&mut self, call: &str) {
        self.executed += 1;
        let call = call.replace("{tag}", &format!("I{}", self.executed));
        let _ = writeln!(self.text, "{call};");
        let (error, detail) = self.bench.call(&call);
        let expected = USUAL.contains(&error) || self.scope.refused.contains(&error);
        assert!(expected, "ERR {error}, EXERR {detail} of {call}");
    }

    fn write(&mut self, tag: &str, value: f64) {
        let _ = writeln!(self.text, "{tag} := {value:?};");
        self.bench.write(tag, value);
    }

    /// Speed and rates up to a rate, at most so fast.
    fn rates(&mut self, speed: f64, rate: f64) -> [f64; 3] {
        let speed = self.random.between(0.1 * speed, speed);
        [
            speed,
            self.random.between(0.3 * rate, rate),
            self.random.between(0.3 * rate, rate),
        ]
    }

    /// The operands from Speed on.
    fn dynamics(&mut self, speed: f64, rate: f64) -> String {
        let [speed, up, down] = self.rates(speed, rate);
        let (profile, jerk) = (self.random.below(2), self.random.between(20.0, 100.0));
        format!("{speed}, 0, {up}, 0, {down}, 0, {profile}, {jerk}, {jerk}, 2")
    }

    /// A point near the beginning.
    fn point(&mut self) -> [f64; 3] {
        let (reach, planar) = (self.scope.reach, self.is_planar());
        let mut point = [0, 1, 2].map(|place| self.base[place] + self.random.between(-reach, reach));
        if planar && self.is_oriented() {
            point[1] = self.base[1];
        }
        point
    }

    fn path(&mut self) {
        let [x, y, z] = self.point();
        let turn = self.scope.turn;
        let mut to = [x, y, z, self.base[3], self.base[4], self.base[5]];
        let mut incremental = self.random.below(4) == 0;
        if self.is_free() {
            for (place, most) in [(3, turn / 3.0), (4, turn / 3.0), (5, turn)] {
                to[place] += self.random.between(-most, most);
            }
        } else if self.swings() {
            // The start is arbitrary, so the move does only the one or the other.
            incremental = true;
            let place = if self.tilts { 4 } else { 5 };
            to[place] += self.random.between(-turn / 4.0, turn / 4.0);
        } else {
            to[5] += self.random.between(-4.0 * turn, 4.0 * turn);
        }
        if incremental {
            let share = if self.is_free() { 0.2 } else { 1.0 };
            for (to, base) in to.iter_mut().zip(self.base) {
                *to = share * (*to - base);
            }
            for to in &mut to[..3] {
                *to *= 0.2;
            }
        }
        if self.random.below(6) == 0 {
            // The parts of the move that only turn, or only move.
            let standing = self.random.below(2) == 0;
            for (place, to) in to.iter_mut().enumerate().filter(|(place, _)| standing == (*place < 3)) {
                *to = if incremental { 0.0 } else { self.base[place] };
            }
        }
        for (place, to) in to.into_iter().enumerate() {
            self.write(&format!("Way.Position[{place}]"), f64::from(to as f32));
        }
        self.write("Way.MoveType", f64::from(u8::from(incremental)));
        let whole = !self.is_free() && !self.swings() && self.random.below(8) == 0;
        let turns = if whole { *self.random.one_of(&[1.0, -1.0]) } else { 0.0 };
        self.write("Way.TurnsCounters[2]", turns);
        let termination = *self.random.one_of(&[0.0, 1.0, 6.0, 6.0]);
        let tolerance = self.random.between(0.0, 20.0);
        self.write("Way.TerminationType", termination);
        self.write("Way.CommandToleranceLinear", tolerance);
        let profile = self.random.below(2) as f64;
        self.write("Pace.Profile", profile);
        for (part, speed, rate) in [("", 300.0, RATE), ("Orientation", 200.0, TURN_RATE)] {
            let rates = self.rates(speed, rate);
            for (name, value) in ["Speed", "Acceleration", "Deceleration"].iter().zip(rates) {
                self.write(&format!("Pace.{part}{name}"), value);
            }
        }
        let jerk = self.random.between(20.0, 100.0);
        self.write("Pace.AccelerationJerk", jerk);
        self.write("Pace.DecelerationJerk", jerk);
        self.execute("MCPM(CART, {tag}, Way, 1, Pace)");
    }

    /// The termination type of a line or an arc.
    fn termination(&mut self) -> i32 {
        let types: &[i32] = if self.corners {
            &[1, 2, 3, 4, 5, 6]
        } else {
            &[0, 1, 2, 3, 6]
        };
        let termination = *self.random.one_of(types);
        // Only a system with orientation has an Actual Tolerance here.
        if termination == 0 && !self.is_oriented() {
            1
        } else {
            termination
        }
    }

    fn line(&mut self) {
        let point = self.point();
        let axes = self.axes[0].len().min(3);
        let dynamics = self.dynamics(300.0, RATE);
        let termination = self.termination();
        let merge = if self.random.below(5) == 0 {
            1 + self.random.below(2)
        } else {
            0
        };
        let (speed, tolerance) = (self.random.below(2), self.random.between(0.0, 15.0));
        self.execute(&format!(
            "MCLM(CART, {{tag}}, 0, {:?}, {dynamics}, {termination}, {merge}, {speed}, {tolerance})",
            &point[..axes]
        ));
    }

    /// Half a circle, or a whole one, of a robot whose source is a plane; a quarter in space.
    fn arc(&mut self) {
        let radius = self.random.between(1.0, 0.25 * self.scope.reach);
        let dynamics = self.dynamics(150.0, RATE);
        let termination = self.termination();
        let merge = u64::from(self.random.below(5) == 0);
        let (to, centre) = match (self.is_planar(), self.random.below(2)) {
            (true, 0) => (vec![0.0, 0.0], vec![radius, 0.0]),
            (true, _) => (vec![2.0 * radius, 0.0], vec![radius, 0.0]),
            (false, _) => (vec![radius, radius, 0.0], vec![radius, 0.0, 0.0]),
        };
        let direction = self.random.below(2);
        self.execute(&format!(
            "MCCM(CART, {{tag}}, 1, {to:?}, 3, {centre:?}, {direction}, {dynamics}, {termination}, {merge}, 0, 5)"
        ));
    }

    /// An axis of the source or a joint by itself.
    fn single(&mut self) {
        let joint = self.random.below(2) == 0;
        let joints = self.axes[1].len();
        let (axis, way) = if joint {
            let place = self.random.below(joints as u64) as usize;
            (JOINTS[place], self.scope.joint)
        } else if self.is_oriented() {
            let angle = if self.is_free() { 3 + self.random.below(3) } else { 5 };
            (CARTESIAN[angle as usize], 0.5 * self.scope.turn)
        } else {
            let place = self.random.below(self.axes[0].len() as u64) as usize;
            (CARTESIAN[place], 0.3 * self.scope.reach)
        };
        let way = self.random.between(-way, way);
        let dynamics = self.dynamics(100.0, TURN_RATE);
        self.execute(&format!("MAM({axis}, {{tag}}, 1, {way}, {dynamics})"));
    }

    /// MCCD of the active move, or of all.
    fn change(&mut self) {
        let speed = if self.random.below(6) == 0 {
            0.0
        } else {
            self.random.between(20.0, 300.0)
        };
        // At least every programmed deceleration: a move that overshoots leaves the reach.
        let (rate, scope) = (RATE, self.random.below(2));
        let call = |speed: f64| {
            format!("MCCD(CART, {{tag}}, 1, 1, {speed}, 0, 1, {rate}, 0, 1, {rate}, 0, 0, 0, 0, 0, 0, {scope})")
        };
        self.execute(&call(speed));
        if speed == 0.0 {
            self.run_for(40);
            self.execute(&call(100.0));
        }
    }

    fn stop(&mut self) {
        let percent = 100.0 * STOP;
        let call = match self.random.below(4) {
            0 | 1 => format!("MCS(CART, {{tag}}, 2, 1, {percent}, 1, 0, 0, 2)"),
            2 => {
                let joint = JOINTS[self.random.below(self.axes[1].len() as u64) as usize];
                format!("MAS({joint}, {{tag}}, 2, 1, {TURN_RATE}, 0, 0, 0, 2)")
            }
            _ => {
                let axis = if self.is_oriented() { "RZ" } else { "X" };
                format!("MAS({axis}, {{tag}}, 2, 1, {TURN_RATE}, 0, 0, 0, 2)")
            }
        };
        self.execute(&call);
    }

    fn hold(&mut self) {
        let percent = *self.random.one_of(&[0.0, 20.0, 60.0, 100.0]);
        let _ = writeln!(self.text, "CART.FeedOverride := {percent};");
        self.bench.set_override("CART", percent / 100.0);
        self.run_for(20);
    }

    /// Runs for a number of milliseconds at most.
    fn run_for(&mut self, ticks: u64) {
        let ticks = ticks.div_ceil((self.period * 1000.0) as u64);
        let _ = writeln!(self.text, "DELAY({});", ticks as f64 * self.period);
        for _ in 0..ticks {
            self.tick();
        }
    }

    /// Makes one tick: no axis jumps, and both sides agree.
    fn tick(&mut self) {
        let before = self.bench.snapshot();
        self.bench.tick();
        self.ticks += 1;
        let after = self.bench.snapshot();
        let failed = self.bench.control("Link").has(Flag::Er);
        self.was_singular |= self.is_singular(&after);
        assert!(
            self.scope.may_fail || self.was_singular || !failed,
            "the transform fails: {:?}",
            self.bench.control("Link").err
        );
        let oriented = self.is_oriented();
        for side in 0..2 {
            for (place, axis) in self.axes[side].iter().enumerate() {
                let most = if self.was_singular {
                    f64::INFINITY
                } else if self.corners && (side == 1 || place < 3) {
                    CORNER / self.period
                } else if side == 1 || self.singles {
                    JOINT_RATE
                } else {
                    most(place, oriented)
                };
                self.check_axis(*axis, [&before, &after], most);
            }
        }
        if self.bench.control("Link").has(Flag::Ip) {
            self.check_sides(&after);
        }
    }

    /// Checks that the velocity of an axis is that of its positions, and that it changes by at most `most` in a second.
    fn check_axis(&self, axis: usize, [before, after]: [&Snapshot; 2], most: f64) {
        let name = &self.bench.machine().axes[axis].name;
        let [b, a] = [before, after].map(|snapshot| snapshot.axes[axis].command);
        assert!(a.iter().all(|value| value.is_finite()), "{name}: {a:?}");
        let step = most * self.period;
        assert!(
            (a[1] - b[1]).abs() <= step,
            "{name}: velocity from {} to {}, by more than {step}",
            b[1],
            a[1]
        );
        let mean = 0.5 * (a[1] + b[1]) * self.period;
        assert!(
            (a[0] - b[0] - mean).abs() <= step * self.period,
            "{name}: position from {} to {} at {} units/s",
            b[0],
            a[0],
            a[1]
        );
        assert!(
            !self.axes[1].contains(&axis) || a[1].abs() <= self.joint_speed,
            "{name}: {} degrees/s",
            a[1]
        );
    }

    /// Whether a wrist is so near to its singularity, at which the axes of J4 and J6 lie in one line, that these two joints turn at
    /// their full speed. Single axes, residuals and turns about another axis than Z lead there from the start of the program.
    fn is_singular(&self, shown: &Snapshot) -> bool {
        let is_wrist = matches!(self.mechanism, Mechanism::Wrist(..)) && self.axes[1].len() == JOINTS.len();
        is_wrist && shown.axes[self.axes[1][4]].command[0].abs() < SINGULAR
    }

    /// The joints are where the source says.
    fn check_sides(&self, shown: &Snapshot) {
        let mut source = [0.0; 6];
        for (place, axis) in self.axes[0].iter().enumerate() {
            source[place] = shown.axes[*axis].command[0];
        }
        let mut joints = [0.0; 6];
        for (place, axis) in self.axes[1].iter().enumerate() {
            joints[place] = shown.axes[*axis].command[0];
        }
        let [line, turn] = match &self.mechanism {
            Mechanism::Wrist(robot, [work, tool]) => {
                let taken = robot.forward(&joints).expect("joints of the robot");
                let wanted = end_of_arm(work, &Pose::new(source), tool);
                let turn = (taken.pose.rotation - wanted.rotation).abs().max();
                [(taken.pose.position - wanted.position).norm(), turn]
            }
            Mechanism::Arm(robot, frame) => {
                let [x, y, z] = robot
                    .forward([joints[0], joints[1], joints[2]])
                    .expect("joints of the robot");
                let wanted = frame.transform_point(&Point::new(source[0], source[1], source[2]));
                [(Point::new(x, y, z) - wanted).norm(), 0.0]
            }
        };
        assert!(line < 1e-6 && turn < 1e-8, "apart by {line} and {turn}");
    }

    /// Makes up the program and runs it, then stops everything; nothing is left behind.
    pub fn play(&mut self) {
        for _ in 0..6 + self.random.below(8) {
            match self.random.below(16) {
                0..=4 if self.is_oriented() => self.path(),
                0..=2 => self.arc(),
                3..=7 => self.line(),
                8 | 9 if self.singles => self.single(),
                10 => self.change(),
                11 => self.hold(),
                12 if self.random.below(3) == 0 => self.stop(),
                _ => {
                    let ticks = 1 + self.random.below(200);
                    self.run_for(ticks);
                }
            }
            if self.ticks > self.scope.ticks {
                break;
            }
        }
        self.finish();
        self.check_ends();
    }

    fn finish(&mut self) {
        let _ = writeln!(self.text, "CART.FeedOverride := 100;");
        self.bench.set_override("CART", 1.0);
        let ticks = self.random.below(300);
        self.run_for(ticks);
        self.execute(&format!("MCS(CART, {{tag}}, 2, 1, {}, 1, 0, 0, 2)", 100.0 * STOP));
        let mut rest = 0;
        while rest < 3 {
            let before = self.bench.snapshot();
            self.tick();
            let still = |axis: usize| before.axes[axis].command[1] == 0.0;
            rest = if self.axes.iter().flatten().all(|axis| still(*axis)) {
                rest + 1
            } else {
                0
            };
            assert!(self.ticks < 20_000, "it never comes to rest");
        }
    }

    /// Every instruction ended in exactly one way, but for the transform, which goes on.
    fn check_ends(&self) {
        let mut ends: BTreeMap<u64, Vec<String>> = BTreeMap::new();
        let mut under_way = BTreeSet::new();
        for (name, event) in self.bench.events.iter().filter(|(name, _)| name != "Link") {
            let started = event.set & Flag::Ip.mask() != 0;
            let ended = event.set & (Flag::Er.mask() | Flag::Pc.mask()) != 0
                || event.clear & Flag::Ip.mask() != 0
                || (event.set & Flag::Dn.mask() != 0 && !started && !under_way.contains(&event.ticket.0));
            if started {
                under_way.insert(event.ticket.0);
            }
            let list = ends.entry(event.ticket.0).or_default();
            if ended {
                list.push(format!("{name}: +{:#x} -{:#x}", event.set, event.clear));
            }
        }
        for ends in ends.values() {
            assert_eq!(ends.len(), 1, "an instruction ended {} times: {ends:?}", ends.len());
        }
    }
}

/// The greatest change of an axis's velocity in a second while no single axis of the source moves: by two superposed moves
/// and the residuals of a merge, by moves or by their stops.
fn most(place: usize, oriented: bool) -> f64 {
    if place < 3 {
        // An arc adds its centripetal acceleration.
        let centripetal = if oriented { 0.0 } else { 150.0 * 150.0 / 1.0 };
        3.0 * f64::max(RATE, STOP * 10_000.0) + centripetal
    } else {
        // Rates of angles are up to 1 / cos(60 degrees) of those about axes, and turn along with them.
        2.0 * (3.0 * f64::max(RATE, STOP * MAX_TURN[1]) + 400.0 * 400.0 / 57.0)
    }
}

/// Runs programs of a scope: of `long` seeds as many as [`seeds`] says.
///
/// # Panics
/// When one fails, with the program.
pub fn run(scope: &Scope, long: u64) {
    for seed in seeds(long) {
        run_one(scope, seed);
    }
}

/// Runs the program of a seed.
///
/// # Panics
/// When it fails, with the program.
pub fn run_one(scope: &Scope, seed: u64) {
    let mut one = RobotProgram::new(seed, scope);
    let result = catch_unwind(AssertUnwindSafe(|| one.play()));
    if result.is_err() {
        println!("{}", one.config);
        panic!("seed {seed}, {:.3} s:\n{}", one.ticks as f64 * one.period, one.text);
    }
}
