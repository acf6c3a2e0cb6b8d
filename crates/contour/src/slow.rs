//! A start that keeps the limits: the running motion is followed while it brakes, and the rest of the course is travelled
//! so slowly that nothing is exceeded. Position units and seconds.

use crate::Point;
use crate::guess::{Running, Site, followed, knots};
use crate::nodes::{Nodes, blossom};
use crate::section::Section;

/// The nodes with the running motion in place of those before the instant at which it is as slow as the others are
/// when they take `factor` times as long.
pub(crate) fn slowed(section: &Section<'_>, running: Running<'_>, nodes: &Nodes, factor: f64) -> Nodes {
    let course = &section.course;
    let end = running.trajectory.duration();
    let sites = followed(section, Running { leave: end, ..running });
    let mut k = 0;
    // The speed of the nodes at a progress.
    let mut speed = |progress: f64| {
        while k + 2 < nodes.points.len() && nodes.progress[k + 1] <= progress {
            k += 1;
        }
        let spans = &nodes.spans;
        let around = spans[k.max(1) - 1] + spans[k] + spans[(k + 1).min(spans.len() - 1)];
        (nodes.points[k + 1] - nodes.points[k]).norm() * 3.0 / around
    };
    let follow = (running.leave - running.splice).min(end - running.splice - LEAST_LEFT);
    let leave = sites
        .iter()
        .find(|site| site.time >= follow && site.speed * factor <= speed(site.progress))
        .map_or(end - running.splice - LEAST_LEFT, |site| site.time)
        .min(end - running.splice - LEAST_LEFT)
        .max(follow);
    let Site {
        point: from, progress: at, ..
    } = sites
        .into_iter()
        .take_while(|site| site.time <= leave + 1e-9)
        .last()
        .unwrap_or(Site::none());
    let grid = knots(Running {
        leave: running.splice + leave,
        ..running
    });
    let first = nodes.progress.partition_point(|&progress| progress <= at).max(1);
    // The nodes behind: their offset from where the running motion is fades out.
    let (here, next) = (nodes.progress[first - 1], nodes.progress[first.min(nodes.progress.len() - 1)]);
    let part = if next > here { (at - here) / (next - here) } else { 0.0 };
    let before = nodes.points[first - 1];
    let base = before + (nodes.points[first.min(nodes.points.len() - 1)] - before) * part;
    let offset: Point = from - base;
    let span = nodes.spans[(first - 1).min(nodes.spans.len() - 1)];
    let mut times = grid.clone();
    let mut time = grid[grid.len() - 1] + span * factor * (1.0 - part);
    let fade = FADE * factor;
    let mut points = Vec::new();
    let mut progress = Vec::new();
    for k in first..nodes.points.len() {
        let u = ((time - leave) / fade).min(1.0);
        times.push(time);
        points.push(nodes.points[k] + offset * (1.0 - u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)));
        progress.push(nodes.progress[k]);
        time += nodes.spans.get(k).copied().unwrap_or_default() * factor;
    }
    let mut fresh = Nodes {
        points: Vec::with_capacity(times.len()),
        progress: Vec::with_capacity(times.len()),
        spans: times.windows(2).map(|pair| pair[1] - pair[0]).collect(),
        ..nodes.clone()
    };
    let sites = followed(
        section,
        Running {
            leave: running.splice + leave,
            ..running
        },
    );
    let mut i = 0;
    for (k, &time) in grid.iter().enumerate() {
        let before = times[k.max(1)] - times[k.max(1) - 1];
        let behind = times.get(k + 1).map_or(before, |next| next - time);
        let state = running.trajectory.at(running.splice + time);
        fresh.points.push(blossom(&state, [-before, 0.0, behind]));
        while i + 1 < sites.len() && sites[i].time < time {
            i += 1;
        }
        fresh.progress.push(sites[i].progress);
    }
    fresh.points.extend(points);
    fresh.progress.extend(progress);
    let last = fresh.points.len() - 1;
    fresh.points[last] = course.pieces[course.pieces.len() - 1].end();
    fresh.progress[last] = course.length();
    fresh.set_lead();
    fresh
}

/// Seconds that are left of the running motion at least.
const LEAST_LEFT: f64 = 0.003;
/// Seconds, times the factor, in which the offset between both fades out.
const FADE: f64 = 0.015;
