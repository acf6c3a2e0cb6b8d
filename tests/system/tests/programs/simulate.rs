//! `simulate` from outside: the same bytes twice, and how much faster than real time.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use arcline_system_tests::{fixture, programs};

/// The floors with and without a trace, on the default configuration at 1 ms, on one core. Without a trace, the runner passes over
/// uneventful ticks.
const TIMES_REAL_TIME: [f64; 2] = [200.0, 5000.0];

/// The ten-minute program in a folder of its own; in a debug build its first twentieth.
fn program(folder: &Path) -> PathBuf {
    let text = fs::read_to_string(fixture("long/ten_minutes.st")).expect("a file of this package");
    let loops = "FOR i := 1 TO 100 BY 1 DO";
    assert!(text.contains(loops), "the program has its loop");
    let text = if cfg!(debug_assertions) {
        text.replace(loops, "FOR i := 1 TO 5 BY 1 DO")
    } else {
        text
    };
    let file = folder.join("program.st");
    fs::write(&file, text).expect("the folder is writable");
    file
}

/// Runs the program with `arguments`; returns how long that took.
fn simulate(program: &Path, arguments: &[&Path]) -> Duration {
    let began = Instant::now();
    let run = Command::new(programs::arcline_server())
        .arg("simulate")
        .arg(program)
        .args(arguments)
        .output();
    let run = run.expect("the server was just built");
    let took = began.elapsed();
    assert!(run.status.success(), "{run:?}");
    took
}

#[test]
fn two_runs_give_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = program(folder.path());
    let files: Vec<PathBuf> = ["1.csv", "1.jsonl", "2.csv", "2.jsonl"]
        .iter()
        .map(|name| folder.path().join(name))
        .collect();
    for run in files.chunks(2) {
        simulate(
            &program,
            &[Path::new("--trace"), &run[0], Path::new("--events"), &run[1]],
        );
    }
    let read = |file: &PathBuf| fs::read(file).expect("simulate has written it");
    for kind in [0, 1] {
        let (first, second) = (read(&files[kind]), read(&files[kind + 2]));
        assert!(!first.is_empty());
        assert!(first == second, "{:?} and {:?} differ", files[kind], files[kind + 2]);
    }
}

#[test]
fn faster_than_real_time() {
    // The least of several runs, and of many while it is not reached: the machine may be busy with something else.
    const TRIES: usize = 240;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = program(folder.path());
    let trace = folder.path().join("trace.csv");
    let with_trace = [Path::new("--trace"), &trace];
    simulate(&program, &with_trace);
    // One row for each tick of 1 ms, and the header.
    let rows = fs::read(&trace)
        .expect("simulate has written it")
        .iter()
        .filter(|byte| **byte == b'\n')
        .count();
    let simulated = (rows - 1) as f64 * 1e-3;
    let runs: [(&str, &[&Path]); 2] = [("a trace", &with_trace), ("no trace", &[])];
    for ((name, arguments), least) in runs.into_iter().zip(TIMES_REAL_TIME) {
        let mut took = Duration::MAX;
        for _ in 0..TRIES {
            took = took.min(simulate(&program, arguments));
            if cfg!(debug_assertions) || simulated / took.as_secs_f64() > least {
                break;
            }
        }
        let times = simulated / took.as_secs_f64();
        println!("{simulated:.1} s simulated in {took:?} with {name}: {times:.0} times real time");
        // A debug build is measured, not checked.
        assert!(
            cfg!(debug_assertions) || times > least,
            "{times:.0} times real time with {name}, expected {least}"
        );
    }
}

