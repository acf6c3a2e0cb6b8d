//! The tags of the controller's own program, which has its own memory: the image shows that memory to clients, and notes for the program all
//! changes by others. Motion control structures may be anywhere in these tags.
//!
//! Not here: the memory of the program, and the order of the exchange of changes (`arcline_server`'s `live`).

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use arcline_instruction_set::ControlSlot;
use arcline_tag::{DataType, Elementary, TagType};

use super::{Image, PlainTag, TableError, TagId, TagKind};
use crate::Event;

/// Changes of tags by others than the program, since it last took them.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct ForeignChanges {
    /// Parts of tags, in order. Their bytes are the present ones of the tags.
    pub parts: Vec<ChangedPart>,
    /// Changes of instructions, in order.
    pub events: Vec<Event>,
    /// The list of changes was full: any part of any tag may have changed.
    pub is_cut: bool,
}

/// A part of a tag that has changed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ChangedPart {
    /// The tag.
    pub tag: TagId,
    /// The first byte.
    pub offset: usize,
    /// Bytes.
    pub length: usize,
    /// The bits of each byte that have changed.
    pub mask: u8,
}

/// A part of a project that the list of tags contains, without data. Its text is its name there.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ProjectPart<'n> {
    /// A task.
    Task(&'n str),
    /// A program.
    Program(&'n str),
    /// A routine of a program.
    Routine {
        /// The program.
        program: &'n str,
        /// The routine.
        routine: &'n str,
    },
}

impl fmt::Display for ProjectPart<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ProjectPart::Task(task) => write!(out, "Task:{task}"),
            ProjectPart::Program(program) => write!(out, "Program:{program}"),
            ProjectPart::Routine { program, routine } => write!(out, "Program:{program}.Routine:{routine}"),
        }
    }
}

/// The notes for a program; `None` without a program. A copy of the image starts without notes.
#[derive(Debug, Default)]
pub(super) struct Notes(pub(super) Option<ForeignChanges>);

impl Clone for Notes {
    fn clone(&self) -> Self {
        Notes(None)
    }
}

/// The tags of the program.
#[derive(Clone, Debug, Default)]
pub(super) struct ProgramTags {
    tags: BTreeSet<TagId>,
    /// The names of the project's tasks, programs and routines in the list of tags, in lower case.
    listed: BTreeSet<String>,
    /// The slots of motion control structures inside of them, with their paths.
    controls: BTreeMap<u32, String>,
}

impl Image {
    /// Starts to note changes for the program, until [`Image::take_foreign_changes`] takes them.
    pub fn follow_for_program(&mut self) {
        self.notes.0.get_or_insert_default();
    }

    /// The program has not taken all changes.
    pub fn has_foreign_changes(&self) -> bool {
        let noted = self.notes.0.as_ref();
        noted.is_some_and(|noted| !noted.parts.is_empty() || !noted.events.is_empty() || noted.is_cut)
    }

