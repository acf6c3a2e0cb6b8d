//! `arcline trace` against a real server: CSV, MCAP, triggers.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use arcline_system_tests::command_line::{arcline, command};
use arcline_system_tests::eventually;
use arcline_system_tests::server::Server;

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().expect("UTF-8").to_owned()
}

/// The rows of a CSV file as numbers, and its titles.
fn read(file: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(file).expect("it has been written");
    let mut lines = text.lines();
    let titles = lines.next().expect("a header").split(',').map(str::to_owned).collect();
    let number = |cell: &str| cell.parse().unwrap_or_else(|_| panic!("{cell:?} is no number"));
    (
        titles,
        lines.map(|line| line.split(',').map(number).collect()).collect(),
    )
}

#[test]
fn every_tick_is_in_the_file() {
    let server = Server::start();
    let at = server.address();
    let folder = tempfile::tempdir().expect("a folder");
    let file = path(folder.path(), "t.csv");
    let told = arcline(
        at,
        &[
            "--json",
            "trace",
            "X",
            "CS1",
            "X.MoveStatus",
            "--for",
            "0.5",
            "-o",
            &file,
        ],
    )
    .expect(0);
    assert_eq!(
        (&told.objects()[0]["rows"], &told.objects()[0]["missing"]),
        (&500.into(), &0.into()),
        "{told:?}"
    );
    let (titles, rows) = read(&file);
    let expected = "tick,time_s,X.CommandPosition,X.CommandVelocity,X.CommandAcceleration,X.ActualPosition,CS1.PathSpeed,\
                    CS1.PathPosition,X.MoveStatus";
    assert_eq!(titles.join(","), expected);
    assert_eq!(rows.len(), 500);
    for pair in rows.windows(2) {
        assert_eq!(pair[1][0], pair[0][0] + 1.0, "no gap");
    }
    assert!((rows[0][1] - rows[0][0] * 1e-3).abs() < 1e-9, "{:?}", rows[0]);
    let _ = arcline(at, &["trace", "--for", "0.1", "--every", "10", "-o", &file]).expect(0);
    let (titles, rows) = read(&file);
    assert_eq!(
        (titles.len(), rows.len()),
        (2 + 7 * 4, 10),
        "all axes, every tenth tick"
    );
    assert_eq!(rows[1][0], rows[0][0] + 10.0);
    let piped = arcline(at, &["trace", "X", "--for", "0.1", "-o", "-"]).expect(0);
    assert_eq!(piped.stdout.lines().count(), 1 + 100, "{piped:?}");
    assert!(piped.stdout.starts_with("tick,time_s,X.CommandPosition,"), "{piped:?}");
    assert!(piped.stderr.starts_with("100 rows of 4 signals"), "{piped:?}");
    for (why, arguments, message) in [
        (
            "no such signal",
            &["trace", "X.ComandPosition", "--for", "1", "-o", &file][..],
            "did you mean \"X.CommandPosition\"?",
        ),
        (
            "no such axis",
            &["trace", "CS9", "--for", "1", "-o", &file],
            "there is no tag \"CS9\"",
        ),
        (
            "no such file",
            &["trace", "X", "--for", "1", "-o", "t.txt"],
            "ends neither in .csv nor in .mcap",
        ),
    ] {
        let refused = arcline(at, arguments).expect(2);
        assert!(refused.stderr.contains(message), "{why}: {refused:?}");
    }
}

#[test]
fn a_trigger_begins_a_trace_that_includes_the_ticks_before_it() {
    let server = Server::start();
    let at = server.address();
    let folder = tempfile::tempdir().expect("a folder");
    let file = path(folder.path(), "t.csv");
    let arguments = [
        "trace",
        "X",
        "--for",
        "0.2",
        "--trigger",
        "X.CommandPosition>=1",
        "--before",
        "0.05",
        "-o",
        &file,
    ];
    let waiting = command(at, &arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("just built");
    // The file is there when the trace is about to be armed; a move that repeats triggers it sooner or later.
    let mut waiting = waiting;
    eventually("the end of the trace", Duration::from_secs(30), || {
        let _ = arcline(at, &["move-axis", "X", "2"]).expect(0);
        let _ = arcline(at, &["move-axis", "X", "0"]).expect(0);
        waiting.try_wait().expect("it is our child")
    });
    let output = waiting.wait_with_output().expect("it has ended");
    assert!(output.status.success(), "{output:?}");
    let (_, rows) = read(&file);
    assert_eq!(rows.len(), 250);
    assert!(rows[49][2] < 1.0 && rows[50][2] >= 1.0, "{:?} {:?}", rows[49], rows[50]);
}
