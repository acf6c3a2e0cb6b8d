//! The names of a machine for the routines of a project, and where the project's tags stand in the tag memory.

use std::collections::{BTreeMap, BTreeSet};
use std::iter;

use arcline_controller::Input;
use arcline_controller::image::{Access, Image, PlainTag, ProjectPart, TableError, TagId, TagKind};
use arcline_controller::machine::Machine;
use arcline_instruction_set::{Attribute, AxisId, ControlSlot, Directory as _, Object};
use arcline_routine::source::{self, Project};
use arcline_routine::{Cell, Directory, Tag};
use arcline_tag::{Elementary, PathSegment, TagPath, TagType};

/// The names of a machine, for a project that is being loaded.
#[derive(Debug)]
pub struct Names<'m> {
    machine: &'m Machine,
    image: &'m mut Image,
    attributes: Vec<(&'static Attribute, u16)>,
    /// Inputs of axes that wires lead to.
    inputs: Vec<(AxisId, WiredInput)>,
    /// Motion control structures inside of tags.
    inside: Vec<(ControlSlot, String)>,
    /// Tags that were made for instructions that name them.
    created: BTreeSet<TagId>,
}

/// The positions of a project's tags.
#[derive(Debug, Default)]
pub struct Places {
    /// The tags that clients see too, by their first byte in the project's memory.
    pub tags: Vec<Placed>,
    /// Axes, coordinate systems and the group: first byte in the project's memory, and the tag.
    pub objects: Vec<(u32, TagId)>,
    /// The attributes that the project reads or sets.
    pub attributes: Vec<(&'static Attribute, u16)>,
    /// The inputs of axes that its wires lead to.
    inputs: Vec<(AxisId, WiredInput)>,
}

/// An input of an axis that a wire can lead to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum WiredInput {
    HomeSwitch,
    Enable,
    Registration(u8),
}

impl WiredInput {
    /// Their names behind that of the axis.
    const ALL: [(&'static str, Self); 4] = [
        (arcline_config::HOME_SWITCH, Self::HomeSwitch),
        ("enable", Self::Enable),
        ("registration_1", Self::Registration(0)),
        ("registration_2", Self::Registration(1)),
    ];
}

/// A tag in both memories.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// The first byte in the project's memory.
    pub from: usize,
    /// Its end there.
    pub to: usize,
    /// The tag.
    pub id: TagId,
}

/// A tag of a project that cannot stand in the tag memory.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("tag {name}: {error}")]
pub struct NotPlaced {
    name: String,
    error: TableError,
}

impl<'m> Names<'m> {
    /// The names of a machine and of the tags in its memory.
    pub fn new(machine: &'m Machine, image: &'m mut Image) -> Self {
        Names {
            machine,
            image,
            attributes: Vec::new(),
            inputs: Vec::new(),
            inside: Vec::new(),
            created: BTreeSet::new(),
        }
    }

    /// Makes the tags of a project, that was loaded with these names, tags of the machine. Tags that are there keep their values.
    ///
    /// # Errors
    /// The first tag for which there is no place; some tags are placed then.
    pub fn place(self, cell: &mut Cell, project: &Project) -> Result<Places, NotPlaced> {
        let Names {
            image,
            attributes,
            inputs,
            inside,
            created,
            ..
        } = self;
        let mut places = Places {
            attributes,
            inputs,
            ..Places::default()
        };
        let wanted = wanted(cell, image);
        for tag in cell.tags() {
            if is_object(image, tag)
                && let Some(known) = image.find(&tag.name)
            {
                places.objects.push((tag.at, known.id));
            }
        }
        for (place, tag) in wanted {
            let id = image.add_program_tag(&tag).map_err(|error| NotPlaced {
                name: full_name(&tag),
                error,
            })?;
            let Some(at) = cell.tags().get(place).map(|tag| tag.at as usize) else {
                continue;
            };
            if created.contains(&id) {
                image.store(id, &tag.first);
            }
            let bytes = image.bytes(id);
            cell.memory_mut().write(at, bytes);
            places.tags.push(Placed {
                from: at,
                to: at + bytes.len(),
                id,
            });
        }
        places.tags.sort_by_key(|tag| tag.from);
        for (slot, path) in inside {
            let at = cell.controls().iter().find(|(_, known)| *known == slot);
            let at = at.map_or(usize::MAX, |(at, _)| *at as usize);
            if let Some(tag) = places.tag_at(at) {
                image.place_control(slot, tag.id, at - tag.from, &path);
            }
        }
        place_aliases(image, project);
        let listed = image.list_project(parts(project));
        listed.map_err(|(name, error)| NotPlaced { name, error })?;
        Ok(places)
    }
}

