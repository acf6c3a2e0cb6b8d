//! The residual of a rotation when a move that keeps the orientation is merged: it ramps out about its present axis beside the path
//! (spec/coordinated-instructions.md §6.3).
//!
//! As with a [`crate::move_trajectory::Residual`] of positions, the acceleration across the rate ramps out about an axis of its own. The
//! residual is not compensated: the move has no programmed orientation, and keeps the one in which the tool comes to rest.
//! Bounded; nothing allocates. Radians, seconds.

use arcline_geometry::{Path, Point, Rotation, RotationState, Spin};
use arcline_profile::{Jerk, KinematicState, Limits, Profile};

use crate::junction::braking;
use crate::planner::Planner;
use crate::running::{Parameter, Running};
use crate::tolerance::SAME_INSTANT_S;
use crate::{Clock, Instant, MasterRate};

/// The rotation of an orientation at an instant.
#[derive(Clone, Copy, Debug)]
pub struct AngularState {
    /// Fixed angles, degrees.
    pub angles: Point,
    /// Its rate, radians/s.
    pub rate: Point,
    /// The derivative of the rate, radians/s².
    pub change: Point,
    /// The limits for braking it, radians and seconds; a rotation without a jerk loses its acceleration at once.
    pub limits: Limits,
}

/// A rotation that ramps out.
#[derive(Clone, Copy, Debug)]
pub struct RotationResidual {
    spin: Spin,
    /// Radians along the rate, and across it.
    profiles: [Profile; 2],
    limits: Limits,
}

impl AngularState {
    /// The state over the displacement of a master. `nominal`: the speed of the master at which the limits apply, master units/s.
    #[must_use]
    pub fn by_displacement(&self, rate: &MasterRate, nominal: f64) -> AngularState {
        let mut own = *self;
        for component in 0..own.rate.len() {
            let state = rate.by_displacement(KinematicState {
                position: 0.0,
                velocity: self.rate[component],
                acceleration: self.change[component],
            });
            (own.rate[component], own.change[component]) = (state.velocity, state.acceleration);
        }
        let backwards = Parameter {
            speed: nominal.recip(),
            ..Parameter::TIME
        };
        own.limits = backwards.in_time(&self.limits);
        own
    }

    /// The residual that brakes it to rest; `None` if it is at rest.
    #[must_use]
    pub fn ramped_out(&self) -> Option<RotationResidual> {
        let turns = self.rate != Point::zeros() || self.kept_change() != Point::zeros();
        turns.then(|| self.ramp())
    }

    /// The acceleration that does not end at once.
    fn kept_change(&self) -> Point {
        match self.limits.jerk {
            Some(_) => self.change,
            None => Point::zeros(),
        }
    }

    fn ramp(&self) -> RotationResidual {
        let (speed, change) = (self.rate.norm(), self.kept_change());
        let along = self.rate.try_normalize(0.0).unwrap_or_default();
        let across = change - along * along.dot(&change);
        let limits = braking(&self.limits, speed);
        let profiles = [
            KinematicState {
                position: 0.0,
                velocity: speed,
                acceleration: along.dot(&change),
            },
            KinematicState {
                acceleration: across.norm(),
                ..KinematicState::default()
            },
        ]
        .map(|from| Profile::stop(from, &limits));
        let duration = longest(&profiles);
        let axes = [along, across.try_normalize(0.0).unwrap_or_default()];
        let spin = Spin::new(&self.angles, axes, |share| angles(&profiles, share * duration));
        RotationResidual { spin, profiles, limits }
    }
}

impl RotationResidual {
    /// Rx, Ry, Rz at rest, degrees.
    #[must_use]
    pub fn end(&self) -> Point {
        self.spin.ended().near
    }
}

/// A rotation that ramps out from an instant on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RampingOut {
    residual: RotationResidual,
    start: Instant,
    /// The orientation with which moves begin: the planned end of the rotation.
    end: RotationState,
}

impl RampingOut {
    /// The orientation while `own`, a rotation that begins at the planned end of this one, is active too.
    pub(crate) fn beside(&self, own: Option<RotationState>, clock: &Clock) -> RotationState {
        let elapsed = self.start.elapsed(clock);
        let rest = if elapsed >= longest(&self.residual.profiles) {
            self.residual.spin.ended()
        } else {
            self.residual.spin.at(&angles(&self.residual.profiles, elapsed))
        };
        own.map_or(rest, |own| own.after(&rest, &self.end))
    }

    /// The rotation is at rest at an instant.
    pub(crate) fn is_over_at(&self, at: &Instant, clock: &Clock) -> bool {
        self.start.elapsed(clock) - at.elapsed(clock) >= longest(&self.residual.profiles) - SAME_INSTANT_S
    }

