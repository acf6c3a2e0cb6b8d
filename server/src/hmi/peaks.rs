//! The peaks of one axis while a simulation runs, and the limits of it that they exceed. Position units, per s, s² and s³.
//!
//! The jerk of a tick is the change of acceleration over it. It counts against Maximum Acceleration Jerk and Maximum
//! Deceleration Jerk, as in Logix, only for S-curves: a trapezoid steps, and no maximum is meant for that.

use std::fmt;

use arcline_controller::machine::{Axis, Travel};
use arcline_instruction_set::{Call, enumerations};

/// Share by which a peak may be above its limit: what rounding leaves.
const ROUNDING: f64 = 1e-6;
/// That of a jerk: two positions far from 0 leave more of it.
const JERK_ROUNDING: f64 = 1e-4;

/// How the acceleration of what an instruction begins changes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Shape {
    /// By a jerk.
    SCurve,
    /// In steps.
    Trapezoid,
}

impl Shape {
    /// What an instruction says; `None`: it has no profile.
    pub(super) fn of(call: &Call) -> Option<Self> {
        let place = call.instruction().operand("Profile")?;
        let curve = enumerations::PROFILE.parse_word("S-curve").map(f64::from);
        Some(if Some(call.number(place)) == curve {
            Self::SCurve
        } else {
            Self::Trapezoid
        })
    }
}

/// What an axis has reached.
#[derive(Clone, Debug, Default)]
pub(super) struct Peaks {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    before: Option<Row>,
    /// Of what moves the axis, in this tick and the one before: a trapezoid, if there is one.
    shapes: [Option<Shape>; 2],
}

/// An axis at the end of a tick.
#[derive(Clone, Copy, Debug)]
struct Row {
    position: f64,
    velocity: f64,
    acceleration: f64,
}

impl Row {
    fn stands(self) -> bool {
        self.velocity == 0.0 && self.acceleration == 0.0
    }

    fn brakes(self) -> bool {
        self.velocity * self.acceleration < 0.0
    }
}

/// A limit that is exceeded, and by what.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Exceeded {
    Speed { is: f64, limit: f64 },
    Acceleration { is: f64, limit: f64 },
    Deceleration { is: f64, limit: f64 },
    Jerk { is: f64, limit: f64 },
    Travel { is: f64, travel: Travel },
}

impl fmt::Display for Exceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Speed { is, limit } => write!(f, "speed {is:.6} above {limit}"),
            Self::Acceleration { is, limit } => write!(f, "acceleration {is:.6} above {limit}"),
            Self::Deceleration { is, limit } => write!(f, "deceleration {is:.6} above {limit}"),
            Self::Jerk { is, limit } => write!(f, "jerk {is:.6} above {limit}"),
            Self::Travel { is, travel } => write!(f, "position {is:.6} outside {} to {}", travel.min, travel.max),
        }
    }
}

impl Peaks {
    /// Something with a profile moves the axis in this tick.
    pub(super) fn follows(&mut self, shape: Shape) {
        self.shapes[0] = self.shapes[0].max(Some(shape));
    }

    /// Takes the position, velocity and acceleration at the end of a tick; gives a limit that they exceed.
    pub(super) fn look(
        &mut self,
        axis: &Axis,
        [position, velocity, acceleration, _]: [f64; 4],
        period: f64,
    ) -> Option<Exceeded> {
        let now = Row {
            position,
            velocity,
            acceleration,
        };
        let before = self.before.replace(now);
        let jerk = before.map_or(0.0, |before| (acceleration - before.acceleration).abs() / period);
        self.velocity = self.velocity.max(velocity.abs());
        self.acceleration = self.acceleration.max(acceleration.abs());
        self.jerk = self.jerk.max(jerk);
        let shape = self.shapes[0].max(self.shapes[1]);
        self.shapes = [None, self.shapes[0]];
        let above = |is: f64, limit: f64| is > limit * (1.0 + ROUNDING);
        if above(velocity.abs(), axis.max_speed) {
            return Some(Exceeded::Speed {
                is: velocity,
                limit: axis.max_speed,
            });
        }
        let is = acceleration.abs();
        if now.brakes() && above(is, axis.max_deceleration) {
            let limit = axis.max_deceleration;
            return Some(Exceeded::Deceleration { is, limit });
        }
        if !now.brakes() && above(is, axis.max_acceleration) {
            let limit = axis.max_acceleration;
            return Some(Exceeded::Acceleration { is, limit });
        }
        if shape == Some(Shape::SCurve) {
            // A tick in which it begins to brake has both.
            let limits = [Some(now), before].map(|row| match row {
                Some(row) if row.brakes() => axis.max_deceleration_jerk,
                Some(row) if !row.stands() => axis.max_acceleration_jerk,
                _ => 0.0,
            });
            let limit = limits[0].max(limits[1]);
            if limit > 0.0 && jerk > limit * (1.0 + JERK_ROUNDING) {
                return Some(Exceeded::Jerk { is: jerk, limit });
            }
        }
        let moved = before.is_none_or(|before| before.position != position);
        let travel = axis.travel.filter(|_| moved && axis.start.homed);
        let outside = travel.filter(|travel| !(travel.min - ROUNDING..=travel.max + ROUNDING).contains(&position));
        outside.map(|travel| Exceeded::Travel { is: position, travel })
    }

    /// Where it was at the newest tick.
    pub(super) fn position(&self) -> Option<f64> {
        self.before.map(|row| row.position)
    }

    /// The highest speed.
    pub(super) fn velocity(&self) -> f64 {
        self.velocity
    }

    /// The highest acceleration, either way.
    pub(super) fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// The highest jerk, either way.
    pub(super) fn jerk(&self) -> f64 {
        self.jerk
    }
}
