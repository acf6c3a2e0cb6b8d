//! Tolerances of the planner: thresholds for rounding, and for differences too small to show, with the unit in the name. Units:
//! position units, seconds; sines and shares have none.
//!
//! One rounding of an `f64` is at most 1.1e-16 of the number. A tolerance that no rounding explains says what it trades; "not measured" means that its
//! figure is a choice.

/// Rounding of an instant, seconds: an instant this little ahead of a tick counts as the tick's. A motion over a whole number of ticks ends
/// at the last of them. An instant is a tick and a fraction, so only durations round: one of a day has a rounding of 7e-12.
pub const SAME_INSTANT_S: f64 = 1e-10;
/// Rounding, as a share of a speed, a distance or a limit: far above the rounding of `f64`, far below the resolution of a machine.
pub(crate) const ROUNDING_SHARE: f64 = 1e-9;
/// An acceleration across the direction of motion below this share of the acceleration is rounding: [`ROUNDING_SHARE`] of a part of a vector.
pub(crate) const NO_ACCELERATION_SHARE: f64 = 1e-9;
/// Change of a velocity by its split into parts, as a share of it, at which the split is found: 900 roundings, so that the step of the velocity that it
/// causes is invisible.
pub(crate) const SPLIT_VELOCITY_SHARE: f64 = 1e-13;
/// Square of the least share of a path that the compensation of terminated motion must leave: a tenth of the path. A smaller rest would need a speed
/// more than ten times as high along it. Not measured.
pub(crate) const LEAST_PATH_SQUARED_SHARE: f64 = 0.01;
/// Rounding of the distance to the end of a path, as a share of it and its offset: 9,000 roundings of a distance that many moves sum up.
pub(crate) const DISTANCE_SHARE: f64 = 1e-12;
/// Error of the vertex of a parabola through three samples, as a share of it: within this share below a bound the maximum is searched for more closely.
/// A larger share searches more often, a smaller one may miss an excess. Not measured.
pub(crate) const VERTEX_SHARE: f64 = 1e-2;
/// Sine of the angle between lines that are collinear: 0.1 degree (spec/coordinated-instructions.md §7.7).
pub(crate) const COLLINEAR_SINE: f64 = 0.001_745_328_365_898_309;
/// Unit tangents with a difference up to this are equal: the rounding of an exact tangent (spec/motion-core.md §6.3).
pub(crate) const SAME_TANGENT_SINE: f64 = 1e-6;
/// A component of a plane's direction up to this does not move its axis. A larger one may still be rounding, up to 1.5e-8, the root of the rounding of a
/// normal: the limit that it gives is so high that it does not count.
pub(crate) const NO_COMPONENT_SINE: f64 = 1e-9;
/// Factor by which an accepted spiral may be tighter than its radius: the curvature `(r² + 2 b²) / (r² + b²)^1.5` with the
/// slope `b` exceeds 1 over the smaller radius. With the largest mismatch of radii (15 %, spec/coordinated-instructions.md §13.4) by 4.7 % at a sweep of
/// half a radian, and by less for longer ones; the worst spiral, a quarter of a radian, exceeds it by 8.9 %, and is not covered.
pub(crate) const TIGHTER_SPIRAL_RATIO: f64 = 1.05;
/// The largest displacement by an acceleration across the velocity, as a share of the stop: a smaller share removes the acceleration with more jerk, a
/// larger one lets the motion leave its line further. Not measured.
pub(crate) const ASIDE_SHARE: f64 = 0.1;
/// Difference from the wanted pace, a share of the planned speed, at which it is reached: a million roundings of a ramp's end.
pub(crate) const REACHED_PACE_SHARE: f64 = 1e-10;
/// Excess of a pace over its bounds, as a share of the planned speed: 9,000 roundings of a sampled ramp.
pub(crate) const PACE_SHARE: f64 = 1e-12;
/// Shares of the planned speed or its rates with a difference up to this are equal: [`ROUNDING_SHARE`] of a quotient of two limits.
pub(crate) const SAME_SHARE: f64 = 1e-9;
/// An acceleration below this share of the limit counts as steady speed: a planned contour always has a small one. It only decides a status bit. Not
/// measured.
pub(crate) const STEADY_SHARE: f64 = 0.01;
/// Seconds before and after an instant over which an acceleration of a contour must last on average. Around a circle of 120 chords the
/// planned speed ripples by 0.2 % in periods of 3 ms.
pub(crate) const RIPPLE_S: f64 = 0.006;
/// The least speed for the stop of a contour, as a share of the speed limit, such that its rates along the curve stay finite. Not measured.
pub(crate) const CREEPING_SHARE: f64 = 1e-3;
/// The least speed for ramps of the pace that suit the present state, as a share of the trajectory's highest speed: below it a ramp would be so steep
/// that the check of the limits refuses it. Not measured.
pub(crate) const LEAST_RAMP_SPEED_SHARE: f64 = 0.01;
/// The least rate of an axis that does not move, position units/s² or /s³: above 0, so that a time is finite, and below the rates of any machine in
/// millimetres or degrees. Not measured.
pub(crate) const LEAST_RATE_UNITS: f64 = 1e-3;
