//! Tolerances of robots: what is rounding, with its unit in its name. Units: position units, degrees, radians; sines and shares have none.

/// Below this cosine of Ry the other two angles are not distinguishable.
pub(crate) const UPRIGHT_COSINE: f64 = 1e-9;
/// An angle this little above -180 is 180, degrees.
pub(crate) const HALF_TURN_DEG: f64 = 1e-9;
/// Operands are REAL: this far off the plane is in it, position units.
pub(crate) const OFF_PLANE_UNITS: f64 = 1e-3;
/// Sine of an angle that is rounding.
pub(crate) const OFF_ANGLE_SINE: f64 = 1e-5;
/// Up to this [`crate::number::Number::NEAREST`] it is no fault that J4 and J6 turn about the same axis: nothing moves.
pub(crate) const STRAIGHT_COSINE: f64 = 1e-9;
/// An angle this far out of its range is at its end, radians.
pub(crate) const RANGE_END_RAD: f64 = 1e-9;
/// Elbows that are this near to a line or a point, as a share of the rod, squared or to the fourth, hold no plate.
pub(crate) const DEGENERATE_SHARE: f64 = 1e-18;
