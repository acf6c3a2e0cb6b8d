//! Speed, rates and jerks as operands: the programmed dynamics of moves and jogs, and the changes by MCCD and MCD.
//!
//! Not here: the use of these dynamics, and MAM's durations in seconds.

use arcline_instruction_set::enumerations::{JerkUnits, LockDirection, NoYes, RateUnits, SpeedUnits, VelocityProfile};
use arcline_instruction_set::operands::{DynamicsOperands, LockOperands, OperandValue, StopOperands};
use arcline_instruction_set::{MotionError, OperandIndex};
use arcline_planner::MasterRate;
use arcline_planner::profile::{Limits, stop_distance};

use crate::dynamics::{
    Dynamics, JerkRate, Jerks, Maxima, ProgrammedProfile, Units, in_units, jerk_in_units, speed_for_jerk,
};
use crate::masters::displacement::Sense;
use crate::masters::follower::DrivenBy;
use crate::masters::follower::{LockCondition, MasterFollower};
use crate::masters::links::MasterLink;
use crate::motion::Motion;
use crate::rotary::RotaryPosition;

/// Speed, rates and jerks with their units, of a move, a jog or a change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rates {
    pub(super) speed: OperandValue<f64>,
    pub(super) speed_units: OperandValue<SpeedUnits>,
    pub(super) accel_rate: OperandValue<f64>,
    pub(super) accel_units: OperandValue<RateUnits>,
    pub(super) decel_rate: OperandValue<f64>,
    pub(super) decel_units: OperandValue<RateUnits>,
    pub(super) accel_jerk: OperandValue<f64>,
    pub(super) decel_jerk: OperandValue<f64>,
    pub(super) jerk_units: OperandValue<JerkUnits>,
}

impl Rates {
    fn speed(&self, maxima: &Maxima) -> f64 {
        in_units(*self.speed, *self.speed_units, maxima.speed)
    }

    fn acceleration(&self, maxima: &Maxima) -> f64 {
        in_units(*self.accel_rate, *self.accel_units, maxima.acceleration)
    }

    fn deceleration(&self, maxima: &Maxima) -> f64 {
        in_units(*self.decel_rate, *self.decel_units, maxima.deceleration)
    }

    fn jerks(&self, maxima: &Maxima) -> Jerks {
        let units = *self.jerk_units;
        Jerks {
            acceleration: jerk_in_units(*self.accel_jerk, units, maxima.acceleration_jerk),
            deceleration: jerk_in_units(*self.decel_jerk, units, maxima.deceleration_jerk),
        }
    }

    /// Rejects a percentage of a maximum that is 0: no motion would be possible.
    fn verify(&self, dynamics: &Dynamics) -> Result<(), MotionError> {
        positive(dynamics.acceleration, self.accel_rate.index)?;
        positive(dynamics.deceleration, self.decel_rate.index)?;
        if let Some(jerk) = dynamics.limits().jerk {
            positive(jerk.acceleration, self.accel_jerk.index)?;
            positive(jerk.deceleration, self.decel_jerk.index)?;
        }
        Ok(())
    }
}

/// The operands for dynamics, profile and master lock: MCLM, MCCM, MAM, MAJ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Programmed {
    pub(super) rates: Rates,
    profile: VelocityProfile,
    lock: LockOperands,
}

impl Programmed {
    pub(super) fn new(dynamics: DynamicsOperands, lock: LockOperands) -> Self {
        let DynamicsOperands {
            speed,
            speed_units,
            accel_rate,
            accel_units,
            decel_rate,
            decel_units,
            profile,
            accel_jerk,
            decel_jerk,
            jerk_units,
        } = dynamics;
        let rates = Rates {
            speed,
            speed_units,
            accel_rate,
            accel_units,
            decel_rate,
            decel_units,
            accel_jerk,
            decel_jerk,
            jerk_units,
        };
        Programmed {
            rates,
            profile: *profile,
            lock,
        }
    }

    pub(super) fn is_s_curve(&self) -> bool {
        self.profile == VelocityProfile::SCurve
    }

    /// The shape of the profile with these jerks.
    pub(super) fn shape(&self, jerks: Jerks) -> ProgrammedProfile {
        match self.profile {
            VelocityProfile::SCurve => ProgrammedProfile::SCurve(jerks),
            VelocityProfile::Trapezoidal => ProgrammedProfile::Trapezoidal(jerks),
        }
    }

    /// Speed, rates and jerks in position units.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) if a percentage of a maximum is 0.
    pub(super) fn dynamics(&self, maxima: &Maxima) -> Result<Dynamics, MotionError> {
        let rates = &self.rates;
        let speed = rates.speed(maxima);
        let dynamics = Dynamics {
            speed,
            acceleration: rates.acceleration(maxima),
            deceleration: rates.deceleration(maxima),
            shape: self.shape(rates.jerks(maxima)),
            last_speed: speed_for_jerk(speed, maxima.speed),
        };
        rates.verify(&dynamics)?;
        Ok(dynamics)
    }

