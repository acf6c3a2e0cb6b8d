//! Faults of axes: every kind with every action, their effect on motion, and the way back
//! (spec/axis-and-data-types.md §1.8, §9.3, §12).

use arcline_controller::Cause;
use arcline_instruction_set::predefined::{
    axis_fault, axis_status, cip_axis_status, coordinate_system_status, motion_status,
};
use arcline_instruction_set::{Ending, ExceptionAction, FAULTS, FaultKind, FaultWord, Flag};
use arcline_tests::bench::{Bench, OK};

/// Speed, rates and profile of every move here: a trapezoid at 100 units/s.
const RATES: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";

/// CIPAxisState.
const STOPPED: i16 = 2;
const RUNNING: i16 = 4;
const ABORTING: i16 = 7;
const FAULTED: i16 = 8;
const SHUTDOWN: i16 = 10;

/// The default machine with more keys for some of its axes.
fn machine(keys: &[(&str, &str)]) -> Bench {
    let mut text = arcline_config::DEFAULT.to_owned();
    for (axis, keys) in keys {
        let name = format!("name = \"{axis}\"\ntype = ");
        assert!(text.contains(&name), "{axis}");
        text = text.replacen(&name, &format!("{keys}\n{name}"), 1);
    }
    Bench::with(&text)
}

/// A coordinated move with a pending one, 60 units/s of X and 80 of Y, and a move of S alone.
fn moving(keys: &[(&str, &str)]) -> Bench {
    let mut bench = machine(keys);
    assert_eq!(bench.call(&format!("MCLM(CS1, L1, 0, [300, 400, 0], {RATES}, 1)")), OK);
    assert_eq!(bench.call(&format!("MCLM(CS1, L2, 0, [0, 400, 0], {RATES}, 1)")), OK);
    assert_eq!(bench.call(&format!("MAM(S, A1, 0, 1000, {RATES})")), OK);
    bench.run(500);
    bench
}

fn has(word: u32, bit: u32) -> bool {
    word & bit != 0
}

