//! The commands of the command line that command no motion: explain, watch, the shell, completions and manual pages.

use std::io::Write;
use std::process::{Command, Stdio};

use arcline_system_tests::command_line::{Outcome, arcline, command, read_numbers};
use arcline_system_tests::programs;
use arcline_system_tests::server::Server;
use arcline_system_tests::terminal::at_a_terminal;

/// Runs it to its end with `input` on its standard input.
fn with_input(mut command: Command, input: &str) -> Outcome {
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program was just built");
    let mut stdin = child.stdin.take().expect("stdin is piped");
    // A program that has ended before reads no input.
    let _ = stdin.write_all(input.as_bytes());
    drop(stdin);
    let output = child.wait_with_output().expect("it ends");
    Outcome {
        code: output.status.code(),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

#[test]
fn traces_are_compared_within_a_tolerance() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = std::net::SocketAddr::from(([127, 0, 0, 1], 9));
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path.to_str().expect("the project's paths are UTF-8").to_owned()
    };
    let a = file("a.csv", "tick,time_s,X\n0,0,1\n1,0.001,2\n");
    #[rustfmt::skip]
    let cases = [
        // why,                  the other,                                   tolerance, code, words
        ("itself",               "tick,time_s,X\n0,0,1\n1,0.001,2\n",         "0",    0, "the same: 2 rows, greatest difference 0"),
        ("other columns' order", "time_s,X,tick\n0,1,0\n0.001,2,1\n",         "0",    0, "the same"),
        ("within",               "tick,time_s,X\n0,0,1\n1,0.001,2.25\n",      "0.25", 0, "greatest difference 0.25"),
        ("beyond",               "tick,time_s,X\n0,0,1\n1,0.001,2.5\n",       "0.25", 1, "line 3, X: 2 and 2.5; 1 numbers differ, by 0.5 at most"),
        ("shorter",              "tick,time_s,X\n0,0,1\n",                    "0",    1, "ends after 1 row"),
        ("a column less",        "tick,time_s\n0,0\n1,0.001\n",               "0",    1, "has no column X"),
        ("a tick late",          "tick,time_s,X\n0,0,1\n2,0.001,2\n",         "1",    1, "line 3, tick: 1 and 2"),
        ("at another time",      "tick,time_s,X\n0,0,1\n1,0.002,2\n",         "1",    1, "line 3, time_s: 0.001 and 0.002"),
        ("a column twice",       "tick,time_s,X,X\n0,0,1,1\n1,0.001,2,3\n",   "0",    1, "has no column X once more"),
        ("no trace",             "hello\n",                                   "0",    2, "is no trace"),
        ("a row that is cut",    "tick,time_s,X\n0,0\n",                      "0",    2, "line 2 has 2 cells, expected 3"),
    ];
    // Equal names: the first is compared with the first, the second with the second.
    let twice = file("twice.csv", "tick,time_s,X,X\n0,0,1,2\n");
    assert!(
        arcline(at, &["diff", &twice, &twice])
            .expect(0)
            .stdout
            .contains("the same")
    );
    let other = file("other.csv", "tick,time_s,X,X\n0,0,1,3\n");
    assert_eq!(arcline(at, &["diff", &twice, &other]).code, Some(1));
    for (why, text, tolerance, code, words) in cases {
        let b = file("b.csv", text);
        let ran = arcline(at, &["diff", &a, &b, "--tolerance", tolerance]);
        assert_eq!(ran.code, Some(code), "{why}: {}{}", ran.stdout, ran.stderr);
        let told = format!("{}{}", ran.stdout, ran.stderr);
        assert!(told.contains(words), "{why}: {told}");
    }
}

