//! Planted defects: between two ticks, a test corrupts a generator as no planner, transform or follower ever should.

use arcline_drive::{DriveState, Drives, ExchangeLost, Feedback, Following, SetPoint};
use arcline_instruction_set::{
    Argument, AxisId, Call, ControlSlot, ExceptionAction, FaultKind, MAX_OPERANDS, Mnemonic, RealArray, SystemId,
};
use arcline_planner::profile::{Limits, Profile};
use arcline_profile::KinematicState;

use crate::axis::generator_kind::GeneratorKind;
use crate::cause::{Cause, FaultChange};
use crate::execution::Ticket;
use crate::machine::{Axis, AxisKind, CommandLimits, CoordinateSystem, ExceptionActions, MotionGroup};
use crate::motion::Motion;

/// Axes X, Y, A of 500 units/s and 5000 units/s²; X and Y are those of the coordinate system.
fn machine(limits: CommandLimits, action: ExceptionAction) -> MotionGroup {
    let axis = |name: &str| Axis {
        max_acceleration_jerk: 100_000.0,
        max_deceleration_jerk: 100_000.0,
        exception_actions: ExceptionActions::default().with(FaultKind::CommandLimit, action),
        command_limits: limits,
        ..Axis::new(name, AxisKind::Servo, 500.0, 5000.0)
    };
    let system = CoordinateSystem {
        max_acceleration_jerk: 100_000.0,
        max_deceleration_jerk: 100_000.0,
        actual_tolerance: 0.01,
        command_tolerance: 0.5,
        ..CoordinateSystem::new("CS1", &[AxisId(0), AxisId(1)], 500.0, 5000.0)
    };
    MotionGroup::new(["X", "Y", "A"].map(axis).to_vec(), vec![system])
}

/// Drives whose axes are exactly at their set-points.
#[derive(Debug)]
struct AtSetPoints;

impl Drives for AtSetPoints {
    fn exchange(&mut self, set_points: &[SetPoint], feedback: &mut [Feedback]) -> Result<(), ExchangeLost> {
        for (set_point, feedback) in set_points.iter().zip(feedback) {
            feedback.state = if set_point.enable {
                DriveState::Enabled
            } else {
                DriveState::Off
            };
            feedback.following = Following::Exact;
            feedback.motion = set_point.motion();
        }
        Ok(())
    }
}

/// A call with 0 for every operand that `operands` does not name.
fn call(mnemonic: Mnemonic, target: u16, control: u32, operands: &[(&str, Argument)]) -> Call {
    let instruction = mnemonic.instruction();
    let mut arguments = [Argument::None; MAX_OPERANDS];
    for index in instruction.operands_behind_control() {
        arguments[index] = Argument::Number(0.0);
    }
    for name in ["Event Distance", "Calculated Data"] {
        if let Some(index) = instruction.operand(name) {
            arguments[index] = Argument::None;
        }
    }
    for (name, argument) in operands {
        arguments[instruction.operand(name).expect(name)] = *argument;
    }
    Call {
        mnemonic,
        target: Some(target),
        control: ControlSlot(control),
        arguments,
    }
}

const fn number(value: f64) -> Argument {
    Argument::Number(value)
}

/// Rates of 1000 units/s², and jerks of 100 % of time.
const RATES: [(&str, Argument); 5] = [
    ("Accel Rate", number(1000.0)),
    ("Decel Rate", number(1000.0)),
    ("Accel Jerk", number(100.0)),
    ("Decel Jerk", number(100.0)),
    ("Jerk Units", number(2.0)),
];

/// X and Y begin a line at 100 units/s, to 6000 and 8000.
fn begin_line(motion: &mut Motion, ticket: Ticket) {
    let line = [
        ("Position", Argument::Array(RealArray::from_slice(&[6000.0, 8000.0]))),
        ("Speed", number(100.0)),
        ("Termination Type", number(1.0)),
    ];
    let line: Vec<_> = line.into_iter().chain(RATES).collect();
    accept(motion, ticket, &call(Mnemonic::Mclm, 0, 0, &line));
}

