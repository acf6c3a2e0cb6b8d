//! The maxima of axes and coordinate systems, and their Dynamics Configuration Bits.

use arcline_instruction_set::DYNAMICS_CONFIGURATION_BITS;
use roxmltree::Node;
use toml::{Table, Value};

use super::super::Importer;
use super::put;
use crate::{L5xError, Reason};

impl<'a, 't> Importer<'a, 't> {
    /// The five maxima, and the speed that holds. 0 as a speed, acceleration or its jerk is no limit that can be moved with.
    pub(super) fn dynamics(
        &mut self,
        node: Node<'a, 't>,
        section: &'static str,
        name: &str,
        table: &mut Table,
    ) -> Result<f64, L5xError> {
        let mut holds = FALLBACK_SPEED;
        for (attribute, key, fallback) in DYNAMICS {
            let number = self.source.number(node, attribute)?;
            if number.is_some_and(|number| number < 0.0) {
                return Err(self.source.wrong(node, attribute, "a number, 0 or more"));
            }
            let may_be_zero = matches!(key, "max_deceleration" | "max_deceleration_jerk");
            let number = number.filter(|number| may_be_zero || *number > 0.0);
            if number.is_none() && !may_be_zero && !self.overlaid(section, name, &[key]) {
                let reason = Reason::Changed(match fallback {
                    Some(FALLBACK_SPEED) => "0 or not given: becomes 100 units/s",
                    Some(_) => "0 or not given: becomes 1000 units/s²",
                    None => "0 or not given: becomes acceleration² / speed",
                });
                self.source.report_attribute(node, attribute, reason);
            }
            let number = number.or(fallback);
            if key == "max_speed" {
                holds = number.unwrap_or(holds);
            }
            table.extend(number.map(|number| (key.to_owned(), Value::Float(number))));
        }
        self.dynamics_bits(node, table)?;
        Ok(holds)
    }

    /// The Dynamics Configuration Bits, in decimal or as `16#0000_0007`; all three are the default of a configuration too.
    fn dynamics_bits(&mut self, node: Node<'a, 't>, table: &mut Table) -> Result<(), L5xError> {
        let attribute = "DynamicsConfigurationBits";
        let Some(word) = node.attribute(attribute).map(str::trim) else {
            return Ok(());
        };
        let bits = match word.strip_prefix("16#") {
            Some(digits) => u32::from_str_radix(&digits.replace('_', ""), 16),
            None => word.parse(),
        };
        let Ok(bits) = bits else {
            return Err(self
                .source
                .wrong(node, attribute, "a whole number such as 7 or 16#0000_0007"));
        };
        let known = bits & DYNAMICS_CONFIGURATION_BITS;
        if known != bits {
            let words = "of Dynamics Configuration Bits only bits 0 to 2 have a meaning";
            self.source.report_attribute(node, attribute, Reason::Changed(words));
        }
        if known != DYNAMICS_CONFIGURATION_BITS {
            put(table, "dynamics_configuration_bits", Value::Integer(known.into()));
        }
        Ok(())
    }
}

/// Position units per second of an axis that has no Maximum Speed.
pub(super) const FALLBACK_SPEED: f64 = 100.0;
/// Position units per second² of an axis that has no Maximum Acceleration.
pub(super) const FALLBACK_RATE: f64 = 1000.0;

/// Attribute, key, and the replacement of 0.
const DYNAMICS: [(&str, &str, Option<f64>); 5] = [
    ("MaximumSpeed", "max_speed", Some(FALLBACK_SPEED)),
    ("MaximumAcceleration", "max_acceleration", Some(FALLBACK_RATE)),
    ("MaximumDeceleration", "max_deceleration", None),
    ("MaximumAccelerationJerk", "max_acceleration_jerk", None),
    ("MaximumDecelerationJerk", "max_deceleration_jerk", None),
];
