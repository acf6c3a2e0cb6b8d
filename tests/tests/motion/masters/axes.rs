//! MDAC, and MAM and MAJ by the way of a master (spec/axis-and-data-types.md §1.5, §3.3, §3.4, §3.8).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::motion_status::{ACCEL_STATUS, JOG_LOCK_STATUS, MOVE_LOCK_STATUS};
use arcline_tests::bench::{Bench, OK};

/// The operands from Speed on: 2 units per master unit, 1 unit per master unit².
const DRIVEN: &str = "2, 4, 1, 4, 1, 4, 0, 100, 100, 6";
/// The same by time.
const TIMED: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";

#[track_caller]
fn execute(bench: &mut Bench, call: &str) {
    assert_eq!(bench.call(call), OK, "{call}");
}

/// X is linked to A for everything.
fn linked() -> Bench {
    let mut bench = Bench::new();
    execute(&mut bench, "MDAC(X, A, D1, All, Command);");
    bench
}

/// A jogs, at full speed after 5 ms.
fn jog(bench: &mut Bench, speed: f64) {
    let call = format!(
        "MAJ(A, J1, {}, {}, 0, 10000, 0, 10000, 0, 0, 100, 100, 2, Disabled, Programmed);",
        u8::from(speed < 0.0),
        speed.abs()
    );
    execute(bench, &call);
}

fn bit(bench: &Bench, bit: u32) -> bool {
    bench.axis("X").motion_status & bit != 0
}

#[track_caller]
fn near(is: f64, expected: f64, why: &str) {
    assert!((is - expected).abs() < 1e-9, "{why}: {is} is not {expected}");
}

/// The position of a move of 100 at a displacement of its master (spec/coordinated-instructions.md §27.8), with speed and acceleration by it.
pub(super) fn planned(way: f64) -> [f64; 3] {
    match way {
        way if way < 2.0 => [0.5 * way * way, way, 1.0],
        way if way < 50.0 => [2.0 + 2.0 * (way - 2.0), 2.0, 0.0],
        way if way < 52.0 => [100.0 - 0.5 * (52.0 - way).powi(2), 52.0 - way, -1.0],
        _ => [100.0, 0.0, 0.0],
    }
}

#[test]
fn a_move_is_a_function_of_the_masters_way_and_its_speed_one_of_time() {
    // In units per master unit, and as a whole master distance of which ramps take 2 each.
    for dynamics in [DRIVEN, "52, 7, 2, 7, 2, 7, 0, 1, 1, 7"] {
        let mut bench = linked();
        let call = format!(
            "MAM(X, M1, 0, 100, {dynamics}, Disabled, Programmed, 10, PositionForwardOnly, [0, 2, 50], Data3);"
        );
        execute(&mut bench, &call);
        assert_eq!(bench.bits("M1"), "EN DN IP AC CalculatedDataAvailable", "{dynamics}");
        jog(&mut bench, 50.0);
        while bench.position("A") < 10.0 {
            assert_eq!(bench.position("X"), 0.0, "nothing moves before the lock");
            assert!(!bit(&bench, MOVE_LOCK_STATUS));
            bench.tick();
        }
        for (is, expected) in bench.array("Data3").iter().zip([52.0, 50.0, 26.0]) {
            near(*is, expected, "calculated");
        }
        while !bench.control("M1").has(Flag::Pc) {
            let way = bench.position("A") - 10.0;
            let [position, slope, bend] = planned(way);
            let command = bench.axis("X").command;
            near(command[0], position, "position");
            near(command[1], 50.0 * slope, "velocity");
            near(command[2], 2500.0 * bend, "acceleration");
            assert!(bit(&bench, MOVE_LOCK_STATUS), "at {way}");
            assert_eq!(
                bench.control("M1").has(Flag::TrackingMaster),
                (2.0..50.0).contains(&way),
                "at {way}"
            );
            assert_eq!(bit(&bench, ACCEL_STATUS), way < 2.0, "at {way}");
            bench.tick();
        }
        assert_eq!(bench.position("X"), 100.0);
        assert!((62.0..62.1).contains(&(bench.position("A") + 1e-9)));
        assert_eq!(bench.bits("M1"), "EN DN PC CalculatedDataAvailable");
        assert_eq!(bench.bits("D1"), "EN DN IP");
        assert!(!bit(&bench, MOVE_LOCK_STATUS));
    }
}

