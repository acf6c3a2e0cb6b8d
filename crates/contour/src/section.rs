//! One section: moves without a stop between them, from rest or from a running motion to rest.
//!
//! A few runs of the optimisation, each on nodes at equal times of the one before, the tube narrowed where
//! the curve was outside. Position units and seconds.

use crate::allowance::{Allowance, Begin};
use crate::course::Course;
use crate::nodes::Nodes;
use crate::nominal::nodes;
use crate::optimise;
use crate::plan::{Effort, SHORTEST, bounds, smoothness};
use crate::resample::{project, resample};
use crate::rounding::{Smoothness, Stretch, round};
use crate::setup::problem;
use crate::share::Share;
use crate::trajectory::MoveEnd;
use crate::{AxisLimits, Bounds, ContourMove, Trajectory};

/// What a section has come to.
pub(crate) struct Solved {
    pub(crate) trajectory: Trajectory,
    pub(crate) nodes: Nodes,
    /// The time of each node.
    pub(crate) times: Vec<f64>,
}

/// Moves from rest to rest without a stop between them.
pub(crate) struct Section<'a> {
    moves: &'a [ContourMove],
    pub(crate) course: Course,
    pub(crate) bounds: Vec<Bounds>,
    pub(crate) allowance: Allowance,
    pub(crate) smoothness: Smoothness,
}

impl<'a> Section<'a> {
    /// Moves of which at least one has a length.
    pub(crate) fn new(moves: &'a [ContourMove], limits: &AxisLimits, begin: Begin) -> Self {
        let smoothness = smoothness(moves);
        let long: Vec<&ContourMove> = moves.iter().filter(|m| m.path.length() > SHORTEST).collect();
        let course = Course::new(long.iter().map(|m| m.path).collect());
        let tolerances = long.iter().map(|m| m.tolerance).collect();
        let deviations = long.iter().map(|m| m.deviation);
        Section {
            moves,
            allowance: Allowance::new(&course, tolerances, deviations, smoothness, begin),
            course,
            bounds: long.iter().map(|m| bounds(m, limits, smoothness)).collect(),
            smoothness,
        }
    }

    /// The limits without those of the jerk, and the course rounded for them: an S-curve starts from the
    /// trapezoid's shape, as without jerk limits the optimisation is not stiff.
    pub(crate) fn first_guess(&self) -> (Vec<Bounds>, Vec<Stretch>) {
        (
            self.bounds.iter().map(Bounds::without_jerk).collect(),
            round(&self.course, &self.allowance, Smoothness::Trapezoid),
        )
    }

    /// From rest to rest; `None` where the result is not inside the tube and the limits.
    pub(crate) fn plan(&self, effort: Effort) -> Option<Trajectory> {
        Some(self.finish(self.solve(effort)?))
    }

    /// As [`Section::plan`], with its nodes.
    pub(crate) fn solve(&self, effort: Effort) -> Option<Solved> {
        let (free, stretches) = self.first_guess();
        let guess = nodes(&self.course, &self.allowance, &stretches, &free, Smoothness::Trapezoid);
        self.work(guess, effort, &rounds(self.smoothness, effort))
    }

    /// From a first guess to rest; `None` where the result is not inside the tube and the limits.
    pub(crate) fn improve(&self, nodes: Nodes, effort: Effort) -> Option<Trajectory> {
        Some(self.finish(self.work(nodes, effort, &rounds(self.smoothness, effort))?))
    }

    /// From a guess that is nearly within its limits.
    pub(crate) fn repair(&self, nodes: Nodes) -> Option<Trajectory> {
        let rounds = rounds(self.smoothness, Effort::Full);
        let last = &rounds[rounds.len() - REPAIRS..];
        Some(self.finish(self.work(nodes, Effort::Full, last)?))
    }

