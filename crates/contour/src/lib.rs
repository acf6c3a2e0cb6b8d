//! Contours: sequences of lines and arcs as one motion within a tolerance and within the limits of
//! every axis, near the least time (`corner = "precise"`, `axis_limits = "enforce"`).
//!
//! [`plan`] turns moves into a [`Trajectory`], which the tick evaluates without allocation. Planning
//! allocates and iterates: it belongs outside the tick. It knows no update period: the result is a
//! function of time. Units: position units and seconds.
//!
//! By subject: `path` (the programmed pieces and the corridor about them), `timing` (the times of the control points),
//! `solve` (the optimisation), `section` and `plan` (moves from rest to rest), `extend` (extensions during execution).
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
pub use extend::replan::replan;
pub use extend::{ExtensionRequest, extend, extend_slowed};
pub use limits::{AxisLimits, Rates};
pub use plan::{begin, plan, plan_with_stops};
pub use trajectory::{AxesState, Peaks, Piece, Trajectory};

pub(crate) use limits::MoveLimits;
use tolerance::SAME_POINT_UNITS;

/// One programmed move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourMove {
    /// Its programmed path.
    pub path: Path,
    /// Programmed vector speed, position units / s, above 0.
    pub speed: f64,
    /// Vector acceleration, position units / s², above 0.
    pub acceleration: f64,
    /// Vector deceleration, position units / s², above 0.
    pub deceleration: f64,
    /// Vector jerk, position units / s³: an S-curve. `None`: a trapezoid.
    pub jerk: Option<f64>,
    /// The permitted deviation of the rounded corner at its end from the programmed path, position units.
    /// 0: the motion meets the end exactly, at rest if there is a corner.
    pub tolerance: f64,
    /// The part of the path on which the motion may deviate.
    pub deviation: Deviation,
}

impl ContourMove {
    /// The move has a length; shorter moves are complete at once.
    pub(crate) fn has_length(&self) -> bool {
        self.path.length() > SAME_POINT_UNITS
    }
}

/// The part of the programmed path on which a contour may deviate from it within the tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Deviation {
    /// At its corners. A rounding extends over at most ten tolerances from its corner; outside of the roundings, a move longer than 50 tolerances
    /// deviates by at most a hundredth of the tolerance. Shorter moves may deviate anywhere, and so may lines of at most 250 tolerances that are
    /// chords of a curve (spec/motion-core.md §6.4).
    #[default]
    Corners,
    /// Anywhere.
    Anywhere,
}
