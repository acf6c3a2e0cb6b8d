//! From moves to a trajectory: sections from rest to rest, each rounded, timed and improved.

use crate::course::{Course, along};
use crate::nominal::{Nodes, Warp, grid, nodes, sites};
use crate::optimise;
use crate::rounding::{Smoothness, round};
use crate::setup::problem;
use crate::share::Share;
use crate::straight::straight;
use crate::{AxisLimits, Bounds, ContourMove, Path, Point, Trajectory};

/// How much work a plan may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Timing only, on corners rounded one by one.
    Quick,
    /// Timing and shape together.
    Full,
}

/// Plans the moves from rest to rest; the last one ends exactly. Total: what cannot be rounded is
/// stopped at. An empty list gives a trajectory of no duration at the origin.
#[must_use]
pub fn plan(moves: &[ContourMove], limits: &AxisLimits) -> Trajectory {
    plan_with(moves, limits, Effort::Full)
}

/// [`plan`] with a choice of how much work it may be.
#[must_use]
pub fn plan_with(moves: &[ContourMove], limits: &AxisLimits, effort: Effort) -> Trajectory {
    let start = moves.first().map_or(Point::zeros(), |first| first.path.start());
    let mut whole = Trajectory::rest(start);
    let mut section: Vec<ContourMove> = Vec::new();
    for (index, next) in moves.iter().enumerate() {
        section.push(*next);
        let stops = moves.get(index + 1).is_none_or(|after| !can_pass(next, after));
        if stops {
            whole.append(plan_section(&section, limits, effort));
            section.clear();
        }
    }
    whole
}

/// Whether the joint between two moves can be passed without a stop.
fn can_pass(before: &ContourMove, after: &ContourMove) -> bool {
    if before.jerk.is_some() != after.jerk.is_some() {
        return false;
    }
    let tangent = (before.path.end_tangent() - after.path.start_tangent()).norm() <= TANGENT;
    tangent || before.tolerance > 0.0 || before.path.length() <= 0.0 || after.path.length() <= 0.0
}

/// Plans one section, as well as it can be done: what is outside the tube or the limits is planned
/// again with less freedom, at last with a stop at every joint.
fn plan_section(moves: &[ContourMove], limits: &AxisLimits, effort: Effort) -> Trajectory {
    let smoothness = if moves.iter().any(|m| m.jerk.is_some()) {
        Smoothness::SCurve
    } else {
        Smoothness::Trapezoid
    };
    let long: Vec<&ContourMove> = moves.iter().filter(|m| m.path.length() > SHORTEST).collect();
    let end = moves.last().map_or(Point::zeros(), |last| last.path.end());
    if let [one] = long.as_slice()
        && let Path::Line(line) = &one.path
    {
        let mut trajectory = straight(line, &bounds(one, limits, smoothness));
        let before = moves.iter().take_while(|m| m.path.length() <= SHORTEST).count();
        trajectory.move_ends = vec![0.0; before];
        trajectory.move_ends.resize(moves.len(), trajectory.duration());
        trajectory.end = end;
        return trajectory;
    }
    if long.is_empty() {
        let mut rest = Trajectory::rest(end);
        rest.move_ends = vec![0.0; moves.len()];
        return rest;
    }
    let course = Course::new(long.iter().map(|m| m.path).collect());
    let bounds: Vec<Bounds> = long.iter().map(|m| bounds(m, limits, smoothness)).collect();
    let tolerances: Vec<f64> = long.iter().map(|m| m.tolerance).collect();
    let section = Section {
        moves,
        course,
        bounds,
        tolerances,
        smoothness,
    };
    let efforts: &[Effort] = match effort {
        Effort::Full => &[Effort::Full, Effort::Quick],
        Effort::Quick => &[Effort::Quick],
    };
    for &effort in efforts {
        if let Some(trajectory) = section.plan(effort) {
            return trajectory;
        }
    }
    if long.len() == 1 {
        return section.crawl();
    }
    let mut whole = Trajectory::rest(moves[0].path.start());
    for one in moves {
        whole.append(plan_section(core::slice::from_ref(one), limits, effort));
    }
    whole
}

/// Moves from rest to rest without a stop between them.
struct Section<'a> {
    moves: &'a [ContourMove],
    course: Course,
    bounds: Vec<Bounds>,
    tolerances: Vec<f64>,
    smoothness: Smoothness,
}