#[test]
fn an_error_is_explained() {
    let server = Server::start();
    let at = server.address();
    let told = arcline(at, &["explain", "13/4", "MCLM"]).expect(0).stdout;
    assert_eq!(
        told,
        "ERR 13 Parameter Out Of Range, operand 4 (Speed)\n\
         cause   The operand is out of its range.\n        \
         Operand 4 of MCLM is Speed: number, 0 or more (in Speed Units; 0: the move waits until MCCD or MCD gives it a speed).\n\
         remedy  Correct the operand whose number is EXERR (counted from 0).\n"
    );
    // The newest error of a tag; the type of an instruction tag tells the instruction.
    assert_eq!(arcline(at, &["explain", "Move1"]).expect(0).stdout, "Move1: no error\n");
    for (tag, value) in [("Move1.Speed", "-5.0"), ("Move1.EnableIn", "true")] {
        let _ = arcline(at, &["write", tag, value]).expect(0);
    }
    for subject in [&["explain", "Move1"][..], &["explain", "Move1.MotionControl", "MCLM"]] {
        assert_eq!(arcline(at, subject).expect(0).stdout, told, "{subject:?}");
    }
    let object = arcline(at, &["--json", "explain", "Move1"]).expect(0).objects();
    assert_eq!(
        (&object[0]["ERR"], &object[0]["instruction"]),
        (&13.into(), &"MCLM".into()),
        "{object:?}"
    );
    let _ = arcline(at, &["explain", "120"]).expect(2);
    let slip = arcline(at, &["explain", "overcurent"]).expect(2);
    assert!(slip.stderr.contains("did you mean \"overcurrent\"?"), "{slip:?}");
    let near = arcline(at, &["explain", "Mvoe1"]).expect(2);
    assert!(near.stderr.contains("did you mean \"Move1\"?"), "{near:?}");
    // Codes and faults need no server.
    let nobody = "127.0.0.1:1".parse().expect("an address");
    let refused = arcline(nobody, &["explain", "overcurent"]).expect(3).stderr;
    let words = "overcurent is neither an error nor a fault (did you mean \"overcurrent\"?), and tags are read from the server\n";
    assert!(
        refused.starts_with("no connection to 127.0.0.1:1: ") && refused.ends_with(words),
        "{refused}"
    );
    assert!(
        arcline(nobody, &["explain", "overcurrent"])
            .expect(0)
            .stdout
            .contains("more current than its limit")
    );
    let _ = arcline(nobody, &["explain", "61/17"]).expect(0);
    let _ = arcline(nobody, &["explain", "Move1"]).expect(3);
}

