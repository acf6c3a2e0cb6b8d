//! The first guess of a motion that continues another one: that one up to where it brakes for its end, from there on the
//! rounded course. Position units and seconds.

use crate::course::along;
use crate::nodes::{LEAD, Nodes, blossom, led_grid};
use crate::nominal::{NODE_TIME, Sample, Speeds, sample, speeds};
use crate::rounding::Smoothness;
use crate::section::Section;
use crate::{Point, State, Trajectory};

/// What is continued.
#[derive(Clone, Copy)]
pub(crate) struct Running<'a> {
    pub(crate) trajectory: &'a Trajectory,
    /// From when on it is planned anew.
    pub(crate) splice: f64,
    /// From when on it is no longer followed.
    pub(crate) leave: f64,
    /// The piece of the section's course that it is on at the splice.
    pub(crate) piece: usize,
}

/// A point of the guess.
#[derive(Clone, Copy)]
pub(crate) struct Site {
    /// Seconds from the splice.
    pub(crate) time: f64,
    pub(crate) point: Point,
    pub(crate) progress: f64,
    /// Speed, units / s.
    pub(crate) speed: f64,
    cruise: bool,
}

/// Nodes of the whole motion from the splice to the end of the section.
pub(crate) fn guess(section: &Section<'_>, running: Running<'_>) -> Nodes {
    let course = &section.course;
    let mut route = followed(section, running);
    let left = running.leave - running.splice;
    let from = running.trajectory.at(running.leave);
    let at = route.last().map_or(0.0, |site| site.progress);
    lead_on(section, &mut route, &from, left, at);
    let whole = route.last().map_or(left, |site| site.time);
    let busy: Vec<(f64, f64)> = route
        .windows(2)
        .filter(|pair| !pair[1].cruise)
        .map(|pair| (pair[0].time, pair[1].time))
        .collect();
    let running_knots = knots(running);
    let followed = running_knots.len();
    let fine = section.allowance.roundings(course, |s| {
        let k = route
            .partition_point(|site| site.progress < s)
            .clamp(1, route.len() - 1);
        let (before, behind) = (&route[k - 1], &route[k]);
        let part = ((s - before.progress) / (behind.progress - before.progress)).clamp(0.0, 1.0);
        let time = before.time + (behind.time - before.time) * part;
        if time.is_finite() { time } else { behind.time }
    });
    let grid = led_grid(running_knots, whole, &busy, &fine);
    let mut nodes = Nodes {
        points: Vec::with_capacity(grid.len()),
        progress: Vec::with_capacity(grid.len()),
        spans: grid.windows(2).map(|pair| pair[1] - pair[0]).collect(),
        lead: Some(running.trajectory.at(running.splice)),
        // The end of what is followed is free to be passed faster.
        kept: (followed * 2 / 3).max(LEAD + 1).min(followed - 1),
    };
    let mut i = 0;
    for k in 0..grid.len() {
        let before = grid[k.max(1)] - grid[k.max(1) - 1];
        let behind = grid.get(k + 1).map_or(before, |next| next - grid[k]);
        // The mean of three knots.
        let time = grid[k] + (behind - before) / 3.0;
        while i + 2 < route.len() && route[i + 1].time < time {
            i += 1;
        }
        let (here, next) = (&route[i], &route[i + 1]);
        let (span, t) = (next.time - here.time, (time - here.time).max(0.0));
        let gone = (here.speed + (next.speed - here.speed) / span * t / 2.0) * t;
        let part = gone / (0.5 * (here.speed + next.speed) * span);
        let part = if part.is_finite() {
            part.clamp(0.0, 1.0)
        } else {
            t / span
        };
        let point = if k + 1 < followed {
            blossom(&running.trajectory.at(running.splice + grid[k]), [-before, 0.0, behind])
        } else {
            here.point + (next.point - here.point) * part
        };
        nodes.points.push(point);
        nodes
            .progress
            .push(here.progress + (next.progress - here.progress) * part);
    }
    let last = grid.len() - 1;
    nodes.points[last] = course.pieces[course.pieces.len() - 1].end();
    nodes.progress[last] = course.length();
    nodes.set_lead();
    nodes
}

