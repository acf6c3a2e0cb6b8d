//! A servo: a proportional position loop with velocity feed-forward, and the effect of its limits.
//!
//! With the command `r`, the actual position `x` and the following error `e = r - x`, the loop requires the velocity
//!
//! ```text
//! u = K e + f r'        K = 2π · bandwidth, f = feed-forward gain
//! ```
//!
//! which the axis has without limits, `x' = u`: a response of `(K + f s) / (K + s)`. Between two updates, `r` is the cubic through both
//! positions and velocities, for which the response is solved exactly. The limits are in [`super::regime`]. The loop acts on the true
//! position; the feedback shows that of the encoder.

use std::f64::consts::TAU;

use arcline_profile::KinematicState;

use super::encoder::Encoder;
use super::regime::{DriveLimits, Loop, LoopState, Regime};
use super::settings::Settings;
use crate::Saturation;

/// A simulated servo drive and its mechanics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    control: Loop,
    limits: Option<DriveLimits>,
    encoder: Encoder,
    command: KinematicState,
    error: f64,
    actual: KinematicState,
    regime: Regime,
    /// Seconds for which the regime has lasted within the last period.
    lasted: f64,
    /// Seconds before the end of the next period at which the command comes to rest.
    rest: f64,
}

/// `r' = c0 + c1 t + c2 t²`: the velocity of the command within a period.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Velocity {
    pub(crate) c: [f64; 3],
}

impl Servo {
    pub(crate) fn new(position: f64, settings: &Settings) -> Self {
        let Settings {
            speed_limit: speed,
            torque_limit: torque,
            ..
        } = *settings;
        Servo {
            control: Loop {
                gain: TAU * settings.bandwidth,
                feedforward: settings.feedforward,
            },
            limits: (speed.is_finite() || torque.is_finite()).then_some(DriveLimits { speed, torque }),
            encoder: Encoder {
                resolution: settings.encoder_resolution,
            },
            command: KinematicState::at_rest(position),
            error: 0.0,
            actual: KinematicState::at_rest(position),
            regime: Regime::Linear,
            lasted: 0.0,
            rest: 0.0,
        }
    }

    pub(crate) fn actual(&self) -> KinematicState {
        self.actual
    }

    pub(crate) fn measured(&self) -> KinematicState {
        KinematicState {
            position: self.encoder.read(self.actual.position),
            ..self.actual
        }
    }

    pub(crate) fn measured_error(&self) -> f64 {
        self.measured_with(self.error)
    }

    /// The following error by the encoder, for a true one.
    fn measured_with(&self, error: f64) -> f64 {
        match self.encoder.resolution {
            Some(_) => self.command.position - self.encoder.read(self.command.position - error),
            None => error,
        }
    }

    pub(crate) fn saturation(&self) -> Saturation {
        match self.regime {
            Regime::Linear => Saturation::None,
            Regime::Speed(_) => Saturation::Speed,
            Regime::Torque(_) => Saturation::Torque,
        }
    }

    pub(crate) fn error_before(&self, seconds: f64) -> f64 {
        if self.limits.is_some() && seconds > self.lasted {
            return f64::INFINITY;
        }
        let velocity = self.actual.velocity;
        self.measured_with(match self.regime {
            // Also if the exponential overflows.
            Regime::Linear if self.error == 0.0 => self.error,
            Regime::Linear => self.error * libm::exp(self.control.gain * seconds),
            Regime::Speed(_) => self.error + seconds * velocity,
            Regime::Torque(rate) => self.error + seconds * (velocity - 0.5 * rate * seconds),
        })
    }

    /// Acceleration at the torque limit, or 0 without one.
    pub(crate) fn torque_limit(&self) -> f64 {
        self.limits.map_or(
            0.0,
            |limits| if limits.torque.is_finite() { limits.torque } else { 0.0 },
        )
    }

    /// The length of one encoder count, or 0 without an encoder.
    pub(crate) fn count(&self) -> f64 {
        self.encoder.resolution.map_or(0.0, |resolution| 1.0 / resolution)
    }

    /// Sets the motion of the axis; the command is the position by the encoder.
    pub(crate) fn set_state(&mut self, now: KinematicState) {
        self.actual = now;
        self.command = KinematicState {
            position: self.encoder.read(now.position),
            ..now
        };
        self.error = self.command.position - now.position;
        self.lasted = 0.0;
        self.rest = 0.0;
        self.regime = match &self.limits {
            Some(limits) => limits.regime_at(self.asked(), now.velocity),
            None => Regime::Linear,
        };
    }