#[test]
fn a_misspelt_name_is_answered_with_the_likely_one() {
    let server = Server::start();
    let at = server.address();
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (out, part) = (path("t.csv"), path("part.ngc"));
    std::fs::write(&part, "G0 X1\n").expect("the folder is writable");
    #[rustfmt::skip]
    let cases: &[(&str, &[&str], &str)] = &[
        ("a tag",                       &["read", "Mvoe1"],                                             "Move1"),
        ("a member",                    &["read", "X.ActualPositon"],                                   "ActualPosition"),
        ("a member of a member",        &["read", "Move1.MotionControl.ERRR"],                          "ERR"),
        ("a tag that is written",       &["write", "Mvoe1.Speed", "5"],                                 "Move1"),
        ("a member that is written",    &["write", "Move1.Sped", "5"],                                  "Speed"),
        ("a tag that is deleted",       &["tags", "delete", "Mvoe1"],                                   "Move1"),
        ("what is shown",               &["status", "CSS1"],                                            "CS1"),
        ("what is watched",             &["watch", "CSS1"],                                             "CS1"),
        ("a signal",                    &["trace", "X.ActualPositon", "--for", "1", "-o", &out],        "X.ActualPosition"),
        ("what is traced",              &["trace", "CSS1", "--for", "1", "-o", &out],                   "CS1"),
        ("a trigger's signal",          &["trace", "X", "--for", "1", "--trigger", "X.CommandPositon>=1", "-o", &out], "X.CommandPosition"),
        ("an instruction",              &["exec", "MCML(CS1, M1)"],                                     "MCLM"),
        ("its coordinate system",       &["exec", "MCLM(CSS1, M1, 0, [1, 2, 3])"],                      "CS1"),
        ("its word",                    &["exec", "MCLM(CS1, M1, Absolte, [1, 2, 3])"],                 "Absolute"),
        ("its tag",                     &["exec", "MCLM(CS1, M1, 0, Mvoe1.Position)"],                  "Move1"),
        ("the member of its tag",       &["exec", "MCLM(CS1, M1, 0, Move1.Positon)"],                   "Position"),
        ("another object of it",        &["exec", "MAG(Y, XX, M1, Same, 1, 1, 1, Actual, Real, Disabled)"], "X"),
        ("the end of a line",           &["move", "CSS1", "1,2,3"],                                     "CS1"),
        ("the end of an arc",           &["arc", "XYY", "1,2", "--via", "1,1"],                         "XY"),
        ("a change",                    &["change", "CSS1", "--speed", "20%"],                          "CS1"),
        ("an override",                 &["override", "CSS1", "50%"],                                   "CS1"),
        ("a hold",                      &["hold", "CSS1"],                                              "CS1"),
        ("its end",                     &["resume", "CSS1"],                                            "CS1"),
        ("a stop",                      &["stop", "CSS1"],                                              "CS1"),
        ("G-code",                      &["gcode", &part, "CSS1"],                                      "CS1"),
        ("G-code without a machine",    &["gcode", &part, "CSS1", "--simulate"],                        "CS1"),
        ("a move of an axis",           &["move-axis", "XX", "5"],                                      "X"),
        ("a jog",                       &["jog", "XX", "5"],                                            "X"),
        ("homing",                      &["home", "XX"],                                                "X"),
        ("a servo",                     &["servo", "off", "XX"],                                        "X"),
        ("a fault",                     &["fault", "inject", "XX", "overcurrent"],                      "X"),
        ("faults that are listed",      &["fault", "list", "XX"],                                       "X"),
    ];
    for (why, arguments, meant) in cases {
        let refused = arcline(at, arguments).expect(2);
        let answers = [format!("did you mean \"{meant}\"?"), format!("did you mean `{meant}`?")];
        assert!(
            answers.iter().any(|answer| refused.stderr.contains(answer)),
            "{why}: {arguments:?}: {refused:?}"
        );
    }
    // A client may yet make a motion control tag, so a trigger waits for it, with a message, until Ctrl-C ends it.
    let waiting = command(at, &["trace", "X", "--for", "1", "--trigger", "Mvoe1:AC", "-o", &out]);
    let talk = [("did you mean \"Move1\"?", ""), ("waiting for the trigger", "\u{3}")];
    let told = at_a_terminal(&waiting, &talk);
    assert!(told.code == Some(0) && told.stdout.contains("0 rows"), "{told:?}");
    // A list without a row is no error; a name of the wrong kind has a message with its kind.
    let none = arcline(at, &["tags", "Mvoe1"]).expect(0);
    assert_eq!(
        (none.stdout.as_str(), none.stderr.as_str()),
        ("", "no tag matches \"Mvoe1\", did you mean \"Move1\"?\n")
    );
    for arguments in [&["status", "Move1"][..], &["trace", "Move1", "--for", "1", "-o", &out]] {
        let told = arcline(at, arguments).expect(2).stderr;
        assert!(told.contains("Move1 has the type MCLM, expected an axis"), "{told}");
    }
}

#[test]
fn a_coordinate_system_shows_its_own_axes() {
    let server = Server::start();
    let at = server.address();
    let shown = arcline(at, &["status", "XY", "CS1"]).expect(0).stdout;
    let positions: Vec<usize> = shown
        .lines()
        .skip(1)
        .map(|line| line.matches("0.000").count())
        .collect();
    assert_eq!(positions, [3, 2], "{shown}");
    let object = arcline(at, &["--json", "status", "XY"]).expect(0).objects();
    assert_eq!(object[0]["position"].as_array().map(Vec::len), Some(2), "{object:?}");
}

#[test]
fn a_status_bit_is_read_without_its_structure() {
    let server = Server::start();
    let at = server.address();
    assert_eq!(arcline(at, &["read", "Move1.PC"]).expect(0).stdout, "false\n");
    let program = "Move1.Position[0] := 5; Move1.EnableIn := TRUE; WAIT(Move1.PC); Move1.EnableIn := FALSE;";
    let _ = with_input(command(at, &["shell"]), &format!("{program}\n")).expect(0);
    assert_eq!(read_numbers(at, &["X.CommandPosition"]), [5.0]);
}

