//! Cam profiles: the position of a slave over that of a master, as piecewise cubics through given points
//! (spec/axis-and-data-types.md §3.9).
//!
//! [`Profile::calculate`] makes a profile from points, [`Profile::at`] evaluates it. Not here: axes, time, tags, and the behaviour of
//! a cam at the ends of its profile. Units: those of the points, `x` of the master and `y` of the slave.

#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod profile;
mod spline;

pub use profile::{CamSegment, Profile, Value};
pub use spline::{CalculateError, Point, SegmentType};