    /// Checks that all units are of one mode (94).
    pub(super) fn verify_units(&self) -> Result<(), MotionError> {
        let rates = &self.rates;
        let others = [
            rates.accel_units.is_master_driven(),
            rates.decel_units.is_master_driven(),
            rates.jerk_units.is_master_driven(),
        ];
        if others.iter().any(|other| *other != self.is_master_driven()) {
            return Err(MotionError::MdscUnitsConflict);
        }
        Ok(())
    }

    /// The unit of the speed is per master unit.
    fn is_master_driven(&self) -> bool {
        self.rates.speed_units.is_master_driven()
    }

    /// Checks that the lock direction matches the mode of the units (95), and that a master driven motion has a link (93).
    pub(super) fn verify_link(&self, link: Option<&MasterLink>) -> Result<(), MotionError> {
        verify_lock(&self.lock, self.is_master_driven(), link)
    }

    /// The link and lock that drive the motion; `None`: time drives it.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) if a rotary master never shows the Lock Position.
    pub(super) fn driven_by(
        &self,
        motion: &Motion,
        link: Option<&MasterLink>,
    ) -> Result<Option<DrivenBy>, MotionError> {
        let Some(link) = link.filter(|_| self.is_master_driven()) else {
            return Ok(None);
        };
        driven_by(motion, &self.lock, link).map(Some)
    }
}

/// Checks that the lock direction matches the mode (95), and that a master driven motion has a link (93).
pub(super) fn verify_lock(
    lock: &LockOperands,
    master_driven: bool,
    link: Option<&MasterLink>,
) -> Result<(), MotionError> {
    if (*lock.lock_direction != LockDirection::None) != master_driven {
        return Err(MotionError::MdscLockDirectionConflict);
    }
    if master_driven && link.is_none() {
        return Err(MotionError::MdscNotActivated);
    }
    Ok(())
}

/// The link and lock that drive a motion.
///
/// # Errors
/// `ParameterOutOfRange` (13) if a rotary master never shows the Lock Position.
pub(super) fn driven_by(motion: &Motion, lock: &LockOperands, link: &MasterLink) -> Result<DrivenBy, MotionError> {
    let LockOperands {
        lock_position,
        lock_direction,
    } = lock;
    let (sense, at_position) = match **lock_direction {
        LockDirection::None | LockDirection::ImmediateForward => (Sense::Forward, false),
        LockDirection::ImmediateReverse => (Sense::Reverse, false),
        LockDirection::PositionForward => (Sense::Forward, true),
        LockDirection::PositionReverse => (Sense::Reverse, true),
    };
    let position = at_position.then_some(**lock_position);
    let unwind = motion.axes[link.master.axis].unwind;
    if let (Some(position), Some(unwind)) = (position, unwind)
        && !RotaryPosition::contains(unwind, position)
    {
        return Err(lock_position.out_of_range());
    }
    Ok(DrivenBy {
        link: link.id,
        lock: LockCondition { sense, position },
    })
}

/// The rate of the master, which converts moving motion that a master driven one takes over (97, 98). A motion that waits for a lock takes
/// over no motion (102).
pub(super) fn master_rate(link: &MasterLink, lock: LockCondition, moves: bool) -> Result<MasterRate, MotionError> {
    let rate = MasterFollower::rate_of(&link.master, lock.sense);
    if !moves {
        Ok(rate)
    } else if link.master.velocity() == 0.0 {
        Err(MotionError::MdscIdleMasterAndSlaveMoving)
    } else if rate.speed <= 0.0 {
        Err(MotionError::MdscDirectionMismatch)
    } else if lock.position.is_some() {
        Err(MotionError::MdscLockWhileMoving)
    } else {
        Ok(rate)
    }
}

/// Checks that a distance is long enough to reduce the speed of the motion taken over to the programmed one (103).
pub(super) fn verify_reduction(speed: f64, limits: &Limits, distance: f64) -> Result<(), MotionError> {
    let excess = speed - limits.speed;
    // A ramp is symmetric: its mean speed times the time that a stop from the difference would take.
    let needed = if excess > 0.0 {
        stop_distance(excess, limits) * (speed + limits.speed) / excess
    } else {
        0.0
    };
    if needed > distance {
        return Err(MotionError::MdscInvalidSlaveSpeedReduction);
    }
    Ok(())
}

/// A change of the dynamics of a motion: MCCD, MCD.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChangeOperands {
    pub(super) rates: Rates,
    pub(super) change_speed: NoYes,
    pub(super) change_accel: NoYes,
    pub(super) change_decel: NoYes,
    pub(super) change_accel_jerk: NoYes,
    pub(super) change_decel_jerk: NoYes,
}

