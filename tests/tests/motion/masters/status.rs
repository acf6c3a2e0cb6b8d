//! TrackingMaster, CoordMotionLockStatus and the bits of links over sequences and changes
//! (spec/coordinated-instructions.md §8.3, §8.7, §8.8, §10.2, §18.2).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status::COORDINATE_SYSTEM_LOCK_STATUS;
use arcline_tests::bench::{Bench, OK};

/// The operands from Speed on: 2 units per master unit, 1 unit per master unit².
const DRIVEN: &str = "2, 4, 1, 4, 1, 4, 0, 100, 100, 6";

#[track_caller]
fn execute(bench: &mut Bench, call: &str) {
    assert_eq!(bench.call(call), OK, "{call}");
}

/// CS1 with room for four moves, linked to A.
fn linked() -> Bench {
    let deep = "command_tolerance = 0.5\nqueue_depth = 4";
    let mut bench = Bench::with(&arcline_config::DEFAULT.replace("command_tolerance = 0.5", deep));
    execute(&mut bench, "MDCC(CS1, A, D1, Command, 0);");
    bench
}

/// A goes on by a distance, and stands.
fn lead(bench: &mut Bench, by: f64) {
    execute(
        bench,
        &format!("MAM(A, Go, 1, {by}, 500, 0, 20000, 0, 20000, 0, 0, 100, 100, 2);"),
    );
    bench.until("Go", Flag::Pc);
    bench.tick();
}

fn line(tag: &str, x: f64, ending: u8, merge: u8, lock: &str) -> String {
    format!("MCLM(CS1, {tag}, 0, [{x}, 0, 0], {DRIVEN}, {ending}, {merge}, 0, 0, {lock}, 0, 0);")
}

fn locked(bench: &Bench) -> bool {
    bench.system("CS1").motion_status & COORDINATE_SYSTEM_LOCK_STATUS != 0
}

