//! Tolerances of motion: thresholds for rounding, and for differences too small to show, with the unit in the name. Units: position units,
//! degrees, seconds; shares have none.

/// A following error below this shows as position lock (Position Lock Tolerance's default), position units.
pub(crate) const POSITION_LOCK_UNITS: f64 = 0.01;
/// An actual speed below this shows as standstill, position units/s.
pub(crate) const STANDSTILL_UNITS_PER_S: f64 = 1e-3;
/// An excess of a position over a travel limit below this is rounding, position units.
pub(crate) const TRAVEL_UNITS: f64 = 1e-9;
/// Rounding after some thousand turns, as a share of a turn: a position this little below the unwind is 0.
pub(crate) const UNWIND_SHARE: f64 = 1e-12;
/// Difference of equal programmed positions, as a share of a turn: a move between them is not a whole turn.
pub(crate) const SAME_POSITION_SHARE: f64 = 1e-9;
/// An angle this little above -180 is 180, degrees.
pub(crate) const HALF_TURN_DEG: f64 = 1e-9;
/// Excess of half a rotation, as a share of a rotation.
pub(crate) const HALF_ROTATION_SHARE: f64 = 1e-9;
/// A rotation that passes straight up within this distance changes its angles at once, degrees.
pub(crate) const AT_ONCE_DEG: f64 = 0.05;
/// A leg of homing that ends this little after an update ends with it, seconds.
pub(crate) const SHORTEST_STEP_S: f64 = 1e-9;
/// Rounding far from 0: the error of a command's step, as a share of the position, or of the largest distance of an axis in an update.
pub(crate) const COMMAND_SHARE: f64 = 1e-12;
/// Rounding, as a share of a distance.
pub(crate) const DISTANCE_SHARE: f64 = 1e-9;
/// Error of a master's displacement, as a share of the length of a cam's profile.
pub(crate) const CAM_LENGTH_SHARE: f64 = 1e-12;
/// Excess of a position over the ends of an output cam, as a share of its length.
pub(crate) const OUTPUT_CAM_SHARE: f64 = 1e-12;
/// The least distance before its travel limit within which an axis brakes, position units.
pub(crate) const NO_ROOM_UNITS: f64 = 1e-9;
/// A source axis this close to the position that belongs to its target counts as being there, position units.
pub(crate) const CONSISTENT_UNITS: f64 = 1e-3;
/// A displacement of a joint below this does not count as motion, degrees or position units.
pub(crate) const NO_MOTION_UNITS: f64 = 1e-6;
/// A joint that rotates far within a step of this share of the path turns at once: it is at the origin.
pub(crate) const ORIGIN_STEP_SHARE: f64 = 1.0 / (1 << 20) as f64;
/// Excess of a joint's speed, as a share of its Maximum Speed.
pub(crate) const JOINT_SPEED_SHARE: f64 = 1e-9;
/// Excess of a joint's distance between two samples, as a share of that at its Maximum Speed.
pub(crate) const JOINT_DISTANCE_SHARE: f64 = 1e-3;
/// An excess of a joint's position over its range below this is rounding, position units or degrees.
pub(crate) const JOINT_UNITS: f64 = 1e-9;
/// Least time between two samples of a stop, seconds.
pub(crate) const SHORTEST_SAMPLE_INTERVAL_S: f64 = 2e-5;
/// A coordinated move starts at the position of its axis if it is this close, position units.
pub(crate) const START_UNITS: f64 = 1e-9;
