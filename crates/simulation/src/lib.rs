//! The controller on a virtual clock: ticks pass when the caller says so, and a run can be repeated exactly.
//!
//! [`Simulation`] is a machine with its tags, driven tick by tick. [`Runner`] is the same with programs, which continue in the ticks in which
//! they have something to do. An [`Observer`] sees what happens; [`Record`] writes it down as text. Times are in seconds.
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
pub use runner::{Limits, Locked, Options, Passed, Piece, Runner};
pub use signals::{AXIS_SIGNALS, Columns, NoSignal, Signal, sample};
pub use simulation::Simulation;
pub use values::NotWritten;
