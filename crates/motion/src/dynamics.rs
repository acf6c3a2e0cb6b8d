//! From programmed speeds, rates and jerks to the limits of a profile
//! (spec/coordinated-instructions.md §4.5, §5.3).

use arcline_instruction_set::enumerations::{JerkUnits, RateUnits, SpeedUnits};
use arcline_profile::{Jerk, Limits, jerk_from_percent_of_time};

use crate::machine::{Axis, CoordinateSystem};

/// The properties that the units of speeds, rates and jerks share.
pub(crate) trait Units: Copy {
    /// The number is a percentage of the maximum.
    fn is_percent_of_maximum(self) -> bool;

    /// The number is in master units instead of seconds.
    fn is_master_driven(self) -> bool;

    /// The unit of the number if it is a duration.
    fn duration(self) -> Option<Duration>;
}

/// The unit of the duration of a move or of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Duration {
    Seconds,
    MasterUnits,
}

macro_rules! units {
    ($($units:ident by_master $($driven:ident)|+;)*) => {$(
        impl Units for $units {
            fn is_percent_of_maximum(self) -> bool {
                self == Self::PercentOfMaximum
            }

            fn is_master_driven(self) -> bool {
                matches!(self, $(Self::$driven)|+)
            }

            fn duration(self) -> Option<Duration> {
                match self {
                    Self::Seconds => Some(Duration::Seconds),
                    Self::MasterUnits => Some(Duration::MasterUnits),
                    _ => None,
                }
            }
        }
    )*};
}

units! {
    SpeedUnits by_master UnitsPerMasterUnit | MasterUnits;
    RateUnits by_master UnitsPerMasterUnit2 | MasterUnits;
    JerkUnits by_master UnitsPerMasterUnit3 | PercentOfTimeMasterDriven | MasterUnits;
}

/// The maxima of an axis or, along the path, of a coordinate system: units/s, units/s², units/s³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Maxima {
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) deceleration: f64,
    pub(crate) acceleration_jerk: f64,
    pub(crate) deceleration_jerk: f64,
}

impl Maxima {
    /// The limits of a stop at the Maximum Deceleration; of an S-curve, also at the Maximum Deceleration Jerk.
    pub(crate) fn stop(&self, s_curve: bool) -> Limits {
        stop_limits(self.speed, self.deceleration, s_curve.then_some(self.deceleration_jerk))
    }
}

/// The limits of a stop; a present acceleration ramps down with the rate and jerk of the deceleration. `jerk` is set for an S-curve.
pub(crate) fn stop_limits(speed: f64, deceleration: f64, jerk: Option<f64>) -> Limits {
    Limits {
        speed,
        acceleration: deceleration,
        deceleration,
        jerk: jerk.map(|jerk| Jerk {
            acceleration: jerk,
            deceleration: jerk,
        }),
    }
}

impl From<&Axis> for Maxima {
    fn from(axis: &Axis) -> Self {
        Maxima {
            speed: axis.max_speed,
            acceleration: axis.max_acceleration,
            deceleration: axis.max_deceleration,
            acceleration_jerk: axis.max_acceleration_jerk,
            deceleration_jerk: axis.max_deceleration_jerk,
        }
    }
}

impl From<&CoordinateSystem> for Maxima {
    fn from(system: &CoordinateSystem) -> Self {
        Maxima {
            speed: system.max_speed,
            acceleration: system.max_acceleration,
            deceleration: system.max_deceleration,
            acceleration_jerk: system.max_acceleration_jerk,
            deceleration_jerk: system.max_deceleration_jerk,
        }
    }
}

/// The limits of the motion along a path that keep the joints of robots within theirs; infinite if no joint limits it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathLimits {
    /// Along the path, units/s.
    pub(crate) speed: f64,
    /// Along the path, units/s².
    pub(crate) acceleration: f64,
    /// Along the path, units/s².
    pub(crate) deceleration: f64,
}

impl PathLimits {
    pub(crate) const UNLIMITED: PathLimits = PathLimits {
        speed: f64::INFINITY,
        acceleration: f64::INFINITY,
        deceleration: f64::INFINITY,
    };

    /// The lower limit of each pair.
    pub(crate) fn and(&self, other: &PathLimits) -> PathLimits {
        PathLimits {
            speed: self.speed.min(other.speed),
            acceleration: self.acceleration.min(other.acceleration),
            deceleration: self.deceleration.min(other.deceleration),
        }
    }

    /// The limits over the displacement of a master at `nominal` master units/s (more than 0): units per master unit, and per master
    /// unit squared.
    pub(crate) fn by_master(&self, nominal: f64) -> PathLimits {
        PathLimits {
            speed: self.speed / nominal,
            acceleration: self.acceleration / (nominal * nominal),
            deceleration: self.deceleration / (nominal * nominal),
        }
    }
}

