//! The tuned constants of the planner, by subject. Not here: values of the specification and of formulas, which stand where they are used.
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

/// All of them.
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
    /// How far from the reference path the optimisation lets the curve be.
    Corridor {
        /// Share of the tolerance that it uses on a long piece, of the hundredth that is allowed.
        aim_straight_share: f64 = 0.006,
        /// Share of the reach of a rounding that it uses: the corridor is narrow from half the distance of two nodes before its end on.
        aim_reach_share: f64 = 0.9,
        /// Reaches of a rounding within which the middle between two knots counts too.
        near_reaches: f64 = 2.0,
        /// How fast the corridor opens at the ends at which the motion rests, units per unit.
        /// Four times as fast: +0.15 %, 3 rests.
        cone: f64 = 0.25,
    }
}

constants! {
    /// How much of the tolerance the knots may use, so that the curve between them stays inside.
    Margin {
        /// Share where nothing else is known.
        usual_share: f64 = 0.98,
        /// Above this quotient the corridor is tightened.
        inside: f64 = 0.999,
        /// The quotient that tightening aims at.
        target: f64 = 0.975,
        /// Least factor of one narrowing where pieces are kept to: the curve may be outside by many of their corridors before it
        /// has come inside.
        /// 0.18 instead: no difference.
        least_factor: f64 = 0.6,
        /// Points measured between two knots.
        parts: usize = 4,
        /// From this quotient on, the largest one between the measured points is looked for, where any piece is kept to.
        close: f64 = 0.5,
        /// Nodes about an edge of the corridor between which the motion passes it, and halvings that find the instant.
        edge_nodes: usize = 3,
        edge_halvings: u32 = 40,
    }
}

