//! One path in execution: the geometry, the profile along it, and the motion superposed on it.

use arcline_geometry::{Path, PathPoint, Point, Rotation, RotationState};
use arcline_profile::{DynamicsBits, KinematicState, Limits, MOST_OVERSHOOT, Phase, Profile};

use crate::running::scaled_limits;
use crate::tolerance::{DISTANCE_SHARE, ROUNDING_SHARE, SAME_INSTANT_S};
use crate::{Clock, Instant, MasterRate};

/// A path with the profile along it, from an instant on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoveTrajectory {
    pub(crate) path: Path,
    /// The rotation of the orientation along `path`.
    pub(crate) rotation: Option<Rotation>,
    /// The distance before the start of `path`, on a collinear predecessor.
    pub(crate) run_up: Option<Path>,
    /// The predecessor's remaining motion to the start of `path`, if the move became active before its end.
    pub(crate) approach: Option<Approach>,
    pub(crate) profile: Profile,
    pub(crate) start: Instant,
    /// The position of the path's start on the profile: not 0 if the profile runs over several joined paths.
    pub(crate) offset: f64,
    pub(crate) residual: Option<Residual>,
}

/// A predecessor that still runs to its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach {
    pub(crate) path: Path,
    pub(crate) profile: Profile,
    pub(crate) start: Instant,
    /// The position of the path's start on the profile.
    pub(crate) offset: f64,
    /// The programmed limits of its profile.
    pub(crate) limits: Limits,
    /// Its deceleration may stem from other limits.
    pub(crate) has_other_limits: bool,
}

/// Terminated motion that ramps out while its displacement is compensated in proportion to the distance covered on the path
/// (spec/coordinated-instructions.md §6.3).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residual {
    /// Along the old velocity, and across it if the acceleration was not along the velocity; or axis by axis.
    pub(crate) parts: [ResidualPart; 3],
    pub(crate) start: Instant,
    /// Share of the move's limits for its own profile, such that path and compensation together keep them: at most 1.
    pub(crate) share: f64,
}

/// A displacement along one direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResidualPart {
    pub(crate) direction: Point,
    pub(crate) profile: Profile,
    /// The final displacement.
    whole: f64,
}

/// The motion of a trajectory, or of a whole coordinate system, at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Position of the axes, position units.
    pub position: Point,
    /// Velocity of the axes, units/s.
    pub velocity: Point,
    /// Acceleration of the axes, units/s².
    pub acceleration: Point,
    /// State along the path: distance from its start, speed, tangential acceleration.
    pub along: KinematicState,
    /// The phase of the speed along the path.
    pub phase: Phase,
    /// The orientation, and its rates in radians/s and radians/s², while a move rotates it.
    pub rotation_state: Option<RotationState>,
}

impl MoveTrajectory {
    pub(crate) fn sample(&self, clock: &Clock) -> Sample {
        let elapsed = self.start.elapsed(clock);
        if let (Some(approach), true) = (&self.approach, elapsed < 0.0) {
            return Sample {
                // Only a move without a rotation has an approach.
                rotation_state: self.rotation.map(|rotation| rotation.at(0.0)),
                ..approach.sample(clock)
            };
        }
        let along = self.along(elapsed);
        let phase = self.profile.phase(elapsed);
        let mut sample = match &self.run_up {
            Some(run_up) if along.position < 0.0 => at(run_up, run_up.length() + along.position, along, phase),
            _ => at(&self.path, along.position, along, phase),
        };
        if let Some(residual) = &self.residual {
            residual.add(&mut sample, self.path.length(), clock);
        }
        let length = self.path.length();
        sample.rotation_state = self.rotation.map(|rotation| {
            if length > 0.0 {
                let rotation_state = rotation.at(along.position / length);
                rotation_state.in_time(along.velocity / length, along.acceleration / length)
            } else {
                rotation.ended()
            }
        });
        sample
    }

