//! Limits of a profile, as programmed and as the planner uses them; jerk in per cent of time.

/// Limits of speed, acceleration and jerk, all above 0. A speed of 0 is a pause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Position units per second.
    pub speed: f64,
    /// While speeding up, position units per second squared.
    pub acceleration: f64,
    /// While slowing down, position units per second squared.
    pub deceleration: f64,
    /// `None` for a trapezoidal profile.
    pub jerk: Option<Jerk>,
}

/// Limits of jerk, position units per second cubed, above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jerk {
    /// While speeding up, for raising and for lowering the acceleration.
    pub acceleration: f64,
    /// While slowing down, both ways.
    pub deceleration: f64,
}

/// Jerk (position units per second cubed) for a share of the ramp time in per cent, `0 < percent <=
/// 100`: `a^2/v (200/p - 1)` with the programmed speed and acceleration (or deceleration)
/// (spec/motion-core.md §4).
#[must_use]
pub fn jerk_from_percent_of_time(speed: f64, acceleration: f64, percent: f64) -> f64 {
    acceleration * acceleration / speed * (200.0 / percent - 1.0)
}

/// Limits for the S-curve's arithmetic: positive, finite, of a size whose products stay finite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SCurve {
    pub(crate) speed: f64,
    /// While speeding up.
    pub(crate) up: Side,
    /// While slowing down.
    pub(crate) down: Side,
}

/// Acceleration and jerk of one sign of speeding up, with their reciprocals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// Largest acceleration.
    pub(crate) most: f64,
    pub(crate) jerk: f64,
    /// `1 / most`
    pub(crate) per_most: f64,
    /// `1 / jerk`
    pub(crate) per_jerk: f64,
}

impl Side {
    fn new(most: f64, jerk: f64) -> Side {
        Side {
            most,
            jerk,
            per_most: 1.0 / most,
            per_jerk: 1.0 / jerk,
        }
    }
}

/// Limits of a trapezoid, sanitised as those of [`SCurve`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trapezoid {
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) deceleration: f64,
    /// `1 / acceleration`
    pub(crate) per_acceleration: f64,
    /// `1 / deceleration`
    pub(crate) per_deceleration: f64,
}

pub(crate) enum ProfileShape {
    Trapezoid(Trapezoid),
    SCurve(SCurve),
}

impl Limits {
    pub(crate) fn shape(&self) -> ProfileShape {
        let speed = sane(self.speed).max(0.0);
        let acceleration = sane_limit(self.acceleration);
        let deceleration = sane_limit(self.deceleration);
        let trapezoid = ProfileShape::Trapezoid(Trapezoid {
            speed,
            acceleration,
            deceleration,
            per_acceleration: 1.0 / acceleration,
            per_deceleration: 1.0 / deceleration,
        });
        let Some(jerk) = self.jerk else {
            return trapezoid;
        };
        let most = (acceleration * FASTEST_RISE).min(LARGEST_JERK);
        let most_down = (deceleration * FASTEST_RISE).min(LARGEST_JERK);
        if jerk.acceleration > most && jerk.deceleration > most_down {
            return trapezoid;
        }
        ProfileShape::SCurve(SCurve {
            speed,
            up: Side::new(acceleration, sane_limit(jerk.acceleration).min(most).max(SMALLEST)),
            down: Side::new(deceleration, sane_limit(jerk.deceleration).min(most_down).max(SMALLEST)),
        })
    }
}

/// A finite number of bounded size; NaN becomes 0.
pub(crate) fn sane(value: f64) -> f64 {
    if value.is_nan() || value.abs() < SMALLEST {
        0.0
    } else {
        value.clamp(-LARGEST, LARGEST)
    }
}

/// The displacement between two positions; one so short that its products would vanish is 0.
pub(crate) fn displacement(from: f64, to: f64) -> f64 {
    let displacement = to - from;
    if displacement.abs() < SMALLEST {
        0.0
    } else {
        displacement
    }
}

fn sane_limit(value: f64) -> f64 {
    if value.is_nan() {
        SMALLEST
    } else {
        value.clamp(SMALLEST, LARGEST)
    }
}

/// Magnitudes whose products in a plan stay finite.
const LARGEST: f64 = 1e30;
const SMALLEST: f64 = 1e-30;
/// A profile that reaches its acceleration within the inverse of this (s) counts as a trapezoid (spec/motion-core.md §4).
const FASTEST_RISE: f64 = 1e9;
/// A profile with a jerk above this counts as a trapezoid (spec/motion-core.md §4).
const LARGEST_JERK: f64 = 1e15;
