//! Tolerances of the simulated drives: what is rounding, with its unit in its name. Units: position units, seconds; shares have none.

/// Share of a position, or position units below 1, by which the axis may be beyond one that it still stands on: far more than
/// rounding moves it.
pub(super) const SENSOR_WIDTH_SHARE: f64 = 1e-9;
/// A coasting axis slower than this stands, position units/s.
pub(super) const STANDSTILL_UNITS_PER_S: f64 = 1e-6;
/// A time shorter than this is passed in a straight line, seconds.
pub(super) const SHORTEST_S: f64 = 1e-9;
/// A speed limit counts as exceeded beyond this share of it, so that a switch is one switch whatever rounds.
pub(super) const SPEED_MARGIN_SHARE: f64 = 1e-12;
/// The same share of the torque limit.
pub(super) const TORQUE_MARGIN_SHARE: f64 = 1e-9;
/// Share of the terms of a regime that rounding may lose: far above the true figure.
pub(super) const TERM_SHARE: f64 = 1e-13;
/// Share of the tolerance within which two positions of a swing are one.
pub(super) const GRAIN_SHARE: f64 = 1e-9;