    /// As [`MoveTrajectory::sample`], but behind the end of its path on the paths of a trail: at most as many as a profile crosses.
    pub(crate) fn sample_along<'a>(&self, trail: impl Iterator<Item = &'a Path>, clock: &Clock) -> Sample {
        let mut sample = self.sample(clock);
        let (mut length, mut distance) = (self.path.length(), sample.along.position);
        for path in trail {
            if distance <= length || self.is_approaching(clock) {
                break;
            }
            distance -= length;
            length = path.length();
            let on = at(path, distance, sample.along, sample.phase);
            sample = Sample {
                along: sample.along,
                rotation_state: sample.rotation_state,
                ..on
            };
        }
        sample
    }

    /// The number of these paths, each with the highest speed at the corner before it, that the profile crosses. A corner that it would pass
    /// faster than the axes can follow ends the count.
    pub(crate) fn followed<'a>(&self, beyond: impl Iterator<Item = (&'a Path, f64)>) -> usize {
        let mut end = self.path.length();
        let mut count = 0;
        for (path, corner) in beyond {
            let speed = match self.profile.time_at_position(end) {
                Some(at) => self.profile.at(at).velocity,
                // The profile does not get there: later paths make no difference.
                None => return usize::MAX,
            };
            if speed > corner * (1.0 + ROUNDING_SHARE) {
                break;
            }
            end += path.length();
            count += 1;
        }
        count
    }

    /// Adds the remaining motion of this move to a sample of the move that blends with its end.
    pub(crate) fn add_rest(&self, mut sample: Sample, clock: &Clock) -> Sample {
        let rest = self.sample(clock);
        sample.position += rest.position - self.path.end();
        sample.velocity += rest.velocity;
        sample.acceleration += rest.acceleration;
        sample.rotation_state = match (sample.rotation_state, rest.rotation_state, self.rotation) {
            (Some(own), Some(rest), Some(rotation)) => Some(own.after(&rest, &rotation.ended())),
            (own, rest, _) => own.or(rest),
        };
        sample
    }

    /// State along the path at the present tick; before its start the distance is negative.
    pub(crate) fn state(&self, clock: &Clock) -> KinematicState {
        let elapsed = self.start.elapsed(clock);
        match &self.approach {
            Some(approach) if elapsed < 0.0 => {
                let mut state = approach.profile.at(approach.start.elapsed(clock));
                state.position -= approach.offset + approach.path.length();
                state
            }
            _ => self.along(elapsed),
        }
    }

    /// The share of the limits of the move for the profile.
    pub(crate) fn share(&self) -> f64 {
        self.residual.map_or(1.0, |residual| residual.share)
    }

    fn along(&self, elapsed: f64) -> KinematicState {
        let mut along = self.profile.at(elapsed);
        if self.offset != 0.0 {
            along.position -= self.offset;
            if elapsed >= self.profile.duration() && self.profile.end().velocity == 0.0 && self.ends_here() {
                along.position = self.path.length();
            }
        }
        along
    }

    /// The profile ends at the end of the path, within the rounding of the offset.
    fn ends_here(&self) -> bool {
        let length = self.path.length();
        (self.profile.end().position - self.offset - length).abs() <= DISTANCE_SHARE * (self.offset + length)
    }

    /// Continues on another profile from an instant on, beginning in the state at that instant.
    pub(crate) fn replan(&mut self, profile: Profile, at: Instant) {
        if let Some(approach) = self.approach.take()
            && profile.start().position < 0.0
        {
            self.run_up = Some(approach.path);
        }
        self.offset = 0.0;
        self.profile = profile;
        self.start = at;
    }

    /// Brakes on its path from the instant that both clocks show: until then it was a function of a master's displacement, from then on of time.
    /// The residual beside the path brakes, too.
    pub(crate) fn stop_in_time(
        &mut self,
        limits: &Limits,
        dynamics_bits: DynamicsBits,
        rate: &MasterRate,
        clock: &Clock,
        time: &Clock,
    ) {
        let from = rate.in_time(self.state(clock));
        if let Some(residual) = &mut self.residual {
            let elapsed = residual.start.elapsed(clock);
            for part in &mut residual.parts {
                let now = rate.in_time(part.profile.at(elapsed));
                part.profile = Profile::stop_within(now, limits, None, dynamics_bits);
            }
            residual.start = time.now();
        }
        self.replan(self.stop_from(from, limits, None, dynamics_bits), time.now());
    }

    /// A stop along the path. `limits` apply to the axes together, so a path with a compensation that adds to its length has only its share of
    /// them. The stop is no faster than the limits `before` and half as much again, or than the planned maximum of the earlier profile.
    pub(crate) fn stop_from(
        &self,
        from: KinematicState,
        limits: &Limits,
        before: Option<&Limits>,
        dynamics_bits: DynamicsBits,
    ) -> Profile {
        let share = self.share();
        let before = before.map(|before| {
            let own = scaled_limits(before, 1.0, share);
            Limits {
                speed: own.speed.max(self.profile.top_speed(0.0) / MOST_OVERSHOOT),
                ..own
            }
        });
        Profile::stop_within(from, &scaled_limits(limits, 1.0, share), before.as_ref(), dynamics_bits)
    }

    /// The acceleration across the path at the present tick.
    pub(crate) fn centripetal(&self, clock: &Clock) -> Point {
        let elapsed = self.start.elapsed(clock);
        let (path, state) = match &self.approach {
            Some(approach) if elapsed < 0.0 => {
                let mut state = approach.profile.at(approach.start.elapsed(clock));
                state.position -= approach.offset;
                (&approach.path, state)
            }
            _ => (&self.path, self.along(elapsed)),
        };
        path.at(state.position).curvature * (state.velocity * state.velocity)
    }

    /// The path has not begun: the predecessor still runs to its end.
    pub(crate) fn is_approaching(&self, clock: &Clock) -> bool {
        self.approach.is_some() && self.start.elapsed(clock) < 0.0
    }

    /// The profile, approach and residual of this trajectory have ended at an instant.
    pub(crate) fn is_over_at(&self, at: &Instant, clock: &Clock) -> bool {
        self.start.elapsed(clock) - at.elapsed(clock) >= self.duration(clock) - SAME_INSTANT_S
    }

    /// Seconds from the start to the end of the profile, the approach and the residual of this trajectory.
    pub(crate) fn duration(&self, clock: &Clock) -> f64 {
        let own = self.profile.duration();
        self.residual.map_or(own, |residual| {
            let head = self.start.elapsed(clock) - residual.start.elapsed(clock);
            own.max(residual.duration() + head)
        })
    }
}

