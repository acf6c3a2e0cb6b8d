//! The tuned constants of the planner, by subject. Not here: values of the specification and of formulas, which are defined at their use.
//!
//! Experiments: times are sums over 8 benchmark and 24 random plans, extensions and replans (14.738 s of motion, 1 rest, 2.13M steps of nodes) with
//! one constant changed, and the streams `coarse`, `fine`, `rough`, `rows`, `islands` of `tests/src/streams.rs` as the share of their motion that planning
//! takes; NOTES.md has the whole of them. A constant without a recorded experiment says what it trades, and "not measured": its value is a choice. Names end in
//! the unit where there is one: `_s` seconds, `_units` position units, `_share` a part of a limit or length.

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
    pub(crate) end: End,
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
    pub(crate) attempts: Attempts,
    pub(crate) patience: Patience,
}

pub(crate) const TUNING: Tuning = Tuning {
    corridor: Corridor::VALUES,
    margin: Margin::VALUES,
    rounding: Rounding::VALUES,
    smooth: Smooth::VALUES,
    end: End::VALUES,
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
    attempts: Attempts::VALUES,
    patience: Patience::VALUES,
};

constants! {
    /// The corridor within which the optimisation keeps the curve.
    Corridor {
        /// Share of the tolerance for a long piece; a hundredth is permitted.
        /// Less leaves the optimisation less room, more puts more results outside, which repairs narrow. Not measured.
        aim_straight_share: f64 = 0.006,
        /// Share of the length of a rounding: the corridor is narrow from half the distance of two nodes before its end on.
        /// More reaches further, but between two measured points just outside the rounding a line deviated by 1.4 hundredths of the tolerance with
        /// 0.96; less rounds a corner more sharply.
        aim_reach_share: f64 = 0.9,
        /// Lengths of a rounding within which the middle between two knots also counts.
        /// More points keep more of the curve inside, and cost work. Not measured.
        near_reaches: f64 = 2.0,
        /// The opening of the corridor's cone at the ends at which the motion rests, units per unit.
        /// Four times as fast: +0.15 %, 3 rests.
        cone: f64 = 0.25,
        /// Pieces to either side of the present one among which the nearest point is searched for: a short piece may hide a nearer one behind it. More find
        /// it behind more short pieces, and take more time. Not measured.
        foot_pieces: usize = 2,
        /// Pieces to either side to which a point may belong: as `foot_pieces`. Not measured.
        near_pieces: usize = 2,
    }
}

constants! {
    /// The share of the tolerance for the knots, such that the curve between them stays inside.
    Margin {
        /// The share at first.
        /// More is faster, less needs fewer repairs of what lies between two knots. Not measured.
        usual_share: f64 = 0.98,
        /// The quotient above which the corridor is narrowed.
        /// Below 1, as between the measured points the curve may be farther outside; less repairs more often. Not measured.
        inside: f64 = 0.999,
        /// The quotient after narrowing.
        /// Less is inside after fewer repairs, more is faster. Not measured.
        target: f64 = 0.975,
        /// Least factor of one narrowing if the curve keeps close to some pieces: the curve may be outside by many of their corridors before it
        /// comes inside.
        /// 0.18 instead: no difference.
        least_factor: f64 = 0.6,
        /// Points measured between two knots.
        /// More points find more of the excess and take more time. Four alone missed up to a tenth of the tolerance at the joints of rough chords;
        /// therefore joints are measured as well.
        parts: usize = 4,
        /// The quotient from which on the largest one between the measured points is searched for, if the curve keeps close to some piece.
        /// Less searches at more knots, more may miss an excess. Not measured.
        close: f64 = 0.5,
        /// Nodes about an edge of the corridor between which the motion passes it, and halvings that find the instant.
        /// Nodes: enough that the motion passes the edge between them, as nodes and progress differ a little. Halvings: a bracket of a few
        /// milliseconds closes to the last bit of an instant. Not measured.
        edge_nodes: usize = 3,
        edge_halvings: usize = 40,
        /// Steps of the secant method that find the instant at which the motion passes a joint.
        /// Every step is measured, so more steps find the excess at the joint more exactly, and take more time. Not measured.
        joint_steps: usize = 3,
    }
}

constants! {
    /// The first curve inside the corridor.
    Rounding {
        /// Share of the tolerance that it uses.
        /// More is faster at once, less leaves the barrier room to begin with. Not measured.
        inside_share: f64 = 0.9,
        /// Largest share of its radius that an arc covers within a rounding: half a radian.
        /// More rounds a corner beside a short arc less sharply, less keeps more of the arc. Not measured.
        arc_share: f64 = 0.5,
        /// Factor by which a rounding beside an arc is shortened until it is inside, and the number of shortenings.
        /// A factor nearer to 1 finds a longer rounding in more trials; 60 of 0.7 end at 5e-10 of the length. Not measured.
        shorten: f64 = 0.7,
        shortenings: u32 = 60,
        /// Points of it that are measured.
        /// More points find more of an excess, and take more time. Not measured.
        measured: u32 = 32,
        /// Samples of it for the speed profile; and of one that turns by no more than [`Smooth::sharp`], as those between dense chords.
        /// More samples show more of the curvature to the speed profile, and take more time: with 24 for all of them they took a third of the time of
        /// an extension along chords of 0.05 mm, and the motion of the streams took as long. 6 for all: `corners` +3 % with trapezoids.
        samples: usize = 24,
        gentle_samples: usize = 6,
        /// Samples of a line for the whole length of the reference path, at least and at most for each.
        /// More samples place nodes more exactly where the speed changes, and take more time. Not measured.
        line_samples: [f64; 3] = [400.0, 4.0, 200.0],
        /// Samples of an arc for each radian, at least and at most for each.
        /// As for lines. Not measured.
        arc_samples: [f64; 3] = [20.0, 8.0, 1000.0],
    }
}

