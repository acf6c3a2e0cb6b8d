//! `simulate Cell.L5X`: the project's own tasks beside its machine, tick by tick (spec/programs.md §14; `arcline-cell`).

use std::process::ExitCode;
use std::time::Instant;

use arcline_cases::Outcome;
use arcline_cell::{End, LoadError, Names, RunLimits, SimulatedCell, UnknownParts, told};
use arcline_routine::Finding;

use super::SimulateArgs;
use super::cannot_write;
use super::output::{Files, is_standard_output};
use crate::cli::Failure;
use crate::live::configuration;

/// Longest simulated time of a project, s.
const LONGEST: f64 = 60.0;

/// Runs a project until its condition holds.
pub(super) fn simulate(args: &SimulateArgs) -> Result<ExitCode, Failure> {
    // Deep projects need more stack than a thread has.
    std::thread::scope(|scope| {
        let run = std::thread::Builder::new()
            .name("scan".to_owned())
            .stack_size(arcline_routine::STACK);
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
    let source = arcline_l5x::logic(&text, &file).map_err(wrong)?;
    let machine = project.machine.clone();
    let unknown_parts = if args.allow_missing {
        UnknownParts::Allowed
    } else {
        UnknownParts::Refused
    };
    let loaded = SimulatedCell::load(&project, source, unknown_parts);
    let mut cell = loaded.map_err(|error| not_loaded(&file, &error))?;
    show(&file, cell.findings());
    let until = args.until.as_deref().map(|text| {
        let condition = cell.condition(text);
        condition.map_err(|reason| Failure::usage(format!("--until {text}: {reason}")))
    });
    let until = until.transpose()?;
    if let Some(seed) = args.scan_phase.or(args.seed) {
        cell.set_phase(seed);
    }
    let mut files = Files::create(args, &machine)?;
    let longest = args.max.unwrap_or(LONGEST);
    let limits = RunLimits {
        until: until.as_ref(),
        ticks: u64::MAX,
        time: longest,
    };
    let end = match cell.begin(&mut files) {
        Err(fault) => End::Fault(fault),
        Ok(()) => {
            set_tags(&mut cell, &args.set)?;
            cell.run(limits, &mut files)
        }
    };
    if let Some(path) = &args.tags {
        let mut text = cell.tags_json();
        text.push('\n');
        if is_standard_output(path) {
            crate::cli::print(&text)?;
        } else {
            std::fs::write(path, text).map_err(|error| cannot_write(path, &error))?;
        }
    }
    let measures = files.measures.take();
    let mut summary = files.finish(args)?;
    summary.executed = cell.simulation().executed();
    let is_done = matches!(end, End::Reached) || matches!(end, End::Time) && until.is_none();
    eprint!("{}", summary.text(&file, &machine, is_done));
    if let Some(measures) = measures {
        let (word, error) = match &end {
            End::Fault(fault) => ("fault", Some(fault.to_string())),
            End::Time if !is_done => ("timeout", None),
            _ => ("finished", None),
        };
        let outcome = Outcome {
            instructions: Some(cell.simulation().executed()),
            seed: args.scan_phase.or(args.seed),
            wall_s: Some(began.elapsed().as_secs_f64()),
            ..Outcome::ended(word, error, &measures, &machine)
        };
        crate::cli::print(&format!("{}\n", outcome.line()))?;
    }
    match end {
        End::Reached => Ok(ExitCode::SUCCESS),
        // Files take everything.
        End::Left => Ok(ExitCode::SUCCESS),
        End::Time if until.is_none() => Ok(ExitCode::SUCCESS),
        End::Time => {
            let condition = args.until.as_deref().unwrap_or_default();
            Err(Failure::new(
                3,
                format!("{file}: {condition} did not become true in {longest} s of simulated time (--max)"),
            ))
        }
        End::Fault(fault) => Err(Failure::new(1, format!("{file}: {fault}, after {} s", cell.time()))),
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

/// Writes the values of `--set`.
fn set_tags(cell: &mut SimulatedCell, sets: &[String]) -> Result<(), Failure> {
    let mut given = Vec::new();
    for set in sets {
        let (tag, value) = set
            .split_once('=')
            .ok_or_else(|| Failure::usage(format!("--set {set}: expected TAG=VALUE")))?;
        given.push((tag.trim(), value.trim()));
    }
    let set = cell.set(&given);
    set.map_err(|error| Failure::usage(format!("--set {error}")))
}

/// The failure of a project that does not run, with its findings.
fn not_loaded(file: &str, error: &LoadError) -> Failure {
    match error {
        LoadError::Parts(parts) => {
            show(file, &parts.findings);
            Failure::usage(format!("{file}: {}", parts.summary()))
        }
        LoadError::Tag(error) => Failure::usage(format!("{file}: {error}")),
    }
}

fn show(file: &str, findings: &[Finding]) {
    for line in told(findings) {
        eprintln!("{file}: {line}");
    }
}
