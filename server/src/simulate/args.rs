//! The command line of `simulate`.

use std::path::{Path, PathBuf};

use arcline_cases::LARGEST;
use arcline_structured_text::{OnError, Policy, QueueFull};
use arcline_tag::WriteValue;
use clap::{Args, ValueEnum};

use crate::cli::{Failure, seconds};

/// Flags of `simulate`.
#[derive(Args, Debug)]
pub(crate) struct SimulateArgs {
    /// The program: Structured Text, or a project of a controller (.L5X) with its tasks. With --cases the program of cases that name none.
    #[arg(value_name = "PROGRAM.st|PROJECT.L5X", required_unless_present = "cases")]
    pub(crate) program: Option<PathBuf>,
    /// Read the program line by line, as it runs: each line has whole statements, `-` is standard input, and memory does not
    /// grow with its length.
    #[arg(long)]
    pub(crate) lines: bool,
    /// Configuration file; without it the embedded default is used.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Write the samples of every axis at every tick to this file, as CSV or MCAP; `-` is CSV on standard output. With --cases `{case}` in
    /// the name is the number of the case.
    #[arg(long, value_name = "OUT.csv|.mcap")]
    pub(crate) trace: Option<PathBuf>,
    /// Only these signals, such as X.CommandPosition,X.ActualPosition.
    #[arg(long, value_name = "SIGNAL,...", value_delimiter = ',', requires = "trace")]
    pub(crate) signals: Vec<String>,
    /// Only every nth tick.
    #[arg(long, value_name = "N", default_value = "1", requires = "trace", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) every: u64,
    /// Write every change of an instruction's status to this file, as JSON lines; `-` is standard output.
    #[arg(long, value_name = "OUT.jsonl")]
    pub(crate) events: Option<PathBuf>,
    /// Write every change of the faults of an axis to this file, as JSON lines; `-` is standard output.
    #[arg(long, value_name = "OUT.jsonl")]
    pub(crate) faults: Option<PathBuf>,
    /// Of Structured Text the longest simulated time, s (default 3600); of a project the expression of tags that ends the run.
    #[arg(long, value_name = "SECONDS|EXPRESSION")]
    pub(crate) until: Option<String>,
    /// Longest simulated time of a project, s (default 60).
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) max: Option<f64>,
    /// Give a tag this value before the first tick, or a key of the configuration, such as axis.X.max_speed=500. Repeat it for several.
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Write all tags of a project to this file at the end, as JSON; `-` is standard output.
    #[arg(long, value_name = "OUT.json")]
    pub(crate) tags: Option<PathBuf>,
    /// The seed of chance: of the times of faults that a case gives as a range; of a project the same as --scan-phase.
    #[arg(long, value_name = "SEED")]
    pub(crate) seed: Option<u64>,
    /// Print the result as one line of JSON.
    #[arg(long)]
    pub(crate) json: bool,
    /// Let a plant outside say where the axes are: at each tick a line of JSON with the set-points goes to standard output, and one with the feedback
    /// comes from standard input (docs/PLANTS.md).
    #[arg(long, conflicts_with_all = ["cases", "json"])]
    pub(crate) step: bool,
    #[command(flatten)]
    pub(crate) batch: BatchArgs,
    /// Let the scans of a project's continuous task fall in other ticks, to find races: same seed, same run.
    #[arg(long, value_name = "SEED")]
    pub(crate) scan_phase: Option<u64>,
    /// Run a project of which parts are missing or not supported: they are named and passed over.
    #[arg(long)]
    pub(crate) allow_missing: bool,
    /// Continue after an instruction has erred.
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Reaction of a coordinated move to a full queue.
    #[arg(long, value_enum, default_value_t = QueueFullWord::Wait)]
    pub(crate) queue_full: QueueFullWord,
}

