//! The five maxima, and the Dynamics Configuration Bits, that an axis and a coordinate system have alike.

use arcline_controller::machine::{DynamicsBits, default_jerk};

use crate::error::ConfigError;
use crate::section::{NumberRule, Section};

/// What an axis and a coordinate system have alike.
pub(super) struct Dynamics {
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) deceleration: f64,
    pub(super) acceleration_jerk: f64,
    pub(super) deceleration_jerk: f64,
    pub(super) bits: DynamicsBits,
}

impl Dynamics {
    pub(super) fn read(section: &Section<'_>) -> Result<Self, ConfigError> {
        let speed = section.required_number("max_speed", &POSITIVE_SPEED)?;
        let acceleration = section.required_number("max_acceleration", &POSITIVE_RATE)?;
        let deceleration = section
            .number("max_deceleration", &NOT_NEGATIVE_RATE)?
            .unwrap_or(acceleration);
        let acceleration_jerk = section.number("max_acceleration_jerk", &POSITIVE_JERK)?;
        let deceleration_jerk = section.number("max_deceleration_jerk", &NOT_NEGATIVE_JERK)?;
        Ok(Self {
            speed,
            acceleration,
            deceleration,
            acceleration_jerk: acceleration_jerk.unwrap_or_else(|| default_jerk(speed, acceleration)),
            deceleration_jerk: deceleration_jerk.unwrap_or_else(|| default_jerk(speed, deceleration)),
            bits: section
                .integer("dynamics_configuration_bits", 0..=7, BITS)?
                .map_or(DynamicsBits::ALL, |bits| DynamicsBits::from_bits(bits as u32)),
        })
    }
}

const BITS: &str = "a whole number from 0 to 7";
pub(super) const POSITIVE_SPEED: NumberRule = NumberRule {
    expected: "a number above 0 (units/s)",
    holds: |x| x > 0.0,
};
pub(super) const POSITIVE_RATE: NumberRule = NumberRule {
    expected: "a number above 0 (units/s²)",
    holds: |x| x > 0.0,
};
const NOT_NEGATIVE_RATE: NumberRule = NumberRule {
    expected: "a number, 0 or more (units/s²)",
    holds: |x| x >= 0.0,
};
const POSITIVE_JERK: NumberRule = NumberRule {
    expected: "a number above 0 (units/s³)",
    holds: |x| x > 0.0,
};
const NOT_NEGATIVE_JERK: NumberRule = NumberRule {
    expected: "a number, 0 or more (units/s³)",
    holds: |x| x >= 0.0,
};