/// A machine at rest, in its first tick.
fn at_rest(limits: CommandLimits, action: ExceptionAction) -> Motion {
    let mut motion = Motion::new(&machine(limits, action));
    motion.begin(1, &mut AtSetPoints);
    motion
}

/// Executes a call, which must be accepted.
fn accept(motion: &mut Motion, ticket: Ticket, call: &Call) {
    let shown = motion.execute(ticket, call);
    assert_eq!((shown.err, shown.exerr), (0, 0), "{}", call.mnemonic);
}

/// A begins a jog at 200 units/s.
fn begin_jog(motion: &mut Motion, ticket: Ticket, control: u32) {
    let jog: Vec<_> = [("Speed", number(200.0))].into_iter().chain(RATES).collect();
    accept(motion, ticket, &call(Mnemonic::Maj, 2, control, &jog));
}

/// Ends the present tick, and runs those from `next` to 399.
fn get_up_to_speed(motion: &mut Motion, next: u64) {
    motion.finish(|_| ());
    for tick in next..400 {
        motion.begin(tick, &mut AtSetPoints);
        motion.finish(|_| ());
    }
}

/// A machine in motion: a line of X and Y at 100 units/s, a jog of A at 200, all at their speed.
fn moving(limits: CommandLimits, action: ExceptionAction) -> Motion {
    let mut motion = at_rest(limits, action);
    begin_line(&mut motion, Ticket(1));
    begin_jog(&mut motion, Ticket(2), 1);
    get_up_to_speed(&mut motion, 2);
    motion
}

/// The set-points of X, Y and A, and every change of faults, from one tick until all axes stand.
struct Run {
    sent: Vec<[[f64; 2]; 3]>,
    faults: Vec<FaultChange>,
}

fn run(motion: &mut Motion, from: u64) -> Run {
    let mut run = Run {
        sent: vec![sent(motion)],
        faults: Vec::new(),
    };
    for tick in from..from + 1000 {
        motion.begin(tick, &mut AtSetPoints);
        motion.take_fault_changes(|change| run.faults.push(*change));
        run.sent.push(sent(motion));
        motion.finish(|_| ());
    }
    run
}

fn sent(motion: &Motion) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|axis| [motion.set_points[axis].position, motion.set_points[axis].velocity])
}

impl Run {
    /// No set-point is further or faster than an axis at its maxima gets within an update.
    fn assert_smooth(&self, why: &str) {
        for pair in self.sent.windows(2) {
            for (before, after) in pair[0].iter().zip(&pair[1]) {
                assert!(
                    (after[1] - before[1]).abs() <= 5.0 + 1e-9,
                    "{why}: {before:?} {after:?}"
                );
                let mean = 0.5 * (before[1] + after[1]) * 0.001;
                assert!(
                    (after[0] - before[0] - mean).abs() <= 0.0025 + 1e-9,
                    "{why}: {before:?} {after:?}"
                );
            }
        }
    }

    fn refused(&self) -> Vec<(u16, &'static str)> {
        let refused = self
            .faults
            .iter()
            .filter_map(|change| Some((change.axis.0, change.refused?.source)));
        refused.collect()
    }
}