impl Approach {
    fn sample(&self, clock: &Clock) -> Sample {
        let elapsed = self.start.elapsed(clock);
        let mut along = self.profile.at(elapsed);
        along.position -= self.offset;
        at(&self.path, along.position, along, self.profile.phase(elapsed))
    }
}

impl Residual {
    /// A residual that ramps out beside a path. A compensation away from the target makes the distance longer than the path; the path
    /// is then slower by that factor.
    pub(crate) fn new(parts: [ResidualPart; 3], start: Instant, path: &Path) -> Self {
        Residual {
            parts,
            start,
            share: Residual::share_of(&parts, path),
        }
    }

    /// The factor of the speed of a path beside a residual.
    pub(crate) fn share_of(parts: &[ResidualPart; 3], path: &Path) -> f64 {
        let length = path.length();
        let total: Point = parts.iter().map(ResidualPart::total).sum();
        let allowed = match path {
            Path::Line(line) => (line.end() - line.start() - total).norm(),
            Path::Arc(_) => length + total.norm(),
        };
        if allowed > length { length / allowed } else { 1.0 }
    }

    pub(crate) fn duration(&self) -> f64 {
        self.parts
            .iter()
            .map(|part| part.profile.duration())
            .fold(0.0, f64::max)
    }

    fn add(&self, sample: &mut Sample, length: f64, clock: &Clock) {
        for part in &self.parts {
            let now = part.profile.at(self.start.elapsed(clock));
            let share = if length > 0.0 { part.whole / length } else { 0.0 };
            sample.position += part.direction * (now.position - share * sample.along.position);
            sample.velocity += part.direction * (now.velocity - share * sample.along.velocity);
            sample.acceleration += part.direction * (now.acceleration - share * sample.along.acceleration);
        }
    }
}

impl ResidualPart {
    pub(crate) fn new(direction: Point, profile: Profile) -> Self {
        ResidualPart {
            direction,
            profile,
            whole: profile.end().position,
        }
    }

    pub(crate) fn moves(&self) -> bool {
        self.profile.duration() > 0.0
    }

    pub(crate) fn total(&self) -> Point {
        self.direction * self.whole
    }
}

fn at(path: &Path, s: f64, along: KinematicState, phase: Phase) -> Sample {
    let [position, velocity, acceleration] = on_path(path, s, &along);
    Sample {
        position,
        velocity,
        acceleration,
        along,
        phase,
        rotation_state: None,
    }
}

/// Position, velocity and acceleration of the axes at arc length `s` of a path.
pub(crate) fn on_path(path: &Path, s: f64, along: &KinematicState) -> [Point; 3] {
    let PathPoint {
        position,
        tangent,
        curvature,
        ..
    } = path.at(s);
    let acceleration = tangent * along.acceleration + curvature * (along.velocity * along.velocity);
    [position, tangent * along.velocity, acceleration]
}
