//! Speed, rates and jerks as operands: what moves and jogs are programmed with, and what MCCD and MCD change.
//!
//! Not here: what becomes of them, and MAM's durations in seconds.

use arcline_instruction_set::{Call, Mnemonic, MotionError, OperandIndex};
use arcline_planner::Pace;
use arcline_planner::profile::{Limits, stop_distance};

use super::place;
use crate::dynamics::{Dynamics, JerkRate, Jerks, Maxima, Shape, in_units, jerk_in_units, reference_speed};
use crate::masters::guide::Guide;
use crate::masters::links::MasterLink;
use crate::masters::master::{LockTo, Sense};
use crate::motion::Motion;
use crate::rotary::Turn;
use crate::system::Lead;
use crate::verify::is_master_driven;

/// Profile: S-curve.
const S_CURVE: i32 = 1;

/// Places of magnitudes and of their units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rates {
    pub(super) speed: usize,
    pub(super) speed_units: usize,
    pub(super) accel_rate: usize,
    pub(super) accel_units: usize,
    pub(super) decel_rate: usize,
    pub(super) decel_units: usize,
    pub(super) accel_jerk: usize,
    pub(super) decel_jerk: usize,
    pub(super) jerk_units: usize,
}

impl Rates {
    fn of(mnemonic: Mnemonic) -> Self {
        let place = |name| place(mnemonic, name);
        Rates {
            speed: place("Speed"),
            speed_units: place("Speed Units"),
            accel_rate: place("Accel Rate"),
            accel_units: place("Accel Units"),
            decel_rate: place("Decel Rate"),
            decel_units: place("Decel Units"),
            accel_jerk: place("Accel Jerk"),
            decel_jerk: place("Decel Jerk"),
            jerk_units: place("Jerk Units"),
        }
    }

    fn speed(&self, call: &Call, maxima: &Maxima) -> f64 {
        in_units(call.number(self.speed), call.word(self.speed_units), maxima.speed)
    }

    fn acceleration(&self, call: &Call, maxima: &Maxima) -> f64 {
        let units = call.word(self.accel_units);
        in_units(call.number(self.accel_rate), units, maxima.acceleration)
    }

    fn deceleration(&self, call: &Call, maxima: &Maxima) -> f64 {
        let units = call.word(self.decel_units);
        in_units(call.number(self.decel_rate), units, maxima.deceleration)
    }

    fn jerks(&self, call: &Call, maxima: &Maxima) -> Jerks {
        let jerk = |value, maximum| jerk_in_units(call.number(value), call.word(self.jerk_units), maximum);
        Jerks {
            acceleration: jerk(self.accel_jerk, maxima.acceleration_jerk),
            deceleration: jerk(self.decel_jerk, maxima.deceleration_jerk),
        }
    }

    /// A percentage of a maximum that is 0 leaves nothing to move with.
    fn verify(&self, dynamics: &Dynamics) -> Result<(), MotionError> {
        positive(dynamics.acceleration, self.accel_rate)?;
        positive(dynamics.deceleration, self.decel_rate)?;
        if let Some(jerk) = dynamics.limits().jerk {
            positive(jerk.acceleration, self.accel_jerk)?;
            positive(jerk.deceleration, self.decel_jerk)?;
        }
        Ok(())
    }
}

/// Places of the operands that say how something moves: MCLM, MCCM, MAM, MAJ.
#[derive(Clone, Copy, Debug)]
pub(super) struct DynamicsLayout {
    pub(super) rates: Rates,
    profile: usize,
    lock: LockLayout,
}

/// Places of the operands that say how something is locked to a master: those of [`DynamicsLayout`], and MATC's.
#[derive(Clone, Copy, Debug)]
pub(super) struct LockLayout {
    position: usize,
    direction: usize,
}

/// Lock Direction, from 1 on: at once forward and reverse, and at a position forward and reverse.
const IMMEDIATE_REVERSE: i32 = 2;
const POSITION_FORWARD: i32 = 3;
const POSITION_REVERSE: i32 = 4;

impl DynamicsLayout {
    pub(super) fn of(mnemonic: Mnemonic) -> Self {
        DynamicsLayout {
            rates: Rates::of(mnemonic),
            profile: place(mnemonic, "Profile"),
            lock: LockLayout::of(mnemonic),
        }
    }

    pub(super) fn is_s_curve(&self, call: &Call) -> bool {
        call.word(self.profile) == S_CURVE
    }

    /// The shape with these jerks.
    pub(super) fn shape(&self, call: &Call, jerks: Jerks) -> Shape {
        if self.is_s_curve(call) {
            Shape::SCurve(jerks)
        } else {
            Shape::Trapezoidal(jerks)
        }
    }

