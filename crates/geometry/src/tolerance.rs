//! Tolerances of geometry: what is rounding, with its unit in its name. Units: position units, degrees; sines, cosines, shares and
//! ratios have none.

/// Two points nearer than this are the same point (spec/coordinated-instructions.md §13.4), position units.
pub const SAME_POINT_UNITS: f64 = 1e-6;
/// Sine of the angle below which three points are collinear (spec/coordinated-instructions.md §13.4).
pub(crate) const COLLINEAR_SINE: f64 = 1e-6;
/// Share of a radius by which it may be short of half a chord: an exact half circle by its radius.
pub(crate) const HALF_CIRCLE_SHARE: f64 = 1e-9;
/// Share of a radius by which two equal radii differ by rounding.
pub(crate) const SAME_RADIUS_SHARE: f64 = 4e-16;
/// Below this ratio of slope to radius, the radial motion adds less than 1e-16 to the length.
pub(crate) const CIRCULAR_RATIO: f64 = 1e-8;
/// A step of Newton's method by a smaller share of an angle than this is rounding.
pub(crate) const NEWTON_STEP_SHARE: f64 = 1e-15;
/// Below this cosine of the second angle the other two are not distinguishable.
pub(crate) const UPRIGHT_COSINE: f64 = 1e-9;
/// Below this ratio of the parts of a quaternion there is no rotation but rounding.
pub(crate) const NO_ROTATION_RATIO: f64 = 1e-15;
/// Below this ratio of them the rotation is half a turn, but for rounding of the angles.
pub(crate) const HALF_TURN_RATIO: f64 = 1e-9;
/// Angles that differ by less are the same, degrees.
pub(crate) const SAME_ANGLES_DEG: f64 = 1e-9;