#[test]
fn a_program_sets_the_override() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("program.st");
    let run = |text: &str| {
        fs::write(&file, text).expect("the folder is writable");
        let trace = folder.path().join("trace.csv");
        let run = Command::new(programs::arcline_server())
            .args([Path::new("simulate"), &file, Path::new("--trace"), &trace])
            .output()
            .expect("the server was just built");
        let rows = fs::read_to_string(&trace).map_or(0, |trace| trace.lines().count());
        (
            run.status.code(),
            String::from_utf8_lossy(&run.stderr).into_owned(),
            rows,
        )
    };
    let program = "MCLM(CS1, M, 0, [100, 0, 0], 100, 0, 2000, 0, 2000, 0, 1, 50000, 50000, 0, 1);";
    let (code, errors, whole) = run(program);
    assert_eq!(code, Some(0), "{errors}");
    let (code, errors, half) = run(&format!("FeedOverride[0] := 50; {program}"));
    assert_eq!(code, Some(0), "{errors}");
    assert!(
        half > whole * 9 / 5 && half < whole * 2,
        "{half} rows instead of {whole}"
    );
    let (code, errors, _) = run("FeedOverride[0] := 201;");
    assert_ne!(code, Some(0));
    assert!(
        errors.contains("FeedOverride cannot be 201, expected 0 to 200"),
        "{errors}"
    );
}

/// A merge takes no place in the queue, so it waits for none (the queue of XY has one place).
#[test]
fn a_merge_never_waits_for_room_in_the_queue() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (file, events) = (folder.path().join("program.st"), folder.path().join("events.jsonl"));
    let dynamics = "50, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1";
    for merge in [1, 2] {
        let program = format!(
            "MCLM(XY, M1, 0, [100, 0], {dynamics});\nMCLM(XY, M2, 0, [100, 50], {dynamics});\nDELAY(0.1);\n\
             MCLM(XY, M3, 0, [0, 50], {dynamics}, {merge});"
        );
        fs::write(&file, program).expect("the folder is writable");
        simulate(&file, &[Path::new("--events"), &events]);
        let text = fs::read_to_string(&events).expect("simulate has written it");
        let active = text
            .lines()
            .find(|line| line.contains("\"M3\"") && line.contains("\"AC\""))
            .expect("M3 becomes active");
        let at = active
            .split("\"time_s\":")
            .nth(1)
            .and_then(|rest| rest.split([',', '}']).next());
        let at: f64 = at.and_then(|time| time.trim().parse().ok()).expect("a time");
        assert!((0.1..0.105).contains(&at), "Merge {merge}: M3 takes over at {at} s");
    }
}

#[test]
fn a_program_injects_faults_and_sees_them() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("program.st");
    let trace = folder.path().join("trace.csv");
    let run = |text: &str| {
        fs::write(&file, text).expect("the folder is writable");
        let run = Command::new(programs::arcline_server())
            .args([Path::new("simulate"), &file, Path::new("--trace"), &trace])
            .output()
            .expect("the server was just built");
        (run.status.code(), String::from_utf8_lossy(&run.stderr).into_owned())
    };
    // X stops by itself at 10,000 units/s² and ends behind 20 by half a unit and the travel of an update.
    let (code, errors) = run(
        "MCLM(CS1, M, 0, [100, 0, 0], 100, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 1);\n\
         WAIT(X.ActualPosition > 20);\nFaultInject[0] := 16;\nWAIT(X.CIPAxisState = 8);\n\
         FaultInject[0] := 0;\nMAFR(X, R);\nWAIT(X.CIPAxisState = 2);\nMSO(X, On);\nWAIT(On.DN);\n\
         MAM(X, Back, 0, 20, 100, 0, 2000, 0, 2000, 0, 0, 100, 100, 2);\nWAIT(Back.PC);",
    );
    assert_eq!(code, Some(0), "{errors}");
    let text = fs::read_to_string(&trace).expect("a trace was written");
    let positions = text
        .lines()
        .skip(1)
        .filter_map(|row| row.split(',').nth(2)?.parse::<f64>().ok());
    let positions: Vec<f64> = positions.collect();
    let furthest = positions.iter().copied().fold(0.0, f64::max);
    assert!((20.5..20.8).contains(&furthest), "{furthest}");
    assert_eq!(positions.last(), Some(&20.0));
    let (code, errors) = run("FaultInject[4] := 16;");
    assert_ne!(code, Some(0));
    assert!(
        errors.contains("FaultInject[4] cannot be 0x10, expected bits of 0x203"),
        "{errors}"
    );
}