#[test]
fn a_jog_goes_as_fast_as_its_master_says_and_stands_with_it() {
    let mut bench = linked();
    jog(&mut bench, 50.0);
    bench.run(20);
    execute(
        &mut bench,
        &format!("MAJ(X, M1, Reverse, {DRIVEN}, Disabled, Programmed, 0, ImmediateForwardOnly);"),
    );
    bench.run(60);
    assert_eq!(bench.bits("M1"), "EN DN IP AC TrackingMaster");
    assert_eq!(bench.bits("D1"), "EN DN IP AC");
    near(bench.axis("X").command[1], -100.0, "twice as fast, the other way");
    assert!(bit(&bench, JOG_LOCK_STATUS));
    jog(&mut bench, -50.0);
    bench.run(20);
    let stands = bench.position("X");
    assert_eq!((bench.axis("X").command[1], bit(&bench, JOG_LOCK_STATUS)), (0.0, false));
    jog(&mut bench, 50.0);
    bench.run(12);
    assert_eq!(bench.position("X"), stands, "the master is not yet where it turned");
    bench.run(30);
    near(bench.axis("X").command[1], -100.0, "it is followed again");
    // The stop is one by time, out of the speed that it really has.
    execute(&mut bench, "MAS(X, S, Jog, Yes, 1000, 0, No, 0, 0);");
    let from = bench.position("X");
    bench.tick();
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("D1").as_str()),
        ("EN DN", "EN DN IP")
    );
    assert_eq!(bench.until("S", Flag::Pc), 99);
    near(bench.position("X"), from - 5.0, "100 units/s at 1000 units/s²");
}

#[test]
fn a_move_that_is_stopped_brakes_from_the_speed_that_it_really_has() {
    let mut bench = linked();
    jog(&mut bench, 50.0);
    execute(
        &mut bench,
        &format!("MAM(X, M1, 0, 500, {DRIVEN}, Disabled, Programmed, 0, 1, [0], Data1);"),
    );
    bench.run(500);
    near(bench.axis("X").command[1], 100.0, "at speed");
    let from = bench.position("X");
    execute(&mut bench, "MAS(X, S, Move, Yes, 1000, 0, No, 0, 0);");
    assert_eq!(bench.bits("M1"), "EN DN");
    assert_eq!(bench.until("S", Flag::Pc), 100);
    near(bench.position("X"), from + 5.0, "100 units/s at 1000 units/s²");
    assert_eq!(bench.bits("D1"), "EN DN IP");
}

#[test]
fn a_change_of_dynamics_is_one_of_the_same_mode_and_calculated_anew() {
    let mut bench = linked();
    execute(
        &mut bench,
        &format!("MAM(X, M1, 0, 100, {DRIVEN}, Disabled, Programmed, 0, 1, [0, 60], Data2);"),
    );
    let lead = |bench: &mut Bench, to: f64| {
        execute(bench, &format!("MAM(A, Go, 0, {to}, {TIMED});"));
        bench.until("Go", Flag::Pc);
    };
    lead(&mut bench, 26.0);
    near(bench.position("X"), 50.0, "at half its way");
    let change = |speed: f64, units: u8| {
        format!("MCD(X, C, Move, Yes, {speed}, No, 1, No, 1, No, 1, No, 1, {units}, {units}, {units}, {units});")
    };
    assert_eq!(bench.call(&change(1.0, 0)), (105, 0));
    execute(&mut bench, &change(1.0, 4));
    assert!(!bench.control("M1").has(Flag::CalculatedDataAvailable));
    bench.run(2);
    assert!(bench.control("M1").has(Flag::CalculatedDataAvailable));
    for (is, expected) in bench.array("Data2").iter().zip([76.0, 21.0]) {
        near(*is, expected, "from its start");
    }
    // A pause is part of it.
    lead(&mut bench, 46.0);
    execute(&mut bench, &change(0.0, 4));
    bench.run(3);
    assert!(
        !bench.control("M1").has(Flag::CalculatedDataAvailable),
        "it does not come to its end"
    );
    lead(&mut bench, 60.0);
    execute(&mut bench, &change(1.0, 4));
    lead(&mut bench, 100.0);
    assert_eq!(bench.bits("M1"), "EN DN PC CalculatedDataAvailable");
    // 70.5 at 46; a ramp of 0.5 in 1 down and another one up: 29.5 - 1.5 at 1 and the last ramp.
    near(bench.array("Data2")[0], 60.0 + 1.0 + 28.0 - 0.0 + 1.0, "with the pause");
}

