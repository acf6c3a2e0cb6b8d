//! Another implementation of the drives: a fieldbus whose feedback is two ticks old, and which can be lost. The effects of instructions and
//! faults on it (spec/axis-and-data-types.md §12).

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};

use arcline_controller::drive::{
    DriveInputs, DriveState, Drives, ExchangeLost, Feedback, HOME_LATCH, KinematicState, LATCHES, Latch,
    REGISTRATION_LATCHES, SetPoint, Trigger,
};
use arcline_instruction_set::predefined::{axis_status, cip_axis_io_status};
use arcline_instruction_set::{FaultKind, FaultSet, Flag};
use arcline_tests::bench::{Bench, OK};

const PERIOD: f64 = 0.001;
/// Ticks that a drive takes to switch on.
const SWITCH_ON: u32 = 20;
/// Ticks without set-points after which a drive switches itself off.
const WATCHDOG: u32 = 10;
/// Age of the feedback, ticks.
const AGE: usize = 2;
/// The position at which the home switch of X becomes active, and the position of its registration input, of the machine.
const SWITCH: f64 = 10.0;
const MARK: f64 = 33.3;

/// One drive: at every tick its axis is at the set-point of the tick before.
#[derive(Debug, Default)]
struct Drive {
    position: f64,
    before: f64,
    target: Option<SetPoint>,
    switching: u32,
    state: DriveState,
    /// The drive never switches on or off.
    stuck: bool,
    unheard: u32,
    faults: FaultSet,
    closed: [Option<u32>; LATCHES],
    /// Feedback on its way to the controller, the oldest first.
    sent: VecDeque<Feedback>,
}

impl Drive {
    /// Makes one tick; `heard`: the set-point that has come over the bus.
    fn tick(&mut self, heard: Option<&SetPoint>) -> Feedback {
        self.before = self.position;
        if let Some(target) = self.target.filter(|_| self.state == DriveState::Enabled) {
            self.position = target.position;
        }
        self.unheard = heard.map_or(self.unheard + 1, |_| 0);
        if !self.faults.is_empty() {
            self.state = DriveState::Faulted;
        } else if self.stuck {
            self.switching = 0;
        } else if self.unheard > WATCHDOG || heard.is_some_and(|heard| !heard.enable) {
            (self.state, self.switching) = (DriveState::Off, 0);
        } else if self.state != DriveState::Enabled && heard.is_some() {
            self.switching += 1;
            if self.switching > SWITCH_ON {
                self.state = DriveState::Enabled;
            }
        }
        if let Some(heard) = heard {
            let held = (heard.position - self.position).abs() < 1e-9;
            assert!(
                self.state != DriveState::Off || !heard.enable || held,
                "a jump when it switches on"
            );
            self.target = Some(*heard);
        }
        let velocity = (self.position - self.before) / PERIOD;
        let mut feedback = Feedback {
            state: self.state,
            motion: KinematicState {
                position: self.position,
                velocity,
                acceleration: 0.0,
            },
            faults: self.faults,
            inputs: DriveInputs {
                home: self.position >= SWITCH,
                registration: [self.position >= MARK, false],
            },
            ..Feedback::default()
        };
        let armed = self.target.map(|target| target.latches).unwrap_or_default();
        for (place, armed) in armed.iter().enumerate() {
            let Some(armed) = armed.filter(|armed| self.closed[place] != Some(armed.number)) else {
                continue;
            };
            let rises = self.position > self.before;
            let at = match armed.trigger {
                Trigger::SwitchOn if rises => SWITCH,
                Trigger::SwitchOff if !rises => SWITCH,
                Trigger::RegistrationOn if rises => MARK,
                _ => continue,
            };
            let share = (at - self.before) / (self.position - self.before);
            if (0.0..=1.0).contains(&share) {
                self.closed[place] = Some(armed.number);
                feedback.latches[place] = Some(Latch {
                    number: armed.number,
                    before_end_s: (1.0 - share + AGE as f64) * PERIOD,
                    position: at,
                });
            }
        }
        self.sent.push_back(feedback);
        if self.sent.len() > AGE {
            self.sent.pop_front().unwrap_or_default()
        } else {
            Feedback::default()
        }
    }
}

#[derive(Debug, Default)]
struct Bus {
    drives: Vec<Drive>,
    lost: bool,
    /// Set-points of the last exchanges that were not lost.
    heard: Vec<SetPoint>,
}

/// The bus as the controller has it, and as the test has it.
#[derive(Debug, Clone)]
struct Fieldbus(Arc<Mutex<Bus>>);

impl Fieldbus {
    fn bus(&self) -> MutexGuard<'_, Bus> {
        self.0.lock().expect("no test panics with the bus")
    }
}

