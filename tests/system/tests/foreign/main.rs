//! Programs of others against ours: clients in Python, JavaScript and C, a browser, Wireshark; strace, which makes the disk fail.
//!
//! `cargo test --workspace --test foreign`, or `.ci/run foreign`. A program that this machine does not have is said on the terminal;
//! in CI it is a failure.

mod browser;
mod disk;
mod guide;
mod interop;
mod mcap;
mod metrics;
mod readme;
