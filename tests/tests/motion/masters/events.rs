//! Event Distance and Calculated Data of coordinated moves, by time and by the way of a master, and termination types in both
//! (spec/coordinated-instructions.md §7, §8.4, §9; the reference page MCCD).
//!
//! Every row is run twice with the same numbers: by time, a hundred times as fast, master units are hundredths of seconds.

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status::MOVE_TRANSITION_STATUS;
use arcline_tests::bench::{Bench, OK};

/// The time base of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Time,
    Master,
}

use Mode::{Master, Time};

/// Speed of the master, master units/s: that at which corners are meant.
const NOMINAL: f64 = 100.0;

impl Mode {
    /// The scale between the time bases: seconds per master unit.
    fn scale(self) -> f64 {
        match self {
            Time => 1.0 / NOMINAL,
            Master => 1.0,
        }
    }

    /// Speed to Jerk Units: 2 units per master unit, 1 unit per master unit²; or a hundred times as fast.
    fn dynamics(self) -> &'static str {
        match self {
            Time => "200, 0, 10000, 0, 10000, 0, 0, 100, 100, 2",
            Master => "2, 4, 1, 4, 1, 4, 0, 100, 100, 6",
        }
    }

    fn lock(self) -> u8 {
        match self {
            Time => 0,
            Master => 1,
        }
    }
}

/// CS1 with queues of four, linked to A.
fn bench() -> Bench {
    let deep = "command_tolerance = 0.5\nqueue_depth = 4";
    let mut bench = Bench::with(&arcline_config::DEFAULT.replace("command_tolerance = 0.5", deep));
    assert_eq!(bench.call(&format!("MDCC(CS1, A, D1, Command, {NOMINAL});")), OK);
    bench
}

fn line(mode: Mode, tag: &str, to: [f64; 3], ending: u8, tolerance: f64, events: &str) -> String {
    let (dynamics, lock) = (mode.dynamics(), mode.lock());
    format!(
        "MCLM(CS1, {tag}, 0, {to:?}, {dynamics}, {ending}, Disabled, Programmed, {tolerance}, 0, {lock}, {events});"
    )
}

#[track_caller]
fn execute(bench: &mut Bench, call: &str) {
    assert_eq!(bench.call(call), OK, "{call}");
}

/// The master goes to a position.
fn lead(bench: &mut Bench, to: f64) {
    execute(
        bench,
        &format!("MAM(A, Go, 0, {to}, 500, 0, 20000, 0, 20000, 0, 0, 100, 100, 2);"),
    );
    bench.until("Go", Flag::Pc);
}

/// Advances by a displacement, in master units or in hundredths of seconds.
fn go_on(bench: &mut Bench, mode: Mode, by: f64) {
    match mode {
        Time => bench.run((by * 10.0).round() as u64),
        Master => {
            let to = bench.position("A") + by;
            lead(bench, to);
        }
    }
}

#[track_caller]
fn answers(bench: &Bench, mode: Mode, array: &str, expected: &[f64], why: &str) {
    let is = bench.array(array);
    assert_eq!(is.len(), expected.len(), "{why}");
    for (is, expected) in is.iter().zip(expected) {
        // -1 says that a distance was skipped.
        let expected = if *expected < 0.0 {
            *expected
        } else {
            expected * mode.scale()
        };
        assert!((is - expected).abs() < 1e-9, "{why}, {mode:?}: {is} is not {expected}");
    }
}

#[test]
fn distances_of_one_move() {
    for mode in [Time, Master] {
        let mut bench = bench();
        execute(
            &mut bench,
            &line(mode, "M1", [100.0, 0.0, 0.0], 1, 0.0, "[0, 2, 50, -3, 200, 100], Data6"),
        );
        assert!(bench.control("M1").has(Flag::CalculatedDataAvailable), "{mode:?}");
        bench.tick();
        // spec/coordinated-instructions.md §27.8, and: skipped, before its start, at its start.
        answers(&bench, mode, "Data6", &[52.0, 50.0, 26.0, -1.0, 0.0, 0.0], "a line");
        execute(&mut bench, &line(mode, "M2", [100.0, 50.0, 0.0], 1, 0.0, "0, 0"));
        assert!(
            !bench.control("M2").has(Flag::CalculatedDataAvailable),
            "nothing is asked for"
        );
        let short = line(mode, "M3", [0.0, 0.0, 0.0], 1, 0.0, "[0, 1], Data1");
        assert_eq!(bench.call(&short), (101, 0), "{mode:?}");
    }
}

