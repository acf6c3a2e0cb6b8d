//! A start that keeps the limits: the running motion is followed while it brakes, and the rest of the course is travelled
//! so slowly that nothing is exceeded; one fades into the other where both are as slow. Position units and seconds.

use crate::guess::{Running, Site, followed, knots};
use crate::nodes::{Nodes, blossom};
use crate::nominal::NODE_TIME;
use crate::section::Section;
use crate::{State, Trajectory};

/// The motion of `nodes`, `factor` times as long, with the running motion in place of its beginning.
pub(crate) fn slowed(section: &Section<'_>, running: Running<'_>, nodes: &Nodes, factor: f64) -> Nodes {
    let course = &section.course;
    let end = running.trajectory.duration() - running.splice;
    let sites = followed(
        section,
        Running {
            leave: running.splice + end,
            ..running
        },
    );
    let slow = Slow::new(nodes, factor);
    let follow = (running.leave - running.splice).min(end);
    let joint = sites
        .iter()
        .find(|site| site.time >= follow && site.speed <= slow.speed_at(site.progress))
        .or(sites.last());
    let Some(&Site {
        time: middle,
        progress: at,
        ..
    }) = joint
    else {
        return nodes.clone();
    };
    let half = (FADE * factor).min(0.8 * (middle - LEAST_FOLLOWED)).max(NODE_TIME);
    let shift = slow.time_of(at) - middle;
    let (from, until) = (middle - half, middle + half);
    let mut times = knots(Running {
        leave: running.splice + from,
        ..running
    });
    let followed_knots = times.len();
    let steps = (2.0 * half / NODE_TIME).ceil();
    let start = times[followed_knots - 1];
    times.extend((1..=steps as usize).map(|k| start + (until - start) * k as f64 / steps));
    let faded = times.len();
    let first = slow.times.partition_point(|&time| time - shift <= until + 0.5 * NODE_TIME);
    times.extend(slow.times[first..].iter().map(|&time| time - shift));
    let mut fresh = Nodes {
        points: Vec::with_capacity(times.len()),
        progress: Vec::with_capacity(times.len()),
        spans: times.windows(2).map(|pair| pair[1] - pair[0]).collect(),
        ..nodes.clone()
    };
    let (mut i, mut least) = (0, 0.0);
    for k in 0..faded {
        let time = times[k];
        let before = times[k.max(1)] - times[k.max(1) - 1];
        let behind = times.get(k + 1).map_or(before, |next| next - time);
        while i + 1 < sites.len() && sites[i].time < time {
            i += 1;
        }
        let run = running.trajectory.at(running.splice + time);
        let (state, progress) = if k < followed_knots {
            (run, sites[i].progress)
        } else {
            let u = ((time - from) / (2.0 * half)).clamp(0.0, 1.0);
            let (next, ahead) = slow.at(time + shift);
            (
                faded_state(&run, &next, u, 2.0 * half),
                sites[i].progress + (ahead - sites[i].progress) * u,
            )
        };
        least = f64::max(least, progress);
        fresh.points.push(blossom(&state, [-before, 0.0, behind]));
        fresh.progress.push(least);
    }
    fresh.points.extend_from_slice(&nodes.points[first..]);
    fresh.progress.extend(nodes.progress[first..].iter().map(|p| p.max(least)));
    let last = fresh.points.len() - 1;
    fresh.points[last] = course.pieces[course.pieces.len() - 1].end();
    fresh.progress[last] = course.length();
    fresh.set_lead();
    fresh
}

/// A motion that takes longer.
struct Slow<'a> {
    nodes: &'a Nodes,
    motion: Trajectory,
    factor: f64,
    /// Of the nodes.
    times: Vec<f64>,
}

impl<'a> Slow<'a> {
    fn new(nodes: &'a Nodes, factor: f64) -> Self {
        let motion = nodes.spline(&nodes.spans);
        let times = nodes.times(&motion).into_iter().map(|time| time * factor).collect();
        Slow {
            nodes,
            motion,
            factor,
            times,
        }
    }

    /// When a progress is reached.
    fn time_of(&self, progress: f64) -> f64 {
        let all = &self.nodes.progress;
        let k = all.partition_point(|&p| p < progress).clamp(1, all.len() - 1);
        let (p0, p1) = (all[k - 1], all[k]);
        let part = if p1 > p0 { ((progress - p0) / (p1 - p0)).clamp(0.0, 1.0) } else { 1.0 };
        self.times[k - 1] + (self.times[k] - self.times[k - 1]) * part
    }

    fn speed_at(&self, progress: f64) -> f64 {
        self.at(self.time_of(progress)).0.velocity.norm()
    }

    /// The state and the progress at an instant.
    fn at(&self, time: f64) -> (State, f64) {
        let state = self.motion.at((time / self.factor).max(0.0));
        let k = self.times.partition_point(|&t| t <= time).clamp(1, self.times.len() - 1);
        let (t0, t1) = (self.times[k - 1], self.times[k]);
        let part = ((time - t0) / (t1 - t0)).clamp(0.0, 1.0);
        let all = &self.nodes.progress;
        (
            State {
                position: state.position,
                velocity: state.velocity / self.factor,
                acceleration: state.acceleration / (self.factor * self.factor),
            },
            all[k - 1] + (all[k] - all[k - 1]) * part,
        )
    }
}

/// One motion fading into another one within `span` seconds, at a part `u` of it.
fn faded_state(from: &State, to: &State, u: f64, span: f64) -> State {
    let weight = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
    let rate = 30.0 * u * u * (1.0 - u) * (1.0 - u) / span;
    let change = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (span * span);
    let position = to.position - from.position;
    let velocity = to.velocity - from.velocity;
    let acceleration = to.acceleration - from.acceleration;
    State {
        position: from.position + position * weight,
        velocity: from.velocity + velocity * weight + position * rate,
        acceleration: from.acceleration + acceleration * weight + velocity * (2.0 * rate) + position * change,
    }
}

/// Seconds of the running motion that are followed at least.
const LEAST_FOLLOWED: f64 = 0.003;
/// Seconds, times the factor, before and behind the joint in which one motion fades into the other.
const FADE: f64 = 0.012;
