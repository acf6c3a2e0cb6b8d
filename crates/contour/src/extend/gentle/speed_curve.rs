//! The curve of a gentle continuation, and its speeds. Position units and seconds.

use crate::extend::gentle::fade::Fade;
use crate::extend::gentle::smoothed::Smoothed;
use crate::limits::MoveLimits;
use crate::path::reference::along;
use crate::path::rounding::{Corners, Stretch, StretchShape, round};
use crate::section::Section;
use crate::tolerance::RATE_SHARE;
use crate::tuning::TUNING;
use crate::{AxesState, Point};
use arcline_profile::{Jerk, KinematicState, Limits, Profile, entry_speed, exit_speed};

/// A curve with the speeds that it permits.
pub(crate) struct SpeedCurve<'a> {
    pub(super) section: &'a Section<'a>,
    curve: Curve,
    pub(super) parts: Vec<SpeedCurvePart>,
}

/// The curve by its progress.
enum Curve {
    /// The reference path with every corner rounded.
    Rounded(Vec<Stretch>),
    /// A smooth curve through dense chords.
    Smooth(Box<Smoothed>),
}

/// A part of a speed curve.
pub(super) struct SpeedCurvePart {
    pub(super) from: f64,
    pub(super) to: f64,
    /// The constant speed at which it is within all limits.
    pub(super) speed: f64,
    /// The part belongs to a line.
    is_straight: bool,
    /// The least number of its nodes.
    nodes: f64,
    /// The piece of the reference path to which it belongs.
    piece: usize,
}

/// The timing along a speed curve: one profile for each stretch, with the instant at which it begins. Between them, the acceleration along
/// the path is 0.
pub(super) struct SpeedCurveTiming {
    /// The part that it begins on.
    first: usize,
    parts: Vec<(f64, Profile)>,
}

impl SpeedCurveTiming {
    pub(super) fn at(&self, time: f64) -> KinematicState {
        let part = self.parts.partition_point(|(from, _)| *from <= time).saturating_sub(1);
        let (from, profile) = &self.parts[part];
        profile.at(time - from)
    }

    /// The part that it begins on, and the profile from there.
    pub(super) fn first(&self) -> (usize, &Profile) {
        (self.first, &self.parts[0].1)
    }

    /// The number of profiles.
    pub(super) fn count(&self) -> usize {
        self.parts.len()
    }

    /// The instants at which the profiles end.
    pub(super) fn ends(&self) -> impl Iterator<Item = f64> + '_ {
        self.parts.iter().map(|(from, profile)| from + profile.duration())
    }
}

impl<'a> SpeedCurve<'a> {
    pub(crate) fn new(section: &'a Section<'a>) -> Self {
        let reference = &section.reference;
        let stretches = round(reference, &section.allowance, Corners::Even);
        let mut parts: Vec<SpeedCurvePart> = stretches
            .iter()
            .map(|stretch| {
                let piece = reference.piece_at(0.5 * (stretch.from + stretch.to));
                let keeps_close = section.allowance.keeps_close_at(reference, piece, stretch.from);
                let is_rounding = matches!(stretch.shape, StretchShape::Bezier(..));
                let measured = if is_rounding { TUNING.gentle.rounding_samples } else { 1 };
                let step = (stretch.to - stretch.from) / f64::from(measured);
                let sites = (0..=measured).map(|k| stretch.derivatives(reference, stretch.from + step * f64::from(k)));
                SpeedCurvePart {
                    from: stretch.from,
                    to: stretch.to,
                    speed: most_speed(&section.bounds[piece], sites, step),
                    is_straight: !is_rounding && !stretch.is_arc(reference),
                    nodes: if is_rounding {
                        TUNING.gentle.rounding_nodes[usize::from(keeps_close)]
                    } else {
                        0.0
                    },
                    piece,
                }
            })
            .collect();
        let pairs = stretches.windows(2).enumerate();
        for (k, pair) in pairs {
            let [_, end, _] = pair[0].derivatives(reference, pair[0].to);
            let [_, start, _] = pair[1].derivatives(reference, pair[1].from);
            if (end - start).norm() > TUNING.gentle.corner {
                parts[k + 1].speed = 0.0;
            }
        }
        SpeedCurve {
            section,
            curve: Curve::Rounded(stretches),
            parts,
        }
    }