constants! {
    /// The smooth curve in place of dense chords ([`crate::path::smooth`]).
    Smooth {
        /// Seconds between two nodes in busy stretches.
        /// Nodes 2 ms apart with the shape found before the timing, against both found at once: +0.3 % (surface), +0.5 % (raster), flower and cone3d
        /// as before, at 15 to 30 ms for 1,000 chords instead of 300 to 4,000. Other distances are not measured.
        node_s: f64 = 0.002,
        /// The same where no corner is farther than this number of tolerances from an arc through the middles of its chords. 0.0025 instead: 8 to 25 % more steps
        /// of nodes, the motion of 11 streams 0.05 % shorter. 0.004: S-curves of `surf1` (0.1 mm at 300 mm/s, 0.005 mm) 13 % slower. Everywhere: `coarse` with
        /// S-curves 25 s, not 12.6. Up to 0.23 tolerances: `surface` at 300 mm/s took more repairs.
        flat_node_s: f64 = 0.003,
        flat: f64 = 0.2,
        /// The least number of nodes of a whole motion. 160, as of others: `fine` with S-curves 1.44 times the steps of nodes and 6 % more time of motion, with
        /// trapezoids 1.3 times; 90: no difference.
        least_nodes: f64 = 60.0,
        /// Length of the pieces beside a joint, as a share of the way between two nodes, and the roughness of the joint (difference of unit vectors) from
        /// which on the curve is held inside the corridor there too.
        /// Never: `rough` with trapezoids 0.8 of the motion instead of 0.13; for every joint that turns: `coarse` with trapezoids 0.053 instead of 0.03.
        joint_share: f64 = 0.4,
        rough: f64 = 0.02,
        /// A change of direction (of a unit vector) whose corner has nodes of its own.
        /// Without nodes of its own a corner of more than 20 degrees (spec/motion-core.md §6.4) is cut by nodes that are too far apart; more corners
        /// with them cost more nodes. Not measured.
        sharp: f64 = 0.35,
        /// The least number of moves for a smooth curve, and the moves for each permitted sharp corner.
        /// Fewer moves are planned better with shape and timing together; more sharp corners cost more nodes of their own. Not measured.
        least_moves: usize = 24,
        most_sharp: usize = 3,
        /// Rounds of springs.
        /// More rounds bring the springs closer to the barrier, and take more time. Not measured.
        rounds: usize = 12,
        /// The weight of a node's jerk relative to the logarithm of the room to the wall: of a jerk that reaches the least
        /// acceleration limit within this number of seconds.
        /// More makes the jerk smaller, less keeps the curve farther from the wall.
        /// Less where the curve is outside: S-curve of the surface +15 %. Other values are not measured.
        stiffness: f64 = 20.0,
        jerk_s: f64 = 0.05,
        /// Share of the corridor that it uses, and share of its room for a point outside.
        /// More is faster, less leaves more room between the knots; room for a point outside must be above 0, so that the spring is finite. Not
        /// measured.
        inside_share: f64 = 0.95,
        least_room: f64 = 1e-7,
        /// Nodes behind the given ones beside which the corridor is as wide as the running motion needs it: this multiple of its distance, and at
        /// most this share of the corridor.
        /// A running motion closer to the wall than the springs permit was pulled inwards just behind the fixed nodes: a bend of 5 to 9 times the
        /// jerk. 0.995 of the tolerance, however much a repair narrowed the corridor, never came inside. Other values are not measured.
        beside_nodes: usize = 24,
        beside_off: f64 = 1.02,
        most_begun: f64 = 0.995,
        /// Share of the distance to the wall for one step.
        /// Nearer to 1 takes fewer rounds, and may end at the wall. Not measured.
        most_step: f64 = 0.8,
        /// Most repeated attempts of a continuation to close in on its limits.
        /// More attempts find more extensions, and take the time of others. Not measured.
        closing: usize = 3,
        /// Excess after an attempt beyond which a further one does not come inside.
        /// Motions farther outside after closing in once did not come inside: `rows` with S-curves 0.07 of the motion instead of 0.12 (with the
        /// instants of the attempts, in one change).
        far: f64 = 1.8,
        /// The same in a short rest of the running motion ([`Extend::short_s`]): of 26 attempts at `fine` with S-curves that were outside by more after they
        /// had closed in once, one came inside.
        far_short: f64 = 1.02,
        /// Quotient of the distance from the path and the tolerance beyond which the first trapezoids of a stream have no repairs: the motion waits for them.
        /// Of 22 first plans that were farther outside 17 never came inside, and the others took three to six repairs. With repairs 8 of 299 streams began
        /// after more than 20 ms, not one, and their first motion took 0.3 % more time. S-curves that are 4 times outside come inside in two.
        far_to_begin: f64 = 2.0,
        /// The same after two repairs, trapezoids and S-curves; the third is the last. Of 1,800 first plans 19 came inside with two repairs or more, and of 22 that were
        /// farther outside after two one, with its sixth.
        far_repaired: f64 = 1.35,
        /// Largest share of an excess that may remain after another attempt.
        /// More continues attempts that hardly close in, less gives up attempts that would. Not measured.
        nearer: f64 = 0.97,
        /// Most repetitions of the timing with a narrower corridor where the curve was outside.
        /// With narrower corridors only where the curve was outside, it came outside elsewhere: each repair narrows the whole, and there are up to
        /// six. Other numbers are not measured.
        repairs: usize = 6,
        /// Fixed nodes at an end: three determine the position, velocity and acceleration of the motion there.
        /// Fewer do not determine the acceleration, more leave less to improve. Not measured.
        held_ends: usize = 3,
        /// The spring of a fixed node, far above all others.
        /// A smaller one moves the fixed nodes visibly, a larger one leaves the others fewer digits. Not measured.
        held_spring: f64 = 1e14,
    }
}

