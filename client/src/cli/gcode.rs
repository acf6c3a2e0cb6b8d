//! `gcode`: a program of lines and arcs, run by the server as Structured Text, simulated, or written down. What its words
//! mean is `arcline-gcode`'s.

use std::path::{Path, PathBuf};

use serde_json::json;

use arcline_client::{Client, Event, Object, ProgramError, Runner};
use arcline_gcode::{Motion, Options, Program, StructuredText};

use super::args::{Gcode, Unit};
use super::output::counted;
use super::wait::{self, StopCommand};
use super::{Failure, Output};

/// Statements that are checked and run at a time; a program of Structured Text has a largest size.
const AT_A_TIME: usize = 20_000;

/// `gcode` without a server: `--emit` and `--simulate`.
pub(crate) fn without_server(command: &Gcode, output: &Output) -> Result<(), Failure> {
    let options = Options {
        axes: usize::from(command.axes.unwrap_or(3)),
        start: start(command).unwrap_or_default(),
        inches: command.unit == Some(Unit::Inch),
        skip: command.skip.clone(),
    };
    let program = parse(command, &options)?;
    let made = program.structured_text(&command.system, &command.tag);
    match &command.emit {
        Some(target) if target == Path::new("-") => output.result(made.text.trim_end(), || json!({"text": made.text})),
        Some(target) => {
            std::fs::write(target, &made.text).map_err(|source| Failure::at(target, source))?;
            let (shown, count) = (target.display().to_string(), program.steps.len());
            output.result(
                format!("{shown}: {}", counted(count, "statement")),
                || json!({"program": shown, "statements": count}),
            );
        }
        None => simulate(command, &program, &made, output)?,
    }
    Ok(())
}

/// `gcode` on the machine.
pub(crate) async fn run(client: &Client, command: &Gcode, output: &Output) -> Result<(), Failure> {
    let system = &command.system;
    let axes = client.axes_of(system).await?;
    let mut options = Options {
        axes: command.axes.map_or(axes.len().min(3), usize::from),
        inches: match command.unit {
            Some(unit) => unit == Unit::Inch,
            None => axes.first().is_some_and(|axis| is_inch(&axis.units)),
        },
        skip: command.skip.clone(),
        ..Options::default()
    };
    options.start = match start(command) {
        Some(start) => start,
        None => {
            let mut start = [0.0; 3];
            for (coordinate, axis) in start.iter_mut().zip(&axes) {
                let position = client.read(&format!("{}.CommandPosition", axis.name)).await?;
                *coordinate = position.as_f64().unwrap_or_default();
            }
            start
        }
    };
    let program = parse(command, &options)?;
    let made = program.structured_text(system, &command.tag);
    let ran = tokio::select! {
        ran = pieces(client, command, &made, output) => ran,
        () = wait::interrupted() => {
            let stop = StopCommand::all(Object::CoordinateSystem, system.clone());
            return Err(wait::interrupt(client, stop, output).await);
        }
    };
    ran?;
    let (shown, count) = (command.file.display().to_string(), moves(&program));
    output.result(
        format!("{shown}: {}", counted(count, "move")),
        || json!({"program": shown, "moves": count}),
    );
    Ok(())
}

/// Runs the statements, so many at a time, and waits for the end of the motion.
async fn pieces(client: &Client, command: &Gcode, made: &StructuredText, output: &Output) -> Result<(), Failure> {
    let statements: Vec<&str> = made.text.lines().collect();
    let mut done = 0;
    for piece in statements.chunks(AT_A_TIME) {
        let of_line = |line: usize| {
            made.lines
                .get(done + line.saturating_sub(1))
                .copied()
                .unwrap_or_default()
        };
        let failed = |source: ProgramError| {
            let line = match &source {
                ProgramError::Client { line, .. } => of_line(*line),
                ProgramError::Syntax(error) => of_line(error.line),
                ProgramError::Hopeless(error) => of_line(error.line),
                ProgramError::Runtime(_) => of_line(1),
            };
            let path = command.file.display().to_string();
            Failure::Move { path, line, source }
        };
        let mut runner = Runner::program(client, &piece.join("\n")).await.map_err(failed)?;
        let mut on_event = |event: Event<'_>| {
            if let Event::Executed { line, execution } = event
                && output.is_watched()
            {
                output.note(&format!("line {}: {}", of_line(line), execution.mnemonic));
            }
        };
        runner.run(&mut on_event).await.map_err(failed)?;
        if done + piece.len() == statements.len() {
            runner.finish(&mut on_event).await.map_err(failed)?;
        }
        done += piece.len();
    }
    Ok(())
}