impl Drives for Fieldbus {
    fn exchange(&mut self, set_points: &[SetPoint], feedback: &mut [Feedback]) -> Result<(), ExchangeLost> {
        let mut bus = self.bus();
        let lost = bus.lost;
        bus.heard.clear();
        bus.heard.extend_from_slice(set_points);
        for (drive, (set_point, feedback)) in bus.drives.iter_mut().zip(set_points.iter().zip(feedback)) {
            let came = drive.tick((!lost).then_some(set_point));
            if !lost {
                *feedback = came;
            }
        }
        if lost { Err(ExchangeLost) } else { Ok(()) }
    }
}

/// X, Y on the bus and V without a drive, in coordinate systems XY and XYV; every servo is off.
fn machine() -> (Bench, Fieldbus) {
    let dynamics = "max_speed = 1000\nmax_acceleration = 2000\nmax_acceleration_jerk = 40000\n";
    let axis = |name: &str, kind: &str, keys: &str| {
        format!("[[axis]]\nname = \"{name}\"\ntype = \"{kind}\"\n{dynamics}{keys}\n")
    };
    let system = |name: &str, axes: &str| {
        format!(
            "[[coordinate_system]]\nname = \"{name}\"\naxes = [{axes}]\nqueue_depth = 8\nactual_tolerance = 0.0001\n{dynamics}"
        )
    };
    let off = "start = { servo_on = false }\n";
    let home = "home = { sequence = \"switch\", position = 100, offset = 5, speed = 50, return_speed = 20, switch = { min = 10 } }\n\
                registration = { input_1 = \"Mark\" }\n";
    let config = [
        axis("X", "servo", &format!("{off}{home}")),
        axis("Y", "servo", off),
        axis("V", "virtual", ""),
        system("XY", "\"X\", \"Y\""),
        system("XYV", "\"X\", \"Y\", \"V\""),
        "[[tag]]\nname = \"Mark\"\ntype = \"BOOL\"\n".to_owned(),
    ];
    let bus = Fieldbus(Arc::default());
    bus.bus().drives = (0..3).map(|_| Drive::default()).collect();
    (Bench::with_drives(&config.concat(), Box::new(bus.clone())), bus)
}

fn running() -> (Bench, Fieldbus) {
    let (mut bench, bus) = machine();
    for axis in ["X", "Y"] {
        assert_eq!(bench.call(&format!("MSO({axis}, On{axis})")), OK);
    }
    bench.until("OnY", Flag::Dn);
    (bench, bus)
}

fn is_on(bench: &Bench, axis: &str) -> bool {
    bench.axis(axis).status & axis_status::SERVO_ACTION_STATUS != 0
}

/// Speed 100, trapezoid, 1000 units/s².
const RATES: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";

#[test]
fn servo_on_is_an_answer_of_the_drive() {
    let (mut bench, bus) = machine();
    bench.run(5);
    bus.bus().drives[0].position = 7.5;
    bench.run(5);
    assert_eq!(bench.call("MSO(X, On)"), OK);
    bench.run(u64::from(SWITCH_ON));
    assert_eq!(
        (bench.bits("On").as_str(), is_on(&bench, "X")),
        ("EN", false),
        "the drive takes its time"
    );
    assert_eq!(bench.call(&format!("MAM(X, M, 0, 5, {RATES})")), (5, 0));
    bench.until("On", Flag::Dn);
    assert!(is_on(&bench, "X"));
    assert_eq!(bench.position("X"), 7.5, "nothing moves");
    assert_eq!(bench.call("MSF(X, Off)"), OK);
    assert!(!is_on(&bench, "X"));
    bench.run(2);
    assert_eq!(bench.bits("Off"), "EN", "the drive is on as yet");
    bench.until("Off", Flag::Dn);
    assert_eq!(bench.axis("X").cip_state, 2, "stopped");
}

