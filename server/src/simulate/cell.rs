//! `simulate Cell.L5X`: the project's own tasks beside its machine, tick by tick (spec/programs.md §14).
//!
//! In a tick the machine begins, then the tasks that are due run and call instructions of motion at this instant, then the
//! machine ends the tick. No other input enters, so two runs give the same bytes.

use std::process::ExitCode;
use std::time::Instant;

use arcline_cases::Outcome;
use arcline_routine::source::Project;
use arcline_routine::{Cell, Condition, Fault, Finding, Loaded};
use arcline_simulation::{Observer as _, Simulation};

use super::SimulateArgs;
use super::cannot_write;
use super::cell_tags;
use super::output::{Files, is_standard_output};
use super::plant::Plant;
use crate::cli::Failure;
use crate::live::{Names, Surroundings, UnknownParts, blocking, configuration};

/// Longest simulated time of a project, s.
const LONGEST: f64 = 60.0;

/// Runs a project until its condition holds.
pub(super) fn simulate(args: &SimulateArgs) -> Result<ExitCode, Failure> {
    // Deep projects need more stack than a thread has.
    std::thread::scope(|scope| {
        let run = std::thread::Builder::new().name("scan".to_owned()).stack_size(STACK);
        let run = run.spawn_scoped(scope, || run_project(args));
        match run.map(std::thread::ScopedJoinHandle::join) {
            Ok(Ok(result)) => result,
            Ok(Err(_)) => Err(Failure::new(1, "the simulation ended unexpectedly")),
            Err(error) => Err(Failure::new(1, format!("no thread for the simulation: {error}"))),
        }
    })
}

fn run_project(args: &SimulateArgs) -> Result<ExitCode, Failure> {
    let began = Instant::now();
    if args.step {
        return Err(Failure::usage(
            "--step is for programs in Structured Text, not for projects",
        ));
    }
    let file = args.program().display().to_string();
    let text = crate::l5x::read(args.program())?;
    let wrong = |error: arcline_l5x::L5xError| Failure::usage(error.to_string());
    let project = match &args.config {
        Some(config) => crate::cli::project(Some(config))?,
        None => configuration(args.program())?,
    };
    let mut source = arcline_l5x::logic(&text, &file).map_err(wrong)?;
    Surroundings::of(&project.server.controller).surround(&mut source);
    let machine = project.machine.clone();
    let mut plant = Plant::new(Simulation::of_project(&project));
    let unknown_parts = if args.allow_missing {
        UnknownParts::Allowed
    } else {
        UnknownParts::Refused
    };
    let loaded = plant.load(&source, unknown_parts);
    let Loaded { mut cell, findings, .. } = loaded.map_err(|error| Failure::usage(format!("{file}: {error}")))?;
    refuse(&file, &findings, unknown_parts)?;
    let until = args.until.as_deref().map(|text| {
        let condition = plant.with_names(|names| cell.condition(&source, names, text));
        condition.map_err(|reason| Failure::usage(format!("--until {text}: {reason}")))
    });
    let until = until.transpose()?;
    if let Some(seed) = args.scan_phase.or(args.seed) {
        cell.set_phase(seed);
    }
    let mut files = Files::create(args, &machine)?;
    let longest = args.max.unwrap_or(LONGEST);
    let setup = Setup {
        source: &source,
        sets: &args.set,
        until: until.as_ref(),
        longest,
    };
    let end = run(&mut cell, &mut plant, &setup, &mut files)?;
    if let Some(path) = &args.tags {
        let mut text = cell_tags::json(&cell, plant.time());
        text.push('\n');
        if is_standard_output(path) {
            crate::cli::print(&text)?;
        } else {
            std::fs::write(path, text).map_err(|error| cannot_write(path, &error))?;
        }
    }
    let measures = files.measures.take();
    let mut summary = files.finish(args)?;
    summary.executed = plant.executed();
    let is_done = matches!(end, End::Reached) || matches!(end, End::Time) && until.is_none();
    eprint!("{}", summary.text(&file, &machine, is_done));
    if let Some(measures) = measures {
        let (word, error) = match &end {
            End::Fault(fault) => ("fault", Some(fault.to_string())),
            End::Time if !is_done => ("timeout", None),
            _ => ("finished", None),
        };
        let outcome = Outcome {
            instructions: Some(plant.executed()),
            seed: args.scan_phase.or(args.seed),
            wall_s: Some(began.elapsed().as_secs_f64()),
            ..Outcome::ended(word, error, &measures, &machine)
        };
        crate::cli::print(&format!("{}\n", outcome.line()))?;
    }
    match end {
        End::Reached => Ok(ExitCode::SUCCESS),
        End::Time if until.is_none() => Ok(ExitCode::SUCCESS),
        End::Time => {
            let condition = args.until.as_deref().unwrap_or_default();
            Err(Failure::new(
                3,
                format!("{file}: {condition} did not become true in {longest} s of simulated time (--max)"),
            ))
        }
        End::Fault(fault) => Err(Failure::new(1, format!("{file}: {fault}, after {} s", plant.time()))),
    }
}

