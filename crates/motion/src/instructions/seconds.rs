//! MAM in seconds, or in master units: the operands give the durations of the whole move and of its phases; speed and rates follow from
//! the distance (spec/axis-and-data-types.md §1.4).
//!
//! With the distance `D`, the duration `T`, those of the phases `Ta` and `Td`, and the ramp times `Tj` inside them
//! (S-curve; 0 for a trapezoid):
//!
//! ```text
//! v = D / (T − (Ta + Td)/2)      a = v / (Ta − Tj)      j = a / Tj
//! ```

use arcline_instruction_set::MotionError;

use super::programmed::{Programmed, Rates};
use crate::dynamics::{Dynamics, JerkRate, Jerks, Maxima, ProgrammedProfile, Units};

/// The operand Speed is a duration.
pub(super) fn is_duration(rates: &Rates) -> bool {
    rates.speed_units.duration().is_some()
}

/// Checks that either all operands are durations in the same units, or none is.
pub(super) fn verify_units(rates: &Rates) -> Result<(), MotionError> {
    let others = [
        rates.accel_units.duration(),
        rates.decel_units.duration(),
        rates.jerk_units.duration(),
    ];
    if others.iter().all(|other| *other == rates.speed_units.duration()) {
        Ok(())
    } else {
        Err(MotionError::MdscUnitsConflict)
    }
}

/// Checks that the phases fit into the move, and an S-curve's ramps into the phases.
pub(super) fn verify_durations(programmed: &Programmed) -> Result<(), MotionError> {
    let rates = &programmed.rates;
    let [whole, accel, decel] = [*rates.speed, *rates.accel_rate, *rates.decel_rate];
    if accel + decel > whole {
        return Err(rates.speed.out_of_range());
    }
    if programmed.is_s_curve() {
        for (ramp, phase) in [(rates.accel_jerk, accel), (rates.decel_jerk, decel)] {
            if *ramp > 0.5 * phase {
                return Err(ramp.out_of_range());
            }
        }
    }
    Ok(())
}

/// Speed, rates and jerks that cover a distance in the programmed time. Over no distance they are the axis's maxima.
pub(super) fn dynamics(programmed: &Programmed, distance: f64, maxima: &Maxima) -> Dynamics {
    let rates = &programmed.rates;
    let [whole, accel, decel] = [*rates.speed, *rates.accel_rate, *rates.decel_rate];
    let [accel_ramp, decel_ramp] = if programmed.is_s_curve() {
        [*rates.accel_jerk, *rates.decel_jerk]
    } else {
        [0.0; 2]
    };
    let jerks = |acceleration, deceleration| Jerks {
        acceleration: JerkRate::Units(acceleration),
        deceleration: JerkRate::Units(deceleration),
    };
    // Without effect on a trapezoid.
    let most = jerks(maxima.acceleration_jerk, maxima.deceleration_jerk);
    if distance == 0.0 {
        return Dynamics {
            speed: maxima.speed,
            acceleration: maxima.acceleration,
            deceleration: maxima.deceleration,
            shape: programmed.shape(most),
            last_speed: maxima.speed,
        };
    }
    let speed = distance / (whole - 0.5 * (accel + decel));
    let (acceleration, deceleration) = (speed / (accel - accel_ramp), speed / (decel - decel_ramp));
    Dynamics {
        speed,
        acceleration,
        deceleration,
        shape: if programmed.is_s_curve() {
            ProgrammedProfile::SCurve(jerks(acceleration / accel_ramp, deceleration / decel_ramp))
        } else {
            ProgrammedProfile::Trapezoidal(most)
        },
        last_speed: speed,
    }
}
