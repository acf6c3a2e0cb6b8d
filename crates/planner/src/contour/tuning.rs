//! When contours are planned: the tuned constants of [`super::requests`]. Those of the plans themselves are `arcline_contour`'s.
//!
//! No experiment stands beside them: the streams of `tests/tests/motion/streams.rs` and the paths outside of the repository hold them.

/// How long the first move of a contour without an end waits for others, and the end of one that runs for another move, seconds: clients
/// send them one by one.
pub(super) const GATHER_S: f64 = 0.01;
/// The same behind a contour for which moves came too slowly, seconds, while the moves that wait last no longer than `LEAST_BEGUN_S`.
pub(super) const LONGEST_GATHER_S: f64 = 0.1;
/// Duration of waiting moves, seconds, from which on they begin at once.
pub(super) const LEAST_BEGUN_S: f64 = 0.1;
/// A trajectory is extended when one move waits for so many that are planned.
pub(super) const FEW_MOVES: usize = 4;
/// The same while more than `AMPLE_S` of it are left.
pub(super) const FEW_MOVES_LATER: usize = 2;
/// The rest of a trajectory that need not be extended soon, seconds.
pub(super) const AMPLE_S: f64 = 0.5;
/// The rest of a trajectory that is extended in any case, seconds.
pub(super) const NEAR_S: f64 = 0.5;
/// Seconds that the first extension may take to be planned. Later ones may take as long as the one before, times `PLANNING_MARGIN`.
pub(super) const PLANNING_S: f64 = 0.03;
/// Seconds that an extension may take at most.
pub(super) const MOST_PLANNING_S: f64 = 3.0;
/// Time for a plan, as a multiple of the time that the last one took.
pub(super) const PLANNING_MARGIN: f64 = 1.5;
/// Share of what is left of a trajectory before which an extension that failed is not tried again.
pub(super) const RETRY_SHARE: f64 = 0.3;
/// The same of a plan of what is left.
pub(super) const RETRY_ANEW_SHARE: f64 = 0.1;
/// Seconds without a change after which moves that changed are planned anew.
pub(super) const UNCHANGED_S: f64 = 0.1;
/// Duration of a long move, seconds.
pub(super) const LONG_MOVE_S: f64 = 0.7;
/// A slower pace, as a share of the planned one, is not planned anew.
pub(super) const LEAST_PACE_SHARE: f64 = 0.2;
/// A shorter rest of a trajectory, seconds, is not planned anew.
pub(super) const LEAST_LEFT_S: f64 = 0.1;