/// The transition from a line of 100 to its successor: the successor's end, Termination Type, Command Tolerance, the time at which the
/// first is complete, and whether the path leaves the corner.
type Change = (&'static str, [f64; 3], u8, f64, f64, bool);

#[test]
fn termination_types_by_time_and_by_a_master() {
    let (corner, on) = ([100.0, 100.0, 0.0], [200.0, 0.0, 0.0]);
    #[rustfmt::skip]
    let changes: [Change; 17] = [
        // why                                      second,  type, tolerance, complete at,                   blended
        ("actual tolerance",                        corner,  0,    0.0,       52.0,                          false),
        ("no settle",                               corner,  1,    9.0,       52.0,                          false),
        // Half a unit before the end, at a speed of 1, a ramp of 1 is left.
        ("the tolerance of the system",             corner,  2,    9.0,       51.0,                          true),
        ("no decel",                                corner,  3,    9.0,       50.0,                          true),
        ("a programmed tolerance",                  corner,  6,    0.125,     51.5,                          true),
        ("a tolerance beyond the deceleration",     corner,  6,    30.0,      50.0,                          true),
        ("no tolerance",                            corner,  6,    0.0,       52.0,                          false),
        // An axis may change by 10 units/s at once: a speed of 0.1.
        ("constrained, round a corner",             corner,  4,    9.0,       2.0 + 48.0025 + 1.9,           false),
        ("unconstrained, round a corner",           corner,  5,    9.0,       2.0 + 48.0025 + 1.9,           false),
        ("constrained, straight on",                on,      4,    9.0,       51.0,                          false),
        ("unconstrained, straight on",              on,      5,    9.0,       51.0,                          false),
        ("no decel, straight on",                   on,      3,    9.0,       51.0,                          false),
        ("the system's tolerance, straight on",     on,      2,    9.0,       51.0 - 0.25,                   false),
        ("a programmed one, straight on",           on,      6,    9.0,       51.0 - 4.5,                    false),
        ("no settle, straight on",                  on,      1,    9.0,       52.0,                          false),
        // A blend of both along one line turns before the end.
        ("no decel, and back",            [0.0, 0.0, 0.0],   3,    9.0,       50.0,                          true),
        ("constrained, and back",         [0.0, 0.0, 0.0],   4,    9.0,       2.0 + 48.000625 + 1.95,        false),
    ];
    for (why, second, ending, tolerance, complete, blended) in changes {
        for mode in [Time, Master] {
            let mut bench = bench();
            execute(
                &mut bench,
                &line(mode, "M1", [100.0, 0.0, 0.0], ending, tolerance, "[0], Of1"),
            );
            execute(&mut bench, &line(mode, "M2", second, 1, 0.0, "[0], Then1"));
            bench.tick();
            answers(&bench, mode, "Of1", &[complete], why);
            let begun = bench.now() - 1;
            if mode == Master {
                execute(
                    &mut bench,
                    "MAJ(A, J, 0, 200, 0, 20000, 0, 20000, 0, 0, 100, 100, 2, Disabled, Programmed);",
                );
            }
            let mut was_blended = false;
            let mut before = 0.0;
            let gone = |bench: &Bench| match mode {
                Time => (bench.now() - begun) as f64 * 1e-3,
                Master => bench.position("A"),
            };
            while !bench.control("M1").has(Flag::Pc) {
                before = gone(&bench);
                bench.tick();
            }
            let complete = complete * mode.scale();
            assert!(
                before < complete + 1e-9 && gone(&bench) > complete - 1e-9,
                "{why}, {mode:?}: complete between {before} and {}, not at {complete}",
                gone(&bench)
            );
            assert_eq!(bench.bits("M1").split(' ').nth(2), Some("PC"), "{why}, {mode:?}");
            while !bench.control("M2").has(Flag::Pc) {
                was_blended |= bench.system("CS1").motion_status & MOVE_TRANSITION_STATUS != 0;
                bench.tick();
            }
            assert_eq!(was_blended, blended, "{why}, {mode:?}");
            // The whole is the sum of both.
            let whole = complete + bench.array("Then1")[0];
            let update = if mode == Time { 1e-3 } else { 0.2 };
            assert!((gone(&bench) - whole).abs() < 1.1 * update, "{why}, {mode:?}");
            let end = ["X", "Y"].map(|axis| bench.position(axis));
            assert!(
                (end[0] - second[0]).abs() < 1e-9 && (end[1] - second[1]).abs() < 1e-9,
                "{why}, {mode:?}: {end:?}"
            );
        }
    }
}

/// MCCD of the speed.
fn change(mode: Mode, speed: f64, scope: &str) -> String {
    let (speed, units) = match mode {
        Time => (speed * NOMINAL, ["0", "0", "0", "0"]),
        Master => (speed, ["4", "4", "4", "4"]),
    };
    let [own, accel, decel, jerk] = units;
    format!("MCCD(CS1, C, 1, Yes, {speed}, {own}, No, 1, {accel}, No, 1, {decel}, No, 1, No, 1, {jerk}, {scope});")
}

#[test]
fn a_change_of_dynamics_is_calculated_from_the_start_of_the_move() {
    for mode in [Time, Master] {
        let mut bench = bench();
        execute(
            &mut bench,
            &line(mode, "M1", [100.0, 0.0, 0.0], 1, 0.0, "[0, 2, 60], Data3"),
        );
        go_on(&mut bench, mode, 26.0);
        answers(&bench, mode, "Data3", &[52.0, 50.0, 21.0], "as programmed");
        assert!((bench.position("X") - 50.0).abs() < 1e-9);
        // From 2 to 1 on 1.5 in 1; 48 at 1; the ramp of 0.5 in 1.
        execute(&mut bench, &change(mode, 1.0, "ActiveMotion"));
        assert!(
            !bench.control("M1").has(Flag::CalculatedDataAvailable),
            "{mode:?}: recalculated"
        );
        bench.tick();
        assert!(
            !bench.control("M1").has(Flag::CalculatedDataAvailable),
            "{mode:?}: for an update"
        );
        bench.tick();
        assert!(
            bench.control("M1").has(Flag::CalculatedDataAvailable),
            "{mode:?}: available again"
        );
        // The moves behind the event keep their answer.
        answers(
            &bench,
            mode,
            "Data3",
            &[26.0 + 1.0 + 48.0 + 1.0, 26.0 + 1.0 + 46.5, 21.0],
            "slower",
        );

        // Not while it stands; then the standstill is part of it.
        let mut bench = self::bench();
        execute(
            &mut bench,
            &line(mode, "M1", [100.0, 0.0, 0.0], 1, 0.0, "[0, 2, 60], Data3"),
        );
        go_on(&mut bench, mode, 26.0);
        execute(&mut bench, &change(mode, 0.0, "ActiveMotion"));
        go_on(&mut bench, mode, 14.0);
        assert_eq!(bench.bits("M1"), "EN DN IP AC", "{mode:?}: it stands at 52");
        assert!((bench.position("X") - 52.0).abs() < 1e-9);
        answers(&bench, mode, "Data3", &[52.0, 50.0, 21.0], "not calculated");
        execute(&mut bench, &change(mode, 2.0, "ActiveMotion"));
        bench.run(2);
        assert!(
            bench.control("M1").has(Flag::CalculatedDataAvailable),
            "{mode:?}: it goes on"
        );
        answers(
            &bench,
            mode,
            "Data3",
            &[40.0 + 2.0 + 22.0 + 2.0, 40.0 + 2.0 + 22.0, 21.0],
            "with the standstill",
        );

        // A stop makes them of no use.
        execute(&mut bench, "MCS(CS1, S, CoordinatedMove, No, 0, 0, No, 0, 0);");
        assert_eq!(bench.bits("M1"), "EN DN", "{mode:?}");
        bench.run(100);
        assert_eq!(bench.bits("M1"), "EN DN", "{mode:?}: not recalculated");
    }
}

#[test]
fn a_change_of_dynamics_of_a_pending_move_is_calculated_when_it_is_active() {
    for (scope, second) in [("ActiveMotion", 52.0), ("ActiveAndPendingMotion", 101.0)] {
        for mode in [Time, Master] {
            let mut bench = bench();
            execute(&mut bench, &line(mode, "M1", [100.0, 0.0, 0.0], 1, 0.0, "[0], Of1"));
            execute(&mut bench, &line(mode, "M2", [100.0, 100.0, 0.0], 1, 0.0, "[0], Then1"));
            go_on(&mut bench, mode, 26.0);
            execute(&mut bench, &change(mode, 1.0, scope));
            go_on(&mut bench, mode, 51.0);
            answers(&bench, mode, "Of1", &[76.0], scope);
            assert_eq!(bench.bits("M1").split(' ').nth(2), Some("PC"), "{scope}, {mode:?}");
            assert!(
                bench.control("M2").has(Flag::CalculatedDataAvailable),
                "{scope}, {mode:?}"
            );
            answers(&bench, mode, "Then1", &[second], scope);
        }
    }
}

#[test]
fn a_later_successor_changes_the_calculated_data() {
    for mode in [Time, Master] {
        let mut bench = bench();
        execute(
            &mut bench,
            &line(mode, "M1", [100.0, 0.0, 0.0], 3, 0.0, "[0, 10], Data2"),
        );
        go_on(&mut bench, mode, 10.0);
        answers(&bench, mode, "Data2", &[52.0, 46.0], "alone");
        execute(&mut bench, &line(mode, "M2", [100.0, 100.0, 0.0], 1, 0.0, "0, 0"));
        bench.tick();
        answers(&bench, mode, "Data2", &[50.0, 46.0], "it blends now");
    }
}
