//! The causes of motion that ended before its end, and the messages of the command line for mistakes of a newcomer.

use std::time::Duration;

use arcline_system_tests::command_line::{Outcome, arcline, command, read_numbers};
use arcline_system_tests::eventually;
use arcline_system_tests::server::Server;

/// Runs a command in the background; its outcome when it has ended.
fn begin(at: std::net::SocketAddr, arguments: &[&str]) -> std::thread::JoinHandle<Outcome> {
    let mut command = command(at, arguments);
    std::thread::spawn(move || {
        let output = command.output().expect("it ends");
        Outcome {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    })
}

/// The last object that a failed command printed.
fn failed_with(ended: std::thread::JoinHandle<Outcome>) -> serde_json::Value {
    let mut objects = ended.join().expect("it ran").expect(1).objects();
    objects.pop().expect("one result")
}

fn moves(at: std::net::SocketAddr, axis: &str) {
    let speed = format!("{axis}.CommandVelocity");
    eventually("motion", Duration::from_secs(20), || {
        (read_numbers(at, &[&speed])[0].abs() > 1.0).then_some(())
    });
}

fn stands(at: std::net::SocketAddr, axis: &str) {
    let speed = format!("{axis}.CommandVelocity");
    eventually("rest", Duration::from_secs(20), || {
        (read_numbers(at, &[&speed])[0] == 0.0).then_some(())
    });
}

const ENDLESS: &str = "MCLM(CS1, Down, 0, [100000, 0, 0], 100, 0, 2000, 0, 2000, 0, 0, 0, 0, 0);\n";

#[test]
fn a_motion_command_prints_the_cause_of_its_end() {
    let server = Server::start();
    let at = server.address();
    let moving = ["move", "CS1", "100000,0,0", "--speed", "100", "--tag", "Long"];
    let ended = begin(at, &moving);
    moves(at, "X");
    let _ = arcline(at, &["exec", "MCS(CS1, Halt, All)"]).expect(0);
    let told = ended.join().expect("it ran").expect(1).stderr;
    assert!(told.contains("without PC: stopped by MCS Halt"), "{told}");

    let ended = begin(at, &moving);
    moves(at, "X");
    let merged =
        "MCLM(CS1, Other, 0, [100000, 10, 0], 100, 0, 2000, 0, 2000, 0, 0, 0, 0, 0, 0, Coordinated Motion, Programmed)";
    let _ = arcline(at, &["exec", "--no-wait", merged]).expect(0);
    let told = ended.join().expect("it ran").expect(1).stderr;
    assert!(told.contains("superseded by MCLM Other"), "{told}");
    let _ = arcline(at, &["stop"]).expect(0);

    let ended = begin(at, &["--json", moving[0], moving[1], moving[2], moving[3], moving[4]]);
    moves(at, "X");
    let _ = arcline(at, &["fault", "inject", "X", "overcurrent"]).expect(0);
    let object = failed_with(ended);
    let text = object["error"].as_str().unwrap_or_default();
    assert!(
        text.contains("stopped by a fault: X overcurrent, at ") && text.contains(" s of machine time"),
        "{text}"
    );
    assert_eq!(
        (&object["ended"]["axis"], &object["ended"]["faults"][0]),
        (&"X".into(), &"overcurrent".into()),
        "{object}"
    );
    assert!(
        object["ended"]["unix_s"].as_f64().is_some_and(|at| at > 1.7e9),
        "{object}"
    );
}

#[test]
fn a_jog_prints_the_cause_of_its_stop() {
    let server = Server::start();
    let at = server.address();
    let ended = begin(at, &["jog", "S", "50"]);
    moves(at, "S");
    let _ = arcline(at, &["exec", "MAS(S, Halt, Jog)"]).expect(0);
    let told = ended.join().expect("it ran").expect(0).stdout;
    assert_eq!(told, "MAJ S: stopped by MAS Halt\n");
    let clear = || {
        let _ = arcline(at, &["fault", "clear", "S"]).expect(0);
        let _ = arcline(at, &["servo", "on", "S"]).expect(0);
    };
    let ended = begin(at, &["jog", "S", "50"]);
    moves(at, "S");
    let _ = arcline(at, &["fault", "inject", "S", "overcurrent"]).expect(0);
    let failed = ended.join().expect("it ran").expect(1);
    assert!(
        failed
            .stderr
            .starts_with("MAJ S: stopped by a fault: S overcurrent, at ")
            && failed.stdout.is_empty(),
        "{failed:?}"
    );
    clear();
    let ended = begin(at, &["--json", "jog", "S", "50"]);
    moves(at, "S");
    let _ = arcline(at, &["fault", "inject", "S", "overcurrent"]).expect(0);
    let object = failed_with(ended);
    assert_eq!(
        (&object["ended"]["by"], &object["ended"]["faults"][0]),
        (&"fault".into(), &"overcurrent".into()),
        "{object}"
    );
    // The kind of the fault is in the status too.
    let told = arcline(at, &["status", "S"]).expect(0).stdout;
    assert!(told.contains("fault: overcurrent"), "{told}");
    let object = arcline(at, &["--json", "status", "S"]).expect(0).objects().remove(0);
    assert_eq!(object["fault_kinds"], serde_json::json!(["overcurrent"]), "{object}");
}

/// The share of the way, the distance to go and the time left of the active move, its deceleration included.
#[test]
fn status_shows_how_far_the_active_move_is() {
    let server = Server::start();
    let at = server.address();
    let active = || {
        let object = arcline(at, &["--json", "status", "CS1"]).expect(0).objects().remove(0);
        object["active_move"].clone()
    };
    assert!(active().is_null(), "nothing moves");
    // 100 s at 10 units/s, and half a ramp of 1 s each.
    let slow = "MCLM(CS1, Slow, 0, [1000, 0, 0], 10, 0, 10, 0, 10, 0, 0, 0, 0, 0)";
    let _ = arcline(at, &["exec", "--no-wait", slow]).expect(0);
    moves(at, "X");
    let shown = active();
    let number = |member: &str| shown[member].as_f64().unwrap_or_else(|| panic!("{member}: {shown}"));
    let (share, remaining, left) = (number("share"), number("remaining"), number("time_left_s"));
    assert_eq!(number("length"), 1000.0);
    assert!((share - (1.0 - remaining / 1000.0)).abs() < 1e-9, "{shown}");
    assert!(share > 0.0 && share < 0.5, "{shown}");
    // At full speed: the way at that speed, and 0.5 s longer for the ramp down.
    if remaining < 990.0 {
        assert!((left - (remaining / 10.0 + 0.5)).abs() < 0.01, "{shown}");
    }
    let text = arcline(at, &["status", "CS1"]).expect(0).stdout;
    assert!(text.contains(" to go, ") && text.contains(" s left"), "{text}");
    // A hold: how long is not known.
    let _ = arcline(at, &["hold", "CS1"]).expect(0);
    stands(at, "X");
    let held = active();
    assert!(
        held["time_left_s"].is_null() && held["remaining"].as_f64().is_some(),
        "{held}"
    );
    let _ = arcline(at, &["stop"]).expect(0);
    assert!(active().is_null(), "it was stopped");
}

#[test]
fn a_program_whose_wait_cannot_come_true_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("wait.st");
    std::fs::write(&file, format!("{ENDLESS}WAIT(Down.PC);\n")).expect("the folder is writable");
    let file = file.to_str().expect("UTF-8");
    let server = Server::start();
    let at = server.address();
    let ended = begin(at, &["run", file]);
    moves(at, "X");
    let _ = arcline(at, &["stop"]).expect(0);
    let told = ended.join().expect("it ran").expect(1).stderr;
    assert_eq!(
        told,
        "line 2: WAIT can no longer come true: Down (MCLM, line 1) was stopped by MCS\n"
    );
    // A fault ends a program that only waits for the end of its motion.
    std::fs::write(file, ENDLESS).expect("the folder is writable");
    let ended = begin(at, &["run", file]);
    moves(at, "X");
    let _ = arcline(at, &["fault", "inject", "X", "overcurrent"]).expect(0);
    let told = ended.join().expect("it ran").expect(1).stderr;
    assert!(
        told.contains("line 1: ") && told.contains("stopped by a fault: X overcurrent"),
        "{told}"
    );
}

