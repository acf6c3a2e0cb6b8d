//! Tolerances of profiles: thresholds for rounding, with the unit in the name. A share is of the named quantity.
//!
//! One rounding of an `f64` is at most 1.1e-16 of the number. Each tolerance states its count of roundings; the factor above the operations that
//! it covers is a choice, and none of them is visible on a machine.

/// Rounding of a speed or a jerk limit, as a share of it: 900 roundings, where `v + a² / 2j` or `a² / 2v` has five.
pub(crate) const LIMIT_SHARE: f64 = 1e-13;
/// Error of a sampled position, as a share of the largest position of the profile: 36 roundings, about two for each of the 14 segments whose
/// starts follow from each other, and those of the cubic.
pub(crate) const SAMPLED_POSITION_SHARE: f64 = 4e-15;
/// Rounding of a velocity, as a share of it: 18 roundings. A ramp over it would take a visible time (square root) for an invisible change.
pub(crate) const SAME_VELOCITY_SHARE: f64 = 2e-15;
/// Rounding of a distance, as a share of it: 9,000 roundings, as a braking distance is a difference of ramps that may be longer than itself.
pub(crate) const DISTANCE_SHARE: f64 = 1e-12;
/// Share by which a bound is raised above all rounding of it: a bound may be too high, so the margin costs nothing.
pub(crate) const ABOVE_ROUNDING_SHARE: f64 = 1e-9;
/// Displacements with a relative difference below this need every digit of the difference: it has six digits fewer than they have.
pub(crate) const CLOSE_DISPLACEMENT_SHARE: f64 = 1e-6;
/// One rounding of a number, as a share of it: a root has no higher precision. `f64::EPSILON` is 2.2e-16.
pub(crate) const ROUNDED_SHARE: f64 = 2e-16;
/// Width of a closed bracket around a root, as a share of it: two roundings.
pub(crate) const BRACKET_SHARE: f64 = 4e-16;
/// Relative size of a step of Newton's method after which the next one is exact: the convergence is quadratic, so that the next step is about
/// its square, 1e-18.
pub(crate) const NEWTON_STEP_SHARE: f64 = 1e-9;
/// Precision of a look-ahead's distance, as a share of it: 90 roundings. The speed found is rounded down afterwards.
pub(crate) const LOOKAHEAD_SHARE: f64 = 1e-14;
/// Rounding of a planned displacement, as a share of it: 18 roundings.
pub(crate) const DISPLACEMENT_SHARE: f64 = 2e-15;
/// Below this share of the velocity change that its deceleration implies, a velocity has too few digits for differences of closed forms: three of
/// its sixteen digits are lost.
pub(crate) const LEAST_VELOCITY_SHARE: f64 = 1e-3;