    /// The changes since the last call.
    pub fn take_foreign_changes(&mut self) -> ForeignChanges {
        self.notes.0.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// The tag belongs to the program.
    pub fn is_of_program(&self, id: TagId) -> bool {
        self.program_tags.tags.contains(&id)
    }

    /// Adds a tag of the program, or takes over a plain tag of its name and type with its present bytes.
    ///
    /// # Errors
    /// Another tag has its name, or there is no room; nothing has changed then.
    pub fn add_program_tag(&mut self, tag: &PlainTag) -> Result<TagId, TableError> {
        let tag = PlainTag {
            tag_type: self.adopt_type(&tag.tag_type),
            ..tag.clone()
        };
        let id = match self.names.get(tag.program.as_deref(), &tag.name) {
            Some(known) => {
                let fits = |known: &super::Tag| match known.kind {
                    TagKind::Plain | TagKind::MotionControl(_) => known.tag_type == tag.tag_type,
                    _ => false,
                };
                if !self.tag(known).is_some_and(fits) {
                    return Err(TableError::Taken { name: tag.name });
                }
                if let Some(row) = self.row_of(known)
                    && self.tags[row].kind == TagKind::Plain
                {
                    self.tags[row].access = tag.access;
                }
                known
            }
            None if self.tags.len() + 2 > MAX_TAGS => return Err(TableError::NoRoom),
            None => self.add_plain(&tag).ok_or(TableError::NoRoom)?,
        };
        if matches!(self.tag(id).map(|tag| tag.kind), Some(TagKind::MotionControl(_))) {
            self.table.configured_controls.insert(id);
        }
        self.program_tags.tags.insert(id);
        Ok(id)
    }

    /// Adds an alias of the program; returns `false` if its target does not exist, or another tag has the name.
    pub fn add_program_alias(&mut self, alias: &PlainTag) -> bool {
        if self.names.get(alias.program.as_deref(), &alias.name).is_some() {
            return false;
        }
        let added = self.add_plain(alias);
        self.program_tags.tags.extend(added);
        added.is_some()
    }

    /// Lists the tasks, programs and routines of a project, in place of those of an earlier one.
    ///
    /// # Errors
    /// The first part for which there is no room, with its name in the list; some are listed then.
    pub fn list_project<'n>(
        &mut self,
        parts: impl Iterator<Item = ProjectPart<'n>>,
    ) -> Result<(), (String, TableError)> {
        let mut listed = BTreeSet::new();
        for part in parts {
            let name = part.to_string();
            if self.tags.len() + 2 > MAX_TAGS {
                return Err((name, TableError::NoRoom));
            }
            match part {
                ProjectPart::Task(task) => self.list_part(None, &format!("Task:{task}"), TagKind::Task),
                ProjectPart::Program(program) => {
                    self.add_program(program);
                }
                ProjectPart::Routine { program, routine } => {
                    let row = self.add_program(program);
                    self.list_part(Some(row), &format!("Routine:{routine}"), TagKind::Routine);
                }
            }
            listed.insert(name.to_ascii_lowercase());
        }
        let gone: Vec<TagId> = self
            .tags
            .iter()
            .filter(|tag| matches!(tag.kind, TagKind::Task | TagKind::Routine))
            .filter(|tag| !listed.contains(&self.full_name(tag).to_ascii_lowercase()))
            .map(|tag| tag.id)
            .collect();
        gone.into_iter().for_each(|id| self.remove(id));
        self.program_tags.listed = listed;
        self.sweep();
        Ok(())
    }

    fn list_part(&mut self, program: Option<u16>, name: &str, kind: TagKind) {
        let scope = program.and_then(|row| self.programs.get(usize::from(row)));
        if self.names.get(scope.map(String::as_str), name).is_none() {
            self.add_in(program, name, TagType::scalar(Elementary::Udint), kind);
        }
    }

    /// Whether a project has the program of this row.
    pub(super) fn is_in_project(&self, program: u16) -> bool {
        let program = self.programs.get(usize::from(program));
        program.is_some_and(|program| {
            let name = ProjectPart::Program(program).to_string();
            self.program_tags.listed.contains(&name.to_ascii_lowercase())
        })
    }

    /// Removes the tags of the program, except those that `keep` selects.
    pub fn remove_program_tags(&mut self, keep: impl Fn(TagId) -> bool) {
        let gone: Vec<TagId> = self.program_tags.tags.iter().copied().filter(|id| !keep(*id)).collect();
        for id in gone {
            for slot in self.slots_in(id) {
                self.release_control(slot);
            }
            self.program_tags.tags.remove(&id);
            self.remove(id);
        }
        self.sweep();
    }

    /// The type of a tag, with the structure instances that clients know.
    pub fn adopted(&mut self, tag_type: &TagType) -> TagType {
        let adopted = self.adopt_type(tag_type);
        if let DataType::Structure(template) = &adopted.data_type {
            self.note_type(template);
        }
        adopted
    }

    /// Reserves a slot for a motion control structure, for [`Image::place_control`]; `None` if no slot is left.
    pub fn reserve_control(&mut self) -> Option<ControlSlot> {
        let slot = self.free_slot()?;
        self.use_slot(slot, TagId(0), 0);
        Some(slot)
    }

    /// The slot of a structure by its path, such as `Program:Main.Moves[2].Control`.
    pub fn placed_control(&self, path: &str) -> Option<ControlSlot> {
        let controls = &self.program_tags.controls;
        let row = controls.iter().find(|(_, known)| known.eq_ignore_ascii_case(path));
        row.map(|(slot, _)| ControlSlot(*slot))
    }

    /// Places a reserved slot in a tag of the program, from a byte on.
    pub fn place_control(&mut self, slot: ControlSlot, id: TagId, offset: usize, path: &str) {
        self.use_slot(slot, id, offset);
        self.program_tags.controls.insert(slot.0, path.to_owned());
    }

    /// Frees a slot that is in no tag any more.
    pub fn release_control(&mut self, slot: ControlSlot) {
        if let Some(row) = self.controls.get_mut(slot.0 as usize) {
            *row = (TagId(0), 0);
            self.table.spare_slots.push(slot.0);
        }
        self.program_tags.controls.remove(&slot.0);
    }