#[test]
fn piped_watching_gives_a_line_for_each_change() {
    let server = Server::start();
    let at = server.address();
    let shown = arcline(at, &["watch", "X", "CS1", "--for", "0.3", "--interval", "0.1"]).expect(0);
    let lines: Vec<&str> = shown.stdout.lines().collect();
    assert!(lines.len() >= 2 && lines[0].contains("  X  0.000  "), "{shown:?}");
    assert!(!shown.stdout.contains('\u{1b}'), "{shown:?}");
    let object = arcline(at, &["--json", "watch", "X", "--for", "0.05"])
        .expect(0)
        .objects();
    assert!(
        object[0]["time_s"].is_number() && object[0]["name"] == "X",
        "{object:?}"
    );
    let _ = arcline(at, &["watch", "W"]).expect(2);
}

#[test]
fn status_and_watch_name_the_mover_and_tell_that_stop_holds() {
    let server = Server::start();
    let at = server.address();
    let mover = |name: &str| arcline(at, &["--json", "status", name]).expect(0).objects()[0]["moved_by"].clone();
    assert!(mover("CS1").is_null() && mover("X").is_null());
    let resting = arcline(at, &["status", "X", "CS1"]).expect(0).stdout;
    assert!(!resting.contains("moved by"), "{resting}");

    let _ = arcline(at, &["move", "CS1", "100000,0,0", "--speed", "10", "--no-wait"]).expect(0);
    // Its coordinate system moves X; Y is an axis of it too.
    for name in ["CS1", "X"] {
        let mover = mover(name);
        assert!(
            mover["product"]
                .as_str()
                .is_some_and(|product| product.starts_with("arcline ")),
            "{name}: {mover}"
        );
        assert!(
            mover["address"]
                .as_str()
                .is_some_and(|from| from.starts_with("127.0.0.1")),
            "{mover}"
        );
    }
    let text = mover("CS1")["text"].as_str().expect("a text").to_owned();
    let status = arcline(at, &["status", "X", "CS1", "S"]).expect(0).stdout;
    let lines: Vec<&str> = status
        .lines()
        .filter(|line| line.contains(&format!("moved by {text}")))
        .collect();
    assert!(
        lines.len() == 2
            && !status
                .lines()
                .any(|line| line.starts_with("S ") && line.contains("moved by")),
        "{status}"
    );

    let watched = arcline(at, &["watch", "X", "--for", "0.05"]).expect(0).stdout;
    assert!(
        watched.contains(&format!("moved by {text}")) && !watched.contains("STOP holds"),
        "{watched}"
    );
    let shown = at_a_terminal(&command(at, &["watch"]), &[("moved", "q")]);
    assert_eq!(shown.code, Some(0), "{shown:?}");

    let _ = arcline(at, &["stop", "--hold"]).expect(0);
    let watched = arcline(at, &["watch", "X", "--for", "0.05"]).expect(0).stdout;
    assert!(watched.contains("STOP holds: motion is inhibited"), "{watched}");
    let objects = arcline(at, &["--json", "watch", "X", "--for", "0.05"])
        .expect(0)
        .objects();
    assert!(
        objects.iter().any(|object| object["motion_inhibited"] == true),
        "{objects:?}"
    );
    let shown = at_a_terminal(&command(at, &["watch"]), &[("holds:", "q")]);
    assert_eq!(shown.code, Some(0), "{shown:?}");
}

#[test]
fn watching_on_a_terminal_fills_the_screen_and_leaves_it() {
    let server = Server::start();
    let at = server.address();
    let shown = at_a_terminal(&command(at, &["watch", "--for", "1"]), &[]);
    for expected in ["\u{1b}[?1049h", "CS1", "pause", "\u{1b}[?1049l"] {
        assert!(shown.stdout.contains(expected), "{expected:?} in {shown:?}");
    }
    assert_eq!(shown.code, Some(0), "{shown:?}");
    // The key ends it, and the other one stops the machine first.
    let _ = arcline(at, &["jog", "X", "5", "--no-wait"]).expect(0);
    let shown = at_a_terminal(&command(at, &["watch", "X"]), &[("jogging", "s"), ("stop:", "q")]);
    assert_eq!(shown.code, Some(0), "{shown:?}");
    arcline_system_tests::eventually("the stop", std::time::Duration::from_secs(20), || {
        (read_numbers(at, &["X.CommandVelocity"])[0] == 0.0).then_some(())
    });
}