/// Flags of `simulate` for many runs.
#[derive(Args, Debug)]
pub(crate) struct BatchArgs {
    /// Run many cases, one of each line of this file (JSON), in one process; `-` is standard input. The results are JSON lines in the order of the cases.
    #[arg(long, value_name = "CASES.jsonl", conflicts_with_all = ["lines", "events", "faults", "max", "tags", "scan_phase", "allow_missing"])]
    pub(crate) cases: Option<PathBuf>,
    /// Write the results to this file instead of standard output.
    #[arg(long, value_name = "OUT.jsonl", requires = "cases")]
    pub(crate) output: Option<PathBuf>,
    /// Go on behind the results that the file already has.
    #[arg(long, requires = "output")]
    pub(crate) resume: bool,
    /// Number of the first case of the file, when it is a part of a larger one: numbers and seeds are those of the whole.
    #[arg(long, value_name = "CASE", default_value = "0", requires = "cases", value_parser = clap::value_parser!(u64).range(..=LARGEST))]
    pub(crate) first: u64,
    /// The first case that is run, counted from 0.
    #[arg(long, value_name = "CASE", default_value = "0", requires = "cases", value_parser = clap::value_parser!(u64).range(..=LARGEST))]
    pub(crate) from: u64,
    /// The case behind the last.
    #[arg(long, value_name = "CASE", requires = "cases")]
    pub(crate) to: Option<u64>,
    /// Threads (default: one for each processor).
    #[arg(long, value_name = "N", requires = "cases", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
}

impl SimulateArgs {
    /// The program; an empty path: none, which only cases may have.
    pub(crate) fn program(&self) -> &Path {
        self.program.as_deref().unwrap_or(Path::new(""))
    }

    /// The program's reactions.
    pub(crate) fn policy(&self) -> Policy {
        Policy {
            queue_full: self.queue_full.into(),
            on_error: if self.keep_going {
                OnError::KeepGoing
            } else {
                OnError::Stop
            },
        }
    }

    /// The names and values of --set.
    pub(crate) fn sets(&self) -> Result<Vec<(String, WriteValue)>, Failure> {
        let pair = |set: &String| {
            let (name, value) = set.split_once('=')?;
            let Ok(value) = value.parse();
            Some((name.trim().to_owned(), value))
        };
        let pairs = self
            .set
            .iter()
            .map(|set| pair(set).ok_or_else(|| Failure::usage(format!("--set {set}: expected KEY=VALUE"))));
        pairs.collect()
    }

    /// The longest simulated time of Structured Text, s.
    pub(crate) fn seconds(&self) -> Result<f64, Failure> {
        self.until.as_deref().map_or(Ok(LONGEST), |text| {
            seconds(text).map_err(|expected| Failure::usage(format!("--until {text}: {expected}")))
        })
    }

    /// Checks that standard input and output are free for a plant.
    pub(crate) fn check_step(&self) -> Result<(), Failure> {
        let pipes = [
            (self.program.as_ref(), "the program"),
            (self.trace.as_ref(), "--trace"),
            (self.events.as_ref(), "--events"),
            (self.faults.as_ref(), "--faults"),
        ];
        let taken = pipes
            .into_iter()
            .find(|(path, _)| path.is_some_and(|path| path == Path::new("-")));
        match taken.filter(|_| self.step) {
            None => Ok(()),
            Some((_, what)) => Err(Failure::usage(format!(
                "--step needs standard input and output for the plant: {what} cannot be -"
            ))),
        }
    }

    /// The first flag that only projects have.
    pub(crate) fn of_projects(&self) -> Option<&'static str> {
        let given = [
            (self.max.is_some(), "--max"),
            (self.tags.is_some(), "--tags"),
            (self.scan_phase.is_some(), "--scan-phase"),
            (self.allow_missing, "--allow-missing"),
        ];
        given.into_iter().find_map(|(is_given, flag)| is_given.then_some(flag))
    }
}

/// The longest simulated time of Structured Text, s.
const LONGEST: f64 = 3600.0;

/// The reaction of a coordinated move that finds the queue full, as a word.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum QueueFullWord {
    /// The move waits for room.
    Wait,
    /// The move errs, as on a controller.
    Error,
}

impl From<QueueFullWord> for QueueFull {
    fn from(word: QueueFullWord) -> Self {
        match word {
            QueueFullWord::Wait => Self::Wait,
            QueueFullWord::Error => Self::Error,
        }
    }
}
