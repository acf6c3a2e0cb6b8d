//! The tuned constants of the planner, by subject. Not here: values of the specification and of formulas, which are defined at their use.
//!
//! Experiments: times are sums over 8 benchmark and 24 random plans, extensions and replans (14.738 s of motion, 1 rest, 2.13M steps of nodes) with
//! one constant changed. Names end in the unit where there is one: `_s` seconds, `_units` position units, `_share` a part of a limit or length.

/// A struct of constants: each field with its meaning, type and value in one line.
macro_rules! constants {
    ($(#[$about:meta])* $name:ident { $($(#[$meaning:meta])* $field:ident: $kind:ty = $value:expr,)* }) => {
        $(#[$about])*
        pub(crate) struct $name { $($(#[$meaning])* pub(crate) $field: $kind,)* }
        impl $name {
            const VALUES: $name = $name { $($field: $value,)* };
        }
    };
}

/// All tuned constants.
pub(crate) struct Tuning {
    pub(crate) corridor: Corridor,
    pub(crate) margin: Margin,
    pub(crate) rounding: Rounding,
    pub(crate) smooth: Smooth,
    pub(crate) grid: Grid,
    pub(crate) speed_profile: SpeedProfile,
    pub(crate) stages: Stages,
    pub(crate) work: Work,
    pub(crate) barrier: Barrier,
    pub(crate) relax: Relax,
    pub(crate) extend: Extend,
    pub(crate) warm_start: WarmStart,
    pub(crate) joined: Joined,
    pub(crate) gentle: Gentle,
}

pub(crate) const TUNING: Tuning = Tuning {
    corridor: Corridor::VALUES,
    margin: Margin::VALUES,
    rounding: Rounding::VALUES,
    smooth: Smooth::VALUES,
    grid: Grid::VALUES,
    speed_profile: SpeedProfile::VALUES,
    stages: Stages::VALUES,
    work: Work::VALUES,
    barrier: Barrier::VALUES,
    relax: Relax::VALUES,
    extend: Extend::VALUES,
    warm_start: WarmStart::VALUES,
    joined: Joined::VALUES,
    gentle: Gentle::VALUES,
};

constants! {
    /// The corridor within which the optimisation keeps the curve.
    Corridor {
        /// Share of the tolerance for a long piece; a hundredth is permitted.
        aim_straight_share: f64 = 0.006,
        /// Share of the length of a rounding: the corridor is narrow from half the distance of two nodes before its end on.
        aim_reach_share: f64 = 0.9,
        /// Lengths of a rounding within which the middle between two knots also counts.
        near_reaches: f64 = 2.0,
        /// The opening of the corridor's cone at the ends at which the motion rests, units per unit.
        /// Four times as fast: +0.15 %, 3 rests.
        cone: f64 = 0.25,
    }
}

constants! {
    /// The share of the tolerance for the knots, such that the curve between them stays inside.
    Margin {
        /// The share at first.
        usual_share: f64 = 0.98,
        /// The quotient above which the corridor is narrowed.
        inside: f64 = 0.999,
        /// The quotient after narrowing.
        target: f64 = 0.975,
        /// Least factor of one narrowing if the curve keeps close to some pieces: the curve may be outside by many of their corridors before it
        /// comes inside.
        /// 0.18 instead: no difference.
        least_factor: f64 = 0.6,
        /// Points measured between two knots.
        parts: usize = 4,
        /// The quotient from which on the largest one between the measured points is searched for, if the curve keeps close to some piece.
        close: f64 = 0.5,
        /// Nodes about an edge of the corridor between which the motion passes it, and halvings that find the instant.
        edge_nodes: usize = 3,
        edge_halvings: usize = 40,
        /// Steps of the secant method that find the instant at which the motion passes a joint.
        joint_steps: usize = 3,
    }
}

constants! {
    /// The first curve inside the corridor.
    Rounding {
        /// Share of the tolerance that it uses.
        inside_share: f64 = 0.9,
        /// Largest share of its radius that an arc covers within a rounding: half a radian.
        arc_share: f64 = 0.5,
        /// Factor by which a rounding beside an arc is shortened until it is inside, and the number of shortenings.
        shorten: f64 = 0.7,
        shortenings: u32 = 60,
        /// Points of it that are measured.
        measured: u32 = 32,
        /// Samples of it for the speed profile.
        samples: usize = 24,
        /// Samples of a line for the whole length of the reference path, at least and at most for each.
        line_samples: [f64; 3] = [400.0, 4.0, 200.0],
        /// Samples of an arc for each radian, at least and at most for each.
        arc_samples: [f64; 3] = [20.0, 8.0, 1000.0],
    }
}

constants! {
    /// The smooth curve in place of dense chords ([`crate::path::smooth`]).
    Smooth {
        /// Seconds between two nodes in busy stretches.
        node_s: f64 = 0.002,
        /// Length of the pieces beside a joint, as a share of the way between two nodes, and the roughness of the joint (difference of unit vectors) from
        /// which on the curve is held inside the corridor there too.
        /// Never: `rough` with trapezoids 0.8 of the motion instead of 0.13; for every joint that turns: `coarse` with trapezoids 0.053 instead of 0.03.
        joint_share: f64 = 0.4,
        rough: f64 = 0.02,
        /// A change of direction (of a unit vector) whose corner has nodes of its own.
        sharp: f64 = 0.35,
        /// The least number of moves for a smooth curve, and the moves for each permitted sharp corner.
        least_moves: usize = 24,
        most_sharp: usize = 3,
        /// Rounds of springs.
        rounds: usize = 12,
        /// The weight of a node's jerk relative to the logarithm of the room to the wall: of a jerk that reaches the least
        /// acceleration limit within this number of seconds.
        stiffness: f64 = 20.0,
        jerk_s: f64 = 0.05,
        /// Share of the corridor that it uses, and share of its room for a point outside.
        inside_share: f64 = 0.95,
        least_room: f64 = 1e-7,
        /// Nodes behind the given ones beside which the corridor is as wide as the running motion needs it: this multiple of its distance, and at
        /// most this share of the corridor.
        beside_nodes: usize = 24,
        beside_off: f64 = 1.02,
        most_begun: f64 = 0.995,
        /// Share of the distance to the wall for one step.
        most_step: f64 = 0.8,
        /// Most repeated attempts of a continuation to close in on its limits.
        closing: usize = 3,
        /// Excess after an attempt beyond which a further one does not come inside.
        far: f64 = 1.8,
        /// Largest share of an excess that may remain after another attempt.
        nearer: f64 = 0.97,
        /// Most repetitions of the timing with a narrower corridor where the curve was outside.
        repairs: usize = 6,
        /// Fixed nodes at an end: three determine the position, velocity and acceleration of the motion there.
        held_ends: usize = 3,
        /// The spring of a fixed node, far above all others.
        held_spring: f64 = 1e14,
    }
}

constants! {
    /// The distances between nodes.
    Grid {
        /// Seconds between two nodes of a short motion.
        /// 2 ms: +0.02 %, a third less work.
        node_s: f64 = 0.001,
        /// The least number of nodes of a whole motion, and the largest of its busy part: alone, for each piece, and in total.
        least_nodes: f64 = 160.0,
        most_nodes_alone: f64 = 4000.0,
        most_nodes_each: f64 = 200.0,
        most_nodes: f64 = 24_000.0,
        /// Seconds beside a busy stretch in which nodes stay close, and the growth of the distance per second beyond.
        quiet_s: f64 = 0.25,
        growth: f64 = 0.08,
        /// Most busy stretches whose quiet neighbourhood counts.
        most_quiet: usize = 1000,
        /// Nodes in the rounding of a corner beside a piece that the curve keeps close to, the shortest time between two, and the
        /// growth of that time per second beyond.
        /// 10 nodes: +0.6 %, 5 % more work, as fewer come inside.
        rounding_nodes: f64 = 20.0,
        finest_s: f64 = 5e-5,
        spread: f64 = 0.2,
        /// Share of the acceleration limit below which a stretch is not busy.
        idle_share: f64 = 1e-3,
    }
}

constants! {
    /// The speed profile that places the first nodes.
    SpeedProfile {
        /// Shares of the acceleration limits across and along the curve, and of the jerk limits.
        normal_share: f64 = 0.8,
        tangent_share: f64 = 0.9,
        jerk_share: f64 = 0.6,
        /// Shares of the limits of acceleration and jerk for the continuation of a running motion along dense chords, seconds between
        /// the points of that motion, and the least share of its speed.
        gentle_rate_share: f64 = 0.6,
        gentle_jerk_share: f64 = 0.5,
        gentle_step_s: f64 = 0.000_5,
        gentle_least_share: f64 = 0.1,
    }
}

/// One run of the optimisation: weights of the time, growing by [`Stages::factor`], and Gauss-Newton steps for each.
pub(crate) struct StageTuning {
    pub(crate) first: f64,
    pub(crate) last: f64,
    pub(crate) steps: usize,
}

const fn stage(first: f64, last: f64, steps: usize) -> StageTuning {
    StageTuning { first, last, steps }
}

constants! {
    /// The runs of the optimisation that make up a plan.
    Stages {
        /// For a trapezoid: timing alone; timing and shape, twice.
        timing: StageTuning = stage(1.0, 1000.0, 8),
        shape: [StageTuning; 2] = [stage(1.0, 300.0, 8), stage(5.0, 1000.0, 8)],
        /// For an S-curve, first without limits of jerk.
        /// None of it: -0.01 % on these short paths; dense polylines do not converge without it (flower 2.24 s, not 1.99 s).
        without_jerk: StageTuning = stage(1.0, 30.0, 8),
        timing_with_jerk: StageTuning = stage(1.0, 1000.0, 8),
        shape_with_jerk: [StageTuning; 2] = [stage(1.0, 300.0, 12), stage(5.0, 1000.0, 8)],
        /// The last one, and most repetitions with a narrower corridor where its result was outside.
        last: StageTuning = stage(10.0, 2000.0, 8),
        /// 2 repairs: no difference here.
        repairs: usize = 4,
        /// Factor of the weight of the time from one to the next.
        /// 10: +0.07 %, 8 % less work.
        factor: f64 = 5.0,
        /// Excess of a continuation after a repair up to which it may still come inside.
        hopeless: f64 = 1.2,
        /// Most multiples of the permitted distance from the reference path after any stage. Motions that came inside never exceeded 1.3; most
        /// of the others began at 5 to 12.
        astray: f64 = 2.0,
    }
}

constants! {
    /// The budget of one planning call, in visits of one node ([`crate::solve::work::Work`]): a fixed part for any motion, and a part
    /// for each node of the first guess.
    Work {
        /// A section from rest. A surface of 1,000 chords needs 900 visits of each of 5,300 nodes, as most steps are shortened many
        /// times; 1M visits take about 0.3 s.
        from_rest: u64 = 5_000_000,
        from_rest_each: u64 = 3000,
        /// All attempts to continue a motion. Of 75 extensions of the benchmark's paths in windows the 68 that were found took 81 to 439
        /// steps; without a bound those that were not took up to 7,600.
        to_continue: u64 = 1_000_000,
        to_continue_each: u64 = 1000,
    }
}

constants! {
    /// Steps of the barrier method.
    Barrier {
        /// Newton decrement per node at which a weight is complete.
        /// 1e-2: -0.1 %, a fifth less work.
        converged: f64 = 1e-3,
        /// A step that leaves less than this share of a slack is shortened.
        /// 0.12: -0.1 %.
        nearer_share: f64 = 0.03,
        /// Room for a point outside the corridor, as a share of its distance.
        widen_share: f64 = 0.02,
        /// A point this close to the corridor's wall is outside with other spans; and its new room.
        touching: f64 = 1e-5,
        reweighed: f64 = 2e-3,
        /// Largest change of a span's logarithm in one step.
        most_change: f64 = 1.0,
        /// Most attempts to shorten one step, and those of them near critical nodes only.
        attempts: u32 = 24,
        local_attempts: u32 = 16,
        /// Share of the expected decrease that a step must reach.
        sufficient: f64 = 1e-4,
        /// Relative lift of the matrix's diagonal.
        lift: f64 = 1e-9,
        /// Nodes to either side over which a shortening of the step is spread.
        /// 12 nodes: +0.4 %, 3 rests.
        spread_nodes: usize = 48,
        /// The range in which a product can take the factors of another node before its logarithm is due: a third of the exponents of `f64`.
        least_product: f64 = 1e-100,
        most_product: f64 = 1e100,
    }
}

constants! {
    /// Starts outside the limits.
    Relax {
        /// Quotient of limits at which the barrier starts, the factor by which spans grow to reach it, and the largest number of such steps.
        /// 0.42: -0.05 %, 4 % less work.
        feasible: f64 = 0.7,
        lengthen: f64 = 1.2,
        lengthenings: u32 = 200,
        /// Distance of a quotient from 1 from which on it is kept with a margin.
        inside: f64 = 1e-5,
        /// The weight of a relaxed limit, such that the other limits do not push the excess to it.
        /// 1: +1 %, 2 rests and a replan not found, a third more work.
        weight: f64 = 30.0,
        /// Quotient above which a start is slowed down, and the nodes over which it is.
        far: f64 = 1.5,
        ramp_nodes: f64 = 80.0,
        /// Nodes to either side of one outside its limits whose timing alone is slowed down; and as many more that lead there.
        spread_nodes: usize = 60,
        /// Nodes at the end that do not count for that.
        end_nodes: usize = 4,
        /// The share of a limit that counts as full for a continuation: close to its limit, the hull of the spline is a little wider
        /// than the motion itself, which is measured at the end.
        near_full: f64 = 0.9995,
        /// Further steps for each weight in which relaxed limits close in.
        /// 12: no difference here.
        most_closing: usize = 24,
        /// Room for an exceeded limit, and the least of it, as shares of the quotient.
        widen_share: f64 = 0.3,
        least_share: f64 = 1e-3,
    }
}

constants! {
    /// The splice of a running trajectory, and the length of its extension.
    Extend {
        /// Seconds before the braking at which the warm start leaves it.
        settle_s: f64 = 0.06,
        /// Times of braking before its end at which the warm start leaves it.
        /// 1 time: no difference here.
        brakings: f64 = 1.5,
        /// Seconds after a stop up to which the plan starts at the stop instead.
        after_stop_s: f64 = 0.01,
        /// Seconds at programmed speed, and the least number of moves, to plan before a motion begins.
        first_s: f64 = 0.4,
        first_moves: usize = 4,
        /// Seconds of one extension, about: at least and at most; and the least number of moves.
        least_s: f64 = 0.25,
        most_s: f64 = 0.8,
        least_moves: usize = 12,
        /// One in this number of dense chords may be an arc.
        most_arcs: usize = 4,
        /// Rest of the running motion, seconds, below which a slower instant of it is tried second.
        /// 0: `fine` with S-curves 0.33 of the motion instead of 0.18; always: `coarse` +0.65 %, `islands` +0.2 % with S-curves.
        short_s: f64 = 0.4,
        /// Seconds by which the splice is later after an attempt that ended far outside the limits.
        slower_s: f64 = 0.03,
        /// Rest of the running motion, seconds, from which on timing and shape are planned together.
        ample_s: f64 = 0.3,
        /// Share of the moves to plan if no plan for all is found.
        less_share: f64 = 0.25,
        /// Least time to follow the running motion, and least rest of it, seconds.
        least_followed_s: f64 = 0.004,
        least_left_s: f64 = 0.008,
        /// Splices to try for a plan anew, and seconds between them.
        attempts: u32 = 3,
        later_s: f64 = 0.02,
        /// Instants to examine for a splice, and seconds between them.
        choice: u32 = 30,
        choice_step_s: f64 = 0.001,
        /// Weight of the used share of the acceleration, relative to that of the tolerance.
        acceleration_weight: f64 = 0.3,
        /// Seconds for which a plan anew follows the trajectory.
        replan_followed_s: f64 = 0.01,
        /// Seconds, and the least number of moves, of a plan anew.
        replan_s: f64 = 1.0,
        replan_least_moves: usize = 4,
        /// Seconds beyond which planning anew would take too long: the motion keeps its pace.
        replan_most_ahead_s: f64 = 4.0,
    }
}

constants! {
    /// The warm start of a continuation.
    WarmStart {
        /// Shortest time between the knots of a followed motion, and the longest as a multiple of the time between two nodes.
        least_span_s: f64 = 2e-5,
        most_span_nodes: f64 = 2.0,
        /// Seconds from point to point of a followed motion.
        step_s: f64 = 5e-4,
        /// Seconds, and the least distance in position units, in which the offset from the rounded path fades out.
        fade_s: f64 = 0.015,
        least_fade_units: f64 = 1e-6,
        /// Least distance of the first step behind the followed motion, position units.
        least_step_units: f64 = 1e-7,
    }
}

constants! {
    /// The joined warm start of a continuation ([`crate::extend::warm_start_joined`]).
    Joined {
        /// Seconds by which a difference of speeds is divided to compare it with one of accelerations.
        soon_s: f64 = 0.01,
        /// Other instants of the second motion to examine near the one at the same arc length, and seconds between them.
        shifts: i32 = 4,
        shift_s: f64 = 2.5e-4,
        /// Least time to follow the running motion.
        least_followed_s: f64 = 0.004,
        /// Knots closer than this would coincide.
        least_span_s: f64 = 2e-4,
        /// The sum of shares of tolerance, speed and acceleration up to which two motions are alike.
        most_unlike: f64 = 1.5,
    }
}

constants! {
    /// The continuation on evenly rounded corners, within all limits from the warm start on ([`crate::extend::gentle`]).
    Gentle {
        /// The interval in which the continuation may leave the running motion, in seconds before its last braking and as a share of
        /// that braking; and the number of instants in it.
        before_s: f64 = 0.15,
        latest_share: f64 = 0.9,
        leaves: usize = 40,
        /// Most possible instants among those to try.
        attempts: usize = 12,
        /// Seconds of one extension, as a share of the usual ones.
        ahead_share: f64 = 0.5,
        /// Share of the limits for changes of the speed where the path turns.
        turning_share: f64 = 0.3,
        /// Share of the permitted speed of a stretch at which a running motion may enter it.
        entry_share: f64 = 0.95,
        /// Least time of a change of the acceleration, seconds.
        step_s: f64 = 0.005,
        /// Nodes of a rounding, and of one beside a piece that the curve keeps close to.
        rounding_nodes: [f64; 2] = [8.0, 16.0],
        /// Points of a rounding at which its limits are sampled. Without an experiment.
        rounding_samples: u32 = 16,
        /// Tangents (unit vectors) with a larger difference form a corner. Without an experiment: a thousand times
        /// [`crate::tolerance::SAME_TANGENT_SINE`].
        corner: f64 = 1e-3,
        /// Points of the fading offset at which its position and rates are sampled. Without an experiment.
        fade_samples: u32 = 16,
        /// Share of the limits for the offset that fades out.
        fade_share: f64 = 0.2,
        /// The least and the longest time in which it fades out, seconds, and the factor from one trial to the next.
        fade_s: [f64; 2] = [0.004, 0.1],
        fade_factor: f64 = 1.3,
        /// Ratio of the speeds of a smooth curve within one part, and the least number of nodes of a part.
        alike: f64 = 1.25,
        least_part: f64 = 4.0,
        /// Most instants at which the continuation leaves the running motion for a smooth curve.
        smooth_attempts: usize = 6,
        /// Most smoothings of the curve if it is outside with the times of the faster motion.
        repairs: usize = 3,
    }
}
