//! The finished profile: a fixed number of segments, each with its start time, start state and jerk.
//!
//! Seconds and position units. Sampling evaluates the segment from its start and never integrates,
//! so rounding does not grow with time.

use crate::KinematicState;
use crate::builder::{Builder, MAX_SEGMENTS};
use crate::limits::{Limits, ProfileShape, sane};
use crate::numeric::newton;
use crate::tolerance::{BRACKET_SHARE, ROUNDED_SHARE, SAMPLED_POSITION_SHARE};
use crate::{position, ramp, trapezoid};

/// The phase of a motion at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// The magnitude of the velocity grows.
    Accelerating,
    /// Constant velocity, or at rest.
    #[default]
    Steady,
    /// The magnitude of the velocity shrinks.
    Decelerating,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Segment {
    pub(crate) state: KinematicState,
    pub(crate) jerk: f64,
}

/// A part of a profile with one jerk and one phase.
#[derive(Clone, Copy, Debug)]
pub struct ProfileSegment {
    segment: Segment,
    from: f64,
    until: f64,
}

impl ProfileSegment {
    /// As [`Profile::at`], to the last bit, from the instant of [`Profile::segment`] until its end.
    #[must_use]
    pub fn at(&self, t: f64) -> KinematicState {
        self.segment.at(t - self.from)
    }

    /// The time of its end, seconds after the start of the profile; infinite for the motion that continues after the profile.
    #[must_use]
    pub fn until(&self) -> f64 {
        self.until
    }
}

/// Position over time: planned once, sampled often. `Copy`, without heap.
#[derive(Clone, Copy, Debug)]
pub struct Profile {
    /// Start times of the segments. Entries from `len` on are unused, here and below.
    pub(crate) times: [f64; MAX_SEGMENTS],
    pub(crate) segments: [Segment; MAX_SEGMENTS],
    pub(crate) len: usize,
    pub(crate) start: KinematicState,
    pub(crate) duration: f64,
    pub(crate) end: KinematicState,
    pub(crate) arrives: bool,
}

impl Profile {
    /// At rest at `position`, with a duration of 0.
    #[must_use]
    pub fn rest(position: f64) -> Profile {
        let state = KinematicState {
            position,
            velocity: 0.0,
            acceleration: 0.0,
        };
        Profile {
            arrives: true,
            ..Profile::unplanned(state)
        }
    }

    /// From `from` to `target`, passing it with `end_speed` (spec/motion-core.md §2, §3.4).
    ///
    /// `end_speed` is along the direction of positive positions (negative for the other), at most the
    /// speed limit. If it can be met, [`Profile::end`] is exactly `(target, end_speed, 0)`. If
    /// the distance is too short for it, the profile ends at `target` with the velocity and acceleration
    /// that the straight ramp towards `end_speed` has there; if the target lies behind, the
    /// profile ends at rest. With speed limit 0 the motion stops and does not arrive
    /// ([`Profile::arrives`]).
    ///
    /// Real-time safe: at most 64 evaluations of at most nine segments.
    #[must_use]
    #[inline]
    pub fn to_position(from: KinematicState, target: f64, end_speed: f64, limits: &Limits) -> Profile {
        let mut profile = Profile::unplanned(from);
        profile.plan_to_position(from, target, end_speed, limits);
        profile
    }

    /// As [`Profile::to_position`] to rest, but in two stages if it would overshoot the target: first the
    /// stop, then a move back from rest (spec/motion-core.md §5.2: after a change of dynamics).
    #[must_use]
    #[inline]
    pub fn to_position_two_stage(from: KinematicState, target: f64, limits: &Limits) -> Profile {
        let mut profile = Profile::unplanned(from);
        profile.plan_in_two_stages(from, target, limits);
        profile
    }

    /// From `from` to a velocity (signed), which continues after the duration (spec/motion-core.md §3.3).
    /// `limits.speed` is not read.
    #[must_use]
    #[inline]
    pub fn to_velocity(from: KinematicState, velocity: f64, limits: &Limits) -> Profile {
        let mut profile = Profile::unplanned(from);
        profile.plan_to_velocity(from, velocity, limits);
        profile
    }

    /// To rest at any position: [`Profile::to_velocity`] 0.
    #[must_use]
    pub fn stop(from: KinematicState, limits: &Limits) -> Profile {
        Profile::to_velocity(from, 0.0, limits)
    }

    /// Seconds to the end state.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The state at time 0.
    #[must_use]
    pub fn start(&self) -> KinematicState {
        self.start
    }

    /// The exact end state.
    #[must_use]
    pub fn end(&self) -> KinematicState {
        self.end
    }

