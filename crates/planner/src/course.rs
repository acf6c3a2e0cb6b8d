//! The motion of an active move up to the next instant at which more than its position can change: its phase, its end, or its successor.
//!
//! Units: position units, seconds. Nothing allocates.

use arcline_geometry::{Path, Point};
use arcline_profile::ProfileSegment;

use crate::move_trajectory::on_path;
use crate::planner::Planner;
use crate::tolerance::SAME_INSTANT_S;
use crate::{Clock, Instant};

/// One segment of the profile of a move, on one path.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    path: Path,
    segment: ProfileSegment,
    /// The position of the path's start on the profile.
    offset: f64,
    start: Instant,
    /// Seconds from `start` to its end.
    until: f64,
}

impl Course {
    /// Position, velocity and acceleration of the axes at the present tick: those of [`Planner::sample`], to the last bit. `None`: the course has
    /// ended.
    pub fn at(&self, clock: &Clock) -> Option<[Point; 3]> {
        let elapsed = self.start.elapsed(clock);
        if elapsed >= self.until {
            return None;
        }
        let mut along = self.segment.at(elapsed);
        if self.offset != 0.0 {
            along.position -= self.offset;
        }
        Some(on_path(&self.path, along.position, &along))
    }
}

impl<T: Copy> Planner<T> {
    /// The course of the active move from the present tick on. `None` without an active move, and while more than its profile determines the
    /// motion.
    pub fn course(&self, clock: &Clock) -> Option<Course> {
        let running = self.active.as_ref()?;
        let trajectory = &running.trajectory;
        let elapsed = trajectory.start.elapsed(clock);
        let is_alone = self.tail.is_none()
            && self.ramping_out.is_none()
            && self.trail().next().is_none()
            && !self.queue.is_passing()
            && trajectory.rotation.is_none()
            && trajectory.run_up.is_none()
            && trajectory.residual.is_none();
        if !is_alone || !trajectory.profile.arrives() {
            return None;
        }
        let segment = trajectory.profile.segment(elapsed)?;
        let end = self.hand_over_at.unwrap_or(f64::INFINITY);
        let end = end.min(trajectory.profile.duration()).min(segment.until());
        Some(Course {
            path: trajectory.path,
            segment,
            offset: trajectory.offset,
            start: trajectory.start,
            until: end - SAME_INSTANT_S,
        })
    }
}