/// Runs it by `arcline-server simulate`, and reports its duration and its limits from the events and the trace.
fn simulate(command: &Gcode, program: &Program, made: &StructuredText, output: &Output) -> Result<(), Failure> {
    let folder = tempfile::tempdir().map_err(|source| Failure::at(&std::env::temp_dir(), source))?;
    let text = folder.path().join("program.st");
    std::fs::write(&text, &made.text).map_err(|source| Failure::at(&text, source))?;
    let events = command
        .events
        .clone()
        .unwrap_or_else(|| folder.path().join("events.jsonl"));
    let server = server_program();
    let mut simulation = std::process::Command::new(&server);
    simulation.arg("simulate").arg(&text).arg("--events").arg(&events);
    for (flag, file) in [("--config", &command.config), ("--trace", &command.trace)] {
        if let Some(file) = file {
            simulation.arg(flag).arg(file);
        }
    }
    let ran = simulation.output().map_err(|source| Failure::at(&server, source))?;
    if !ran.status.success() {
        let said = String::from_utf8_lossy(&ran.stderr);
        return Err(Failure::Simulate {
            said: in_lines_of(&said, &text, command, made),
            code: ran.status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1),
        });
    }
    let log = std::fs::read_to_string(&events).map_err(|source| Failure::at(&events, source))?;
    let seconds = log.lines().last().and_then(|line| {
        let event: serde_json::Value = serde_json::from_str(line).ok()?;
        event["time_s"].as_f64()
    });
    let seconds = seconds.unwrap_or_default();
    let (shown, moves) = (command.file.display().to_string(), moves(program));
    let (lines, arcs) = (count(program, false), count(program, true));
    let [all, straight, round] = [(moves, "move"), (lines, "line"), (arcs, "arc")].map(|(n, noun)| counted(n, noun));
    output.result(
        format!("{shown}: {all} ({straight}, {round}) in {seconds:.3} s"),
        || json!({"program": shown, "moves": moves, "lines": lines, "arcs": arcs, "seconds": seconds}),
    );
    Ok(())
}

/// The message of the simulation, with the file and line of the G-code in place of those of the generated program.
fn in_lines_of(said: &str, text: &Path, command: &Gcode, made: &StructuredText) -> String {
    let said = said.replace(&text.display().to_string(), &command.file.display().to_string());
    let lines = said
        .trim()
        .lines()
        .map(|line| line.trim_start_matches("arcline-server: "));
    // An excerpt of the program that was made says nothing about the G-code.
    let lines = lines.filter(|line| !line.starts_with(' '));
    let told: Vec<String> = lines.map(|line| in_line_of(line, made)).collect();
    let mut told = told.join("\n");
    if command.config.is_none() && told.contains("there is no coordinate system") {
        told.push_str("\nthis is the default machine; --config FILE simulates another one");
    }
    told
}

/// One line of it.
fn in_line_of(said: &str, made: &StructuredText) -> String {
    let Some((front, rest)) = said.split_once("line ") else {
        return said.to_owned();
    };
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let (digits, behind) = rest.split_at(end);
    let line = digits
        .parse::<usize>()
        .ok()
        .and_then(|line| made.lines.get(line.checked_sub(1)?));
    // The column belongs to the generated program.
    let behind = match behind.strip_prefix(", column ") {
        Some(rest) => rest.trim_start_matches(|c: char| c.is_ascii_digit()),
        None => behind,
    };
    match line {
        Some(line) => format!("{front}line {line}{behind}"),
        None => said.to_owned(),
    }
}

/// `arcline-server` beside this program, or wherever the system finds it.
fn server_program() -> PathBuf {
    let name = format!("arcline-server{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe()
        .ok()
        .map(|program| program.with_file_name(&name));
    beside
        .filter(|path| path.is_file())
        .unwrap_or_else(|| PathBuf::from(name))
}

fn parse(command: &Gcode, options: &Options) -> Result<Program, Failure> {
    let bytes = std::fs::read(&command.file).map_err(|source| Failure::at(&command.file, source))?;
    // A comment may be in any code page.
    let text = String::from_utf8_lossy(&bytes);
    Program::parse(&text, options).map_err(|source| Failure::Gcode {
        path: command.file.display().to_string(),
        source,
    })
}

fn start(command: &Gcode) -> Option<[f64; 3]> {
    let given = command.start.as_ref()?;
    let mut start = [0.0; 3];
    for (coordinate, number) in start.iter_mut().zip(&given.0) {
        *coordinate = *number;
    }
    Some(start)
}

fn is_inch(units: &str) -> bool {
    ["in", "inch", "inches", "\""]
        .iter()
        .any(|inch| units.eq_ignore_ascii_case(inch))
}

fn moves(program: &Program) -> usize {
    count(program, false) + count(program, true)
}

fn count(program: &Program, arcs: bool) -> usize {
    let wanted = |motion: &Motion| match motion {
        Motion::Line { .. } => !arcs,
        Motion::Arc { .. } => arcs,
        Motion::Dwell { .. } => false,
    };
    program.steps.iter().filter(|step| wanted(&step.motion)).count()
}
