//! The tuned constants of [`super::requests`] for the time of planning. Those of the plans themselves are `arcline_contour`'s.
//!
//! The streams of `tests/tests/motion/streams.rs` and paths outside of the repository verify them together. No experiment that changes one of them alone
//! is recorded: each states what it trades, and is not measured.

/// Seconds for which the first move of an open contour waits for others, and the end of a trajectory in execution for another move: clients
/// send moves one by one. More time delays a contour of one move, less begins a stream with fewer moves. Not measured.
pub(super) const GATHER_S: f64 = 0.01;
/// So many moves, of this duration in seconds at their programmed speeds, begin without waiting for others: the first plan of a stream would take no more
/// of them. Fewer moves are those of a short program, which is planned better as a whole; less time plans less than the first extension needs. Not measured.
pub(super) const ENOUGH_MOVES: usize = 24;
pub(super) const ENOUGH_S: f64 = 0.35;
/// So many moves begin without waiting for others however short they are: a client that sends as fast as it can has sent them after some 5 ms. Of 60 random
/// streams at 12 moves a millisecond 3 begin after more than 20 ms, before 6, and dense S-curves continue from their end 4 times in 24, before 11; with 100
/// moves 4 and 11.
pub(super) const MANY_MOVES: usize = 64;
/// The same after a contour for which moves arrived too slowly, while the waiting moves last no longer than `LEAST_BEGUN_S`. More time makes each rest
/// longer, less makes rests more frequent. Not measured.
pub(super) const LONGEST_GATHER_S: f64 = 0.1;
/// Waiting moves of at least this duration, seconds, begin at once. Fewer seconds may end before the first extension is planned, more delay the beginning.
/// Not measured.
pub(super) const LEAST_BEGUN_S: f64 = 0.1;
/// A trajectory is extended when the waiting moves are at least its planned ones divided by this number. A larger one extends more often, and plans the
/// end of the trajectory more often. Not measured.
pub(super) const FEW_MOVES: usize = 4;
/// The same while the motion does not brake for the end of the trajectory within the time for planning and `AMPLE_S`: then fewer extensions, of more moves each,
/// are in time. Not measured.
pub(super) const FEW_MOVES_LATER: usize = 2;
/// Seconds until the motion brakes for its end, beside those for planning. Seconds until it is at rest there instead, 0.5: 1.3 to 1.6 times the plans of dense
/// chords at 200 to 400 mm/s, of which a queue of 1,000 moves holds 0.2 to 0.5 s. 0.09: `fine` with trapezoids 47 plans, not 54, and 0.1 % slower; `spiral` with
/// S-curves 0.6 % slower than with 0.17.
pub(super) const AMPLE_S: f64 = 0.12;
/// A trajectory with at most this rest is extended in any case, seconds. More extends for few moves, less leaves no time to plan. Not measured.
pub(super) const NEAR_S: f64 = 0.5;
/// Seconds without a new move after which a trajectory is extended with however few moves wait. More leaves less time for an extension that is hard to
/// find, less extends for each move of a slow sender.
pub(super) const SETTLED_S: f64 = 0.2;
/// The largest share of a trajectory's rest that the planning of its extension is expected to take: the searches of an extension end by themselves in
/// time. Without it, no splice was possible after one plan that took long.
pub(super) const MOST_PLANNING_SHARE: f64 = 0.25;
/// Seconds for planning the first extension, and the least for later ones, which get the planning time of the last one, times `PLANNING_MARGIN`. More
/// splices later, so that less of the trajectory can change; less makes plans late. Not measured; an extension that was found took 6 to 10 ms
/// on dense chords (`contour/NOTES.md`, *Extensions of dense chords*).
pub(super) const PLANNING_S: f64 = 0.03;
/// Most seconds for planning an extension: a late plan doubles the time of the next one, and without a bound a trajectory would never be long enough. Not
/// measured.
pub(super) const MOST_PLANNING_S: f64 = 3.0;
/// Time for a plan, as a multiple of the planning time of the last one: more splices later, less makes plans late. Not measured.
pub(super) const PLANNING_MARGIN: f64 = 1.5;
/// Share of a trajectory's rest that must pass before a failed extension is tried again. Less repeats the failure from almost the same state, more leaves
/// less rest for the next attempt. Not measured.
pub(super) const RETRY_SHARE: f64 = 0.3;
/// The same for a failed plan of the rest: smaller, as the motion continues at its pace meanwhile and does not come to rest. Not measured.
pub(super) const RETRY_ANEW_SHARE: f64 = 0.1;
/// Seconds without a change after which moves that changed are planned anew. Less plans for each step of an override that is turned, more stays longer at
/// the pace of the old plan. Not measured.
pub(super) const UNCHANGED_S: f64 = 0.1;
/// Duration of a long move, seconds: such a move is planned at full speed under a low override, as a plan anew within it could not raise its speed in
/// time. Less plans more moves faster than they are travelled, more lets an override rise late. Not measured.
pub(super) const LONG_MOVE_S: f64 = 0.7;
/// The least pace, as a share of the planned one, at which a slower trajectory is planned anew: a plan for a lower one would take several times as long
/// as the present one, and be replaced when the override rises. Not measured.
pub(super) const LEAST_PACE_SHARE: f64 = 0.2;
/// The least rest of a trajectory that is planned anew, seconds: a plan of less is not in time. Not measured.
pub(super) const LEAST_LEFT_S: f64 = 0.1;
/// Seconds after which the plan of an extension is late; of S-curves not before the time reserved for it is over, at least 30 ms: their pace falls slowly,
/// and an extension that comes meanwhile does not suit it. Of 50,000 moves of `fine` with S-curves, each plan 50 ms late, 3 rested, before 6, and the motion
/// took 8 % less time; trapezoids, each plan 120 ms late, rested more often with it, and took 1 % longer.
pub(super) const LATE_S: f64 = 0.025;
/// Rest of a trajectory, seconds, below which its pace is lower while the plan of its extension is late: of trapezoids, and of S-curves, whose pace falls more
/// slowly. Of 252 random streams whose plans come after 120 ms, 49 rested, now 23 (0.2 and 0.35), and 19 with 0.35 for both, but trapezoids then took 3 % longer.
pub(super) const LATE_LEFT_S: [f64; 2] = [0.2, 0.35];
/// That pace. Others are not measured.
pub(super) const WAITING_PACE: f64 = 0.25;
