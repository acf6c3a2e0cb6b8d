//! Tolerances of the planner: what is rounding or too little to show, with its unit in its name. Units: position units, seconds;
//! sines and shares have none.

/// Seconds by which an instant may be off for rounding: what lies so little ahead of a tick is at it. A motion of a whole number
/// of ticks ends at the last of them.
pub const SAME_INSTANT_S: f64 = 1e-10;
/// Share of a speed, a distance or a limit that is rounding: far above what is left of `f64`, far below what a machine shows.
pub(crate) const ROUNDING_SHARE: f64 = 1e-9;
/// Share of an acceleration that is none: what rounding leaves across the direction of motion.
pub(crate) const NO_ACCELERATION_SHARE: f64 = 1e-9;
/// Share of the velocity by which its split into parts may change it.
pub(crate) const SPLIT_VELOCITY_SHARE: f64 = 1e-13;
/// Share of the distance to the end of a path, its offset included, that is rounding.
pub(crate) const DISTANCE_SHARE: f64 = 1e-12;
/// Share of the vertex of a parabola by which one through three looks may be off.
pub(crate) const VERTEX_SHARE: f64 = 1e-2;
/// Sine of the angle between lines that are collinear: 0.1 degree.
pub(crate) const COLLINEAR_SINE: f64 = 0.001_745_328_365_898_309;
/// Unit tangents whose difference is no longer are equal: what floating point leaves of an exact tangent (spec/motion-core.md §6.3).
pub(crate) const SAME_TANGENT_SINE: f64 = 1e-6;
/// A component of the direction of a plane that is no larger does not move its axis.
pub(crate) const NO_COMPONENT_SINE: f64 = 1e-9;
/// Difference from the wanted pace, a share of the planned speed, at which it is reached.
pub(crate) const REACHED_PACE_SHARE: f64 = 1e-10;
/// Share of the planned speed by which a pace within its bounds may be beyond them.
pub(crate) const PACE_SHARE: f64 = 1e-12;
/// Shares of the planned speed or its rates that differ by no more are the same.
pub(crate) const SAME_SHARE: f64 = 1e-9;
/// Share of an acceleration that shows as steady speed.
pub(crate) const STEADY_SHARE: f64 = 0.01;
/// Share of the speed limit that a contour which creeps is braked with, so that its rates along the curve stay finite.
pub(crate) const CREEPING_SHARE: f64 = 1e-3;
/// A rate that an axis has which does not move, position units/s² or /s³.
pub(crate) const LEAST_RATE_UNITS: f64 = 1e-3;
