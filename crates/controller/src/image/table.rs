//! Changes of the table of tags while the machine runs: tags that clients create and delete, and the tags and types of another configuration.
//! Unchanged tags keep their ids, their bytes and the instances of their types.
//!
//! Not here: axes, coordinate systems and the group, which never change. Sizes are bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use arcline_instruction_set::predefined;
use arcline_tag::{DataType, TagType, Template, write_string};

use super::{Access, AliasTarget, Image, InstructionTag, PlainTag, Tag, TagId, TagKind, index};

/// Most plain tags.
pub const MAX_PLAIN_TAGS: usize = 4096;
/// Bytes of all plain tags.
pub const MAX_PLAIN_BYTES: usize = 64 << 20;
/// Longest name of a tag, characters.
const MAX_NAME: usize = 40;
/// Most programs.
const MAX_PROGRAMS: usize = 1024;
/// The highest instance that every client can browse (spec/ethernet-ip.md §10).
const MAX_ID: u32 = 0xFFFF;
/// Template instances of a configuration's types.
const OWN_TYPES: std::ops::RangeInclusive<u16> = 0x200..=0xEFF;

/// The text is a valid tag name: 1 to 40 letters, digits and underscores, no digit first.
pub fn is_tag_name(text: &str) -> bool {
    text.len() <= MAX_NAME
        && text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// The key of a tag of a configuration.
fn key(program: Option<&str>, name: &str) -> String {
    match program {
        Some(program) => format!("program:{program}.{name}").to_ascii_lowercase(),
        None => name.to_ascii_lowercase(),
    }
}

/// The tags of a configuration.
#[derive(Clone, Copy, Debug)]
pub struct ConfiguredTags<'a> {
    /// Structure types; a type comes after those that it uses.
    pub data_types: &'a [Arc<Template>],
    /// Instructions as tags.
    pub instructions: &'a [InstructionTag],
    /// Plain data and aliases; an alias comes after its target.
    pub tags: &'a [PlainTag],
}

/// The reason why a change of the table of tags was refused.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum TableError {
    /// The name is not a valid tag name.
    #[error("{name:?} cannot be the name of a tag, expected up to 40 letters, digits and underscores, no digit first")]
    NotAName {
        /// The name, its beginning.
        name: String,
    },
    /// Another tag has that name.
    #[error("there is a tag {name} already")]
    Taken {
        /// The name.
        name: String,
    },
    /// No room for another tag, or for one of that size.
    #[error("there is no room for another tag of that size")]
    NoRoom,
    /// No tag of that id.
    #[error("there is no such tag")]
    NoSuchTag,
    /// A tag that only the configuration can remove.
    #[error("{name} is no plain tag that clients may write")]
    NotPlain {
        /// The name.
        name: String,
    },
    /// The target of an alias is a part of it.
    #[error("{name} is what {alias} stands for")]
    InUse {
        /// The name.
        name: String,
        /// The alias.
        alias: String,
    },
}

/// The history of the table of tags.
#[derive(Clone, Debug, Default)]
pub(super) struct Table {
    /// Counts the tags that were added or removed, or whose access changed.
    pub(super) changes: u32,
    /// Counts the configurations taken over.
    reloads: u32,
    /// The highest id ever used.
    last_id: u32,
    /// The highest template instance ever used for a type of a configuration.
    last_type: u16,
    /// Types of the configuration, by name in lower case.
    declared: BTreeMap<String, Arc<Template>>,
    /// Plain tags that belong to no configuration.
    created: BTreeSet<TagId>,
    /// Motion control tags of the configuration, which no other tag replaces.
    pub(super) configured_controls: BTreeSet<TagId>,
    /// Slots of removed tags.
    pub(super) spare_slots: Vec<u32>,
}

impl Image {
    /// A number that changes with every change of the table of tags.
    pub fn table_changes(&self) -> u32 {
        self.table.changes
    }

    /// The number of configurations taken over.
    pub fn reloads(&self) -> u32 {
        self.table.reloads
    }

    /// A client created the tag at run time.
    pub fn is_created(&self, id: TagId) -> bool {
        self.table.created.contains(&id)
    }

    /// Declares types of which clients can create tags.
    pub fn declare(&mut self, types: &[Arc<Template>]) {
        for template in types {
            let template = self.adopt(template);
            self.note_type(&template);
            self.table.declared.insert(template.name.to_ascii_lowercase(), template);
        }
    }

