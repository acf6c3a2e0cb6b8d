//! The peaks of one axis while a simulation runs, and the limits of it that they exceed. Position units, per s, s² and s³.
//!
//! The jerk of a tick is the change of acceleration over it. It counts against Maximum Acceleration Jerk and Maximum
//! Deceleration Jerk, as in Logix, only for S-curves: a trapezoid steps, and no maximum is meant for that.

use arcline_controller::machine::{Axis, Travel};
use arcline_instruction_set::Call;
use arcline_instruction_set::enumerations::VelocityProfile;

/// The share by which rounding may lift a peak above its limit.
const ROUNDING: f64 = 1e-6;
/// The share for a jerk, whose rounding is greater: it is a difference of two positions far from 0.
const JERK_ROUNDING: f64 = 1e-4;

/// The change of acceleration in the motion that an instruction begins.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Shape {
    /// Acceleration changes by a jerk.
    SCurve,
    /// Acceleration changes in steps.
    Trapezoid,
}

impl Shape {
    /// The shape of an instruction's motion; `None`: the instruction has no profile.
    pub(super) fn of(call: &Call) -> Option<Self> {
        let place = call.instruction().operand("Profile")?;
        Some(if call.word(place) == VelocityProfile::SCurve as i32 {
            Self::SCurve
        } else {
            Self::Trapezoid
        })
    }
}

/// The peak values of an axis.
#[derive(Clone, Debug, Default)]
pub(super) struct Peaks {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    before: Option<Row>,
    /// The shapes of the motion on the axis, in this tick and the one before: a trapezoid, if there is one.
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

/// An exceeded limit and the excess.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Exceeded {
    Speed { is: f64, limit: f64 },
    Acceleration { is: f64, limit: f64 },
    Deceleration { is: f64, limit: f64 },
    Jerk { is: f64, limit: f64 },
    Travel { is: f64, travel: Travel },
}

impl Exceeded {
    /// The peak and its limit for a reader, in the units of the axis: `jerk 59438.1 mm/s³, maximum 42666.7 mm/s³`.
    pub(super) fn text(&self, units: &str) -> String {
        let rate = |what: &str, is: f64, limit: f64, per: &str| {
            let (is, limit) = apart(is.abs(), limit);
            format!("{what} {is} {units}/{per}, maximum {limit} {units}/{per}")
        };
        match *self {
            Self::Speed { is, limit } => rate("speed", is, limit, "s"),
            Self::Acceleration { is, limit } => rate("acceleration", is, limit, "s²"),
            Self::Deceleration { is, limit } => rate("deceleration", is, limit, "s²"),
            Self::Jerk { is, limit } => rate("jerk", is, limit, "s³"),
            Self::Travel { is, travel } => {
                let (is, _) = apart(is, if is > travel.max { travel.max } else { travel.min });
                format!("position {is} {units}, travel {} to {} {units}", travel.min, travel.max)
            }
        }
    }
}

/// Two numbers in six significant digits, or in as many as distinguish them.
fn apart(is: f64, limit: f64) -> (String, String) {
    let digits = (6..=17).find(|digits| figures(is, *digits) != figures(limit, *digits));
    let digits = digits.unwrap_or(17);
    (figures(is, digits), figures(limit, digits))
}

/// A number in significant digits, without zeros behind the last one.
fn figures(number: f64, digits: i32) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let decimals = (digits - 1 - number.abs().log10().floor() as i32).clamp(0, 17);
    let text = format!("{number:.*}", decimals as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

impl Peaks {
    /// A motion with a profile moves the axis in this tick.
    pub(super) fn follows(&mut self, shape: Shape) {
        self.shapes[0] = self.shapes[0].max(Some(shape));
    }

    /// Takes the position, velocity and acceleration at the end of a tick; gives a limit that they exceed.
    pub(super) fn exceeded(
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

    /// The position of the axis at the newest tick.
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
