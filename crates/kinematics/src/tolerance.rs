//! Tolerances of robots: thresholds for rounding, with the unit in the name. Units: position units, degrees, radians; sines and shares have none.

/// Cosine of Ry below which the other two angles are not distinguishable.
pub(crate) const UPRIGHT_COSINE: f64 = 1e-9;
/// An angle this little above -180 counts as 180, degrees.
pub(crate) const HALF_TURN_DEG: f64 = 1e-9;
/// Distance from the plane up to which an operand counts as in it, position units: operands are REAL.
pub(crate) const OFF_PLANE_UNITS: f64 = 1e-3;
/// Sine of an angle up to which it is rounding.
pub(crate) const OFF_ANGLE_SINE: f64 = 1e-5;
/// Up to this [`crate::number::Number::NEAREST`], J4 and J6 may rotate about the same axis, as no joint moves.
pub(crate) const STRAIGHT_COSINE: f64 = 1e-9;
/// An angle this far out of its range counts as at its end, radians.
pub(crate) const RANGE_END_RAD: f64 = 1e-9;
/// Elbows this close to a line or a point hold no plate; a share of the rod, squared or to the fourth.
pub(crate) const DEGENERATE_SHARE: f64 = 1e-18;
