//! A first guess of the timing, only to place the nodes: dense where the motion will be slow.
//!
//! Speed bounds from curvature and its change, one backward and one forward pass with constant
//! acceleration, and nodes at equal intervals of the resulting time. Seconds and position units.

use crate::allowance::Allowance;
use crate::course::Course;
use crate::nodes::Nodes;
use crate::rounding::{Smoothness, Stretch};
use crate::{Bounds, Point};

/// A point of the rounded course.
pub(crate) struct Sample {
    stretch: usize,
    u: f64,
    pub(crate) point: Point,
    pub(crate) progress: f64,
}

/// How fast the samples are passed, as a first guess.
pub(crate) struct Speeds {
    /// Squares of the speed at the samples.
    pub(crate) square: Vec<f64>,
    /// Seconds from the first sample.
    pub(crate) times: Vec<f64>,
    /// Distance from sample to sample.
    length: Vec<f64>,
    /// Acceleration along the path from sample to sample.
    rate: Vec<f64>,
    pub(crate) curvature: Vec<Point>,
}

/// `bounds[i]` belongs to piece `i` of the course.
pub(crate) fn nodes(
    course: &Course,
    allowance: &Allowance,
    stretches: &[Stretch],
    bounds: &[Bounds],
    smoothness: Smoothness,
) -> Nodes {
    let samples = sample(course, stretches);
    let count = samples.len();
    let Speeds {
        square,
        times,
        length,
        rate,
        curvature,
    } = speeds(course, &samples, bounds, smoothness, 0.0);
    let total = times[count - 1];
    let warp = Warp::new(
        total,
        rate[0] * TANGENT_SHARE,
        rate[count - 2] * TANGENT_SHARE,
        bounds,
        smoothness,
    );
    let whole = warp.stretched(total);
    let mut busy = Vec::new();
    for i in 0..count - 1 {
        let cruise = square[i] == square[i + 1] && curvature[i] == Point::zeros() && curvature[i + 1] == Point::zeros();
        if !cruise {
            busy.push((warp.warped(times[i]), warp.warped(times[i + 1])));
        }
    }
    let fine = allowance.roundings(course, |s| {
        let k = samples
            .partition_point(|sample| sample.progress < s)
            .clamp(1, count - 1);
        let (before, behind) = (samples[k - 1].progress, samples[k].progress);
        warp.warped(times[k - 1] + (times[k] - times[k - 1]) * ((s - before) / (behind - before)).clamp(0.0, 1.0))
    });
    let grid = grid(whole, &busy, &fine);
    let mut nodes = Nodes {
        points: Vec::with_capacity(grid.len()),
        progress: Vec::with_capacity(grid.len()),
        spans: grid.windows(2).map(|pair| pair[1] - pair[0]).collect(),
        lead: None,
        kept: 0,
    };
    let mut i = 0;
    let mut on_arc = Vec::with_capacity(grid.len());
    for at in sites(&grid) {
        let time = warp.nominal(at);
        while i + 2 < count && times[i + 1] < time {
            i += 1;
        }
        let (v0, v1) = (square[i].sqrt(), square[i + 1].sqrt());
        let (dt, t) = (times[i + 1] - times[i], time - times[i]);
        let part = ((v0 + (v1 - v0) / dt * t / 2.0) * t / length[i]).clamp(0.0, 1.0);
        let (here, next) = (&samples[i], &samples[i + 1]);
        let begin = if here.stretch == next.stretch { here.u } else { 0.0 };
        let u = begin + (next.u - begin) * part;
        nodes.points.push(stretches[next.stretch].at(course, u));
        on_arc.push(stretches[next.stretch].is_arc(course));
        nodes
            .progress
            .push(here.progress + (next.progress - here.progress) * part);
    }
    pass_through(&mut nodes.points, &grid, &on_arc);
    let last = grid.len() - 1;
    nodes.points[0] = course.pieces[0].start();
    nodes.points[last] = course.pieces[course.pieces.len() - 1].end();
    nodes.progress[last] = course.length();
    nodes
}

/// Moves the control points of arcs outwards, so that the curve is on the arc where they were.
fn pass_through(points: &mut [Point], grid: &[f64], on_arc: &[bool]) {
    let times: Vec<f64> = sites(grid).collect();
    let through: Vec<Point> = (0..points.len())
        .map(|i| {
            let inner = i > 1 && i + 2 < points.len() && on_arc[i - 1..=i + 1].iter().all(|&on| on);
            if !inner {
                return points[i];
            }
            let (before, behind) = (times[i] - times[i - 1], times[i + 1] - times[i]);
            let rates = [
                (points[i] - points[i - 1]) / before,
                (points[i + 1] - points[i]) / behind,
            ];
            let change = (rates[1] - rates[0]) * 2.0 / (before + behind);
            let [a, b, c] = [-1, 0, 1].map(|k| grid[i.wrapping_add_signed(k)] - times[i]);
            points[i] + change * ((a * b + b * c + c * a) / 6.0)
        })
        .collect();
    points.copy_from_slice(&through);
}

