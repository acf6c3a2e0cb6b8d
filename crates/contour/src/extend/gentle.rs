//! A continuation that is within all limits from the first guess on: the running motion until it is left, then the programmed path with every corner
//! rounded evenly, at a constant speed so low that nothing there comes near to a limit. Position units and seconds.
//!
//! The offset from the rounded path at the instant at which the running motion is left fades out in position, velocity and acceleration.

use crate::extend::warm_start::{Running, followed, knots};
use crate::path::reference::along;
use crate::path::rounding::{Corners, Shape, Stretch, round};
use crate::section::Section;
use crate::timing::control_points::{ControlPoints, blossom};
use crate::tuning::TUNING;
use crate::{Point, State};
use arcline_profile::{Jerk, KinematicState, Limits, Profile, entry_speed, exit_speed};

/// Control points of a motion that follows the running one until it is left and then the course, with shares of what is possible there (of the limits along the
/// path, and of the speed). `None`: it is too fast for what comes.
pub(crate) fn gentle(course: &Course<'_>, running: Running<'_>, shares: [f64; 2]) -> Option<ControlPoints> {
    let section = course.section;
    let reference = &section.reference;
    let left = running.leave - running.splice;
    let from = running.trajectory.at(running.leave);
    let route = followed(section, running);
    let length = reference.length();
    let way = course.way(running, &course.ends(shares), shares)?;
    let (fade, _) = Fade::new(course, &from, &way.0.first()?.1);
    let mut grid = knots(section, running);
    let followed = grid.len();
    grid.extend(marched(&course.steps(&way, &fade)).into_iter().map(|time| left + time));
    // The last span is left out: there the motion comes to rest.
    let whole = grid.pop()?;
    let mut control = ControlPoints::continuing(running.trajectory.at(running.splice), &grid, followed);
    let mut i = 0;
    for k in 0..grid.len() {
        let before = grid[k.max(1)] - grid[k.max(1) - 1];
        let behind = grid.get(k + 1).map_or(whole, |&next| next) - grid[k];
        let (state, progress) = if k < followed {
            while i + 2 < route.len() && route[i + 1].time < grid[k] {
                i += 1;
            }
            (running.trajectory.at(running.splice + grid[k]), route[i].progress)
        } else {
            let along = way.at(grid[k] - left);
            let moving = course.moving(&along);
            (fade.added_to(&moving, grid[k] - left), along.position)
        };
        control.points.push(blossom(&state, [-before, 0.0, behind]));
        control.progress.push(progress.min(length));
    }
    Some(control.completed(reference))
}

/// The reference path with every corner rounded, by its progress.
pub(crate) struct Course<'a> {
    section: &'a Section<'a>,
    stretches: Vec<Stretch>,
    /// For each stretch the constant speed at which it is within all limits.
    speeds: Vec<f64>,
}

/// How a motion goes on along a course: one profile for each stretch, with the instant at which it begins. The acceleration along the path is 0 between them.
struct Way(Vec<(f64, Profile)>);

impl Way {
    fn at(&self, time: f64) -> KinematicState {
        let part = self.0.partition_point(|(from, _)| *from <= time).saturating_sub(1);
        let (from, profile) = &self.0[part];
        profile.at(time - from)
    }

    /// When each profile ends.
    fn ends(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|(from, profile)| from + profile.duration())
    }
}

impl<'a> Course<'a> {
    pub(crate) fn new(section: &'a Section<'a>) -> Self {
        let stretches = round(&section.reference, &section.allowance, Corners::Even);
        let mut speeds: Vec<f64> = stretches.iter().map(|stretch| most_speed(section, stretch)).collect();
        let pairs = stretches.windows(2).enumerate();
        for (k, pair) in pairs {
            let [_, end, _] = pair[0].derivatives(&section.reference, pair[0].to);
            let [_, start, _] = pair[1].derivatives(&section.reference, pair[1].from);
            if (end - start).norm() > SHARP {
                speeds[k + 1] = 0.0;
            }
        }
        Course {
            section,
            stretches,
            speeds,
        }
    }

