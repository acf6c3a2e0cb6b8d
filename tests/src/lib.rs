//! Tests of the controller, tick by tick on the virtual clock, for behaviour that no single crate can test.
//!
//! This library is their common ground. It runs Structured Text on a controller ([`mod@bench`]), makes machines ([`follow`],
//! [`robots`]), random programs ([`random`], [`robot_programs`]) and toolpaths ([`streams`]), and reports the tests that cannot run here
//! ([`mod@not_run`]). It holds no tests; they are in `tests/tests`. The programs as users
//! start them, with sockets and files, are tested by the package `arcline-system-tests` in `tests/system`.
#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};

pub mod bench;
pub mod follow;
pub mod not_run;
pub mod random;
pub mod robot_programs;
pub mod robots;
pub mod streams;
mod trace;

/// The root folder of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the tests package is a folder of the workspace")
}

/// A file of `tests`, such as `config/seeds.toml`.
#[must_use]
pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}
