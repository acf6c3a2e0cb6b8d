//! The controller on a virtual clock: the caller executes the ticks, and a run can be repeated exactly.
//!
//! [`Simulation`] is a machine with its tags, driven tick by tick. [`Runner`] is a simulation with programs, which continue in the ticks in which
//! they have work. An [`Observer`] receives the changes; [`Record`] writes them as text. Times are in seconds.
//!
//! Not here: threads, real clocks, files, sockets, logs.

#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod calls;
mod end;
mod names;
mod observer;
mod program;
mod record;
mod runner;
mod signals;
mod simulation;
#[cfg(test)]
mod tests;
mod values;

pub use calls::Origin;
pub use end::{End, Erred, Refused};
pub use names::ImageNames;
pub use observer::{Blind, Observer};
pub use program::ProgramId;
pub use record::Record;
pub use runner::{Locked, Options, Passed, Piece, RunLimits, Runner};
pub use signals::{AXIS_SIGNALS, Columns, NoSignal, Signal, sample};
pub use simulation::Simulation;
pub use values::{Encoded, NotWritten, by_element, encoded, try_write};
