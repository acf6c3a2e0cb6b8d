//! The numbers of a geometry: plain numbers, or numbers with derivatives by time.
//!
//! Every transform is written once over [`Number`]. With `f64` it maps a position; with [`KinematicState`] it maps position,
//! velocity and acceleration together, by the rules of differentiation and not by differences. Units: those of the
//! number, seconds.

use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

use arcline_profile::KinematicState;

use crate::tolerance::{
    LEAST_BEND_AT_REST_SHARE, LEAST_BEND_IN_MOTION_SHARE, NEAREST_AT_REST_SHARE, NEAREST_IN_MOTION_SHARE,
};

/// A real number, alone or with its derivatives by time.
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
    /// The least distance of an arm from the axis of its first joint, as a share of its reach: during a motion the joint speeds must be finite.
    const NEAREST_SHARE: f64;

    /// The least bend of two links from stretched or folded: the least `1 - |cos|` of the angle between them, or the same share of
    /// the squares of which it is a quotient. A negative value permits
    /// rounding.
    const LEAST_BEND_SHARE: f64;

    /// A constant number.
    fn constant(value: f64) -> Self;

    /// Its present value.
    fn value(self) -> f64;

    /// Square root; a number with derivatives must be above 0.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);

    /// The angle of the direction (`x`, `self`), radians, above -pi up to pi.
    #[must_use]
    fn atan2(self, x: Self) -> Self;

    /// The value and its derivatives are finite.
    fn is_finite(self) -> bool;
}

impl Number for f64 {
    const NEAREST_SHARE: f64 = NEAREST_AT_REST_SHARE;
    const LEAST_BEND_SHARE: f64 = LEAST_BEND_AT_REST_SHARE;

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

impl Number for KinematicState {
    const NEAREST_SHARE: f64 = NEAREST_IN_MOTION_SHARE;
    const LEAST_BEND_SHARE: f64 = LEAST_BEND_IN_MOTION_SHARE;

    fn constant(position: f64) -> Self {
        KinematicState::at_rest(position)
    }

    fn value(self) -> f64 {
        self.position
    }

    fn sqrt(self) -> Self {
        let root = self.position.sqrt();
        if self.velocity == 0.0 && self.acceleration == 0.0 {
            return KinematicState::constant(root);
        }
        let velocity = self.velocity / (2.0 * root);
        KinematicState {
            position: root,
            velocity,
            acceleration: (self.acceleration - 2.0 * velocity * velocity) / (2.0 * root),
        }
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.position);
        let square = self.velocity * self.velocity;
        let moving = |position: f64, slope: f64| KinematicState {
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
            return KinematicState::constant(position);
        }
        let square = x.position * x.position + y.position * y.position;
        let change = 2.0 * (x.position * x.velocity + y.position * y.velocity);
        KinematicState {
            position,
            velocity: first / square,
            acceleration: (second - first * change / square) / square,
        }
    }

    fn is_finite(self) -> bool {
        self.position.is_finite() && self.velocity.is_finite() && self.acceleration.is_finite()
    }
}

/// The square root of a number that only rounding can make negative.
pub(crate) fn root<N: Number>(square: N) -> N {
    if square.value() > 0.0 {
        square.sqrt()
    } else {
        N::constant(0.0)
    }
}
