//! The path from an axis's command to its actual position.
//!
//! An ideal drive follows at once. A [`Servo`] follows through a position loop with velocity feed-forward, within its limits of speed and
//! torque, and its position is read through an encoder ([`Settings`]). Both are solved exactly over each coarse update period, so their motion
//! does not depend on its length. Not here: faults, the drive's states, the units of the configuration. Units: position units, seconds. Nothing
//! allocates.

use arcline_profile::KinematicState;

use super::tolerance::STANDSTILL_UNITS_PER_S;
use super::{Servo, Settings};
use crate::Saturation;

/// A drive with its axis. A copy of it can run ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Follows the command without error.
    Ideal(KinematicState),
    /// Follows through a position loop.
    Servo(Servo),
}

/// Time constant of an axis that coasts to rest without torque, seconds.
const COAST_TIME_CONSTANT: f64 = 0.1;

impl Drive {
    /// An ideal drive at rest.
    pub fn ideal(position: f64) -> Self {
        Drive::Ideal(KinematicState::at_rest(position))
    }

    /// A servo at rest.
    pub fn servo(position: f64, settings: &Settings) -> Self {
        Drive::Servo(Servo::new(position, settings))
    }

    /// The motion of the axis by its encoder: the position is a whole number of counts, if it has an encoder.
    pub fn actual(&self) -> KinematicState {
        match self {
            Drive::Ideal(actual) => *actual,
            Drive::Servo(servo) => servo.measured(),
        }
    }

    /// Command minus actual position by the encoder.
    pub fn error(&self) -> f64 {
        match self {
            Drive::Ideal(_) => 0.0,
            Drive::Servo(servo) => servo.measured_error(),
        }
    }

    /// The following error `seconds` ago, at most a period, if the command has not moved since.
    ///
    /// Infinite if it is unknown because a limit has ended since; a search for the instant of an error then never yields one that is too early.
    pub fn error_before(&self, seconds: f64) -> f64 {
        match self {
            Drive::Ideal(_) => 0.0,
            Drive::Servo(servo) => servo.error_before(seconds),
        }
    }

    /// The axis is exactly at its command at every instant.
    pub fn is_exact(&self) -> bool {
        match self {
            Drive::Ideal(_) => true,
            Drive::Servo(servo) => servo.is_exact(),
        }
    }

    /// The command at `at` seconds after the beginning of a period at whose end it is `command`.
    pub(super) fn command_within(&self, command: KinematicState, period: f64, at: f64) -> KinematicState {
        match self {
            Drive::Ideal(before) => super::servo::command_within(before, &command, period, at),
            Drive::Servo(servo) => servo.command_within(&command, period, at),
        }
    }

    /// The limit that prevents the drive from following.
    pub fn saturation(&self) -> Saturation {
        match self {
            Drive::Ideal(_) => Saturation::None,
            Drive::Servo(servo) => servo.saturation(),
        }
    }

    /// Makes the command of the next period come to rest `seconds` before its end, if that is within the period and the command is then at rest.
    /// Otherwise the command is the cubic through both ends of the period, without such a corner.
    pub fn rest_for(&mut self, seconds: f64) {
        if let Drive::Servo(servo) = self {
            servo.rest_for(seconds);
        }
    }

    /// Follows the command for one period, to `command` at its end. Real-time.
    pub fn cycle(&mut self, command: KinematicState, period: f64) {
        match self {
            Drive::Ideal(actual) => *actual = command,
            Drive::Servo(servo) => servo.cycle(command, period),
        }
    }

    /// Coasts for one period without torque; the command follows the axis. Real-time.
    pub fn coast(&mut self, period: f64) -> KinematicState {
        let mut now = self.axis();
        if now.velocity != 0.0 {
            let left = libm::exp(-period / COAST_TIME_CONSTANT);
            now.position += now.velocity * COAST_TIME_CONSTANT * (1.0 - left);
            now.velocity *= left;
            now.acceleration = -now.velocity / COAST_TIME_CONSTANT;
            if now.velocity.abs() < STANDSTILL_UNITS_PER_S {
                now = KinematicState::at_rest(now.position);
            }
        }
        self.set_state(now);
        self.actual()
    }

    /// Removes torque and speed at once: the axis stands at the position that its encoder reads.
    pub fn halt(&mut self) {
        self.set_state(KinematicState::at_rest(self.actual().position));
    }

    /// The true motion of the axis, between the counts of its encoder.
    pub(super) fn axis(&self) -> KinematicState {
        match self {
            Drive::Ideal(actual) => *actual,
            Drive::Servo(servo) => servo.actual(),
        }
    }

    fn set_state(&mut self, now: KinematicState) {
        match self {
            Drive::Ideal(actual) => *actual = now,
            Drive::Servo(servo) => servo.set_state(now),
        }
    }
}

#[cfg(test)]
#[path = "drive_tests.rs"]
mod tests;
