//! A batch: lines of cases in, results out in the same order, on several threads.
//!
//! The threads take one case after the other. A result that is ready before those ahead of it waits, and a thread that is too far ahead waits for the
//! slowest, so that few results are in memory at a time.

use std::collections::BTreeMap;
use std::io::{self, BufRead, Read as _, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crate::case::Invalid;
use crate::outcome::Outcome;
use crate::worker::{Defaults, Worker};

/// Longest line, bytes.
const LONGEST: u64 = 1 << 20;
/// How many cases a thread may be ahead of the first result that is missing.
const AHEAD: u64 = 256;

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
}

/// The results of a batch in numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Done {
    /// Results that were written.
    pub results: u64,
    /// Of those, cases that were not run.
    pub invalid: u64,
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
    /// The results that are there are of other cases.
    #[error("{0}")]
    Other(String),
}

/// The cases that have not been begun.
struct Cases<R> {
    input: R,
    /// The next case, and the line behind it.
    next: u64,
    line: u64,
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
    /// The input cannot be read, or the output not written.
    pub fn run<R: BufRead + Send, W: Write + Send>(
        &self,
        input: R,
        output: W,
        tell: &mut (dyn FnMut(&Outcome) -> bool + Send),
    ) -> Result<Done, BatchError> {
        let cases = Mutex::new(Cases {
            input,
            next: self.first,
            line: 0,
        });
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
                scope.spawn(|| self.work(&cases, &results, &moved));
            }
            self.work(&cases, &results, &moved);
        });
        let results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
        results.failed.map_or(Ok(results.done), Err)
    }

    fn work<R: BufRead, W: Write>(&self, cases: &Mutex<Cases<R>>, results: &Mutex<Results<'_, W>>, moved: &Condvar) {
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
                Ok(line) => worker.run_line(number, line_number, &line),
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

/// A case: its number, the line where it stands, and the line.
type Next = (u64, u64, Result<String, Invalid>);

impl<R: BufRead> Cases<R> {
    /// The next case; `None`: there are no more.
    fn next(&mut self, from: u64, to: Option<u64>) -> io::Result<Option<Next>> {
        loop {
            if to.is_some_and(|to| self.next >= to) {
                return Ok(None);
            }
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
            if number < from {
                continue;
            }
            let line = if is_long {
                Err(Invalid(format!("the line is longer than {LONGEST} bytes")))
            } else {
                String::from_utf8(bytes).map_err(|_| Invalid("the line is not UTF-8".to_owned()))
            };
            return Ok(Some((number, self.line, line)));
        }
    }
}

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
            self.done.invalid += u64::from(outcome.end == "invalid");
            if !(self.tell)(&outcome) {
                self.is_over = true;
                return;
            }
        }
    }
}

/// How many results a file has, and the bytes of their lines: a last line without end is none. The first one must be that of the case `from`.
///
/// # Errors
/// The file cannot be read, or its lines are not the results of such a batch.
pub fn finished(file: impl BufRead, from: u64) -> Result<(u64, u64), BatchError> {
    let (mut count, mut bytes) = (0, 0);
    let mut file = file;
    let mut line = Vec::new();
    loop {
        line.clear();
        file.read_until(b'\n', &mut line).map_err(BatchError::Read)?;
        if line.last() != Some(&b'\n') {
            return Ok((count, bytes));
        }
        let result: Option<serde_json::Value> = serde_json::from_slice(&line).ok();
        let case = result.and_then(|result| result.get("case").and_then(serde_json::Value::as_u64));
        if case != Some(from + count) {
            let place = count + 1;
            let expected = from + count;
            return Err(BatchError::Other(format!(
                "line {place} is not the result of case {expected}: these are results of another batch"
            )));
        }
        count += 1;
        bytes += line.len() as u64;
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