#[test]
fn a_drive_that_does_not_answer_fails_its_requests() {
    const ANSWER_TICKS: u64 = 2000;
    let (mut bench, bus) = machine();
    bench.run(5);
    bus.bus().drives[0].stuck = true;
    assert_eq!(bench.call("MSO(X, On)"), OK);
    bench.run(1000);
    assert_eq!(bench.call("MSO(X, Again)"), OK);
    bench.run(ANSWER_TICKS - 1000);
    assert_eq!(
        (bench.bits("On").as_str(), bench.axis("X").cip_state),
        ("EN", 3),
        "it has 2 s"
    );
    bench.run(1);
    for tag in ["On", "Again"] {
        let control = bench.control(tag);
        assert_eq!(
            (bench.bits(tag).as_str(), control.err, control.exerr),
            ("EN ER", 12, 2),
            "{tag}"
        );
    }
    assert_eq!((bench.axis("X").cip_state, is_on(&bench, "X")), (2, false), "stopped");
    bench.tick();
    assert!(!bus.bus().heard[0].enable, "it is asked no more");
    // The drive works again.
    bus.bus().drives[0].stuck = false;
    assert_eq!(bench.call("MSO(X, On2)"), OK);
    bench.until("On2", Flag::Dn);
    bus.bus().drives[0].stuck = true;
    assert_eq!(bench.call("MSF(X, Off)"), OK);
    bench.run(ANSWER_TICKS);
    assert_eq!(bench.bits("Off"), "EN");
    bench.run(1);
    let control = bench.control("Off");
    assert_eq!(
        (bench.bits("Off").as_str(), control.err, control.exerr),
        ("EN ER", 12, 2)
    );
    assert_eq!(bench.axis("X").cip_state, 6, "the drive is on, and Stopping shows it");
}

#[test]
fn moves_end_where_they_should() {
    let (mut bench, bus) = running();
    assert_eq!(bench.call(&format!("MAM(X, M, 0, 40, {RATES})")), OK);
    bench.until("M", Flag::Pc);
    assert_eq!(bench.position("X"), 40.0);
    bench.run(5);
    assert_eq!((bench.axis("X").actual[0], bus.bus().drives[0].position), (40.0, 40.0));
    // Actual Tolerance: the command stands before the axis is seen there.
    for (tag, to, end) in [("A", "[60, 20]", 0), ("B", "[80, 0]", 1), ("C", "[0, 0]", 0)] {
        assert_eq!(bench.call(&format!("MCLM(XY, {tag}, 0, {to}, {RATES}, {end})")), OK);
    }
    let mut stood = 0;
    while !bench.control("A").has(Flag::Pc) {
        bench.tick();
        let stands = bench.position("X") == 60.0 && bench.position("Y") == 20.0;
        stood += u32::from(stands);
    }
    assert!((3..=5).contains(&stood), "the feedback is {AGE} ticks old: {stood}");
    bench.until("C", Flag::Pc);
    assert_eq!((bench.position("X"), bench.position("Y")), (0.0, 0.0));
    // A stop on the path.
    assert_eq!(bench.call(&format!("MCLM(XY, D, 0, [300, 300], {RATES}, 1)")), OK);
    bench.run(500);
    assert_eq!(bench.call("MCS(XY, S, CoordinatedMove, Yes, 500, 0)"), OK);
    bench.until("S", Flag::Pc);
    bench.run(5);
    let [x, y] = ["X", "Y"].map(|axis| bench.axis(axis));
    assert!((x.command[0] - y.command[0]).abs() < 1e-9, "on the path");
    assert_eq!((x.command[1], x.actual[1], x.actual[0]), (0.0, 0.0, x.command[0]));
}

#[test]
fn homing_takes_the_exact_position_of_the_latch() {
    let (mut bench, bus) = running();
    assert_eq!(bench.call("MAH(X, H)"), OK);
    bench.until("H", Flag::Pc);
    assert_eq!(bench.position("X"), 100.0);
    bench.run(5);
    // The Home Position lies 5 from the switch.
    let machine = bus.bus().drives[0].position;
    assert!((machine - (SWITCH + 5.0)).abs() < 1e-9, "{machine}");
    // A homing that begins within the switch goes back first.
    assert_eq!(bench.call("MAH(X, H2)"), OK);
    bench.until("H2", Flag::Pc);
    bench.run(5);
    let machine = bus.bus().drives[0].position;
    assert!((machine - (SWITCH + 5.0)).abs() < 1e-9, "{machine}");
    assert!(bus.bus().drives[0].closed[HOME_LATCH].is_some());
}

