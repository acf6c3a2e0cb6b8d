//! Master driven motion: MDCC and MDAC, and the moves that are functions of a master's displacement
//! (spec/coordinated-instructions.md §8, §9, §18, §27.8; spec/axis-and-data-types.md §1.5, §3.8).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status;
mod actions;
mod axes;
mod contours;
mod events;
mod followers;
mod kinds;
mod status;
mod ways;

use arcline_tests::bench::{Bench, OK};

/// A machine that is linked: CS1 and Y to A, by command.
fn linked() -> Bench {
    let mut bench = Bench::new();
    assert_eq!(bench.call("MDCC(CS1, A, D1, Command, 0);"), OK);
    bench
}

/// A jogs, forwards with a positive speed, at full speed after 5 ms.
fn jog(bench: &mut Bench, speed: f64) {
    let direction = if speed < 0.0 { "Reverse" } else { "Forward" };
    let text = format!(
        "MAJ(A, J1, {direction}, {}, Unitspersec, 10000, Unitspersec2, 10000, Unitspersec2, Trapezoidal, 100, 100, %ofTime, Disabled, Programmed);",
        speed.abs()
    );
    assert_eq!(bench.call(&text), OK);
}

/// A line of CS1 to X by a master: 2 units per master unit, 1 unit per master unit².
fn line(tag: &str, x: f64, more: &str) -> String {
    format!(
        "MCLM(CS1, {tag}, Absolute, [{x}, 0, 0], 2, Unitspermasterunit, 1, Unitspermasterunit2, 1, Unitspermasterunit2, \
         Trapezoidal, 100, 100, %ofTimeMasterDriven, {more});"
    )
}

/// No blending, no merge, locked at once to a master that goes forwards.
const AT_ONCE: &str = "1, Disabled, Programmed, 0, 0, ImmediateForwardOnly, 0, 0";

/// A bit of CS1's CoordinateMotionStatus.
fn cs1(bench: &Bench, bit: u32) -> bool {
    bench.system("CS1").motion_status & bit != 0
}

#[test]
fn a_move_takes_the_master_distance_of_its_profile() {
    let mut bench = linked();
    // spec/coordinated-instructions.md §27.8: 52 units of the master, locked at 10.
    let lock = "1, Disabled, Programmed, 0, 10, PositionForwardOnly, [0, 2, 50], Data";
    assert_eq!(bench.call(&line("M1", 100.0, lock)), OK);
    assert_eq!(bench.bits("M1"), "EN DN IP AC CalculatedDataAvailable");
    jog(&mut bench, 50.0);
    while bench.position("A") < 10.0 {
        assert_eq!(bench.position("X"), 0.0, "nothing moves before the lock");
        assert!(!cs1(&bench, coordinate_motion_status::COORDINATE_SYSTEM_LOCK_STATUS));
        bench.tick();
    }
    assert!(cs1(&bench, coordinate_motion_status::COORDINATE_SYSTEM_LOCK_STATUS));
    for (calculated, expected) in bench.array("Data").iter().zip([52.0, 50.0, 26.0]) {
        assert!((calculated - expected).abs() < 1e-12, "{calculated} is not {expected}");
    }
    let before = loop {
        let before = bench.position("A");
        bench.tick();
        let way = bench.position("A") - 10.0;
        let x = bench.position("X");
        let expected = match way {
            way if way < 2.0 => 0.5 * way * way,
            way if way < 50.0 => 2.0 + 2.0 * (way - 2.0),
            way if way < 52.0 => 100.0 - 0.5 * (52.0 - way).powi(2),
            _ => 100.0,
        };
        assert!((x - expected).abs() < 1e-9, "{x} is not {expected} at {way}");
        if bench.control("M1").has(Flag::Pc) {
            break before;
        }
        assert_eq!(
            bench.control("M1").has(Flag::TrackingMaster),
            (2.0..50.0).contains(&way),
            "at {way}"
        );
    };
    assert!(before < 62.0 && bench.position("A") >= 62.0 - 1e-9);
    assert_eq!(bench.position("X"), 100.0);
}

