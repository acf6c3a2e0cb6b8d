//! Tolerances of motion: thresholds for rounding, and for differences too small to show, with the unit in the name. Units: position units,
//! degrees, seconds; shares have none.
//!
//! One rounding of an `f64` is at most 1.1e-16 of the number: 6e-11 position units at a million. A tolerance that no rounding explains says what it
//! trades; "not measured" means that its figure is a choice.

/// A following error below this shows as position lock, position units: the default of Position Lock Tolerance
/// (spec/axis-and-data-types.md §9.3).
pub(crate) const POSITION_LOCK_UNITS: f64 = 0.01;
/// An actual speed below this shows as standstill, position units/s: 1 nm in an update of 1 ms with millimetres. Not measured.
pub(crate) const STANDSTILL_UNITS_PER_S: f64 = 1e-3;
/// An excess of a position over a travel limit below this is rounding, position units: 17 roundings of a position of a million units.
pub(crate) const TRAVEL_UNITS: f64 = 1e-9;
/// Rounding after some thousand turns, as a share of a turn: a position this little below the unwind is 0. 1,000 turns have a rounding of at most
/// 1.1e-13 of a turn.
pub(crate) const UNWIND_SHARE: f64 = 1e-12;
/// Difference of equal programmed positions, as a share of a turn: a move between them is not a whole turn (spec/axis-and-data-types.md §3.4).
pub(crate) const SAME_POSITION_SHARE: f64 = 1e-9;
/// An angle this little above -180 is 180, degrees: 35,000 roundings of an angle of one turn.
pub(crate) const HALF_TURN_DEG: f64 = 1e-9;
/// Excess of half a rotation, as a share of a rotation: far above the rounding of angles that 16 samples have followed, and
/// far below a programmed difference.
pub(crate) const HALF_ROTATION_SHARE: f64 = 1e-9;
/// A rotation that passes straight up within this distance changes its angles at once, degrees. A sample of half a turn, 11 degrees, is
/// halved eight times until it is shorter; a smaller distance takes more of the samples, which are limited. Not measured.
pub(crate) const ANGLES_AT_ONCE_DEG: f64 = 0.05;
/// A change of Rx or Rz between two samples of a rotation from which the samples are too far apart, degrees: a rotation by 11 degrees,
/// the longest between two samples, changes them as much only within 11 degrees of straight up. Not measured.
pub(crate) const ANGLES_FAR_DEG: f64 = 60.0;
/// A leg of homing that ends this little after an update ends with it, seconds: far above the rounding of an instant, a millionth of an update of
/// 1 ms.
pub(crate) const SHORTEST_STEP_S: f64 = 1e-9;
/// Rounding far from 0: the error of a command's step, as a share of the position, or of the largest distance of an axis in an update. A step is
/// the difference of two sums of generators: 9,000 roundings of the position.
pub(crate) const COMMAND_SHARE: f64 = 1e-12;
/// Rounding, as a share of a distance: far above the errors of two planned stops (`arcline_profile` plans them to 2e-15), far below a visible one.
pub(crate) const DISTANCE_SHARE: f64 = 1e-9;
/// Error of a master's displacement, as a share of the length of a cam's profile: 9,000 roundings, as the displacement is the difference of positions
/// that may be far from 0.
pub(crate) const CAM_LENGTH_SHARE: f64 = 1e-12;
/// Excess of a position over the ends of an output cam, as a share of its length: [`CAM_LENGTH_SHARE`] for the axis of an output cam.
pub(crate) const OUTPUT_CAM_SHARE: f64 = 1e-12;
/// The least distance before its travel limit within which an axis brakes, position units: [`TRAVEL_UNITS`], as the axis may be there already. It keeps
/// the deceleration finite.
pub(crate) const NO_ROOM_UNITS: f64 = 1e-9;
/// A source axis this close to the position that belongs to its target counts as being there, position units
/// (spec/coordinated-instructions.md §19.1).
pub(crate) const CONSISTENT_UNITS: f64 = 1e-3;
/// A displacement of a joint below this does not count as motion, degrees or position units: a joint that reverses within it cannot exceed a limit
/// visibly, and a search for its reversal would take samples from others. Not measured.
pub(crate) const NO_MOTION_UNITS: f64 = 1e-6;
/// A joint that rotates far within a step of this share of the path turns at once: it is at the origin. Fifteen halvings of one of
/// the 32 steps of a path. Not measured.
pub(crate) const ORIGIN_STEP_SHARE: f64 = 1.0 / (1 << 20) as f64;
/// A rotation of a joint between two samples of a path from which the samples are too far apart, degrees: the joint must not be taken for one that
/// turns the other way round, and more samples cost more time. Not measured.
pub(crate) const JOINT_FAR_DEG: f64 = 5.0;
/// Share of the speeds and rates of a joint that a path may use at its samples: the rest is for what the joint does between two of them. Not measured.
pub(crate) const SAMPLED_LIMIT_SHARE: f64 = 0.98;
/// A joint with a larger displacement between two samples at the smallest interval, or between two updates, turns at once, degrees: 10 degrees in
/// [`SHORTEST_SAMPLE_INTERVAL_S`] are 500,000 degrees a second. Between updates of 1 ms they are 10,000, more than any joint's. Not measured.
pub(crate) const JOINT_AT_ONCE_DEG: f64 = 10.0;
/// Excess of a joint's speed over its Maximum Speed from which the source leads it no longer: the error between two samples of a stop
/// (spec/coordinated-instructions.md §19.8).
pub(crate) const SAMPLE_ERROR_SHARE: f64 = 0.02;
/// Excess of a joint's speed, as a share of its Maximum Speed: 9 million roundings, as the derivatives of an arm lose digits where it is
/// almost stretched.
pub(crate) const JOINT_SPEED_SHARE: f64 = 1e-9;
/// The same share for a distance between two samples, or for the speed in their middle, which a cubic through both estimates: larger, as its error is
/// more than rounding. Not measured.
pub(crate) const JOINT_DISTANCE_SHARE: f64 = 1e-3;
/// Difference between the speed of a joint in the middle of an interval and the mean of those at the ends, as a share of its Maximum Speed,
/// above which the interval is divided: a smaller share finds narrower peaks of the speed, and takes more samples in a tick. Not measured.
pub(crate) const ODD_SPEED_SHARE: f64 = 0.25;
/// An excess of a joint's position over its range below this is rounding, position units or degrees: 17 roundings of a position of a million units.
pub(crate) const JOINT_UNITS: f64 = 1e-9;
/// Least time between two samples of a stop, seconds: a 50th of an update of 1 ms. It bounds the samples in a tick where a joint would turn at once. Not
/// measured.
pub(crate) const SHORTEST_SAMPLE_INTERVAL_S: f64 = 2e-5;
/// A coordinated move starts at the position of its axis if it is this close, position units: 17 roundings of a position of a million units.
pub(crate) const START_UNITS: f64 = 1e-9;