impl ChangeOperands {
    /// Checks that every unit of a change is of the mode of the motion under way: 94, and 105 for the speed.
    pub(super) fn verify_mode(&self, driven: bool) -> Result<(), MotionError> {
        let rates = &self.rates;
        let changes_jerk = [self.change_accel_jerk, self.change_decel_jerk].contains(&NoYes::Yes);
        let changed = [
            (self.change_accel == NoYes::Yes, rates.accel_units.is_master_driven()),
            (self.change_decel == NoYes::Yes, rates.decel_units.is_master_driven()),
            (changes_jerk, rates.jerk_units.is_master_driven()),
        ];
        let mode = match self.change_speed {
            NoYes::Yes => rates.speed_units.is_master_driven(),
            NoYes::No => driven,
        };
        if changed.iter().any(|(changed, master)| *changed && *master != mode) {
            Err(MotionError::MdscUnitsConflict)
        } else if mode != driven {
            Err(MotionError::MdscInvalidModeOrMasterChange)
        } else {
            Ok(())
        }
    }

    /// The change in position units, the same for all moves.
    pub(super) fn change(&self, maxima: &Maxima) -> Change {
        let rates = &self.rates;
        let jerks = rates.jerks(maxima);
        let wanted = |change: NoYes| change == NoYes::Yes;
        Change {
            speed: wanted(self.change_speed).then(|| rates.speed(maxima)),
            acceleration: wanted(self.change_accel).then(|| rates.acceleration(maxima)),
            deceleration: wanted(self.change_decel).then(|| rates.deceleration(maxima)),
            acceleration_jerk: wanted(self.change_accel_jerk).then_some(jerks.acceleration),
            deceleration_jerk: wanted(self.change_decel_jerk).then_some(jerks.deceleration),
            rates: *rates,
        }
    }
}

/// The operands of MCCD or MCD that change something, in units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(super) speed: Option<f64>,
    pub(super) acceleration: Option<f64>,
    pub(super) deceleration: Option<f64>,
    pub(super) acceleration_jerk: Option<JerkRate>,
    pub(super) deceleration_jerk: Option<JerkRate>,
    pub(super) rates: Rates,
}

impl Change {
    /// The dynamics with the change. A jerk in percent of time follows every change.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) if a percentage of a maximum is 0.
    pub(super) fn of(&self, mut dynamics: Dynamics) -> Result<Dynamics, MotionError> {
        if let Some(speed) = self.speed {
            dynamics.set_speed(speed);
        }
        dynamics.acceleration = self.acceleration.unwrap_or(dynamics.acceleration);
        dynamics.deceleration = self.deceleration.unwrap_or(dynamics.deceleration);
        let jerks = dynamics.jerks_mut();
        jerks.acceleration = self.acceleration_jerk.unwrap_or(jerks.acceleration);
        jerks.deceleration = self.deceleration_jerk.unwrap_or(jerks.deceleration);
        self.rates.verify(&dynamics)?;
        Ok(dynamics)
    }

    /// Checks that [`Change::of`] succeeds for any dynamics: the unchanged values were accepted before, and a jerk in percent of time is more
    /// than 0.
    ///
    /// # Errors
    /// `ParameterOutOfRange` (13) if a percentage of a maximum is 0.
    pub(super) fn verify(&self, s_curve: bool) -> Result<(), MotionError> {
        let jerk = |jerk: Option<JerkRate>| match jerk {
            Some(JerkRate::Units(jerk)) if s_curve => Some(jerk),
            _ => None,
        };
        let rates = &self.rates;
        let changed = [
            (self.acceleration, rates.accel_rate.index),
            (self.deceleration, rates.decel_rate.index),
            (jerk(self.acceleration_jerk), rates.accel_jerk.index),
            (jerk(self.deceleration_jerk), rates.decel_jerk.index),
        ];
        let mut changed = changed
            .into_iter()
            .filter_map(|(value, operand)| Some((value?, operand)));
        changed.try_for_each(|(value, operand)| positive(value, operand))
    }
}

/// The rates of a stop that differ from the maxima.
#[derive(Clone, Copy, Debug)]
pub(super) struct StopChange {
    pub(super) deceleration: Option<f64>,
    pub(super) jerk: Option<JerkRate>,
}

/// The rates of MCS or MAS that differ from the maxima, in position units.
pub(super) fn stop_change(operands: &StopOperands, maxima: &Maxima) -> StopChange {
    let StopOperands {
        change_decel,
        decel_rate,
        decel_units,
        change_decel_jerk,
        decel_jerk,
        jerk_units,
    } = *operands;
    let deceleration = in_units(*decel_rate, *decel_units, maxima.deceleration);
    let jerk = jerk_in_units(*decel_jerk, *jerk_units, maxima.deceleration_jerk);
    StopChange {
        deceleration: (*change_decel == NoYes::Yes).then_some(deceleration),
        jerk: (*change_decel_jerk == NoYes::Yes).then_some(jerk),
    }
}

/// Rejects a percentage of a maximum that is 0: no motion would be possible.
pub(super) fn positive(value: f64, operand: OperandIndex) -> Result<(), MotionError> {
    if value > 0.0 {
        Ok(())
    } else {
        Err(MotionError::ParameterOutOfRange(operand))
    }
}
