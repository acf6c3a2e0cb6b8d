//! The attributes of axes and coordinate systems that clients set while the machine runs (spec/axis-and-data-types.md §9.6).

use arcline_instruction_set::{AxisId, Object, Quantity, Setting, SystemId};
use arcline_profile::numeric::modulo;

use crate::axis::Axis;
use crate::machine::DynamicsBits;
use crate::motion::Motion;
use crate::system::System;

impl Motion {
    /// Sets an attribute of an axis or a coordinate system. Later instructions and stops follow it; a motion that is planned already does not
    /// change. An attribute that cannot be set, and an index without an object, change nothing. Real-time.
    pub fn set(&mut self, setting: Setting) {
        match setting.object {
            Object::MotionGroup => {}
            Object::Axis => {
                if let Some(axis) = self.axes.get_mut(AxisId(setting.index)) {
                    axis.set(setting.quantity, setting.value);
                }
            }
            Object::CoordinateSystem => {
                if let Some(system) = self.systems.get_mut(SystemId(setting.index)) {
                    system.set(setting.quantity, setting.value);
                }
            }
        }
    }
}

impl Axis {
    fn set(&mut self, quantity: Quantity, value: f64) {
        let home = &mut self.next_home;
        match quantity {
            Quantity::HomePosition => home.position = self.unwind.map_or(value, |turn| modulo(value, turn)),
            Quantity::HomeOffset => home.offset = value,
            Quantity::HomeSpeed => home.speed = value,
            Quantity::HomeReturnSpeed => home.return_speed = value,
            Quantity::DynamicsConfigurationBits => self.dynamics_bits = bits(value),
            Quantity::MaximumSpeed
            | Quantity::MaximumAcceleration
            | Quantity::MaximumDeceleration
            | Quantity::MaximumAccelerationJerk
            | Quantity::MaximumDecelerationJerk
            | Quantity::ActualPositionTolerance
            | Quantity::CommandPositionTolerance => {}
        }
    }
}

impl System {
    fn set(&mut self, quantity: Quantity, value: f64) {
        let description = &mut self.description;
        match quantity {
            Quantity::MaximumSpeed => description.max_speed = value,
            Quantity::MaximumAcceleration => description.max_acceleration = value,
            Quantity::MaximumDeceleration => description.max_deceleration = value,
            Quantity::MaximumAccelerationJerk => description.max_acceleration_jerk = value,
            Quantity::MaximumDecelerationJerk => description.max_deceleration_jerk = value,
            Quantity::ActualPositionTolerance => description.actual_tolerance = value,
            Quantity::CommandPositionTolerance => description.command_tolerance = value,
            Quantity::DynamicsConfigurationBits => self.travel.set_dynamics_bits(bits(value)),
            Quantity::HomePosition | Quantity::HomeOffset | Quantity::HomeSpeed | Quantity::HomeReturnSpeed => {}
        }
    }
}

fn bits(value: f64) -> DynamicsBits {
    DynamicsBits::from_bits(value as u32)
}