constants! {
    /// The time behind a millisecond at which no continuation with limits of the jerk ends, if it can end later.
    End {
        /// Ends that are sooner move by less than 10⁻⁹ units in their last tick with up to 6 · 10⁶ units/s³, and those that are later by more than 10⁻⁷ with 5,000 at least.
        /// With 0.25 ms one live run of `coarse` in three ended so: its end had a tenth to a third of its jerk.
        from_s: f64 = 1e-5,
        to_s: f64 = 5e-4,
        /// Seconds of motion that a second is worth by which an end is too early. More takes a slower motion, less leaves ends that seem to rest: with 50, of 210
        /// ends of `coarse` four were within 0.3 ms behind a tick, now none.
        weight: f64 = 200.0,
    }
}

constants! {
    /// The distances between nodes.
    Grid {
        /// Seconds between two nodes of a short motion.
        /// 2 ms: +0.02 %, a third less work.
        node_s: f64 = 0.001,
        /// The least number of nodes of a whole motion, and the largest of its busy part: alone, for each piece, and in total.
        /// Fewer plan short motions worse, more take longer: arcs of minutes with 24,000 nodes took minutes to plan, and have at most 4,000 now. Other
        /// values are not measured.
        least_nodes: f64 = 160.0,
        most_nodes_alone: f64 = 4000.0,
        most_nodes_each: f64 = 200.0,
        most_nodes: f64 = 24_000.0,
        /// Seconds beside a busy stretch in which nodes stay close, and the growth of the distance per second beyond.
        /// A longer time or less growth takes more nodes in long cruises, a shorter time leaves fewer to the ramps beside a busy
        /// stretch. Not measured.
        quiet_s: f64 = 0.25,
        growth: f64 = 0.08,
        /// Most busy stretches whose quiet neighbourhood counts.
        /// It bounds the work of a path with many stretches. Not measured.
        most_quiet: usize = 1000,
        /// Nodes in the rounding of a corner beside a piece that the curve keeps close to, the shortest time between two, and the
        /// growth of that time per second beyond.
        /// 10 nodes: +0.6 %, 5 % more work, as fewer come inside.
        rounding_nodes: f64 = 20.0,
        /// Time: shorter spans follow sharper roundings, and leave the derivatives fewer digits. Growth: more takes fewer nodes, but a kink in the
        /// spans is a jerk. Not measured.
        finest_s: f64 = 5e-5,
        spread: f64 = 0.2,
        /// Share of the acceleration limit below which a stretch is not busy.
        /// More leaves more stretches with few nodes. Not measured.
        idle_share: f64 = 1e-3,
    }
}

