//! The attributes of axes and coordinate systems without a tag: numbers of the machine, some of which clients can set, the progress of moves, and
//! faults by kind.
//!
//! The image has the only copy of settable attributes outside the controller: every interface that sets them writes them here, and the caller sends
//! the controller the change ([`WriteEffect::Setting`]). They start at the machine's values, also after a restart.

use arcline_instruction_set::{ATTRIBUTES, Attribute, AxisId, FaultSet, Object, Quantity, Setting, SystemId};

use super::{Image, WriteEffect, WriteError};
use crate::Snapshot;
use crate::machine::Machine;

/// The settable attributes of every axis, then of every coordinate system, in configuration order.
#[derive(Clone, Debug, Default)]
pub(super) struct Attributes(Vec<Setting>);

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
        let axes = (0..).take(machine.axes.len()).map(|index| (Object::Axis, index));
        let systems = (0..).take(machine.systems.len());
        let systems = systems.map(|index| (Object::CoordinateSystem, index));
        let settings = axes.chain(systems).flat_map(|(object, index)| {
            let settable = ATTRIBUTES
                .iter()
                .filter(move |one| one.object == object && one.is_settable());
            settable.filter_map(move |attribute| {
                Some(Setting {
                    object,
                    index,
                    quantity: attribute.quantity,
                    value: configured(machine, attribute, index)?,
                })
            })
        });
        Attributes(settings.collect())
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

    /// The settable attributes of every axis, then of every coordinate system.
    pub fn settings(&self) -> &[Setting] {
        &self.attributes.0
    }

    /// The value of an attribute of an object of the image's machine; `None`: no such object.
    pub fn attribute(&self, machine: &Machine, attribute: &Attribute, index: u16) -> Option<f64> {
        if !attribute.is_settable() {
            return configured(machine, attribute, index);
        }
        let mut settings = self.attributes.0.iter();
        settings
            .find(|one| one.is_of(attribute, index))
            .map(|setting| setting.value)
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
        if !attribute.holds(value) {
            let range = attribute.range();
            return Err(WriteError::NotInRange { name, value, range });
        }
        let mut settings = self.attributes.0.iter_mut();
        let setting = settings
            .find(|one| one.is_of(attribute, index))
            .ok_or(WriteError::NoSuchTag)?;
        setting.value = value;
        Ok(WriteEffect::Setting)
    }
}

/// The value of an attribute in the configuration; `None`: no such object.
fn configured(machine: &Machine, attribute: &Attribute, index: u16) -> Option<f64> {
    let index = usize::from(index);
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
                Quantity::DynamicsConfigurationBits => axis.dynamics_bits.bits().into(),
                Quantity::HomePosition => axis.home.position,
                Quantity::HomeOffset => axis.home.offset,
                Quantity::HomeSpeed => axis.home.speed,
                Quantity::HomeReturnSpeed => axis.home.return_speed,
                Quantity::ActualPositionTolerance | Quantity::CommandPositionTolerance => return None,
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
                Quantity::DynamicsConfigurationBits => system.dynamics_bits.bits().into(),
                Quantity::HomePosition | Quantity::HomeOffset | Quantity::HomeSpeed | Quantity::HomeReturnSpeed => {
                    return None;
                }
            })
        }
    }
}
