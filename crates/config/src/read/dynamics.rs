//! The five maxima, and the Dynamics Configuration Bits, that an axis and a coordinate system have alike.

use arcline_controller::machine::{DynamicsBits, default_jerk};

use crate::section::Section;

/// The dynamics that an axis and a coordinate system have in common.
pub(super) struct Dynamics {
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) deceleration: f64,
    pub(super) acceleration_jerk: f64,
    pub(super) deceleration_jerk: f64,
    pub(super) bits: DynamicsBits,
}

impl Dynamics {
    pub(super) fn read(section: &Section<'_>) -> Self {
        let speed = section.required("max_speed");
        let acceleration = section.required("max_acceleration");
        let deceleration = section.number("max_deceleration").unwrap_or(acceleration);
        let jerk = |key, rate| section.number(key).unwrap_or_else(|| default_jerk(speed, rate));
        Self {
            speed,
            acceleration,
            deceleration,
            acceleration_jerk: jerk("max_acceleration_jerk", acceleration),
            deceleration_jerk: jerk("max_deceleration_jerk", deceleration),
            bits: DynamicsBits::from_bits(section.whole("dynamics_configuration_bits")),
        }
    }
}