constants! {
    /// The speed profile that places the first nodes.
    SpeedProfile {
        /// Shares of the acceleration limits across and along the curve, and of the jerk limits.
        /// More begins closer to the fastest motion, less closer to a feasible one, from which the barrier starts. Not measured.
        normal_share: f64 = 0.8,
        tangent_share: f64 = 0.9,
        jerk_share: f64 = 0.6,
        /// Shares of the limits of acceleration and jerk for the continuation of a running motion along dense chords, seconds between
        /// the points of that motion, and the least share of its speed.
        /// Shares: more begins faster, less more often inside the limits. Points and least speed: they bound the work. Not measured.
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
        /// More weight at the end is faster, more steps take more time. Not measured.
        timing: StageTuning = stage(1.0, 1000.0, 8),
        shape: [StageTuning; 2] = [stage(1.0, 300.0, 8), stage(5.0, 1000.0, 8)],
        /// For an S-curve, first without limits of jerk.
        /// None of it: -0.01 % on these short paths; dense polylines do not converge without it (flower 2.24 s, not 1.99 s).
        without_jerk: StageTuning = stage(1.0, 30.0, 8),
        /// As `timing` and `shape`. Not measured.
        timing_with_jerk: StageTuning = stage(1.0, 1000.0, 8),
        shape_with_jerk: [StageTuning; 2] = [stage(1.0, 300.0, 12), stage(5.0, 1000.0, 8)],
        /// The last one, and most repetitions with a narrower corridor where its result was outside.
        /// 2,000 bounds the loss to the barrier: a larger weight leaves less of the limits unused and takes more steps. Not measured.
        last: StageTuning = stage(10.0, 2000.0, 8),
        /// 2 repairs: no difference here.
        repairs: usize = 4,
        /// The largest weight for a motion from rest in a stream: the first moves wait for their plan.
        /// 1,000: one in ten streams of trapezoids was planned in 17 ms or more, not 7; S-curves in 10.7 ms (median), not 8.3. 25: their motion took 3 %
        /// longer.
        begun: f64 = 200.0,
        /// Factor of the weight of the time from one to the next.
        /// 2 to 4 take about as many steps of nodes, with two steps for each weight; 4: `adept` with S-curves 0.7 % slower.
        factor: f64 = 2.5,
        /// Excess of a continuation after a repair up to which it may still come inside.
        /// More continues repairs that do not come inside, less gives up some that would. Not measured.
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
        /// The smooth curve of the first moves of a stream, which wait for it. Without one, the corners are rounded one by one in 3 to 20 ms.
        /// Trapezoids, of 82 first plans of dense chords, a computer at half its speed: 150,000: 95 % within 26 ms, longest 32; 60,000: 14 and 20; as
        /// much motion. 40,000, of 1,200 random streams: three begin with another motion, and the latest sooner. S-curves: with 100,000 a circle of 120 chords
        /// had no smooth curve.
        to_begin: u64 = 40_000,
        to_begin_s_curve: u64 = 150_000,
        /// Visits of each node in one stage of the first plan of a stream. Without a bound single stages took 130 to 220, and their plan a third more time; the first motion
        /// of 300 streams with S-curves took 0.1 % less.
        begin_stage_each: u64 = 50,
        /// Visits of each node to make the first S-curves of a stream faster on evenly rounded corners.
        /// 39 first plans of few moves took 13 ms at most with 40, and 24 with 100; 60: 16 ms and 3 % less time of motion than 40, as with 100. With 40, the speed
        /// along a circle of 120 chords flickered.
        begin_each: u64 = 60,
        /// Most of them of all nodes: two long lines at 55 mm/s had 1,850.
        most_to_begin: u64 = 60_000,
        /// All attempts to continue a motion. Of 75 extensions of the benchmark's paths in windows the 68 that were found took 81 to 439
        /// steps; without a bound those that were not took up to 7,600.
        to_continue: u64 = 1_000_000,
        to_continue_each: u64 = 1000,
        /// Visits of each node to make a motion within all limits faster when the budget of its search is used up: a start that was slowed down takes ten
        /// times as long as it must.
        hastening_each: u64 = 100,
        /// Visits of each node that an attempt of a gentle continuation is worth without its optimisation: its speed curve, and a smoothing;
        /// and those of an attempt along a smooth curve: of each node of the curve, and again of the motion along it. More leave fewer attempts to a search, fewer let it
        /// take longer than its share. The smooth curve alone counted with 50: such searches took two to four times their share.
        attempt_each: u64 = 25,
        smooth_attempt_each: u64 = 70,
        /// Those of each piece of the path for an attempt from a warm start outside of the limits, for its roundings and their speeds; and for a gentle search
        /// and each of its attempts. 1 µs (2.9 before they had fewer samples) and 3 µs.
        piece_each: u64 = 8,
        gentle_piece_each: u64 = 25,
        /// Those of each node for a stage along a smooth curve: smoothing, measuring and narrowing take 4 to 5 µs.
        stage_each: u64 = 40,
        /// Visits that one of timing and shape together is worth.
        /// 3: such searches took two to four times their share.
        together_each: u64 = 6,
        /// Visits in a second of a processor: 8 to 16 million on a slow computer of 2026. Fewer leave the searches of an extension less work, more let them
        /// take longer than there is time.
        visits_per_s: f64 = 8e6,
    }
}

