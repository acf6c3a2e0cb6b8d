//! Commands of `arcline` against a real `arcline-server`: every one, and its messages for mistakes.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use arcline_system_tests::command_line::{arcline, command, read_numbers};
use arcline_system_tests::server::{Server, signal};
use arcline_system_tests::{eventually, fixture};

/// The examples of the seeds, letter by letter.
const SEED_MCCM: &str = "MCCM(myMccmCoordinateSystem, myMccmMotionControl, myMccmMoveType, myMccmPosition[0], \
    myMccmCircleType, myMccmRadius[0], myMccmDirection, myMccmSpeed, Unitspersec, myMccmAccelRate, Unitspersec2, \
    myMccmDecelRate, Unitspersec2, Trapezoidal, 100.0, 100.0, %ofTime, myMccmTermType, CoordinatedMotion, Programmed, \
    0, 0, None, 0, 0);";
const SEED_MCCD: &str = "MCCD(myMccdCoordinateSystem, myMccdMotionControl, CoordinatedMove, Yes, MyMccdSpeed, \
    Unitspersec, Yes, MyMsccdAccelRate, Unitspersec2, Yes, MyMccdDecelRate, Unitspersec2, Yes, 100.0, Yes, 100.0, \
    %ofTime, ActiveMotion);";
const SEED_MCS: &str =
    "MCS (myMcsCoordinateSystem, myMcsMotionControl, All, Yes, myMcsDecelRate, Unitspersec2, Yes, 100.0, % of Time);";

const AXES: [&str; 2] = ["Axis0.CommandPosition", "Axis1.CommandPosition"];

fn path_speed(server: &Server) -> f64 {
    let velocities = read_numbers(server.address(), &["Axis0.CommandVelocity", "Axis1.CommandVelocity"]);
    velocities[0].hypot(velocities[1])
}

#[test]
fn the_lines_of_the_seeds_run_as_they_stand() {
    let server = Server::start_on(&fixture("config/seeds.toml"));
    let at = server.address();
    for (tag, value) in [
        ("myMccmPosition[0]", "100.0"),
        ("myMccmCircleType", "2"),
        ("myMccmRadius[0]", "60.0"),
        ("myMccmDirection", "0"),
        ("myMccmSpeed", "200.0"),
        ("myMccmAccelRate", "2000.0"),
        ("myMccmDecelRate", "2000.0"),
        ("myMccmTermType", "1"),
        ("MyMccdSpeed", "40.0"),
        ("MyMsccdAccelRate", "1500.0"),
        ("MyMccdDecelRate", "1500.0"),
        ("myMcsDecelRate", "1000.0"),
    ] {
        let _ = arcline(at, &["write", tag, value]).expect(0);
    }

    // An arc of radius 60 from 0, 0 to 100, 0.
    let _ = arcline(at, &["exec", SEED_MCCM]).expect(0);
    assert_eq!(read_numbers(at, &AXES), [100.0, 0.0], "end of the seed's arc");
    let control = ["myMccmMotionControl.PC", "myMccmMotionControl.ERR"];
    let shown = arcline(at, &["--json", "read", control[0], control[1]])
        .expect(0)
        .objects();
    assert_eq!(
        (&shown[0]["value"], &shown[1]["value"]),
        (&true.into(), &0.into()),
        "{shown:?}"
    );

    // A long line at 300, changed to 40 on the way.
    let _ = arcline(
        at,
        &["move", "myMccdCoordinateSystem", "900,0", "--speed", "300", "--no-wait"],
    )
    .expect(0);
    eventually("full speed", Duration::from_secs(20), || {
        (path_speed(&server) > 299.0).then_some(())
    });
    let _ = arcline(at, &["exec", SEED_MCCD]).expect(0);
    eventually("the seed's new speed", Duration::from_secs(20), || {
        ((path_speed(&server) - 40.0).abs() < 1e-3).then_some(())
    });
    let _ = arcline(at, &["stop", "myMccdCoordinateSystem"]).expect(0);
    assert_eq!(path_speed(&server), 0.0, "after a stop");

    // A line stopped on its way.
    let before = read_numbers(at, &AXES)[0];
    let _ = arcline(
        at,
        &["move", "myMcsCoordinateSystem", "5000,0", "--speed", "200", "--no-wait"],
    )
    .expect(0);
    eventually("the move is under way", Duration::from_secs(20), || {
        (path_speed(&server) > 199.0).then_some(())
    });
    let _ = arcline(at, &["exec", SEED_MCS]).expect(0);
    assert_eq!(path_speed(&server), 0.0, "after the seed's stop");
    let after = read_numbers(at, &AXES)[0];
    assert!(
        before < after && after < 5000.0,
        "stopped between {before} and 5000: {after}"
    );
    assert_eq!(read_numbers(at, &AXES)[0], after, "and stays there");
}

