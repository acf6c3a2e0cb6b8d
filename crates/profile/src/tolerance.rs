//! Tolerances of profiles: thresholds for rounding, with the unit in the name. A share is of the named quantity.
//!
//! `f64` has a rounding of 1.1e-16 of a number; each tolerance is that times the operations before it, with a margin.

/// Rounding of a speed or a jerk limit, as a share of it.
pub(crate) const LIMIT_SHARE: f64 = 1e-13;
/// Error of a sampled position, as a share of the largest position of the profile.
pub(crate) const SAMPLED_POSITION_SHARE: f64 = 4e-15;
/// Rounding of a velocity, as a share of it: a ramp over it would take a visible time (square root) for an invisible change.
pub(crate) const SAME_VELOCITY_SHARE: f64 = 2e-15;
/// Rounding of a distance, as a share of it.
pub(crate) const DISTANCE_SHARE: f64 = 1e-12;
/// Share by which a bound is raised above all rounding of it.
pub(crate) const ABOVE_ROUNDING_SHARE: f64 = 1e-9;
/// Displacements with a relative difference below this need every digit of the difference.
pub(crate) const CLOSE_DISPLACEMENT_SHARE: f64 = 1e-6;
/// One rounding of a number, as a share of it: a root has no higher precision.
pub(crate) const ROUNDED_SHARE: f64 = 2e-16;
/// Width of a closed bracket around a root, as a share of it: two roundings.
pub(crate) const BRACKET_SHARE: f64 = 4e-16;
/// Relative size of a step of Newton's method after which the next one is exact.
pub(crate) const NEWTON_STEP_SHARE: f64 = 1e-9;
/// Precision of a look-ahead's distance, as a share of it.
pub(crate) const LOOKAHEAD_SHARE: f64 = 1e-14;
/// Rounding of a planned displacement, as a share of it.
pub(crate) const DISPLACEMENT_SHARE: f64 = 2e-15;