    fn work(&self, mut nodes: Nodes, effort: Effort, rounds: &[Round]) -> Option<Solved> {
        let Section {
            course,
            bounds,
            allowance,
            smoothness,
            ..
        } = self;
        let smoothness = *smoothness;
        let free: Vec<Bounds> = bounds.iter().map(Bounds::without_jerk).collect();
        let mut share = Share::new();
        let mut last: Option<(Trajectory, Vec<f64>)> = None;
        let mut warped = Smoothness::Trapezoid;
        for (index, round) in rounds.iter().enumerate() {
            let limited = if round.jerk { bounds } else { &free };
            // One that continues a motion is close to its limits everywhere: repairs keep its nodes.
            let keep = nodes.lead.is_some() && index + REPAIRS > rounds.len();
            if let Some((trajectory, times)) = last.as_ref().filter(|_| !keep) {
                let warp = if round.jerk {
                    core::mem::replace(&mut warped, Smoothness::Trapezoid)
                } else {
                    Smoothness::Trapezoid
                };
                let fine = allowance.roundings(course, |s| nodes.time_of(s, times));
                nodes = resample(trajectory, times, &nodes, bounds, &fine, warp);
                project(course, &mut nodes);
            }
            if !round.jerk {
                warped = smoothness;
            }
            let shares: Vec<f64> = nodes.progress.iter().map(|&s| share.at(s)).collect();
            let mut problem = problem(course, &nodes, (limited, bounds), allowance, effort, &shares);
            problem.make_feasible();
            problem.run(optimise::Effort {
                first: round.first,
                last: round.last,
                factor: 5.0,
                steps: round.steps,
            });
            let span = nodes.spans[0];
            nodes.points = core::mem::take(&mut problem.points);
            nodes.spans = problem.spans.iter().map(|h| span * h).collect();
            let (trajectory, times, excess) = timed(&nodes, limited, course, round.last_one);
            if !trajectory.duration().is_finite() {
                return None;
            }
            // A motion that waits for its continuation does not wait for ever.
            if nodes.lead.is_some() && round.last_one && excess > HOPELESS {
                return None;
            }
            let worst = share.tighten(&trajectory, &nodes, course, allowance);
            if round.last_one && worst <= 1.0 && excess <= 1.0 + ROUNDING {
                return Some(Solved {
                    trajectory,
                    nodes,
                    times,
                });
            }
            // The first repair is local; then the whole tube gives way.
            if index + REPAIRS > rounds.len() {
                share.narrow(worst, allowance);
            }
            last = Some((trajectory, times));
        }
        None
    }

    fn finish(&self, solved: Solved) -> Trajectory {
        let Solved {
            mut trajectory,
            nodes,
            times,
        } = solved;
        trajectory.move_ends = move_ends(self, &nodes, &times, trajectory.duration());
        trajectory.end = self.moves.last().map_or(trajectory.end, |last| last.path.end());
        trajectory
    }

    /// The last resort for a single curve: the nominal timing, as slow as the limits ask for.
    pub(crate) fn crawl(&self) -> Trajectory {
        let stretches = round(&self.course, &self.allowance, Smoothness::Trapezoid);
        let nodes = nodes(&self.course, &self.allowance, &stretches, &self.bounds, self.smoothness);
        let (trajectory, times, _) = timed(&nodes, &self.bounds, &self.course, true);
        self.finish(Solved {
            trajectory,
            nodes,
            times,
        })
    }
}

/// One run of the optimisation.
struct Round {
    jerk: bool,
    first: f64,
    last: f64,
    steps: usize,
    /// The result may be the final one.
    last_one: bool,
}

fn rounds(smoothness: Smoothness, effort: Effort) -> Vec<Round> {
    let round = |jerk, first, last, steps, last_one| Round {
        jerk,
        first,
        last,
        steps,
        last_one,
    };
    let mut rounds = match (smoothness, effort) {
        (Smoothness::Trapezoid, Effort::Quick) => vec![round(false, 1.0, 1000.0, 8, true)],
        (Smoothness::Trapezoid, Effort::Full) => {
            vec![round(false, 1.0, 300.0, 8, false), round(false, 5.0, 1000.0, 8, false)]
        }
        (Smoothness::SCurve, Effort::Quick) => {
            vec![round(false, 1.0, 30.0, 8, false), round(true, 1.0, 1000.0, 8, true)]
        }
        (Smoothness::SCurve, Effort::Full) => vec![
            round(false, 1.0, 30.0, 8, false),
            round(true, 1.0, 300.0, 12, false),
            round(true, 5.0, 1000.0, 8, false),
        ],
    };
    if effort == Effort::Full {
        for _ in 0..REPAIRS {
            rounds.push(round(smoothness == Smoothness::SCurve, 10.0, 2000.0, 8, true));
        }
    }
    rounds
}

