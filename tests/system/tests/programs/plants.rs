//! `simulate --step`: a plant outside says where the axes are.

use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use arcline_system_tests::programs;
use serde_json::{Value, json};

const PROGRAM: &str = "MCLM(CS1, M1, Absolute, [40, 20, 0], 200, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2);
WAIT(M1.PC);
MCCM(XY, M2, Absolute, [40, 60], Center, [40, 40], CW, 150, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2);
WAIT(M2.PC);
MAM(S, M3, Absolute, 5, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);
";

/// Runs the program in a folder with a plant that answers each line of set-points; `None`: it closes its pipe. Behind that the output is read to its end.
fn step(folder: &Path, arguments: &[&str], mut plant: impl FnMut(&str) -> Option<String>) -> Output {
    fs::write(folder.join("program.st"), PROGRAM).expect("the folder is writable");
    let child = Command::new(programs::arcline_server())
        .current_dir(folder)
        .args(["simulate", "program.st", "--step"])
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = child.expect("the server was just built");
    let (mut input, output) = (child.stdin.take(), child.stdout.take());
    for line in BufReader::new(output.expect("a pipe")).lines() {
        let line = line.expect("text");
        // The first line has no tick.
        if line.starts_with("{\"arcline\"") {
            continue;
        }
        match plant(&line) {
            // A server that has refused the answer before reads no more.
            Some(answer) => drop(input.as_mut().map(|input| input.write_all(answer.as_bytes()))),
            None => drop(input.take()),
        }
    }
    child.wait_with_output().expect("it ends")
}

#[test]
fn a_plant_that_echoes_gives_the_trace_of_the_simulated_drives() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("program.st"), PROGRAM).expect("the folder is writable");
    let plain = Command::new(programs::arcline_server())
        .current_dir(&folder)
        .args([
            "simulate",
            "program.st",
            "--trace",
            "plain.csv",
            "--events",
            "plain.jsonl",
        ])
        .output();
    let plain = plain.expect("the server was just built");
    assert!(plain.status.success(), "{plain:?}");
    let mut ticks = 0;
    let files = ["--trace", "step.csv", "--events", "step.jsonl"];
    let echoed = step(folder.path(), &files, |line| {
        ticks += 1;
        Some(format!("{line}\n"))
    });
    assert!(echoed.status.success(), "{echoed:?}");
    assert_eq!(echoed.stderr, plain.stderr, "the same summary");
    let read = |name: &str| fs::read(folder.path().join(name)).expect("simulate has written it");
    for kind in ["csv", "jsonl"] {
        assert!(
            read(&format!("plain.{kind}")) == read(&format!("step.{kind}")),
            "{kind}"
        );
    }
    let rows = read("plain.csv").split(|byte| *byte == b'\n').count() - 2;
    assert_eq!(ticks, rows, "a line for each tick");
    // The plant leaves all axes to the simulated drives.
    let left = step(folder.path(), &files, |_| Some("{}\n".to_owned()));
    assert!(
        left.status.success() && read("plain.csv") == read("step.csv"),
        "{left:?}"
    );
}

#[test]
fn the_actual_position_is_that_of_the_plant() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut last = [json!(0), json!(0), json!(0), json!(0)];
    let ran = step(
        folder.path(),
        &["--trace", "late.csv", "--signals", "X.CommandPosition,X.ActualPosition"],
        |line| {
            let sent: Value = serde_json::from_str(line).expect("a line of JSON");
            let answer = json!({"tick": sent["tick"], "position": last});
            last = [0, 1, 2, 3].map(|axis| sent["position"][axis].clone());
            Some(format!("{answer}\n"))
        },
    );
    assert!(ran.status.success(), "{ran:?}");
    let trace = fs::read_to_string(folder.path().join("late.csv")).expect("simulate has written it");
    let rows: Vec<Vec<&str>> = trace.lines().skip(1).map(|row| row.split(',').collect()).collect();
    let moved = rows.windows(2).filter(|rows| rows[0][2] != rows[1][2]).count();
    assert!(moved > 100, "{moved}");
    for rows in rows.windows(2) {
        assert_eq!(rows[1][3], rows[0][2], "a tick behind, at tick {}", rows[1][0]);
    }
}

#[test]
fn a_plant_that_says_nonsense_ends_the_run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    #[rustfmt::skip]
    let cases = [
        (Some("no JSON\n"),               "standard input: tick 20: is no feedback: expected ident at line 1 column 2"),
        (Some("{\"position\":[1]}\n"),    "standard input: tick 20: position has 1 values, expected 4, one of each axis"),
        (Some("{\"tick\":19}\n"),         "standard input: tick 20: is an answer to tick 19"),
        (None,                            "standard input: tick 20: has ended, expected the feedback of the tick"),
    ];
    for (answer, expected) in cases {
        let ran = step(folder.path(), &[], |line| match line.contains("\"tick\":20,") {
            true => answer.map(str::to_owned),
            false => Some("{}\n".to_owned()),
        });
        let error = String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(2), "{answer:?}: {error}");
        assert!(error.contains(expected), "{answer:?}: {error}");
    }
    for arguments in [
        &["--trace", "-"][..],
        &["--events", "-"],
        &["--json"],
        &["--cases", "cases.jsonl"],
    ] {
        let ran = step(folder.path(), arguments, |_| None);
        assert_eq!(ran.status.code(), Some(2), "{arguments:?}: {ran:?}");
    }
}
