//! What a move of a trajectory is to keep along the path. Not the limits of the axes: [`crate::AxisLimits`].

/// The programmed speed and rates of one move.
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

    /// The lesser of each.
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