#[test]
fn the_speed_of_axes_is_that_of_the_move_times_that_of_the_master() {
    let mut bench = linked();
    jog(&mut bench, 50.0);
    bench.run(20);
    assert_eq!(bench.call(&line("M1", 400.0, AT_ONCE)), OK);
    let mut before = bench.position("X");
    for _ in 0..900 {
        let (velocity, acceleration) = (bench.axis("X").command[1], bench.axis("X").command[2]);
        bench.tick();
        let x = bench.position("X");
        let mean = 0.5 * (velocity + bench.axis("X").command[1]);
        assert!(((x - before) / 1e-3 - mean).abs() < 1e-2, "{x}: {mean}");
        // 1 unit per master unit², at 50 master units/s.
        assert!(
            acceleration == 0.0 || (acceleration.abs() - 2500.0).abs() < 1e-6,
            "{acceleration}"
        );
        before = x;
    }
    assert!((bench.axis("X").command[1] - 100.0).abs() < 1e-9);
    assert!((bench.system("CS1").path_speed - 100.0).abs() < 1e-9);
    assert!(!cs1(&bench, coordinate_motion_status::ACCEL_STATUS));
    // The master slows down, and the slave with it: bits of the instruction show its own ramps only.
    assert_eq!(
        bench.call("MAS(A, S1, Jog, Yes, 100, Unitspersec2, No, 100, %ofTime);"),
        OK
    );
    bench.run(10);
    assert!(cs1(&bench, coordinate_motion_status::DECEL_STATUS));
    assert_eq!(bench.bits("M1"), "EN DN IP AC TrackingMaster");
    bench.until("S1", Flag::Pc);
    bench.run(2);
    assert_eq!(bench.axis("X").command[1], 0.0);
    assert_eq!(bench.bits("M1"), "EN DN IP AC TrackingMaster");
    assert!(
        cs1(&bench, coordinate_motion_status::COORDINATE_SYSTEM_LOCK_STATUS),
        "it stands, and is locked"
    );
}

#[test]
fn a_master_that_turns_round_is_followed_again_from_where_it_was() {
    let mut bench = linked();
    jog(&mut bench, 50.0);
    assert_eq!(bench.call(&line("M1", 100.0, AT_ONCE)), OK);
    bench.run(500);
    jog(&mut bench, -50.0);
    bench.run(12);
    let (furthest, x) = (bench.position("A"), bench.position("X"));
    assert!(!cs1(&bench, coordinate_motion_status::COORDINATE_SYSTEM_LOCK_STATUS));
    bench.run(200);
    assert!(bench.position("A") < furthest - 5.0);
    assert_eq!(bench.position("X"), x, "the slave stays");
    assert_eq!(bench.axis("X").command[1], 0.0);
    assert_eq!(bench.bits("M1"), "EN DN IP AC TrackingMaster");
    jog(&mut bench, 50.0);
    while bench.position("A") < furthest {
        assert!((bench.position("X") - x).abs() < 0.5);
        bench.tick();
    }
    bench.run(5);
    assert!(cs1(&bench, coordinate_motion_status::COORDINATE_SYSTEM_LOCK_STATUS));
    bench.until("M1", Flag::Pc);
    assert!((bench.position("A") - 52.0).abs() < 0.06, "the phase is kept");
}

#[test]
fn links_show_ac_while_a_motion_uses_them() {
    let mut bench = Bench::new();
    assert_eq!(bench.call(&line("M1", 100.0, AT_ONCE)), (93, 0));
    assert_eq!(bench.call("MDCC(CS1, A, D1, Command, 0);"), OK);
    assert_eq!(bench.bits("D1"), "EN DN IP");
    jog(&mut bench, 50.0);
    assert_eq!(bench.call(&line("M1", 10.0, AT_ONCE)), OK);
    bench.tick();
    assert_eq!(bench.bits("D1"), "EN DN IP AC");
    // Renewed.
    assert_eq!(bench.call("MDCC(CS1, A, D2, Command, 0);"), OK);
    bench.tick();
    assert_eq!(
        (bench.bits("D1").as_str(), bench.bits("D2").as_str()),
        ("EN DN", "EN DN IP AC")
    );
    assert_eq!(
        bench.call("MDCC(CS1, A, D3, Actual, 0);"),
        (105, 0),
        "another reference under motion"
    );
    // To another master: it waits.
    assert_eq!(bench.call("MDCC(CS1, B, D3, Command, 0);"), OK);
    bench.tick();
    assert_eq!(
        (bench.bits("D2").as_str(), bench.bits("D3").as_str()),
        ("EN DN IP AC", "EN DN IP")
    );
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.bits("D2"), "EN DN IP");
    assert_eq!(bench.call(&line("M2", 20.0, AT_ONCE)), OK);
    bench.tick();
    assert_eq!(
        (bench.bits("D2").as_str(), bench.bits("D3").as_str()),
        ("EN DN", "EN DN IP AC")
    );
    bench.run(100);
    assert_eq!(bench.position("X"), 10.0, "B stands");
    // A time driven move does not use it.
    assert_eq!(
        bench.call("MCS(CS1, S2, CoordinatedMove, No, 0, Unitspersec2, No, 0, %ofTime);"),
        OK
    );
    bench.run(3);
    assert_eq!(
        (bench.bits("S2").as_str(), bench.bits("D3").as_str()),
        ("EN DN PC", "EN DN IP")
    );
    let timed = "MCLM(CS1, M3, Absolute, [20, 0, 0], 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);";
    assert_eq!(bench.call(timed), OK);
    bench.tick();
    assert_eq!(bench.bits("D3"), "EN DN IP");
}