    /// Speed, rates and jerks in units.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) where a percentage of a maximum is 0.
    pub(super) fn read(&self, call: &Call, maxima: &Maxima) -> Result<Dynamics, MotionError> {
        let rates = &self.rates;
        let speed = rates.speed(call, maxima);
        let dynamics = Dynamics {
            speed,
            acceleration: rates.acceleration(call, maxima),
            deceleration: rates.deceleration(call, maxima),
            shape: self.shape(call, rates.jerks(call, maxima)),
            last_speed: reference_speed(speed, maxima.speed),
        };
        rates.verify(&dynamics)?;
        Ok(dynamics)
    }

    /// One mode for all units: 94.
    pub(super) fn verify_units(&self, call: &Call) -> Result<(), MotionError> {
        let rates = &self.rates;
        let master = is_master_driven(call.number(rates.speed_units));
        let others = [rates.accel_units, rates.decel_units, rates.jerk_units];
        if others
            .iter()
            .any(|units| is_master_driven(call.number(*units)) != master)
        {
            return Err(MotionError::MdscUnitsConflict);
        }
        Ok(())
    }

    /// Whether the speed is by a master.
    pub(super) fn is_master_driven(&self, call: &Call) -> bool {
        is_master_driven(call.number(self.rates.speed_units))
    }

    /// A lock direction of the mode of the units (95), and a link for what is master driven (93).
    pub(super) fn verify_link(&self, call: &Call, link: Option<&MasterLink>) -> Result<(), MotionError> {
        self.lock.verify(call, self.is_master_driven(call), link)
    }

    /// How a call is driven by its link; `None`: by time.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) where a rotary master never shows the Lock Position.
    pub(super) fn lead(
        &self,
        motion: &Motion,
        call: &Call,
        link: Option<&MasterLink>,
    ) -> Result<Option<Lead>, MotionError> {
        let Some(link) = link.filter(|_| self.is_master_driven(call)) else {
            return Ok(None);
        };
        self.lock.lead(motion, call, link).map(Some)
    }
}

impl LockLayout {
    pub(super) fn of(mnemonic: Mnemonic) -> Self {
        LockLayout {
            position: place(mnemonic, "Lock Position"),
            direction: place(mnemonic, "Lock Direction"),
        }
    }

    /// A lock direction of the mode (95), and a link for what is master driven (93).
    pub(super) fn verify(
        &self,
        call: &Call,
        master_driven: bool,
        link: Option<&MasterLink>,
    ) -> Result<(), MotionError> {
        if (call.word(self.direction) != 0) != master_driven {
            return Err(MotionError::MdscLockDirectionConflict);
        }
        if master_driven && link.is_none() {
            return Err(MotionError::MdscNotActivated);
        }
        Ok(())
    }

    /// How a call is driven by a link.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) where a rotary master never shows the Lock Position.
    pub(super) fn lead(&self, motion: &Motion, call: &Call, link: &MasterLink) -> Result<Lead, MotionError> {
        let direction = call.word(self.direction);
        let position = (direction >= POSITION_FORWARD).then(|| call.number(self.position));
        let unwind = motion.axes[usize::from(link.master.axis)].unwind;
        if let (Some(position), Some(unwind)) = (position, unwind)
            && !Turn::contains(unwind, position)
        {
            return Err(MotionError::ParameterOutOfRange(OperandIndex(self.position as u8)));
        }
        let sense = if matches!(direction, IMMEDIATE_REVERSE | POSITION_REVERSE) {
            Sense::Reverse
        } else {
            Sense::Forward
        };
        Ok(Lead {
            link: link.id,
            lock: LockTo { sense, position },
        })
    }
}

/// With what a master driven motion takes over one at a speed: how its master moves (97, 98). One that waits for a lock takes
/// over nothing (102).
pub(super) fn pace(link: &MasterLink, lock: LockTo, moves: bool) -> Result<Pace, MotionError> {
    let pace = Guide::pace_of(&link.master, lock.sense);
    if !moves {
        Ok(pace)
    } else if link.master.velocity() == 0.0 {
        Err(MotionError::MdscIdleMasterAndSlaveMoving)
    } else if pace.speed <= 0.0 {
        Err(MotionError::MdscDirectionMismatch)
    } else if lock.position.is_some() {
        Err(MotionError::MdscLockWhileMoving)
    } else {
        Ok(pace)
    }
}

/// Whether a way is long enough to slow down on it, from the speed of what is taken over to the programmed one (103).
pub(super) fn verify_reduction(speed: f64, limits: &Limits, way: f64) -> Result<(), MotionError> {
    let excess = speed - limits.speed;
    // A ramp is symmetric: its mean speed times the time that a stop from the difference would take.
    let needed = if excess > 0.0 {
        stop_distance(excess, limits) * (speed + limits.speed) / excess
    } else {
        0.0
    };
    if needed > way {
        return Err(MotionError::MdscInvalidSlaveSpeedReduction);
    }
    Ok(())
}

/// Places of the operands that change how something moves: MCCD, MCD.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChangeLayout {
    pub(super) rates: Rates,
    change_speed: usize,
    change_accel: usize,
    change_decel: usize,
    change_accel_jerk: usize,
    change_decel_jerk: usize,
}

