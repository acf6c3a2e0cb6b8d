//! A batch: lines of cases in, results out in the same order, on several threads.
//!
//! The threads take one case after the other. A result that is ready before those ahead of it waits, and a thread that is too far ahead waits for the
//! slowest, so that few results are in memory at a time.

use std::any::Any;
use std::collections::{BTreeMap, HashSet};
use std::io::{self, BufRead, Read as _, Write};
use std::ops::Add;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crate::case::{Case, Invalid};
use crate::outcome::{DEFECT, INVALID, Outcome};
use crate::resume::{Finished, Other};
use crate::worker::{Defaults, Worker};

/// Longest line, bytes.
const LONGEST: u64 = 1 << 20;
/// How many cases a thread may be ahead of the first result that is missing.
const AHEAD: u64 = 256;
/// Largest number of a case from which a batch begins: JSON readers with 64-bit floats have all whole numbers up to here.
pub const LARGEST: u64 = 1 << 53;

/// How to run a batch.
#[derive(Debug)]
pub struct Batch {
    /// The values of keys that cases leave out.
    pub defaults: Arc<Defaults>,
    /// Number of the first case of the input: a part of a batch in a process of its own has the numbers, and so the seeds, of the whole.
    pub first: u64,
    /// The first case that is run.
    pub from: u64,
    /// The case behind the last; `None`: all.
    pub to: Option<u64>,
    /// Threads, 1 or more.
    pub jobs: usize,
    /// True ends the batch, at the present tick of the cases that run; these have no result.
    pub over: Arc<AtomicBool>,
    /// The results of the cases before `from`, behind which the batch continues; `None`: it begins.
    pub behind: Option<Finished>,
}

/// The results of a batch in numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Done {
    /// Results that were written.
    pub results: u64,
    /// Of those, cases that were not run.
    pub invalid: u64,
    /// Of those, cases that found a defect of Arcline ([`DEFECT`]).
    pub defects: u64,
    /// Of those, cases that were run and whose trace could not be written.
    pub untraced: u64,
}

impl Add for Done {
    type Output = Done;

    fn add(self, more: Done) -> Done {
        Done {
            results: self.results + more.results,
            invalid: self.invalid + more.invalid,
            defects: self.defects + more.defects,
            untraced: self.untraced + more.untraced,
        }
    }
}

/// Why a batch ended early.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// The cases cannot be read.
    #[error("the cases cannot be read: {0}")]
    Read(io::Error),
    /// The results cannot be written.
    #[error("the results cannot be written: {0}")]
    Write(io::Error),
    /// The results that are there are of another batch.
    #[error(transparent)]
    Other(#[from] Other),
    /// The first case has a number that is too large.
    #[error("the first case has the number {0}, expected at most {LARGEST}")]
    Number(u64),
    /// All cases would write one trace.
    #[error("the trace is {0:?}, expected a name with {{case}} in it, so that each case has a file of its own")]
    Trace(String),
}

/// The cases that have not been begun.
struct Cases<R> {
    input: R,
    /// The next case, and the line behind it.
    next: u64,
    line: u64,
    /// The traces that cases name themselves, without `{case}`.
    traces: HashSet<PathBuf>,
}

/// The results that have not been written.
struct Results<'t, W> {
    output: W,
    next: u64,
    waiting: BTreeMap<u64, Outcome>,
    tell: &'t mut (dyn FnMut(&Outcome) -> bool + Send),
    done: Done,
    failed: Option<BatchError>,
    /// No more is wanted, or it failed.
    is_over: bool,
}

impl Batch {
    /// Runs the cases of an input to its end. Each result is a line of the output, written when those before it are; `tell` sees it too, and ends the
    /// batch by false.
    ///
    /// # Errors
    /// See [`BatchError`]. Before the first result nothing is written.
    pub fn run<R: BufRead + Send, W: Write + Send>(
        &self,
        input: R,
        output: W,
        tell: &mut (dyn FnMut(&Outcome) -> bool + Send),
    ) -> Result<Done, BatchError> {
        self.run_with(input, output, tell, &Worker::run_line)
    }

    /// The same with another function that runs the case of a line.
    pub(crate) fn run_with<R: BufRead + Send, W: Write + Send>(
        &self,
        input: R,
        output: W,
        tell: &mut (dyn FnMut(&Outcome) -> bool + Send),
        run_line: &RunLine,
    ) -> Result<Done, BatchError> {
        let first = self.first.max(self.from);
        if first > LARGEST {
            return Err(BatchError::Number(first));
        }
        if let Some(trace) = self.defaults.trace.as_ref().filter(|trace| !trace.contains(CASE)) {
            return Err(BatchError::Trace(trace.clone()));
        }
        let mut cases = Cases {
            input,
            next: self.first,
            line: 0,
            traces: HashSet::new(),
        };
        if let Some(behind) = &self.behind {
            let last = cases.skip_to(self.from).map_err(BatchError::Read)?;
            behind.check(&mut Worker::new(self.defaults.clone()), last.as_deref())?;
        }
        let cases = Mutex::new(cases);
        let results = Mutex::new(Results {
            output,
            next: self.from.max(self.first),
            waiting: BTreeMap::new(),
            tell,
            done: Done::default(),
            failed: None,
            is_over: false,
        });
        let moved = Condvar::new();
        std::thread::scope(|scope| {
            for _ in 1..self.jobs.max(1) {
                scope.spawn(|| self.work(&cases, &results, &moved, run_line));
            }
            self.work(&cases, &results, &moved, run_line);
        });
        let results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
        results.failed.map_or(Ok(results.done), Err)
    }

