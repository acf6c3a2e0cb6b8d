//! A thousand clients at once, and implicit I/O at its shortest intervals: each needs the machine for itself.
//!
//! `cargo test --workspace --test load`, or `.ci/run load`.

mod crowd;
mod io_scanner;