#[test]
fn stop_stops_axes_and_everything() {
    let server = Server::start();
    let at = server.address();
    let _ = arcline(at, &["jog", "S", "50", "--no-wait"]).expect(0);
    moves(at, "S");
    let told = arcline(at, &["stop", "s"]).expect(0).stdout;
    assert!(told.starts_with("MAS S: ") && told.contains("PC"), "{told}");
    stands(at, "S");
    // B is virtual; X is part of CS1, and both of them jog.
    for axis in ["B", "X"] {
        let _ = arcline(at, &["jog", axis, "50", "--no-wait"]).expect(0);
    }
    let _ = arcline(at, &["move", "CS1", "0,100000,0", "--speed", "100", "--no-wait"]).expect(0);
    for axis in ["B", "X", "Y"] {
        moves(at, axis);
    }
    let _ = arcline(at, &["stop"]).expect(0);
    for axis in ["B", "X", "Y"] {
        assert_eq!(
            read_numbers(at, &[&format!("{axis}.CommandVelocity")])[0],
            0.0,
            "{axis}"
        );
    }
}

#[test]
fn mistakes_are_told_in_words() {
    let server = Server::start();
    let at = server.address();
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (mcap, part) = (path("t.mcap"), path("part.ngc"));
    std::fs::write(&mcap, [0x89, b'M', b'C', b'A', b'P', 0xFF]).expect("the folder is writable");
    std::fs::write(&part, "G0 X1\n").expect("the folder is writable");
    let svg = path("t.svg");
    let _ = arcline(at, &["tags", "create", "Parts", "DINT"]).expect(0);
    #[rustfmt::skip]
    let cases: &[(&str, &[&str], i32, &str)] = &[
        ("a move of an axis",          &["move", "X", "100"],             2, "X is an axis, MCLM acts on a coordinate system: `arcline move-axis X POSITION` moves it"),
        ("an axis too many",           &["move", "CS1", "1,2,3,4"],       2, "CS1 has 3 axes (X, Y, Z), 4 were given"),
        ("too many in an arc",         &["arc", "XY", "1,2,3", "--center", "0,0"], 2, "XY has 2 axes (X, Y), 3 were given"),
        ("an axis too few",            &["move", "CS1", "1,2"],           1, "operand 3 (Position): CS1 has 3 axes (X, Y, Z), 2 were given"),
        ("operands left out",          &["exec", "MAJ(X, J, Forward, 20)"], 1, "operand 5 (Accel Rate): Accel Rate was not given"),
        ("a fraction for a DINT",      &["write", "Parts", "3.5"],        2, "Parts is DINT, 3.5 does not fit"),
        ("a type that is none",        &["tags", "create", "Foo", "FOO"], 2, "\"FOO\" cannot be its type; types are BOOL"),
        ("a motion control tag",       &["tags", "create", "M", "MOTION_INSTRUCTION"], 2, "made by the first instruction that names it"),
        ("a servo of a system",        &["servo", "on", "CS1"],           2, "CS1 is a coordinate system, MSO acts on an axis"),
        ("a name that is none",        &["tags", "create", "bad name", "DINT"], 2, "\"bad name\" cannot be the name of a tag: a name has 1 to 40"),
        ("an array of none",           &["tags", "create", "M", "DINT[0]"], 2, "\"DINT[0]\" cannot be its type: an array has one to three dimensions"),
        ("a trace that is no CSV",     &["plot", &mcap, "-o", &svg],      2, "plot reads traces in CSV only"),
        ("an axis to explain",         &["explain", "X"],                 2, "expected a tag of an instruction; `arcline fault list`"),
        ("a machine that is not told", &["gcode", &part, "Gantry", "--simulate"], 2, "--config FILE simulates another one"),
        ("a margin at no speed",       &["margin", "5", "--master-speed", "inf"], 2, "\"inf\" is no speed, expected a number such as 500"),
        ("too long an array",          &["read", "Move1.Position{10}"],   2, "an array of 9"),
    ];
    for (why, arguments, code, message) in cases {
        let refused = arcline(at, arguments).expect(*code);
        assert!(refused.stderr.contains(message), "{why}: {refused:?}");
        assert!(!refused.stderr.contains("CIP status"), "{why}: {refused:?}");
    }
    // The number stands behind the words, for a look into the pages of CIP.
    #[rustfmt::skip]
    let refused: &[(&str, &[&str], &str)] = &[
        ("a read-only tag",   &["write", "X.ActualPosition", "1"],    "X.ActualPosition: clients may not change it, or not with the role of this connection (CIP status 0x0F)\n"),
        ("a name that is",    &["tags", "create", "Move1", "DINT"],   "Move1: it exists already (CIP status 0x0D): choose another name, or delete that tag first\n"),
        ("a tag of an axis",  &["tags", "delete", "X"],               "X: clients may not change it, or not with the role of this connection (CIP status 0x0F): only plain tags can be deleted\n"),
    ];
    for (why, arguments, message) in refused {
        assert_eq!(arcline(at, arguments).expect(1).stderr, *message, "{why}");
    }
    assert_eq!(read_numbers(at, &["Parts"])[0], 0.0, "nothing was written");
    // Everything stops, though the coordinate systems of X cannot move.
    let _ = arcline(at, &["servo", "off", "X"]).expect(0);
    let _ = arcline(at, &["stop"]).expect(0);
    let refused = arcline(at, &["stop", "CS1"]).expect(1);
    assert!(refused.stderr.contains("ERR 5 "), "{refused:?}");
    let _ = arcline(at, &["servo", "on", "X"]).expect(0);
    let _ = arcline(at, &["write", "Parts", "3.0"]).expect(0);
    assert_eq!(read_numbers(at, &["Parts"])[0], 3.0);
    assert_eq!(
        arcline(at, &["read", "Move1.Position{3}"]).expect(0).stdout,
        "[0, 0, 0]\n"
    );
    let told = arcline(at, &["explain", "13"]).expect(0).stdout;
    assert!(told.starts_with("ERR 13 Parameter Out Of Range\n"), "{told}");
    assert!(told.contains("arcline explain 13/EXERR"), "{told}");
    // An axis and a signal of it are one column.
    let csv = path("t.csv");
    let _ = arcline(at, &["trace", "X", "X.CommandVelocity", "--for", "0.01", "-o", &csv]).expect(0);
    let text = std::fs::read_to_string(&csv).expect("it was written");
    let header = text.lines().next().unwrap_or_default();
    assert_eq!(header.matches("X.CommandVelocity").count(), 1, "{header}");
}
