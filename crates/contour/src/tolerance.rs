//! Tolerances of contours: thresholds for rounding, with the unit in the name. Units: position units, radians; sines and shares have none.
//!
//! Not here: tuned constants ([`crate::tuning`]).

/// Points up to this distance apart are equal, position units.
pub(crate) const SAME_POINT_UNITS: f64 = 1e-9;
/// Samples up to this distance apart are equal, position units.
pub(crate) const SAME_SAMPLE_UNITS: f64 = 1e-12;
/// Control points up to this distance apart have no direction, position units.
pub(crate) const SAME_CONTROL_POINT_UNITS: f64 = 1e-12;
/// Tangents with a difference up to this are collinear: 0.1 degree, in radians (spec/coordinated-instructions.md §7.7).
pub(crate) const COLLINEAR_RAD: f64 = 0.1 * core::f64::consts::PI / 180.0;
/// The sine of the angle between collinear lines.
pub(crate) const SAME_DIRECTION_SINE: f64 = 1e-9;
/// Unit tangents with a difference up to this are equal (spec/motion-core.md §6.3).
pub(crate) const SAME_TANGENT_SINE: f64 = 1e-6;
/// Rounding of a limit that is reached exactly, as a share of it.
pub(crate) const LIMIT_SHARE: f64 = 1e-10;
/// Rounding of a speed or a rate, as a share of it.
pub(crate) const RATE_SHARE: f64 = 1e-9;
/// Rounding of the length of a piece, as a share of it.
pub(crate) const LENGTH_SHARE: f64 = 1e-15;
/// Share of a piece between its middle and a sample just before it.
pub(crate) const BESIDE_SHARE: f64 = 1e-9;
/// Share of a diagonal element below which a pivot of a factorisation is rounding.
pub(crate) const PIVOT_SHARE: f64 = 1e-14;
/// A diagonal element below this counts as 0 in a factorisation; it keeps the pivot above 0.
pub(crate) const LEAST_DIAGONAL: f64 = 1e-200;
/// A length below this would overflow as a divisor, position units.
pub(crate) const LEAST_LENGTH_UNITS: f64 = 1e-300;
