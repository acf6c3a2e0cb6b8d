//! What MAM and MAJ share: dynamics in units of the axis, verification, and how a generator begins.

use arcline_instruction_set::{AxisIndex, Call, Culprit, Mnemonic, MotionError};

use super::moves::positive;
use super::place;
use crate::axis::{Axis, AxisDynamics, AxisState};
use crate::dynamics::{Dynamics, Jerks, Shape, in_units, jerk_in_units, reference_speed};
use crate::motion::Motion;
use crate::verify;

/// Places of the operands that every single-axis move has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisMoveLayout {
    pub(super) speed: usize,
    pub(super) speed_units: usize,
    accel_rate: usize,
    accel_units: usize,
    decel_rate: usize,
    decel_units: usize,
    profile: usize,
    accel_jerk: usize,
    decel_jerk: usize,
    jerk_units: usize,
    merge: usize,
    merge_speed: usize,
    lock_direction: usize,
}

/// Profile: S-curve.
const S_CURVE: i32 = 1;

impl AxisMoveLayout {
    pub(super) fn of(mnemonic: Mnemonic) -> Self {
        let place = |name| place(mnemonic, name);
        AxisMoveLayout {
            speed: place("Speed"),
            speed_units: place("Speed Units"),
            accel_rate: place("Accel Rate"),
            accel_units: place("Accel Units"),
            decel_rate: place("Decel Rate"),
            decel_units: place("Decel Units"),
            profile: place("Profile"),
            accel_jerk: place("Accel Jerk"),
            decel_jerk: place("Decel Jerk"),
            jerk_units: place("Jerk Units"),
            merge: place("Merge"),
            merge_speed: place("Merge Speed"),
            lock_direction: place("Lock Direction"),
        }
    }

    /// Whether the instruction ends what other single-axis instructions move.
    pub(super) fn merges(&self, call: &Call) -> bool {
        call.is_one(self.merge)
    }

    /// Whether the present speed of the axis is the one to go on with.
    pub(super) fn keeps_speed(&self, call: &Call) -> bool {
        self.merges(call) && call.is_one(self.merge_speed)
    }

    pub(super) fn is_s_curve(&self, call: &Call) -> bool {
        call.word(self.profile) == S_CURVE
    }

    /// Speed, rates and jerks in units.
    pub(super) fn dynamics(&self, call: &Call, axis: &AxisDynamics) -> Result<Dynamics, MotionError> {
        let units = |value, word, maximum| in_units(call.number(value), call.word(word), maximum);
        let jerk = |value, maximum| jerk_in_units(call.number(value), call.word(self.jerk_units), maximum);
        let speed = units(self.speed, self.speed_units, axis.speed);
        let jerks = Jerks {
            acceleration: jerk(self.accel_jerk, axis.acceleration_jerk),
            deceleration: jerk(self.decel_jerk, axis.deceleration_jerk),
        };
        let dynamics = Dynamics {
            speed,
            acceleration: units(self.accel_rate, self.accel_units, axis.acceleration),
            deceleration: units(self.decel_rate, self.decel_units, axis.deceleration),
            shape: if self.is_s_curve(call) {
                Shape::SCurve(jerks)
            } else {
                Shape::Trapezoidal(jerks)
            },
            last_speed: reference_speed(speed, axis.speed),
        };
        positive(dynamics.acceleration, self.accel_rate)?;
        positive(dynamics.deceleration, self.decel_rate)?;
        if let Some(jerk) = dynamics.limits().jerk {
            positive(jerk.acceleration, self.accel_jerk)?;
            positive(jerk.deceleration, self.decel_jerk)?;
        }
        Ok(dynamics)
    }

    /// One mode for all units, a lock direction of that mode, a link for a master driven move.
    pub(super) fn verify_mode(&self, call: &Call) -> Result<(), MotionError> {
        let master = verify::is_master_driven(call.number(self.speed_units));
        let others = [self.accel_units, self.decel_units, self.jerk_units];
        if others
            .iter()
            .any(|units| verify::is_master_driven(call.number(*units)) != master)
        {
            return Err(MotionError::MdscUnitsConflict);
        }
        if (call.word(self.lock_direction) != 0) != master {
            return Err(MotionError::MdscLockDirectionConflict);
        }
        if master {
            return Err(MotionError::MdscNotActivated);
        }
        Ok(())
    }
}

/// The axis may be moved: not shut down, servo on, not homed, no stop of everything under way, and its stops can be made.
pub(super) fn verify_axis(motion: &Motion, axis: u16, s_curve: bool) -> Result<(), MotionError> {
    let state = &motion.axes[usize::from(axis)];
    ready(state)?;
    not_homing(state)?;
    if state.dynamics.deceleration <= 0.0 {
        return Err(MotionError::ZeroMaxDecel(Culprit::Axis(AxisIndex(0))));
    }
    if s_curve && state.dynamics.deceleration_jerk <= 0.0 {
        return Err(MotionError::ZeroMaxDecelJerk(Culprit::Axis(AxisIndex(0))));
    }
    if state.is_stopping() {
        return Err(MotionError::NotAllowedWhileStopping(AxisIndex(0)));
    }
    Ok(())
}

/// Not homed by an active sequence.
pub(super) fn not_homing(axis: &Axis) -> Result<(), MotionError> {
    if axis.is_homed_actively() {
        return Err(MotionError::HomeInProcess(AxisIndex(0)));
    }
    Ok(())
}

/// Not shut down, servo on.
pub(super) fn ready(axis: &Axis) -> Result<(), MotionError> {
    not_shut_down(axis)?;
    match axis.state {
        AxisState::Running => Ok(()),
        _ => Err(MotionError::ServoOffState(AxisIndex(0))),
    }
}

/// Not shut down; the servo may be off.
pub(super) fn not_shut_down(axis: &Axis) -> Result<(), MotionError> {
    match axis.state {
        AxisState::Shutdown => Err(MotionError::ShutdownState(AxisIndex(0))),
        _ => Ok(()),
    }
}