#[test]
fn a_planted_defect_becomes_a_stop_of_everything_that_moves_with_the_axis() {
    type Defect = fn(&mut Motion);
    let jump: Defect = |motion| motion.axes[AxisId(0)].sum.redefine(5.0);
    // A velocity that reaches so far in one update is inside the limits.
    let near: Defect = |motion| motion.axes[AxisId(1)].sum.redefine(1.9);
    let back: Defect = |motion| motion.axes[AxisId(0)].sum.redefine(-0.2);
    let jog: Defect = |motion| motion.axes[AxisId(2)].sum.redefine(1.7);
    let no_number: Defect = |motion| motion.axes[AxisId(1)].sum.redefine(f64::NAN);
    let runaway: Defect = |motion| {
        let limits = Limits {
            speed: 1e5,
            acceleration: 5e7,
            deceleration: 5e7,
            jerk: None,
        };
        let now = motion.clock.now();
        let jog = motion.axes[AxisId(2)].sum.get_mut(GeneratorKind::Jog).expect("jogs");
        jog.follow(Profile::to_velocity(jog.now, 1e5, &limits), now);
    };
    let far: Defect = |motion| {
        let now = motion.clock.now();
        let jog = motion.axes[AxisId(2)].sum.get_mut(GeneratorKind::Jog).expect("jogs");
        let beyond = KinematicState {
            position: jog.now.position - 1000.0,
            ..jog.now
        };
        jog.follow(
            Profile::stop(
                beyond,
                &Limits {
                    speed: 1.0,
                    acceleration: 1.0,
                    deceleration: 1.0,
                    jerk: None,
                },
            ),
            now,
        );
    };
    #[rustfmt::skip]
    let cases = [
        // why,                                  defect,    refused,                     who stands afterwards
        ("X of a line 5 units further on",        jump,      (0, "coordinated motion"), [true, true, false]),
        ("Y of a line 1.9 units further on",      near,      (1, "coordinated motion"), [true, true, false]),
        ("X of a line 0.2 units further back",    back,      (0, "coordinated motion"), [true, true, false]),
        ("a jog 1.7 units further on",            jog,       (2, "MAJ"),                [false, false, true]),
        ("Y of a line at a position that is none", no_number, (1, "coordinated motion"), [true, true, false]),
        ("a jog that accelerates 10,000 times",   runaway,   (2, "MAJ"),                [false, false, true]),
        ("a jog that stands 1,000 units behind",  far,       (2, "MAJ"),                [false, false, true]),
    ];
    for (why, defect, refused, stands) in cases {
        let mut motion = moving(CommandLimits::default(), ExceptionAction::StopPlanner);
        defect(&mut motion);
        let run = run(&mut motion, 400);
        run.assert_smooth(why);
        assert_eq!(run.refused(), [refused], "{why}");
        let change = run.faults[0];
        assert_eq!(
            change.set.kinds().collect::<Vec<_>>(),
            [FaultKind::CommandLimit],
            "{why}"
        );
        let ticket = if refused.1 == "MAJ" { 2 } else { 1 };
        let by = change.refused.expect("one").by;
        assert!(
            matches!(by, Cause::Instruction { ticket: Ticket(one), .. } if one == ticket),
            "{why}: {by:?}"
        );
        let last = run.sent.last().expect("ticks");
        assert_eq!(last.map(|[_, velocity]| velocity == 0.0), stands, "{why}: {last:?}");
        let counts: Vec<u32> = motion.axes_since(None).map(|(_, axis)| axis.refused_commands).collect();
        let expected: Vec<u32> = (0..3).map(|axis| u32::from(axis == refused.0)).collect();
        assert_eq!(counts, expected, "{why}");
        assert!(motion.systems[SystemId(0)].is_busy() != stands[0], "{why}");
    }
}

#[test]
fn the_action_of_the_fault_follows_the_stop() {
    for (action, torque) in [
        (ExceptionAction::StopPlanner, true),
        (ExceptionAction::StopDrive, false),
        (ExceptionAction::Shutdown, false),
    ] {
        let mut motion = moving(CommandLimits::default(), action);
        motion.axes[AxisId(0)].sum.redefine(5.0);
        let run = run(&mut motion, 400);
        assert_eq!(run.refused().len(), 1, "{action:?}");
        assert_eq!(motion.axes[AxisId(0)].has_torque(), torque, "{action:?}");
        assert!(motion.axes[AxisId(1)].has_torque(), "{action:?}: Y has no fault");
    }
}

