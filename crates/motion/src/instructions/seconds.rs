//! MAM in seconds, or in master units: the durations of the whole move and of its phases are programmed, speed and rates follow from the
//! distance (spec/axis-and-data-types.md §1.4).
//!
//! With the distance `D`, the duration `T`, those of the phases `Ta` and `Td`, and the ramp times `Tj` inside them
//! (S-curve; 0 for a trapezoid):
//!
//! ```text
//! v = D / (T − (Ta + Td)/2)      a = v / (Ta − Tj)      j = a / Tj
//! ```

use arcline_instruction_set::{Call, MotionError, OperandIndex};

use super::programmed::{DynamicsLayout, Rates};
use crate::dynamics::{Dynamics, JerkRate, Jerks, Maxima, Shape};

/// The word of every Units operand for a duration in seconds.
pub(super) const SECONDS: i32 = 3;

/// The same for a duration in master units, over which the master goes.
pub(super) const MASTER_UNITS: i32 = 7;

/// Whether the word of Speed Units makes a duration of the speed.
pub(super) fn is_duration(units: i32) -> bool {
    matches!(units, SECONDS | MASTER_UNITS)
}

/// Where the speed is a duration, everything is, and only there.
pub(super) fn verify_units(rates: &Rates, call: &Call, duration: i32) -> Result<(), MotionError> {
    let is_duration = |units: usize| call.word(units) == duration;
    let others = [rates.accel_units, rates.decel_units, rates.jerk_units];
    let same = others
        .iter()
        .all(|units| is_duration(*units) == is_duration(rates.speed_units));
    if same {
        Ok(())
    } else {
        Err(MotionError::MdscUnitsConflict)
    }
}

/// The phases have room within the move, and an S-curve's ramps within the phases.
pub(super) fn verify_durations(layout: &DynamicsLayout, call: &Call) -> Result<(), MotionError> {
    let rates = &layout.rates;
    let [whole, accel, decel] = [rates.speed, rates.accel_rate, rates.decel_rate].map(|operand| call.number(operand));
    let beyond = |operand: usize| Err(MotionError::ParameterOutOfRange(OperandIndex(operand as u8)));
    if accel + decel > whole {
        return beyond(rates.speed);
    }
    if layout.is_s_curve(call) {
        for (ramp, phase) in [(rates.accel_jerk, accel), (rates.decel_jerk, decel)] {
            if call.number(ramp) > 0.5 * phase {
                return beyond(ramp);
            }
        }
    }
    Ok(())
}

/// Speed, rates and jerks that cover a distance in the programmed time. Over no distance they are the axis's maxima.
pub(super) fn dynamics(layout: &DynamicsLayout, call: &Call, distance: f64, maxima: &Maxima) -> Dynamics {
    let rates = &layout.rates;
    let [whole, accel, decel] = [rates.speed, rates.accel_rate, rates.decel_rate].map(|operand| call.number(operand));
    let [accel_ramp, decel_ramp] = if layout.is_s_curve(call) {
        [rates.accel_jerk, rates.decel_jerk].map(|operand| call.number(operand))
    } else {
        [0.0; 2]
    };
    let jerks = |acceleration, deceleration| Jerks {
        acceleration: JerkRate::Units(acceleration),
        deceleration: JerkRate::Units(deceleration),
    };
    // Of no effect in a trapezoid.
    let most = jerks(maxima.acceleration_jerk, maxima.deceleration_jerk);
    if distance == 0.0 {
        return Dynamics {
            speed: maxima.speed,
            acceleration: maxima.acceleration,
            deceleration: maxima.deceleration,
            shape: layout.shape(call, most),
            last_speed: maxima.speed,
        };
    }
    let speed = distance / (whole - 0.5 * (accel + decel));
    let (acceleration, deceleration) = (speed / (accel - accel_ramp), speed / (decel - decel_ramp));
    Dynamics {
        speed,
        acceleration,
        deceleration,
        shape: if layout.is_s_curve(call) {
            Shape::SCurve(jerks(acceleration / accel_ramp, deceleration / decel_ramp))
        } else {
            Shape::Trapezoidal(most)
        },
        last_speed: speed,
    }
}
