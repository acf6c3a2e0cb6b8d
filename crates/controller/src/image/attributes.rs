//! The attributes of axes and coordinate systems without a tag: numbers of the machine, the progress of moves, faults by kind, and the Dynamics
//! Configuration Bits, which clients can set.
//!
//! The image is the only copy of these bits outside the controller: every interface that sets them writes them here, and the caller sends the
//! controller the change ([`WriteEffect::DynamicsBits`]). They start at the machine's values, also after a restart.

use arcline_instruction_set::{Attribute, AxisId, DYNAMICS_CONFIGURATION_BITS, FaultSet, Object, Quantity, SystemId};

use super::{Image, WriteEffect, WriteError};
use crate::Snapshot;
use crate::machine::{DynamicsBits, Machine};

/// The Dynamics Configuration Bits of every axis and every coordinate system, in configuration order.
#[derive(Clone, Debug, Default)]
pub(super) struct Attributes {
    axes: Vec<DynamicsBits>,
    systems: Vec<DynamicsBits>,
}

/// The active move of a coordinate system.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct MoveProgress {
    /// Distance to go along its path, units.
    pub remaining: f64,
    /// Length of its path, units; 0: no move is active.
    pub length: f64,
    /// Seconds until its end or its successor, as planned now; NaN: unknown.
    pub time_left: f64,
}

/// The values of the newest snapshot that only attributes show.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    /// The active moves of all coordinate systems, in configuration order.
    progress: Vec<MoveProgress>,
    /// The faults of all axes, in configuration order.
    faults: Vec<FaultSet>,
}

impl Attributes {
    pub(super) fn new(machine: &Machine) -> Self {
        Attributes {
            axes: machine.axes.iter().map(|axis| axis.dynamics_bits).collect(),
            systems: machine.systems.iter().map(|system| system.dynamics_bits).collect(),
        }
    }
}

impl Image {
    /// The active move of a coordinate system; `None`: no such system.
    pub fn progress(&self, system: SystemId) -> Option<MoveProgress> {
        self.shown.progress.get(usize::from(system)).copied()
    }

    /// The faults of an axis; `None`: no such axis.
    pub fn faults(&self, axis: AxisId) -> Option<FaultSet> {
        self.shown.faults.get(usize::from(axis)).copied()
    }

    /// Takes over the values of a snapshot that only attributes show.
    pub(super) fn show_attributes(&mut self, snapshot: &Snapshot) {
        let Shown { progress, faults } = &mut self.shown;
        progress.clear();
        progress.extend(snapshot.systems.iter().map(|system| MoveProgress {
            remaining: (system.path_length - system.path_position).max(0.0),
            length: system.path_length,
            time_left: system.time_left.unwrap_or(f64::NAN),
        }));
        faults.clear();
        faults.extend(snapshot.axes.iter().map(|axis| axis.faults));
    }

    /// The Dynamics Configuration Bits of every axis, then of every coordinate system: class, index and bits.
    pub fn dynamics_bits(&self) -> impl Iterator<Item = (Object, u16, DynamicsBits)> {
        let axes = (0..).zip(&self.attributes.axes);
        let axes = axes.map(|(index, bits)| (Object::Axis, index, *bits));
        let systems = (0..).zip(&self.attributes.systems);
        axes.chain(systems.map(|(index, bits)| (Object::CoordinateSystem, index, *bits)))
    }

    /// The value of an attribute of an object of the image's machine; `None`: no such object.
    pub fn attribute(&self, machine: &Machine, attribute: &Attribute, index: u16) -> Option<f64> {
        let index = usize::from(index);
        if attribute.quantity == Quantity::DynamicsConfigurationBits {
            let bits = match attribute.object {
                Object::MotionGroup => return None,
                Object::Axis => self.attributes.axes.get(index),
                Object::CoordinateSystem => self.attributes.systems.get(index),
            };
            return Some(bits?.bits().into());
        }
        match attribute.object {
            Object::MotionGroup => None,
            Object::Axis => {
                let axis = machine.axes.get(index)?;
                Some(match attribute.quantity {
                    Quantity::MaximumSpeed => axis.max_speed,
                    Quantity::MaximumAcceleration => axis.max_acceleration,
                    Quantity::MaximumDeceleration => axis.max_deceleration,
                    Quantity::MaximumAccelerationJerk => axis.max_acceleration_jerk,
                    Quantity::MaximumDecelerationJerk => axis.max_deceleration_jerk,
                    Quantity::ActualPositionTolerance
                    | Quantity::CommandPositionTolerance
                    | Quantity::DynamicsConfigurationBits => return None,
                })
            }
            Object::CoordinateSystem => {
                let system = machine.systems.get(index)?;
                Some(match attribute.quantity {
                    Quantity::MaximumSpeed => system.max_speed,
                    Quantity::MaximumAcceleration => system.max_acceleration,
                    Quantity::MaximumDeceleration => system.max_deceleration,
                    Quantity::MaximumAccelerationJerk => system.max_acceleration_jerk,
                    Quantity::MaximumDecelerationJerk => system.max_deceleration_jerk,
                    Quantity::ActualPositionTolerance => system.actual_tolerance,
                    Quantity::CommandPositionTolerance => system.command_tolerance,
                    Quantity::DynamicsConfigurationBits => return None,
                })
            }
        }
    }

    /// Sets an attribute of an object.
    ///
    /// # Errors
    /// [`WriteError::NotSettable`] for a read-only attribute, [`WriteError::NotInRange`] for a value outside of its range,
    /// [`WriteError::NoSuchTag`] if the object does not exist; the image is unchanged then.
    pub fn set_attribute(&mut self, attribute: &Attribute, index: u16, value: f64) -> Result<WriteEffect, WriteError> {
        let name = attribute.name;
        if !attribute.is_settable() {
            return Err(WriteError::NotSettable { name });
        }
        let most = DYNAMICS_CONFIGURATION_BITS;
        if !(0.0..=f64::from(most)).contains(&value) || value.fract() != 0.0 {
            return Err(WriteError::NotInRange { name, value, most });
        }
        let bits = match attribute.object {
            Object::MotionGroup => return Err(WriteError::NoSuchTag),
            Object::Axis => &mut self.attributes.axes,
            Object::CoordinateSystem => &mut self.attributes.systems,
        };
        let bits = bits.get_mut(usize::from(index)).ok_or(WriteError::NoSuchTag)?;
        *bits = DynamicsBits::from_bits(value as u32);
        Ok(WriteEffect::DynamicsBits)
    }
}