    /// A type of the configuration by its name, case ignored.
    pub fn declared(&self, name: &str) -> Option<Arc<Template>> {
        self.table.declared.get(&name.to_ascii_lowercase()).cloned()
    }

    /// Creates a plain tag.
    ///
    /// # Errors
    /// An invalid name, a name that another tag has, or no room; nothing has changed then.
    pub fn create(&mut self, tag: &PlainTag) -> Result<TagId, TableError> {
        let program = tag.program.as_deref();
        if let Some(name) = [Some(tag.name.as_str()), program]
            .into_iter()
            .flatten()
            .find(|name| !is_tag_name(name))
        {
            let name = name.chars().take(MAX_NAME).collect();
            return Err(TableError::NotAName { name });
        }
        if self.names.get(program, &tag.name).is_some() {
            return Err(TableError::Taken { name: tag.name.clone() });
        }
        let plain = || self.tags.iter().filter(|known| known.kind == TagKind::Plain);
        let bytes: usize = plain().map(|known| known.tag_type.size()).sum();
        let too_many = plain().count() >= MAX_PLAIN_TAGS || bytes + tag.tag_type.size() > MAX_PLAIN_BYTES;
        let new_program =
            program.is_some_and(|program| !self.programs.iter().any(|known| known.eq_ignore_ascii_case(program)));
        // A tag and its program.
        if too_many || self.tags.len() + 2 > MAX_ID as usize || new_program && self.programs.len() >= MAX_PROGRAMS {
            return Err(TableError::NoRoom);
        }
        let tag = PlainTag {
            alias: None,
            ..tag.clone()
        };
        let id = self.add_plain(&tag).ok_or(TableError::NoRoom)?;
        self.table.created.insert(id);
        Ok(id)
    }

    /// Deletes an alias, or a plain tag that clients may write or have created.
    ///
    /// # Errors
    /// The tag is of another kind, or the target of an alias is a part of it; nothing has changed then.
    pub fn delete(&mut self, id: TagId) -> Result<(), TableError> {
        let tag = self.tag(id).ok_or(TableError::NoSuchTag)?;
        let name = self.full_name(tag);
        match tag.kind {
            _ if self.is_of_program(id) => return Err(TableError::NotPlain { name }),
            TagKind::Alias(_) => {}
            TagKind::Plain if tag.access == Access::ReadWrite || self.is_created(id) => {}
            _ => return Err(TableError::NotPlain { name }),
        }
        let stands_for = |other: &&Tag| matches!(other.kind, TagKind::Alias(AliasTarget { tag, .. }) if tag == id);
        if let Some(alias) = self.tags.iter().find(stands_for) {
            let alias = self.full_name(alias);
            return Err(TableError::InUse { name, alias });
        }
        self.remove(id);
        self.sweep();
        Ok(())
    }

    /// Takes over the tags and types of another configuration of the same machine. Created tags stay unless it has their names; tags that are the
    /// same in `old` and `new` keep id and bytes.
    ///
    /// # Errors
    /// A tag that does not belong to the configuration has one of the names; nothing has changed then.
    pub fn reload(&mut self, old: ConfiguredTags<'_>, new: ConfiguredTags<'_>) -> Result<(), TableError> {
        let mut next = self.clone();
        next.try_reload(old, new)?;
        // A copy starts without notes for a program.
        next.notes = std::mem::take(&mut self.notes);
        if next.table.changes != self.table.changes {
            next.table.reloads = next.table.reloads.wrapping_add(1);
        }
        *self = next;
        Ok(())
    }