/// Removes the tags of a program that the project of another cell does not have, or has with another type.
pub fn remove_others(image: &mut Image, cell: &Cell) {
    let wanted = wanted(cell, image).into_iter();
    let wanted: BTreeMap<String, TagType> = wanted
        .map(|(_, tag)| (full_name(&tag).to_ascii_lowercase(), tag.tag_type))
        .collect();
    let kept: BTreeSet<TagId> = image
        .tags()
        .iter()
        .filter(|tag| {
            let name = image.full_name(tag).to_ascii_lowercase();
            wanted.get(&name) == Some(&tag.tag_type) && !matches!(tag.kind, TagKind::Alias(_))
        })
        .map(|tag| tag.id)
        .collect();
    image.remove_program_tags(|id| kept.contains(&id));
}

/// The tags that clients are to see, with their numbers in the cell.
fn wanted(cell: &Cell, image: &mut Image) -> Vec<(usize, PlainTag)> {
    (0..)
        .zip(cell.tags())
        .filter(|(_, tag)| !is_object(image, tag))
        .collect::<Vec<_>>()
        .into_iter()
        .filter_map(|(place, tag)| Some((place, plain(tag, cell, image)?)))
        .collect()
}

impl Places {
    /// The place of a tag.
    pub fn tag(&self, id: TagId) -> Option<Placed> {
        self.tags.iter().find(|tag| tag.id == id).copied()
    }

    /// The command to the machine when a wire gives the input of this number a value.
    pub fn input(&self, number: u32, on: bool) -> Option<Input> {
        let (axis, input) = *self.inputs.get(number as usize)?;
        Some(match input {
            WiredInput::HomeSwitch => Input::HomeSwitch { axis, on },
            WiredInput::Enable => Input::Enable { axis, on },
            WiredInput::Registration(input) => Input::Registration { axis, input, on },
        })
    }

    /// The tag that has a byte of the project's memory.
    pub fn tag_at(&self, at: usize) -> Option<Placed> {
        let behind = self.tags.partition_point(|tag| tag.from <= at);
        let tag = self.tags.get(behind.checked_sub(1)?)?;
        (at < tag.to).then_some(*tag)
    }
}

/// Whether a tag is that of an axis, a coordinate system or the group of the machine.
fn is_object(image: &Image, tag: &Tag) -> bool {
    let known = image.find(&tag.name).filter(|_| tag.program.is_none());
    known.is_some_and(|known| is_motion_object(known.kind))
}

fn is_motion_object(kind: TagKind) -> bool {
    matches!(
        kind,
        TagKind::Axis(_) | TagKind::CoordinateSystem(_) | TagKind::MotionGroup
    )
}

/// A tag as clients see it; `None`: they do not.
fn plain(tag: &Tag, cell: &Cell, image: &mut Image) -> Option<PlainTag> {
    let access = match tag.access {
        source::Access::ReadWrite => Access::ReadWrite,
        source::Access::ReadOnly => Access::ReadOnly,
        source::Access::Hidden if image.find(&tag.full_name()).is_some() => Access::ReadOnly,
        source::Access::Hidden => return None,
    };
    let from = tag.at as usize;
    let first = cell.memory().get(from..from + tag.tag_type.size()).unwrap_or_default();
    Some(PlainTag {
        program: tag.program.clone(),
        access,
        first: first.to_vec(),
        ..PlainTag::new(tag.name.clone(), image.adopted(&tag.tag_type))
    })
}

fn full_name(tag: &PlainTag) -> String {
    match &tag.program {
        Some(program) => format!("Program:{program}.{}", tag.name),
        None => tag.name.clone(),
    }
}

/// The tasks, programs and routines of a project, as the list of tags has them.
fn parts(project: &Project) -> impl Iterator<Item = ProjectPart<'_>> {
    let tasks = project.tasks.iter().map(|task| ProjectPart::Task(&task.name));
    let programs = project.programs.iter().flat_map(|program| {
        let routines = program.routines.iter().map(|routine| ProjectPart::Routine {
            program: &program.name,
            routine: &routine.name,
        });
        iter::once(ProjectPart::Program(&program.name)).chain(routines)
    });
    tasks.chain(programs)
}

/// Makes the aliases of a project; one may stand for another that comes later.
fn place_aliases(image: &mut Image, project: &Project) {
    let of_controller = project.tags.iter().map(|tag| (None, tag));
    let programs = project.programs.iter();
    let of_programs = programs.flat_map(|program| program.tags.iter().map(|tag| (Some(program.name.as_str()), tag)));
    let mut left: Vec<_> = of_controller
        .chain(of_programs)
        .filter(|(_, tag)| tag.alias.is_some() && tag.access != source::Access::Hidden)
        .collect();
    for _ in 0..ALIAS_CHAIN {
        let before = left.len();
        left.retain(|(program, tag)| {
            let path = tag.alias.as_deref().unwrap_or_default();
            let scoped = program.map(|program| format!("Program:{program}.{path}"));
            let paths = [scoped, Some(path.to_owned())].into_iter().flatten();
            let alias = paths.filter_map(|path| path.parse::<TagPath>().ok()).find_map(|path| {
                let tag_type = alias_type(image, &path)?;
                Some((path, tag_type))
            });
            let Some((path, tag_type)) = alias else { return true };
            let access = match tag.access {
                source::Access::ReadWrite => Access::ReadWrite,
                source::Access::ReadOnly | source::Access::Hidden => Access::ReadOnly,
            };
            let alias = PlainTag {
                program: program.map(str::to_owned),
                access,
                alias: Some(path),
                ..PlainTag::new(tag.name.clone(), tag_type)
            };
            !image.add_program_alias(&alias)
        });
        if left.len() == before {
            return;
        }
    }
}