/// The parts of a project that do not run.
pub(crate) fn findings(text: &str, file: &str) -> Result<Vec<Finding>, Failure> {
    let wrong = |error: arcline_l5x::L5xError| Failure::usage(error.to_string());
    let import = arcline_l5x::import(text, file).map_err(wrong)?;
    let source = arcline_l5x::logic(text, file).map_err(wrong)?;
    let mut image = import.project.image();
    let mut names = Names::new(&import.project.machine, &mut image);
    Ok(arcline_routine::load(&source, &mut names).findings)
}

/// The settings of a run.
struct Setup<'a> {
    source: &'a Project,
    /// TAG=VALUE, written before the first scan.
    sets: &'a [String],
    until: Option<&'a Condition>,
    /// Longest simulated time, s.
    longest: f64,
}

/// The end of a run.
enum End {
    /// The condition became true.
    Reached,
    /// The time passed.
    Time,
    /// A major fault that no routine cleared.
    Fault(Fault),
}

fn run(cell: &mut Cell, plant: &mut Plant, setup: &Setup<'_>, files: &mut Files) -> Result<End, Failure> {
    files.begin(plant.machine());
    plant.begin_tick(cell);
    if let Err(fault) = cell.start(0, plant) {
        return Ok(End::Fault(fault));
    }
    set_tags(cell, plant, setup)?;
    let period = plant.machine().period_ns;
    loop {
        let scanned = cell.tick(plant.tick(), period, plant);
        plant.end_tick(cell, files);
        if let Err(fault) = scanned {
            return Ok(End::Fault(fault));
        }
        if setup.until.is_some_and(|condition| cell.holds(condition, plant)) {
            return Ok(End::Reached);
        }
        if plant.time() >= setup.longest {
            return Ok(End::Time);
        }
        plant.begin_tick(cell);
    }
}

/// Writes the values of `--set`.
fn set_tags(cell: &mut Cell, plant: &mut Plant, setup: &Setup<'_>) -> Result<(), Failure> {
    let mut given = Vec::new();
    for set in setup.sets {
        let (tag, value) = set
            .split_once('=')
            .ok_or_else(|| Failure::usage(format!("--set {set}: expected TAG=VALUE")))?;
        given.push((tag.trim(), value.trim()));
    }
    let writes = plant.with_names(|names| cell.writes(setup.source, names, &given));
    let writes = writes.map_err(|(tag, reason)| Failure::usage(format!("--set {tag}: {reason}")))?;
    let written = cell.write(&writes, plant);
    written.map_err(|tag| Failure::usage(format!("--set {tag}: it cannot be written")))
}

/// Refuses a project whose parts do not all run.
fn refuse(file: &str, findings: &[Finding], unknown_parts: UnknownParts) -> Result<(), Failure> {
    let count = blocking(findings, unknown_parts).count();
    for finding in findings.iter().take(SHOWN) {
        eprintln!("{file}: {finding}");
    }
    match blocking(findings, unknown_parts).next() {
        None => Ok(()),
        Some(first) => Err(Failure::usage(format!(
            "{file}: {first}; {count} parts of the project do not run"
        ))),
    }
}

/// Findings that are printed.
const SHOWN: usize = 50;
/// Stack of the thread that scans, bytes.
const STACK: usize = 256 << 20;
