//! Tolerances of robots: thresholds for rounding, with the unit in the name. Units: position units, degrees, radians; sines and shares have none.
//! One rounding of an `f64` is at most 1.1e-16 of the number.

/// Cosine of Ry below which the other two angles are not distinguishable: it is a sum of products with a rounding of 1e-16 each, which leaves seven
/// digits of their directions.
pub(crate) const UPRIGHT_COSINE: f64 = 1e-9;
/// An angle this little above -180 counts as 180, degrees: that is 35,000 roundings of an
/// angle of one turn.
pub(crate) const HALF_TURN_DEG: f64 = 1e-9;
/// Distance from the plane up to which an operand counts as in it, position units: operands are REAL, whose rounding reaches this at 16,000 units.
pub(crate) const OFF_PLANE_UNITS: f64 = 1e-3;
/// Sine of an angle up to which it is rounding: operands are REAL, whose rounding at 180 degrees is 1.3e-7 of a radian; the rest is a margin for frames
/// of several angles.
pub(crate) const OFF_ANGLE_SINE: f64 = 1e-5;
/// The value of [`crate::number::Number::NEAREST_SHARE`] for positions alone: a point nearer to an axis has no direction about it, but for seven digits.
pub(crate) const NEAREST_AT_REST_SHARE: f64 = 1e-9;
/// The same with derivatives (spec/coordinated-instructions.md §19.8): a joint that passes the axis at this distance rotates a million times as fast
/// as at full reach.
pub(crate) const NEAREST_IN_MOTION_SHARE: f64 = 1e-6;
/// The value of [`crate::number::Number::LEAST_BEND_SHARE`] for positions alone: below 0, as a stretched arm is within rounding of
/// its reach (spec/coordinated-instructions.md §22.2).
pub(crate) const LEAST_BEND_AT_REST_SHARE: f64 = -1e-9;
/// The same with derivatives: the rates of a stretched arm are infinite (spec/coordinated-instructions.md §22.3).
pub(crate) const LEAST_BEND_IN_MOTION_SHARE: f64 = 1e-6;
/// An angle this far out of its range counts as at its end, radians: 4 million roundings of an
/// angle of three radians.
pub(crate) const RANGE_END_RAD: f64 = 1e-9;
/// Elbows this close to a line or a point hold no plate; a share of the rod, squared or to the fourth: 1e-9 of the rod, which leaves seven digits.
pub(crate) const DEGENERATE_SHARE: f64 = 1e-18;