/// The type of a part of a tag.
fn alias_type(image: &Image, path: &TagPath) -> Option<TagType> {
    let (id, place) = image.locate(path).ok()?;
    let rest = path.rest();
    Some(match place.bit {
        Some(_) => TagType::scalar(Elementary::Bool),
        None if rest.is_empty() => image.tag(id)?.tag_type.clone(),
        None if place.elements > 1 && !matches!(rest.last(), Some(PathSegment::Element(_))) => {
            TagType::array(place.data_type, place.elements)
        }
        None => TagType::scalar(place.data_type),
    })
}

impl Directory for Names<'_> {
    fn object_type(&self, name: &str) -> Option<TagType> {
        let tag = self.image.find(name)?;
        is_motion_object(tag.kind).then(|| tag.tag_type.clone())
    }

    fn object(&self, object: Object, name: &str) -> Option<u16> {
        self.image.object(object, name)
    }

    fn control(&mut self, name: &str) -> Option<ControlSlot> {
        let is_whole = !name.contains(['.', '[', ':']);
        let is_new = self.image.find(name).is_none();
        if is_whole && let Ok(slot) = self.image.control_slot(name) {
            let id = self.image.find(name).map(|tag| tag.id);
            self.created.extend(id.filter(|_| is_new));
            return Some(slot);
        }
        let slot = match self.image.placed_control(name) {
            Some(slot) => slot,
            None => self.image.reserve_control()?,
        };
        self.inside.push((slot, name.to_owned()));
        Some(slot)
    }

    fn tag(&mut self, name: &str, tag_type: &TagType) -> Option<u32> {
        if let Some(tag) = self.image.find(name) {
            let fits = tag.kind == TagKind::Plain && tag.tag_type.size() == tag_type.size();
            return fits.then_some(tag.id.0);
        }
        let (program, name) = match name.strip_prefix("Program:").and_then(|name| name.split_once('.')) {
            Some((program, name)) => (Some(program.to_owned()), name),
            None => (None, name),
        };
        let tag = PlainTag {
            program,
            ..PlainTag::new(name, tag_type.clone())
        };
        let id = self.image.add_program_tag(&tag).ok()?;
        self.created.insert(id);
        Some(id.0)
    }

    fn constant(&self, object: Object, index: u16, name: &str) -> Option<f64> {
        let name = name.to_ascii_lowercase();
        if object == Object::MotionGroup || name == "interpolationtime" {
            let is_period = matches!(name.as_str(), "coarseupdateperiod" | "interpolationtime");
            return is_period.then(|| self.machine.period_ns as f64 / 1e3);
        }
        if object != Object::Axis {
            return None;
        }
        let home = &self.machine.axes.get(usize::from(index))?.home;
        Some(match name.as_str() {
            "homemode" => f64::from(home.mode as u8),
            "homesequence" => f64::from(home.sequence as u8),
            "homedirection" => f64::from(home.direction as u8),
            _ => return None,
        })
    }

    fn axis_input(&mut self, text: &str) -> Option<u32> {
        let (axis, input) = text.rsplit_once('.')?;
        let known = WiredInput::ALL
            .iter()
            .find(|(name, _)| name.eq_ignore_ascii_case(input));
        let (_, input) = known?;
        let index = self.image.object(Object::Axis, axis)?;
        self.machine.drives.get(usize::from(index))?.as_ref()?;
        self.inputs.push((AxisId(index), *input));
        Some(self.inputs.len() as u32 - 1)
    }

    fn attribute(&mut self, object: Object, index: u16, name: &str) -> Option<(u32, usize)> {
        let attribute = Attribute::named(object, name)?;
        self.image.attribute(self.machine, attribute, index)?;
        self.attributes.push((attribute, index));
        Some((self.attributes.len() as u32 - 1, 4))
    }

    fn is_settable(&self, attribute: u32) -> bool {
        let known = self.attributes.get(attribute as usize);
        known.is_some_and(|(attribute, _)| attribute.is_settable())
    }
}

/// Aliases of aliases that are followed.
const ALIAS_CHAIN: usize = 16;
