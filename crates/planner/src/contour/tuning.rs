//! The tuned constants of [`super::requests`] for the time of planning. Those of the plans themselves are `arcline_contour`'s.
//!
//! No experiment determines them: the streams of `tests/tests/motion/streams.rs` and paths outside of the repository verify them.

/// Seconds for which the first move of an open contour waits for others, and the end of a trajectory in execution for another move: clients
/// send moves one by one.
pub(super) const GATHER_S: f64 = 0.01;
/// The same after a contour for which moves arrived too slowly, while the waiting moves last no longer than `LEAST_BEGUN_S`.
pub(super) const LONGEST_GATHER_S: f64 = 0.1;
/// Waiting moves of at least this duration, seconds, begin at once.
pub(super) const LEAST_BEGUN_S: f64 = 0.1;
/// A trajectory is extended when the waiting moves are at least its planned ones divided by this number.
pub(super) const FEW_MOVES: usize = 4;
/// The same while more than `AMPLE_S` of the trajectory are left.
pub(super) const FEW_MOVES_LATER: usize = 2;
/// A trajectory with at least this rest need not be extended soon, seconds.
pub(super) const AMPLE_S: f64 = 0.5;
/// A trajectory with at most this rest is extended in any case, seconds.
pub(super) const NEAR_S: f64 = 0.5;
/// Seconds for planning the first extension. Later ones get the planning time of the last one, times `PLANNING_MARGIN`.
pub(super) const PLANNING_S: f64 = 0.03;
/// Most seconds for planning an extension.
pub(super) const MOST_PLANNING_S: f64 = 3.0;
/// Time for a plan, as a multiple of the planning time of the last one.
pub(super) const PLANNING_MARGIN: f64 = 1.5;
/// Share of a trajectory's rest that must pass before a failed extension is tried again.
pub(super) const RETRY_SHARE: f64 = 0.3;
/// The same for a failed plan of the rest.
pub(super) const RETRY_ANEW_SHARE: f64 = 0.1;
/// Seconds without a change after which moves that changed are planned anew.
pub(super) const UNCHANGED_S: f64 = 0.1;
/// Duration of a long move, seconds.
pub(super) const LONG_MOVE_S: f64 = 0.7;
/// The least pace, as a share of the planned one, at which a slower trajectory is planned anew.
pub(super) const LEAST_PACE_SHARE: f64 = 0.2;
/// The least rest of a trajectory that is planned anew, seconds.
pub(super) const LEAST_LEFT_S: f64 = 0.1;
