//! Tolerances of the simulated drives: thresholds for rounding, with the unit in the name. Units: position units, seconds; shares have none.

/// The distance within which the axis stands on a position, as a share of the position, or in position units below 1: far more than rounding.
pub(super) const SENSOR_WIDTH_SHARE: f64 = 1e-9;
/// A coasting axis slower than this counts as standing, position units/s.
pub(super) const STANDSTILL_UNITS_PER_S: f64 = 1e-6;
/// The motion over a time shorter than this is linear, seconds.
pub(super) const SHORTEST_S: f64 = 1e-9;
/// Excess of a speed limit, as a share of it, from which it counts as exceeded, so that rounding does not cause a second switch.
pub(super) const SPEED_MARGIN_SHARE: f64 = 1e-12;
/// Excess of a torque limit, as a share of it, from which it counts as exceeded.
pub(super) const TORQUE_MARGIN_SHARE: f64 = 1e-9;
/// Rounding of the terms of a regime, as a share of them: far above the true figure.
pub(super) const TERM_SHARE: f64 = 1e-13;
/// Share of the tolerance within which two positions of an oscillation are equal.
pub(super) const GRAIN_SHARE: f64 = 1e-9;