constants! {
    /// The time that each search for an extension may take, so that the next one still is in time: a share of what the searches before leave of the
    /// running motion's rest. Extensions that are found on a smooth curve take 5 to 60 ms, those that are not found took 0.2 to 2 s: without these limits
    /// one random stream in five rested. With least times as well, the searches of a short rest took all of it: of 250 random streams 10 rested, now none.
    Patience {
        /// Half as much: a motion of the random streams is 0.2 % longer, and the searches behind it take the time. In a short rest
        /// ([`Extend::short_s`]) it gets more, as others are found seldom: with 0.1 ten of 48 extensions of `fine` were not found, not one. Since all of the work
        /// counts, with 0.1 and 0.16 `rough` with S-curves takes 5 % more time, `rows` 1 %; 0.18 and 0.26: no difference.
        smooth: f64 = 0.14,
        smooth_short: f64 = 0.22,
        gentle_and_smooth: f64 = 0.05,
        /// At first, timing and shape together alone keep the speed constant along few chords (half of it: a circle of 120 slowed down twice at its end),
        /// but what comes behind them needs time as well (more: of 22 random extensions 6 were not found).
        together: f64 = 0.6,
        gentle: f64 = 0.07,
        gentle_alone: f64 = 0.15,
        gentle_sooner: f64 = 0.07,
        /// A gentle plan of few moves, after all others. Without it 9 of 1,060 extensions of the random streams were not found, not one.
        gentle_and_few: f64 = 0.2,
        /// The last one may take more of what is left, and this number of seconds in any case. With half of it 3 of 252 random streams rested on a slow
        /// computer, not 1: after a failure the motion slows down, which needs the time.
        last: f64 = 0.25,
        least_last_s: f64 = 0.05,
        /// The share of its time that a gentle search takes until it finds a plan, about.
        gentle_takes: f64 = 0.5,
        /// The longest rest of which they take a share, seconds: a failed extension is tried again with what is left.
        most_rest_s: f64 = 1.5,
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
        /// More room makes the first steps longer, less closes in sooner. Not measured.
        widen_share: f64 = 0.02,
        /// A point this close to the corridor's wall is outside with other spans; and its new room.
        /// More takes more points anew, less leaves a point at a wall that holds up all steps; the new room must be above `touching`. Not measured.
        touching: f64 = 1e-5,
        reweighed: f64 = 2e-3,
        /// Largest change of a span's logarithm in one step.
        /// A larger change reaches a distant optimum in fewer steps, a smaller one stays where the matrix is valid. Not measured.
        most_change: f64 = 1.0,
        /// Most attempts to shorten one step, and those of them near critical nodes only.
        /// More attempts find a shorter step that is feasible, and take the work of a step each. Not measured.
        attempts: u32 = 24,
        local_attempts: u32 = 16,
        /// Share of the expected decrease that a step must reach.
        /// The usual value of a search along a line (Armijo); more refuses more steps. Not measured.
        sufficient: f64 = 1e-4,
        /// Steps for each weight but the first and the last: along the curve of the optima, which need not be reached on the way.
        /// 1: dense chords with trapezoids a fifth fewer steps, S-curves of `coarse` 1.5 % and of `adept` 0.4 % slower. 8, a factor of 5 and no step along the
        /// curve of the optima: twice as many steps of nodes.
        steps_between: usize = 2,
        /// Relative lift of the matrix's diagonal.
        /// More makes the steps shorter, less may leave a pivot without digits. Not measured.
        lift: f64 = 1e-9,
        /// Nodes to either side over which a shortening of the step is spread.
        /// 12 nodes: +0.4 %, 3 rests.
        spread_nodes: usize = 48,
        /// The range in which a product can take the factors of another node before its logarithm is due: a third of the exponents of `f64`.
        /// More logarithms cost time, and a product outside of the range of `f64` is wrong.
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
        /// A smaller factor ends closer below the quotient, in more steps; 200 of 1.2 are a factor of 1e15. Not measured.
        lengthen: f64 = 1.2,
        lengthenings: u32 = 200,
        /// Distance of a quotient from 1 from which on it is kept with a margin.
        /// More keeps a quotient from its limit, less leaves the barrier no room. Not measured.
        inside: f64 = 1e-5,
        /// The weight of a relaxed limit, such that the other limits do not push the excess to it.
        /// 1: +1 %, 2 rests and a replan not found, a third more work.
        weight: f64 = 30.0,
        /// Quotient above which a start is slowed down, and the nodes over which it is.
        /// Where most of what is new is far outside, a motion that begins slower comes inside; slower than necessary costs time. Nodes: fewer make a
        /// kink in the spans, which is a jerk. Not measured.
        far: f64 = 1.5,
        ramp_nodes: f64 = 80.0,
        /// Nodes to either side of one outside its limits whose timing alone is slowed down; and as many more that lead there.
        /// Slowing down everything behind the given nodes, within 80 nodes, made 30 to 50 times the jerk
        /// just behind the splice; now only what is outside is slowed down, over 60. Other numbers are not measured.
        spread_nodes: usize = 60,
        /// Nodes at the end that do not count for that.
        /// At rest they come inside by themselves, and slowing down for them made everything behind the given nodes slow. Not measured.
        end_nodes: usize = 4,
        /// The share of a limit that counts as full for a continuation: close to its limit, the hull of the spline is a little wider
        /// than the motion itself, which is measured at the end.
        /// A larger share refuses continuations of which only the hull is outside, a smaller one leaves more to the measurement. Not measured.
        near_full: f64 = 0.9995,
        /// Further steps for each weight in which relaxed limits close in.
        /// 12: no difference here.
        most_closing: usize = 24,
        /// Steps in which the room of the most relaxed limit must shrink by this share; a continuation of which it does not is given up.
        /// Of 501 continuations of eight streams 60 were never within their limits, 55 of which are given up, with 0.8 of their steps left; so are 8 of the
        /// others, which took as long. 4 steps: 57 and 19; 16 steps and 10 %: 55 and 7.
        stalled_steps: usize = 8,
        stalled_share: f64 = 0.05,
        /// Room for an exceeded limit, and the least of it, as shares of the quotient.
        /// More room makes the first steps longer, less closes in sooner. Not measured.
        widen_share: f64 = 0.3,
        least_share: f64 = 1e-3,
    }
}

