//! Control of objects by viewers of the page: one viewer at a time has control of an axis, and control of a coordinate system is
//! control of its axes. A viewer takes control from another one by force only, and every viewer sees all controllers. Stops need no
//! control.

use std::collections::{BTreeMap, BTreeSet};

use arcline_controller::machine::Machine;
use arcline_instruction_set::{AxisId, Object, SystemId};

/// A viewer.
pub(crate) type ViewerId = u64;

/// The viewer that has control of each object.
#[derive(Debug, Default)]
pub(crate) struct Control {
    /// Names of viewers.
    names: BTreeMap<ViewerId, String>,
    /// The viewer of each object that was taken.
    taken: BTreeMap<MotionObject, ViewerId>,
}

/// An object that moves, by its index.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum MotionObject {
    Axis(AxisId),
    System(SystemId),
    Group,
}

/// Another viewer has control of an object.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Conflict {
    /// The object, as it was taken.
    pub(crate) object: MotionObject,
    /// The name of the viewer.
    pub(crate) by: String,
}

impl MotionObject {
    /// The object of a name.
    pub(crate) fn find(machine: &Machine, name: &str) -> Option<Self> {
        let system = machine.system(name).map(Self::System);
        let axis = machine.axis(name).map(Self::Axis);
        system
            .or(axis)
            .or_else(|| machine.is_group(name).then_some(Self::Group))
    }

    /// An object of an instruction.
    pub(crate) fn of(object: Object, place: u16) -> Self {
        match object {
            Object::Axis => Self::Axis(AxisId(place)),
            Object::CoordinateSystem => Self::System(SystemId(place)),
            Object::MotionGroup => Self::Group,
        }
    }

    pub(crate) fn name(self, machine: &Machine) -> &str {
        let name = match self {
            Self::Axis(place) => machine.axes.get(usize::from(place)).map(|axis| axis.name.as_str()),
            Self::System(place) => machine
                .systems
                .get(usize::from(place))
                .map(|system| system.name.as_str()),
            Self::Group => Some(machine.group.as_str()),
        };
        name.unwrap_or_default()
    }

    /// Its axes.
    pub(crate) fn axes(self, machine: &Machine) -> BTreeSet<AxisId> {
        match self {
            Self::Axis(place) => BTreeSet::from([place]),
            Self::System(place) => {
                let system = machine.systems.get(usize::from(place));
                system
                    .map(|system| system.axes.iter().copied().collect())
                    .unwrap_or_default()
            }
            Self::Group => AxisId::first(machine.axes.len()).collect(),
        }
    }
}

impl Control {
    pub(crate) fn enter(&mut self, viewer: ViewerId, name: String) {
        self.names.insert(viewer, name);
    }

    /// A viewer goes, and with it its control of all objects.
    pub(crate) fn leave(&mut self, viewer: ViewerId) {
        self.names.remove(&viewer);
        self.taken.retain(|_, by| *by != viewer);
    }

    pub(crate) fn name(&self, viewer: ViewerId) -> &str {
        self.names.get(&viewer).map_or("", String::as_str)
    }

    /// Gives a viewer control of an object.
    ///
    /// # Errors
    /// Another viewer has control of one of its axes, and there is no force. By force that viewer loses the objects with these axes.
    pub(crate) fn take(
        &mut self,
        machine: &Machine,
        viewer: ViewerId,
        object: MotionObject,
        force: bool,
    ) -> Result<(), Conflict> {
        if !force && let Some(held) = self.held(machine, viewer, object) {
            return Err(held);
        }
        let axes = object.axes(machine);
        self.taken
            .retain(|other, by| *by == viewer || other.axes(machine).is_disjoint(&axes));
        self.taken.insert(object, viewer);
        Ok(())
    }

    /// Ends the control of an object.
    pub(crate) fn release(&mut self, viewer: ViewerId, object: MotionObject) {
        if self.taken.get(&object) == Some(&viewer) {
            self.taken.remove(&object);
        }
    }

    /// The control that another viewer has of one of its axes.
    fn held(&self, machine: &Machine, viewer: ViewerId, object: MotionObject) -> Option<Conflict> {
        let axes = object.axes(machine);
        let mut others = self.taken.iter().filter(|(_, by)| **by != viewer);
        let (object, by) = others.find(|(other, _)| !other.axes(machine).is_disjoint(&axes))?;
        Some(Conflict {
            object: *object,
            by: self.name(*by).to_owned(),
        })
    }

    /// Checks that a viewer has control of all axes of an object.
    ///
    /// # Errors
    /// The control that another viewer has of it; `None`: no viewer has.
    pub(crate) fn check(
        &self,
        machine: &Machine,
        viewer: ViewerId,
        object: MotionObject,
    ) -> Result<(), Option<Conflict>> {
        let own = self.taken.iter().filter(|(_, by)| **by == viewer);
        let own: BTreeSet<AxisId> = own.flat_map(|(object, _)| object.axes(machine)).collect();
        if object.axes(machine).is_subset(&own) {
            Ok(())
        } else {
            Err(self.held(machine, viewer, object))
        }
    }

    /// The controller of every object that has one: objects that were taken, and their axes.
    pub(crate) fn drivers(&self, machine: &Machine) -> BTreeMap<String, String> {
        let mut drivers = BTreeMap::new();
        for (object, by) in &self.taken {
            let name = self.name(*by);
            drivers.insert(object.name(machine).to_owned(), name.to_owned());
            for axis in object.axes(machine) {
                drivers.insert(MotionObject::Axis(axis).name(machine).to_owned(), name.to_owned());
            }
        }
        drivers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_one_viewers() {
        let machine = arcline_config::load(arcline_config::DEFAULT, "default")
            .expect("it is valid")
            .machine;
        let object = |name: &str| MotionObject::find(&machine, name).expect(name);
        let mut control = Control::default();
        control.enter(1, "one".into());
        control.enter(2, "two".into());
        assert_eq!(
            control.check(&machine, 1, object("CS1")),
            Err(None),
            "nothing is given by itself"
        );
        assert_eq!(control.take(&machine, 1, object("CS1"), false), Ok(()));
        #[rustfmt::skip]
        let cases = [
            ("the system itself",    "CS1",    true,  Some("CS1")),
            ("one of its axes",      "y",      true,  Some("CS1")),
            ("a system within it",   "XY",     true,  Some("CS1")),
            ("a system beside it",   "CS2",    false, Some("CS1")),
            ("another system",       "CS3",    false, None),
            ("everything",           "Motion", false, Some("CS1")),
        ];
        for (why, name, may, held) in cases {
            assert_eq!(control.check(&machine, 1, object(name)).is_ok(), may, "{why}");
            let refused = control.take(&machine, 2, object(name), false).err();
            let held = held.map(|name| Conflict {
                object: object(name),
                by: "one".into(),
            });
            assert_eq!(refused, held, "{why}");
            control.release(2, object(name));
        }
        assert_eq!(
            control.drivers(&machine).keys().collect::<Vec<_>>(),
            ["CS1", "X", "Y", "Z"]
        );
        assert_eq!(control.take(&machine, 2, object("X"), true), Ok(()), "by force");
        assert_eq!(
            control.check(&machine, 1, object("Y")),
            Err(None),
            "the whole system is lost"
        );
        control.leave(2);
        assert!(control.drivers(&machine).is_empty());
        assert_eq!(control.check(&machine, 2, object("X")), Err(None));
    }
}