    /// With which speed each stretch is entered, and at rest after the last.
    pub(crate) fn ends(&self, shares: [f64; 2]) -> Vec<f64> {
        let count = self.stretches.len();
        let mut ends = vec![0.0; count + 1];
        for k in (0..count).rev() {
            let limits = self.limits(k, shares);
            let before = self.speeds[k.saturating_sub(1)].min(self.speeds[k]);
            let stretch = &self.stretches[k];
            ends[k] = entry_speed(stretch.to - stretch.from, ends[k + 1], &limits).min(shares[1] * before);
        }
        ends
    }

    /// Whether a motion that is left goes on gently; `ends` as [`Course::ends`]. The share of what is allowed that its offset needs to fade out.
    pub(crate) fn goes_on(&self, running: Running<'_>, ends: &[f64], shares: [f64; 2]) -> Option<f64> {
        let (_, profile) = self.first(running, ends, shares)?;
        let from = running.trajectory.at(running.leave);
        Some(Fade::new(self, &from, &profile).1)
    }

    /// How a motion that is left comes to the course at its speed: the stretch at whose end it has done so, and the profile until there. `None`: it is too fast for
    /// what comes.
    fn first(&self, running: Running<'_>, ends: &[f64], shares: [f64; 2]) -> Option<(usize, Profile)> {
        let from = running.trajectory.at(running.leave);
        let at = followed(self.section, running).last()?.progress;
        let state = self.state(&from, at);
        let first = self.place(state.position);
        if state.velocity <= 0.0 {
            return None;
        }
        let behind = [0, 1, 2, 4, 8, 16, 32, 64, 128].map(|more| first + more);
        behind
            .into_iter()
            .take_while(|&last| last < self.stretches.len())
            .find_map(|last| {
                let target = self.stretches[last].to;
                let mut limits = self.limits_of(first, shares[0], shares[1]);
                for k in first + 1..=last {
                    limits.speed = limits.speed.min(shares[1] * self.speeds[k]);
                }
                if ends[last + 1] <= 0.0 && last + 1 < self.stretches.len() {
                    return None;
                }
                let most = exit_speed(state, target - state.position, &limits);
                let profile = Profile::to_position(state, target, ends[last + 1].min(most), &limits);
                let end = profile.end();
                let is_met = end.velocity <= ends[last + 1] * (1.0 + ROUNDING) + ROUNDING
                    && end.acceleration.abs() <= ROUNDING * limits.acceleration;
                let is_forward = |&t: &f64| profile.at(t).velocity >= 0.0;
                let within = |k: usize| {
                    let time = profile.time_at_position(self.stretches[k].from);
                    time.is_some_and(|time| profile.at(time).velocity <= TUNING.gentle.entry_share * self.speeds[k])
                };
                let is_within =
                    is_met && profile.segment_times().iter().all(is_forward) && (first + 1..=last).all(within);
                is_within.then_some((last, profile))
            })
    }

    fn way(&self, running: Running<'_>, ends: &[f64], shares: [f64; 2]) -> Option<Way> {
        let (last, profile) = self.first(running, ends, shares)?;
        let (mut time, mut state) = (profile.duration(), profile.end());
        let mut parts = vec![(0.0, profile)];
        for k in last + 1..self.stretches.len() {
            let (target, limits) = (self.stretches[k].to, self.limits(k, shares));
            let from = KinematicState {
                acceleration: 0.0,
                ..state
            };
            let most = exit_speed(from, target - from.position, &limits);
            let profile = Profile::to_position(from, target, ends[k + 1].min(most), &limits);
            parts.push((time, profile));
            time += profile.duration();
            state = profile.end();
        }
        (state.velocity == 0.0 && time.is_finite()).then_some(Way(parts))
    }

    /// Which stretch is at a progress.
    fn place(&self, progress: f64) -> usize {
        let place = self.stretches.partition_point(|stretch| stretch.to < progress);
        place.min(self.stretches.len() - 1)
    }

    fn at(&self, progress: f64) -> [Point; 3] {
        self.stretches[self.place(progress)].derivatives(&self.section.reference, progress)
    }