    /// The profile ends at its target: false only for a speed limit of 0.
    #[must_use]
    pub fn arrives(&self) -> bool {
        self.arrives
    }

    /// The state `t` seconds after the start. Before 0 the start state; from the duration on the end
    /// state, whose velocity continues. Real-time safe: one pass over at most 14 start times.
    #[must_use]
    pub fn at(&self, t: f64) -> KinematicState {
        if t >= self.duration {
            let mut end = self.end;
            if end.velocity != 0.0 {
                end.position += end.velocity * (t - self.duration);
            }
            return end;
        }
        if t < 0.0 || self.len == 0 {
            return self.start;
        }
        let index = self.segment_at(t);
        self.segments[index].at(t - self.times[index])
    }

    /// The jerk at `t`, position units per second cubed: at the joint of two segments that of the later one.
    #[must_use]
    pub fn jerk(&self, t: f64) -> f64 {
        if t >= self.duration || t < 0.0 || self.len == 0 {
            return 0.0;
        }
        self.segments[self.segment_at(t)].jerk
    }

    /// The phase at `t`, determined by segment and not by sampling: at the joint of two
    /// segments the later one counts.
    #[must_use]
    pub fn phase(&self, t: f64) -> Phase {
        if t >= self.duration || t < 0.0 || self.len == 0 {
            return Phase::Steady;
        }
        self.phase_of(self.segment_at(t))
    }

    /// The segment at `t`: at the joint of two segments the later one; after the duration, the motion that continues. `None` before
    /// the start.
    #[must_use]
    pub fn segment(&self, t: f64) -> Option<ProfileSegment> {
        if t >= self.duration {
            return (self.end.acceleration == 0.0).then_some(ProfileSegment {
                segment: Segment {
                    state: self.end,
                    jerk: 0.0,
                },
                from: self.duration,
                until: f64::INFINITY,
            });
        }
        if t < 0.0 || self.len == 0 {
            return None;
        }
        let index = self.segment_at(t);
        Some(ProfileSegment {
            segment: self.segments[index],
            from: self.times[index],
            until: self.end_of(index),
        })
    }

    /// The time (s) until which the motion speeds up from the start: the beginning of the cruise or of
    /// the braking. 0 if it does not begin by speeding up. Real-time safe: one pass over the segments.
    #[must_use]
    pub fn accelerates_until(&self) -> f64 {
        let rising = (0..self.len).take_while(|&index| self.phase_of(index) == Phase::Accelerating);
        match rising.count() {
            0 => 0.0,
            count if count == self.len => self.duration,
            count => self.times[count],
        }
    }

    /// The time (s) from which the motion only slows down, to the end; the duration if it does not end
    /// by slowing down. Real-time safe: one pass over the segments.
    #[must_use]
    pub fn brakes_from(&self) -> f64 {
        let falling = (0..self.len)
            .rev()
            .take_while(|&index| self.phase_of(index) == Phase::Decelerating);
        match falling.last() {
            Some(index) => self.times[index],
            None => self.duration,
        }
    }

    fn phase_of(&self, index: usize) -> Phase {
        // No segment has a change of sign of v or a inside.
        let middle = self.segments[index].at(0.5 * self.length_of(index));
        let product = middle.velocity * middle.acceleration;
        if product > 0.0 {
            Phase::Accelerating
        } else if product < 0.0 {
            Phase::Decelerating
        } else {
            Phase::Steady
        }
    }

    /// The first time at which the position is `s`; `None` if it never is. Positions behind the end
    /// are reached if the end has a velocity. Real-time safe, bounded.
    #[must_use]
    pub fn time_at_position(&self, s: f64) -> Option<f64> {
        if s == self.start.position {
            return Some(0.0);
        }
        for index in 0..self.len {
            let from = self.segments[index].state.position;
            let last = index + 1 == self.len;
            let to = if last {
                self.end.position
            } else {
                self.segments[index + 1].state.position
            };
            if s == to && last {
                return Some(self.duration);
            }
            if (from <= s && s <= to) || (to <= s && s <= from) {
                return Some(self.times[index] + self.segments[index].time_to(s, self.length_of(index)));
            }
        }
        if s == self.end.position {
            return Some(self.duration);
        }
        let more = (s - self.end.position) / self.end.velocity;
        if more >= 0.0 && more.is_finite() {
            return Some(self.duration + more);
        }
        // Beyond a turning point or the end by rounding, as a sample may be.
        let turns = self.segments.iter().zip(&self.times).take(self.len);
        let (mut nearest, mut when) = ((s - self.end.position).abs(), self.duration);
        let mut largest = self.end.position.abs();
        for (segment, &time) in turns {
            let position = segment.state.position;
            largest = largest.max(position.abs());
            if (s - position).abs() < nearest {
                (nearest, when) = ((s - position).abs(), time);
            }
        }
        (nearest <= SAMPLED_POSITION_SHARE * largest).then_some(when)
    }