#[test]
fn every_fault_with_every_action() {
    use ExceptionAction::{Alarm, FaultStatusOnly, Ignore, Shutdown, StopDrive, StopPlanner};
    for fault in &FAULTS {
        #[rustfmt::skip]
        let cases = [
            // action,        fault, alarm, state at once, later,  a move of X then,  moves go on
            (Ignore,          false, false, RUNNING,       RUNNING,  OK,       true),
            (Alarm,           false, true,  RUNNING,       RUNNING,  OK,       true),
            (FaultStatusOnly, true,  false, RUNNING,       RUNNING,  OK,       true),
            (StopPlanner,     true,  false, RUNNING,       RUNNING,  (20, 0),  false),
            (StopDrive,       true,  false, ABORTING,      FAULTED,  (20, 0),  false),
            (Shutdown,        true,  false, SHUTDOWN,      SHUTDOWN, (7, 0),   false),
        ];
        for (action, faults, alarms, at_once, later, answer, goes_on) in cases {
            let why = format!("{} {}", fault.word, action.word());
            if fault.kind == FaultKind::CommandLimit && !action.stops() {
                // The axis has stopped already; a configuration that asks for less is refused.
                continue;
            }
            let keys = format!("exception_actions = {{ {} = \"{}\" }}", fault.word, action.word());
            let mut bench = moving(&[("X", &keys)]);
            bench.inject("X", &[fault.kind]);
            assert_eq!(bench.axis("X").fault, 0, "{why}: found at the next update");
            bench.tick();
            let x = bench.axis("X");
            let bit = 1u64 << fault.bit;
            let word = match fault.shows {
                FaultWord::Motion => x.motion_faults.map(u64::from),
                FaultWord::Cip => x.cip_faults,
            };
            let other = match fault.shows {
                FaultWord::Motion => x.cip_faults,
                FaultWord::Cip => x.motion_faults.map(u64::from),
            };
            let bits = |on| if on { bit } else { 0 };
            assert_eq!((word, other), ([bits(faults), bits(alarms)], [0, 0]), "{why}");
            let shown = match fault.shows {
                FaultWord::Motion => axis_fault::MOTION_FAULT,
                FaultWord::Cip => axis_fault::PHYSICAL_AXIS_FAULT,
            };
            assert_eq!(x.fault, if faults { shown } else { 0 }, "{why}");
            let alarm_status = alarms && fault.shows == FaultWord::Cip;
            assert_eq!(has(x.cip_status, cip_axis_status::ALARM_STATUS), alarm_status, "{why}");
            assert_eq!(x.cip_state, at_once, "{why}");
            // The coordinate systems of X show it, and no other.
            for (system, mask) in [("CS1", 1), ("XY", 1), ("CS3", 0)] {
                let system = bench.system(system);
                let mask = if faults { mask } else { 0 };
                let expected = if mask == 0 { 0 } else { axis_fault::PHYSICAL_AXIS_FAULT };
                assert_eq!((system.axes_faulted, system.fault), (mask, expected), "{why}");
                let ready = has(system.status, coordinate_system_status::READY_STATUS);
                assert_eq!(ready, mask == 0, "{why}");
            }
            // The instructions.
            let (first, second) = if goes_on {
                ("EN DN IP AC", "EN DN IP")
            } else {
                ("EN DN", "EN DN")
            };
            assert_eq!(
                (bench.bits("L1").as_str(), bench.bits("L2").as_str()),
                (first, second),
                "{why}"
            );
            assert_eq!(bench.bits("A1"), "EN DN IP", "{why}: S has nothing to do with it");
            // The axes.
            let y = bench.axis("Y");
            let stopping = |status| has(status, motion_status::STOPPING_STATUS);
            assert_eq!(stopping(y.motion_status), !goes_on, "{why}");
            assert_eq!(stopping(x.motion_status), !goes_on && action != Shutdown, "{why}");
            if goes_on {
                continue;
            }
            // 60 and 80 units/s at the Maximum Deceleration of 10,000.
            let braking = |bench: &Bench| ["X", "Y"].map(|axis| bench.axis(axis).command[1] != 0.0);
            bench.run(4);
            assert_eq!(braking(&bench), [action != Shutdown, true], "{why}");
            bench.run(1);
            assert_eq!(bench.axis("X").cip_state, at_once, "{why}");
            bench.run(1);
            assert_eq!(
                (braking(&bench), bench.axis("X").cip_state),
                ([false, true], later),
                "{why}"
            );
            bench.run(2);
            assert_eq!(braking(&bench), [false, false], "{why}");
            assert_eq!(bench.axis("Y").cip_state, RUNNING, "{why}");
            assert_eq!(bench.bits("L1"), "EN DN", "{why}: PC stays 0");
            let servo = bench.axis("X").status & (axis_status::SERVO_ACTION_STATUS | axis_status::DRIVE_ENABLE_STATUS);
            assert_eq!(servo != 0, action == StopPlanner, "{why}");
            assert_eq!(bench.call(&format!("MAM(X, A2, 1, -1, {RATES})")), answer, "{why}");
            // A cause that is still there comes back at the next update.
            let faulted = |bench: &Bench| bench.axis("X").fault != 0;
            assert_eq!(bench.call("MAFR(X, R1)"), OK, "{why}");
            assert!(!faulted(&bench), "{why}");
            bench.tick();
            assert!(faulted(&bench), "{why}");
            assert_eq!(bench.bits("R1"), "EN DN", "{why}");
            bench.inject("X", &[]);
            assert_eq!(bench.call("MAFR(X, R2)"), OK, "{why}");
            bench.run(2);
            assert!(!faulted(&bench), "{why}");
            let recovered = match action {
                StopDrive => STOPPED,
                Shutdown => SHUTDOWN,
                _ => RUNNING,
            };
            assert_eq!(bench.axis("X").cip_state, recovered, "{why}");
            if action == Shutdown {
                assert_eq!(bench.call("MASR(X, R3)"), OK, "{why}");
                // The axis coasts to rest from 60 units/s.
                bench.run(2000);
            }
            if action != StopPlanner {
                assert_eq!(bench.call("MSO(X, R4)"), OK, "{why}");
                bench.run(2);
            }
            assert_eq!(bench.call(&format!("MAM(X, A3, 1, 1, {RATES})")), OK, "{why}");
            bench.until("A3", Flag::Pc);
        }
    }
}

