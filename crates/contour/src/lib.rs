//! Contours: sequences of lines and arcs as one motion within a tolerance and within the limits of
//! every axis, near the least time (`corner = "precise"`, `axis_limits = "enforce"`).
//!
//! [`plan`] turns moves into a [`Trajectory`], which the tick evaluates without allocation. Planning
//! allocates and iterates: it belongs outside the tick. It knows no update period: the result is a
//! function of time. Units: position units and seconds.
#![forbid(unsafe_code)]
#![allow(
    clippy::needless_range_loop,
    reason = "axes, nodes and band rows are indexed side by side"
)]

mod allowance;
mod assemble;
mod banded;
mod course;
mod ease;
mod guess;
mod meet;
mod nodes;
mod nominal;
mod optimise;
mod plan;
mod problem;
mod rates;
mod resample;
mod rounding;
mod section;
mod setup;
mod share;
mod splice;
mod steps;
mod straight;
mod trajectory;
mod tube;
mod way;

pub use arcline_geometry::{Path, Point};
pub use plan::{Effort, plan, plan_with};
pub use rates::Rates;
pub use splice::{extend, replan};
pub use trajectory::{Peaks, Piece, State, Trajectory};

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

/// Where a contour may deviate from the programmed path inside the tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Deviation {
    /// At its corners: outside the rounding of its corners a move longer than 50 tolerances deviates by at most a hundredth of
    /// the tolerance. A rounding reaches at most ten tolerances from its corner.
    #[default]
    Corners,
    /// Anywhere.
    Anywhere,
}

/// What each axis can do; infinite where there is no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLimits {
    /// Position units / s.
    pub speed: Point,
    /// Position units / s².
    pub acceleration: Point,
    /// Position units / s³, kept by S-curves. `None`: no limit.
    pub jerk: Option<Point>,
}

/// All limits of one move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) deceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) axes: AxisLimits,
}

impl Bounds {
    /// The magnitude of the acceleration in any direction: the larger of the two rates.
    pub(crate) fn norm_acceleration(&self) -> f64 {
        self.acceleration.max(self.deceleration)
    }

    pub(crate) fn norm_jerk(&self) -> f64 {
        self.jerk
    }

    /// The same without limits of jerk.
    pub(crate) fn without_jerk(&self) -> Bounds {
        Bounds {
            jerk: f64::INFINITY,
            axes: AxisLimits {
                jerk: None,
                ..self.axes
            },
            ..*self
        }
    }

    /// The least jerk limit of all.
    pub(crate) fn least_jerk(&self) -> f64 {
        self.axes.jerk.map_or(self.jerk, |axes| self.jerk.min(axes.min()))
    }
}
