//! What a geometry computes with: plain numbers, or numbers that move.
//!
//! Every transform is written once over [`Number`]. With `f64` it maps a position; with [`Moving`] it maps position,
//! velocity and acceleration together, by the rules of differentiation and not by differences. Units: those of the
//! number, seconds.

use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or one together with its change over time.
pub trait Number:
    Copy
    + fmt::Debug
    + PartialEq
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// How near to the axis of its first joint an arm may be, as a share of its reach: what moves needs finite joint
    /// speeds.
    const NEAREST: f64;

    /// How far from stretched or folded two links must be: the least `1 - |cos|` of the angle between them. Below 0 is
    /// rounding.
    const LEAST_BEND: f64;

    /// One that does not change.
    fn constant(value: f64) -> Self;

    /// What it is now.
    fn value(self) -> f64;

    /// Square root; the number must be above 0 where it moves.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);

    /// The angle of the direction (`x`, `self`), radians, above -pi up to pi.
    #[must_use]
    fn atan2(self, x: Self) -> Self;

    /// Whether nothing of it is infinite or not a number.
    fn is_finite(self) -> bool;
}

impl Number for f64 {
    const NEAREST: f64 = 1e-9;
    const LEAST_BEND: f64 = -1e-9;

    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }

    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }

    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
}

/// A number with its first and second derivative in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moving {
    /// What it is now.
    pub position: f64,
    /// Per second.
    pub velocity: f64,
    /// Per second squared.
    pub acceleration: f64,
}

impl Moving {
    /// At rest.
    #[must_use]
    pub fn standing(position: f64) -> Self {
        Moving {
            position,
            ..Moving::default()
        }
    }
}

impl Number for Moving {
    const NEAREST: f64 = 1e-6;
    const LEAST_BEND: f64 = 1e-6;

    fn constant(position: f64) -> Self {
        Moving::standing(position)
    }

    fn value(self) -> f64 {
        self.position
    }

    fn sqrt(self) -> Self {
        let root = self.position.sqrt();
        if self.velocity == 0.0 && self.acceleration == 0.0 {
            return Moving::constant(root);
        }
        let velocity = self.velocity / (2.0 * root);
        Moving {
            position: root,
            velocity,
            acceleration: (self.acceleration - 2.0 * velocity * velocity) / (2.0 * root),
        }
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.position);
        let square = self.velocity * self.velocity;
        let moving = |position: f64, slope: f64| Moving {
            position,
            velocity: slope * self.velocity,
            acceleration: slope * self.acceleration - position * square,
        };
        (moving(sin, cos), moving(cos, -sin))
    }

    fn atan2(self, x: Self) -> Self {
        let y = self;
        let position = libm::atan2(y.position, x.position);
        let turns = |a: f64, b: f64| x.position * a - y.position * b;
        let (first, second) = (turns(y.velocity, x.velocity), turns(y.acceleration, x.acceleration));
        if first == 0.0 && second == 0.0 {
            return Moving::constant(position);
        }
        let square = x.position * x.position + y.position * y.position;
        let change = 2.0 * (x.position * x.velocity + y.position * y.velocity);
        Moving {
            position,
            velocity: first / square,
            acceleration: (second - first * change / square) / square,
        }
    }

    fn is_finite(self) -> bool {
        self.position.is_finite() && self.velocity.is_finite() && self.acceleration.is_finite()
    }
}

impl Add for Moving {
    type Output = Moving;

    fn add(self, other: Moving) -> Moving {
        Moving {
            position: self.position + other.position,
            velocity: self.velocity + other.velocity,
            acceleration: self.acceleration + other.acceleration,
        }
    }
}

impl Sub for Moving {
    type Output = Moving;

    fn sub(self, other: Moving) -> Moving {
        self + -other
    }
}

impl Neg for Moving {
    type Output = Moving;

    fn neg(self) -> Moving {
        self * -1.0
    }
}

impl Mul for Moving {
    type Output = Moving;

    fn mul(self, other: Moving) -> Moving {
        Moving {
            position: self.position * other.position,
            velocity: self.velocity * other.position + self.position * other.velocity,
            acceleration: self.acceleration * other.position
                + 2.0 * self.velocity * other.velocity
                + self.position * other.acceleration,
        }
    }
}

impl Div for Moving {
    type Output = Moving;

    fn div(self, other: Moving) -> Moving {
        let inverse = 1.0 / other.position;
        let position = self.position * inverse;
        let velocity = (self.velocity - position * other.velocity) * inverse;
        Moving {
            position,
            velocity,
            acceleration: (self.acceleration - 2.0 * velocity * other.velocity - position * other.acceleration)
                * inverse,
        }
    }
}

impl Add<f64> for Moving {
    type Output = Moving;

    fn add(self, other: f64) -> Moving {
        Moving {
            position: self.position + other,
            ..self
        }
    }
}

impl Sub<f64> for Moving {
    type Output = Moving;

    fn sub(self, other: f64) -> Moving {
        self + -other
    }
}

impl Mul<f64> for Moving {
    type Output = Moving;

    fn mul(self, factor: f64) -> Moving {
        Moving {
            position: self.position * factor,
            velocity: self.velocity * factor,
            acceleration: self.acceleration * factor,
        }
    }
}

/// The square root of what only rounding can make negative.
pub(crate) fn root<N: Number>(square: N) -> N {
    if square.value() > 0.0 {
        square.sqrt()
    } else {
        N::constant(0.0)
    }
}