#[test]
fn masters_that_cannot_be_are_refused() {
    #[rustfmt::skip]
    let cases = [
        // why,                       call,                                  status
        ("an axis of the slave",      "MDCC(CS1, X, D2, Command, 0);",       (10, 0)),
        ("no such reference",         "MDCC(CS1, A, D2, 2, 0);",             (13, 3)),
        ("a speed below zero",        "MDCC(CS1, A, D2, Command, -1);",      (13, 4)),
        ("the axis itself",           "MDAC(A, A, D2, All, Command);",       (10, 0)),
        ("no such motion type",       "MDAC(A, B, D2, 5, Command);",         (13, 3)),
        ("no such reference",         "MDAC(A, B, D2, All, 7);",             (13, 4)),
        ("a follower of the slave",   "MDCC(CS1, C, D2, Command, 0);",       (10, 0)),
        ("a master of its master",    "MDAC(B, C, D2, Move, Command);",      OK),
        ("a circle",                  "MDAC(C, B, D2, Move, Command);",      (10, 0)),
    ];
    let mut bench = Bench::new();
    let gear = "MAG(C, X, G1, Same, 1, 1, 1, Command, Real, Disabled, 100, Unitspersec2);";
    assert_eq!(bench.call(gear), OK);
    for (why, call, expected) in cases {
        assert_eq!(bench.call(call), expected, "{why}: {call}");
    }
}

#[test]
fn units_locks_and_modes_are_refused_in_their_order() {
    let timed = |more: &str| format!("MCLM(CS1, M1, Absolute, [9, 0, 0], 2, Unitspersec, 1, {more});");
    #[rustfmt::skip]
    let cases = [
        // why,                                    call,                                                            status
        ("master's rates at a speed in time",      timed("Unitspermasterunit2, 1, Unitspersec2"),                   (94, 0)),
        ("a lock of a time driven move",
            timed("Unitspersec2, 1, Unitspersec2, Trapezoidal, 100, 100, %ofTime, 1, Disabled, Programmed, 0, 0, 1"), (95, 0)),
        ("no lock of a master driven move",        line("M1", 9.0, "1, Disabled, Programmed, 0, 0, None, 0, 0"),    (95, 0)),
        ("no room for what is calculated",         line("M1", 9.0, "1, Disabled, Programmed, 0, 0, 1, [0, 1, 2, 3, 4], Data"), (101, 0)),
        ("nowhere to put it",                      line("M1", 9.0, "1, Disabled, Programmed, 0, 0, 1, [0], 0"),     (101, 0)),
        ("more room than needed",                  line("M1", 9.0, "1, Disabled, Programmed, 0, 0, 1, [0], Data"),  OK),
    ];
    for (why, call, expected) in cases {
        assert_eq!(linked().call(&call), expected, "{why}: {call}");
    }
}

