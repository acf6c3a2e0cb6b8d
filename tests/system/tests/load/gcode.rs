//! Long programs of G-code: their memory, and that they take as long as they are said to take.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::Stdio;

use arcline_system_tests::command_line::{arcline, command, read_numbers};
use arcline_system_tests::gcode::{simulated, simulated_on, toolpath};
use arcline_system_tests::server::Server;

#[test]
fn a_million_lines_take_no_more_memory_than_ten_thousand() {
    let _machine = crate::take_machine();
    let folder = tempfile::tempdir().expect("a folder");
    let (short, long) = (simulated(folder.path(), 10_000), simulated(folder.path(), 1_000_000));
    println!("{short:?}, {long:?}");
    assert_eq!(long.moves, 999_999);
    assert!(long.peak < short.peak + (16 << 20), "{short:?}, {long:?}");
    // As many moves, as much time, but for the first and the last one.
    let (per_short, per_long) = (short.seconds / short.moves as f64, long.seconds / long.moves as f64);
    assert!(
        (per_long / per_short - 1.0).abs() < 0.01,
        "{per_short} s and {per_long} s a move"
    );
}

/// A planned contour keeps no move that is complete.
#[test]
fn a_dense_toolpath_takes_no_more_memory_with_ten_times_the_moves() {
    let _machine = crate::take_machine();
    let folder = tempfile::tempdir().expect("a folder");
    let config = machine(folder.path());
    let of = |lines| simulated_on(Some(&config), &toolpath(folder.path(), lines));
    let (short, long) = (of(5_000), of(50_000));
    println!("{short:?}, {long:?}");
    assert!(long.peak < short.peak + (16 << 20), "{short:?}, {long:?}");
}

/// The time that `--simulate` printed, the first motion within 20 ms of the first execution, and no rest. A computer that is busy with something else
/// makes a server late, so one of three tries counts, and each is printed.
#[test]
fn a_dense_toolpath_takes_the_time_that_was_simulated() {
    let _machine = crate::take_machine();
    let folder = tempfile::tempdir().expect("a folder");
    let (config, file) = (machine(folder.path()), toolpath(folder.path(), 4_000));
    let simulated = simulated_on(Some(&config), &file).seconds;
    let is_kept = (0..3).any(|_| {
        let run = Run::live(&config, &file, folder.path(), simulated);
        println!("simulated {simulated} s, live {run:?}");
        run.rests == [0.0, 0.0] && (run.motion / simulated - 1.0).abs() <= 0.01 && run.began <= 0.020
    });
    assert!(is_kept, "none of three tries");
}

/// A program on a server. Seconds.
#[derive(Debug)]
struct Run {
    /// The time from the execution of the first move to the first motion.
    began: f64,
    /// The time from the first motion to the last.
    motion: f64,
    /// Rests on the way: as the program, and as the planner was too slow.
    rests: Vec<f64>,
}

impl Run {
    fn live(config: &Path, file: &Path, folder: &Path, simulated: f64) -> Run {
        let server = Server::start_on(config);
        let trace = folder.join("trace.csv");
        let time = (simulated + 2.0).to_string();
        let axes = ["trace", "X", "Y", "Z", "--trigger", "MCLM:IP", "--for", &time, "-o"];
        let mut tracing = command(server.address(), &axes);
        let mut tracing = tracing
            .arg(&trace)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it was just built");
        let mut waiting = String::new();
        let errors = tracing.stderr.take().expect("it is piped");
        BufReader::new(errors).read_line(&mut waiting).expect("a line");
        assert_eq!(waiting, "waiting for the trigger\n");
        let _ = arcline(server.address(), &["gcode", file.to_str().expect("UTF-8"), "CS1"]).expect(0);
        assert!(tracing.wait().expect("it ends").success());
        let rests = ["ContourRests[0].Starved", "ContourRests[0].Unplanned"];
        let rests = read_numbers(server.address(), &rests);
        let (began, motion) = moving(&trace);
        Run { began, motion, rests }
    }
}

/// The times from the first row of a trace to the first motion, and from that to the last, s.
fn moving(trace: &Path) -> (f64, f64) {
    let text = std::fs::read_to_string(trace).expect("a trace");
    let mut rows = text.lines();
    let head: Vec<&str> = rows.next().expect("a head").split(',').collect();
    let velocities: Vec<usize> = (0..head.len())
        .filter(|&column| head[column].ends_with("CommandVelocity"))
        .collect();
    assert_eq!(velocities.len(), 3, "{head:?}");
    let (mut start, mut first, mut last) = (None, None, 0.0);
    for row in rows {
        let row: Vec<f64> = row.split(',').map(|cell| cell.parse().expect("a number")).collect();
        start.get_or_insert(row[1]);
        if velocities.iter().any(|&column| row[column] != 0.0) {
            first.get_or_insert(row[1]);
            last = row[1];
        }
    }
    let (start, first) = (start.expect("rows"), first.expect("a motion"));
    (first - start, last - first)
}

/// Three axes whose moves are planned as contours within the limits of the axes, with a queue of 1,000.
fn machine(folder: &Path) -> PathBuf {
    let mut text = String::from("[server]\nname = \"toolpaths\"\n[motion_group]\nname = \"Motion\"\n");
    for axis in ["X", "Y", "Z"] {
        text += &format!(
            "[[axis]]\nname = \"{axis}\"\ntype = \"virtual\"\nunits = \"mm\"\nmax_speed = 500.0\nmax_acceleration = 5000.0\n\
             max_deceleration = 5000.0\nmax_acceleration_jerk = 100000.0\nmax_deceleration_jerk = 100000.0\n"
        );
    }
    text += "[[coordinate_system]]\nname = \"CS1\"\ntype = \"cartesian\"\naxes = [\"X\", \"Y\", \"Z\"]\nmax_speed = 1000.0\n\
             max_acceleration = 10000.0\nmax_deceleration = 10000.0\nmax_acceleration_jerk = 1000000.0\n\
             max_deceleration_jerk = 1000000.0\nqueue_depth = 1000\ncorner = \"precise\"\naxis_limits = \"enforce\"\n";
    let file = folder.join("machine.toml");
    std::fs::write(&file, text).expect("the folder is writable");
    file
}