/// The spline through the nodes, the time of each node, and by what factor the limits are exceeded. One that begins at
/// rest is slowed down or sped up as a whole so that none is; one that continues a motion cannot be.
fn timed(nodes: &Nodes, bounds: &[Bounds], course: &Course, keep: bool) -> (Trajectory, Vec<f64>, f64) {
    let trajectory = nodes.spline(&nodes.spans);
    let factor = excess(&trajectory, nodes, bounds, course);
    if nodes.lead.is_some() {
        let times = nodes.times(&trajectory);
        return (trajectory, times, factor);
    }
    let spans: Vec<f64> = nodes
        .spans
        .iter()
        .map(|span| span * if keep { factor } else { 1.0 })
        .collect();
    let trajectory = nodes.spline(&spans);
    let times = nodes.times(&trajectory);
    (trajectory, times, 1.0)
}

/// By what factor the trajectory must take longer to keep every limit; below 1 it may be shorter.
fn excess(trajectory: &Trajectory, nodes: &Nodes, bounds: &[Bounds], course: &Course) -> f64 {
    let mut factor = 0.0_f64;
    let last = nodes.progress.len() - 1;
    for (k, pair) in trajectory.knots.windows(2).enumerate() {
        let (knot, next) = (&pair[0], &pair[1]);
        let bound = &bounds[course.piece_at(nodes.progress[nodes.node_at(k).min(last)])];
        // Velocity is a parabola between knots: inside the hull of its Bezier points.
        let middle = knot.state.velocity + knot.state.acceleration * (0.5 * (next.time - knot.time));
        for velocity in [knot.state.velocity, middle] {
            factor = factor.max(velocity.norm() / bound.speed);
            for axis in 0..3 {
                factor = factor.max(velocity[axis].abs() / bound.axes.speed[axis]);
            }
        }
        factor = factor.max((knot.state.acceleration.norm() / bound.norm_acceleration()).sqrt());
        for axis in 0..3 {
            factor = factor.max((knot.state.acceleration[axis].abs() / bound.axes.acceleration[axis]).sqrt());
        }
        if bound.jerk.is_finite() {
            factor = factor.max(libm::cbrt(knot.jerk.norm() / bound.jerk));
        }
        if let Some(jerk) = bound.axes.jerk {
            for axis in 0..3 {
                factor = factor.max(libm::cbrt(knot.jerk[axis].abs() / jerk[axis]));
            }
        }
    }
    if factor > 0.0 { factor } else { 1.0 }
}

/// When each of `moves` ends: where the progress passes its end; moves without length end with the one before.
fn move_ends(section: &Section<'_>, nodes: &Nodes, times: &[f64], whole: f64) -> Vec<MoveEnd> {
    let course = &section.course;
    let time_at = |s: f64| nodes.time_of(s, times);
    let mut ends = Vec::with_capacity(section.moves.len());
    let (mut piece, mut last) = (0, MoveEnd::plain(0.0));
    for one in section.moves {
        if one.path.length() > SHORTEST {
            let [before, behind] = section.allowance.rounding(course, piece);
            piece += 1;
            let s = course.starts[piece];
            last = if piece == course.pieces.len() {
                MoveEnd::plain(whole)
            } else {
                MoveEnd {
                    time: time_at(s),
                    rounding: [time_at(s - before), time_at(s + behind)],
                }
            };
        }
        ends.push(last);
    }
    ends
}

/// How often the tube is tightened where the result is outside.
const REPAIRS: usize = 5;
/// What rounding errors make of a limit that is reached exactly, relative.
const ROUNDING: f64 = 1e-10;
/// By what factor a plan may exceed its limits and still be expected to come inside.
const HOPELESS: f64 = 1.2;
