//! Tolerances of motion: what is rounding or too little to show, with its unit in its name. Units: position units, degrees, seconds;
//! shares have none.

/// A following error below this shows as position lock (Position Lock Tolerance's default), position units.
pub(crate) const POSITION_LOCK_UNITS: f64 = 0.01;
/// An actual speed below this shows as standstill, position units/s.
pub(crate) const STANDSTILL_UNITS_PER_S: f64 = 1e-3;
/// A position beyond a travel limit by less than this is rounding, position units.
pub(crate) const TRAVEL_UNITS: f64 = 1e-9;
/// Share of a turn that some thousand turns leave as rounding: so little below the unwind is 0.
pub(crate) const UNWIND_SHARE: f64 = 1e-12;
/// Share of a turn by which two equal programmed positions may differ: a move between them is no whole turn.
pub(crate) const SAME_POSITION_SHARE: f64 = 1e-9;
/// An angle this little above -180 is 180, degrees.
pub(crate) const HALF_TURN_DEG: f64 = 1e-9;
/// Share of a rotation by which half of one may be exceeded.
pub(crate) const HALF_ROTATION_SHARE: f64 = 1e-9;
/// The angles of a rotation that passes straight up nearer than this change at once, degrees.
pub(crate) const AT_ONCE_DEG: f64 = 0.05;
/// A leg of homing that ends this little behind an update ends with it, seconds.
pub(crate) const SHORTEST_STEP_S: f64 = 1e-9;
/// Share of a position, or of the most that an axis moves in an update, by which a step of its command may be off: rounding far from
/// 0.
pub(crate) const COMMAND_SHARE: f64 = 1e-12;
/// Share of a distance that is rounding.
pub(crate) const DISTANCE_SHARE: f64 = 1e-9;
/// Share of the length of a cam's profile by which a displacement of its master may be off.
pub(crate) const CAM_LENGTH_SHARE: f64 = 1e-12;
/// Share of the length of an output cam by which a position may be beyond its ends.
pub(crate) const OUTPUT_CAM_SHARE: f64 = 1e-12;
/// The least room that an axis has to brake in before its travel limit, position units.
pub(crate) const NO_ROOM_UNITS: f64 = 1e-9;
/// A source axis this near stands where its target says, position units.
pub(crate) const CONSISTENT_UNITS: f64 = 1e-3;
/// A motion of a joint that is none, degrees or position units.
pub(crate) const NO_MOTION_UNITS: f64 = 1e-6;
/// A joint that turns far in a step of this share of the path turns at once: it is at the origin.
pub(crate) const ORIGIN_STEP_SHARE: f64 = 1.0 / (1 << 20) as f64;
/// Share of its Maximum Speed by which a joint may be too fast.
pub(crate) const JOINT_SPEED_SHARE: f64 = 1e-9;
/// The same share for a distance between two looks.
pub(crate) const JOINT_DISTANCE_SHARE: f64 = 1e-3;
/// A position of a joint beyond its range by less than this is rounding, position units or degrees.
pub(crate) const JOINT_UNITS: f64 = 1e-9;
/// Time between two looks at a stop, at least, seconds.
pub(crate) const SHORTEST_LOOK_S: f64 = 2e-5;
/// A coordinated move starts where its axis is if it is this near, position units.
pub(crate) const START_UNITS: f64 = 1e-9;
