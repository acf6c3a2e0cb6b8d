//! The results that an ended batch has left in a file, and whether a batch may continue behind them.

use std::io::{self, BufRead};

use serde::Deserialize;
use serde_json::Value;

use crate::batch::Done;
use crate::outcome::{DEFECT, INVALID};
use crate::worker::Worker;

/// The results that a file has.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Finished {
    /// Their numbers.
    pub done: Done,
    /// Bytes of their lines. A last line without end is none of them.
    pub bytes: u64,
    last: Option<Kept>,
}

/// Why results are of another batch.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Other {
    /// A line has no result, or that of another case.
    #[error("line {line} is not the result of case {expected}: these are results of another batch")]
    Line {
        /// The line, from 1.
        line: u64,
        /// The case whose result it should be.
        expected: u64,
    },
    /// The last result is that of another case.
    #[error("the results are of another batch: that of case {case} has the {what} {found}, expected {expected}")]
    Value {
        /// Number of the case.
        case: u64,
        /// Name of the member.
        what: &'static str,
        /// Its value in the file.
        found: String,
        /// Its value in this batch.
        expected: String,
    },
    /// There are more results than cases.
    #[error("the results are of another batch: there is one of case {case}, and no such case")]
    Case {
        /// The last case with a result.
        case: u64,
    },
}

/// The members by which a result is known to be of a batch.
#[derive(Clone, PartialEq, Debug, Deserialize)]
struct Kept {
    case: u64,
    end: Option<String>,
    trace_error: Option<String>,
    id: Option<Value>,
    version: Option<String>,
    seed: Option<u64>,
    program: Option<String>,
    config: Option<String>,
}

/// Reads the results that a file has, if it can be read. The first one must be that of the case `from`.
///
/// # Errors
/// The lines are not the results of such a batch.
pub fn finished(mut file: impl BufRead, from: u64) -> io::Result<Result<Finished, Other>> {
    let mut finished = Finished::default();
    let mut line = Vec::new();
    loop {
        line.clear();
        file.read_until(b'\n', &mut line)?;
        let expected = from.saturating_add(finished.done.results);
        let other = Other::Line {
            line: finished.done.results + 1,
            expected,
        };
        if line.last() != Some(&b'\n') {
            let begin = format!("{{\"case\":{expected},");
            let is_result = line.starts_with(begin.as_bytes()) || begin.as_bytes().starts_with(&line);
            return Ok(if is_result { Ok(finished) } else { Err(other) });
        }
        let kept: Option<Kept> = serde_json::from_slice(&line).ok();
        let Some(kept) = kept.filter(|kept| kept.case == expected) else {
            return Ok(Err(other));
        };
        finished.done.results += 1;
        finished.done.invalid += u64::from(kept.end.as_deref() == Some(INVALID));
        finished.done.defects += u64::from(kept.end.as_deref() == Some(DEFECT));
        finished.done.untraced += u64::from(kept.trace_error.is_some());
        finished.bytes += line.len() as u64;
        finished.last = Some(kept);
    }
}

impl Finished {
    /// Checks that the last result is of this version and of the case of a line, as a worker would run it; `None`: there is no such case.
    pub(crate) fn check(&self, worker: &mut Worker, line: Option<&str>) -> Result<(), Other> {
        let Some(kept) = &self.last else { return Ok(()) };
        let case = kept.case;
        let Some(line) = line else {
            return Err(Other::Case { case });
        };
        let expected = worker.identify(case, line);
        let text = |value: &Option<Value>| value.as_ref().map_or_else(|| "none".to_owned(), Value::to_string);
        let number = |seed: Option<u64>| seed.map(|seed| seed.to_string());
        #[rustfmt::skip]
        let members = [
            ("id",      Some(text(&kept.id)),  Some(text(&expected.id))),
            ("version", kept.version.clone(),  Some(expected.version.to_owned())),
            ("seed",    number(kept.seed),     number(expected.seed)),
            ("program", kept.program.clone(),  expected.program),
            ("config",  kept.config.clone(),   expected.config),
        ];
        for (what, found, expected) in members {
            if let (Some(found), Some(expected)) = (found, expected)
                && found != expected
            {
                return Err(Other::Value {
                    case,
                    what,
                    found,
                    expected,
                });
            }
        }
        Ok(())
    }
}