constants! {
    /// The splice of a running trajectory, and the length of its extension.
    Extend {
        /// Seconds before the braking at which the warm start leaves it.
        /// Earlier keeps less of the running motion, later leaves less time to change it. Not measured.
        settle_s: f64 = 0.06,
        /// Times of braking before its end at which the warm start leaves it.
        /// 1 time: no difference here.
        brakings: f64 = 1.5,
        /// Seconds after a stop up to which the plan starts at the stop instead.
        /// More plans from rest more often, less from a state just behind it. Not measured.
        after_stop_s: f64 = 0.01,
        /// Seconds of the first guess, and the least number of moves, to plan before a motion begins.
        /// Of random streams whose plans came as late as their processor time, on a slow computer, 95 of 100 began within 35 ms (S-curves) and 39 ms; with
        /// 0.4 s at programmed speed within 56 and 84 ms, and the motion took as long. 0.2 s: 13 rests in 257 streams, not 4. S-curves: by the guess with
        /// limits of the jerk, and at least the second number of seconds by that without them; by the latter alone their first plans took twice as long
        /// at sharp corners (95 of 100 within 15.6 ms, not 8.3), and with plans 20 ms late their motion 0.6 % more time.
        first_s: f64 = 0.35,
        first_without_jerk_s: f64 = 0.2,
        first_moves: usize = 4,
        /// Seconds of one extension, about: at least and at most; and the least number of moves.
        /// Longer extensions plan the end of the motion less often, but each takes longer, and the motion must not end meanwhile. Not measured.
        least_s: f64 = 0.25,
        most_s: f64 = 0.8,
        least_moves: usize = 12,
        /// One in this number of dense chords may be an arc.
        /// More arcs as a smooth curve take more nodes; fewer leave streams of chords to slower plans. Not measured.
        most_arcs: usize = 4,
        /// Rest of the running motion, seconds, below which a slower instant of it is tried second, and little else before a motion from its end. With the
        /// motion from its end below 0.2 s: 3 rests in 150 starts of dense S-curves that are sent at 5 to 6 moves a millisecond, on a slow computer;
        /// without it 58, now 2. Of 80 random streams of 300 moves, sent so, 3 rested, now none, and the S-curves take 2.7 % less time.
        /// 0: `fine` with S-curves 0.33 of the motion instead of 0.18; always: `coarse` +0.65 %, `islands` +0.2 % with S-curves.
        short_s: f64 = 0.4,
        /// Rest of the running motion, seconds, from which on instants long before its braking are tried too. 0.4: `rows` with S-curves 0.5 % less, planning of
        /// random streams 9 % more.
        long_s: f64 = 1.0,
        /// Rest of the running motion, seconds, in which the first moves of a motion from its end are planned in time. More gives up motions that come in
        /// time, less plans some that are late. Not measured.
        least_to_begin_s: f64 = 0.01,
        /// Seconds by which the splice is later after an attempt that ended far outside the limits.
        /// More is slower at the splice and found sooner, less keeps more of the speed. Not measured.
        slower_s: f64 = 0.03,
        /// Rest of the running motion, seconds, from which on timing and shape are planned together.
        /// Timing and shape together are faster at sharp corners, and took 0.3 to 2 s for 0.8 s of motion in streams of lines and arcs. Other values
        /// are not measured.
        ample_s: f64 = 0.3,
        /// Share of the moves to plan if no plan for all is found.
        /// Fewer moves are easier to plan and leave the next extension less time. Not measured.
        less_share: f64 = 0.25,
        /// Least time to follow the running motion, and least rest of it, seconds.
        /// Less time leaves no knots of the running motion to begin with, more excludes splices. Not measured.
        least_followed_s: f64 = 0.004,
        least_left_s: f64 = 0.008,
        /// Splices to try for a plan anew, and seconds between them.
        /// More splices find more plans, and take their time. Not measured.
        attempts: u32 = 3,
        later_s: f64 = 0.02,
        /// Instants to examine for a splice, and seconds between them.
        /// More instants find a better splice, later ones delay the change. Not measured.
        choice: u32 = 30,
        choice_step_s: f64 = 0.001,
        /// Weight of the used share of the acceleration, relative to that of the tolerance.
        /// More prefers instants with little acceleration, less those in the middle of the corridor. Not measured.
        acceleration_weight: f64 = 0.3,
        /// Seconds for which a plan anew follows the trajectory.
        /// Longer keeps more of the old pace, shorter leaves fewer knots to begin with. Not measured.
        replan_followed_s: f64 = 0.01,
        /// Seconds, and the least number of moves, of a plan anew.
        /// More takes longer to plan, less is planned again sooner. Not measured.
        replan_s: f64 = 1.0,
        replan_least_moves: usize = 4,
        /// Seconds beyond which planning anew would take too long: the motion keeps its pace.
        /// More plans that are late, less leaves more overrides to the pace of the old plan. Not measured.
        replan_most_ahead_s: f64 = 4.0,
    }
}

