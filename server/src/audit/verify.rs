//! `arcline-server audit verify`: checks that the lines of an audit are the written ones, in their order.
//!
//! A chain reveals every line that was changed, removed, added or moved, except at the end: only a hash that is stored elsewhere (`--head`)
//! reveals missing lines there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Subcommand;
use serde_json::Value;

use super::chain;
use super::file::numbered;
use crate::cli::{Failure, print};

/// The commands.
#[derive(Subcommand, Debug)]
pub(crate) enum AuditCommand {
    /// Check the chain of all lines; exit code 3 at the first one that does not fit.
    Verify {
        /// The folder of the audit.
        #[arg(value_name = "FOLDER")]
        folder: PathBuf,
        /// The hash of a line that must be there, as the log shows it every minute.
        #[arg(long, value_name = "HEX")]
        head: Option<String>,
    },
}

/// Runs a command.
pub(crate) fn run(command: &AuditCommand) -> Result<ExitCode, Failure> {
    let AuditCommand::Verify { folder, head } = command;
    match verify(folder, head.as_deref()) {
        Ok(verified) => print(&format!(
            "{} lines, from {} to {}; the hash of the last one is {}\n",
            verified.lines, verified.first, verified.last, verified.head
        )),
        Err(Broken::Read { file, error }) => Err(Failure::usage(format!("{}: {error}", file.display()))),
        Err(broken) => Err(Failure::new(BROKEN, broken.to_string())),
    }
}

/// The exit code of a chain that is broken.
const BROKEN: u8 = 3;

/// A chain that holds.
#[derive(PartialEq, Eq, Debug)]
pub(super) struct Verified {
    /// Lines.
    pub(super) lines: u64,
    /// The number of the first line in the files.
    pub(super) first: u64,
    /// The number of the last one.
    pub(super) last: u64,
    /// Its hash.
    pub(super) head: String,
}

/// The error of a chain.
#[derive(Debug, thiserror::Error)]
pub(super) enum Broken {
    /// A file cannot be read.
    #[error("{}: {error}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        error: io::Error,
    },
    /// A line is not the one that was written there.
    #[error("{}, line {line}: n = {n} does not fit: {reason}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// The line in it, from 1.
        line: usize,
        /// The number that belongs there.
        n: u64,
        /// The error in the line.
        reason: &'static str,
    },
    /// No line has the hash.
    #[error("no line has the hash {head}: lines are missing at the end")]
    Head {
        /// The hash.
        head: String,
    },
}

/// Checks all lines of a folder.
pub(super) fn verify(folder: &Path, head: Option<&str>) -> Result<Verified, Broken> {
    let read = |file: &Path| {
        let file = file.to_owned();
        move |error| Broken::Read { file, error }
    };
    let files = numbered(folder).map_err(read(folder))?;
    let mut verified: Option<Verified> = None;
    let mut has_head = head.is_none();
    for (_, file) in &files {
        let bytes = fs::read(file).map_err(read(file))?;
        let text = String::from_utf8_lossy(&bytes);
        for (line, text) in (1..).zip(text.lines()) {
            let next = verified.as_ref().map(|verified| verified.last + 1);
            let wrong = |n: Option<u64>, reason| Broken::Line {
                file: file.clone(),
                line,
                n: next.or(n).unwrap_or(1),
                reason,
            };
            let of: Value = serde_json::from_str(text).map_err(|_| wrong(None, "it is no JSON"))?;
            let n = of["n"].as_u64().ok_or_else(|| wrong(None, "it has no number"))?;
            let prev = of["prev"].as_str().unwrap_or_default();
            match &verified {
                Some(before) if n != before.last + 1 => return Err(wrong(Some(n), "another number stands there")),
                Some(before) if prev != before.head => return Err(wrong(Some(n), "the line before has another hash")),
                None if n == 1 && prev != chain::first() => return Err(wrong(Some(n), "the first line has no zeros")),
                _ => {}
            }
            let hash = chain::hash(text.as_bytes());
            has_head |= head.is_some_and(|head| head.eq_ignore_ascii_case(&hash));
            let first = verified.as_ref().map_or(n, |verified| verified.first);
            let lines = verified.as_ref().map_or(1, |verified| verified.lines + 1);
            verified = Some(Verified {
                lines,
                first,
                last: n,
                head: hash,
            });
        }
    }
    match head {
        Some(head) if !has_head => Err(Broken::Head { head: head.to_owned() }),
        _ => Ok(verified.unwrap_or(Verified {
            lines: 0,
            first: 0,
            last: 0,
            head: chain::first(),
        })),
    }
}