    /// The progress of a motion near the path, with its first two derivatives by time.
    fn state(&self, from: &State, at: f64) -> KinematicState {
        let reference = &self.section.reference;
        let (_, piece) = reference.foot(&from.position, reference.piece_at(at));
        let position = reference.starts[piece] + along(&reference.pieces[piece], &from.position);
        let [_, tangent, curvature] = self.at(position);
        let square = tangent.norm_squared();
        let velocity = from.velocity.dot(&tangent) / square;
        let acceleration = (from.acceleration - curvature * (velocity * velocity)).dot(&tangent) / square;
        KinematicState {
            position,
            velocity,
            acceleration,
        }
    }

    /// The motion on the path.
    fn moving(&self, along: &KinematicState) -> State {
        let [position, tangent, curvature] = self.at(along.position);
        State {
            position,
            velocity: tangent * along.velocity,
            acceleration: curvature * (along.velocity * along.velocity) + tangent * along.acceleration,
        }
    }

    /// Limits along a stretch.
    fn limits(&self, place: usize, [rates, speed]: [f64; 2]) -> Limits {
        let stretch = &self.stretches[place];
        let is_straight = matches!(stretch.shape, Shape::Piece(_)) && !stretch.is_arc(&self.section.reference);
        let share = if is_straight {
            rates
        } else {
            rates.min(TUNING.gentle.turning_share)
        };
        self.limits_of(place, share, speed)
    }

    /// Shares of the limits along a stretch.
    fn limits_of(&self, place: usize, share: f64, speed: f64) -> Limits {
        let stretch = &self.stretches[place];
        let reference = &self.section.reference;
        let bound = &self.section.bounds[reference.piece_at(0.5 * (stretch.from + stretch.to))];
        let rate = share * bound.axes.acceleration.min();
        let (acceleration, deceleration) = (
            rate.min(share * bound.acceleration),
            rate.min(share * bound.deceleration),
        );
        // A step of the acceleration is more than it is on a curve of nodes.
        let jerk = (share * bound.least_jerk()).min(acceleration.min(deceleration) / TUNING.gentle.step_s);
        Limits {
            speed: speed * self.speeds[place],
            acceleration,
            deceleration,
            jerk: Some(Jerk {
                acceleration: jerk,
                deceleration: jerk,
            }),
        }
    }

    /// Where the nodes of a motion along the course are.
    fn steps(&self, way: &Way, fade: &Fade) -> Vec<Span> {
        let node_s = self.section.allowance.node_s();
        let step = |stretch: &Stretch, lasts: f64| match stretch.shape {
            Shape::Bezier(..) => node_s.min(lasts / self.rounding_nodes(stretch)),
            Shape::Piece(_) => node_s,
        };
        // The first profile may pass several stretches.
        let (_, profile) = &way.0[0];
        let behind = self.stretches.len() + 1 - way.0.len();
        let passed = &self.stretches[self.place(profile.at(0.0).position)..behind];
        let mut spans: Vec<Span> = Vec::new();
        let mut from = 0.0;
        let ends = passed.iter().enumerate().map(|(k, stretch)| {
            let is_last = k + 1 == passed.len();
            let passes = profile.time_at_position(stretch.to).filter(|_| !is_last);
            (stretch, passes.unwrap_or(profile.duration()))
        });
        for (stretch, end) in ends.chain(self.stretches[behind..].iter().zip(way.ends().skip(1))) {
            if end > from {
                let step = step(stretch, end - from);
                spans.push(Span { end, step, knot: false });
                from = end;
            }
        }
        let cuts = profile.segment_times().iter().copied().chain([fade.duration]);
        for cut in cuts.filter(|&cut| cut > 0.0 && cut < profile.duration()) {
            let k = spans.partition_point(|span| span.end <= cut);
            let step = spans[k].step;
            let part = Span {
                end: cut,
                step,
                knot: true,
            };
            spans.insert(k, part);
        }
        spans
    }