    /// The path of a placed slot.
    pub(super) fn placed_name(&self, slot: ControlSlot) -> Option<&str> {
        self.program_tags.controls.get(&slot.0).map(String::as_str)
    }

    /// Shows the program's bytes of one of its own tags. This is no change for the program, and is not retained over a restart. Bytes of another
    /// length are ignored.
    pub fn store(&mut self, id: TagId, data: &[u8]) {
        let is_data = self
            .tag(id)
            .is_some_and(|tag| matches!(tag.kind, TagKind::Plain | TagKind::MotionControl(_)));
        if !is_data || self.bytes(id).len() != data.len() || self.bytes(id) == data {
            return;
        }
        if let Some(bytes) = self.bytes_mut(id) {
            bytes.copy_from_slice(data);
        }
    }

    /// Notes a changed part, for the program.
    pub(super) fn note_part(&mut self, tag: TagId, offset: usize, length: usize, mask: u8) {
        let is_known = self.program_tags.tags.contains(&tag);
        let Some(noted) = self.notes.0.as_mut().filter(|_| is_known && length > 0) else {
            return;
        };
        let part = ChangedPart {
            tag,
            offset,
            length,
            mask,
        };
        if noted.parts.last() == Some(&part) {
            return;
        }
        if noted.parts.len() >= MAX_NOTES {
            noted.is_cut = true;
            noted.parts.clear();
        }
        if !noted.is_cut {
            noted.parts.push(part);
        }
    }

    /// Notes a change of an instruction, for the program.
    pub(super) fn note_event(&mut self, event: &Event) {
        let Some(noted) = self.notes.0.as_mut() else { return };
        if noted.events.len() >= MAX_NOTES {
            noted.is_cut = true;
            noted.events.clear();
        }
        if !noted.is_cut {
            noted.events.push(*event);
        }
    }

    fn slots_in(&self, id: TagId) -> Vec<ControlSlot> {
        let placed = self.program_tags.controls.keys().map(|slot| ControlSlot(*slot));
        let inside = |slot: &ControlSlot| self.controls.get(slot.0 as usize).is_some_and(|(tag, _)| *tag == id);
        placed.filter(inside).collect()
    }
}

/// Most listed changes; the program takes them between two rungs.
const MAX_NOTES: usize = 4096;
/// Most tags, limited by the instances that every client can browse.
const MAX_TAGS: usize = 0xFFFF;

#[cfg(test)]
mod tests {
    use arcline_instruction_set::{Flag, Mnemonic, predefined};
    use arcline_tag::{Elementary, TemplateBuilder};

    use super::*;
    use crate::image::tests::machine;
    use crate::{Cause, Ticket};

    fn image() -> Image {
        let mut image = Image::new(&machine(), &[], &[]);
        image.follow_for_program();
        image
    }

    fn dint(name: &str) -> PlainTag {
        PlainTag::new(name, TagType::scalar(Elementary::Dint))
    }

    #[test]
    fn writes_of_clients_are_noted_for_the_program_and_its_own_stores_are_not() {
        let mut image = image();
        let mine = image.add_program_tag(&dint("Mine")).expect("room");
        let other = image.create(&dint("Other")).expect("room");
        image.write(other, 0, &[1]).expect("writable");
        assert!(!image.has_foreign_changes(), "it is no tag of the program");
        image.store(mine, &[9, 0, 0, 0]);
        assert!(!image.has_foreign_changes(), "the program knows what it stores");
        image.write(mine, 1, &[7, 8]).expect("writable");
        image.write_bit(mine, 0, 2, true).expect("writable");
        let part = |offset, length, mask| ChangedPart {
            tag: mine,
            offset,
            length,
            mask,
        };
        assert_eq!(image.take_foreign_changes().parts, [part(1, 2, 0xFF), part(0, 1, 4)]);
        assert_eq!(image.bytes(mine), [13, 7, 8, 0]);
        assert!(!image.has_foreign_changes(), "they are taken");
        assert!(!image.clone().has_foreign_changes());
    }

