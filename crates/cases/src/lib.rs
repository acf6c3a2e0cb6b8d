//! Many simulations in one process: cases as JSON lines in, a result for each out, in the order of the cases, and as much memory for a million as for
//! one (docs/BATCHES.md; spec/beyond-one-machine.md §6).
//!
//! [`Case`] is what a line says, [`Worker`] runs one after the other and keeps the machines and programs that come again, [`Batch`] has a worker in
//! each of its threads. [`Outcome`] is a line of the results, [`Measures`] what a run is measured by, also that of a single `simulate --json`.
//!
//! Not here: the command line, real time, sockets; and nothing that spreads over several computers, which engines for that do (`examples`).

#![forbid(unsafe_code)]

mod batch;
mod case;
mod measures;
mod outcome;
mod resume;
#[cfg(test)]
mod tests;
mod trace;
mod worker;

pub use batch::{Batch, BatchError, Done, LARGEST};
pub use case::{Case, FaultAt, FaultTime, Invalid, Pairs, QueueFullWord};
pub use measures::Measures;
pub use outcome::{DEFECT, INVALID, Outcome, Peak, Raised, text_hash};
pub use resume::{Finished, Other, finished};
pub use trace::TraceFile;
pub use worker::{Defaults, Prepared, Worker, prepared};