    fn work<R: BufRead, W: Write>(
        &self,
        cases: &Mutex<Cases<R>>,
        results: &Mutex<Results<'_, W>>,
        moved: &Condvar,
        run_line: &RunLine,
    ) {
        let mut worker = Worker::until(self.defaults.clone(), self.over.clone());
        loop {
            let next = lock(cases).next(self.from, self.to);
            let (number, line_number, line) = match next {
                Ok(Some(next)) => next,
                Ok(None) => return,
                Err(error) => {
                    let mut results = lock(results);
                    results.failed.get_or_insert(BatchError::Read(error));
                    results.is_over = true;
                    moved.notify_all();
                    return;
                }
            };
            let outcome = match line {
                Ok(line) => {
                    let run = || run_line(&mut worker, number, line_number, &line);
                    catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| {
                        // The panic may have left its machines in between.
                        worker = Worker::until(self.defaults.clone(), self.over.clone());
                        Outcome::panicked(number, line_number, &line, text_of(&*panic))
                    })
                }
                Err(why) => Outcome::invalid(number, line_number, &why),
            };
            let mut results = lock(results);
            if self.over.load(Ordering::Relaxed) {
                results.is_over = true;
                moved.notify_all();
                return;
            }
            while !results.is_over && number >= results.next + AHEAD {
                results = moved.wait(results).unwrap_or_else(PoisonError::into_inner);
            }
            results.take(number, outcome);
            moved.notify_all();
            if results.is_over {
                return;
            }
        }
    }
}

/// Runs the case of a line: its number, its line in the file, and the line.
type RunLine = dyn Fn(&mut Worker, u64, u64, &str) -> Outcome + Sync;

/// The text of a panic.
fn text_of(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no text")
}

/// A case: its number, the line where it stands, and the line.
type Next = (u64, u64, Result<String, Invalid>);

impl<R: BufRead> Cases<R> {
    /// The next case from a number on; `None`: there are no more.
    fn next(&mut self, from: u64, to: Option<u64>) -> io::Result<Option<Next>> {
        while to.is_none_or(|to| self.next < to) {
            let Some(next) = self.read()? else { return Ok(None) };
            if next.0 >= from {
                return Ok(Some(next));
            }
        }
        Ok(None)
    }

    /// Skips the cases before a number. Returns the line of the last one; `None`: there are not so many, or it is no text.
    fn skip_to(&mut self, from: u64) -> io::Result<Option<String>> {
        let mut last = None;
        while self.next < from {
            let Some((_, _, line)) = self.read()? else {
                return Ok(None);
            };
            last = line.ok();
        }
        Ok(last)
    }

    /// Reads a case; `None`: there are no more.
    fn read(&mut self) -> io::Result<Option<Next>> {
        loop {
            let mut bytes = Vec::new();
            (&mut self.input).take(LONGEST).read_until(b'\n', &mut bytes)?;
            if bytes.is_empty() {
                return Ok(None);
            }
            self.line += 1;
            let is_long = bytes.len() as u64 == LONGEST && bytes.last() != Some(&b'\n');
            if is_long {
                self.input.skip_until(b'\n')?;
            }
            if bytes.trim_ascii().is_empty() {
                continue;
            }
            let number = self.next;
            self.next += 1;
            let line = if is_long {
                Err(Invalid(format!("the line is longer than {LONGEST} bytes")))
            } else {
                String::from_utf8(bytes).map_err(|_| Invalid("the line is not UTF-8".to_owned()))
            };
            let line = line.and_then(|line| self.claim_trace(&line).map(|()| line));
            return Ok(Some((number, self.line, line)));
        }
    }

    /// Takes the file of the trace that a case names for itself. The cases do it in their order, so that the same ones are refused on any number of
    /// threads.
    fn claim_trace(&mut self, line: &str) -> Result<(), Invalid> {
        if !line.contains("trace") {
            return Ok(());
        }
        // A line that is no case is refused when it is run.
        let trace = Case::parse(line).ok().and_then(|case| case.trace);
        let Some(trace) = trace.filter(|trace| !trace.contains(CASE)) else {
            return Ok(());
        };
        let parts = Path::new(&trace).components();
        let file = parts.filter(|part| *part != Component::CurDir).collect();
        if self.traces.insert(file) {
            return Ok(());
        }
        Err(Invalid(format!(
            "trace: an earlier case has written {trace}, expected another file, or {CASE} in its name"
        )))
    }
}

/// Stands for the number of the case in the name of a trace.
pub(crate) const CASE: &str = "{case}";

impl<W: Write> Results<'_, W> {
    /// Takes a result, and writes those whose turn it is.
    fn take(&mut self, number: u64, outcome: Outcome) {
        self.waiting.insert(number, outcome);
        while let Some(outcome) = self.waiting.remove(&self.next) {
            if self.is_over {
                return;
            }
            let mut line = outcome.line();
            line.push('\n');
            let written = self
                .output
                .write_all(line.as_bytes())
                .and_then(|()| self.output.flush());
            if let Err(error) = written {
                self.failed = Some(BatchError::Write(error));
                self.is_over = true;
                return;
            }
            self.next += 1;
            self.done.results += 1;
            self.done.invalid += u64::from(outcome.end == INVALID);
            self.done.defects += u64::from(outcome.end == DEFECT);
            self.done.untraced += u64::from(outcome.trace_error.is_some());
            if !(self.tell)(&outcome) {
                self.is_over = true;
                return;
            }
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
