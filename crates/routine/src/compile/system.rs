//! GSV and SSV (spec/programs.md §10.8): the attributes that projects read.

use arcline_instruction_set::Object;
use arcline_tag::DataType;

use super::{Compiler, Owner, Wrong};
use crate::code::{Attribute, Cellular, NameOf, System, TaskAttribute, WallClock};
use crate::expression::Expression;
use crate::table::Op;

impl Compiler<'_> {
    /// The effect of GSV and SSV without a known attribute: 0, and a minor fault.
    pub(crate) fn missing_attribute(&mut self, operands: &[&str]) -> Option<System> {
        let area = self.area_of(operands.last()?).ok()?;
        Some(System {
            attribute: Attribute::Missing,
            area,
        })
    }

    /// The attribute and the tag; `None`: Arcline does not have it.
    pub(crate) fn system(&mut self, op: Op, operands: &[&str]) -> Result<Option<System>, Wrong> {
        let [class, instance, attribute, tag] = operands else {
            return Err(format!("{} operands, expected 4", operands.len()).into());
        };
        let area = self.area_of(tag).map_err(|reason| reason.of(tag))?;
        let (class, attribute) = (class.to_ascii_lowercase(), attribute.to_ascii_lowercase());
        if attribute == "name" {
            let Some(name) = self.name_of(&class, instance).filter(|_| op == Op::Gsv) else {
                return Ok(None);
            };
            let text = Expression::parse(tag).ok().and_then(|tag| self.text_part(&tag));
            let attribute = Attribute::Name(name, text);
            return Ok(Some(System { attribute, area }));
        }
        let found = match class.as_str() {
            "wallclocktime" => match attribute.as_str() {
                "localdatetime" | "datetime" => Some(Attribute::WallClock(WallClock::DateTime)),
                "currentvalue" => Some(Attribute::WallClock(WallClock::Microseconds)),
                _ => None,
            },
            "task" => self.task_attribute(instance, &attribute),
            "program" => self.program_attribute(instance, &attribute),
            "faultlog" => match attribute.as_str() {
                "minorfaultbits" => Some(Attribute::MinorFaults),
                "majorfaultbits" => Some(Attribute::MajorFaults),
                "minorevents" => Some(Attribute::Events(0)),
                "majorevents" => Some(Attribute::Events(1)),
                _ => None,
            },
            // A part of a project may use modules that it does not bring along, and an add-on instruction gets them by reference.
            "module" if matches!(self.owner, Owner::Program(_)) && !self.has_module(instance) => None,
            "module" => match attribute.as_str() {
                // Running, and no fault.
                "entrystatus" => Some(Attribute::Constant(Box::new(0x4000_i16.to_le_bytes()))),
                "faultcode" | "faultinfo" | "mode" | "ledstatus" | "forcestatus" | "instance" => {
                    Some(Attribute::Constant(Box::new([0; 2])))
                }
                _ => None,
            },
            "controllerdevice" => match attribute.as_str() {
                "status" => Some(Attribute::Constant(Box::new(0x0060_i16.to_le_bytes()))),
                "vendor" => Some(Attribute::Constant(Box::new(1_i16.to_le_bytes()))),
                "type" => Some(Attribute::Constant(Box::new(14_i16.to_le_bytes()))),
                // Those of the Identity object: product 1, revision 33.11.
                "productcode" => Some(Attribute::Constant(Box::new(1_i16.to_le_bytes()))),
                "productrev" => Some(Attribute::Constant(Box::new([33, 11]))),
                // The number of its characters, and those.
                "devicename" => {
                    let name = self.project.processor.bytes().take(MAX_DEVICE_NAME);
                    let name: Vec<u8> = std::iter::once(name.len() as u8).chain(name).collect();
                    Some(Attribute::Constant(name.into()))
                }
                _ => None,
            },
            "axis" | "coordinatesystem" | "motiongroup" => self.object_attribute(&class, instance, &attribute),
            _ => None,
        };
        Ok(found
            .filter(|attribute| op == Op::Gsv || self.is_settable(attribute))
            .map(|attribute| System { attribute, area }))
    }

    /// Whether SSV has an effect on an attribute. The clock is that of the run, and the configuration alone sets most numbers of the machine.
    fn is_settable(&self, attribute: &Attribute) -> bool {
        match attribute {
            Attribute::Host(number) => self.directory.is_settable(*number),
            Attribute::Record(_)
            | Attribute::DisableFlag(_)
            | Attribute::MinorFaults
            | Attribute::MajorFaults
            | Attribute::Events(_)
            | Attribute::Task(_, TaskAttribute::InhibitTask | TaskAttribute::Status) => true,
            Attribute::Task(..)
            | Attribute::WallClock(_)
            | Attribute::Name(..)
            | Attribute::Constant(_)
            | Attribute::Number(_)
            | Attribute::Member(_)
            | Attribute::Missing => false,
        }
    }

    /// Whether the project has a module of that name, or none at all.
    fn has_module(&self, name: &str) -> bool {
        let all = &self.project.modules;
        all.is_empty() || all.iter().any(|one| one.eq_ignore_ascii_case(name))
    }

    /// The program, task or routine whose name is read.
    fn name_of(&self, class: &str, instance: &str) -> Option<NameOf> {
        let is_this = instance.eq_ignore_ascii_case("THIS");
        match class {
            "program" if is_this => Some(NameOf::Program(None)),
            "program" => Some(NameOf::Program(Some(self.program_named(instance)? as u32))),
            "task" if is_this => Some(NameOf::Task(None)),
            "task" => Some(NameOf::Task(Some(self.task_named(instance)? as u32))),
            "routine" if is_this => Some(NameOf::Routine),
            _ => None,
        }
    }

    fn program_named(&self, name: &str) -> Option<usize> {
        let mut programs = self.project.programs.iter();
        programs.position(|one| one.name.eq_ignore_ascii_case(name))
    }

    fn task_named(&self, name: &str) -> Option<usize> {
        let mut tasks = self.project.tasks.iter();
        tasks.position(|one| one.name.eq_ignore_ascii_case(name))
    }

    fn task_attribute(&mut self, instance: &str, attribute: &str) -> Option<Attribute> {
        let tasks = &self.project.tasks;
        let place = if instance.eq_ignore_ascii_case("THIS") {
            let Owner::Program(program) = self.owner else {
                return None;
            };
            let name = &self.project.programs.get(program)?.name;
            tasks
                .iter()
                .position(|task| task.programs.iter().any(|one| one.eq_ignore_ascii_case(name)))
        } else {
            self.task_named(instance)
        };
        let attribute = match attribute {
            "rate" => TaskAttribute::Rate,
            "watchdog" => TaskAttribute::Watchdog,
            "priority" => TaskAttribute::Priority,
            "instance" => TaskAttribute::Instance,
            "overlapcount" => TaskAttribute::OverlapCount,
            "inhibittask" => TaskAttribute::InhibitTask,
            "status" => TaskAttribute::Status,
            "lastscantime" => TaskAttribute::LastScanTime,
            "maxscantime" => TaskAttribute::MaxScanTime,
            _ => return None,
        };
        Some(Attribute::Task(place? as u32, attribute))
    }

    fn program_attribute(&mut self, instance: &str, attribute: &str) -> Option<Attribute> {
        let place = match self.owner {
            Owner::Program(program) if instance.eq_ignore_ascii_case("THIS") => Some(program),
            _ => self.program_named(instance),
        }? as u32;
        Some(match attribute {
            "majorfaultrecord" => Attribute::Record(place),
            "disableflag" => Attribute::DisableFlag(place),
            "lastscantime" | "maxscantime" => Attribute::Constant(Box::new([0; 4])),
            _ => return None,
        })
    }

    fn object_attribute(&mut self, class: &str, instance: &str, attribute: &str) -> Option<Attribute> {
        let object = match class {
            "axis" => Object::Axis,
            "coordinatesystem" => Object::CoordinateSystem,
            _ => Object::MotionGroup,
        };
        let name = self.name_of_object(instance);
        let index = self.directory.object(object, &name)?;
        if let Some((number, _)) = self.directory.attribute(object, index, attribute) {
            return Some(Attribute::Host(number));
        }
        if let Some(value) = self.directory.constant(object, index, attribute) {
            return Some(Attribute::Number(value));
        }
        // Positions and status words are members of the object's tag.
        let reference = Expression::parse_reference(&format!("{instance}.{attribute}")).ok()?;
        let found = self.resolve(&reference).ok()?;
        match found.data_type {
            DataType::Elementary(kind) if found.bit.is_none() && !found.is_array() => {
                Some(Attribute::Member(Cellular {
                    place: found.place(),
                    kind,
                }))
            }
            _ => None,
        }
    }

    /// The name of a motion object, for which an alias may stand.
    fn name_of_object(&mut self, instance: &str) -> String {
        let place = self.area_of(instance).map(|area| area.place);
        let of_controller = place.ok().and_then(|place| place.fixed());
        let tag = of_controller.and_then(|at| self.tags.list.iter().find(|tag| tag.at == at));
        tag.map_or_else(|| instance.to_owned(), |tag| tag.name.clone())
    }
}

/// Characters of DeviceName, which has 33 bytes.
const MAX_DEVICE_NAME: usize = 32;
