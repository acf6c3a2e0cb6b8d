//! Stops of one axis: of one generator, of all motion of single-axis instructions, or of all motion.
//!
//! Not here: the instructions that stop an axis (`crate::motion`, `crate::instructions`). Units: position units, seconds. Nothing allocates.

use arcline_planner::Instant;
use arcline_planner::profile::{Jerk, Limits, Profile};
use arcline_profile::KinematicState;

use super::generator::Generator;
use super::generator_kind::GeneratorKind;
use super::{AfterStop, Axis};
use crate::execution::Execution;

impl Axis {
    /// Brakes one generator from its present motion; `execution` completes when the generator stands. The instruction that
    /// began the generator does not end here. A stop that is under way only becomes harder.
    pub(crate) fn brake(&mut self, kind: GeneratorKind, limits: &Limits, execution: Option<Execution>, now: Instant) {
        let Some(generator) = self.sum.get_mut(kind) else {
            return;
        };
        let limits = &harder(limits, generator.brake.as_ref());
        let mut from = generator.now;
        if limits.jerk.is_none() {
            from.acceleration = 0.0;
        }
        let before = generator.in_force.filter(|_| generator.follower.is_none());
        let limits_of_stop = stopping(limits, before.as_ref());
        let stop = Profile::stop_within(from, limits, before.as_ref(), self.dynamics_bits);
        generator.jerk = generator.highest_jerk();
        // A stop is a function of time, even if the motion that it stops is a function of a master.
        generator.follower = None;
        generator.follow(stop, now);
        generator.set_limits_in_force(&limits_of_stop);
        generator.execution = execution;
        generator.program = None;
        generator.stopping = true;
        generator.brake = Some(*limits);
    }

    /// Marks one generator as stopping on its own profile; `execution` completes when the generator stands.
    pub(crate) fn let_rest(&mut self, kind: GeneratorKind, execution: Option<Execution>) {
        if let Some(generator) = self.sum.get_mut(kind) {
            generator.jerk = generator.highest_jerk();
            generator.execution = execution;
            generator.program = None;
            generator.stopping = true;
        }
    }

    /// The stop of an axis that would move a robot out of its reach: at the axis's maxima, with no less jerk than the programmed jerk of
    /// the generators that move it.
    pub(crate) fn guarded_stop(&self) -> Limits {
        let mut limits = self.dynamics.stop(self.is_s_curve());
        if let Some(jerk) = &mut limits.jerk {
            let programmed = self.sum.active().map(|(_, generator)| generator.highest_jerk());
            let highest = programmed.fold(jerk.deceleration, f64::max);
            (jerk.acceleration, jerk.deceleration) = (highest, highest);
        }
        limits
    }

    /// Replaces all motion of the axis by one deceleration from its total speed and acceleration, at least as hard as every stop
    /// under way. The instructions that moved the axis do not end here.
    pub(crate) fn brake_all(&mut self, limits: &Limits, execution: Option<Execution>, now: Instant) {
        let brakes = self.sum.active().filter_map(|(_, generator)| generator.brake);
        let limits = &brakes.fold(*limits, |limits, brake| harder(&limits, Some(&brake)));
        let mut from = self.command;
        if limits.jerk.is_none() {
            from.acceleration = 0.0;
        }
        let started_at = self.started_at;
        let before = self.sum.in_force(|_| true);
        let profile = Profile::stop_within(from, limits, before.as_ref(), self.dynamics_bits);
        let mut stop = Generator::planned(profile, now);
        stop.set_limits_in_force(&stopping(limits, before.as_ref()));
        stop.execution = execution;
        stop.stopping = true;
        stop.brake = Some(*limits);
        stop.s_curve = limits.jerk.is_some();
        stop.after_transform = self.stops_after_transform();
        stop.coordinated = self.has_coordinated_motion();
        self.after_stop = AfterStop::Hold;
        self.sum.set_position(from.position);
        self.begin(GeneratorKind::Stop, stop);
        self.started_at = started_at;
    }

    /// Replaces all motion of the axis by one deceleration at its Maximum Deceleration, from the set-point that went out at `began`.
    pub(crate) fn brake_from(&mut self, last: KinematicState, began: Instant) {
        let limits = self.dynamics.stop(false);
        self.after_stop = AfterStop::Hold;
        self.sum.set_position(last.position);
        self.command = KinematicState::at_rest(last.position);
        if limits.deceleration <= 0.0 {
            return;
        }
        let mut stop = Generator::planned(Profile::stop(last, &limits), began);
        stop.stopping = true;
        stop.brake = Some(limits);
        let started_at = self.started_at;
        self.begin(GeneratorKind::Stop, stop);
        self.started_at = started_at;
    }

    /// Replaces the motion of single-axis instructions, and a stop of such motion, by one deceleration; the motion of a coordinate system
    /// or a transform continues. The instructions do not end here.
    pub(crate) fn brake_own(&mut self, limits: &Limits, now: Instant) {
        let moved = self.sum.motion_of(GeneratorKind::is_own);
        let from = KinematicState {
            position: self.command.position,
            velocity: moved.velocity,
            acceleration: if limits.jerk.is_some() { moved.acceleration } else { 0.0 },
        };
        let mut stop = Generator::planned(Profile::stop(from, limits), now);
        stop.stopping = true;
        stop.s_curve = limits.jerk.is_some();
        if let Some(earlier) = self.sum.get(GeneratorKind::Stop) {
            (stop.after_transform, stop.coordinated) = (earlier.after_transform, earlier.coordinated);
        }
        let started_at = self.started_at;
        for kind in GeneratorKind::ALL {
            if kind.is_own() {
                self.end(kind);
            }
        }
        self.after_stop = AfterStop::Hold;
        self.begin(GeneratorKind::Stop, stop);
        self.started_at = started_at;
    }
}

/// The limits of a stop; an acceleration ramps down at least as fast as under the earlier limits.
fn stopping(limits: &Limits, before: Option<&Limits>) -> Limits {
    let mut limits = *limits;
    limits.speed = before.map_or(0.0, |before| before.speed);
    if let (Some(jerk), Some(own)) = (&mut limits.jerk, before.and_then(|before| before.jerk)) {
        jerk.acceleration = jerk.acceleration.max(own.acceleration);
    }
    limits
}

/// The limits of a stop that replaces one under way with the limits `under_way`.
fn harder(limits: &Limits, under_way: Option<&Limits>) -> Limits {
    let Some(under_way) = under_way else { return *limits };
    let jerk = limits.jerk.map(|jerk| match under_way.jerk {
        None => jerk,
        Some(other) => Jerk {
            acceleration: jerk.acceleration.max(other.acceleration),
            deceleration: jerk.deceleration.max(other.deceleration),
        },
    });
    Limits {
        acceleration: limits.acceleration.max(under_way.acceleration),
        deceleration: limits.deceleration.max(under_way.deceleration),
        jerk,
        ..*limits
    }
}
