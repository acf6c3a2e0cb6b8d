//! Kinematics: where the tool of a robot is when its joints are somewhere, and the reverse.
//!
//! A [`Robot`] is a geometry with its parameters. Both directions are closed forms, written once over [`Number`]: plain
//! numbers map positions, [`Moving`] ones map velocities and accelerations along, by exact differentiation. Everything is
//! total and safe in the tick: no allocation, no loop that is not bounded, no panic.
//!
//! Not here: axes, coordinate systems, instructions, time. Source: spec/coordinated-instructions.md §22; formulas that
//! other documents have in another form are in `NOTES.md`.
#![forbid(unsafe_code)]

mod error;
mod number;
mod parallel;
mod robot;
mod two_links;

pub use error::{GeometryError, KinematicsError};
pub use number::{Moving, Number};
pub use robot::{Arm, Elbow, Geometry, Parameters, Robot};

#[cfg(test)]
mod tests;
