//! Operands that several instructions have one behind the other.

use super::row::*;
use crate::enumerations::*;
use crate::instruction::Range;
use crate::operands::{OperandReader, OperandValue, Operands};
use crate::{RealArray, Words, WrittenArray};

operand_groups! {
    /// Speed, rates and jerks of a move or a jog: MCLM, MCCM, MAM, MAJ.
    DynamicsOperands(speeds, rates, jerks) [
        speed: f64 = speed(),
        speed_units: SpeedUnits = speed_units(speeds),
        accel_rate: f64 = accel_rate(),
        accel_units: RateUnits = rate_units(rates),
        decel_rate: f64 = decel_rate(),
        decel_units: RateUnits = rate_units(rates),
        profile: VelocityProfile = profile(),
        accel_jerk: f64 = profile_jerk(),
        decel_jerk: f64 = profile_jerk(),
        jerk_units: JerkUnits = jerk_units(jerks),
    ];

    /// The position and direction at which a motion locks to its master: MCLM, MCCM, MCPM, MAM, MAJ, MATC.
    LockOperands() [
        lock_position: f64 = number(Range::Any, "master units; used when master driven"),
        lock_direction: LockDirection = word(),
    ];

    /// Event distances and the array for their results: MCLM, MCCM, MAM.
    EventOperands() [
        event_distance: RealArray = array_or_none("distances before the end of the move, position units"),
        calculated_data: Option<WrittenArray> = written(
            4, "receives seconds (master driven: master units) from the start to each event distance"),
    ];

    /// Deceleration and jerk of a stop: MCS, MAS.
    StopOperands() [
        change_decel: NoYes = change(),
        decel_rate: f64 = decel_rate().changed_by("Change Decel"),
        decel_units: RateUnits = rate_units(&STOP_RATE_UNITS),
        change_decel_jerk: NoYes = change(),
        decel_jerk: f64 = jerk().changed_by("Change Decel Jerk"),
        jerk_units: JerkUnits = jerk_units(&STOP_JERK_UNITS),
    ];
}
