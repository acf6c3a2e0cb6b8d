//! `gcode --simulate`: the statements stream through `arcline-server simulate`, its events come back.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read as _, Write as _};
use std::process::{Command, Stdio};

use serde_json::json;

use super::PROGRESS;
use super::source::{Counts, Source};
use crate::cli::output::counted;
use crate::cli::tools::server_program;
use crate::cli::{Failure, Output};

/// Simulated time without an end of its own, s.
const LONGEST: &str = "1e9";

/// Reports the duration of a program.
pub(super) fn simulate(source: &Source<'_>, counts: &Counts, output: &Output) -> Result<(), Failure> {
    let command = source.command;
    let server = server_program();
    let failed = |error| Failure::at(&server, error);
    let mut simulation = Command::new(&server);
    simulation.args(["simulate", "-", "--lines", "--events", "-", "--until", LONGEST]);
    for (flag, file) in [("--config", &command.config), ("--trace", &command.trace)] {
        if let Some(file) = file {
            simulation.arg(flag).arg(file);
        }
    }
    simulation
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut simulation = simulation.spawn().map_err(failed)?;
    let (input, events, errors) = (
        simulation.stdin.take(),
        simulation.stdout.take(),
        simulation.stderr.take(),
    );
    let progress = output.bar(counts.statements(), PROGRESS);
    let (written, said, seconds) = std::thread::scope(|scope| {
        let written = scope.spawn(|| -> Result<(), Failure> {
            let Some(input) = input else { return Ok(()) };
            let mut input = BufWriter::new(input);
            for step in source.steps()? {
                // A simulation that has ended with an error reads no further.
                if writeln!(input, "{}", source.text_of(&step?)).is_err() {
                    break;
                }
                progress.inc(1);
            }
            let _ = input.flush();
            Ok(())
        });
        let said = scope.spawn(|| {
            let mut said = Vec::new();
            // Show the part that could be read.
            let _ = errors.map(|mut errors| errors.read_to_end(&mut said));
            String::from_utf8_lossy(&said).into_owned()
        });
        let seconds = events.map_or(Ok(0.0), |events| last_time(BufReader::new(events), source));
        (written.join(), said.join().unwrap_or_default(), seconds)
    });
    let status = simulation.wait().map_err(failed)?;
    progress.finish_and_clear();
    written.unwrap_or(Ok(()))?;
    if !status.success() {
        return Err(Failure::Simulate {
            said: in_lines_of(&said, source),
            code: status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1),
        });
    }
    let seconds = seconds?;
    let Counts { lines, arcs, .. } = *counts;
    let (shown, moves) = (source.name(), counts.moves());
    let [all, straight, round] = [(moves, "move"), (lines, "line"), (arcs, "arc")].map(|(n, noun)| counted(n, noun));
    output.result(
        format!("{shown}: {all} ({straight}, {round}) in {seconds:.3} s"),
        || json!({"program": shown, "moves": moves, "lines": lines, "arcs": arcs, "seconds": seconds}),
    );
    Ok(())
}

/// The time of the last event, s. All of them go to the file that the command names.
fn last_time(mut events: impl std::io::BufRead, source: &Source<'_>) -> Result<f64, Failure> {
    let target = source.command.events.as_deref();
    let failed = |error| Failure::at(target.unwrap_or(&source.command.file), error);
    let file = target.map(File::create).transpose().map_err(failed)?;
    let mut file = file.map(BufWriter::new);
    let (mut line, mut last) = (String::new(), String::new());
    while events.read_line(&mut line).map_err(failed)? > 0 {
        if let Some(file) = &mut file {
            file.write_all(line.as_bytes()).map_err(failed)?;
        }
        std::mem::swap(&mut line, &mut last);
        line.clear();
    }
    if let Some(mut file) = file {
        file.flush().map_err(failed)?;
    }
    let event: Option<serde_json::Value> = serde_json::from_str(&last).ok();
    Ok(event.and_then(|event| event["time_s"].as_f64()).unwrap_or_default())
}

/// The message of the simulation, with the file and line of the G-code in place of those of the generated program.
fn in_lines_of(said: &str, source: &Source<'_>) -> String {
    let name = source.name();
    let lines = said
        .trim()
        .lines()
        .map(|line| line.trim_start_matches("arcline-server: "));
    // An excerpt of the program that was made says nothing about the G-code.
    let lines = lines.filter(|line| !line.starts_with(' '));
    let lines = lines.map(|line| match line.strip_prefix("-: ") {
        Some(rest) => format!("{name}: {}", in_line_of(rest, source)),
        None => line.to_owned(),
    });
    let mut message = lines.collect::<Vec<_>>().join("\n");
    if source.command.config.is_none() && message.contains("there is no coordinate system") {
        message.push_str("\nthis is the default machine; --config FILE simulates another one");
    }
    message
}

/// One line of it.
fn in_line_of(said: &str, source: &Source<'_>) -> String {
    let Some((front, rest)) = said.split_once("line ") else {
        return said.to_owned();
    };
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let (digits, behind) = rest.split_at(end);
    // The column belongs to the generated program.
    let behind = match behind.strip_prefix(", column ") {
        Some(rest) => rest.trim_start_matches(|c: char| c.is_ascii_digit()),
        None => behind,
    };
    match digits.parse().map_or(0, |statement| source.line_of(statement)) {
        0 => said.to_owned(),
        line => format!("{front}line {line}{behind}"),
    }
}