    /// Seconds from an instant until it is at rest.
    pub(crate) fn rests_after(&self, since: &Instant, clock: &Clock) -> f64 {
        longest(&self.residual.profiles) + since.elapsed(clock) - self.start.elapsed(clock)
    }

    /// Converts it from a function of a master's displacement to one of time, at the instant that both clocks show.
    fn in_time(&self, parameter: &Parameter, rate: &MasterRate, clock: &Clock, time: &Clock) -> RampingOut {
        let rotation_state = self.beside(None, clock).in_time(rate.speed, rate.acceleration);
        let turning = AngularState {
            angles: rotation_state.angles(),
            rate: rotation_state.rate,
            change: rotation_state.change,
            limits: parameter.in_time(&self.residual.limits),
        };
        RampingOut {
            residual: turning.ramp(),
            start: time.now(),
            end: self.end,
        }
    }
}

impl<T: Copy> Planner<T> {
    /// Makes the move that was just merged keep the orientation in which a rotation comes to rest.
    pub fn ramp_out(&mut self, residual: Option<RotationResidual>, clock: &Clock) {
        self.ramping_out = residual.map(|residual| RampingOut {
            residual,
            start: clock.now(),
            end: residual.spin.ended(),
        });
    }

    /// The limits for braking the present rotation: those of the moves that rotate, radians and seconds; of two simultaneous ones, the higher.
    /// `None` without a rotation.
    pub fn turn_limits(&self) -> Option<Limits> {
        let active = self.active.as_ref();
        let own = active.and_then(Running::turn_limits);
        let rest = self.tail_turns.filter(|_| self.tail.is_some());
        let out = self.ramping_out.zip(active).map(|(out, running)| {
            let parameter = &running.motion.parameter;
            parameter.in_time(&out.residual.limits)
        });
        let all = own.into_iter().chain(rest).chain(out);
        all.reduce(|most, other| {
            if other.deceleration > most.deceleration {
                other
            } else {
                most
            }
        })
    }

    /// The path and the rotation of the move with which the active one blends.
    pub fn tail(&self) -> Option<(&Path, Option<&Rotation>)> {
        self.tail.as_ref().map(|tail| (&tail.path, tail.rotation.as_ref()))
    }

    /// Brakes the move with which the active one blends, with limits of its own; a stop of all has just begun.
    pub fn stop_tail(&mut self, limits: &Limits, clock: &Clock) {
        if let Some(tail) = &mut self.tail {
            let stop = tail.stop_from(tail.state(clock), limits, None, self.dynamics_bits);
            tail.replan(stop, clock.now());
        }
    }

    pub(crate) fn ramp_out_in_time(&mut self, rate: &MasterRate, clock: &Clock, time: &Clock) {
        if self.active.is_some() {
            self.ramping_out = self.ramping_out_in_time(rate, clock, time);
        }
    }

    /// The residual of a rotation, as a function of time.
    pub(crate) fn ramping_out_in_time(&self, rate: &MasterRate, clock: &Clock, time: &Clock) -> Option<RampingOut> {
        let out = self.ramping_out.filter(|out| !out.is_over_at(&clock.now(), clock))?;
        let parameter = &self.active.as_ref()?.motion.parameter;
        Some(out.in_time(parameter, rate, clock, time))
    }
}

impl<T> Running<T> {
    /// The limits of its rotation, radians and seconds.
    pub(crate) fn turn_limits(&self) -> Option<Limits> {
        let rotation = self.motion.rotation.filter(|rotation| !rotation.keeps_orientation())?;
        let length = self.motion.path.length();
        let ratio = if length > 0.0 {
            rotation.angle().to_radians() / length
        } else {
            0.0
        };
        let limits = self.motion.parameter.in_time(&self.motion.limits);
        (ratio > 0.0).then(|| Limits {
            speed: limits.speed * ratio,
            acceleration: limits.acceleration * ratio,
            deceleration: limits.deceleration * ratio,
            jerk: limits.jerk.map(|jerk| Jerk {
                acceleration: jerk.acceleration * ratio,
                deceleration: jerk.deceleration * ratio,
            }),
        })
    }
}

fn angles(profiles: &[Profile; 2], elapsed: f64) -> [[f64; 3]; 2] {
    profiles.each_ref().map(|profile| {
        let at = profile.at(elapsed);
        [at.position, at.velocity, at.acceleration]
    })
}

fn longest(profiles: &[Profile; 2]) -> f64 {
    profiles.iter().map(Profile::duration).fold(0.0, f64::max)
}
