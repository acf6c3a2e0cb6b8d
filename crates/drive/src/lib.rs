//! What stands between an axis's command and its actual position.
//!
//! An ideal drive follows at once. A servo is a proportional position loop with velocity feed-forward,
//! solved exactly over each coarse update period: with the command `r`, the actual position `x` and the
//! following error `e = r - x`,
//!
//! ```text
//! x' = K e + f r'        e' = (1 - f) r' - K e        K = 2π · bandwidth, f = feed-forward gain
//! ```
//!
//! where `r` between two updates is the cubic through both positions and velocities. Not here: faults, the
//! drive's states, the units of the configuration. Units: position units, seconds. Nothing allocates.

#![forbid(unsafe_code)]

use std::f64::consts::TAU;

/// Position and velocity of the command or of the axis itself.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Motion {
    /// Position units.
    pub position: f64,
    /// Position units per second.
    pub velocity: f64,
    /// Position units per second².
    pub acceleration: f64,
}

/// A drive with its axis. Copied to look ahead.
#[derive(Clone, Copy, Debug)]
pub enum Drive {
    /// Follows the command without error.
    Ideal(Motion),
    /// Follows through a position loop.
    Servo(Servo),
}

/// A simulated servo drive and its mechanics.
#[derive(Clone, Copy, Debug)]
pub struct Servo {
    gain: f64,
    feedforward: f64,
    command: Motion,
    error: f64,
    actual: Motion,
}

/// Time constant with which an axis without torque comes to rest, seconds.
const COAST_TIME_CONSTANT: f64 = 0.1;
/// A coasting axis slower than this, units/s, stands.
const STANDSTILL: f64 = 1e-6;

impl Drive {
    /// An ideal drive at rest.
    pub fn ideal(position: f64) -> Self {
        Drive::Ideal(standing(position))
    }

    /// A servo at rest. `bandwidth` of the position loop in hertz, more than 0; `feedforward` 0 to 1.
    pub fn servo(position: f64, bandwidth: f64, feedforward: f64) -> Self {
        Drive::Servo(Servo {
            gain: TAU * bandwidth,
            feedforward,
            command: standing(position),
            error: 0.0,
            actual: standing(position),
        })
    }

    /// What the axis really does.
    pub fn actual(&self) -> Motion {
        match self {
            Drive::Ideal(actual) => *actual,
            Drive::Servo(servo) => servo.actual,
        }
    }

    /// Command minus actual position.
    pub fn error(&self) -> f64 {
        match self {
            Drive::Ideal(_) => 0.0,
            Drive::Servo(servo) => servo.error,
        }
    }

    /// The following error `seconds` ago, if the command stood still since.
    pub fn error_before(&self, seconds: f64) -> f64 {
        match self {
            Drive::Ideal(_) => 0.0,
            Drive::Servo(servo) => servo.error * libm::exp(servo.gain * seconds),
        }
    }

    /// Follows the command for one period, at whose end it is `command`. Real-time.
    pub fn cycle(&mut self, command: Motion, period: f64) {
        match self {
            Drive::Ideal(actual) => *actual = command,
            Drive::Servo(servo) => servo.cycle(command, period),
        }
    }

    /// One period without torque: the axis coasts to rest and the command goes with it. Real-time.
    pub fn coast(&mut self, period: f64) -> Motion {
        let mut now = self.actual();
        if now.velocity != 0.0 {
            let left = libm::exp(-period / COAST_TIME_CONSTANT);
            now.position += now.velocity * COAST_TIME_CONSTANT * (1.0 - left);
            now.velocity *= left;
            now.acceleration = -now.velocity / COAST_TIME_CONSTANT;
            if now.velocity.abs() < STANDSTILL {
                now = standing(now.position);
            }
        }
        self.place(now);
        now
    }

    /// Shifts command and actual position by an offset, as a redefinition of the axis's position does; nothing moves.
    pub fn shift(&mut self, offset: f64) {
        match self {
            Drive::Ideal(actual) => actual.position += offset,
            Drive::Servo(servo) => {
                servo.command.position += offset;
                servo.actual.position += offset;
            }
        }
    }

    /// Removes torque and speed at once: the axis stands where it is.
    pub fn halt(&mut self) {
        self.place(standing(self.actual().position));
    }

    fn place(&mut self, now: Motion) {
        match self {
            Drive::Ideal(actual) => *actual = now,
            Drive::Servo(servo) => {
                servo.actual = now;
                servo.command = now;
                servo.error = 0.0;
            }
        }
    }
}