#[test]
fn soft_travel_is_checked_on_the_actual_position() {
    let keys = "travel = { min = -5.0, max = 10.0 }";
    let mut bench = machine(&[("X", keys)]);
    assert_eq!(bench.call(&format!("MAM(X, A1, 0, 100, {RATES})")), OK);
    while bench.axis("X").actual[0] <= 10.0 {
        assert_eq!(bench.axis("X").motion_faults, [0, 0]);
        assert!(bench.bits("A1").contains("IP"));
        bench.tick();
    }
    assert_eq!(bench.axis("X").motion_faults, [1 << 1, 0]);
    assert_eq!(bench.bits("A1"), "EN DN");
    bench.until_rest();
    let stood = bench.position("X");
    // From 100 units/s at 10,000: half a unit, behind the limit and not before.
    assert!((10.5..10.61).contains(&stood), "{stood}");
    assert_eq!(bench.axis("X").cip_state, RUNNING);

    // Standing outside is no new fault; going further out errs, going back does not.
    assert_eq!(bench.call("MAFR(X, R1)"), OK);
    bench.run(5);
    assert_eq!(bench.axis("X").fault, 0);
    #[rustfmt::skip]
    let cases = [
        ("further out",             format!("MAM(X, A2, 0, 11, {RATES})"),                      (9, 0)),
        ("a jog further out",       "MAJ(X, A2, 0, 10, 0, 500, 0, 500, 0, 0, 100, 100, 2)".to_owned(), (9, 0)),
        ("further out, coordinated", format!("MCLM(XY, L1, 0, [11, 0], {RATES}, 1)"),           (9, 0)),
        ("another axis",            format!("MCLM(XY, L1, 1, [0, 3], {RATES}, 1)"),             OK),
        ("back",                    format!("MAM(X, A2, 0, 9, {RATES})"),                       OK),
    ];
    for (why, call, expected) in cases {
        assert_eq!(bench.call(&call), expected, "{why}");
        bench.until_rest();
        assert_eq!(bench.axis("X").fault, 0, "{why}");
    }
    assert_eq!(bench.position("X"), 9.0);

    // The other side, and exactly to the limits.
    for (target, fault) in [(10.0, 0), (-5.0, 0), (-5.1, 1 << 2)] {
        assert_eq!(bench.call(&format!("MAM(X, A3, 0, {target}, {RATES})")), OK);
        bench.until_rest();
        assert_eq!(bench.axis("X").motion_faults, [fault, 0], "{target}");
    }

    // An axis that is not homed has no limits.
    let mut bench = machine(&[("X", &format!("{keys}\nstart = {{ homed = false }}"))]);
    assert_eq!(bench.call(&format!("MAM(X, A1, 0, 20, {RATES})")), OK);
    bench.until_rest();
    assert_eq!((bench.position("X"), bench.axis("X").fault), (20.0, 0));
}

#[test]
fn a_following_error_faults_when_it_lasts() {
    for (time, updates) in [(0.0, 0), (0.05, 50)] {
        let drive = format!(
            "drive = {{ position_bandwidth_hz = 1.0, velocity_feedforward = 0.0, position_error_tolerance = 5.0, \
             position_error_tolerance_time = {time:.3} }}"
        );
        let mut bench = machine(&[("X", &drive)]);
        assert_eq!(bench.call(&format!("MAM(X, A1, 0, 500, {RATES})")), OK);
        while bench.axis("X").position_error <= 5.0 {
            bench.tick();
        }
        bench.run(updates);
        if updates > 0 {
            assert_eq!(bench.axis("X").cip_state, ABORTING, "{time}");
        }
        let x = bench.axis("X");
        assert_eq!((x.cip_faults, x.cip_state), ([1 << 54, 0], ABORTING), "{time}");
        assert!(!has(x.cip_status, cip_axis_status::TRACKING_COMMAND_STATUS));
        assert!(has(x.cip_status, cip_axis_status::POWER_STRUCTURE_ENABLED_STATUS));
        assert_eq!(bench.call("MSO(X, R0)"), (20, 0), "while it brakes");
        bench.run(10);
        assert_eq!(bench.axis("X").cip_state, FAULTED, "{time}");
        assert_eq!(bench.call("MSF(X, R1)"), OK, "works, and changes nothing");
        bench.run(2);
        assert_eq!(bench.axis("X").cip_state, FAULTED, "{time}");
        // Without torque the axis has no following error: the cause is gone.
        assert_eq!(bench.call("MASR(X, R2)"), OK);
        bench.run(2);
        assert_eq!(
            (bench.axis("X").cip_state, bench.axis("X").fault),
            (STOPPED, 0),
            "{time}"
        );
    }
    // The error is there for one update less than the time.
    let drive =
        "drive = { position_bandwidth_hz = 1.0, velocity_feedforward = 0.0, position_error_tolerance_time = 10.0 }";
    let mut bench = machine(&[("X", drive)]);
    assert_eq!(bench.call(&format!("MAM(X, A1, 0, 200, {RATES})")), OK);
    bench.until("A1", Flag::Pc);
    assert_eq!(bench.axis("X").fault, 0);
}