constants! {
    /// The warm start of a continuation.
    WarmStart {
        /// Shortest time between the knots of a followed motion, and the longest as a multiple of the time between two nodes.
        /// Knots 0.1 ms apart beside others of 2 ms had a thousand times the jerk; halved from 2.0 ms on, as spans grow a little, the grid changed
        /// from 1 to 2 ms at the seam. Therefore the motion is left at a knot, and spans are halved from two node times on. The least span is not
        /// measured.
        least_span_s: f64 = 2e-5,
        most_span_nodes: f64 = 2.0,
        /// Seconds from point to point of a followed motion.
        /// Fewer points miss a bend of the running motion, more take more time. Not measured.
        step_s: f64 = 5e-4,
        /// Seconds, and the least distance in position units, in which the offset from the rounded path fades out.
        /// Longer follows the running motion further, shorter needs more acceleration. Not measured.
        fade_s: f64 = 0.015,
        least_fade_units: f64 = 1e-6,
        /// Least distance of the first step behind the followed motion, position units.
        /// It only keeps two points from being one. Not measured.
        least_step_units: f64 = 1e-7,
    }
}

constants! {
    /// The joined warm start of a continuation ([`crate::extend::warm_start_joined`]).
    Joined {
        /// Seconds by which a difference of speeds is divided to compare it with one of accelerations.
        /// More counts a difference of accelerations for more, less one of speeds. Not measured.
        soon_s: f64 = 0.01,
        /// Other instants of the second motion to examine near the one at the same arc length, and seconds between them.
        /// More instants find a closer pair, and take more time. Not measured.
        shifts: i32 = 4,
        shift_s: f64 = 2.5e-4,
        /// Least time to follow the running motion.
        /// As [`Extend::least_followed_s`]. Not measured.
        least_followed_s: f64 = 0.004,
        /// Knots closer than this would coincide.
        /// It keeps the spans at the seam from being many times shorter than their neighbours, which is a jerk. Not measured.
        least_span_s: f64 = 2e-4,
        /// The sum of shares of tolerance, speed and acceleration up to which two motions are alike.
        /// More joins motions that repairs do not bring inside, less finds fewer pairs. Not measured.
        most_unlike: f64 = 1.5,
    }
}

constants! {
    /// The continuation on evenly rounded corners, within all limits from the warm start on ([`crate::extend::gentle`]).
    Gentle {
        /// The interval in which the continuation may leave the running motion, in seconds before its last braking and as a share of
        /// that braking; and the number of instants in it.
        /// Earlier and more instants find a better one and take more time; behind the middle of its last braking an S-curve cannot continue without a
        /// rest. Not measured.
        before_s: f64 = 0.15,
        latest_share: f64 = 0.9,
        leaves: usize = 40,
        /// Most possible instants among those to try.
        /// More find more extensions, and take their time. Not measured.
        attempts: usize = 12,
        /// Seconds of one extension, as a share of the usual ones.
        /// Less is planned sooner, more leaves more time until the next one. Not measured.
        ahead_share: f64 = 0.5,
        /// The same for a continuation from instants long before the running motion brakes. Fewer moves are found with less work: with 0.5 five of 250
        /// random streams rested whose plans came as late as their processor time, not three.
        sooner_share: f64 = 0.2,
        /// Share of the limits for changes of the speed where the path turns.
        /// More is faster, less is more often within the limits at once. Not measured.
        turning_share: f64 = 0.3,
        /// Shares of the continuations, in the order in which they are tried: of the limits along the path for changes of the speed, and of the speed within
        /// all limits. More is faster, less is more often within the limits at once. With one slow speed for the whole extension, one slow corner made
        /// 41 s of 0.8 s. The values are not measured.
        shares: [[f64; 2]; 5] = [[0.3, 0.8], [0.5, 0.8], [0.7, 0.8], [0.88, 0.8], [0.88, 0.4]],
        /// The same shares for a motion from rest. As much time and motion for 39 first plans with 0.3 and 0.8, 0.7 and 0.8, or 0.5 and 0.9.
        begin_shares: [f64; 2] = [0.5, 0.8],
        /// The same shares along the smooth curve of dense chords. Not measured.
        smooth_shares: [[f64; 2]; 4] = [[0.2, 0.7], [0.3, 0.8], [0.5, 0.8], [0.8, 0.85]],
        /// Share of the permitted speed of a stretch at which a running motion may enter it.
        /// Above it the change of the curvature at the entry needs more than the limits; below it the motion slows down without need. Not measured.
        entry_share: f64 = 0.95,
        /// Least time of a change of the acceleration, seconds.
        /// Less changes the acceleration with more jerk, more is slower. Not measured.
        step_s: f64 = 0.005,
        /// Nodes of a rounding, and of one beside a piece that the curve keeps close to.
        /// More nodes follow a rounding more exactly, and take more time. Not measured.
        rounding_nodes: [f64; 2] = [8.0, 16.0],
        /// Points of a rounding at which its limits are sampled. More find more of an excess, and take more time. Not measured.
        rounding_samples: u32 = 16,
        /// Tangents (unit vectors) with a larger difference form a corner: a thousand times
        /// [`crate::tolerance::SAME_TANGENT_SINE`]. Less rounds joints that are smooth but for rounding, more leaves a kink of the speed. Not measured.
        corner: f64 = 1e-3,
        /// Points of the fading offset at which its position and rates are sampled. More find more of an excess, and take more time. Not measured.
        fade_samples: u32 = 16,
        /// Share of the limits for the offset that fades out.
        /// More fades sooner and leaves less for the motion itself. Not measured.
        fade_share: f64 = 0.2,
        /// The least and the longest time in which it fades out, seconds, and the factor from one trial to the next.
        /// Longer fades more gently and reaches into further corners; a smaller factor finds a shorter time in more trials. Not measured.
        fade_s: [f64; 2] = [0.004, 0.1],
        fade_factor: f64 = 1.3,
        /// Most nodes of a continuation: with more it is very slow, and only to hasten it takes long. Without a bound, one of 100,000 moves took 4 s for 10 s
        /// of motion.
        most_nodes: usize = 8000,
        /// Ratio of the speeds of a smooth curve within one part, and the least number of nodes of a part.
        /// More makes longer parts with one speed, which is that of their slowest place; fewer nodes make more parts. Not measured.
        alike: f64 = 1.25,
        least_part: f64 = 4.0,
        /// Most instants at which the continuation leaves the running motion for a smooth curve.
        /// More find more extensions, and take their time. Not measured.
        smooth_attempts: usize = 6,
        /// Most smoothings of the curve if it is outside with the times of the faster motion.
        /// As those of [`Smooth`]. Not measured.
        repairs: usize = 3,
    }
}

