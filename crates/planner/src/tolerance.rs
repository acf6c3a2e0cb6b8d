//! Tolerances of the planner: thresholds for rounding, and for differences too small to show, with the unit in the name. Units:
//! position units, seconds;
//! sines and shares have none.

/// Rounding of an instant, seconds: an instant this little ahead of a tick counts as the tick's. A motion over a whole number of ticks ends
/// at the last of them.
pub const SAME_INSTANT_S: f64 = 1e-10;
/// Rounding, as a share of a speed, a distance or a limit: far above the rounding of `f64`, far below the resolution of a machine.
pub(crate) const ROUNDING_SHARE: f64 = 1e-9;
/// An acceleration across the direction of motion below this share of the acceleration is rounding.
pub(crate) const NO_ACCELERATION_SHARE: f64 = 1e-9;
/// Change of a velocity by its split into parts, as a share of it.
pub(crate) const SPLIT_VELOCITY_SHARE: f64 = 1e-13;
/// Rounding of the distance to the end of a path, as a share of it and its offset.
pub(crate) const DISTANCE_SHARE: f64 = 1e-12;
/// Error of the vertex of a parabola through three samples, as a share of it.
pub(crate) const VERTEX_SHARE: f64 = 1e-2;
/// Sine of the angle between lines that are collinear: 0.1 degree.
pub(crate) const COLLINEAR_SINE: f64 = 0.001_745_328_365_898_309;
/// Unit tangents with a difference up to this are equal: the rounding of an exact tangent (spec/motion-core.md §6.3).
pub(crate) const SAME_TANGENT_SINE: f64 = 1e-6;
/// A component of a plane's direction up to this does not move its axis.
pub(crate) const NO_COMPONENT_SINE: f64 = 1e-9;
/// Difference from the wanted pace, a share of the planned speed, at which it is reached.
pub(crate) const REACHED_PACE_SHARE: f64 = 1e-10;
/// Excess of a pace over its bounds, as a share of the planned speed.
pub(crate) const PACE_SHARE: f64 = 1e-12;
/// Shares of the planned speed or its rates with a difference up to this are equal.
pub(crate) const SAME_SHARE: f64 = 1e-9;
/// An acceleration below this share of the limit counts as steady speed.
pub(crate) const STEADY_SHARE: f64 = 0.01;
/// Seconds before and after an instant over which an acceleration of a contour must last on average. Around a circle of 120 chords the
/// planned speed ripples by 0.2 % in periods of 3 ms.
pub(crate) const RIPPLE_S: f64 = 0.006;
/// The least speed for the stop of a contour, as a share of the speed limit, such that its rates along the curve stay finite.
pub(crate) const CREEPING_SHARE: f64 = 1e-3;
/// The least speed for ramps of the pace that suit the present state, as a share of the trajectory's highest speed.
pub(crate) const LEAST_RAMP_SPEED_SHARE: f64 = 0.01;
/// The least rate of an axis that does not move, position units/s² or /s³.
pub(crate) const LEAST_RATE_UNITS: f64 = 1e-3;
