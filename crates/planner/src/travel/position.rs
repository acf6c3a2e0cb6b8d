//! The present motion, and the times at which it reaches points of its path.

use arcline_geometry::Point;
use arcline_profile::Limits;

use super::Travel;
use crate::move_event::EventTime;
use crate::{Clock, Course, Sample, TimeBase};

impl<T: Copy> Travel<T> {
    /// The motion of the coordinate system at the present tick, by time, and its speed along the path in the variable of the active move.
    pub fn sample(&self, base: &TimeBase) -> Option<(Sample, f64)> {
        let contour = self.contour_in_force();
        let sample = match contour {
            Some(contour) => contour.sample(&self.contour_clock(base)),
            None => self.planner.sample(&base.clock()),
        }?;
        let planned = sample.along.velocity;
        let Some(master) = &base.master else {
            return Some((sample, planned));
        };
        let rate = match contour {
            Some(_) => self.contour_rate(base),
            None => master.rate,
        };
        Some((rate.sample(sample), planned))
    }

    /// The course of the active superposed move from the present tick on ([`crate::Planner::course`]); `None` while contours are planned as well.
    pub fn course(&self, time: &Clock) -> Option<Course> {
        if self.contour.is_some() {
            return None;
        }
        self.planner.course(time)
    }

    /// Seconds until the end of the active move, or until its successor becomes active, as planned now; `None` if the time is unknown.
    pub fn time_left(&self, time: &Clock) -> Option<f64> {
        match self.contour_in_force() {
            Some(contour) => contour.time_left(time),
            None => self.planner.time_left(time),
        }
    }

    /// Length of the path of the active move, units: for a contour, of its planned curve.
    pub fn length(&self) -> f64 {
        match self.contour_in_force() {
            Some(contour) => contour.length(),
            None => self
                .planner
                .active()
                .map_or(0.0, |running| running.motion.path.length()),
        }
    }

    /// The motion is in a blend at the present tick, off the programmed path.
    pub fn in_transition(&self, base: &TimeBase) -> bool {
        match self.contour_in_force() {
            Some(contour) => contour.in_transition(&self.contour_clock(base)),
            None => self.planner.in_transition(&base.clock()),
        }
    }

    /// The time, after it became active, at which the active move has `distance` (at least 0) left: seconds, or master units.
    pub fn reaches(&self, distance: f64, base: &TimeBase) -> EventTime {
        let Some(contour) = self.contour_in_force() else {
            return self.planner.reaches(distance, &base.clock());
        };
        match contour.reaches(distance, &self.contour_clock(base)) {
            EventTime::At(seconds) => EventTime::At(seconds * contour.nominal()),
            other => other,
        }
    }

    /// The acceleration from the curvature of superposed paths at the present tick, units/s².
    pub fn centripetal(&self, base: &TimeBase) -> Point {
        let rate = base.master.as_ref().map_or(1.0, |master| master.rate.speed);
        self.planner.centripetal(&base.clock()) * (rate * rate)
    }

    /// The limits for braking the present rotation ([`crate::Planner::turn_limits`]).
    pub fn turn_limits(&self) -> Option<Limits> {
        self.planner.turn_limits()
    }
}
