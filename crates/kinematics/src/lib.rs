//! Kinematics: the position of a robot's tool for the positions of its joints, and the inverse.
//!
//! A [`Robot`] is a geometry with its parameters. Both directions are closed forms, written once over [`Number`]: plain
//! numbers map positions, [`arcline_profile::KinematicState`] ones also map velocities and accelerations, by exact differentiation. All
//! functions are total and safe in the tick: no allocation, no unbounded loop, no panic.
//!
//! An [`OrientedRobot`] has a wrist behind its arm and maps a [`Pose`].
//!
//! Not here: axes, coordinate systems, instructions, time. Source: spec/coordinated-instructions.md §22; formulas that
//! differ in form from those of other documents are in `NOTES.md`.
#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod error;
mod number;
mod oriented;
mod parallel;
mod pose;
mod robot;
mod tolerance;
mod two_links;

pub use error::{GeometryError, KinematicsError};
pub use number::Number;
pub use oriented::{Configuration, OrientedRobot, Taken, Turns, Wrist};
pub use pose::{Pose, end_of_arm, tool_centre};
pub use robot::{Arm, Elbow, Geometry, Parameters, Robot};

#[cfg(test)]
mod oriented_tests;
#[cfg(test)]
mod tests;