#[test]
fn master_driven_motion_without_its_link_is_refused() {
    let driven = |more: &str| format!("MAM(X, M1, 0, 100, {DRIVEN}, Disabled, Programmed, {more});");
    let merged = |more: &str| format!("MAM(X, M2, 0, 100, {DRIVEN}, Enabled, Programmed, {more});");
    let jogged = |more: &str| format!("MAJ(X, M2, 0, {DRIVEN}, Enabled, Programmed, {more});");
    let unlinked = |call: &str| Bench::new().call(call);
    assert_eq!(unlinked(&driven("0, 1, 0, 0")), (93, 0), "no link");
    let mut jogs = Bench::new();
    execute(&mut jogs, "MDAC(X, A, D1, Jog, Command);");
    assert_eq!(jogs.call(&driven("0, 1, 0, 0")), (93, 0), "a link for jogs alone");
    assert_eq!(jogs.call(&jogged("0, 1")), OK);
    #[rustfmt::skip]
    let at_rest = [
        // why,                         call,                                                                      status
        ("time for speed alone",        "MAM(X, M1, 0, 100, 2, 0, 1, 4, 1, 4, 0, 100, 100, 6, 0, 0, 0, 0, 0, 0);".to_owned(), (94, 0)),
        ("no lock",                     driven("0, None, 0, 0"),                                                   (95, 0)),
        ("a lock by time",              format!("MAM(X, M1, 0, 100, {TIMED}, 0, 0, 0, 1, 0, 0);"),                 (95, 0)),
        ("too few answers",             driven("0, 1, [0, 1], Data1"),                                             (101, 0)),
        ("too many answers",            driven("0, 1, [0, 1], Data3"),                                             (101, 0)),
        ("a link of one kind beside all", "MDAC(X, B, D2, Move, Command);".to_owned(),                             (96, 0)),
    ];
    for (why, call, expected) in at_rest {
        assert_eq!(linked().call(&call), expected, "{why}");
    }
    // While X moves by time, at 100 units/s.
    #[rustfmt::skip]
    let moving = [
        // why,                         the master's speed, call,                  status
        ("the master stands",           0.0,                merged("0, 1, 0, 0"),  (97, 0)),
        ("a jog, the master stands",    0.0,                jogged("0, 1"),        (97, 0)),
        ("the master goes away",        -50.0,              merged("0, 1, 0, 0"),  (98, 0)),
        ("a lock to wait for",          50.0,               merged("999, 3, 0, 0"), (102, 0)),
        ("no way to slow down",         0.5,                merged("0, 1, 0, 0"),  (103, 0)),
        ("with it",                     50.0,               merged("0, 1, 0, 0"),  OK),
    ];
    for (why, speed, call, expected) in moving {
        let mut bench = linked();
        if speed != 0.0 {
            jog(&mut bench, speed);
        }
        execute(&mut bench, &format!("MAM(X, M1, 0, 60, {TIMED});"));
        bench.run(300);
        assert_eq!(bench.call(&call), expected, "{why}");
    }
    // Another reference of the active master while it is followed.
    let mut bench = linked();
    execute(&mut bench, &driven("0, 1, 0, 0"));
    assert_eq!(bench.call("MDAC(X, A, D2, All, Actual);"), (105, 0));
    bench.tick();
    assert_eq!(bench.bits("D1"), "EN DN IP AC");
}

#[test]
fn another_master_waits_until_a_motion_begins_by_it() {
    let mut bench = linked();
    jog(&mut bench, 50.0);
    execute(
        &mut bench,
        &format!("MAM(X, M1, 0, 400, {DRIVEN}, Disabled, Programmed, 0, 1, 0, 0);"),
    );
    execute(
        &mut bench,
        "MAJ(B, J2, Forward, 25, 0, 10000, 0, 10000, 0, 0, 100, 100, 2, Disabled, Programmed);",
    );
    bench.run(500);
    execute(&mut bench, "MDAC(X, B, D2, All, Command);");
    bench.tick();
    assert_eq!(
        (bench.bits("D1").as_str(), bench.bits("D2").as_str()),
        ("EN DN IP AC", "EN DN IP")
    );
    let speed = bench.axis("X").command[1];
    execute(
        &mut bench,
        &format!("MAM(X, M2, 0, 400, {DRIVEN}, Disabled, Programmed, 0, 1, 0, 0);"),
    );
    assert_eq!(bench.bits("M1"), "EN DN");
    bench.tick();
    assert_eq!(
        (bench.bits("D1").as_str(), bench.bits("D2").as_str()),
        ("EN DN", "EN DN IP AC")
    );
    assert!((bench.axis("X").command[1] - speed).abs() < 3.0, "no step of speed");
    assert_eq!(bench.bits("M2"), "EN DN IP AC DECEL", "4 units per unit of B, to 2");
    bench.run(300);
    assert_eq!(bench.bits("M2"), "EN DN IP AC TrackingMaster");
    near(bench.axis("X").command[1], 50.0, "by the other master");
}

#[test]
fn both_modes_move_one_axis_at_a_time() {
    let mut bench = Bench::new();
    execute(&mut bench, "MDCC(CS1, A, D1, Command, 0);");
    jog(&mut bench, 50.0);
    execute(
        &mut bench,
        &format!("MCLM(CS1, M1, 0, [100, 0, 0], {DRIVEN}, 1, 0, 0, 0, 0, 1, 0, 0);"),
    );
    execute(&mut bench, &format!("MAM(X, M2, 1, 30, {TIMED});"));
    bench.run(100);
    near(bench.axis("X").command[1], 200.0, "the sum of both");
    bench.until("M2", Flag::Pc);
    bench.until("M1", Flag::Pc);
    near(bench.position("X"), 130.0, "the sum of both ways");
}
