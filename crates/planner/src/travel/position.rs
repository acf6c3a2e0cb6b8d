//! Where the motion is, and when it comes to a point of its path.

use arcline_geometry::Point;
use arcline_profile::Limits;

use super::Travel;
use crate::move_event::EventTime;
use crate::{Clock, Sample, TimeBase};

impl<T: Copy> Travel<T> {
    /// Where the coordinate system is at the present tick, by time, and its speed along the path by what the active move is a function of.
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

    /// Seconds until the active move is at its end or its successor becomes active, as planned now; `None` where no time is known.
    pub fn time_left(&self, time: &Clock) -> Option<f64> {
        match self.contour_in_force() {
            Some(contour) => contour.time_left(time),
            None => self.planner.time_left(time),
        }
    }

    /// Length of the path of the active move, units: of a contour the curve that it is travelled on.
    pub fn length(&self) -> f64 {
        match self.contour_in_force() {
            Some(contour) => contour.length(),
            None => self
                .planner
                .active()
                .map_or(0.0, |running| running.motion.path.length()),
        }
    }

    /// Whether the motion is off the programmed path at the present tick, in a blend.
    pub fn in_transition(&self, base: &TimeBase) -> bool {
        match self.contour_in_force() {
            Some(contour) => contour.in_transition(&self.contour_clock(base)),
            None => self.planner.in_transition(&base.clock()),
        }
    }

    /// When so much of the active move is left, at least 0, after it became active: seconds, or master units.
    pub fn reaches(&self, distance: f64, base: &TimeBase) -> EventTime {
        let Some(contour) = self.contour_in_force() else {
            return self.planner.reaches(distance, &base.clock());
        };
        match contour.reaches(distance, &self.contour_clock(base)) {
            EventTime::At(seconds) => EventTime::At(seconds * contour.nominal()),
            other => other,
        }
    }

    /// The acceleration that the curvature of superposed paths gives at the present tick, units/s².
    pub fn centripetal(&self, base: &TimeBase) -> Point {
        let rate = base.master.as_ref().map_or(1.0, |master| master.rate.speed);
        self.planner.centripetal(&base.clock()) * (rate * rate)
    }

    /// With what the turn of the present may be braked ([`crate::Planner::turn_limits`]).
    pub fn turn_limits(&self) -> Option<Limits> {
        self.planner.turn_limits()
    }
}
