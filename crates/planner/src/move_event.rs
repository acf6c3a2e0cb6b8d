//! When the active move comes to its end, to the place where its successor takes over, and to points before it.

use crate::junction::Ending;
use crate::planner::Planner;
use crate::running::Running;
use crate::tolerance::SAME_INSTANT_S;
use crate::{Clock, Instant};

/// A point on the way of the active move that lies at or before the present tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveEvent {
    /// The successor is to become active: [`Planner::hand_over`].
    HandOver(Instant),
    /// The programmed end is reached and nothing has taken over.
    Reached(Instant),
}

/// When the active move comes to a point before its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventTime {
    /// So long after it became active: seconds, or master units.
    At(f64),
    /// It was there before the present plan began.
    Passed,
    /// Not by the present plan: it is paused before.
    Never,
}

impl<T: Copy> Planner<T> {
    /// The next point on the way that lies at or before the present tick.
    pub fn event(&self, clock: &Clock) -> Option<MoveEvent> {
        let running = self.active.as_ref()?;
        let elapsed = running.trajectory.start.elapsed(clock);
        // A stop is over when it stands, to the last bit.
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

    /// When the distance to go of the active move falls to `distance`, at least 0, along its path. With 0, where its
    /// successor is superposed, when that begins.
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

    /// Seconds, or master units, until the active move is at its end, or its successor becomes active; `None` while nothing is active
    /// or it is paused. Real-time.
    pub fn time_left(&self, clock: &Clock) -> Option<f64> {
        let running = self.active.as_ref()?;
        let end = match self.hand_over_at {
            Some(at) => at,
            None if running.trajectory.profile.arrives() => self.end_of(running, clock),
            None => return None,
        };
        Some((end - running.trajectory.start.elapsed(clock)).max(0.0))
    }

    /// When everything of the active move has come to its end, after the start of its trajectory.
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