#[test]
fn the_shell_runs_piped_commands() {
    let server = Server::start();
    let at = server.address();
    let lines = "# a comment\nmove CS1 10,0,0\nMCLM(CS1, Line, Absolute, [20, 5, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2)\n\
                 MSO(X, S1); WAIT(S1.DN);\n--json read X.CommandPosition\nexplain 43\nexit\nmove CS1 0,0,0\n";
    let outcome = with_input(command(at, &["shell"]), lines).expect(0);
    for expected in [
        "MCLM CS1: EN DN PC",
        "line: 1 instruction executed",
        "\"value\":20.0",
        "ERR 43 Coordinate System Queue Full",
    ] {
        assert!(outcome.stdout.contains(expected), "{expected} in {outcome:?}");
    }
    assert_eq!(
        read_numbers(at, &["X.CommandPosition"]),
        [20.0],
        "nothing behind `exit`"
    );
    // The first line that fails ends it with its code.
    for (line, code) in [
        ("MCLM(CS1, L, 0, [1, 2, 3], -5)", 1),
        ("dance", 2),
        ("read 'open", 2),
        ("read Nothing", 2),
        ("shell", 2),
    ] {
        let outcome = with_input(command(at, &["shell"]), &format!("{line}\nmove CS1 0,0,0\n"));
        assert_eq!(outcome.code, Some(code), "{line}: {outcome:?}");
        assert!(!outcome.stderr.is_empty(), "{line}: {outcome:?}");
    }
    assert_eq!(read_numbers(at, &["X.CommandPosition"]), [20.0]);
}

#[test]
fn the_shell_at_a_terminal_completes_and_remembers() {
    let server = Server::start();
    let at = server.address();
    let history = programs::target_directory().join(format!("history-{}", std::process::id()));
    let file = history.to_str().expect("the target folder's name is UTF-8");
    let shell = command(at, &["shell", "--history", file]);
    // Tab makes a whole name of its beginning.
    let talk = [
        ("arcline> ", "read RealT\t"),
        ("RealTime", ".UpdateP\t"),
        ("UpdatePeriod", "\r"),
        ("\n1", ""),
        ("arcline> ", "MSO(X, S1)\r"),
        ("EN DN", ""),
        ("arcline> ", "exit\r"),
    ];
    let outcome = at_a_terminal(&shell, &talk);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stdout.contains("Tab completes"), "{outcome:?}");
    let kept = std::fs::read_to_string(&history).expect("the history has been written");
    assert!(
        kept.contains("read RealTime.UpdatePeriod") && kept.contains("MSO(X, S1)"),
        "{kept}\n{outcome:?}"
    );
    // Operands to come are shown; an error does not end it; an earlier line comes back.
    let talk = [
        ("arcline> ", "MCLM(CS1, "),
        ("MoveType, Position", "\u{3}"),
        // The end of a line; keys before it would be lost.
        ("\u{1b}[?2004l", ""),
        ("arcline> ", "read Nothing\r"),
        ("there is no tag", ""),
        ("arcline> ", "\u{1b}[A\u{1b}[A\u{1b}[A"),
        ("MSO(X, S1)", "\u{3}"),
        ("\u{1b}[?2004l", ""),
        ("arcline> ", "exit\r"),
    ];
    let outcome = at_a_terminal(&shell, &talk);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let _ = std::fs::remove_file(&history);
}

#[test]
fn completions_and_manual_pages_are_made_of_the_arguments() {
    let nobody = "127.0.0.1:1".parse().expect("an address");
    for (shell, expected) in [
        ("bash", "complete -F"),
        ("zsh", "#compdef arcline"),
        ("fish", "complete -c arcline"),
    ] {
        let script = arcline(nobody, &["completions", shell]).expect(0).stdout;
        assert!(script.contains(expected) && script.contains("move-axis"), "{shell}");
    }
    assert!(arcline(nobody, &["man"]).expect(0).stdout.contains(".TH arcline 1"));
    let folder = programs::target_directory().join(format!("man-{}", std::process::id()));
    let shown = arcline(nobody, &["man", "-o", folder.to_str().expect("UTF-8")]).expect(0);
    for page in ["arcline.1", "arcline-move.1", "arcline-fault-inject.1"] {
        let text =
            std::fs::read_to_string(folder.join(page)).unwrap_or_else(|error| panic!("{page}: {error}: {shown:?}"));
        assert!(text.contains("Example: "), "{page}");
    }
    let _ = std::fs::remove_dir_all(&folder);
}
