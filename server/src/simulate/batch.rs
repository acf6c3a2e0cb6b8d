//! `simulate --cases`: many runs in one process (docs/BATCHES.md).

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek as _, SeekFrom, Write};
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use arcline_cases::{Batch, BatchError, Defaults, Done, finished};

use super::output::is_standard_output;
use super::{SimulateArgs, cannot_write, is_l5x};
use crate::cli::{Failure, WRONG};

/// Runs the cases of a file. The exit code is 0 when every case was run, however it ended, and 2 when one could not be.
pub(super) fn run(args: &SimulateArgs, cases: &Path) -> Result<ExitCode, Failure> {
    if is_l5x(args.program()) {
        return Err(Failure::usage("--cases runs Structured Text, and no projects (.L5X)"));
    }
    let text = |path: &Path| path.to_str().map(str::to_owned);
    let trace = args.trace.as_deref().and_then(text);
    if trace.as_ref().is_some_and(|pattern| !pattern.contains("{case}")) {
        return Err(Failure::usage(
            "--trace: expected a name with {case} in it, so that each case has a file of its own",
        ));
    }
    let mut batch = Batch {
        defaults: Arc::new(Defaults {
            program: args.program.as_deref().and_then(text),
            config: args.config.as_deref().and_then(text),
            set: args.sets()?,
            seed: args.seed.unwrap_or_default(),
            until: args.seconds()?,
            policy: args.policy(),
            trace,
            signals: args.signals.clone(),
            every: args.every,
        }),
        first: args.batch.first,
        from: args.batch.from.max(args.batch.first),
        to: args.batch.to,
        jobs: args.batch.jobs.map_or_else(processors, usize::from),
        over: Arc::default(),
    };
    let cannot_read = |error: io::Error| Failure::usage(format!("{}: cannot be read: {error}", cases.display()));
    let input: Box<dyn BufRead + Send> = if is_standard_output(cases) {
        Box::new(BufReader::new(io::stdin()))
    } else {
        Box::new(BufReader::new(File::open(cases).map_err(cannot_read)?))
    };
    let output: Box<dyn Write + Send> = match &args.batch.output {
        None => Box::new(io::stdout()),
        Some(path) if args.batch.resume => Box::new(resumed(path, &mut batch)?),
        Some(path) => Box::new(File::create(path).map_err(|error| cannot_write(path, &error))?),
    };
    let shown = cases.display();
    let done = batch.run(input, output, &mut |outcome| {
        if outcome.end == "invalid" {
            let why = outcome.error.as_deref().unwrap_or_default();
            eprintln!("{shown}: {why}");
        }
        true
    });
    match done {
        Ok(Done { invalid: 0, .. }) => Ok(ExitCode::SUCCESS),
        Ok(Done { results, invalid }) => Err(Failure::new(
            WRONG,
            format!("{shown}: {invalid} of {results} cases could not be run"),
        )),
        Err(error @ BatchError::Read(_)) => Err(Failure::usage(format!("{shown}: {error}"))),
        Err(error) => Err(Failure::new(1, error.to_string())),
    }
}

/// The file of results, behind those that it has.
fn resumed(path: &Path, batch: &mut Batch) -> Result<File, Failure> {
    let cannot = |error: io::Error| cannot_write(path, &error);
    let open = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path);
    let mut file = open.map_err(cannot)?;
    let (count, bytes) = finished(BufReader::new(&file), batch.from)
        .map_err(|error| Failure::usage(format!("{}: {error}", path.display())))?;
    file.set_len(bytes).map_err(cannot)?;
    file.seek(SeekFrom::End(0)).map_err(cannot)?;
    batch.from += count;
    Ok(file)
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}