constants! {
    /// The first curve inside the corridor.
    Rounding {
        /// Share of the tolerance that it uses.
        inside_share: f64 = 0.9,
        /// Share of its radius that an arc goes within a rounding at most: half a radian.
        arc_share: f64 = 0.5,
        /// Factor by which a rounding beside an arc is shortened until it is inside, and how often.
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
    /// The smooth curve that takes the place of dense chords ([`crate::path::smooth`]).
    Smooth {
        /// Seconds between two nodes where the motion is busy.
        node_s: f64 = 0.002,
        /// A change of direction (of a unit vector) whose corner has nodes of its own.
        sharp: f64 = 0.35,
        /// Moves of which there must be at least so many for a smooth curve, and of which one in so many may end in a sharp corner.
        least_moves: usize = 24,
        most_sharp: usize = 3,
        /// Rounds of springs.
        rounds: usize = 12,
        /// How much the jerk of a node counts where the room to the wall counts as the logarithm: a jerk that comes to the least
        /// acceleration limit within so many seconds.
        stiffness: f64 = 20.0,
        jerk_s: f64 = 0.05,
        /// Share of the corridor that it uses, and of its room that is left of it outside.
        inside_share: f64 = 0.95,
        least_room: f64 = 1e-7,
        /// Nodes behind the given ones beside which the corridor is as wide as the running motion needs it: so many times its distance, and at
        /// most this share of the corridor.
        beside_nodes: usize = 24,
        beside_off: f64 = 1.02,
        most_begun: f64 = 0.995,
        /// Share of the way to the wall that one step goes.
        most_step: f64 = 0.8,
        /// How often a motion that is continued may close in on its limits again.
        closing: usize = 3,
        /// Share of an excess of limits that closing in again must leave at most.
        nearer: f64 = 0.97,
        /// How often the timing is repeated with the corridor narrowed where the curve was outside.
        repairs: usize = 6,
        /// Nodes at an end that stay: three give the position, velocity and acceleration with which the motion begins or ends there.
        held_ends: usize = 3,
        /// The spring of a node that stays, far above all others.
        held_spring: f64 = 1e14,
    }
}

constants! {
    /// How far apart the nodes are.
    Grid {
        /// Seconds between two nodes where the motion is short enough.
        /// 2 ms: +0.02 %, a third less work.
        node_s: f64 = 0.001,
        /// Nodes of a whole motion at least, and of its busy part at most: so many, more for each piece, and however many pieces.
        least_nodes: f64 = 160.0,
        most_nodes_alone: f64 = 4000.0,
        most_nodes_each: f64 = 200.0,
        most_nodes: f64 = 24_000.0,
        /// Seconds beside a busy stretch in which nodes stay close, and seconds more between two for each second beyond.
        quiet_s: f64 = 0.25,
        growth: f64 = 0.08,
        /// Busy stretches whose quiet neighbourhood is counted, at most.
        most_quiet: usize = 1000,
        /// Nodes in the rounding of a corner beside a piece that is kept to, the shortest time between two, and seconds more between two for
        /// each second beyond.
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
        /// Shares of the limits of acceleration and jerk with which a motion that runs goes on along dense chords, seconds between the points of
        /// that motion, and the least share of its speed that it keeps.
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
    /// The runs of the optimisation that make a plan.
    Stages {
        /// Of a trapezoid: timing alone; timing and shape, twice.
        timing: StageTuning = stage(1.0, 1000.0, 8),
        shape: [StageTuning; 2] = [stage(1.0, 300.0, 8), stage(5.0, 1000.0, 8)],
        /// Of an S-curve, first without limits of jerk.
        /// None of it: -0.01 % on these short paths; dense polylines do not converge without it (flower 2.24 s, not 1.99 s).
        without_jerk: StageTuning = stage(1.0, 30.0, 8),
        timing_with_jerk: StageTuning = stage(1.0, 1000.0, 8),
        shape_with_jerk: [StageTuning; 2] = [stage(1.0, 300.0, 12), stage(5.0, 1000.0, 8)],
        /// The last one, and how often it is repeated with the corridor narrowed where its result was outside.
        last: StageTuning = stage(10.0, 2000.0, 8),
        /// 2 repairs: no difference here.
        repairs: usize = 4,
        /// Factor by which the weight of the time grows.
        /// 10: +0.07 %, 8 % less work.
        factor: f64 = 5.0,
        /// Factor by which a motion that is continued may exceed its limits after a repair and still be expected to come inside.
        hopeless: f64 = 1.2,
        /// How many times as far as allowed it may be from the reference path after any stage. Those that came inside were never
        /// farther than 1.3 times; most of those that did not began at 5 to 12.
        astray: f64 = 2.0,
    }
}

constants! {
    /// How much one planning call may compute, in looks at one node ([`crate::solve::work::Work`]): some of it for any motion, more for
    /// each node of the first guess.
    Work {
        /// A section from rest. A surface of 1,000 chords needs 900 looks a node on 5,300 nodes, as most steps are shortened many times;
        /// 1M looks take about 0.3 s.
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
        /// Newton decrement for each node at which a weight is done.
        /// 1e-2: -0.1 %, a fifth less work.
        converged: f64 = 1e-3,
        /// A step that leaves less than this share of a slack is shortened there.
        /// 0.12: -0.1 %.
        nearer_share: f64 = 0.03,
        /// Room that a point outside the corridor is given, as a share of its distance.
        widen_share: f64 = 0.02,
        /// A point so near to the corridor's wall is outside for other spans, and how much room it is given.
        touching: f64 = 1e-5,
        reweighed: f64 = 2e-3,
        /// The logarithm of a span changes by no more than this in one step.
        most_change: f64 = 1.0,
        /// Attempts to shorten one step, and how many of them only about the nodes that need it.
        attempts: u32 = 24,
        local_attempts: u32 = 16,
        /// Share of the expected decrease that a step must reach.
        sufficient: f64 = 1e-4,
        /// Relative lift of the matrix's diagonal.
        lift: f64 = 1e-9,
        /// Nodes to either side over which a shortened step is spread.
        /// 12 nodes: +0.4 %, 3 rests.
        spread_nodes: usize = 48,
        /// Between these a product can take the factors of another node before its logarithm is due: a third of the exponents of `f64`.
        least_product: f64 = 1e-100,
        most_product: f64 = 1e100,
    }
}

constants! {
    /// Starts outside the limits.
    Relax {
        /// Quotient of limits at which the barrier starts, the factor by which spans grow until it is reached, and how often.
        /// 0.42: -0.05 %, 4 % less work.
        feasible: f64 = 0.7,
        lengthen: f64 = 1.2,
        lengthenings: u32 = 200,
        /// Distance to a limit's quotient of 1 up to which it is kept with room to spare.
        inside: f64 = 1e-5,
        /// How much more a limit counts while it is relaxed: so that it is not where the others push to.
        /// 1: +1 %, 2 rests and a replan not found, a third more work.
        weight: f64 = 30.0,
        /// Quotient beyond which a start is slowed down, and within how many nodes.
        far: f64 = 1.5,
        ramp_nodes: f64 = 80.0,
        /// Nodes about one outside its limits whose timing alone is slowed down, to either side, and as many more that lead there.
        spread_nodes: usize = 60,
        /// Nodes at the end that do not count for that.
        end_nodes: usize = 4,
        /// What counts as a full limit where a motion is continued: next to it the hull of the spline is a little wider than the
        /// motion itself, which is measured when it is done.
        near_full: f64 = 0.9995,
        /// Further steps for each weight in which relaxed limits close in.
        /// 12: no difference here.
        most_closing: usize = 24,
        /// Room that a limit which is exceeded is given, and the least of it, as shares of the quotient.
        widen_share: f64 = 0.3,
        least_share: f64 = 1e-3,
    }
}

constants! {
    /// Where a running trajectory is left and how far it is planned on.
    Extend {
        /// Seconds before the braking at which it is left.
        settle_s: f64 = 0.06,
        /// Times of braking before its end at which it is left.
        /// 1 time: no difference here.
        brakings: f64 = 1.5,
        /// Seconds behind a stop before which it is simpler to start at the stop.
        after_stop_s: f64 = 0.01,
        /// Seconds at programmed speed, and at least so many moves, for which a motion is planned before it begins.
        first_s: f64 = 0.4,
        first_moves: usize = 4,
        /// Seconds by which it is extended at once, about, at least and at most, but at least so many moves.
        least_s: f64 = 0.25,
        most_s: f64 = 0.8,
        least_moves: usize = 12,
        /// Of dense chords one in so many may be an arc.
        most_arcs: usize = 4,
        /// Seconds that are left of the running motion below which a slower instant of it is tried second.
        /// 0: `fine` with S-curves 0.33 of the motion instead of 0.18; always: `coarse` +0.65 %, `islands` +0.2 % with S-curves.
        short_s: f64 = 0.4,
        /// Seconds that are left of the running motion from which on timing and shape are planned together.
        ample_s: f64 = 0.3,
        /// Share of that which is planned where all of it is not found.
        less_share: f64 = 0.25,
        /// Seconds that the running motion is followed at least, and that are left of it at least.
        least_followed_s: f64 = 0.004,
        least_left_s: f64 = 0.008,
        /// Splices that are tried for a plan anew, and seconds between them.
        attempts: u32 = 3,
        later_s: f64 = 0.02,
        /// Instants that are looked at for a splice, and seconds between them.
        choice: u32 = 30,
        choice_step_s: f64 = 0.001,
        /// Weight of the acceleration in use, where that of the tolerance in use is 1.
        acceleration_weight: f64 = 0.3,
        /// Seconds that a trajectory which is planned anew is followed.
        replan_followed_s: f64 = 0.01,
        /// Seconds, and at least so many moves, for which it is planned anew.
        replan_s: f64 = 1.0,
        replan_least_moves: usize = 4,
        /// Seconds beyond which planning anew would take too long: the motion goes on at its rate.
        replan_most_ahead_s: f64 = 4.0,
    }
}

constants! {
    /// The first guess of a motion that continues another one.
    WarmStart {
        /// Shortest time between the knots of a motion that is followed, and the longest as a multiple of that between two nodes.
        least_span_s: f64 = 2e-5,
        most_span_nodes: f64 = 2.0,
        /// Seconds from point to point of the motion that is followed.
        step_s: f64 = 5e-4,
        /// Seconds, at least so many position units, in which the offset from the rounded path fades out.
        fade_s: f64 = 0.015,
        least_fade_units: f64 = 1e-6,
        /// Position units that the first step behind the followed motion goes at least.
        least_step_units: f64 = 1e-7,
    }
}

constants! {
    /// The second guess of a motion that continues another one ([`crate::extend::warm_start_joined`]).
    Joined {
        /// Seconds in which a difference of speeds counts as much as one of accelerations.
        soon_s: f64 = 0.01,
        /// Other instants of the second motion that are looked at about the one at the same arc length, and seconds between them.
        shifts: i32 = 4,
        shift_s: f64 = 2.5e-4,
        /// The running motion is followed for this long at least.
        least_followed_s: f64 = 0.004,
        /// Knots that are nearer to each other would be one.
        least_span_s: f64 = 2e-4,
        /// A sum of shares of tolerance, speed and acceleration up to which two motions are alike.
        most_unlike: f64 = 1.5,
    }
}

constants! {
    /// The continuation on evenly rounded corners, within all limits from the first guess on ([`crate::extend::gentle`]).
    Gentle {
        /// Seconds before the last braking of the running motion, and share of that braking, from when until when it may be left, and at how many
        /// instants.
        before_s: f64 = 0.15,
        latest_share: f64 = 0.9,
        leaves: usize = 40,
        /// How many of those at which that is possible are tried.
        attempts: usize = 12,
        /// Seconds by which a motion is extended at once, as a share of the usual ones.
        ahead_share: f64 = 0.5,
        /// Share of the limits with which the speed changes where the path turns.
        turning_share: f64 = 0.3,
        /// Share of the speed at which a stretch is within its limits with which a motion that is left may come to it.
        entry_share: f64 = 0.95,
        /// Least time of a change of the acceleration, seconds.
        step_s: f64 = 0.005,
        /// Nodes of a rounding, and of one beside a piece that is kept to.
        rounding_nodes: [f64; 2] = [8.0, 16.0],
        /// Points of a rounding at which its limits are looked at. Without an experiment.
        rounding_samples: u32 = 16,
        /// Tangents (unit vectors) that differ by more are a corner. Without an experiment: a thousand times [`crate::tolerance::SAME_TANGENT_SINE`].
        corner: f64 = 1e-3,
        /// Points of the fading offset at which its place and rates are looked at. Without an experiment.
        fade_samples: u32 = 16,
        /// Share of the limits that the offset uses which fades out.
        fade_share: f64 = 0.2,
        /// Seconds in which it fades out at least and at most, and the factor from one trial to the next.
        fade_s: [f64; 2] = [0.004, 0.1],
        fade_factor: f64 = 1.3,
        /// Factor by which the speeds of a smooth curve differ within a part that is travelled as one, and its nodes at least.
        alike: f64 = 1.25,
        least_part: f64 = 4.0,
        /// Instants at which the running motion is left for a smooth curve, at most.
        smooth_attempts: usize = 6,
        /// How often the curve is smoothed where it is outside with the times of the faster motion.
        repairs: usize = 3,
    }
}