#[test]
fn a_faulted_axis_errs_with_20_and_its_place() {
    for kind in [FaultKind::SoftTravelPositive, FaultKind::Drive] {
        let mut bench = machine(&[]);
        bench.inject("Y", &[kind]);
        bench.run(3);
        #[rustfmt::skip]
        let cases = [
            (format!("MAM(Y, T1, 1, 1, {RATES})"),                          (20, 0)),
            ("MSO(Y, T2)".to_owned(),                                       (20, 0)),
            (format!("MCLM(CS1, T3, 1, [0, 1, 0], {RATES}, 1)"),            (20, 1)),
            (format!("MCCM(XY, T4, 0, [2, 0], 2, [1], 0, {RATES}, 1)"),     (20, 1)),
            ("MCCD(CS1, T5, CoordinatedMove, Yes, 9, 0, No, 0, 0, No, 0, 0, No, 0, No, 0, 2, 0)".to_owned(), (20, 1)),
            ("MAS(Y, T6, All, No, 100, 0, No, 100, 2)".to_owned(),          OK),
            ("MCS(CS1, T7, 0, 0, 0, 0, 0, 0, 0)".to_owned(),                OK),
            ("MSF(X, T8)".to_owned(),                                       OK),
            ("MCSR(CS1, T9)".to_owned(),                                    (20, 1)),
            ("MGSR(Motion, T10)".to_owned(),                                (81, 0)),
            ("MASD(Y, T11)".to_owned(),                                     OK),
            ("MSO(Y, T12)".to_owned(),                                      (7, 0)),
        ];
        for (call, expected) in cases {
            assert_eq!(bench.call(&call), expected, "{kind:?}: {call}");
            bench.run(3);
            assert_ne!(bench.axis("Y").fault, 0, "{call}: the cause is still there");
        }
        bench.inject("Y", &[]);
        assert_eq!(bench.call("MGSR(Motion, T13)"), OK);
        bench.run(2);
        assert_eq!(
            (bench.axis("Y").cip_state, bench.axis("Y").fault),
            (STOPPED, 0),
            "{kind:?}"
        );
        assert_eq!(bench.call("MCSR(CS1, T14)"), OK);
    }
}

#[test]
fn a_reset_while_the_axis_brakes_leaves_it_stopped() {
    let mut bench = moving(&[]);
    bench.inject("X", &[FaultKind::Overcurrent]);
    bench.run(2);
    bench.inject("X", &[]);
    assert_eq!(bench.call("MAFR(X, R1)"), OK);
    assert_eq!(bench.axis("X").cip_state, ABORTING);
    bench.run(5);
    assert_eq!((bench.axis("X").cip_state, bench.axis("X").fault), (STOPPED, 0));
}

#[test]
fn several_faults_take_the_strongest_action_and_show_all_bits() {
    let mut bench = moving(&[]);
    let kinds = [
        FaultKind::SoftTravelNegative,
        FaultKind::Overcurrent,
        FaultKind::FeedbackLoss,
    ];
    bench.inject("X", &kinds);
    bench.tick();
    let x = bench.axis("X");
    assert_eq!((x.motion_faults[0], x.cip_faults[0]), (1 << 2, 1 << 1 | 1 << 43));
    assert_eq!(x.fault, axis_fault::MOTION_FAULT | axis_fault::PHYSICAL_AXIS_FAULT);
    assert_eq!(x.cip_state, ABORTING);
}

