//! Tolerances of contours: thresholds for rounding, with the unit in the name. Units: position units, radians; sines and shares have none.
//!
//! One rounding of an `f64` is at most 1.1e-16 of the number: 6e-11 position units at a million. Not here: tuned constants ([`crate::tuning`]).

/// Points up to this distance apart are equal, position units: 17 roundings of a coordinate of a million units.
pub(crate) const SAME_POINT_UNITS: f64 = 1e-9;
/// Samples up to this distance apart are equal, position units: the end of one stretch and the start of the next one, which are the same point but for
/// rounding; nine roundings of a coordinate of 1,000 units.
pub(crate) const SAME_SAMPLE_UNITS: f64 = 1e-12;
/// Control points up to this distance apart have no direction, position units: nine roundings of a coordinate of 1,000 units.
pub(crate) const SAME_CONTROL_POINT_UNITS: f64 = 1e-12;
/// Tangents with a difference up to this are collinear: 0.1 degree, in radians (spec/coordinated-instructions.md §7.7).
pub(crate) const COLLINEAR_RAD: f64 = 0.1 * core::f64::consts::PI / 180.0;
/// The sine of the angle between collinear lines: over 1,000 units they are 1e-6 units apart, which geometry takes for one point.
pub(crate) const SAME_DIRECTION_SINE: f64 = 1e-9;
/// Unit tangents with a difference up to this are equal (spec/motion-core.md §6.3).
pub(crate) const SAME_TANGENT_SINE: f64 = 1e-6;
/// Rounding of a limit that is reached exactly, as a share of it: a million roundings, as accelerations and jerks are differences of control points over
/// powers of the time, which lose digits.
pub(crate) const LIMIT_SHARE: f64 = 1e-10;
/// Rounding of a speed or a rate, as a share of it: 9 million roundings of a planned profile's end.
pub(crate) const RATE_SHARE: f64 = 1e-9;
/// Width of a bracket of an instant, as a share of it: nine roundings, below which no closer instant can be found.
pub(crate) const LENGTH_SHARE: f64 = 1e-15;
/// Share of a piece between its middle and a sample just before it: far above the rounding of an arc length, so that the sample has the tolerance before
/// the middle, and far below a visible distance.
pub(crate) const BESIDE_SHARE: f64 = 1e-9;
/// Share of a diagonal element below which a pivot of a factorisation is rounding: 90 roundings, of the products that the band subtracts from it.
pub(crate) const PIVOT_SHARE: f64 = 1e-14;
/// A diagonal element below this counts as 0 in a factorisation; it keeps the pivot above 0. The product with [`PIVOT_SHARE`], 1e-214, and its
/// reciprocal are numbers of full precision.
pub(crate) const LEAST_DIAGONAL: f64 = 1e-200;
/// A length below this would overflow as a divisor, position units: 1e308 is about the largest number.
pub(crate) const LEAST_LENGTH_UNITS: f64 = 1e-300;
