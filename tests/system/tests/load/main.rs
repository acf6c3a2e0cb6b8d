//! A thousand clients at once, strangers who take places, implicit I/O at its shortest intervals, a million lines of G-code: each needs the machine for itself.
//!
//! `cargo test --workspace --test load`, or `.ci/run load`.

mod crowd;
mod flood;
mod gcode;
mod io_scanner;
