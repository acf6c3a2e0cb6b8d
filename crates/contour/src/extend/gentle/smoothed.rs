//! The smooth curve of dense chords that continues a running motion, by its own arc length. Position units and seconds.

use crate::extend::warm_start::{Running, knots, warm_start};
use crate::path::margin::ToleranceMargin;
use crate::path::smooth::smooth;
use crate::section::Section;
use crate::solve::work::Budget;
use crate::timing::resample::project;
use crate::{AxesState, Point, Trajectory};
use arcline_profile::KinematicState;

/// Its timing is that of a warm start, and only places its nodes.
pub(crate) struct Smoothed {
    motion: Trajectory,
    /// The time of each node, and the corresponding arc length of the reference path.
    times: Vec<f64>,
    progress: Vec<f64>,
    /// Instants of the knots that follow the running motion, from the one before the splice on.
    followed: Vec<f64>,
    /// Arc length from which on it is straight to its end.
    straight: f64,
}

impl Smoothed {
    /// `None` if too little follows the kept part.
    pub(crate) fn new(section: &Section<'_>, running: Running<'_>, budget: &mut Budget) -> Option<Smoothed> {
        let mut control = warm_start(section, running);
        budget.begin_smooth(control.points.len());
        let margin = ToleranceMargin::new();
        smooth(
            &section.reference,
            &section.allowance,
            &margin,
            &section.bounds,
            &mut control,
        );
        project(&section.reference, &mut control);
        let mut motion = control.spline(&control.spans);
        motion.arc_lengths = motion.measure_arc_lengths();
        let mut followed = knots(section, running);
        followed.truncate(control.kept_nodes - 1);
        let straight = motion.knots.len().checked_sub(1 + LAST_KNOTS)?;
        (straight > control.kept_nodes && motion.duration().is_finite()).then(|| Smoothed {
            straight: motion.arc_lengths[straight],
            times: control.times(&motion),
            progress: control.progress,
            followed,
            motion,
        })
    }

    pub(crate) fn followed(&self) -> &[f64] {
        &self.followed
    }

    /// The state along the curve at the end of the followed part.
    pub(crate) fn begin(&self) -> KinematicState {
        let time = self.followed[self.followed.len() - 1];
        let state = self.motion.at(time);
        let speed = state.velocity.norm();
        KinematicState {
            position: self.motion.arc_length(time),
            velocity: speed,
            acceleration: state.velocity.dot(&state.acceleration) / speed,
        }
    }

    pub(crate) fn motion(&self, time: f64) -> AxesState {
        self.motion.at(time)
    }

    /// The arc lengths of its knots after the followed part, and of its end.
    pub(crate) fn sites(&self) -> Vec<f64> {
        let begin = self.begin().position;
        let inner = self.motion.arc_lengths.iter().copied();
        let inner = inner.filter(|&at| at > begin && at < self.straight);
        core::iter::once(begin)
            .chain(inner)
            .chain([self.straight, self.length()])
            .collect()
    }

    /// The arc length of the reference path at an instant.
    pub(crate) fn progress(&self, time: f64) -> f64 {
        let k = self
            .times
            .partition_point(|&node| node < time)
            .clamp(1, self.times.len() - 1);
        let (t0, t1) = (self.times[k - 1], self.times[k]);
        let part = ((time - t0) / (t1 - t0)).clamp(0.0, 1.0);
        self.progress[k - 1] + (self.progress[k] - self.progress[k - 1]) * part
    }

    /// The arc length of the reference path at an arc length of this curve.
    pub(crate) fn progress_at(&self, s: f64) -> f64 {
        self.progress(self.time(s))
    }

    /// The point at an arc length, and its first two derivatives by it.
    pub(crate) fn derivatives(&self, s: f64) -> [Point; 3] {
        if s >= self.straight {
            let (from, end) = (self.motion.at(self.time(self.straight)), self.end());
            let tangent = (end - from.position) / (self.length() - self.straight);
            return [from.position + tangent * (s - self.straight), tangent, Point::zeros()];
        }
        let AxesState {
            position,
            velocity,
            acceleration,
        } = self.motion.at(self.time(s));
        let square = velocity.norm_squared();
        let tangent = velocity / square.sqrt();
        let across = acceleration - tangent * tangent.dot(&acceleration);
        [position, tangent, across / square]
    }

    fn time(&self, s: f64) -> f64 {
        let whole = self.motion.arc_lengths.last().copied().unwrap_or(0.0);
        let end = self.motion.duration();
        self.motion.time_before(end, whole - s).unwrap_or(0.0)
    }

    fn end(&self) -> Point {
        self.motion.at(self.motion.duration()).position
    }

    fn length(&self) -> f64 {
        let from = self.motion.at(self.time(self.straight)).position;
        self.straight + (self.end() - from).norm()
    }
}

/// Knots at its end that lie on a straight line.
const LAST_KNOTS: usize = 4;