/// Bounds of the speed from curvature and its change, and what the rates along the path leave of them, from a speed
/// (its square) at the first sample to rest.
pub(crate) fn speeds(
    course: &Course,
    samples: &[Sample],
    bounds: &[Bounds],
    smoothness: Smoothness,
    start: f64,
) -> Speeds {
    let count = samples.len();
    let mut length = vec![0.0; count - 1];
    let mut tangent = vec![Point::zeros(); count - 1];
    for i in 0..count - 1 {
        let d = samples[i + 1].point - samples[i].point;
        length[i] = d.norm();
        tangent[i] = d / length[i];
    }
    let mut curvature = vec![Point::zeros(); count];
    for i in 1..count - 1 {
        curvature[i] = (tangent[i] - tangent[i - 1]) * 2.0 / (length[i] + length[i - 1]);
    }
    // Squares of the speed at the samples.
    let mut square = vec![f64::INFINITY; count];
    let mut rate = vec![0.0; count - 1];
    for i in 0..count - 1 {
        let piece = course.piece_at(0.5 * (samples[i].progress + samples[i + 1].progress));
        let bound = &bounds[piece];
        let mut most = bound.speed * bound.speed;
        rate[i] = bound.acceleration.min(bound.deceleration);
        for axis in 0..3 {
            let part = tangent[i][axis].abs();
            most = most.min((bound.axes.speed[axis] / part).powi(2));
            rate[i] = f64::min(rate[i], bound.axes.acceleration[axis] / part);
        }
        let turning = curvature[i].sup(&curvature[i + 1].abs()).sup(&curvature[i].abs());
        for axis in 0..3 {
            most = most.min(NORMAL_SHARE * bound.axes.acceleration[axis] / turning[axis]);
        }
        most = most.min(NORMAL_SHARE * bound.norm_acceleration() / turning.norm());
        if smoothness == Smoothness::SCurve {
            let change = (curvature[i + 1] - curvature[i]) / length[i];
            let mut cubed = JERK_SHARE * bound.norm_jerk() / change.norm();
            if let Some(jerk) = bound.axes.jerk {
                for axis in 0..3 {
                    cubed = cubed.min(JERK_SHARE * jerk[axis] / change[axis].abs());
                }
            }
            most = most.min(libm::cbrt(cubed).powi(2));
        }
        square[i] = square[i].min(most);
        square[i + 1] = square[i + 1].min(most);
    }
    (square[0], square[count - 1]) = (start, 0.0);
    for i in (0..count - 1).rev() {
        square[i] = square[i].min(square[i + 1] + 2.0 * TANGENT_SHARE * rate[i] * length[i]);
    }
    for i in 0..count - 1 {
        square[i + 1] = square[i + 1].min(square[i] + 2.0 * TANGENT_SHARE * rate[i] * length[i]);
    }
    // Too fast for what lies ahead: it brakes with all it has.
    if square[0] < start {
        square[0] = start;
        for i in 0..count - 2 {
            square[i + 1] = square[i + 1].max(square[i] - 2.0 * rate[i] * length[i]);
        }
    }
    let mut times = vec![0.0; count];
    for i in 0..count - 1 {
        times[i + 1] = times[i] + 2.0 * length[i] / (square[i].sqrt() + square[i + 1].sqrt());
    }
    Speeds {
        square,
        times,
        length,
        rate,
        curvature,
    }
}

/// Where on a grid of knots the control points of a line run through evenly would stand: the means of
/// three neighbours.
pub(crate) fn sites(grid: &[f64]) -> impl Iterator<Item = f64> + '_ {
    (0..grid.len()).map(|i| match (i.checked_sub(1).map(|k| grid[k]), grid.get(i + 1)) {
        (Some(before), Some(behind)) => (before + grid[i] + behind) / 3.0,
        _ => grid[i],
    })
}

/// Times of the nodes from 0 to `whole`: close together within and near the `busy` stretches
/// (ascending), farther and farther apart where nothing happens. Of the `fine` ones (ascending) each has [`FINE`] nodes, if that
/// is closer.
pub(crate) fn grid(whole: f64, busy: &[(f64, f64)], fine: &[(f64, f64)]) -> Vec<f64> {
    let all: f64 = busy.iter().map(|(from, to)| to - from).sum();
    let least = NODE_TIME
        .max((all + QUIET * busy.len().min(1000) as f64).min(whole) / MAX_NODES)
        .min(whole / MIN_NODES);
    let mut times = vec![0.0];
    let mut t = 0.0;
    let (mut next, mut finer) = (0, 0);
    while t < whole {
        while next < busy.len() && busy[next].1 < t {
            next += 1;
        }
        let since = if next > 0 { t - busy[next - 1].1 } else { t };
        let until = busy.get(next).map_or(whole, |stretch| stretch.0.min(whole)) - t;
        let far = since.min(until) - QUIET;
        let mut step = least + GROWTH * far.max(0.0);
        while finer + 1 < fine.len() && fine[finer + 1].0 < t {
            finer += 1;
        }
        for &(from, to) in fine.iter().skip(finer).take(2) {
            let off = (from - t).max(t - to).max(0.0);
            step = step.min(((to - from) / FINE).clamp(FINEST.min(least), least) + SPREAD * off);
        }
        t += step;
        times.push(t);
    }
    // Fitted to the whole, which moves every node by less than one of the last steps.
    let scale = whole / t;
    for time in &mut times {
        *time *= scale;
    }
    let last = times.len() - 1;
    times[last] = whole;
    times
}