#[test]
fn limits_are_those_of_the_axis() {
    #[rustfmt::skip]
    let cases = [
        // why,                                enabled, speed, acceleration, acts
        ("as they are by default",               true,   4.0,   100.0,        true),
        ("a speed that allows it",               true,   20.0,  100.0,        true),
        ("an acceleration that allows it",       true,   4.0,   5000.0,       true),
        ("both",                                 true,   20.0,  5000.0,       false),
        ("switched off",                         false,  4.0,   100.0,        false),
    ];
    for (why, enabled, speed, acceleration, acts) in cases {
        let limits = CommandLimits {
            enabled,
            speed,
            acceleration,
        };
        let mut motion = moving(limits, ExceptionAction::StopPlanner);
        // 5 units in an update of 1 ms: 5000 units/s, ten times Maximum Speed.
        motion.axes[AxisId(0)].sum.redefine(5.0);
        let run = run(&mut motion, 400);
        assert_eq!(!run.refused().is_empty(), acts, "{why}");
    }
}

#[test]
fn a_slave_stops_with_its_master() {
    let mut motion = at_rest(CommandLimits::default(), ExceptionAction::StopPlanner);
    begin_jog(&mut motion, Ticket(1), 0);
    let gear = [
        ("Master Axis", Argument::Object(2)),
        ("Ratio", number(1.0)),
        ("Slave Counts", number(1.0)),
        ("Master Counts", number(1.0)),
        ("Master Reference", number(1.0)),
        ("Accel Rate", number(1000.0)),
    ];
    accept(&mut motion, Ticket(2), &call(Mnemonic::Mag, 0, 1, &gear));
    get_up_to_speed(&mut motion, 2);
    assert_eq!(sent(&motion)[0][1], 200.0, "the slave follows");
    motion.axes[AxisId(2)].sum.redefine(5.0);
    let run = run(&mut motion, 400);
    run.assert_smooth("master and slave");
    assert_eq!(run.refused(), [(0, "MAG"), (2, "MAJ")]);
    assert_eq!(run.sent.last().expect("ticks").map(|[_, velocity]| velocity), [0.0; 3]);
}

#[test]
fn a_system_stops_with_its_master() {
    // The less the system moves for a unit of its master, the less its own set-points show of the defect.
    for (ratio, refused) in [
        (0.9, &[(0, "coordinated motion"), (2, "MAJ")][..]),
        (0.3, &[(2, "MAJ")]),
        (0.001, &[(2, "MAJ")]),
    ] {
        let mut motion = at_rest(CommandLimits::default(), ExceptionAction::StopPlanner);
        begin_jog(&mut motion, Ticket(1), 0);
        let master = [("Master Axis", Argument::Object(2)), ("Master Reference", number(1.0))];
        accept(&mut motion, Ticket(2), &call(Mnemonic::Mdcc, 0, 1, &master));
        let line = [
            ("Position", Argument::Array(RealArray::from_slice(&[6000.0, 0.0]))),
            ("Speed", number(ratio)),
            ("Speed Units", number(4.0)),
            ("Accel Rate", number(1.0)),
            ("Accel Units", number(4.0)),
            ("Decel Rate", number(1.0)),
            ("Decel Units", number(4.0)),
            ("Accel Jerk", number(100.0)),
            ("Decel Jerk", number(100.0)),
            ("Jerk Units", number(6.0)),
            ("Lock Direction", number(1.0)),
            ("Termination Type", number(1.0)),
        ];
        accept(&mut motion, Ticket(3), &call(Mnemonic::Mclm, 0, 2, &line));
        get_up_to_speed(&mut motion, 2);
        let [[_, x], ..] = sent(&motion);
        assert!((x - 200.0 * ratio).abs() < 1e-9, "{ratio}: X follows at {x}");
        motion.axes[AxisId(2)].sum.redefine(5.0);
        let run = run(&mut motion, 400);
        run.assert_smooth("a master and a coordinate system");
        assert_eq!(run.refused(), refused, "{ratio}");
        assert_eq!(
            run.sent.last().expect("ticks").map(|[_, velocity]| velocity),
            [0.0; 3],
            "{ratio}"
        );
        assert!(!motion.systems[SystemId(0)].is_busy(), "{ratio}");
    }
}