    /// Start times of the segments, for plots and tests: at most 14, ascending.
    #[must_use]
    pub fn segment_times(&self) -> &[f64] {
        &self.times[..self.len]
    }

    // The plans work in place and their callers are inlined, to avoid copies of the large profile. Each of them completes the profile.

    fn plan_to_position(&mut self, from: KinematicState, target: f64, end_speed: f64, limits: &Limits) {
        let (target, end_speed) = (sane_position(target), sane(end_speed));
        self.start = sane_state(&from);
        match limits.shape() {
            ProfileShape::SCurve(limits) => position::to_position(self, target, end_speed, &limits),
            ProfileShape::Trapezoid(limits) => trapezoid::to_position(self, target, end_speed, &limits),
        }
    }

    fn plan_in_two_stages(&mut self, from: KinematicState, target: f64, limits: &Limits) {
        let target = sane_position(target);
        self.start = sane_state(&from);
        match limits.shape() {
            ProfileShape::SCurve(limits) => position::to_position_two_stage(self, target, &limits),
            // Braking to rest, then a move from rest, is the usual behaviour of a trapezoid.
            ProfileShape::Trapezoid(limits) => trapezoid::to_position(self, target, 0.0, &limits),
        }
    }

    fn plan_to_velocity(&mut self, from: KinematicState, velocity: f64, limits: &Limits) {
        let velocity = sane(velocity);
        self.start = sane_state(&from);
        let mut builder = Builder::new(self, 1.0);
        match limits.shape() {
            ProfileShape::SCurve(limits) => ramp::ramp(&mut builder, velocity, &limits),
            ProfileShape::Trapezoid(limits) => trapezoid::ramp(&mut builder, velocity, &limits),
        }
        let end = KinematicState {
            velocity,
            acceleration: 0.0,
            ..builder.state()
        };
        builder.finish(end, true);
    }

    /// An empty profile from `start`, for a plan.
    #[inline]
    fn unplanned(start: KinematicState) -> Profile {
        Profile {
            times: [0.0; MAX_SEGMENTS],
            segments: [Segment::default(); MAX_SEGMENTS],
            len: 0,
            start,
            duration: 0.0,
            end: start,
            arrives: false,
        }
    }

    fn segment_at(&self, t: f64) -> usize {
        let mut index = 0;
        while index + 1 < self.len && t >= self.times[index + 1] {
            index += 1;
        }
        index
    }

    fn end_of(&self, index: usize) -> f64 {
        if index + 1 < self.len {
            self.times[index + 1]
        } else {
            self.duration
        }
    }

    fn length_of(&self, index: usize) -> f64 {
        self.end_of(index) - self.times[index]
    }
}

impl Segment {
    pub(crate) fn at(&self, u: f64) -> KinematicState {
        let KinematicState {
            position,
            velocity,
            acceleration,
        } = self.state;
        KinematicState {
            position: position + u * (velocity + u * (0.5 * acceleration + u * (self.jerk * SIXTH))),
            velocity: velocity + u * (acceleration + u * (0.5 * self.jerk)),
            acceleration: acceleration + u * self.jerk,
        }
    }

    /// The time within `length` at which the position, monotone here, is `s`.
    pub(crate) fn time_to(&self, s: f64, length: f64) -> f64 {
        let rising = self.at(length).position >= self.state.position;
        let (below, above) = if rising { (0.0, length) } else { (length, 0.0) };
        let miss = |u: f64| {
            let state = self.at(u);
            (state.position - s, state.velocity)
        };
        newton(below, above, MAX_STEPS, miss, |step| {
            if step.value == 0.0 || step.is_closed(BRACKET_SHARE) {
                Some(step.at)
            } else {
                ((step.next - step.at).abs() <= ROUNDED_SHARE * step.at).then_some(step.next)
            }
        })
    }
}

/// Most steps to an instant.
const MAX_STEPS: usize = 64;
/// Multiplication, since a division takes three times as long.
const SIXTH: f64 = 1.0 / 6.0;

fn sane_state(state: &KinematicState) -> KinematicState {
    KinematicState {
        position: sane_position(state.position),
        velocity: sane(state.velocity),
        acceleration: sane(state.acceleration),
    }
}

/// Positions keep their bits unless they are not finite or beyond every usable range.
fn sane_position(position: f64) -> f64 {
    if position.is_nan() {
        0.0
    } else {
        position.clamp(-1e60, 1e60)
    }
}