#[test]
fn a_move_to_its_end() {
    let server = Server::start();
    let at = server.address();
    let moved = arcline(at, &["--json", "move", "CS1", "30,20,10", "--tag", "First"]).expect(0);
    let object = moved.objects().pop().expect("one object for the move");
    for key in ["instruction", "target", "tag", "instance", "status", "ERR", "EXERR"] {
        assert!(object.get(key).is_some(), "{key} in {object}");
    }
    assert_eq!(
        (&object["instruction"], &object["target"], &object["ERR"]),
        (&"MCLM".into(), &"CS1".into(), &0.into())
    );
    assert!(
        object["status"]
            .as_array()
            .is_some_and(|bits| bits.contains(&"PC".into())),
        "{object}"
    );
    let tags = ["X.CommandPosition", "Y.CommandPosition", "Z.CommandPosition"];
    assert_eq!(read_numbers(at, &tags), [30.0, 20.0, 10.0]);
    let _ = arcline(at, &["move", "CS1", "-5,0,0", "--relative", "--trapezoid"]).expect(0);
    assert_eq!(read_numbers(at, &tags), [25.0, 20.0, 10.0]);
    let _ = arcline(at, &["arc", "XY", "25,40", "--center", "25,30", "--cw"]).expect(0);
    assert_eq!(read_numbers(at, &tags), [25.0, 40.0, 10.0]);
    for why in ["a tag's first use", "its second use, with EN still set"] {
        let again = arcline(at, &["--json", "move", "CS1", "5,0,0", "--relative", "--tag", "Again"]).expect(0);
        let status = &again.objects()[0]["status"];
        assert_eq!(*status, serde_json::json!(["EN", "DN", "PC"]), "{why}");
    }
    let _ = arcline(at, &["move", "CS1", "25,40,10"]).expect(0);
    let text = arcline(at, &["status"]).expect(0).stdout;
    assert!(text.contains("CS1") && text.contains("25.000"), "{text}");
}

#[test]
fn exit_codes_and_messages() {
    let server = Server::start();
    let at = server.address();
    let refused = "MCLM(CS1, M1, Absolute, [10, 0, 0], -5, Unitspersec)";
    #[rustfmt::skip]
    let cases: &[(&str, &[&str], i32, &str)] = &[
        // why,                          arguments,                                     code, on standard error
        ("a refused operand",            &["exec", refused],                            1, "ERR 13 Parameter Out Of Range, operand 4 (Speed)"),
        ("no such command",              &["dance"],                                    2, "dance"),
        ("a text that does not parse",   &["exec", "MCLM(CS1, "],                       2, "expected"),
        ("a word that is none",          &["exec", "MCLM(CS1, M1, Sideways, [1, 2, 3], 5)"], 2, "Sideways"),
        ("no such tag",                  &["read", "NoSuchTag"],                        2, "NoSuchTag"),
        ("a read-only tag",              &["write", "X.CommandPosition", "5.0"],        1, "X.CommandPosition"),
        ("a tag",                        &["read", "X.CommandPosition"],                0, ""),
        ("an integer into a REAL",       &["write", "Move1.Speed", "50"],               0, ""),
    ];
    for (why, arguments, code, message) in cases {
        let outcome = arcline(at, arguments);
        assert_eq!(outcome.code, Some(*code), "{why}: {outcome:?}");
        assert!(outcome.stderr.contains(message), "{why}: {outcome:?}");
        assert!(*code != 0 || outcome.stderr.is_empty(), "{why}: {outcome:?}");
    }
    assert_eq!(read_numbers(at, &["X.CommandPosition"]), [0.0], "nothing moved");
    let object = arcline(at, &["--json", "exec", refused])
        .expect(1)
        .objects()
        .pop()
        .expect("one object");
    assert_eq!((&object["ERR"], &object["EXERR"]), (&13.into(), &4.into()), "{object}");

    // A port without a listener: it was free a moment ago.
    let nobody = TcpListener::bind("127.0.0.1:0")
        .and_then(|listener| listener.local_addr())
        .expect("a free port");
    let _ = arcline(nobody, &["status"]).expect(3);
}