    #[test]
    fn the_parts_of_a_project_are_listed() {
        use ProjectPart::{Program, Routine, Task};
        let mut image = image();
        let listed = |image: &Image| -> Vec<(String, u16)> {
            let tags = image.tags().iter();
            let parts = tags.filter(|tag| tag.kind.is_part_of_project());
            parts.map(|tag| (image.full_name(tag), tag.symbol_type())).collect()
        };
        let go = Routine {
            program: "Main",
            routine: "Go",
        };
        let before = image.tags().len();
        let first = [Task("Fast"), Program("Main"), go, Program("Empty")];
        let expected = [
            ("Task:Fast", 0x1070),
            ("Program:Main", 0x1068),
            ("Program:Main.Routine:Go", 0x106D),
            ("Program:Empty", 0x1068),
        ]
        .map(|(name, word)| (name.to_owned(), word));
        assert_eq!(image.list_project(first.into_iter()), Ok(()));
        assert_eq!(listed(&image), expected);
        let empty = image.find("program:empty").map(|tag| tag.id);
        let tag = PlainTag {
            program: Some("main".into()),
            ..dint("Count")
        };
        image.add_program_tag(&tag).expect("room");
        image.remove_program_tags(|_| false);
        assert_eq!(image.list_project(first.into_iter()), Ok(()));
        assert_eq!(listed(&image), expected, "with or without tags, once");
        let path = "Program:Main.Routine:Go".parse().expect("a path");
        assert!(image.read(&path).is_err(), "it has no data");
        // Another project.
        assert_eq!(image.list_project([Program("EMPTY"), Task("Slow")].into_iter()), Ok(()));
        let names: Vec<String> = listed(&image).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["Program:Empty", "Task:Slow"]);
        assert_eq!(
            image.find("Program:Empty").map(|tag| tag.id),
            empty,
            "it is the same one"
        );
        assert_eq!(image.list_project(std::iter::empty()), Ok(()));
        assert_eq!(image.tags().len(), before);
        // Without room.
        let mut names = (0..).map(|number| format!("T{number}"));
        let filled = names.position(|name| image.add_program_tag(&dint(&name)).is_err());
        assert!(filled > Some(1000));
        let refused = image.list_project([first, first].concat().into_iter());
        assert!(matches!(refused, Err((_, TableError::NoRoom))), "{refused:?}");
    }

    #[test]
    fn notes_are_bounded() {
        let mut image = image();
        let mine = image.add_program_tag(&dint("Mine")).expect("room");
        for number in 0..3 * MAX_NOTES {
            image.write(mine, number % 4, &[1]).expect("writable");
        }
        let changes = image.take_foreign_changes();
        assert!(changes.is_cut && changes.parts.len() <= MAX_NOTES);
    }

    #[test]
    fn a_motion_control_structure_inside_of_a_tag_has_its_slot() {
        let mut image = image();
        let cell = TemplateBuilder::new("CELL", 0x200)
            .member("Count", Elementary::Dint)
            .member("Control", predefined::motion_instruction())
            .build();
        let offset = cell.member("Control").map_or(0, |member| member.offset as usize);
        let tag = PlainTag {
            program: Some("Main".into()),
            ..PlainTag::new("Cell", TagType::scalar(cell))
        };
        let slot = image.reserve_control().expect("a slot");
        let id = image.add_program_tag(&tag).expect("room");
        image.place_control(slot, id, offset, "Program:Main.Cell.Control");
        assert_eq!(image.control_name(slot), "Program:Main.Cell.Control");
        let event = Event {
            tick: 1,
            ticket: Ticket(1),
            control: slot,
            owner: true,
            mnemonic: Mnemonic::Mam,
            set: Flag::Ip.mask(),
            clear: 0,
            err: 0,
            exerr: 0,
            segment: 0,
            cause: Cause::Itself,
        };
        image.apply_event(&event);
        let path = "Program:Main.Cell.Control.IP".parse().expect("a path");
        assert!(image.read(&path).expect("it is there").as_bool());
        assert_eq!(image.take_foreign_changes().events, [event]);
        image.remove_program_tags(|_| false);
        assert!(image.find("Program:Main.Cell").is_none() && image.programs().len() == 1);
        assert_eq!(image.control(slot).flags, 0, "it shows nowhere");
    }

    #[test]
    fn names_of_others_are_not_taken_and_clients_do_not_delete() {
        let mut image = image();
        let axis = image.tags()[1].name.clone();
        assert!(matches!(
            image.add_program_tag(&dint(&axis)),
            Err(TableError::Taken { .. })
        ));
        let mine = image.add_program_tag(&dint("Mine")).expect("room");
        assert!(matches!(image.delete(mine), Err(TableError::NotPlain { .. })));
        let same = image.add_program_tag(&dint("mine"));
        assert_eq!(same, Ok(mine), "with the bytes that it has");
    }
}
