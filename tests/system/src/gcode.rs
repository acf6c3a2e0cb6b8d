//! Long G-code programs, simulated: their duration and memory, by `arcline gcode --simulate`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::Duration;

use crate::command_line::command;

/// A simulated program.
#[derive(Clone, Copy, Debug)]
pub struct Simulated {
    /// Duration of its motion, s.
    pub seconds: f64,
    /// Moves that were executed.
    pub moves: u64,
    /// The most memory that `arcline` and the simulation had together, bytes.
    pub peak: u64,
}

/// Writes a program of a number of lines of 0.25 mm at 50 mm/s, up and down in X, and simulates it on the default machine.
///
/// # Panics
/// When it cannot be written, simulated or observed.
#[must_use]
pub fn simulated(folder: &Path, lines: usize) -> Simulated {
    let mut text = String::from("G21 G90 G61 F3000\n");
    for line in 1..lines {
        let step = (line + 200) % 400;
        let x = 0.25 * step.abs_diff(200) as f64;
        // Writing to a String cannot fail.
        let _ = writeln!(text, "G1 X{x}");
    }
    simulated_on(None, &written(folder, lines, text))
}

/// Writes a dense toolpath of a number of lines: chords of 0.25 mm of a wave at 150 mm/s, to be rounded within 0.01 mm.
///
/// # Panics
/// When it cannot be written.
#[must_use]
pub fn toolpath(folder: &Path, lines: usize) -> PathBuf {
    let mut text = String::from("G21 G90 G64 P0.01 F9000\n");
    for line in 1..lines {
        let along = 0.25 * line as f64;
        let (x, y) = (60.0 * (along / 60.0).sin(), 40.0 * (along / 47.0).sin());
        let _ = writeln!(text, "G1 X{x:.3} Y{y:.3} Z{:.3}", 6.0 * (along / 13.0).sin());
    }
    written(folder, lines, text)
}

fn written(folder: &Path, lines: usize, text: String) -> PathBuf {
    let file = folder.join(format!("{lines}.ngc"));
    std::fs::write(&file, text).expect("the folder is writable");
    file
}

/// Simulates a program on the coordinate system CS1 of the machine of a configuration, or of the default one.
///
/// # Panics
/// When it cannot be simulated or observed.
#[must_use]
pub fn simulated_on(config: Option<&Path>, file: &Path) -> Simulated {
    let file = file.to_str().expect("UTF-8");
    let nobody = "127.0.0.1:1".parse().expect("an address");
    let mut arcline = command(nobody, &["--json", "gcode", file, "CS1", "--simulate"]);
    if let Some(config) = config {
        arcline.arg("--config").arg(config);
    }
    let mut arcline = arcline.stdout(Stdio::piped()).spawn().expect("it was just built");
    let peak = peak_of(&mut arcline);
    let output = arcline.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{output:?}");
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).expect("an object");
    Simulated {
        seconds: told["seconds"].as_f64().expect("a time"),
        moves: told["moves"].as_u64().expect("a count"),
        peak,
    }
}

/// The greatest VmHWM of a process and of those that it has started, added, until it ends.
///
/// # Panics
/// When it is no child of this process.
#[must_use]
pub fn peak_of(process: &mut Child) -> u64 {
    let (mut own, mut started) = (0, 0);
    while process.try_wait().expect("it is ours").is_none() {
        own = high_water(process.id()).max(own);
        let children = format!("/proc/{0}/task/{0}/children", process.id());
        let children = std::fs::read_to_string(children).unwrap_or_default();
        let children = children.split_whitespace().filter_map(|id| id.parse().ok());
        started = children.map(high_water).sum::<u64>().max(started);
        std::thread::sleep(Duration::from_millis(10));
    }
    own + started
}

/// VmHWM of a process, bytes; 0: it has ended.
#[must_use]
pub fn high_water(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    kilobytes.unwrap_or_default() * 1024
}