#[test]
fn control_c_stops_the_motion_of_the_command() {
    let server = Server::start();
    let at = server.address();
    let mut waiting = command(at, &["move", "CS1", "100000,0,0", "--speed", "100"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command line was just built");
    let speed = || read_numbers(at, &["X.CommandVelocity"])[0];
    eventually("the move is under way", Duration::from_secs(20), || {
        (speed() > 99.0).then_some(())
    });
    signal("INT", waiting.id());
    let ended = eventually("the end of the command", Duration::from_secs(20), || {
        waiting.try_wait().ok().flatten()
    });
    assert!(!ended.success(), "{ended:?}");
    assert_eq!(speed(), 0.0, "the move has been stopped");
    let output = waiting.wait_with_output().expect("it has ended");
    assert!(
        String::from_utf8_lossy(&output.stdout).contains("stopped"),
        "{output:?}"
    );
}

#[test]
fn single_axes_move_and_jog() {
    let server = Server::start();
    let at = server.address();
    let position = || read_numbers(at, &["X.CommandPosition"])[0];
    let speed = || read_numbers(at, &["X.CommandVelocity"])[0];
    let moved = arcline(at, &["--json", "move-axis", "X", "12.5", "--speed", "50%"]).expect(0);
    assert_eq!(moved.objects()[0]["instruction"], "MAM", "{moved:?}");
    assert_eq!(position(), 12.5);
    let _ = arcline(at, &["move-axis", "X", "-2.5", "--relative", "--trapezoid"]).expect(0);
    assert_eq!(position(), 10.0);
    let refused = arcline(at, &["move-axis", "X", "5", "--shortest"]).expect(1);
    assert!(refused.stderr.contains("ERR 17 Axis Mode Not Rotary"), "{refused:?}");

    // A jog is waited for until Ctrl-C, the end of the terminal or SIGTERM; then it is stopped, and nothing else.
    for end in ["INT", "HUP", "TERM"] {
        let mut waiting = command(at, &["jog", "X", "-40"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command line was just built");
        eventually("the jog", Duration::from_secs(20), || {
            ((speed() + 40.0).abs() < 1e-3).then_some(())
        });
        signal(end, waiting.id());
        let ended = eventually("the end of the command", Duration::from_secs(20), || {
            waiting.try_wait().ok().flatten()
        });
        assert_eq!(ended.code(), Some(130), "{end}: {ended:?}");
        assert_eq!(speed(), 0.0, "the jog has been stopped");
        let output = waiting.wait_with_output().expect("it has ended");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains("interrupted: X is stopped"), "{end}: {text}");
    }

    // A jog that another client stops ends well.
    let waiting = command(at, &["jog", "X", "5%"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the command line was just built");
    eventually("the jog", Duration::from_secs(20), || (speed() > 49.0).then_some(()));
    let _ = arcline(at, &["exec", "MAS(X, S1, Jog)"]).expect(0);
    let output = waiting.wait_with_output().expect("it ends");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success() && text.contains("MAJ X: stopped by MAS S1"),
        "{text}"
    );
    let started = arcline(at, &["jog", "X", "5", "--no-wait"]).expect(0);
    assert!(started.stdout.contains("IP"), "{started:?}");
}

/// As for a user: the key makes the signal, and the progress gives way to the result on the terminal.
#[test]
fn control_c_at_a_terminal() {
    /// Runs a program on a terminal of its own, between its own input and output; needs Python 3.9.
    const ON_A_TERMINAL: &str = "import os, pty, sys; sys.exit(os.waitstatus_to_exitcode(pty.spawn(sys.argv[1:])))";
    let server = Server::start();
    let at = server.address();
    let shown = command(at, &["move", "CS1", "100000,0,0", "--speed", "100"]);
    let mut waiting = Command::new("python3")
        .args(["-c", ON_A_TERMINAL])
        .arg(shown.get_program())
        .args(shown.get_args())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python3 is there, as other tests need it");
    let (mut keys, mut screen) = waiting.stdin.take().zip(waiting.stdout.take()).expect("both are piped");
    let text = Arc::new(Mutex::new(Vec::new()));
    let seen = Arc::clone(&text);
    let reader = std::thread::spawn(move || {
        let mut bytes = [0; 4096];
        while let Ok(length @ 1..) = screen.read(&mut bytes) {
            seen.lock()
                .expect("nobody panics with it")
                .extend_from_slice(&bytes[..length]);
        }
    });
    let text = || String::from_utf8_lossy(&text.lock().expect("nobody panics with it")).into_owned();
    eventually("the progress", Duration::from_secs(20), || {
        text().contains("of 100000.0").then_some(())
    });
    keys.write_all(b"\x03").expect("the terminal is open");
    let ended = eventually("the end of the command", Duration::from_secs(20), || {
        waiting.try_wait().ok().flatten()
    });
    reader.join().expect("it only reads");
    assert_eq!(ended.code(), Some(130), "{}", text());
    assert!(
        text().ends_with("\r\u{1b}[2Kinterrupted: CS1 is stopped\r\n"),
        "{:?}",
        text()
    );
    assert_eq!(read_numbers(at, &["X.CommandVelocity"]), [0.0]);
}

#[test]
fn stop_and_change_on_the_way() {
    let server = Server::start();
    let at = server.address();
    let speed = || read_numbers(at, &["X.CommandVelocity"])[0];
    let _ = arcline(at, &["move", "CS1", "100000,0,0", "--speed", "100", "--no-wait"]).expect(0);
    eventually("speed 100", Duration::from_secs(20), || {
        ((speed() - 100.0).abs() < 1e-3).then_some(())
    });
    let _ = arcline(at, &["change", "CS1", "--speed", "20"]).expect(0);
    eventually("speed 20", Duration::from_secs(20), || {
        ((speed() - 20.0).abs() < 1e-3).then_some(())
    });
    let _ = arcline(at, &["stop"]).expect(0);
    assert_eq!(speed(), 0.0);
}

#[test]
fn a_stop_that_holds_lasts_until_its_release() {
    let server = Server::start();
    let at = server.address();
    let speed = || read_numbers(at, &["X.CommandVelocity"])[0];
    let inhibited = || arcline(at, &["--json", "status", "Motion"]).expect(0).objects()[0]["motion_inhibited"].clone();
    assert_eq!(inhibited(), false);
    let _ = arcline(at, &["move", "CS1", "100000,0,0", "--speed", "100", "--no-wait"]).expect(0);
    eventually("motion", Duration::from_secs(20), || (speed() > 1.0).then_some(()));
    let _ = arcline(at, &["stop", "--hold"]).expect(0);
    eventually("rest", Duration::from_secs(20), || (speed() == 0.0).then_some(()));
    assert_eq!(inhibited(), true);
    let refused = arcline(at, &["move", "CS1", "10,0,0"]).expect(1);
    assert!(refused.stderr.contains("ERR 53"), "{}", refused.stderr);
    // A stop without --hold is another command; it inhibits and releases nothing.
    let _ = arcline(at, &["stop"]).expect(0);
    assert_eq!(inhibited(), true);
    let _ = arcline(at, &["release"]).expect(0);
    assert_eq!(inhibited(), false);
    let _ = arcline(at, &["move", "CS1", "10,0,0", "--relative"]).expect(0);
    let _ = arcline(at, &["stop", "X", "--hold"]).expect(2);
}

#[test]
fn servers_end_in_a_controlled_way() {
    let server = Server::start();
    let _ = arcline(
        server.address(),
        &["move", "CS1", "100000,0,0", "--speed", "100", "--no-wait"],
    )
    .expect(0);
    let (status, log) = server.terminate();
    assert!(status.success(), "{status:?}: {log}");
}

#[test]
fn override_hold_and_resume() {
    let server = Server::start();
    let at = server.address();
    let speed = || read_numbers(at, &["X.CommandVelocity"])[0];
    let reaches = |wanted: f64| {
        eventually(&format!("speed {wanted}"), Duration::from_secs(20), || {
            ((speed() - wanted).abs() < 1e-3).then_some(())
        });
    };
    let shown = || arcline(at, &["--json", "status", "CS1"]).expect(0).objects()[0]["override"].clone();
    assert_eq!(shown(), 100.0);
    let _ = arcline(at, &["move", "CS1", "100000,0,0", "--speed", "100", "--no-wait"]).expect(0);
    reaches(100.0);
    assert_eq!(
        arcline(at, &["override", "CS1", "50%"]).expect(0).stdout,
        "CS1 at 50% of the programmed speed\n"
    );
    reaches(50.0);
    assert_eq!(arcline(at, &["hold", "cs1"]).expect(0).stdout, "cs1 held\n");
    reaches(0.0);
    let status = arcline(at, &["status", "CS1"]).expect(0).stdout;
    assert!(status.contains("moving, held"), "{status}");
    let resumed = arcline(at, &["--json", "resume", "CS1"]).expect(0).objects();
    assert_eq!(resumed[0]["override"], 50.0, "as before the hold");
    reaches(50.0);
    assert!(
        arcline(at, &["status", "CS1"])
            .expect(0)
            .stdout
            .contains("override 50%"),
        "what is not as programmed is shown"
    );
    for (arguments, message) in [
        (&["override", "CS1", "201"], "from 0 to 200"),
        (&["override", "CS1", "-1"], "from 0 to 200"),
        (&["override", "CS7", "50"], "CS7"),
    ] {
        let refused = arcline(at, arguments);
        assert_eq!(refused.code, Some(2), "{refused:?}");
        assert!(refused.stderr.contains(message), "{refused:?}");
    }
    let _ = arcline(at, &["stop"]).expect(0);
    assert_eq!(shown(), 50.0, "kept until it is changed");
}

#[test]
fn axes_are_homed() {
    let server = Server::start_on(&fixture("config/home.toml"));
    let at = server.address();
    let homed = |axis: &str| {
        let read = arcline(at, &["--json", "read", &format!("{axis}.AxisHomedStatus")]).expect(0);
        read.objects()[0]["value"] == true
    };
    assert_eq!((homed("P"), homed("Q")), (false, false));
    let home = arcline(at, &["--json", "home", "P", "Q"]).expect(0).objects();
    for (object, axis) in home.iter().zip(["P", "Q"]) {
        assert_eq!(
            (&object["instruction"], &object["target"]),
            (&"MAH".into(), &axis.into())
        );
        assert_eq!(object["status"], serde_json::json!(["EN", "DN", "PC"]), "{axis}");
    }
    assert_eq!((homed("P"), homed("Q")), (true, true));
    assert_eq!(
        read_numbers(at, &["P.CommandPosition", "Q.CommandPosition"]),
        [5.0, 0.0]
    );

    let refused = arcline(at, &["home", "N"]).expect(1);
    assert!(
        refused.stderr.contains("ERR 84 Drive Digital Input Not Assigned"),
        "{refused:?}"
    );
    let _ = arcline(at, &["home"]).expect(2);

    // No client moves R: its homing lasts until Ctrl-C ends it.
    let homing = || arcline(at, &["--json", "read", "R.HomingStatus"]).expect(0).objects()[0]["value"].clone();
    let mut waiting = command(at, &["home", "R"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the command line was just built");
    eventually("homing is under way", Duration::from_secs(20), || {
        (homing() == true).then_some(())
    });
    signal("INT", waiting.id());
    let ended = eventually("the end of the command", Duration::from_secs(20), || {
        waiting.try_wait().ok().flatten()
    });
    assert_eq!(ended.code(), Some(130));
    assert_eq!((homing(), homed("R")), (false.into(), false));
    let _ = arcline(at, &["home", "R", "--no-wait"]).expect(0);
    assert_eq!(homing(), true);
}

#[test]
fn the_safety_margin_of_a_sequence_is_told_without_a_server() {
    let nobody = "127.0.0.1:1".parse().expect("an address");
    let five = ["margin", "5", "--master-speed", "500", "--update-period", "2"];
    #[rustfmt::skip]
    let cases = [
        // more,                                    margin (spec/coordinated-instructions.md §8.10, §27.8)
        (&[][..],                                   "0.1 master units\n"),
        (&["--first-is-full"],                      "1.08 master units\n"),
        (&["--first-is-full", "--last-is-full"],    "2.06 master units\n"),
    ];
    for (more, margin) in cases {
        let told = arcline(nobody, &[&five[..], more].concat()).expect(0).stdout;
        assert_eq!(told, margin, "{more:?}");
    }
    let object = arcline(nobody, &[&["--json"], &five[..]].concat()).expect(0).objects();
    assert_eq!(object[0]["safety_margin"], 0.1, "{object:?}");
    let _ = arcline(nobody, &["margin", "0", "--master-speed", "500"]).expect(2);
}
