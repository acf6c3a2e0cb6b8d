//! Tests of the whole: what no single crate can test.
//!
//! This library is their common ground. It runs Structured Text on a controller tick by tick ([`mod@bench`]), finds
//! the programs ([`programs`]), runs a server for the length of a test ([`server`]), runs foreign clients
//! ([`python`], [`node`], [`libplctag`]) and a browser ([`browser`]), exchanges data in cycles ([`scanner`]), asks much at
//! a time ([`load`]) and records what goes over the loopback interface ([`capture`]). It holds no tests and knows nothing
//! of motion; the tests are in `tests/tests`.
//!
//! What a test needs and cannot have is said by [`not_run`]: a printed line on a developer's machine, a failure
//! where `CI` is set. No test is ever ignored silently.
#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub mod bare;
pub mod bench;
pub mod browser;
pub mod capture;
pub mod command_line;
pub mod follow;
pub mod foreign;
pub mod interop;
pub mod libplctag;
pub mod load;
pub mod node;
pub mod programs;
pub mod python;
pub mod random;
pub mod robot_programs;
pub mod robots;
pub mod scanner;
pub mod server;
pub mod terminal;
mod trace;

/// The root folder of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the tests package is a folder of the workspace")
}

/// A file of this package, such as `config/seeds.toml`.
#[must_use]
pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Whether this is a run of the project's CI, where nothing may be missing.
#[must_use]
pub fn in_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| value == "true" || value == "1")
}

/// Says that `what` cannot be tested here and why.
///
/// # Panics
/// In CI, where a missing program is a failure.
pub fn not_run(what: &str, why: &str) {
    assert!(!in_ci(), "{what}: cannot run, and CI must run everything: {why}");
    println!("NOT RUN: {what}: {why}");
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
