//! Tests of the programs, as users start them.
//!
//! This library is their common ground. It finds the programs ([`programs`]), runs a server for the length of a test ([`server`]) and
//! the command line ([`command_line`], [`terminal`]), the pages of the guide ([`guide`]), foreign clients ([`interop`], [`python`],
//! [`node`], [`libplctag`], through a [`tunnel`] to a [`secured`] server) and a browser ([`browser`]), exchanges data in cycles ([`scanner`]), asks much at a time ([`load`]), looks at what that does to the ticks ([`lateness`]) and
//! records the traffic of the loopback interface ([`capture`]).
//!
//! `tests/programs` needs nothing but the programs. `tests/foreign` needs programs of others and `tests/load` the machine for itself;
//! `cargo test` runs these two only by name. A test that lacks a program says so by [`not_run`].
#![forbid(unsafe_code)]

use std::io::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

pub use arcline_tests::{fixture, workspace};

pub mod bare;
pub mod browser;
pub mod capture;
pub mod command_line;
pub mod foreign;
pub mod gcode;
pub mod guide;
pub mod interop;
pub mod lateness;
pub mod libplctag;
pub mod load;
pub mod node;
pub mod programs;
pub mod python;
pub mod scanner;
pub mod secured;
pub mod server;
pub mod terminal;
pub mod tunnel;

/// Whether this is a run of the project's CI, where nothing may be missing.
#[must_use]
pub fn in_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| value == "true" || value == "1")
}

/// Says on the terminal that `what` cannot be tested here and why, and how many tests of this process could not run. Adds a line to
/// `target/not-run.txt`, which `.ci/run` counts at its end.
///
/// # Panics
/// In CI, where a missing program is a failure.
pub fn not_run(what: &str, why: &str) {
    assert!(!in_ci(), "{what}: cannot run, and CI must run everything: {why}");
    not_granted(what, why);
}

/// The same for what a machine may refuse to a test although everything is installed, as to trace a process or to mount a file system. It is
/// said and counted, in CI too, and is not a failure there.
pub fn not_granted(what: &str, why: &str) {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed) + 1;
    // The test harness captures what `println!` and `eprintln!` write, and shows it only when a test fails; not what is written to the
    // handle itself.
    let _ = writeln!(std::io::stderr(), "NOT RUN ({count} so far): {what}: {why}");
    let file = programs::target_directory().join("not-run.txt");
    let file = std::fs::OpenOptions::new().create(true).append(true).open(file);
    let _ = file.and_then(|mut file| writeln!(file, "{what}: {why}"));
}

/// Calls `condition` until it gives a value.
///
/// # Panics
/// With `what` in the message, when it has given none before `limit` has passed.
pub fn eventually<T>(what: &str, limit: Duration, mut condition: impl FnMut() -> Option<T>) -> T {
    const PAUSE: Duration = Duration::from_millis(2);
    let deadline = Instant::now() + limit;
    loop {
        if let Some(value) = condition() {
            return value;
        }
        assert!(Instant::now() < deadline, "{what}: not within {limit:?}");
        std::thread::sleep(PAUSE);
    }
}
