//! Tolerances of contours: what is rounding, with its unit in its name. Units: position units, radians; sines and shares have none.
//!
//! Not here: tuned constants ([`crate::tuning`]).

/// Points that are no farther apart are one, position units.
pub(crate) const SAME_POINT_UNITS: f64 = 1e-9;
/// Samples that are no farther apart are one, position units.
pub(crate) const SAME_SAMPLE_UNITS: f64 = 1e-12;
/// Control points that are no farther apart have no direction, position units.
pub(crate) const SAME_CONTROL_POINT_UNITS: f64 = 1e-12;
/// Tangents that differ by no more go on in one direction: 0.1 degree, in radians (spec/coordinated-instructions.md §7.7).
pub(crate) const COLLINEAR_RAD: f64 = 0.1 * core::f64::consts::PI / 180.0;
/// The sine of an angle between lines that go on straight.
pub(crate) const SAME_DIRECTION_SINE: f64 = 1e-9;
/// Unit tangents whose difference is no longer than this are equal (spec/motion-core.md §6.3).
pub(crate) const SAME_TANGENT_SINE: f64 = 1e-6;
/// Share of a limit that rounding adds to one that is reached exactly.
pub(crate) const LIMIT_SHARE: f64 = 1e-10;
/// Share of a speed or a rate that is rounding.
pub(crate) const RATE_SHARE: f64 = 1e-9;
/// Share of the length of a piece that is rounding.
pub(crate) const LENGTH_SHARE: f64 = 1e-15;
/// Share of a piece between its middle and a sample just before it.
pub(crate) const BESIDE_SHARE: f64 = 1e-9;
/// Share of a diagonal element below which a pivot of a factorisation is rounding.
pub(crate) const PIVOT_SHARE: f64 = 1e-14;
/// A diagonal element below this is 0 as far as a factorisation goes; it keeps the pivot above 0.
pub(crate) const LEAST_DIAGONAL: f64 = 1e-200;
/// A length below this would overflow as a divisor, position units.
pub(crate) const LEAST_LENGTH_UNITS: f64 = 1e-300;