#[test]
fn a_registration_latch_has_the_exact_position_and_time() {
    let (mut bench, bus) = running();
    assert_eq!(bench.call("MRP(X, P, Relative, Command, 500)"), OK);
    assert_eq!(bench.call("MAR(X, R, PositiveEdge, Disabled, 0, 0, 1)"), OK);
    assert_eq!(bench.call(&format!("MAM(X, M, 1, 60, {RATES})")), OK);
    let from = bench.now();
    // The drive has the input at its own terminal: the tag means nothing to it.
    bench.write("Mark", 1.0);
    bench.tick();
    assert_eq!(bench.bits("R"), "EN DN IP");
    assert_eq!(
        bench.axis("X").cip_io & cip_axis_io_status::REGISTRATION1_INPUT_STATUS,
        0
    );
    bench.until("R", Flag::Pc);
    let shown = bench.axis("X");
    assert_ne!(shown.cip_io & cip_axis_io_status::REGISTRATION1_INPUT_STATUS, 0);
    assert!(
        (shown.registered[0][0] - (500.0 + MARK)).abs() < 1e-9,
        "{:?}",
        shown.registered
    );
    // 5 units in the 100 ms of acceleration, the rest at 100 units/s; the axis is a tick behind.
    let expected = from as f64 * 1000.0 + 100_000.0 + (MARK - 5.0) * 10_000.0 + 1000.0;
    assert!(
        (f64::from(shown.registered_at[0][0]) - expected).abs() <= 2.0,
        "{:?}",
        shown.registered_at
    );
    assert!(bus.bus().drives[0].closed[REGISTRATION_LATCHES[0]].is_some());
}

#[test]
fn a_fault_of_a_drive_comes_by_its_feedback() {
    for kind in [FaultKind::Overcurrent, FaultKind::Drive] {
        let (mut bench, bus) = running();
        assert_eq!(bench.call(&format!("MCLM(XY, M, 0, [300, 300], {RATES}, 1)")), OK);
        bench.run(300);
        bus.bus().drives[1].faults = FaultSet::default().with(kind);
        bench.run(AGE as u64 + 1);
        assert_eq!(
            (bench.axis("Y").faults, bench.axis("X").faults.is_empty()),
            (FaultSet::default().with(kind), true)
        );
        assert_eq!(bench.bits("M"), "EN DN", "the move is over");
        bench.run(200);
        assert_eq!(
            (bench.axis("Y").cip_state, is_on(&bench, "X")),
            (8, true),
            "faulted, and the other one holds"
        );
        assert_eq!(bench.axis("X").command[1], 0.0);
        bus.bus().drives[1].faults = FaultSet::default();
        bench.run(5);
        assert_eq!(bench.call("MAFR(Y, F)"), OK);
        assert_eq!(bench.call("MSO(Y, On2)"), OK);
        bench.until("On2", Flag::Dn);
        assert!(is_on(&bench, "Y"));
    }
}

#[test]
fn a_short_loss_is_passed_and_a_long_one_stops_everything_in_order() {
    let communication = FaultSet::default().with(FaultKind::DriveCommunication);
    for ticks in [1, 2, 3, 300] {
        let (mut bench, bus) = running();
        assert_eq!(bench.call(&format!("MCLM(XYV, M, 0, [300, 300, 300], {RATES}, 1)")), OK);
        bench.run(300);
        bus.bus().lost = true;
        let mut last = bus.bus().heard.clone();
        for _ in 0..ticks {
            bench.tick();
            let now = bus.bus().heard.clone();
            for (now, last) in now.iter().zip(&last) {
                let change = (now.velocity - last.velocity).abs();
                assert!(change <= 2000.0 * PERIOD + 1e-9, "{change} in a tick");
            }
            last = now;
        }
        bus.bus().lost = false;
        if ticks <= 2 {
            bench.until("M", Flag::Pc);
            assert_eq!(bench.position("X"), 300.0, "{ticks}");
            continue;
        }
        bench.run(200);
        for axis in ["X", "Y"] {
            assert!(
                bench.axis(axis).faults.contains(FaultKind::DriveCommunication),
                "{axis}, {ticks}"
            );
            assert_eq!((bench.axis(axis).cip_state, is_on(&bench, axis)), (8, false), "{axis}");
        }
        assert_eq!(
            (bench.axis("V").faults, bench.axis("V").command[1]),
            (FaultSet::default(), 0.0)
        );
        assert_eq!(bench.bits("M"), "EN DN", "it was ended");
        let stood = bench.position("X");
        assert!((12.0..25.0).contains(&stood), "it braked: {stood}");
        let changes: Vec<_> = bench
            .fault_changes
            .iter()
            .filter(|change| change.set == communication)
            .collect();
        assert_eq!(changes.len(), 2, "{:?}", bench.fault_changes);
        for axis in ["X", "Y"] {
            assert_eq!(bench.call(&format!("MAFR({axis}, F{axis})")), OK);
            bench.run(5);
            assert_eq!(bench.call(&format!("MSO({axis}, Again{axis})")), OK);
        }
        bench.until("AgainY", Flag::Dn);
        assert_eq!(bench.position("X"), bus.bus().drives[0].position, "nothing jumps");
        assert_eq!(bench.call(&format!("MCLM(XY, N, 0, [0, 0], {RATES}, 0)")), OK);
        bench.until("N", Flag::Pc);
        assert_eq!(bench.position("X"), 0.0);
    }
}
