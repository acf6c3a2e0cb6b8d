//! The times at which the active move reaches its end, the takeover by its successor, and points before its end.

use crate::junction::Ending;
use crate::planner::Planner;
use crate::running::Running;
use crate::tolerance::SAME_INSTANT_S;
use crate::{Clock, Instant};

/// An event of the active move at or before the present tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveEvent {
    /// The successor is to become active: [`Planner::hand_over`].
    HandOver(Instant),
    /// The programmed end is reached without a takeover.
    Reached(Instant),
}

/// The time at which the active move reaches a point before its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventTime {
    /// The time after it became active: seconds, or master units.
    At(f64),
    /// Before the beginning of the present plan.
    Passed,
    /// Not by the present plan: the move pauses before.
    Never,
}

impl<T: Copy> Planner<T> {
    /// The next event at or before the present tick.
    pub fn event(&self, clock: &Clock) -> Option<MoveEvent> {
        let running = self.active.as_ref()?;
        let elapsed = running.trajectory.start.elapsed(clock);
        // A stop ends at an exact velocity of 0.
        let rounding = if running.stopped { 0.0 } else { SAME_INSTANT_S };
        let instant = |seconds: f64| running.trajectory.start.after(seconds.min(elapsed), clock);
        if let Some(at) = self.hand_over_at
            && elapsed >= at - rounding
        {
            return Some(MoveEvent::HandOver(instant(at)));
        }
        if !running.trajectory.profile.arrives() {
            return None;
        }
        let end = self.end_of(running, clock);
        (elapsed >= end - rounding).then(|| MoveEvent::Reached(instant(end)))
    }

    /// The time at which the active move has `distance` (at least 0) left along its path. With 0 and a blend, the time at which its successor
    /// begins.
    pub fn reaches(&self, distance: f64, clock: &Clock) -> EventTime {
        let Some(running) = &self.active else {
            return EventTime::Never;
        };
        let trajectory = &running.trajectory;
        let since = running.begun.elapsed(clock) - trajectory.start.elapsed(clock);
        let at = |planned: f64| EventTime::At((since + planned).max(0.0));
        let length = running.motion.path.length();
        if distance > length {
            return EventTime::At(0.0);
        }
        let arrives = trajectory.profile.arrives();
        if distance == 0.0 {
            if let (Some(early), Ending::Blend { .. }) = (self.hand_over_at, running.motion.ending) {
                return at(early);
            }
            if running.joined == 0 {
                return if arrives {
                    at(self.end_of(running, clock))
                } else {
                    EventTime::Never
                };
            }
        }
        let event_position = trajectory.offset + length - distance;
        if event_position < trajectory.profile.start().position {
            return EventTime::Passed;
        }
        match trajectory.profile.time_at_position(event_position) {
            Some(planned) => at(planned),
            None if arrives => at(trajectory.profile.duration()),
            None => EventTime::Never,
        }
    }

    /// Seconds, or master units, until the end of the active move, or until its successor becomes active; `None` without an active move, or
    /// while it is paused. Real-time.
    pub fn time_left(&self, clock: &Clock) -> Option<f64> {
        let running = self.active.as_ref()?;
        let end = match self.hand_over_at {
            Some(at) => at,
            None if running.trajectory.profile.arrives() => self.end_of(running, clock),
            None => return None,
        };
        Some((end - running.trajectory.start.elapsed(clock)).max(0.0))
    }

    /// The time at which the active move, with its blend and residual, has ended, after the start of its trajectory.
    fn end_of(&self, running: &Running<T>, clock: &Clock) -> f64 {
        let mut end = running.trajectory.duration(clock);
        if let (Some(out), true) = (&self.ramping_out, running.exit == 0.0) {
            end = end.max(out.rests_after(&running.trajectory.start, clock));
        }
        match &self.tail {
            Some(tail) if running.exit == 0.0 => {
                end.max(tail.duration(clock) + running.trajectory.start.elapsed(clock) - tail.start.elapsed(clock))
            }
            _ => end,
        }
    }
}
