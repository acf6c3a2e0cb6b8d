//! A thousand clients at once, strangers who take places, implicit I/O at its shortest intervals, a million lines of G-code, the page's
//! frames: each needs the machine for itself.
//!
//! `cargo test --workspace --test load`, or `.ci/run load`.

mod crowd;
mod flood;
mod gcode;
mod io_scanner;
mod page;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// The machine, for one test at a time.
fn take_machine() -> MutexGuard<'static, ()> {
    static MACHINE: Mutex<()> = Mutex::new(());
    MACHINE.lock().unwrap_or_else(PoisonError::into_inner)
}