/// The knots of the running motion from the splice until it is left, long spans divided, from one span before it on.
/// On these the curve that is followed is a spline, to the last bit of its limits.
pub(crate) fn knots(running: Running<'_>) -> Vec<f64> {
    let own = &running.trajectory.knots;
    let first = own.partition_point(|knot| knot.time <= running.splice);
    let inner = own[first..]
        .iter()
        .map(|knot| knot.time)
        .take_while(|&time| time < running.leave);
    let mut times = vec![0.0];
    for time in inner.chain([running.leave]) {
        let from = times[times.len() - 1];
        let span = time - running.splice - from;
        // Knots that are nearly the same would be one.
        if span < LEAST_SPAN && time < running.leave {
            continue;
        }
        let parts = (span / MOST_SPAN).ceil().max(1.0);
        times.extend((1..=parts as usize).map(|k| from + span * k as f64 / parts));
    }
    while times.len() < LEAD + 2 {
        let last = times[times.len() - 1];
        times.push(last + NODE_TIME);
    }
    times.insert(0, -times[1]);
    times
}

/// The running motion from the splice until it is left.
pub(crate) fn followed(section: &Section<'_>, running: Running<'_>) -> Vec<Site> {
    let course = &section.course;
    let left = running.leave - running.splice;
    let count = (left / STEP).ceil().max(1.0) as usize;
    let (mut piece, mut least) = (running.piece, 0.0);
    (0..=count)
        .map(|k| {
            let time = left * k as f64 / count as f64;
            let state = running.trajectory.at(running.splice + time);
            piece = course.foot(&state.position, piece).1;
            least = f64::max(
                least,
                course.starts[piece] + along(&course.pieces[piece], &state.position),
            );
            Site {
                time,
                point: state.position,
                progress: least,
                speed: state.velocity.norm(),
                cruise: state.acceleration == Point::zeros(),
            }
        })
        .collect()
}

/// From a state near the course at arc length `at` along the rounded course to its end.
fn lead_on(section: &Section<'_>, route: &mut Vec<Site>, from: &State, start: f64, at: f64) {
    let course = &section.course;
    let (free, stretches) = section.first_guess();
    let mut samples = sample(course, &stretches);
    let behind = samples.partition_point(|s| s.progress <= at + LEAST_STEP);
    let base = match (behind.checked_sub(1).map(|k| &samples[k]), samples.get(behind)) {
        (Some(here), Some(next)) => {
            let part = ((at - here.progress) / (next.progress - here.progress)).clamp(0.0, 1.0);
            here.point + (next.point - here.point) * part
        }
        (Some(end), None) => end.point,
        _ => samples[0].point,
    };
    let mut ahead: Vec<Sample> = samples.drain(behind.max(1) - 1..).collect();
    if ahead.len() < 2 {
        return;
    }
    // The first one is where it is, and the offset from the rounded course fades out.
    ahead[0].progress = at;
    let speed = from.velocity.norm();
    let fade = (speed * FADE).max(LEAST_FADE);
    let offset = from.position - base;
    for (k, one) in ahead.iter_mut().enumerate() {
        let u = ((one.progress - at) / fade).clamp(0.0, 1.0);
        if k == 0 {
            one.point = from.position;
        } else {
            one.point += offset * (1.0 - u * u * (3.0 - 2.0 * u));
        }
    }
    let Speeds {
        square,
        times,
        curvature,
        ..
    } = speeds(course, &ahead, &free, Smoothness::Trapezoid, speed * speed);
    for k in 1..ahead.len() {
        route.push(Site {
            time: start + times[k],
            point: ahead[k].point,
            progress: ahead[k].progress,
            speed: square[k].sqrt(),
            cruise: square[k - 1] == square[k]
                && curvature[k - 1] == Point::zeros()
                && curvature[k] == Point::zeros()
                && ahead[k].progress > at + fade,
        });
    }
}

/// Shortest and longest time between the knots of a motion that is followed, seconds.
const LEAST_SPAN: f64 = 2e-5;
const MOST_SPAN: f64 = 0.002;
/// Seconds from point to point of the motion that is followed.
const STEP: f64 = 5e-4;
/// Seconds, at least so many position units, in which the offset from the rounded course fades out.
const FADE: f64 = 0.015;
const LEAST_FADE: f64 = 1e-6;
/// Position units that the first step goes at least.
const LEAST_STEP: f64 = 1e-7;
