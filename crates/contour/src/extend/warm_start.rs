//! The warm start of a continuation: the running motion up to its braking at its end, from there on the rounded reference path. Position
//! units and seconds.

use crate::limits::Smoothness;
use crate::path::reference::along;
use crate::section::Section;
use crate::solve::stages::Quality;
use crate::timing::control_points::{ControlPoints, GIVEN, blossom};
use crate::timing::grid::{Density, continued_grid};
use crate::timing::speed_profile::{Sample, sample, speeds};
use crate::tuning::TUNING;
use crate::{AxesState, Point, Trajectory};

/// A running trajectory to be continued.
#[derive(Clone, Copy)]
pub(crate) struct Running<'a> {
    pub(crate) trajectory: &'a Trajectory,
    /// The instant from which on it is planned anew.
    pub(crate) splice: f64,
    /// The instant until which the warm start follows it.
    pub(crate) leave: f64,
    /// The piece of the section's reference path at the splice.
    pub(crate) piece: usize,
}

/// A point of the warm start.
#[derive(Clone, Copy)]
pub(crate) struct RoutePoint {
    /// Seconds from the splice.
    pub(crate) time: f64,
    pub(crate) point: Point,
    pub(crate) progress: f64,
    /// Speed, units / s.
    pub(crate) speed: f64,
    cruise: bool,
}

/// Control points of the whole motion from the splice to the end of the section.
pub(crate) fn warm_start(section: &Section<'_>, running: Running<'_>) -> ControlPoints {
    let reference = &section.reference;
    let mut route = followed(section, running);
    let left = running.leave - running.splice;
    let from = running.trajectory.at(running.leave);
    let at = route.last().map_or(0.0, |point| point.progress);
    go_on(section, &mut route, &from, left, at);
    let running_knots = knots(section, running);
    let followed = running_knots.len();
    let grid = spread(section, &route, running_knots, left);
    let mut control = ControlPoints::continuing(running.trajectory.at(running.splice), &grid, followed);
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
        let part = here.part_gone(next, (time - here.time).max(0.0));
        let point = if k + 1 < followed {
            blossom(&running.trajectory.at(running.splice + grid[k]), [-before, 0.0, behind])
        } else {
            here.point + (next.point - here.point) * part
        };
        control.points.push(point);
        control
            .progress
            .push(here.progress + (next.progress - here.progress) * part);
    }
    control.completed(reference)
}

impl RoutePoint {
    /// The share of the distance to the next point covered after a time.
    fn part_gone(&self, next: &RoutePoint, t: f64) -> f64 {
        let span = next.time - self.time;
        let gone = (self.speed + (next.speed - self.speed) / span * t / 2.0) * t;
        let part = gone / (0.5 * (self.speed + next.speed) * span);
        if part.is_finite() {
            part.clamp(0.0, 1.0)
        } else {
            t / span
        }
    }
}

/// The knots of the running motion and those after it, closer where the route changes much. `left`: the end if there is no route.
fn spread(section: &Section<'_>, route: &[RoutePoint], running_knots: Vec<f64>, left: f64) -> Vec<f64> {
    let whole = route.last().map_or(left, |point| point.time);
    let busy: Vec<(f64, f64)> = route
        .windows(2)
        .filter(|pair| !pair[1].cruise)
        .map(|pair| (pair[0].time, pair[1].time))
        .collect();
    let fine = section.allowance.roundings(&section.reference, |s| {
        let k = route
            .partition_point(|point| point.progress < s)
            .clamp(1, route.len() - 1);
        let (before, behind) = (&route[k - 1], &route[k]);
        let part = ((s - before.progress) / (behind.progress - before.progress)).clamp(0.0, 1.0);
        let time = before.time + (behind.time - before.time) * part;
        if time.is_finite() { time } else { behind.time }
    });
    let pieces = section.reference.pieces.len();
    continued_grid(
        running_knots,
        whole,
        &Density {
            busy,
            fine,
            pieces,
            spacing: section.allowance.spacing(),
        },
    )
}

/// The knots of the running motion from one span before the splice until the warm start leaves it, with long spans divided.
/// On these knots the followed curve is a spline, so it keeps its limits to the last bit.
pub(crate) fn knots(section: &Section<'_>, running: Running<'_>) -> Vec<f64> {
    let most_span = TUNING.warm_start.most_span_nodes * section.allowance.spacing().node_s;
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
        // Knots this close to each other would coincide.
        if span < TUNING.warm_start.least_span_s && time < running.leave {
            continue;
        }
        let parts = (span / most_span).ceil().max(1.0);
        times.extend((1..=parts as usize).map(|k| from + span * k as f64 / parts));
    }
    while times.len() < GIVEN + 2 {
        let last = times[times.len() - 1];
        times.push(last + section.allowance.spacing().node_s);
    }
    times.insert(0, -times[1]);
    times
}

/// The running motion from the splice until the warm start leaves it.
pub(crate) fn followed(section: &Section<'_>, running: Running<'_>) -> Vec<RoutePoint> {
    let reference = &section.reference;
    let left = running.leave - running.splice;
    let count = (left / TUNING.warm_start.step_s).ceil().max(1.0) as usize;
    let (mut piece, mut least) = (running.piece, 0.0);
    (0..=count)
        .map(|k| {
            let time = left * k as f64 / count as f64;
            let state = running.trajectory.at(running.splice + time);
            piece = reference.foot(&state.position, piece).1;
            least = f64::max(
                least,
                reference.starts[piece] + along(&reference.pieces[piece], &state.position),
            );
            RoutePoint {
                time,
                point: state.position,
                progress: least,
                speed: state.velocity.norm(),
                cruise: state.acceleration == Point::zeros(),
            }
        })
        .collect()
}

/// Continues from a state near the reference path at arc length `at` along the rounded reference path to its end.
fn go_on(section: &Section<'_>, route: &mut Vec<RoutePoint>, from: &AxesState, start: f64, at: f64) {
    let reference = &section.reference;
    let (free, stretches) = section.without_jerk();
    let mut samples = sample(reference, &stretches);
    let behind = samples.partition_point(|s| s.progress <= at + TUNING.warm_start.least_step_units);
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
    // The first point has the progress of the motion; its offset from the rounded path fades out.
    ahead[0].progress = at;
    let speed = from.velocity.norm();
    let fade = (speed * TUNING.warm_start.fade_s).max(TUNING.warm_start.least_fade_units);
    let offset = from.position - base;
    for (k, one) in ahead.iter_mut().enumerate() {
        let u = ((one.progress - at) / fade).clamp(0.0, 1.0);
        if k == 0 {
            one.point = from.position;
        } else {
            one.point += offset * (1.0 - u * u * (3.0 - 2.0 * u));
        }
    }
    let mut profile = speeds(reference, &ahead, &free, Smoothness::Trapezoid, speed * speed);
    if section.smoothness == Smoothness::SCurve && section.quality == Quality::Smooth && speed > 0.0 {
        let along = from.velocity.dot(&from.acceleration) / speed;
        profile.go_gently(along, &section.bounds[reference.piece_at(at)]);
    }
    for k in 1..ahead.len() {
        route.push(RoutePoint {
            time: start + profile.times[k],
            point: ahead[k].point,
            progress: ahead[k].progress,
            speed: profile.square[k].sqrt(),
            cruise: profile.is_cruise(k - 1) && ahead[k].progress > at + fade,
        });
    }
}