    fn rounding_nodes(&self, stretch: &Stretch) -> f64 {
        let reference = &self.section.reference;
        let piece = reference.piece_at(0.5 * (stretch.from + stretch.to));
        let is_kept = self.section.allowance.keeps_at(reference, piece, stretch.from);
        TUNING.gentle.rounding_nodes[usize::from(is_kept)]
    }
}

/// A stretch of time: its end, seconds from node to node, and whether there is a knot at its end, as the motion changes there.
struct Span {
    end: f64,
    step: f64,
    knot: bool,
}

/// Instants of nodes behind 0, no farther apart than the steps and without sudden changes, until the end of the last of the stretches.
fn marched(spans: &[Span]) -> Vec<f64> {
    let whole = spans.last().map_or(0.0, |last| last.end);
    let growth = TUNING.grid.spread;
    let begin = |k: usize| if k > 0 { spans[k - 1].end } else { 0.0 };
    // What is possible at the start of each stretch beside what lies before, and at its end beside what lies behind.
    let mut before = vec![f64::INFINITY; spans.len()];
    let mut behind = vec![f64::INFINITY; spans.len()];
    for k in 1..spans.len() {
        let Span { end, step, .. } = spans[k - 1];
        before[k] = step.min(before[k - 1] + growth * (end - begin(k - 1)));
    }
    for k in (1..spans.len()).rev() {
        let Span { end, step, .. } = spans[k];
        behind[k - 1] = step.min(behind[k] + growth * (end - begin(k)));
    }
    let (mut times, mut t, mut k) = (Vec::new(), 0.0, 0);
    // The node from which on they are not at their places, and its time.
    let (mut fitted, mut since) = (0, 0.0);
    while t < whole {
        let Span { end, step, .. } = spans[k];
        let step = step
            .min(before[k] + growth * (t - begin(k)))
            .min(behind[k] + growth * (end - t).max(0.0));
        let step = step.max(TUNING.grid.finest_s);
        t += step;
        times.push(t);
        while k < spans.len() && spans[k].end <= t {
            let span = &spans[k];
            let is_end = k + 1 == spans.len();
            if is_end || span.knot && span.end - since > step {
                let scale = (span.end - since) / (t - since);
                for time in &mut times[fitted..] {
                    *time = since + (*time - since) * scale;
                }
                (fitted, since, t) = (times.len(), span.end, span.end);
            }
            k += 1;
        }
        if k == spans.len() {
            break;
        }
    }
    times
}

/// The constant speed at which a stretch is within all limits.
fn most_speed(section: &Section<'_>, stretch: &Stretch) -> f64 {
    let reference = &section.reference;
    let bound = &section.bounds[reference.piece_at(0.5 * (stretch.from + stretch.to))];
    let count = if matches!(stretch.shape, Shape::Bezier(..)) {
        MEASURED
    } else {
        1
    };
    let step = (stretch.to - stretch.from) / f64::from(count);
    let mut before: Option<Point> = None;
    let mut most = f64::INFINITY;
    for k in 0..=count {
        let [_, tangent, curvature] = stretch.derivatives(reference, stretch.from + step * f64::from(k));
        let change = before.map_or(Point::zeros(), |before| (curvature - before) / step);
        most = most.min(bound.speed / tangent.norm());
        most = most.min(libm::sqrt(bound.norm_acceleration() / curvature.norm()));
        most = most.min(libm::cbrt(bound.jerk / change.norm()));
        for axis in 0..3 {
            most = most.min(bound.axes.speed[axis] / tangent[axis].abs());
            most = most.min(libm::sqrt(bound.axes.acceleration[axis] / curvature[axis].abs()));
            let jerk = bound.axes.jerk.map_or(f64::INFINITY, |axes| axes[axis]);
            most = most.min(libm::cbrt(jerk / change[axis].abs()));
        }
        before = Some(curvature);
    }
    most
}

/// An offset that fades out: the polynomial of degree 5 from its state to 0.
struct Fade {
    duration: f64,
    /// Coefficients by the share of the duration.
    parts: [Point; 6],
}