#[test]
fn a_virtual_axis_has_only_soft_travel_faults() {
    let keys = "travel = { min = -5.0, max = 10.0 }\nexception_actions = { soft_travel_positive = \"stop_drive\" }";
    let mut bench = machine(&[("A", keys)]);
    bench.inject("A", &[FaultKind::Drive, FaultKind::PositionError]);
    bench.run(2);
    assert_eq!(bench.axis("A").fault, 0);
    assert_eq!(bench.call(&format!("MAM(A, A1, 0, 100, {RATES})")), OK);
    bench.until_rest();
    assert_eq!(
        bench.axis("A").fault,
        axis_fault::PHYSICAL_AXIS_FAULT,
        "it has no MotionFault"
    );
    assert_eq!(bench.axis("A").cip_state, RUNNING, "there is no drive to stop");
    assert_eq!(bench.call(&format!("MAM(A, A2, 0, 0, {RATES})")), (20, 0));
    assert_eq!(bench.call("MAFR(A, R1)"), OK);
    assert_eq!(bench.call(&format!("MAM(A, A3, 0, 0, {RATES})")), OK);
    bench.until_rest();
    assert_eq!(bench.position("A"), 0.0);
}

#[test]
fn the_average_velocity_is_the_way_within_its_timebase() {
    let mut bench = machine(&[("X", "average_velocity_timebase = 0.1")]);
    assert_eq!(bench.call(&format!("MAM(X, A1, 0, 100, {RATES})")), OK);
    bench.run(250);
    let before = bench.axis("X").actual[0];
    assert!((bench.axis("X").average_velocity - 100.0).abs() < 1e-9);
    assert_eq!(bench.call("MAS(X, S1, All, No, 100, 0, No, 100, 2)"), OK);
    bench.run(100);
    let x = bench.axis("X");
    assert!((x.average_velocity - (x.actual[0] - before) / 0.1).abs() < 1e-9);
    bench.run(100);
    assert_eq!(bench.axis("X").average_velocity, 0.0);
}

#[test]
fn faults_survive_a_restart_until_they_are_reset() {
    use ExceptionAction::{Alarm, FaultStatusOnly, Shutdown, StopDrive, StopPlanner};
    for fault in &FAULTS {
        #[rustfmt::skip]
        let cases = [
            // action,        comes back, state,    MSO before the reset
            (Alarm,           false,      STOPPED,  OK),
            (FaultStatusOnly, true,       STOPPED,  OK),
            (StopPlanner,     true,       STOPPED,  (20, 0)),
            (StopDrive,       true,       FAULTED,  (20, 0)),
            (Shutdown,        true,       SHUTDOWN, (7, 0)),
        ];
        for (action, comes_back, state, answer) in cases {
            let why = format!("{} {}", fault.word, action.word());
            if fault.kind == FaultKind::CommandLimit && !action.stops() {
                continue;
            }
            let keys = format!("exception_actions = {{ {} = \"{}\" }}", fault.word, action.word());
            let mut bench = machine(&[("X", &keys)]);
            bench.inject("X", &[fault.kind]);
            bench.run(10);
            let before = bench.axis("X");
            let mut bench = bench.restarted();
            bench.run(2);
            let x = bench.axis("X");
            assert_eq!(x.fault, before.fault, "{why}");
            assert_eq!(
                (x.motion_faults[0], x.cip_faults[0]),
                (before.motion_faults[0], before.cip_faults[0]),
                "{why}"
            );
            assert_eq!((x.fault != 0, x.cip_state), (comes_back, state), "{why}");
            assert_eq!(bench.call("MSO(X, M1)"), answer, "{why}");
            // The cause is gone.
            assert_eq!(bench.call("MASR(X, M2)"), OK, "{why}");
            bench.run(2);
            assert_eq!((bench.axis("X").fault, bench.call("MSO(X, M3)")), (0, OK), "{why}");
            bench.run(2);
            assert_eq!(bench.axis("X").cip_state, RUNNING, "{why}");
        }
    }
}

/// The cause that ended an instruction, by its last event; names in place of tags.
fn ending(bench: &Bench, tag: &str) -> String {
    let ended = bench
        .events
        .iter()
        .rfind(|(name, event)| name == tag && event.clear & Flag::Ip.mask() != 0);
    let Some((_, event)) = ended else {
        return "it goes on".to_owned();
    };
    match event.cause {
        Cause::Itself => "itself".to_owned(),
        Cause::Instruction { mnemonic, .. } => mnemonic.to_string(),
        Cause::Fault { axis, faults } => format!("axis {axis} {}", Ending::words(faults).join(" ")),
        Cause::StopAll => "stop of everything".to_owned(),
        Cause::Jog(why) => format!("jog {}", why.word()),
    }
}