    fn try_reload(&mut self, old: ConfiguredTags<'_>, new: ConfiguredTags<'_>) -> Result<(), TableError> {
        self.table.declared.clear();
        self.declare(new.data_types);
        let adopted: Vec<PlainTag> = new
            .tags
            .iter()
            .map(|tag| PlainTag {
                tag_type: self.adopt_type(&tag.tag_type),
                ..tag.clone()
            })
            .collect();
        let by_name = |tags: &'_ [PlainTag]| -> BTreeMap<String, PlainTag> {
            tags.iter()
                .map(|tag| (key(tag.program.as_deref(), &tag.name), tag.clone()))
                .collect()
        };
        let (was, is) = (by_name(old.tags), by_name(&adopted));
        let instructions = |tags: &[InstructionTag]| -> BTreeMap<String, InstructionTag> {
            tags.iter().map(|tag| (key(None, &tag.name), tag.clone())).collect()
        };
        let (was_instruction, is_instruction) = (instructions(old.instructions), instructions(new.instructions));
        let known: Vec<(TagId, String, TagKind)> = self
            .tags
            .iter()
            .map(|tag| (tag.id, self.full_name(tag).to_ascii_lowercase(), tag.kind))
            .collect();
        for (id, name, kind) in &known {
            match kind {
                _ if self.is_of_program(*id) => {}
                TagKind::Plain => self.reload_plain(*id, was.get(name), is.get(name)),
                TagKind::Instruction(instruction) => match is_instruction.get(name) {
                    Some(tag) if tag.mnemonic == instruction.mnemonic => {
                        if was_instruction
                            .get(name)
                            .is_none_or(|before| before.target != tag.target)
                        {
                            self.set_target(*id, tag);
                        }
                    }
                    _ => self.remove(*id),
                },
                // The tag stays, as if an instruction had added it.
                TagKind::MotionControl(_) if !is.contains_key(name) => {
                    self.table.configured_controls.remove(id);
                }
                _ => {}
            }
        }
        // Aliases come after their targets.
        for (id, name, kind) in &known {
            let TagKind::Alias(alias) = kind else { continue };
            if self.is_of_program(*id) {
                continue;
            }
            let same = match (was.get(name), is.get(name), self.tag(*id)) {
                (Some(before), Some(after), Some(tag)) => before.alias == after.alias && tag.tag_type == after.tag_type,
                _ => false,
            };
            if !same || self.tag(alias.tag).is_none() {
                self.remove(*id);
            }
        }
        for tag in new.instructions {
            match self.find(&tag.name).map(|known| known.kind) {
                None => self.add_instruction(tag),
                Some(TagKind::Instruction(_)) => {}
                Some(_) => return Err(TableError::Taken { name: tag.name.clone() }),
            }
        }
        for tag in &adopted {
            let found = self.names.get(tag.program.as_deref(), &tag.name);
            match found.and_then(|id| self.tag(id)).map(|known| known.kind) {
                None => {
                    self.add_configured(tag).ok_or(TableError::NoRoom)?;
                }
                Some(TagKind::Plain | TagKind::Alias(_)) if !tag.is_control() => {}
                Some(TagKind::MotionControl(_)) if tag.is_control() => {
                    self.table.configured_controls.extend(found);
                }
                Some(_) => return Err(TableError::Taken { name: tag.name.clone() }),
            }
        }
        self.sweep();
        Ok(())
    }

    /// Keeps a plain tag that the configuration has with the same type, or that never belonged to it.
    fn reload_plain(&mut self, id: TagId, was: Option<&PlainTag>, is: Option<&PlainTag>) {
        let Some(after) = is else {
            if !self.is_created(id) {
                self.remove(id);
            }
            return;
        };
        let Some(tag) = self.tag(id) else { return };
        if after.alias.is_some() || tag.tag_type != after.tag_type {
            return self.remove(id);
        }
        let other_access = tag.access != after.access;
        self.table.created.remove(&id);
        if other_access {
            self.table.changes = self.table.changes.wrapping_add(1);
        }
        // A read-only tag has its configured value; any other tag gets its first value again if that has changed.
        let anew = after.access == Access::ReadOnly || was.is_some_and(|before| before.first != after.first);
        if let Some(row) = self.row_of(id) {
            self.tags[row].access = after.access;
            self.tags[row].rule = after.rule;
            if let Some(bytes) = self.bytes.get_mut(row).filter(|_| anew) {
                let length = bytes.len();
                bytes.fill(0);
                if after.first.len() == length {
                    bytes.copy_from_slice(&after.first);
                }
                self.note_written(id, 0, length);
            }
        }
    }

    fn set_target(&mut self, id: TagId, tag: &InstructionTag) {
        let Some(DataType::Structure(template)) = self.tag(id).map(|known| known.tag_type.data_type.clone()) else {
            return;
        };
        let member = template.member(tag.mnemonic.instruction().object.member());
        let offset = member.map(|member| member.offset as usize);
        if let (Some(offset), Some(bytes)) = (offset, self.bytes_mut(id))
            && let Some(bytes) = bytes.get_mut(offset..)
        {
            // A name longer than a STRING cannot be configured.
            let _ = write_string(bytes, &tag.target);
        }
    }

    /// The index of a tag among the tags, and of its bytes.
    pub(super) fn row_of(&self, id: TagId) -> Option<usize> {
        // The row, if no tag with a lower id was removed.
        let row = index(id)?;
        if self.tags.get(row).is_some_and(|tag| tag.id == id) {
            return Some(row);
        }
        self.tags.binary_search_by_key(&id, |tag| tag.id).ok()
    }

    /// An unused id: one that was never used, as long as there is one.
    pub(super) fn next_id(&mut self) -> TagId {
        if self.table.last_id < MAX_ID {
            self.table.last_id += 1;
            return TagId(self.table.last_id);
        }
        let free = (1..=MAX_ID).map(TagId).find(|id| self.row_of(*id).is_none());
        free.unwrap_or_else(|| {
            // Beyond the ids that clients can browse: only instruction control tags, whose slots limit their number.
            self.table.last_id += 1;
            TagId(self.table.last_id)
        })
    }

    pub(super) fn remove(&mut self, id: TagId) {
        let Some(row) = self.row_of(id) else { return };
        let tag = self.tags.remove(row);
        self.bytes.remove(row);
        let program = tag.program.and_then(|row| self.programs.get(usize::from(row)).cloned());
        self.names.remove(program.as_deref(), &tag.name, id);
        let slot = match tag.kind {
            TagKind::Instruction(kind) => Some(kind.control),
            TagKind::MotionControl(slot) => Some(slot),
            _ => None,
        };
        if let Some(slot) = slot
            && let Some(control) = self.controls.get_mut(slot.0 as usize)
        {
            *control = (NO_TAG, 0);
            self.table.spare_slots.push(slot.0);
        }
        self.table.created.remove(&id);
        self.table.configured_controls.remove(&id);
        self.table.changes = self.table.changes.wrapping_add(1);
    }

    /// Removes programs without tags that no project has, and unused types.
    pub(super) fn sweep(&mut self) {
        let empty: Vec<TagId> = self
            .tags
            .iter()
            .filter(|tag| match tag.kind {
                TagKind::Program(row) => {
                    !self.is_in_project(row) && !self.tags.iter().any(|other| other.program == Some(row))
                }
                _ => false,
            })
            .map(|tag| tag.id)
            .collect();
        empty.into_iter().for_each(|id| self.remove(id));
        self.templates.clear();
        let used: Vec<Arc<Template>> = self
            .tags
            .iter()
            .filter_map(|tag| match &tag.tag_type.data_type {
                DataType::Structure(template) => Some(template.clone()),
                DataType::Elementary(_) => None,
            })
            .chain([predefined::motion_instruction()])
            .collect();
        used.iter().for_each(|template| self.add_template(template));
    }

    /// Records the instances that a type uses.
    pub(super) fn note_type(&mut self, template: &Template) {
        if OWN_TYPES.contains(&template.instance) {
            self.table.last_type = self.table.last_type.max(template.instance);
        }
    }

    pub(super) fn adopt_type(&mut self, tag_type: &TagType) -> TagType {
        let data_type = match &tag_type.data_type {
            DataType::Structure(template) => DataType::Structure(self.adopt(template)),
            elementary => elementary.clone(),
        };
        TagType {
            data_type,
            ..tag_type.clone()
        }
    }

    /// The known form of a configuration's type: a type with the same name and members keeps its instance, another one gets an
    /// instance unknown to clients.
    fn adopt(&mut self, template: &Arc<Template>) -> Arc<Template> {
        if !OWN_TYPES.contains(&template.instance) {
            return template.clone();
        }
        let mut own = Template::clone(template);
        for member in &mut own.members {
            if let DataType::Structure(inner) = &member.data_type {
                member.data_type = DataType::Structure(self.adopt(inner));
            }
        }
        let known = || self.templates.values().chain(self.table.declared.values());
        let same = |known: &&Arc<Template>| {
            known.name == own.name
                && known.size == own.size
                && known.handle == own.handle
                && known.members == own.members
        };
        if let Some(known) = known().find(same) {
            return known.clone();
        }
        let fresh = template.instance > self.table.last_type;
        if !fresh {
            let used: BTreeSet<u16> = known().map(|known| known.instance).collect();
            let above = (self.table.last_type.saturating_add(1)..=*OWN_TYPES.end()).chain(OWN_TYPES);
            // There are more instances than types in a configuration.
            own.instance = above
                .into_iter()
                .find(|instance| !used.contains(instance))
                .unwrap_or(own.instance);
        }
        let own = Arc::new(own);
        self.note_type(&own);
        own
    }
}

/// No tag.
const NO_TAG: TagId = TagId(0);
