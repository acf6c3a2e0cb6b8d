//! Tests of the programs, as users start them.
//!
//! This library is their common ground. It finds the programs ([`programs`]), runs a server for the length of a test ([`server`]) and
//! the command line ([`command_line`], [`terminal`]), the pages of the guide ([`guide`]), foreign clients ([`interop`], [`python`],
//! [`node`], [`libplctag`], through a [`tunnel`] to a [`secured`] server) and a browser ([`browser`]). It exchanges data in cycles
//! ([`scanner`]), makes many requests at a time ([`load`]), measures their effect on the ticks ([`lateness`]) and records the traffic of
//! the loopback interface ([`capture`]).
//!
//! `tests/programs` needs the programs only. `tests/foreign` needs programs of others and `tests/load` the machine for itself;
//! `cargo test` runs these two only by name. A test that lacks a program reports it by [`not_run`].
#![forbid(unsafe_code)]

use std::time::{Duration, Instant};

pub use arcline_tests::not_run::{in_ci, not_granted, not_run};
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

/// Calls `condition` until it gives a value.
///
/// # Panics
/// With `what` in the message, when the condition has given no value before `limit` has passed.
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