/// The parameters of one attempt to extend a running trajectory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attempt {
    /// Seconds after the last splice before the braking; less than 0: before it.
    pub(crate) later_s: f64,
    /// The instant at which the warm start leaves the running motion: times of braking before its end.
    pub(crate) brakings: f64,
    /// The part of dense chords that is slowed down first.
    pub(crate) slow_down: SlowDown,
    /// The smooth curve begins where the warm start leaves the running motion, not before.
    pub(crate) holds: bool,
}

/// The part of a continuation's timing that is slowed down if it begins outside its limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SlowDown {
    /// The nodes outside, and those that lead there.
    Outside,
    /// All nodes.
    Whole,
}

const fn attempt(later_s: f64, brakings: f64, slow_down: SlowDown, holds: bool) -> Attempt {
    Attempt {
        later_s,
        brakings,
        slow_down,
        holds,
    }
}

/// The attempts in their usual order.
const ATTEMPTS: [Attempt; 6] = [
    attempt(0.0, 1.0, SlowDown::Outside, false),
    attempt(0.0, 1.0, SlowDown::Whole, true),
    attempt(0.02, 1.0, SlowDown::Outside, false),
    attempt(0.04, 0.7, SlowDown::Whole, true),
    attempt(0.06, 0.45, SlowDown::Outside, false),
    attempt(0.08, 0.25, SlowDown::Whole, true),
];

constants! {
    /// The attempts of an extension from a warm start outside of the limits, in their order, until one yields a motion.
    Attempts {
        /// A later splice is at a slower instant, and leaves less time; leaving the running motion later keeps more of it. Slowing down what is outside alone
        /// takes one stage to close in and not four (`surface` 11,500 to 21,000 moves/s); chords of 0.5 mm at 0.005 mm are outside nearly everywhere and
        /// need all of it slowed down. Every other attempt holds the running curve; always: `coarse` with trapezoids 0.10 of the motion. The instants
        /// are not measured.
        usual: [Attempt; 6] = ATTEMPTS,
        /// For a short rest of the running motion ([`Extend::short_s`] has the experiment): a splice at a slower instant succeeds more often than a slower
        /// motion only. Of 13 extensions of `fine` that were not found at once, 11 were from an instant 40 ms later, and none by slowing down more.
        /// Further ones take the time of what is behind them: with all six, 22 of 36 starts of dense S-curves that are sent at 5 moves a millisecond rested.
        short: [Attempt; 2] = [ATTEMPTS[0], ATTEMPTS[3]],
        /// A long rest leaves time for splices before the braking too: later ones of S-curves were outside by more and more (2.6, 4.9 and 7.3 times). With those
        /// `coarse` takes 9.56 s of motion, not 10.14, `rows` 26.3 for 26.7, and `rough` 15.5 s for 17.9, in half of the planning; all with S-curves.
        /// Trapezoids as before, `rough` in two thirds of the planning. The last three, where all others fail, are before the place that they fail at: an end in
        /// a tight bend. Without them 10 of 60 runs of `coarse` with S-curves took 7 % more time than the others, and `rough` 1.4 % more in the mean.
        long: [Attempt; 11] = [
            ATTEMPTS[0],
            attempt(-0.1, 1.0, SlowDown::Whole, false),
            attempt(-0.2, 1.0, SlowDown::Whole, false),
            ATTEMPTS[1],
            ATTEMPTS[2],
            ATTEMPTS[3],
            ATTEMPTS[4],
            ATTEMPTS[5],
            attempt(-0.3, 1.0, SlowDown::Whole, false),
            attempt(-0.45, 1.0, SlowDown::Whole, false),
            attempt(-0.6, 1.0, SlowDown::Whole, false),
        ],
    }
}
