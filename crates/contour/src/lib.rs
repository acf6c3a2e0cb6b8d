//! Contours: sequences of lines and arcs as one motion within a tolerance and within the limits of
//! every axis, near the least time (`corner = "precise"`, `axis_limits = "enforce"`).
//!
//! [`plan`] turns moves into a [`Trajectory`], which the tick evaluates without allocation. Planning
//! allocates and iterates: it belongs outside the tick. It knows no update period: the result is a
//! function of time. Units: position units and seconds.
//!
//! By subject: `path` (the programmed pieces and the corridor about them), `timing` (where the control points stand in time),
//! `solve` (the optimisation), `section` and `plan` (moves from rest to rest), `extend` (while they run).
#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]
#![allow(
    clippy::needless_range_loop,
    reason = "axes, nodes and band rows are indexed side by side"
)]

mod arc_length;
mod extend;
mod limits;
mod path;
mod plan;
mod section;
mod solve;
mod spline;
mod timing;
mod tolerance;
mod trajectory;
mod tuning;

pub use arcline_geometry::{Path, Point};
pub use extend::extend;
pub use extend::replan::replan;
pub use limits::{AxisLimits, Rates};
pub use plan::{begin, plan};
pub use trajectory::{Peaks, Piece, State, Trajectory};

pub(crate) use limits::Bounds;
use tolerance::SAME_POINT_UNITS;

/// One programmed move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourMove {
    /// Where it goes.
    pub path: Path,
    /// Programmed vector speed, position units / s, above 0.
    pub speed: f64,
    /// Vector acceleration, position units / s², above 0.
    pub acceleration: f64,
    /// Vector deceleration, position units / s², above 0.
    pub deceleration: f64,
    /// Vector jerk, position units / s³: an S-curve. `None`: a trapezoid.
    pub jerk: Option<f64>,
    /// How far from the programmed path the corner at its end may be rounded, position units.
    /// 0: the end is met exactly, at rest if there is a corner.
    pub tolerance: f64,
    /// Where the motion may deviate from it.
    pub deviation: Deviation,
}

impl ContourMove {
    /// Whether it goes anywhere: shorter moves are done at once.
    pub(crate) fn has_length(&self) -> bool {
        self.path.length() > SAME_POINT_UNITS
    }
}

/// Where a contour may deviate from the programmed path inside the tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Deviation {
    /// At its corners: outside the rounding of its corners a move longer than 50 tolerances deviates by at most a hundredth of
    /// the tolerance. A rounding reaches at most ten tolerances from its corner. Lines of at most 250 tolerances that are chords of a
    /// curve may deviate anywhere, as shorter moves do (spec/motion-core.md §6.4).
    #[default]
    Corners,
    /// Anywhere.
    Anywhere,
}
