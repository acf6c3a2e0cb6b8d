//! The program of a controller project on a machine (spec/programs.md §14): [`bind`] gives a project the names of a machine and places its tags among
//! those of the machine, for the running server and for a simulation alike; [`SimulatedCell`] runs it on a virtual clock, tick by tick.
//!
//! Not here: the execution of routines (`arcline-routine`), XML (`arcline-l5x`), files, threads, real clocks. Times are in seconds.
#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod binding;
mod decode;
mod json;
mod names;
mod plant;
mod simulated;
#[cfg(test)]
mod tests;
mod values;

pub use binding::{Bound, DoesNotRun, LoadError, Surroundings, UnknownParts, bind, told};
pub use names::{Names, NotPlaced, Placed, Places, remove_others};
pub use simulated::{Condition, End, NotSet, RunLimits, SimulatedCell};
