//! Tolerances of geometry: thresholds for rounding and for arcs that are refused, with the unit in the name. Units: position units, degrees; sines,
//! cosines, shares and ratios have none. One rounding of an `f64` is at most 1.1e-16 of the number.

/// Two points closer than this are equal (spec/coordinated-instructions.md §13.4), position units.
pub const SAME_POINT_UNITS: f64 = 1e-6;
/// Sine of the angle below which three points are collinear (spec/coordinated-instructions.md §13.4).
pub(crate) const COLLINEAR_SINE: f64 = 1e-6;
/// Least radius (error 49, spec/coordinated-instructions.md §13.4), position units.
pub(crate) const SMALLEST_RADIUS_UNITS: f64 = 0.001;
/// Largest difference of the radii at start and end, as a share of that at the start (error 46, spec/coordinated-instructions.md §13.4).
pub(crate) const LARGEST_MISMATCH_SHARE: f64 = 0.15;
/// Difference of a radius and half a chord, as a share of the radius, up to which the arc is an exact half circle
/// (spec/coordinated-instructions.md §13.4).
pub(crate) const HALF_CIRCLE_SHARE: f64 = 1e-9;
/// Rounding of the difference of two equal radii, as a share of a radius: four roundings, two for each distance from the centre.
pub(crate) const SAME_RADIUS_SHARE: f64 = 4e-16;
/// Ratio of slope to radius below which the radial motion adds less than 1e-16 to the length: `sqrt(r² + b²)` is `r (1 + b² / 2r²)`.
pub(crate) const CIRCULAR_RATIO: f64 = 1e-8;
/// Relative size of a step of Newton's method below which it is rounding: nine roundings.
pub(crate) const NEWTON_STEP_SHARE: f64 = 1e-15;
/// Cosine of the second angle below which the other two are not distinguishable: it is a sum of products with a rounding of 1e-16 each, which leaves
/// seven digits of their directions.
pub(crate) const UPRIGHT_COSINE: f64 = 1e-9;
/// Ratio of the parts of a quaternion below which a rotation is rounding: nine roundings.
pub(crate) const NO_ROTATION_RATIO: f64 = 1e-15;
/// Ratio of them below which the rotation is half a turn within rounding of the angles: 1e-7 degrees, far above the rounding of angles of some turns.
pub(crate) const HALF_TURN_RATIO: f64 = 1e-9;
/// Angles with a smaller difference are equal, degrees: an angle of 1,000 turns has a rounding of 3e-11.
pub(crate) const SAME_ANGLES_DEG: f64 = 1e-9;