impl Servo {
    fn cycle(&mut self, command: Motion, period: f64) {
        let before = self.command;
        self.command = command;
        if self.error == 0.0 && (self.feedforward == 1.0 || (before == command && command.velocity == 0.0)) {
            self.actual = command;
            return;
        }
        // r'(t) = c0 + c1 t + c2 t²: the derivative of the cubic through both ends.
        let slope = (command.position - before.position) / period;
        let c0 = before.velocity;
        let c1 = (6.0 * slope - 4.0 * before.velocity - 2.0 * command.velocity) / period;
        let c2 = 3.0 * (before.velocity + command.velocity - 2.0 * slope) / (period * period);
        // e' = g r' - K e has the particular solution p0 + p1 t + p2 t².
        let g = 1.0 - self.feedforward;
        let k = self.gain;
        let p2 = g * c2 / k;
        let p1 = (g * c1 - 2.0 * p2) / k;
        let p0 = (g * c0 - p1) / k;
        let decayed = (self.error - p0) * libm::exp(-k * period);
        self.error = p0 + period * (p1 + period * p2) + decayed;
        if command == before && self.error.abs() <= command.position.abs().max(1.0) * f64::EPSILON {
            self.error = 0.0;
        }
        let rate = self.feedforward * command.velocity + k * self.error;
        self.actual = Motion {
            position: command.position - self.error,
            velocity: rate,
            acceleration: (rate - self.actual.velocity) / period,
        };
    }
}

fn standing(position: f64) -> Motion {
    Motion {
        position,
        velocity: 0.0,
        acceleration: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.001;

    /// A command at constant speed from rest at 0.
    fn at_speed(k: u32, period: f64, speed: f64) -> Motion {
        Motion {
            position: speed * f64::from(k) * period,
            velocity: speed,
            acceleration: 0.0,
        }
    }

    #[test]
    fn a_loop_without_feedforward_follows_at_speed_over_gain() {
        for period in [0.00025, PERIOD, 0.004] {
            let mut drive = Drive::servo(0.0, 40.0, 0.0);
            for k in 1..=(1.0 / period) as u32 {
                drive.cycle(at_speed(k, period, 500.0), period);
            }
            let expected = 500.0 / (TAU * 40.0);
            assert!(
                (drive.error() - expected).abs() < 1e-9 * expected,
                "{} at {period} s",
                drive.error()
            );
            assert!((drive.actual().velocity - 500.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_response_does_not_depend_on_the_update_period() {
        let run = |period: f64| {
            let mut drive = Drive::servo(0.0, 25.0, 0.4);
            // x(t) = t² (3 - 2 t): a cubic, so every period sees the same command.
            for k in 1..=(1.0 / period).round() as u32 {
                let t = f64::from(k) * period;
                let command = Motion {
                    position: t * t * (3.0 - 2.0 * t),
                    velocity: 6.0 * t * (1.0 - t),
                    acceleration: 6.0 - 12.0 * t,
                };
                drive.cycle(command, period);
            }
            drive.error()
        };
        let reference = run(0.000_25);
        for period in [0.001, 0.004, 0.025] {
            assert!(
                (run(period) - reference).abs() < 1e-12,
                "{period}: {} {reference}",
                run(period)
            );
        }
    }

    #[test]
    fn full_feedforward_and_ideal_drives_have_no_error() {
        for mut drive in [Drive::servo(0.0, 40.0, 1.0), Drive::ideal(0.0)] {
            for k in 1..100 {
                let command = at_speed(k, PERIOD, 300.0);
                drive.cycle(command, PERIOD);
                assert_eq!((drive.error(), drive.actual()), (0.0, command));
            }
        }
    }

    #[test]
    fn an_error_decays_with_the_gain_and_can_be_asked_for_backwards() {
        let mut drive = Drive::servo(0.0, 40.0, 0.0);
        drive.cycle(at_speed(1, PERIOD, 100.0), PERIOD);
        let at = Motion {
            velocity: 0.0,
            ..at_speed(1, PERIOD, 100.0)
        };
        drive.cycle(at, PERIOD);
        let before = drive.error();
        drive.cycle(at, PERIOD);
        assert!((drive.error() - before * libm::exp(-TAU * 40.0 * PERIOD)).abs() < 1e-15);
        assert!((drive.error_before(PERIOD) - before).abs() < 1e-12);
    }

    #[test]
    fn a_coasting_axis_comes_to_rest_and_takes_the_command_along() {
        let mut drive = Drive::servo(0.0, 40.0, 0.0);
        for k in 1..200 {
            drive.cycle(at_speed(k, PERIOD, 100.0), PERIOD);
        }
        let from = drive.actual();
        for _ in 0..4000 {
            assert_eq!(drive.coast(PERIOD), drive.actual());
        }
        let now = drive.actual();
        assert_eq!((now.velocity, drive.error()), (0.0, 0.0));
        assert!((now.position - from.position - 100.0 * COAST_TIME_CONSTANT).abs() < 0.1);
        drive.halt();
        assert_eq!(drive.actual().position, now.position);
    }
}
