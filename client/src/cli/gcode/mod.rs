//! `gcode`: a program of lines and arcs, run by the server as Structured Text, simulated, or written to a file. `arcline-gcode` interprets its
//! words; `gcode::source` reads its file.

mod simulate;
mod source;

use std::fs::File;
use std::io::{self, BufWriter};

use serde_json::json;

use arcline_client::{Client, Event, Object, ProgramError, Runner};
use arcline_gcode::Options;

use super::args::{Gcode, Unit};
use super::output::{counted, is_standard_output};
use super::wait::{self, StopCommand};
use super::{Failure, Output};
use source::{Counts, Source};

/// Statements that are checked and run at a time.
const AT_A_TIME: usize = 1000;

/// `gcode` without a server: `--emit` and `--simulate`.
pub(crate) fn without_server(command: &Gcode, output: &Output) -> Result<(), Failure> {
    let options = Options {
        axes: usize::from(command.axes.unwrap_or(3)),
        start: start(command).unwrap_or_default(),
        inches: command.unit == Some(Unit::Inch),
        skip: command.skip.clone(),
    };
    let source = Source { command, options };
    let counts = source.counts()?;
    match &command.emit {
        Some(target) if is_standard_output(target) && output.is_json() => {
            let mut text = Vec::new();
            let written = source.write(&mut text)?;
            written.map_err(|error| Failure::at(target, error))?;
            output.result("", || json!({"text": String::from_utf8_lossy(&text)}));
        }
        Some(target) if is_standard_output(target) => {
            // A reader that has gone away (`| head`) is no error.
            let _ = source.write(&mut BufWriter::new(io::stdout().lock()))?;
        }
        Some(target) => {
            let failed = |error| Failure::at(target, error);
            let file = File::create(target).map_err(failed)?;
            source.write(&mut BufWriter::new(file))?.map_err(failed)?;
            let (shown, count) = (target.display().to_string(), counts.statements());
            output.result(
                format!("{shown}: {}", counted(count, "statement")),
                || json!({"program": shown, "statements": count}),
            );
        }
        None => simulate::simulate(&source, &counts, output)?,
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
    let source = Source { command, options };
    // The whole file, so that nothing moves when a line of it cannot be read.
    let counts = source.counts()?;
    let ran = tokio::select! {
        ran = pieces(client, &source, &counts, output) => ran,
        () = wait::interrupted() => {
            let stop = StopCommand::all(Object::CoordinateSystem, system.clone());
            return Err(wait::interrupt(client, stop, output).await);
        }
    };
    ran?;
    let (shown, count) = (command.file.display().to_string(), counts.moves());
    output.result(
        format!("{shown}: {}", counted(count, "move")),
        || json!({"program": shown, "moves": count}),
    );
    Ok(())
}

/// Runs the statements, a bounded number at a time, and waits for the end of the motion.
async fn pieces(client: &Client, source: &Source<'_>, counts: &Counts, output: &Output) -> Result<(), Failure> {
    let failed = |error: ProgramError| {
        let statement = match &error {
            ProgramError::Client { line, .. } => *line,
            ProgramError::Syntax(error) => error.line,
            ProgramError::Hopeless(error) => error.line,
            ProgramError::Runtime(error) => error.line,
        };
        Failure::Move {
            path: source.name(),
            line: source.line_of(statement),
            source: error,
        }
    };
    let progress = output.bar(counts.statements(), PROGRESS);
    let mut on_event = |event: Event<'_>| {
        // A move is executed up to a whole queue before it moves.
        if let Event::Completed { line } = event {
            progress.set_position(progress.position().max(line as u64));
        }
    };
    let mut steps = source.steps()?;
    let mut runner: Option<Runner<'_>> = None;
    let mut done = 0;
    loop {
        let mut text = String::new();
        let piece = steps.next_text(&mut text, AT_A_TIME)?;
        if piece == 0 {
            break;
        }
        let running = match &mut runner {
            None => runner.insert(Runner::program(client, &text).await.map_err(failed)?),
            Some(running) => {
                running.load(&text, done).await.map_err(failed)?;
                running
            }
        };
        running.run(&mut on_event).await.map_err(failed)?;
        done += piece;
    }
    if let Some(mut running) = runner {
        running.finish(&mut on_event).await.map_err(failed)?;
    }
    progress.finish_and_clear();
    Ok(())
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

/// The progress by statements with the time left.
const PROGRESS: &str = "{bar:30} {percent} %  {human_pos} of {human_len}  {eta} left";