#[test]
fn modes_change_at_rest_only() {
    const TIMED: &str = "100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, Trapezoidal, 100, 100, %ofTime";
    let timed = |tag: &str, x: f64, ending: u8| format!("MCLM(CS1, {tag}, Absolute, [{x}, 0, 0], {TIMED}, {ending});");
    let merged = |lock: &str| {
        line(
            "M2",
            90.0,
            &format!("1, CoordinatedMotion, Programmed, 0, 0, {lock}, 0, 0"),
        )
    };
    let moving = |speed: f64| {
        let mut bench = linked();
        if speed != 0.0 {
            jog(&mut bench, speed);
        }
        assert_eq!(bench.call(&timed("M1", 50.0, 1)), OK);
        bench.run(200);
        bench
    };
    #[rustfmt::skip]
    let cases = [
        // why,                                   speed,  lock,                   status
        ("the master stands",                     0.0,    "ImmediateForwardOnly", (97, 0)),
        ("the master goes the other way",         -50.0,  "ImmediateForwardOnly", (98, 0)),
        ("a lock that would have to be waited for", 50.0, "PositionForwardOnly",  (102, 0)),
        ("the master goes along",                 50.0,   "ImmediateForwardOnly", OK),
        ("too slow a master for what is left",    0.5,    "ImmediateForwardOnly", (103, 0)),
    ];
    for (why, speed, lock, expected) in cases {
        assert_eq!(moving(speed).call(&merged(lock)), expected, "{why}");
    }

    // A queued move of the other mode begins from rest, or fails when it is to begin.
    for (ending, second) in [(1, "EN DN PC"), (3, "EN DN ER")] {
        let mut bench = moving(50.0);
        let mut bench_call = |text: &str| bench.call(text);
        assert_eq!(bench_call(&timed("M2", 60.0, ending)), OK);
        while !bench.control("M2").has(Flag::Ac) {
            bench.tick();
        }
        assert_eq!(bench.call(&line("M3", 90.0, AT_ONCE)), OK);
        bench.until("M2", Flag::Pc);
        assert!(
            (bench.position("X") - 60.0).abs() < 0.2,
            "the first move goes to its end"
        );
        bench.run(800);
        assert_eq!(bench.bits("M3"), second);
        assert_eq!(bench.control("M3").err, if ending == 1 { 0 } else { 105 });
        assert_eq!(bench.position("X"), if ending == 1 { 90.0 } else { 60.0 });
    }
}

#[test]
fn a_merge_into_a_master_driven_move_keeps_the_speed() {
    let mut bench = linked();
    jog(&mut bench, 50.0);
    let timed = "MCLM(CS1, M1, Absolute, [500, 0, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, Trapezoidal, 100, 100, %ofTime, 1);";
    assert_eq!(bench.call(timed), OK);
    bench.run(300);
    let merge = "1, CoordinatedMotion, Programmed, 0, 0, ImmediateForwardOnly, 0, 0";
    assert_eq!(bench.call(&line("M2", 200.0, merge)), OK);
    let mut before = (bench.position("X"), bench.axis("X").command[1]);
    while !bench.control("M2").has(Flag::Pc) {
        bench.tick();
        let now = (bench.position("X"), bench.axis("X").command[1]);
        assert!(
            (now.1 - before.1).abs() < 3.0,
            "no step of speed: {} to {}",
            before.1,
            now.1
        );
        assert!(now.0 >= before.0);
        before = now;
    }
    assert_eq!(bench.position("X"), 200.0);
}

#[test]
fn a_stop_is_a_function_of_time() {
    for (stop, link) in [("CoordinatedMove", "EN DN IP"), ("All", "EN DN")] {
        let mut bench = linked();
        jog(&mut bench, 50.0);
        assert_eq!(
            bench.call(&line("M1", 400.0, "1, Disabled, Programmed, 0, 0, 1, [0], Data")),
            OK
        );
        bench.run(1000);
        assert!(bench.control("M1").has(Flag::CalculatedDataAvailable));
        let from = bench.position("X");
        let call = format!("MCS(CS1, S2, {stop}, Yes, 1000, Unitspersec2, No, 0, %ofTime);");
        assert_eq!(bench.call(&call), OK);
        assert_eq!(bench.bits("M1"), "EN DN", "{stop}");
        bench.until("S2", Flag::Pc);
        let way = bench.position("X") - from;
        assert!((way - 5.0).abs() < 0.1, "{stop}: {way}");
        assert_eq!(bench.bits("D1"), link, "{stop}");
        let at = bench.position("X");
        bench.run(100);
        assert_eq!(bench.position("X"), at);
    }
}