impl ChangeLayout {
    pub(super) fn of(mnemonic: Mnemonic) -> Self {
        let place = |name| place(mnemonic, name);
        ChangeLayout {
            rates: Rates::of(mnemonic),
            change_speed: place("Change Speed"),
            change_accel: place("Change Accel"),
            change_decel: place("Change Decel"),
            change_accel_jerk: place("Change Accel Jerk"),
            change_decel_jerk: place("Change Decel Jerk"),
        }
    }

    pub(super) fn changes_speed(&self, call: &Call) -> bool {
        call.is_one(self.change_speed)
    }

    /// Every unit of a change must be of the mode of what is under way: 94, and 105 for the speed's.
    pub(super) fn verify_mode(&self, call: &Call, driven: bool) -> Result<(), MotionError> {
        let rates = &self.rates;
        let master = |units: usize| is_master_driven(call.number(units));
        let changed = [
            (call.is_one(self.change_accel), rates.accel_units),
            (call.is_one(self.change_decel), rates.decel_units),
            (
                call.is_one(self.change_accel_jerk) || call.is_one(self.change_decel_jerk),
                rates.jerk_units,
            ),
        ];
        let mixed = |mode: bool| {
            changed
                .iter()
                .any(|(changed, units)| *changed && master(*units) != mode)
        };
        let mode = if self.changes_speed(call) {
            master(rates.speed_units)
        } else {
            driven
        };
        if mixed(mode) {
            Err(MotionError::MdscUnitsConflict)
        } else if mode != driven {
            Err(MotionError::MdscInvalidModeOrMasterChange)
        } else {
            Ok(())
        }
    }

    /// What the call changes, read once for all moves.
    pub(super) fn read(&self, call: &Call, maxima: &Maxima) -> Change {
        let rates = &self.rates;
        let jerks = rates.jerks(call, maxima);
        let wanted = |place: usize| call.is_one(place);
        Change {
            speed: wanted(self.change_speed).then(|| rates.speed(call, maxima)),
            acceleration: wanted(self.change_accel).then(|| rates.acceleration(call, maxima)),
            deceleration: wanted(self.change_decel).then(|| rates.deceleration(call, maxima)),
            acceleration_jerk: wanted(self.change_accel_jerk).then_some(jerks.acceleration),
            deceleration_jerk: wanted(self.change_decel_jerk).then_some(jerks.deceleration),
            places: *rates,
        }
    }
}

/// What MCCD or MCD changes, in units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(super) speed: Option<f64>,
    pub(super) acceleration: Option<f64>,
    pub(super) deceleration: Option<f64>,
    pub(super) acceleration_jerk: Option<JerkRate>,
    pub(super) deceleration_jerk: Option<JerkRate>,
    pub(super) places: Rates,
}

impl Change {
    /// Dynamics with the change. A jerk in percent of time follows whatever is changed.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) where a percentage of a maximum is 0.
    pub(super) fn of(&self, mut dynamics: Dynamics) -> Result<Dynamics, MotionError> {
        if let Some(speed) = self.speed {
            dynamics.set_speed(speed);
        }
        dynamics.acceleration = self.acceleration.unwrap_or(dynamics.acceleration);
        dynamics.deceleration = self.deceleration.unwrap_or(dynamics.deceleration);
        let jerks = dynamics.jerks_mut();
        jerks.acceleration = self.acceleration_jerk.unwrap_or(jerks.acceleration);
        jerks.deceleration = self.deceleration_jerk.unwrap_or(jerks.deceleration);
        self.places.verify(&dynamics)?;
        Ok(dynamics)
    }

    /// Whether [`Change::of`] can be made of any dynamics: what is not changed was accepted before, and a jerk in percent of
    /// time is more than 0.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) where a percentage of a maximum is 0.
    pub(super) fn verify(&self, s_curve: bool) -> Result<(), MotionError> {
        let jerk = |jerk: Option<JerkRate>| match jerk {
            Some(JerkRate::Units(jerk)) if s_curve => Some(jerk),
            _ => None,
        };
        let places = &self.places;
        let changed = [
            (self.acceleration, places.accel_rate),
            (self.deceleration, places.decel_rate),
            (jerk(self.acceleration_jerk), places.accel_jerk),
            (jerk(self.deceleration_jerk), places.decel_jerk),
        ];
        let mut changed = changed.into_iter().filter_map(|(value, place)| Some((value?, place)));
        changed.try_for_each(|(value, place)| positive(value, place))
    }
}

/// A percentage of a maximum that is 0 leaves nothing to move with.
pub(super) fn positive(value: f64, operand: usize) -> Result<(), MotionError> {
    if value > 0.0 {
        Ok(())
    } else {
        Err(MotionError::ParameterOutOfRange(OperandIndex(operand as u8)))
    }
}
