//! Tolerances of profiles: what is rounding, with its unit in its name. A share is of the quantity that the sentence names.
//!
//! `f64` keeps a share of 1.1e-16 of a number; each tolerance is that times the operations before it, with room.

/// Share of a speed or a jerk limit that is rounding.
pub(crate) const LIMIT_SHARE: f64 = 1e-13;
/// Share of the largest position of a profile by which a sampled one may be off.
pub(crate) const SAMPLED_POSITION_SHARE: f64 = 4e-15;
/// Share of a velocity that is rounding: a ramp over it would take a visible time (square root) for an invisible change.
pub(crate) const SAME_VELOCITY_SHARE: f64 = 2e-15;
/// Share of a distance that is rounding.
pub(crate) const DISTANCE_SHARE: f64 = 1e-12;
/// Share that lifts a bound above every rounding of it.
pub(crate) const ABOVE_ROUNDING_SHARE: f64 = 1e-9;
/// Two displacements that differ by a smaller share than this need every digit of their difference.
pub(crate) const CLOSE_DISPLACEMENT_SHARE: f64 = 1e-6;
/// Share of a number that one rounding changes: a root is not found more closely.
pub(crate) const ROUNDED_SHARE: f64 = 2e-16;
/// Share of a number within which a bracket around a root is closed: two roundings.
pub(crate) const BRACKET_SHARE: f64 = 4e-16;
/// A step of Newton's method by a smaller share of the value than this makes the next one exact.
pub(crate) const NEWTON_STEP_SHARE: f64 = 1e-9;
/// Share of a distance within which a look-ahead meets it.
pub(crate) const LOOKAHEAD_SHARE: f64 = 1e-14;
/// Share of a displacement that planning it loses by rounding.
pub(crate) const DISPLACEMENT_SHARE: f64 = 2e-15;