impl Fade {
    /// From the state of a motion to the course, travelled by a profile: within the shortest time that leaves most of the limits to other things and stays inside
    /// the tolerance, else the time that comes nearest to both. With the share of what is allowed that it needs.
    fn new(course: &Course<'_>, from: &State, profile: &Profile) -> (Fade, f64) {
        let to = course.moving(&profile.at(0.0));
        let offset = [
            from.position - to.position,
            from.velocity - to.velocity,
            from.acceleration - to.acceleration,
        ];
        let bound = &course.section.bounds[0];
        let rate = TUNING.gentle.fade_share * bound.axes.acceleration.min().min(bound.norm_acceleration());
        let jerk = TUNING.gentle.fade_share * bound.least_jerk();
        let [mut duration, most] = TUNING.gentle.fade_s;
        let mut best: Option<(Fade, f64)> = None;
        while duration <= most {
            let fade = Fade::within(duration, offset);
            let (acceleration, most_jerk) = fade.peaks();
            let used = (acceleration / rate)
                .max(most_jerk / jerk)
                .max(fade.off(course, profile));
            let is_inside = used <= 1.0;
            if best.as_ref().is_none_or(|(_, least)| used < *least) {
                best = Some((fade, used));
            }
            if is_inside {
                break;
            }
            duration *= TUNING.gentle.fade_factor;
        }
        best.unwrap_or((Fade::within(duration, offset), f64::INFINITY))
    }

    /// The largest share of the tolerance that is used until it has faded out.
    fn off(&self, course: &Course<'_>, profile: &Profile) -> f64 {
        let Section {
            reference, allowance, ..
        } = course.section;
        let used = |k: u32| {
            let u = f64::from(k) / f64::from(MEASURED);
            let along = profile.at(u * self.duration);
            let place = course.moving(&along).position + self.at(u)[0];
            let progress = along.position.min(reference.length());
            allowance.used(reference, &place, reference.piece_at(progress), progress)
        };
        (0..=MEASURED).map(used).fold(0.0, f64::max)
    }

    fn within(duration: f64, [p, v, a]: [Point; 3]) -> Fade {
        let (v, a) = (v * duration, a * (duration * duration));
        Fade {
            duration,
            parts: [
                p,
                v,
                a * 0.5,
                p * -10.0 - v * 6.0 - a * 1.5,
                p * 15.0 + v * 8.0 + a * 1.5,
                p * -6.0 - v * 3.0 - a * 0.5,
            ],
        }
    }

    /// Position, velocity, acceleration and jerk at a share of the duration.
    fn at(&self, u: f64) -> [Point; 4] {
        let c = &self.parts;
        let t = self.duration;
        [
            c[0] + (c[1] + (c[2] + (c[3] + (c[4] + c[5] * u) * u) * u) * u) * u,
            (c[1] + (c[2] * 2.0 + (c[3] * 3.0 + (c[4] * 4.0 + c[5] * 5.0 * u) * u) * u) * u) / t,
            (c[2] * 2.0 + (c[3] * 6.0 + (c[4] * 12.0 + c[5] * 20.0 * u) * u) * u) / (t * t),
            (c[3] * 6.0 + (c[4] * 24.0 + c[5] * 60.0 * u) * u) / (t * t * t),
        ]
    }

    /// Largest acceleration and jerk.
    fn peaks(&self) -> (f64, f64) {
        (0..=MEASURED).fold((0.0, 0.0), |(acceleration, jerk): (f64, f64), k| {
            let [_, _, a, j] = self.at(f64::from(k) / f64::from(MEASURED));
            (acceleration.max(a.norm()), jerk.max(j.norm()))
        })
    }

    fn added_to(&self, moving: &State, time: f64) -> State {
        if time >= self.duration {
            return *moving;
        }
        let [p, v, a, _] = self.at(time / self.duration);
        State {
            position: moving.position + p,
            velocity: moving.velocity + v,
            acceleration: moving.acceleration + a,
        }
    }
}

/// Points of a rounding, and of a fading offset, that are measured.
const MEASURED: u32 = 16;
/// Tangents that differ by more are a corner.
const SHARP: f64 = 1e-3;
/// Share of a speed or rate that is rounding.
const ROUNDING: f64 = 1e-9;
