//! The right to drive: an axis is one viewer's at a time, and a coordinate system is its axes. Whoever takes something takes
//! it from nobody unless by force, and everybody sees who has what. Stopping needs no right.

use std::collections::{BTreeMap, BTreeSet};

use arcline_controller::machine::Machine;
use arcline_instruction_set::Object;

/// A viewer.
pub(super) type ViewerId = u64;

/// Who drives what.
#[derive(Debug, Default)]
pub(super) struct Rights {
    /// Names of viewers.
    names: BTreeMap<ViewerId, String>,
    /// Objects that were taken: by whom.
    taken: BTreeMap<Thing, ViewerId>,
}

/// Something that can be driven, by its place.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Thing {
    Axis(u16),
    System(u16),
    Group,
}

/// Somebody else drives it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Held {
    /// What, as it was taken.
    pub(super) thing: Thing,
    /// By whom.
    pub(super) by: String,
}

impl Thing {
    /// What an object's name means.
    pub(super) fn find(machine: &Machine, name: &str) -> Option<Self> {
        let system = machine.system(name).map(Self::System);
        let axis = machine.axis(name).map(Self::Axis);
        system
            .or(axis)
            .or_else(|| machine.is_group(name).then_some(Self::Group))
    }

    /// An object of an instruction.
    pub(super) fn of(object: Object, place: u16) -> Self {
        match object {
            Object::Axis => Self::Axis(place),
            Object::CoordinateSystem => Self::System(place),
            Object::MotionGroup => Self::Group,
        }
    }

    pub(super) fn name(self, machine: &Machine) -> &str {
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
    pub(super) fn axes(self, machine: &Machine) -> BTreeSet<u16> {
        match self {
            Self::Axis(place) => BTreeSet::from([place]),
            Self::System(place) => {
                let system = machine.systems.get(usize::from(place));
                system
                    .map(|system| system.axes.iter().copied().collect())
                    .unwrap_or_default()
            }
            Self::Group => (0..machine.axes.len() as u16).collect(),
        }
    }
}

impl Rights {
    pub(super) fn enter(&mut self, viewer: ViewerId, name: String) {
        self.names.insert(viewer, name);
    }

    /// A viewer goes, and everything that it drives is free.
    pub(super) fn leave(&mut self, viewer: ViewerId) {
        self.names.remove(&viewer);
        self.taken.retain(|_, by| *by != viewer);
    }

    pub(super) fn name(&self, viewer: ViewerId) -> &str {
        self.names.get(&viewer).map_or("", String::as_str)
    }

    /// Gives a viewer the right to drive something.
    ///
    /// # Errors
    /// Another viewer drives one of its axes, and there is no force. By force that one loses what has these axes.
    pub(super) fn take(&mut self, machine: &Machine, viewer: ViewerId, thing: Thing, force: bool) -> Result<(), Held> {
        if !force && let Some(held) = self.held(machine, viewer, thing) {
            return Err(held);
        }
        let axes = thing.axes(machine);
        self.taken
            .retain(|other, by| *by == viewer || other.axes(machine).is_disjoint(&axes));
        self.taken.insert(thing, viewer);
        Ok(())
    }

    /// Takes the right back.
    pub(super) fn release(&mut self, viewer: ViewerId, thing: Thing) {
        if self.taken.get(&thing) == Some(&viewer) {
            self.taken.remove(&thing);
        }
    }

    /// Who else drives one of its axes.
    fn held(&self, machine: &Machine, viewer: ViewerId, thing: Thing) -> Option<Held> {
        let axes = thing.axes(machine);
        let mut others = self.taken.iter().filter(|(_, by)| **by != viewer);
        let (thing, by) = others.find(|(other, _)| !other.axes(machine).is_disjoint(&axes))?;
        Some(Held {
            thing: *thing,
            by: self.name(*by).to_owned(),
        })
    }

    /// Whether a viewer may drive something: it has all of its axes.
    ///
    /// # Errors
    /// Who else drives it; `None`: nobody.
    pub(super) fn check(&self, machine: &Machine, viewer: ViewerId, thing: Thing) -> Result<(), Option<Held>> {
        let own = self.taken.iter().filter(|(_, by)| **by == viewer);
        let own: BTreeSet<u16> = own.flat_map(|(thing, _)| thing.axes(machine)).collect();
        if thing.axes(machine).is_subset(&own) {
            Ok(())
        } else {
            Err(self.held(machine, viewer, thing))
        }
    }

    /// The driver of every object that has one: what was taken, and its axes.
    pub(super) fn drivers(&self, machine: &Machine) -> BTreeMap<String, String> {
        let mut drivers = BTreeMap::new();
        for (thing, by) in &self.taken {
            let name = self.name(*by);
            drivers.insert(thing.name(machine).to_owned(), name.to_owned());
            for axis in thing.axes(machine) {
                drivers.insert(Thing::Axis(axis).name(machine).to_owned(), name.to_owned());
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
        let thing = |name: &str| Thing::find(&machine, name).expect(name);
        let mut rights = Rights::default();
        rights.enter(1, "one".into());
        rights.enter(2, "two".into());
        assert_eq!(
            rights.check(&machine, 1, thing("CS1")),
            Err(None),
            "nothing is given by itself"
        );
        assert_eq!(rights.take(&machine, 1, thing("CS1"), false), Ok(()));
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
            assert_eq!(rights.check(&machine, 1, thing(name)).is_ok(), may, "{why}");
            let refused = rights.take(&machine, 2, thing(name), false).err();
            let held = held.map(|name| Held {
                thing: thing(name),
                by: "one".into(),
            });
            assert_eq!(refused, held, "{why}");
            rights.release(2, thing(name));
        }
        assert_eq!(
            rights.drivers(&machine).keys().collect::<Vec<_>>(),
            ["CS1", "X", "Y", "Z"]
        );
        assert_eq!(rights.take(&machine, 2, thing("X"), true), Ok(()), "by force");
        assert_eq!(
            rights.check(&machine, 1, thing("Y")),
            Err(None),
            "the whole system is lost"
        );
        rights.leave(2);
        assert!(rights.drivers(&machine).is_empty());
        assert_eq!(rights.check(&machine, 2, thing("X")), Err(None));
    }
}
