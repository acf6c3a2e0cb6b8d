//! Tolerances of geometry: thresholds for rounding, with the unit in the name. Units: position units, degrees; sines, cosines, shares and
//! ratios have none.

/// Two points closer than this are equal (spec/coordinated-instructions.md §13.4), position units.
pub const SAME_POINT_UNITS: f64 = 1e-6;
/// Sine of the angle below which three points are collinear (spec/coordinated-instructions.md §13.4).
pub(crate) const COLLINEAR_SINE: f64 = 1e-6;
/// Difference of a radius and half a chord, as a share of the radius, up to which the arc is an exact half circle.
pub(crate) const HALF_CIRCLE_SHARE: f64 = 1e-9;
/// Rounding of the difference of two equal radii, as a share of a radius.
pub(crate) const SAME_RADIUS_SHARE: f64 = 4e-16;
/// Ratio of slope to radius below which the radial motion adds less than 1e-16 to the length.
pub(crate) const CIRCULAR_RATIO: f64 = 1e-8;
/// Relative size of a step of Newton's method below which it is rounding.
pub(crate) const NEWTON_STEP_SHARE: f64 = 1e-15;
/// Cosine of the second angle below which the other two are not distinguishable.
pub(crate) const UPRIGHT_COSINE: f64 = 1e-9;
/// Ratio of the parts of a quaternion below which a rotation is rounding.
pub(crate) const NO_ROTATION_RATIO: f64 = 1e-15;
/// Ratio of them below which the rotation is half a turn within rounding of the angles.
pub(crate) const HALF_TURN_RATIO: f64 = 1e-9;
/// Angles with a smaller difference are equal, degrees.
pub(crate) const SAME_ANGLES_DEG: f64 = 1e-9;
