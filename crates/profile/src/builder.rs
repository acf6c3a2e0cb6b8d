//! The targets of planned segments: a profile, or a displacement only.

use crate::KinematicState;
use crate::profile::{Profile, Segment};

/// A stop of five segments and a return of seven make twelve; 3.4 needs eleven (spec/motion-core.md §3.4). Two more make the
/// phase before the plan ([`crate::AccelerationRemovalPhase`]).
pub(crate) const MAX_SEGMENTS: usize = 14;

/// Receives constant-jerk segments one after the other.
pub(crate) trait Sink {
    fn velocity(&self) -> f64;
    fn acceleration(&self) -> f64;
    /// Adds a segment of `time` with `jerk`. Times that are not above 0 are left out.
    fn push(&mut self, time: f64, jerk: f64);
    /// Replaces the computed velocity and acceleration by their exact values.
    fn set(&mut self, velocity: f64, acceleration: f64);
}

/// Displacement, velocity and acceleration: the result of a trial.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trial {
    pub(crate) x: f64,
    pub(crate) v: f64,
    pub(crate) a: f64,
}

impl Sink for Trial {
    fn velocity(&self) -> f64 {
        self.v
    }

    fn acceleration(&self) -> f64 {
        self.a
    }

    #[inline(always)]
    fn push(&mut self, time: f64, jerk: f64) {
        if time > 0.0 {
            let half = 0.5 * jerk * time;
            self.x += time * (self.v + time * (0.5 * self.a + half * THIRD));
            self.v += time * (self.a + half);
            self.a += time * jerk;
        }
    }

    #[inline(always)]
    fn set(&mut self, velocity: f64, acceleration: f64) {
        self.v = velocity;
        self.a = acceleration;
    }
}

/// Multiplication, since a division takes three times as long.
const THIRD: f64 = 1.0 / 3.0;

/// Collects the segments of a profile. Works in a mirrored frame (`sign` -1) where displacement
/// starts at 0, so that mirrored plans are mirror images bit for bit.
#[derive(Debug)]
pub(crate) struct Builder<'a> {
    pub(crate) now: Trial,
    pub(crate) time: f64,
    pub(crate) len: usize,
    sign: f64,
    /// Filled in place, as copies of it are expensive.
    profile: &'a mut Profile,
}

impl<'a> Builder<'a> {
    /// Starts a new plan, in the frame mirrored by `sign`, from the profile's start state.
    #[inline]
    pub(crate) fn new(profile: &'a mut Profile, sign: f64) -> Builder<'a> {
        let start = profile.start;
        Builder {
            now: Trial {
                x: 0.0,
                v: sign * start.velocity,
                a: sign * start.acceleration,
            },
            time: 0.0,
            len: 0,
            sign,
            profile,
        }
    }

    /// The present state in the caller's frame.
    pub(crate) fn state(&self) -> KinematicState {
        KinematicState {
            position: self.profile.start.position + self.sign * self.now.x,
            velocity: self.sign * self.now.v,
            acceleration: self.sign * self.now.a,
        }
    }

    /// Duration of a segment that has been pushed.
    pub(crate) fn length_of(&self, index: usize) -> f64 {
        let end = if index + 1 < self.len {
            self.profile.times[index + 1]
        } else {
            self.time
        };
        end - self.profile.times[index]
    }

    /// The state at the start of a segment, in the builder's frame, and its jerk.
    pub(crate) fn segment(&self, index: usize) -> (Trial, f64) {
        let Segment { state, jerk } = self.profile.segments[index];
        (
            Trial {
                x: state.position,
                v: state.velocity,
                a: state.acceleration,
            },
            jerk,
        )
    }

    /// Returns to the start of a segment and removes it and all later ones.
    pub(crate) fn rewind(&mut self, index: usize, now: Trial) {
        self.time = self.profile.times[index];
        self.now = now;
        self.len = index;
    }

    /// Ends the profile where it first passes displacement `x` (in the builder's frame, forwards),
    /// which is the position `target`. False if it never does.
    pub(crate) fn cut_at(mut self, x: f64, target: f64) -> bool {
        for index in 0..self.len {
            let next = if index + 1 < self.len {
                self.segment(index + 1).0
            } else {
                self.now
            };
            let segment = self.profile.segments[index];
            if segment.state.position <= x && x <= next.x && next.x > segment.state.position {
                let at_start = x == segment.state.position;
                let time = if at_start {
                    0.0
                } else {
                    segment.time_to(x, self.length_of(index))
                };
                let now = self.segment(index).0;
                self.rewind(index, now);
                self.push(time, segment.jerk);
                let end = KinematicState {
                    position: target,
                    ..self.state()
                };
                self.finish(end, true);
                return true;
            }
        }
        false
    }

    #[inline]
    pub(crate) fn finish(self, end: KinematicState, arrives: bool) {
        let profile = self.profile;
        profile.len = self.len;
        profile.duration = self.time;
        profile.arrives = arrives;
        // Avoids negative zeros.
        profile.end = KinematicState {
            position: end.position,
            velocity: end.velocity + 0.0,
            acceleration: end.acceleration + 0.0,
        };
        // Converts displacements in the mirrored frame to the caller's positions.
        for Segment { state, jerk } in profile.segments.iter_mut().take(self.len) {
            state.position = profile.start.position + self.sign * state.position;
            state.velocity *= self.sign;
            state.acceleration *= self.sign;
            *jerk *= self.sign;
        }
    }
}

impl Sink for Builder<'_> {
    fn velocity(&self) -> f64 {
        self.now.v
    }

    fn acceleration(&self) -> f64 {
        self.now.a
    }

    #[inline(always)]
    fn push(&mut self, time: f64, jerk: f64) {
        // A time below the resolution of the clock changes the state, but adds no segment.
        if self.time + time > self.time && self.len < MAX_SEGMENTS {
            let Trial { x, v, a } = self.now;
            self.profile.times[self.len] = self.time;
            let state = KinematicState {
                position: x,
                velocity: v,
                acceleration: a,
            };
            self.profile.segments[self.len] = Segment { state, jerk };
            self.len += 1;
            self.time += time;
        }
        self.now.push(time, jerk);
    }

    #[inline(always)]
    fn set(&mut self, velocity: f64, acceleration: f64) {
        self.now.set(velocity, acceleration);
    }
}
