//! Tolerances of the simulated drives: thresholds for rounding, with the unit in the name. Units: position units, seconds; shares have none. One rounding
//! of an `f64` is at most 1.1e-16 of the number.

/// The distance within which the axis stands on a position, as a share of the position, or in position units below 1: 9 million roundings, as a reversed
/// axis must find the position on which it stands however the drive came to it.
pub(super) const SENSOR_WIDTH_SHARE: f64 = 1e-9;
/// A coasting axis slower than this counts as standing, position units/s: its speed decays exponentially, and from 1,000 units/s it reaches this after 21
/// time constants.
pub(super) const STANDSTILL_UNITS_PER_S: f64 = 1e-6;
/// The motion over a time shorter than this is linear, seconds: an acceleration of a million units/s² changes the position by 5e-13 units more.
pub(super) const SHORTEST_S: f64 = 1e-9;
/// Excess of a speed limit, as a share of it, from which it counts as exceeded, so that rounding does not cause a second switch: 9,000 roundings.
pub(super) const SPEED_MARGIN_SHARE: f64 = 1e-12;
/// The same share of the torque limit: larger, as the acceleration is a difference of speeds times the gain of the loop.
pub(super) const TORQUE_MARGIN_SHARE: f64 = 1e-9;
/// Rounding of the terms of a regime, as a share of them: 900 roundings, far above the true figure.
pub(super) const TERM_SHARE: f64 = 1e-13;
/// Share of the tolerance within which two positions of an oscillation are equal: the least step of the search along it, so that it ends.
pub(super) const GRAIN_SHARE: f64 = 1e-9;
