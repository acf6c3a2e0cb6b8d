//! The limits of a motion: the programmed rates of its moves, and the limits of the axes.

use crate::{ContourMove, Point};

/// The limits of each axis; infinite for an axis without one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLimits {
    /// Position units / s.
    pub speed: Point,
    /// Position units / s².
    pub acceleration: Point,
    /// Position units / s³, kept by S-curves. `None`: no limit.
    pub jerk: Option<Point>,
}

/// The programmed speed and rates of one move along its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Vector speed, position units / s.
    pub speed: f64,
    /// Vector acceleration, position units / s².
    pub acceleration: f64,
    /// Vector deceleration, position units / s².
    pub deceleration: f64,
    /// Vector jerk, position units / s³; `None`: a trapezoid.
    pub jerk: Option<f64>,
}

impl Rates {
    pub(crate) const UNLIMITED: Rates = Rates {
        speed: f64::INFINITY,
        acceleration: f64::INFINITY,
        deceleration: f64::INFINITY,
        jerk: None,
    };

    /// The lower rate of each pair.
    pub(crate) fn least(self, other: &Rates) -> Rates {
        Rates {
            speed: self.speed.min(other.speed),
            acceleration: self.acceleration.min(other.acceleration),
            deceleration: self.deceleration.min(other.deceleration),
            jerk: match (self.jerk, other.jerk) {
                (Some(one), Some(two)) => Some(one.min(two)),
                (one, two) => one.or(two),
            },
        }
    }
}

/// The smoothness of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Smoothness {
    /// The acceleration may jump.
    Trapezoid,
    /// The jerk may jump.
    SCurve,
}

impl Smoothness {
    /// The smoothness of a section: an S-curve if any of its moves is one.
    pub(crate) fn of(moves: &[ContourMove]) -> Smoothness {
        if moves.iter().any(|m| m.jerk.is_some()) {
            Smoothness::SCurve
        } else {
            Smoothness::Trapezoid
        }
    }
}

/// All limits of one move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoveLimits {
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) deceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) axes: AxisLimits,
}

impl MoveLimits {
    pub(crate) fn new(one: &ContourMove, axes: &AxisLimits, smoothness: Smoothness) -> MoveLimits {
        let scurve = smoothness == Smoothness::SCurve;
        MoveLimits {
            speed: one.speed,
            acceleration: one.acceleration,
            deceleration: one.deceleration,
            jerk: one.jerk.filter(|_| scurve).unwrap_or(f64::INFINITY),
            axes: AxisLimits {
                jerk: axes.jerk.filter(|_| scurve),
                ..*axes
            },
        }
    }

    /// The magnitude of the acceleration in any direction: the larger of the two rates.
    pub(crate) fn norm_acceleration(&self) -> f64 {
        self.acceleration.max(self.deceleration)
    }

    /// The same limits without those of the jerk.
    pub(crate) fn without_jerk(&self) -> MoveLimits {
        MoveLimits {
            jerk: f64::INFINITY,
            axes: AxisLimits {
                jerk: None,
                ..self.axes
            },
            ..*self
        }
    }

    /// The least jerk limit of all.
    pub(crate) fn least_jerk(&self) -> f64 {
        self.axes.jerk.map_or(self.jerk, |axes| self.jerk.min(axes.min()))
    }
}