#[test]
fn the_report_names_the_generator_that_jumped() {
    let mut motion = at_rest(CommandLimits::default(), ExceptionAction::StopPlanner);
    begin_jog(&mut motion, Ticket(1), 0);
    let slow = [("Position", number(500.0)), ("Speed", number(20.0))];
    let slow: Vec<_> = slow.into_iter().chain(RATES).collect();
    accept(&mut motion, Ticket(2), &call(Mnemonic::Mam, 2, 1, &slow));
    get_up_to_speed(&mut motion, 2);
    let now = motion.clock.now();
    let slow = motion.axes[AxisId(2)].sum.get_mut(GeneratorKind::Move).expect("moves");
    let limits = Limits {
        speed: 20.0,
        acceleration: 1000.0,
        deceleration: 1000.0,
        jerk: None,
    };
    let further = KinematicState {
        position: slow.now.position + 1.0,
        ..slow.now
    };
    slow.follow(Profile::to_velocity(further, 20.0, &limits), now);
    let run = run(&mut motion, 400);
    run.assert_smooth("a move beside a jog");
    assert_eq!(run.refused(), [(2, "MAM")]);
    let by = run.faults[0].refused.expect("one").by;
    assert!(matches!(by, Cause::Instruction { ticket: Ticket(2), .. }), "{by:?}");
}

#[test]
fn a_defect_behind_a_transform_stops_both_of_its_sides() {
    // A displacement of the target leads back to the source, so both sides would jump.
    for (why, axis, source) in [
        ("the target 5 units further on", 2, "a transform"),
        ("the source 5 units further on", 0, "coordinated motion"),
    ] {
        let mut machine = machine(CommandLimits::default(), ExceptionAction::StopPlanner);
        let second = Axis {
            name: "B".to_owned(),
            ..machine.axes[2].clone()
        };
        machine.axes.push(second);
        let target = CoordinateSystem {
            name: "CS2".to_owned(),
            axes: vec![AxisId(2), AxisId(3)],
            ..machine.systems[0].clone()
        };
        machine.systems.push(target);
        let mut motion = Motion::new(&machine);
        for tick in 1..3 {
            motion.begin(tick, &mut AtSetPoints);
            motion.finish(|_| ());
        }
        let zeros = Argument::Array(RealArray::from_slice(&[0.0; 3]));
        let pair = [
            ("Target System", Argument::Object(1)),
            ("Orientation", zeros),
            ("Translation", zeros),
        ];
        accept(&mut motion, Ticket(1), &call(Mnemonic::Mct, 0, 1, &pair));
        begin_line(&mut motion, Ticket(2));
        get_up_to_speed(&mut motion, 3);
        let [x, y, a] = sent(&motion).map(|[_, velocity]| velocity);
        assert!((x - 60.0).abs() < 1e-9 && (y - 80.0).abs() < 1e-9, "{why}: {x} {y}");
        assert!((a - x).abs() < 1e-9, "{why}: the target follows, {a}");
        motion.axes[AxisId(axis)].sum.redefine(5.0);
        let run = run(&mut motion, 400);
        run.assert_smooth(why);
        assert_eq!(run.refused(), [(0, source), (2, "a transform")], "{why}");
        assert_eq!(
            run.sent.last().expect("ticks").map(|[_, velocity]| velocity),
            [0.0; 3],
            "{why}"
        );
        assert_eq!(motion.axes[AxisId(3)].command.velocity, 0.0, "{why}: B");
        assert!(
            motion.transforms.iter().next().is_none(),
            "{why}: the transform is over"
        );
        assert!(!motion.systems[SystemId(0)].is_busy(), "{why}");
    }
}