    pub(crate) fn rest_for(&mut self, seconds: f64) {
        self.rest = seconds;
    }

    pub(crate) fn cycle(&mut self, command: KinematicState, period: f64) {
        let rest = std::mem::take(&mut self.rest);
        if 0.0 < rest && rest < period && command.velocity == 0.0 {
            let before = self.actual.velocity;
            self.span(command, period - rest);
            self.span(command, rest);
            self.actual.acceleration = (self.actual.velocity - before) / period;
        } else {
            self.span(command, period);
        }
    }

    /// Executes a period, or the part of one up to the rest of the command.
    fn span(&mut self, command: KinematicState, period: f64) {
        let before = self.command;
        self.command = command;
        let stood = before == command && command.velocity == 0.0;
        if self.error == 0.0 && self.regime == Regime::Linear && (self.is_rigid() || stood) {
            self.actual = command;
            self.lasted = period;
            return;
        }
        let velocity = Velocity::between(&before, &command, period);
        match self.limits {
            Some(limits) => {
                let state = LoopState {
                    error: self.error,
                    velocity: self.actual.velocity,
                    regime: self.regime,
                    command: velocity,
                };
                let (state, lasted) = state.after(&self.control, &limits, period);
                self.regime = state.regime;
                self.lasted = lasted;
                if lasted < period || state.regime != Regime::Linear {
                    self.follow(state.error, state.velocity, period);
                } else if self.error == 0.0 && self.control.feedforward == 1.0 {
                    self.actual = command;
                } else {
                    self.linear(&before, &velocity, period);
                }
            }
            None => self.linear(&before, &velocity, period),
        }
    }

    pub(crate) fn is_exact(&self) -> bool {
        self.is_rigid() && self.encoder.resolution.is_none()
    }

    pub(crate) fn command_within(&self, command: &KinematicState, period: f64, at: f64) -> KinematicState {
        command_within(&self.command, command, period, at)
    }

    /// The velocity of the loop.
    fn asked(&self) -> f64 {
        self.control.feedforward * self.command.velocity + self.control.gain * self.error
    }

    /// The axis follows any command without an error.
    fn is_rigid(&self) -> bool {
        self.limits.is_none() && self.control.feedforward == 1.0
    }

    /// Executes a whole period without limits.
    fn linear(&mut self, before: &KinematicState, velocity: &Velocity, period: f64) {
        let command = self.command;
        let [p0, p1, p2] = self.control.particular(velocity);
        let decayed = (self.error - p0) * libm::exp(-self.control.gain * period);
        let mut error = p0 + period * (p1 + period * p2) + decayed;
        if command == *before && error.abs() <= command.position.abs().max(1.0) * f64::EPSILON {
            error = 0.0;
        }
        let rate = self.control.feedforward * command.velocity + self.control.gain * error;
        self.follow(error, rate, period);
    }

    fn follow(&mut self, error: f64, velocity: f64, period: f64) {
        self.error = error;
        self.actual = KinematicState {
            position: self.command.position - error,
            velocity,
            acceleration: (velocity - self.actual.velocity) / period,
        };
    }
}

impl Velocity {
    /// The velocity of the cubic through both ends of a period.
    fn between(before: &KinematicState, after: &KinematicState, period: f64) -> Self {
        let slope = (after.position - before.position) / period;
        let c1 = (6.0 * slope - 4.0 * before.velocity - 2.0 * after.velocity) / period;
        let c2 = 3.0 * (before.velocity + after.velocity - 2.0 * slope) / (period * period);
        Velocity {
            c: [before.velocity, c1, c2],
        }
    }

    /// The velocity relative to a later instant.
    pub(crate) fn from(&self, t: f64) -> Self {
        let [c0, c1, c2] = self.c;
        Velocity {
            c: [c0 + t * (c1 + t * c2), c1 + 2.0 * t * c2, c2],
        }
    }
}

/// The command at `at` seconds after the beginning of a period, from `before` to `after` at its ends.
pub(super) fn command_within(before: &KinematicState, after: &KinematicState, period: f64, at: f64) -> KinematicState {
    let velocity = Velocity::between(before, after, period);
    let [c0, c1, c2] = velocity.c;
    let [now, slope, _] = velocity.from(at).c;
    KinematicState {
        position: before.position + at * (c0 + at * (0.5 * c1 + at * c2 / 3.0)),
        velocity: now,
        acceleration: slope,
    }
}