    /// A smooth curve, in parts with little change of its speed.
    pub(super) fn smooth(section: &'a Section<'a>, curve: Smoothed) -> Self {
        let reference = &section.reference;
        let sites = curve.sites();
        let mut parts: Vec<SpeedCurvePart> = Vec::new();
        for pair in sites.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let piece = reference.piece_at(curve.progress_at(0.5 * (from + to)));
            let derivatives = [curve.derivatives(from), curve.derivatives(to)];
            let speed = most_speed(&section.bounds[piece], derivatives.into_iter(), to - from);
            match parts.last_mut() {
                Some(part)
                    if (part.speed / speed).max(speed / part.speed) <= TUNING.gentle.alike
                        || part.nodes < TUNING.gentle.least_part =>
                {
                    part.to = to;
                    part.speed = part.speed.min(speed);
                    part.nodes += 1.0;
                }
                _ => parts.push(SpeedCurvePart {
                    from,
                    to,
                    speed,
                    is_straight: false,
                    nodes: 1.0,
                    piece,
                }),
            }
        }
        for part in &mut parts {
            part.nodes = 0.0;
        }
        SpeedCurve {
            section,
            curve: Curve::Smooth(Box::new(curve)),
            parts,
        }
    }

    pub(super) fn smoothed(&self) -> Option<&Smoothed> {
        match &self.curve {
            Curve::Smooth(curve) => Some(curve),
            Curve::Rounded(_) => None,
        }
    }

    /// Seconds between the nodes of a part of this duration.
    pub(super) fn step(&self, part: &SpeedCurvePart, lasts: f64) -> f64 {
        let node_s = self.section.allowance.spacing().node_s;
        if part.nodes > 0.0 {
            node_s.min(lasts / part.nodes)
        } else {
            node_s
        }
    }

    /// The speed at the start of each stretch, and the rest after the last.
    pub(crate) fn ends(&self, shares: [f64; 2]) -> Vec<f64> {
        let count = self.parts.len();
        let mut ends = vec![0.0; count + 1];
        for k in (0..count).rev() {
            let limits = self.limits(k, shares);
            let before = self.parts[k.saturating_sub(1)].speed.min(self.parts[k].speed);
            let part = &self.parts[k];
            ends[k] = entry_speed(part.to - part.from, ends[k + 1], &limits).min(shares[1] * before);
        }
        ends
    }

    /// The share of the allowed values that the offset of a gentle continuation needs to fade out; from a state of the running motion at a progress,
    /// `ends` as [`SpeedCurve::ends`]. `None` if there is no gentle continuation.
    pub(crate) fn goes_on(&self, from: &AxesState, progress: f64, ends: &[f64], shares: [f64; 2]) -> Option<f64> {
        let (_, profile) = self.first(self.state(from, progress), ends, shares)?;
        Some(Fade::new(self, from, &profile).1)
    }

    /// The transition from the running motion to the speed curve at its speed: the stretch at whose end it is complete, and the profile until
    /// there. `None`: the motion is too fast for the path ahead.
    fn first(&self, state: KinematicState, ends: &[f64], shares: [f64; 2]) -> Option<(usize, Profile)> {
        let first = self.part_at(state.position);
        if state.velocity < 0.0 {
            return None;
        }
        let behind = [0, 1, 2, 4, 8, 16, 32, 64, 128].map(|more| first + more);
        behind
            .into_iter()
            .take_while(|&last| last < self.parts.len())
            .find_map(|last| {
                let target = self.parts[last].to;
                let mut limits = self.limits_of(first, shares[0], shares[1]);
                for k in first + 1..=last {
                    limits.speed = limits.speed.min(shares[1] * self.parts[k].speed);
                }
                if ends[last + 1] <= 0.0 && last + 1 < self.parts.len() {
                    return None;
                }
                let most = exit_speed(state, target - state.position, &limits);
                let profile = Profile::to_position(state, target, ends[last + 1].min(most), &limits);
                let end = profile.end();
                let is_met = end.velocity <= ends[last + 1] * (1.0 + RATE_SHARE) + RATE_SHARE
                    && end.acceleration.abs() <= RATE_SHARE * limits.acceleration;
                let is_forward = |&t: &f64| profile.at(t).velocity >= 0.0;
                let within = |k: usize| {
                    let time = profile.time_at_position(self.parts[k].from);
                    time.is_some_and(|time| {
                        profile.at(time).velocity <= TUNING.gentle.entry_share * self.parts[k].speed
                    })
                };
                let is_within =
                    is_met && profile.segment_times().iter().all(is_forward) && (first + 1..=last).all(within);
                is_within.then_some((last, profile))
            })
    }

    /// The timing of a motion from its beginning on the speed curve to rest at its end; `ends` as [`SpeedCurve::ends`]. `None`: it is
    /// too fast for the path ahead.
    pub(super) fn timing(&self, begin: KinematicState, ends: &[f64], shares: [f64; 2]) -> Option<SpeedCurveTiming> {
        let first = self.part_at(begin.position);
        let (last, profile) = self.first(begin, ends, shares)?;
        let (mut time, mut state) = (profile.duration(), profile.end());
        let mut parts = vec![(0.0, profile)];
        for k in last + 1..self.parts.len() {
            let (target, limits) = (self.parts[k].to, self.limits(k, shares));
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
        (state.velocity == 0.0 && time.is_finite()).then_some(SpeedCurveTiming { first, parts })
    }

    /// The index of the part at a progress.
    fn part_at(&self, progress: f64) -> usize {
        let index = self.parts.partition_point(|part| part.to < progress);
        index.min(self.parts.len() - 1)
    }

    fn at(&self, progress: f64) -> [Point; 3] {
        match &self.curve {
            Curve::Rounded(stretches) => {
                stretches[self.part_at(progress)].derivatives(&self.section.reference, progress)
            }
            Curve::Smooth(curve) => curve.derivatives(progress),
        }
    }

    /// The progress of a motion near the path, with its first two derivatives by time.
    pub(super) fn state(&self, from: &AxesState, at: f64) -> KinematicState {
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

    /// The motion on the path at a state along it.
    pub(super) fn moving(&self, along: &KinematicState) -> AxesState {
        let [position, tangent, curvature] = self.at(along.position);
        AxesState {
            position,
            velocity: tangent * along.velocity,
            acceleration: curvature * (along.velocity * along.velocity) + tangent * along.acceleration,
        }
    }

    /// Limits along a stretch.
    fn limits(&self, part: usize, [rates, speed]: [f64; 2]) -> Limits {
        let share = if self.parts[part].is_straight {
            rates
        } else {
            rates.min(TUNING.gentle.turning_share)
        };
        self.limits_of(part, share, speed)
    }

    /// Shares of the limits along a stretch.
    fn limits_of(&self, part: usize, share: f64, speed: f64) -> Limits {
        let bound = &self.section.bounds[self.parts[part].piece];
        let rate = share * bound.axes.acceleration.min();
        let (acceleration, deceleration) = (
            rate.min(share * bound.acceleration),
            rate.min(share * bound.deceleration),
        );
        // The nodes cannot follow a step of the acceleration, so the jerk is limited in any case.
        let jerk = (share * bound.least_jerk()).min(acceleration.min(deceleration) / TUNING.gentle.step_s);
        Limits {
            speed: speed * self.parts[part].speed,
            acceleration,
            deceleration,
            jerk: Some(Jerk {
                acceleration: jerk,
                deceleration: jerk,
            }),
        }
    }
}

/// The constant speed at which a curve is within all limits, from samples one step apart.
fn most_speed(bound: &MoveLimits, sites: impl Iterator<Item = [Point; 3]>, step: f64) -> f64 {
    let mut before: Option<Point> = None;
    let mut most = f64::INFINITY;
    for [_, tangent, curvature] in sites {
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