#[test]
fn an_end_before_the_end_has_its_cause() {
    #[rustfmt::skip]
    let cases = [
        // why,                       what ends,                                             L1,        L2,        A1
        ("a stop of the system",      "MCS(CS1, E, 0)",                                     ["MCS",    "MCS",    "it goes on"]),
        ("a merge",                   "MCLM(CS1, E, 0, [0, 0, 9], 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1, 1, 0)", ["MCLM", "MCLM", "it goes on"]),
        ("a stop of the axis",        "MAS(S, E, 0)",                                       ["it goes on", "it goes on", "MAS"]),
        ("a stop of the group",       "MGS(Motion, E, 1)",                                  ["MGS",    "MGS",    "MGS"]),
        ("an axis that is shut down", "MASD(X, E)",                                         ["MASD",   "MASD",   "it goes on"]),
        ("the drive that goes off",   "MSF(S, E)",                                          ["it goes on", "it goes on", "MSF"]),
    ];
    for (why, call, expected) in cases {
        let mut bench = moving(&[]);
        assert_eq!(bench.call(call), OK, "{why}");
        bench.run(5);
        assert_eq!(["L1", "L2", "A1"].map(|tag| ending(&bench, tag)), expected, "{why}");
    }
    // A fault, on whose axis the moves are; and one of another axis, which they do not mind.
    for (axis, expected) in [
        ("X", "axis 0 overcurrent"),
        ("Z", "axis 2 overcurrent"),
        ("B", "it goes on"),
    ] {
        let mut bench = moving(&[]);
        bench.inject(axis, &[FaultKind::Overcurrent]);
        bench.run(5);
        let other = "it goes on".to_owned();
        let expected = [expected.to_owned(), expected.to_owned(), other];
        assert_eq!(["L1", "L2", "A1"].map(|tag| ending(&bench, tag)), expected, "{axis}");
    }
    let mut bench = moving(&[]);
    bench.stop_all();
    bench.run(5);
    assert_eq!(
        ["L1", "L2", "A1"].map(|tag| ending(&bench, tag)),
        ["stop of everything"; 3]
    );
    let mut bench = Bench::new();
    assert_eq!(bench.call(&format!("MAM(S, A1, 0, 1, {RATES})")), OK);
    bench.run(500);
    assert_eq!(ending(&bench, "A1"), "itself", "it came to its end");
}

#[test]
fn changes_of_faults_are_reported() {
    let mut bench = Bench::new();
    let words = |bench: &mut Bench| -> Vec<[String; 3]> {
        let changes = std::mem::take(&mut bench.fault_changes);
        let told = changes.iter().map(|change| {
            assert_eq!(change.axis.index(), 0);
            [change.set, change.again, change.clear].map(|faults| Ending::words(faults).join(" "))
        });
        told.collect()
    };
    let row = |set: &str, again: &str, clear: &str| [set.to_owned(), again.to_owned(), clear.to_owned()];
    bench.inject("X", &[FaultKind::Overcurrent]);
    bench.run(10);
    assert_eq!(
        words(&mut bench),
        [row("overcurrent", "", "")],
        "once, not in every update"
    );
    bench.inject("X", &[FaultKind::Overcurrent, FaultKind::Overspeed]);
    bench.run(10);
    assert_eq!(words(&mut bench), [row("overspeed", "", "")]);
    assert_eq!(bench.call("MAFR(X, R)"), OK);
    bench.tick();
    assert!(
        matches!(bench.fault_changes[0].by, Cause::Instruction { mnemonic, .. } if mnemonic.to_string() == "MAFR"),
        "{:?}",
        bench.fault_changes
    );
    bench.run(5);
    let both = "overcurrent overspeed";
    assert_eq!(
        words(&mut bench),
        [row("", "", both), row(both, both, "")],
        "the causes are still there"
    );
    bench.inject("X", &[]);
    bench.run(5);
    assert_eq!(words(&mut bench), Vec::<[String; 3]>::new(), "faults latch");
    assert_eq!(bench.call("MAFR(X, R)"), OK);
    bench.run(5);
    assert_eq!(words(&mut bench), [row("", "", both)]);
    // A fault later is another one.
    bench.inject("X", &[FaultKind::Overcurrent]);
    bench.run(5);
    assert_eq!(words(&mut bench), [row("overcurrent", "", "")]);
}