/// The rounded course as points.
pub(crate) fn sample(course: &Course, stretches: &[Stretch]) -> Vec<Sample> {
    let mut samples: Vec<Sample> = Vec::new();
    let whole = course.length();
    for (index, stretch) in stretches.iter().enumerate() {
        let span = stretch.to - stretch.from;
        let count = match &stretch.shape {
            crate::rounding::Shape::Bezier(..) => 24,
            crate::rounding::Shape::Piece(piece) => match &course.pieces[*piece] {
                arcline_geometry::Path::Line(_) => (400.0 * span / whole).clamp(4.0, 200.0) as usize,
                arcline_geometry::Path::Arc(arc) => (span / arc.radius() * 20.0).clamp(8.0, 1000.0) as usize,
            },
        };
        for k in usize::from(!samples.is_empty())..=count {
            let u = k as f64 / count as f64;
            let point = stretch.at(course, u);
            if samples.last().is_some_and(|last| (last.point - point).norm() <= 1e-12) {
                continue;
            }
            samples.push(Sample {
                stretch: index,
                u,
                point,
                progress: stretch.from + span * u,
            });
        }
    }
    samples
}

/// An S-curve leaves rest with `s = j t³/6`, not `a t²/2`: the time near both ends is warped so that
/// the nodes follow the cube, and the retiming has no singular start.
pub(crate) struct Warp {
    total: f64,
    /// Acceleration over jerk at the start and at the end, seconds; 0: no warp.
    ratios: [f64; 2],
}

impl Warp {
    pub(crate) fn new(total: f64, first: f64, last: f64, bounds: &[Bounds], smoothness: Smoothness) -> Warp {
        let ratio = |rate: f64, bound: Option<&Bounds>| match (smoothness, bound) {
            (Smoothness::SCurve, Some(bound)) => (rate / bound.least_jerk()).min(total / 2.0),
            _ => 0.0,
        };
        Warp {
            total,
            ratios: [ratio(first, bounds.first()), ratio(last, bounds.last())],
        }
    }

    /// Warped time at a nominal one near one end.
    fn stretch_end(ratio: f64, t: f64) -> f64 {
        if t < 8.0 / 9.0 * ratio {
            libm::cbrt(3.0 * ratio * t * t)
        } else {
            t + 4.0 / 9.0 * ratio
        }
    }

    fn shrink_end(ratio: f64, t: f64) -> f64 {
        if t < 4.0 / 3.0 * ratio {
            (t * t * t / (3.0 * ratio)).sqrt()
        } else {
            t - 4.0 / 9.0 * ratio
        }
    }

    pub(crate) fn stretched(&self, total: f64) -> f64 {
        Warp::stretch_end(self.ratios[0], total / 2.0) + Warp::stretch_end(self.ratios[1], total / 2.0)
    }

    /// Warped time of a nominal one.
    pub(crate) fn warped(&self, t: f64) -> f64 {
        if t <= self.total / 2.0 {
            Warp::stretch_end(self.ratios[0], t)
        } else {
            self.stretched(self.total) - Warp::stretch_end(self.ratios[1], self.total - t)
        }
    }

    /// Nominal time of a warped one.
    pub(crate) fn nominal(&self, t: f64) -> f64 {
        let half = Warp::stretch_end(self.ratios[0], self.total / 2.0);
        if t <= half {
            Warp::shrink_end(self.ratios[0], t)
        } else {
            let rest = self.stretched(self.total) - t;
            self.total - Warp::shrink_end(self.ratios[1], rest.max(0.0))
        }
    }
}

/// Nodes are a millisecond apart where the motion is short enough.
pub(crate) const NODE_TIME: f64 = 0.001;
const MIN_NODES: f64 = 160.0;
const MAX_NODES: f64 = 24_000.0;
/// Seconds next to a busy stretch with close nodes, and how fast they spread beyond.
const QUIET: f64 = 0.25;
const GROWTH: f64 = 0.08;
/// Nodes in the rounding of a corner beside a piece that is kept to, the shortest time between two, seconds, and how fast they spread beyond.
const FINE: f64 = 20.0;
const FINEST: f64 = 5e-5;
const SPREAD: f64 = 0.2;
/// Shares of the limits that the guess uses across and along the curve.
const NORMAL_SHARE: f64 = 0.8;
const TANGENT_SHARE: f64 = 0.9;
const JERK_SHARE: f64 = 0.6;