impl Section<'_> {
    fn plan(&self, effort: Effort) -> Option<Trajectory> {
        let Section {
            course,
            bounds,
            tolerances,
            smoothness,
            ..
        } = self;
        let smoothness = *smoothness;
        // An S-curve starts from the trapezoid's shape: without jerk limits the optimisation is not stiff.
        let free: Vec<Bounds> = bounds.iter().map(Bounds::without_jerk).collect();
        let stretches = round(course, tolerances, Smoothness::Trapezoid);
        let mut nodes = nodes(course, &stretches, &free, Smoothness::Trapezoid);
        let rounds = rounds(smoothness, effort);
        let mut share = Share::new();
        let mut last: Option<(Trajectory, Vec<f64>)> = None;
        let mut warped = Smoothness::Trapezoid;
        for (index, round) in rounds.iter().enumerate() {
            let limited = if round.jerk { bounds } else { &free };
            if let Some((trajectory, times)) = &last {
                let warp = if round.jerk {
                    core::mem::replace(&mut warped, Smoothness::Trapezoid)
                } else {
                    Smoothness::Trapezoid
                };
                nodes = resample(trajectory, times, &nodes, bounds, warp);
                project(course, &mut nodes);
            }
            if !round.jerk {
                warped = smoothness;
            }
            let shares: Vec<f64> = nodes.progress.iter().map(|&s| share.at(s)).collect();
            let mut problem = problem(course, &nodes, limited, tolerances, effort, &shares);
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
            let (trajectory, times) = timed(&nodes, limited, course, round.last_one);
            if !trajectory.duration().is_finite() {
                return None;
            }
            let worst = share.tighten(&trajectory, &nodes, course, tolerances);
            if round.last_one && worst <= 1.0 {
                return Some(self.finish(trajectory, &nodes, &times));
            }
            // The first repair is local; then the whole tube gives way.
            if index + REPAIRS > rounds.len() {
                share.narrow(worst);
            }
            last = Some((trajectory, times));
        }
        None
    }

    fn finish(&self, mut trajectory: Trajectory, nodes: &Nodes, times: &[f64]) -> Trajectory {
        trajectory.move_ends = move_ends(self.moves, &self.course, nodes, times, trajectory.duration());
        trajectory.end = self.moves.last().map_or(trajectory.end, |last| last.path.end());
        trajectory
    }

    /// The last resort for a single curve: the nominal timing, as slow as the limits ask for.
    fn crawl(&self) -> Trajectory {
        let stretches = round(&self.course, &self.tolerances, Smoothness::Trapezoid);
        let nodes = nodes(&self.course, &stretches, &self.bounds, self.smoothness);
        let (trajectory, times) = timed(&nodes, &self.bounds, &self.course, true);
        self.finish(trajectory, &nodes, &times)
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

/// The spline through the nodes, slowed down or sped up as a whole so that no limit is exceeded,
/// and the time of each node.
fn timed(nodes: &Nodes, bounds: &[Bounds], course: &Course, keep: bool) -> (Trajectory, Vec<f64>) {
    let trajectory = Trajectory::spline(&nodes.points, &nodes.spans);
    let factor = excess(&trajectory, nodes, bounds, course);
    let spans: Vec<f64> = nodes
        .spans
        .iter()
        .map(|span| span * if keep { factor } else { 1.0 })
        .collect();
    let trajectory = Trajectory::spline(&nodes.points, &spans);
    let times = trajectory.knots[1..=nodes.points.len()]
        .iter()
        .map(|k| k.time)
        .collect();
    (trajectory, times)
}

/// By what factor the trajectory must take longer to keep every limit; below 1 it may be shorter.
fn excess(trajectory: &Trajectory, nodes: &Nodes, bounds: &[Bounds], course: &Course) -> f64 {
    let mut factor = 0.0_f64;
    let last = nodes.progress.len() - 1;
    for (k, pair) in trajectory.knots.windows(2).enumerate() {
        let (knot, next) = (&pair[0], &pair[1]);
        let bound = &bounds[course.piece_at(nodes.progress[k.saturating_sub(1).min(last)])];
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

/// The same curve with nodes at equal intervals of its time, warped at its ends for an S-curve.
fn resample(trajectory: &Trajectory, times: &[f64], nodes: &Nodes, bounds: &[Bounds], smoothness: Smoothness) -> Nodes {
    let rate = |bound: Option<&Bounds>| bound.map_or(f64::INFINITY, |b| b.axes.acceleration.min().min(b.acceleration));
    let warp = Warp::new(
        trajectory.duration(),
        rate(bounds.first()),
        rate(bounds.last()),
        bounds,
        smoothness,
    );
    let whole = warp.stretched(trajectory.duration());
    let mut busy: Vec<(f64, f64)> = Vec::new();
    for pair in trajectory.knots.windows(2) {
        let (here, next) = (&pair[0], &pair[1]);
        let most = here.state.acceleration.norm().max(next.state.acceleration.norm());
        if most > IDLE * rate(bounds.first()).min(rate(bounds.last())) {
            busy.push((warp.warped(here.time), warp.warped(next.time)));
        }
    }
    let grid = grid(whole, &busy);
    let intervals = grid.len() - 1;
    let mut points = Vec::with_capacity(intervals + 1);
    let mut progress = Vec::with_capacity(intervals + 1);
    let mut i = 0;
    for at in sites(&grid) {
        let time = warp.nominal(at);
        points.push(trajectory.at(time).position);
        while i + 2 < times.len() && times[i + 1] < time {
            i += 1;
        }
        let part = ((time - times[i]) / (times[i + 1] - times[i])).clamp(0.0, 1.0);
        progress.push(nodes.progress[i] + (nodes.progress[i + 1] - nodes.progress[i]) * part);
    }
    points[0] = nodes.points[0];
    points[intervals] = trajectory.end;
    // Control points whose curve passes through the points (to the fourth order).
    let through: Vec<Point> = points
        .windows(3)
        .map(|p| p[1] - (p[2] - p[1] * 2.0 + p[0]) / 6.0)
        .collect();
    if let Some(inner) = points.get_mut(3..intervals.saturating_sub(2)) {
        inner.copy_from_slice(&through[2..intervals - 3]);
    }
    Nodes {
        points,
        progress,
        spans: grid.windows(2).map(|pair| pair[1] - pair[0]).collect(),
    }
}

/// Sets the progress of every node to that of the nearest point of the course, ascending.
fn project(course: &Course, nodes: &mut Nodes) {
    let mut least = 0.0;
    for (point, progress) in nodes.points.iter().zip(&mut nodes.progress) {
        let (_, piece) = course.foot(point, course.piece_at(*progress));
        let along = course.starts[piece] + along(&course.pieces[piece], point);
        least = f64::max(least, along);
        *progress = least;
    }
    let whole = course.length();
    for progress in &mut nodes.progress {
        *progress = progress.min(whole);
    }
    if let Some(last) = nodes.progress.last_mut() {
        *last = whole;
    }
}

fn bounds(one: &ContourMove, axes: &AxisLimits, smoothness: Smoothness) -> Bounds {
    let scurve = smoothness == Smoothness::SCurve;
    Bounds {
        speed: one.speed,
        acceleration: one.acceleration,
        deceleration: one.deceleration,
        jerk: one.jerk.filter(|_| scurve).unwrap_or(f64::INFINITY),
        axes: AxisLimits {
            jerk: axes.jerk.filter(|_| scurve),
            ..*axes
        },
    }
}

/// When each of `moves` ends: where the progress passes its end; moves without length end with the one before.
fn move_ends(moves: &[ContourMove], course: &Course, nodes: &Nodes, times: &[f64], whole: f64) -> Vec<f64> {
    let mut ends = Vec::with_capacity(moves.len());
    let (mut piece, mut last) = (0, 0.0);
    for one in moves {
        if one.path.length() > SHORTEST {
            piece += 1;
            let s = course.starts[piece];
            let k = nodes.progress.partition_point(|&p| p < s).clamp(1, times.len() - 1);
            let (p0, p1) = (nodes.progress[k - 1], nodes.progress[k]);
            let part = if p1 > p0 {
                ((s - p0) / (p1 - p0)).clamp(0.0, 1.0)
            } else {
                1.0
            };
            last = times[k - 1] + (times[k] - times[k - 1]) * part;
            if piece == course.pieces.len() {
                last = whole;
            }
        }
        ends.push(last);
    }
    ends
}

/// Tangents that differ by no more than this are equal (spec/motion-core.md §6.3).
const TANGENT: f64 = 1e-6;
/// Shorter moves are done at once, position units.
pub(crate) const SHORTEST: f64 = 1e-9;
/// Share of the acceleration limit below which nothing happens.
const IDLE: f64 = 1e-3;
/// How often the tube is tightened where the result is outside.
const REPAIRS: usize = 5;
