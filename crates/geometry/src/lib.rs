//! Paths in Cartesian space, parameterised by arc length: straight lines, circular arcs, full circles; frames, the
//! location of one Cartesian space in another; and rotations from one orientation to another.
//!
//! A path is geometry only; it knows neither time nor speed (`arcline-profile` does), no axes and no
//! units of its own: lengths are the position units of the coordinate system, angles are radians.
//! A path is evaluated in closed form from its arc length `s`, never from stored samples, so a move
//! is the same at every tick rate (spec/motion-core.md §1).
//!
//! All functions are safe in the tick: no allocation, no unbounded loop, no panic.
#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod arc;
mod frame;
mod line;
mod path;
mod rotation;
mod spin;
mod tolerance;

pub use arc::{Arc, ArcError, CirclePoint, Dimension, Direction};
pub use frame::Frame;
pub use line::Line;
pub use path::{Path, PathPoint};
pub use rotation::{Rotation, RotationState, angle_rates, angles, angular_rates, continued, nearest, rotation};
pub use spin::Spin;
pub use tolerance::SAME_POINT_UNITS;

/// A point or a difference of points; unused dimensions are 0.
pub type Point = nalgebra::Vector3<f64>;
