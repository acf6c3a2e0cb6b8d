//! The numeric attributes of axes and coordinate systems: their names in GSV and SSV of Structured Text, and their numbers in the
//! attribute services of the classes 0x0301 and 0x0302 (spec/axis-and-data-types.md §9.2, §9.6).
//!
//! Attributes that are texts or lists, and those that a tag shows (feed override, injected faults), are not here.

use crate::Object;

/// A numeric attribute of an axis or a coordinate system.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Attribute {
    /// The class that has it.
    pub object: Object,
    /// Its name in GSV and SSV, such as `MaximumSpeed`.
    pub name: &'static str,
    /// Its number in the attribute services.
    pub number: u16,
    /// Its meaning.
    pub quantity: Quantity,
}

/// The quantity of an [`Attribute`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Quantity {
    /// Maximum Speed, position units/s.
    MaximumSpeed,
    /// Maximum Acceleration, position units/s².
    MaximumAcceleration,
    /// Maximum Deceleration, position units/s².
    MaximumDeceleration,
    /// Maximum Acceleration Jerk, position units/s³.
    MaximumAccelerationJerk,
    /// Maximum Deceleration Jerk, position units/s³.
    MaximumDecelerationJerk,
    /// Actual Position Tolerance, position units.
    ActualPositionTolerance,
    /// Command Position Tolerance, position units.
    CommandPositionTolerance,
    /// Dynamics Configuration Bits, a sum of bits up to [`DYNAMICS_CONFIGURATION_BITS`].
    DynamicsConfigurationBits,
    /// Home Position, position units; of a rotary axis the rest within one turn counts.
    HomePosition,
    /// Home Offset, position units.
    HomeOffset,
    /// Home Speed, position units/s.
    HomeSpeed,
    /// Home Return Speed, position units/s.
    HomeReturnSpeed,
}

/// A value of an attribute that is set while the machine runs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Setting {
    /// The class of the object.
    pub object: Object,
    /// The index of the object in its class.
    pub index: u16,
    /// The quantity.
    pub quantity: Quantity,
    /// The value, in the quantity's unit.
    pub value: f64,
}

impl Setting {
    /// Whether this is the value of an attribute of an object.
    #[must_use]
    pub fn is_of(&self, attribute: &Attribute, index: u16) -> bool {
        (self.object, self.index, self.quantity) == (attribute.object, index, attribute.quantity)
    }
}

/// All Dynamics Configuration Bits.
pub const DYNAMICS_CONFIGURATION_BITS: u32 = 7;

impl Attribute {
    /// The attribute of that name, case ignored.
    #[must_use]
    pub fn named(object: Object, name: &str) -> Option<&'static Attribute> {
        let mut all = ATTRIBUTES.iter();
        all.find(|one| one.object == object && one.name.eq_ignore_ascii_case(name))
    }

    /// The attribute of that number.
    #[must_use]
    pub fn numbered(object: Object, number: u16) -> Option<&'static Attribute> {
        ATTRIBUTES
            .iter()
            .find(|one| one.object == object && one.number == number)
    }

    /// Whether SSV and the Set Attribute services can set the attribute. The maxima of axes are limits that planned contours keep: only the
    /// configuration sets them.
    #[must_use]
    pub fn is_settable(&self) -> bool {
        let is_maximum = matches!(
            self.quantity,
            Quantity::MaximumSpeed
                | Quantity::MaximumAcceleration
                | Quantity::MaximumDeceleration
                | Quantity::MaximumAccelerationJerk
                | Quantity::MaximumDecelerationJerk
        );
        self.object == Object::CoordinateSystem || !is_maximum
    }

    /// Whether the attribute is a UDINT on the wire; any other is an LREAL.
    fn is_whole(&self) -> bool {
        self.quantity == Quantity::DynamicsConfigurationBits
    }

    /// Bytes of the attribute on the wire.
    #[must_use]
    pub fn size(&self) -> usize {
        if self.is_whole() { 4 } else { 8 }
    }

    /// A value as it travels. A number that is no UDINT becomes one that no attribute can have.
    #[must_use]
    pub fn encode(&self, value: f64) -> Vec<u8> {
        if !self.is_whole() {
            return value.to_le_bytes().to_vec();
        }
        let fits = (0.0..=f64::from(u32::MAX)).contains(&value) && value.fract() == 0.0;
        let word = if fits { value as u32 } else { u32::MAX };
        word.to_le_bytes().to_vec()
    }

    /// The value in the first bytes; `None` if there are fewer than [`Attribute::size`].
    #[must_use]
    pub fn decode(&self, bytes: &[u8]) -> Option<f64> {
        if self.is_whole() {
            bytes.first_chunk().map(|bytes| u32::from_le_bytes(*bytes).into())
        } else {
            bytes.first_chunk().map(|bytes| f64::from_le_bytes(*bytes))
        }
    }

    /// Whether the attribute can be set to a value.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        match self.quantity {
            Quantity::DynamicsConfigurationBits => {
                (0.0..=f64::from(DYNAMICS_CONFIGURATION_BITS)).contains(&value) && value.fract() == 0.0
            }
            Quantity::ActualPositionTolerance | Quantity::CommandPositionTolerance => (0.0..=f64::MAX).contains(&value),
            Quantity::HomePosition | Quantity::HomeOffset => value.is_finite(),
            _ => value > 0.0 && value.is_finite(),
        }
    }

    /// The values that the attribute can be set to, as a phrase.
    #[must_use]
    pub fn range(&self) -> &'static str {
        match self.quantity {
            Quantity::DynamicsConfigurationBits => "a whole number from 0 to 7",
            Quantity::ActualPositionTolerance | Quantity::CommandPositionTolerance => "a number from 0 on",
            Quantity::HomePosition | Quantity::HomeOffset => "a number",
            _ => "a number above 0",
        }
    }
}