/// A jerk as programmed; one in percent of time depends on the speed and the rate, and changes with them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum JerkRate {
    /// Units/s³.
    Units(f64),
    /// Percent of the ramp time that is jerk-limited.
    PercentOfTime(f64),
}

/// The shape of the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ProgrammedProfile {
    /// Profile 0; jerks are stored without effect.
    Trapezoidal(Jerks),
    /// Profile 1.
    SCurve(Jerks),
}

/// Accel Jerk and Decel Jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jerks {
    pub(crate) acceleration: JerkRate,
    pub(crate) deceleration: JerkRate,
}

/// The dynamics of one move: units/s, units/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dynamics {
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) deceleration: f64,
    pub(crate) shape: ProgrammedProfile,
    /// The speed from which a jerk in percent of time is calculated while the move's own speed is 0.
    pub(crate) last_speed: f64,
}

impl Dynamics {
    /// The limits of a profile, as programmed.
    pub(crate) fn limits(&self) -> Limits {
        let jerk = match self.shape {
            ProgrammedProfile::Trapezoidal(_) => None,
            ProgrammedProfile::SCurve(jerks) => Some(Jerk {
                acceleration: self.jerk(jerks.acceleration, self.acceleration),
                deceleration: self.jerk(jerks.deceleration, self.deceleration),
            }),
        };
        Limits {
            speed: self.speed,
            acceleration: self.acceleration,
            deceleration: self.deceleration,
            jerk,
        }
    }

    /// The limits of a jog from one velocity to another, both with a sign. A jerk in percent of time limits at least that share of each ramp,
    /// whatever speed the ramp begins at (spec/axis-and-data-types.md §10.3).
    pub(crate) fn jog_limits(&self, from: f64, to: f64) -> Limits {
        let mut limits = self.limits();
        let reference = to.abs().max((from - to).abs());
        if let (ProgrammedProfile::SCurve(jerks), Some(jerk), true) = (self.shape, &mut limits.jerk, reference > 0.0) {
            jerk.deceleration = resolve(jerks.deceleration, reference, self.deceleration);
        }
        limits
    }

    /// Takes a new speed; jerks in percent of time depend on the last one that was not 0.
    pub(crate) fn set_speed(&mut self, speed: f64) {
        self.speed = speed;
        if speed > 0.0 {
            self.last_speed = speed;
        }
    }

    /// Continues at the speed of the merged motion; jerks in percent of time still depend on the instruction's own speed
    /// (spec/coordinated-instructions.md §5.3, §6.4).
    pub(crate) fn keep_speed(&mut self, speed: f64) {
        self.speed = speed;
    }

    /// Lowers the dynamics to the limits that the joints of robots set; jerks in percent of time follow.
    pub(crate) fn keep_to(&mut self, limits: &PathLimits) {
        if limits.speed < self.speed {
            self.set_speed(limits.speed);
        }
        self.acceleration = self.acceleration.min(limits.acceleration);
        self.deceleration = self.deceleration.min(limits.deceleration);
    }

    pub(crate) fn is_s_curve(&self) -> bool {
        matches!(self.shape, ProgrammedProfile::SCurve(_))
    }

    pub(crate) fn jerks_mut(&mut self) -> &mut Jerks {
        match &mut self.shape {
            ProgrammedProfile::Trapezoidal(jerks) | ProgrammedProfile::SCurve(jerks) => jerks,
        }
    }

    fn jerk(&self, jerk: JerkRate, rate: f64) -> f64 {
        resolve(jerk, self.last_speed, rate)
    }
}

/// A programmed jerk in units/s³ for a ramp between rest and `speed` at `rate`.
pub(crate) fn resolve(jerk: JerkRate, speed: f64, rate: f64) -> f64 {
    match jerk {
        JerkRate::Units(jerk) => jerk,
        JerkRate::PercentOfTime(percent) => jerk_from_percent_of_time(speed, rate, percent),
    }
}

/// A programmed speed or rate in position units.
pub(crate) fn in_units(value: f64, units: impl Units, maximum: f64) -> f64 {
    if units.is_percent_of_maximum() {
        percent(value, maximum)
    } else {
        value
    }
}

/// A percentage of a maximum.
pub(crate) fn percent(value: f64, maximum: f64) -> f64 {
    value / 100.0 * maximum
}

/// A programmed jerk.
pub(crate) fn jerk_in_units(value: f64, units: JerkUnits, maximum: f64) -> JerkRate {
    match units {
        JerkUnits::PercentOfTime | JerkUnits::PercentOfTimeMasterDriven => JerkRate::PercentOfTime(value),
        _ => JerkRate::Units(in_units(value, units, maximum)),
    }
}

/// The speed that replaces a programmed speed of 0 in a jerk in percent of time.
pub(crate) fn speed_for_jerk(speed: f64, maximum: f64) -> f64 {
    if speed > 0.0 { speed } else { maximum }
}