/// An action, and the state after it: the bits of both moves, and the lock.
type Step = (&'static str, Box<dyn Fn(&mut Bench)>, &'static str, &'static str, bool);

#[track_caller]
fn go_through(bench: &mut Bench, steps: &[Step]) {
    for (why, act, first, second, lock) in steps {
        act(bench);
        let bits = |tag: &str| bench.bits(tag).replace("EN DN", "").trim_start().to_owned();
        assert_eq!(
            (bits("M1").as_str(), bits("M2").as_str(), locked(bench)),
            (*first, *second, *lock),
            "{why}"
        );
    }
}

fn by(distance: f64) -> Box<dyn Fn(&mut Bench)> {
    Box::new(move |bench| lead(bench, distance))
}

fn call(text: String) -> Box<dyn Fn(&mut Bench)> {
    Box::new(move |bench| {
        execute(bench, &text);
        bench.tick();
    })
}

#[test]
fn tracking_is_of_the_instructions_own_ramps() {
    let change =
        |speed: f64| format!("MCCD(CS1, C, 1, Yes, {speed}, 4, No, 1, 4, No, 1, 4, No, 1, No, 1, 4, ActiveMotion);");
    #[rustfmt::skip]
    let steps: [Step; 18] = [
        // why,                                        action,                                       M1,                      M2,            lock
        ("at once: locked, and nothing has begun",   call(line("M1", 100.0, 4, 0, "0, 1")),      "IP AC",                 "",                      true),
        ("one that waits",                           call(line("M2", 200.0, 1, 0, "0, 1")),      "IP AC",                 "IP",                    true),
        ("its own ramp",                             by(1.0),                                    "IP AC ACCEL",           "IP",                    true),
        ("with its master",                          by(5.0),                                    "IP AC TrackingMaster",  "IP",                    true),
        ("another way",                              by(-3.0),                                   "IP AC TrackingMaster",  "IP",                    false),
        ("not yet where it turned",                  by(2.0),                                    "IP AC TrackingMaster",  "IP",                    false),
        ("on from there",                            by(3.0),                                    "IP AC TrackingMaster",  "IP",                    true),
        ("slower",                                   call(change(1.0)),                          "IP AC DECEL",           "IP",                    true),
        ("while its master stands",                  call("MAS(X, T, Jog, No, 0, 0, No, 0, 0);".into()), "IP AC DECEL",   "IP",                    true),
        ("slower by now",                            by(2.0),                                    "IP AC TrackingMaster",  "IP",                    true),
        ("a pause",                                  call(change(0.0)),                          "IP AC DECEL",           "IP",                    true),
        ("at rest",                                  by(3.0),                                    "IP AC",                 "IP",                    true),
        ("on again",                                 call(change(2.0)),                          "IP AC ACCEL",           "IP",                    true),
        ("with its master again",                    by(4.0),                                    "IP AC TrackingMaster",  "IP",                    true),
        // Straight on at the same speed.
        ("the next one at once",                     by(45.0),                                   "PC",                    "IP AC TrackingMaster",  true),
        ("its ramp to the end",                      by(43.5),                                   "PC",                    "IP AC DECEL",           true),
        ("the end",                                  by(3.0),                                    "PC",                    "PC",                    false),
        ("nothing follows",                          by(3.0),                                    "PC",                    "PC",                    false),
    ];
    go_through(&mut linked(), &steps);
}

#[test]
fn a_lock_is_shown_from_its_position_on() {
    #[rustfmt::skip]
    let steps: [Step; 9] = [
        // why,                          action,                                       M1,              M2,            lock
        ("it waits",                      call(line("M1", 100.0, 1, 0, "-5, 4")),          "IP AC",           "",               false),
        ("the other way",                 by(20.0),                                        "IP AC",           "",               false),
        ("not as far",                    by(-24.0),                                       "IP AC",           "",               false),
        ("over it",                       by(-2.0),                                        "IP AC ACCEL",     "",               true),
        ("back",                          by(1.5),                                         "IP AC ACCEL",     "",               false),
        ("a new one takes over",          call(line("M2", 50.0, 1, 1, "0, 2")),            "",                "IP AC",          true),
        ("which is locked where it is",   by(-0.5),                                        "",                "IP AC ACCEL",    true),
        ("a stop",                        call("MCS(CS1, S, CoordinatedMove, No, 0, 0, No, 0, 0);".into()), "", "",            false),
        ("nothing follows",               by(-10.0),                                       "",                "",               false),
    ];
    let mut bench = linked();
    go_through(&mut bench, &steps);
    assert_eq!(bench.bits("D1"), "EN DN IP");
}

#[test]
fn nothing_ends_a_move_that_waits_for_a_master_that_stands() {
    for lock in ["0, 1", "10, 3"] {
        let mut bench = linked();
        execute(&mut bench, &line("M1", 100.0, 1, 0, lock));
        bench.run(3);
        // The end of a simulation.
        bench.until_rest();
        assert_eq!(bench.bits("M1"), "EN DN IP AC");
        execute(
            &mut bench,
            "MAM(A, Go, 0, 20, 500, 0, 20000, 0, 20000, 0, 0, 100, 100, 2);",
        );
        bench.until_rest();
        assert!(
            (bench.position("A") - 20.0).abs() < 1e-9 && bench.position("X") > 10.0,
            "it is waited for its master"
        );
    }
}

#[test]
fn moves_behind_a_move_that_cannot_begin_are_cancelled() {
    for (ending, err) in [(1, 93), (3, 105)] {
        let mut bench = linked();
        let timed = |tag: &str, x: f64, ending: u8| {
            format!(
                "MCLM(CS1, {tag}, 0, [{x}, 0, 0], 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, {ending}, 0, 0, 0, 0, 0, 0, 0);"
            )
        };
        execute(&mut bench, &timed("M1", 20.0, ending));
        execute(&mut bench, &line("M2", 50.0, 1, 0, "0, 1"));
        execute(&mut bench, &timed("M3", 90.0, 1));
        if err == 93 {
            execute(&mut bench, "MASD(A, T);");
        }
        let mut before = 0.0;
        for _ in 0..800 {
            bench.tick();
            let now = bench.position("X");
            assert!((now - before).abs() < 0.11, "{err}: no jump from {before} to {now}");
            before = now;
        }
        assert_eq!(before, 20.0, "{err}");
        assert_eq!((bench.bits("M2").as_str(), bench.control("M2").err), ("EN DN ER", err));
        assert_eq!(
            (bench.bits("M1").as_str(), bench.bits("M3").as_str()),
            ("EN DN PC", "EN DN"),
            "{err}"
        );
    }
}

#[test]
fn a_link_that_waits_is_replaced_or_taken_up() {
    let mut bench = linked();
    let ip = |bench: &Bench| ["D1", "D2", "D3", "D4"].map(|tag| bench.control(tag).has(Flag::Ip));
    execute(&mut bench, "MDCC(CS1, B, D2, Command, 0);");
    assert_eq!(ip(&bench), [true, true, false, false], "the second waits");
    execute(&mut bench, "MDCC(CS1, C, D3, Command, 0);");
    assert_eq!(ip(&bench), [true, false, true, false], "a third takes its place");
    execute(&mut bench, "MDCC(CS1, A, D4, Command, 0);");
    assert_eq!(ip(&bench), [false, false, false, true], "the first is renewed");
    // With slave and master at rest, modes, masters and directions change freely.
    execute(&mut bench, &line("M1", 100.0, 1, 0, "0, 1"));
    lead(&mut bench, 10.0);
    execute(&mut bench, &line("M2", 200.0, 1, 1, "0, 2"));
    lead(&mut bench, -10.0);
    assert!(bench.position("X") > 20.0);
    let timed = "MCLM(CS1, M3, 0, [0, 0, 0], 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1, 1, 0, 0, 0, 0, 0, 0);";
    execute(&mut bench, timed);
    bench.until("M3", Flag::Pc);
    execute(&mut bench, &line("M1", 10.0, 1, 0, "0, 1"));
    assert_eq!(bench.bits("M1"), "EN DN IP AC");
    // While the master goes the other way they do not.
    execute(
        &mut bench,
        "MAJ(A, J, 0, 100, 0, 20000, 0, 20000, 0, 0, 100, 100, 2, Disabled, Programmed);",
    );
    bench.run(20);
    assert_eq!(bench.call(&line("M2", 0.0, 1, 1, "0, 2")), (98, 0));
}

#[test]
fn a_slave_in_motion_goes_over_to_another_master_without_a_step() {
    let mut bench = linked();
    // At 100 units/s behind A; 4 units per unit of B, which is half as fast, until it has slowed down to 2.
    for (master, speed) in [("A", 50), ("B", 25)] {
        execute(
            &mut bench,
            &format!(
                "MAJ({master}, J{master}, 0, {speed}, 0, 20000, 0, 20000, 0, 0, 100, 100, 2, Disabled, Programmed);"
            ),
        );
    }
    execute(&mut bench, &line("M1", 400.0, 1, 0, "0, 1"));
    bench.run(500);
    execute(&mut bench, "MDCC(CS1, B, D2, Command, 0);");
    bench.tick();
    assert_eq!(
        (bench.bits("D1").as_str(), bench.bits("D2").as_str()),
        ("EN DN IP AC", "EN DN IP")
    );
    execute(&mut bench, &line("M2", 400.0, 1, 1, "0, 1"));
    bench.tick();
    assert_eq!(
        (bench.bits("D1").as_str(), bench.bits("D2").as_str()),
        ("EN DN", "EN DN IP AC")
    );
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN", "EN DN IP AC DECEL")
    );
    let mut before = 100.0;
    while !bench.control("M2").has(Flag::TrackingMaster) {
        let [_, speed, _] = bench.axis("X").command;
        // 1 unit per master unit², at 25 master units/s: 0.625 units/s in an update.
        assert!(speed <= before + 1e-9 && before - speed < 0.7, "{before} to {speed}");
        before = speed;
        bench.tick();
    }
    assert!(
        (bench.axis("X").command[1] - 50.0).abs() < 1e-9,
        "as fast as the other master says"
    );
    bench.until("M2", Flag::Pc);
    assert_eq!(bench.position("X"), 400.0);
    assert_eq!(bench.bits("D2"), "EN DN IP");
}
