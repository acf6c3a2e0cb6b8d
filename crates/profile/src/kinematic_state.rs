//! Position, velocity and acceleration: one quantity with its first two derivatives by time.
//!
//! The arithmetic is that of functions of time: sums, products and quotients follow the rules of differentiation. Units: those of the quantity,
//! seconds.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::Phase;

/// Position (units), velocity (units/s) and acceleration (units/s²) at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KinematicState {
    /// Position units.
    pub position: f64,
    /// Position units per second.
    pub velocity: f64,
    /// Position units per second squared.
    pub acceleration: f64,
}

impl KinematicState {
    /// The state of an axis at rest at a position.
    #[must_use]
    pub fn at_rest(position: f64) -> Self {
        KinematicState {
            position,
            velocity: 0.0,
            acceleration: 0.0,
        }
    }

    /// The phase of the magnitude of the velocity.
    #[must_use]
    pub fn phase(&self) -> Phase {
        let rising = self.velocity * self.acceleration;
        if rising > 0.0 || (self.velocity == 0.0 && self.acceleration != 0.0) {
            Phase::Accelerating
        } else if rising < 0.0 {
            Phase::Decelerating
        } else {
            Phase::Steady
        }
    }
}

impl Add for KinematicState {
    type Output = KinematicState;

    fn add(self, other: KinematicState) -> KinematicState {
        KinematicState {
            position: self.position + other.position,
            velocity: self.velocity + other.velocity,
            acceleration: self.acceleration + other.acceleration,
        }
    }
}

impl Sub for KinematicState {
    type Output = KinematicState;

    fn sub(self, other: KinematicState) -> KinematicState {
        self + -other
    }
}

impl Neg for KinematicState {
    type Output = KinematicState;

    fn neg(self) -> KinematicState {
        self * -1.0
    }
}

impl Mul for KinematicState {
    type Output = KinematicState;

    fn mul(self, other: KinematicState) -> KinematicState {
        KinematicState {
            position: self.position * other.position,
            velocity: self.velocity * other.position + self.position * other.velocity,
            acceleration: self.acceleration * other.position
                + 2.0 * self.velocity * other.velocity
                + self.position * other.acceleration,
        }
    }
}

impl Div for KinematicState {
    type Output = KinematicState;

    fn div(self, other: KinematicState) -> KinematicState {
        let inverse = 1.0 / other.position;
        let position = self.position * inverse;
        let velocity = (self.velocity - position * other.velocity) * inverse;
        KinematicState {
            position,
            velocity,
            acceleration: (self.acceleration - 2.0 * velocity * other.velocity - position * other.acceleration)
                * inverse,
        }
    }
}

impl Add<f64> for KinematicState {
    type Output = KinematicState;

    fn add(self, other: f64) -> KinematicState {
        KinematicState {
            position: self.position + other,
            ..self
        }
    }
}

impl Sub<f64> for KinematicState {
    type Output = KinematicState;

    fn sub(self, other: f64) -> KinematicState {
        self + -other
    }
}

impl Mul<f64> for KinematicState {
    type Output = KinematicState;

    fn mul(self, factor: f64) -> KinematicState {
        KinematicState {
            position: self.position * factor,
            velocity: self.velocity * factor,
            acceleration: self.acceleration * factor,
        }
    }
}