/// Every attribute of the table.
pub const ATTRIBUTES: &[Attribute] = &[
    axis("MaximumSpeed", 3, Quantity::MaximumSpeed),
    axis("MaximumAcceleration", 4, Quantity::MaximumAcceleration),
    axis("MaximumDeceleration", 5, Quantity::MaximumDeceleration),
    axis("MaximumAccelerationJerk", 6, Quantity::MaximumAccelerationJerk),
    axis("MaximumDecelerationJerk", 7, Quantity::MaximumDecelerationJerk),
    axis("DynamicsConfigurationBits", 11, Quantity::DynamicsConfigurationBits),
    axis("HomePosition", 89, Quantity::HomePosition),
    axis("HomeOffset", 90, Quantity::HomeOffset),
    axis("HomeSpeed", 112, Quantity::HomeSpeed),
    axis("HomeReturnSpeed", 113, Quantity::HomeReturnSpeed),
    system("MaximumSpeed", 3, Quantity::MaximumSpeed),
    system("MaximumAcceleration", 4, Quantity::MaximumAcceleration),
    system("MaximumDeceleration", 5, Quantity::MaximumDeceleration),
    system("MaximumAccelerationJerk", 6, Quantity::MaximumAccelerationJerk),
    system("MaximumDecelerationJerk", 7, Quantity::MaximumDecelerationJerk),
    system("ActualPositionTolerance", 8, Quantity::ActualPositionTolerance),
    system("CommandPositionTolerance", 9, Quantity::CommandPositionTolerance),
    system("DynamicsConfigurationBits", 26, Quantity::DynamicsConfigurationBits),
];

const fn axis(name: &'static str, number: u16, quantity: Quantity) -> Attribute {
    Attribute {
        object: Object::Axis,
        name,
        number,
        quantity,
    }
}

const fn system(name: &'static str, number: u16, quantity: Quantity) -> Attribute {
    Attribute {
        object: Object::CoordinateSystem,
        name,
        number,
        quantity,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_travel_whole() {
        for one in ATTRIBUTES {
            let bytes = one.encode(5.0);
            assert_eq!(
                (bytes.len(), one.decode(&bytes)),
                (one.size(), Some(5.0)),
                "{}",
                one.name
            );
            assert_eq!(one.decode(&bytes[1..]), None, "{}", one.name);
            for value in [-1.0, 0.5, 1e10, f64::NAN] {
                let travelled = one.decode(&one.encode(value));
                let is_refused = one.is_whole() && !travelled.is_some_and(|value| one.holds(value));
                assert!(
                    is_refused || travelled.map(f64::to_bits) == Some(value.to_bits()),
                    "{}: {value}",
                    one.name
                );
            }
        }
    }

    #[test]
    fn names_and_numbers_of_a_class_are_unique() {
        for one in ATTRIBUTES {
            assert_eq!(Attribute::named(one.object, &one.name.to_uppercase()), Some(one));
            assert_eq!(Attribute::numbered(one.object, one.number), Some(one));
        }
        assert_eq!(Attribute::named(Object::Axis, "ActualPositionTolerance"), None);
        assert_eq!(Attribute::numbered(Object::MotionGroup, 3), None);
    }
}
