//! `simulate --cases`: many runs in one process (docs/BATCHES.md).

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek as _, SeekFrom, Write};
use std::num::NonZeroUsize;
use std::os::fd::AsFd as _;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use arcline_cases::{Batch, BatchError, DEFECT, Defaults, Done, INVALID, finished};

use super::output::is_standard_output;
use super::{SimulateArgs, cannot_write, is_l5x};
use crate::cli::{Failure, WRONG};

/// Runs the cases of a file. The exit code is 0 when every case was run, however it ended, 2 when one could not be, and 1 when a result or a trace could
/// not be written or a case found a defect of Arcline. The results of a batch that is continued count too.
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
        behind: None,
    };
    let cannot_read = |error: io::Error| Failure::usage(format!("{}: cannot be read: {error}", cases.display()));
    let input: Box<dyn BufRead + Send> = if is_standard_output(cases) {
        Box::new(BufReader::new(io::stdin()))
    } else {
        Box::new(BufReader::new(File::open(cases).map_err(cannot_read)?))
    };
    if let Some(output) = &args.batch.output {
        check_output(args, cases, output)?;
    }
    let output: Box<dyn Write + Send> = match &args.batch.output {
        None => Box::new(io::stdout()),
        Some(path) if args.batch.resume => Box::new(resumed(path, &mut batch)?),
        Some(path) => Box::new(File::create(path).map_err(|error| cannot_write(path, &error))?),
    };
    let shown = cases.display();
    let done = batch.run(input, output, &mut |outcome| {
        if [INVALID, DEFECT].contains(&outcome.end) {
            let why = outcome.error.as_deref().unwrap_or_default();
            eprintln!("{shown}: {why}");
        }
        if let (Some(why), Some(case)) = (&outcome.trace_error, outcome.case) {
            eprintln!("{shown}: the trace of case {case} {why}");
        }
        true
    });
    let before = batch.behind.map(|behind| behind.done).unwrap_or_default();
    let done = done.map_err(|error| match (&error, &args.batch.output) {
        (BatchError::Write(_), _) => Failure::new(1, error.to_string()),
        (BatchError::Other(_), Some(output)) => Failure::usage(format!("{}: {error}", output.display())),
        _ => Failure::usage(format!("{shown}: {error}")),
    })?;
    let Done {
        results,
        invalid,
        defects,
        untraced,
    } = before + done;
    if invalid > 0 {
        let text = format!("{shown}: {invalid} of {results} cases could not be run");
        return Err(Failure::new(WRONG, text));
    }
    if defects > 0 {
        let text = format!("{shown}: {defects} of {results} cases found a defect of Arcline");
        return Err(Failure::new(1, text));
    }
    if untraced > 0 {
        let text = format!("{shown}: {untraced} of {results} traces could not be written");
        return Err(Failure::new(1, text));
    }
    Ok(ExitCode::SUCCESS)
}

/// Checks that the file of the results is none of those that the batch reads.
fn check_output(args: &SimulateArgs, cases: &Path, output: &Path) -> Result<(), Failure> {
    let identity = |file: Metadata| (file.dev(), file.ino());
    // A new file is none of them, and a device loses nothing.
    let Some(results) = output.metadata().ok().filter(Metadata::is_file) else {
        return Ok(());
    };
    let results = identity(results);
    let standard_input = || File::from(io::stdin().as_fd().try_clone_to_owned()?).metadata();
    let inputs = [
        ("cases", Some(cases)),
        ("program", args.program.as_deref()),
        ("configuration", args.config.as_deref()),
    ];
    for (what, path) in inputs {
        let Some(path) = path else { continue };
        let input = if is_standard_output(path) {
            standard_input()
        } else {
            path.metadata()
        };
        if input.is_ok_and(|input| identity(input) == results) {
            let (output, shown) = (output.display(), path.display());
            return Err(Failure::usage(format!(
                "--output {output}: this is the file of the {what} ({shown}), expected another one"
            )));
        }
    }
    Ok(())
}

/// The file of results, behind those that it has.
fn resumed(path: &Path, batch: &mut Batch) -> Result<Behind, Failure> {
    let cannot = |error: io::Error| cannot_write(path, &error);
    let open = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path);
    let file = open.map_err(cannot)?;
    let behind = finished(BufReader::new(&file), batch.from).map_err(cannot)?;
    let behind = behind.map_err(|error| Failure::usage(format!("{}: {error}", path.display())))?;
    let end = behind.bytes;
    batch.from += behind.done.results;
    batch.behind = Some(behind);
    Ok(Behind { file, end: Some(end) })
}

/// A file that is written behind its whole lines, and stays as it is until then.
struct Behind {
    file: File,
    /// The end of these lines, before the first write.
    end: Option<u64>,
}

impl Write for Behind {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(end) = self.end {
            self.file.set_len(end)?;
            self.file.seek(SeekFrom::Start(end))?;
            self.end = None;
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}
