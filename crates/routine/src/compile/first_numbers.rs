//! The numbers that a text has where others have `?` (spec/programs.md §3): the first values of PRE, ACC, LEN and POS, if the file has no data for the
//! tag.

use std::collections::BTreeMap;

use super::{Compiler, Owner, Wrong};
use crate::code::{Argument, Ex};
use crate::error::FindingKind;
use crate::expression::Expression;
use crate::memory::for_each_structure;
use crate::source::InstructionSource;
use crate::table::{Kind, Row};
use crate::types::root_of;

/// The numbers of the texts so far.
#[derive(Debug, Default)]
pub(crate) struct FirstNumbers {
    /// By first byte.
    tags: BTreeMap<u32, i32>,
    /// By the add-on instruction in whose instances they stand, and their place there.
    instances: BTreeMap<(usize, u32), i32>,
}

impl Compiler<'_> {
    /// Takes the numbers among the operands of an instruction with a structure.
    pub(super) fn first_numbers(&mut self, row: &Row, operands: &[&str]) -> Result<(), Wrong> {
        let given = || row.operands.iter().zip(operands);
        let structure = given().find(|((_, kind), _)| matches!(kind, Kind::Structure(_)));
        let Some((_, structure)) = structure else { return Ok(()) };
        for ((name, kind), text) in given() {
            let Some(member) = kind.shown_member(name).filter(|_| text.trim() != "?") else {
                continue;
            };
            let value = Expression::parse(text).ok().and_then(|value| self.value(&value).ok());
            let number = match value {
                Some(Argument::Integer(Ex::Integer(number))) => i32::try_from(number).ok(),
                _ => None,
            };
            let number = number.ok_or_else(|| format!("{name} {text}: expected ? or a number that a DINT holds"))?;
            self.first_number(structure, member, number)?;
        }
        Ok(())
    }

    fn first_number(&mut self, structure: &str, member: &str, number: i32) -> Result<(), Wrong> {
        let path = format!("{structure}.{member}");
        let reference = Expression::parse_reference(&path).map_err(|error| error.to_string())?;
        let found = self.resolve(&reference)?;
        // An element by a tag, or the operand of a parameter by reference, is known at run time only.
        if !found.index.is_empty() {
            return Ok(());
        }
        let (before, own) = match (self.owner, found.base) {
            (Owner::Program(_), 0) => {
                let before = self.first_numbers.tags.insert(found.at, number);
                (before, self.own_number(found.at))
            }
            (Owner::AddOn(definition), INSTANCE) => {
                let own = self.own_number_of(definition, &reference.name, found.at);
                let place = (definition, found.at);
                let before = match own {
                    Some(_) => None,
                    None => self.first_numbers.instances.insert(place, number),
                };
                (before, own)
            }
            _ => return Ok(()),
        };
        // Those of a run stand in the data.
        let changes = matches!(member, "ACC" | "POS");
        let other = own.map(|own| (own, "the data of its tag, which counts"));
        let other = other.or_else(|| before.map(|before| (before, "another text; this one counts")));
        if let Some((other, place)) = other.filter(|(other, _)| *other != number && !changes) {
            let reason = format!("is {number} here and {other} in {place}");
            self.find(FindingKind::FirstNumber, &path, &reason);
        }
        Ok(())
    }

    /// The number at a place of the memory, if the file has data for its tag.
    fn own_number(&self, at: u32) -> Option<i32> {
        let behind = self.tags.list.partition_point(|tag| tag.at <= at);
        let tag = self.tags.list.get(behind.checked_sub(1)?)?;
        tag.has_value.then(|| dint(&self.tags.bytes, at as usize)).flatten()
    }

    /// The number at a place of the instances of an add-on instruction, if the definition has a value for the parameter or local tag.
    fn own_number_of(&self, definition: usize, name: &str, at: u32) -> Option<i32> {
        let source = self.project.instructions.get(definition)?;
        has_value(source, name).then_some(())?;
        let data_type = self.types.data_type(&source.name)?;
        let mut bytes = vec![0; data_type.size()];
        crate::memory::first_values_of_instance(self.project, &data_type, &mut bytes);
        dint(&bytes, at as usize)
    }

    /// Writes the numbers to the memory of the tags for which the file has no data.
    pub(super) fn write_first_numbers(&mut self) {
        let numbers = std::mem::take(&mut self.first_numbers);
        for (at, number) in numbers.tags {
            if self.own_number(at).is_none() {
                put(&mut self.tags.bytes, at as usize, number);
            }
        }
        let mut by_type: BTreeMap<String, Vec<(u32, i32)>> = BTreeMap::new();
        for ((definition, at), number) in numbers.instances {
            if let Some(source) = self.project.instructions.get(definition) {
                by_type
                    .entry(source.name.to_ascii_lowercase())
                    .or_default()
                    .push((at, number));
            }
        }
        if by_type.is_empty() {
            return;
        }
        for tag in self.tags.list.iter().filter(|tag| !tag.has_value) {
            let from = tag.at as usize;
            let bytes = self.tags.bytes.get_mut(from..from + tag.tag_type.size());
            for_each_structure(
                &tag.tag_type.data_type,
                bytes.unwrap_or_default(),
                &mut |template, bytes| {
                    for (at, number) in by_type.get(&template.name.to_ascii_lowercase()).into_iter().flatten() {
                        put(bytes, *at as usize, *number);
                    }
                },
            );
        }
    }
}

/// The definition has a first value for a parameter or local tag, or for the one that a parameter is an alias of.
fn has_value(source: &InstructionSource, name: &str) -> bool {
    let local = |name: &str| {
        source
            .locals
            .iter()
            .find(|(one, _)| one.name.eq_ignore_ascii_case(name))
    };
    let parameter = source
        .parameters
        .iter()
        .find(|one| one.member.name.eq_ignore_ascii_case(name));
    let alias = parameter.and_then(|one| one.alias.as_deref());
    let name = alias.map_or(name, root_of);
    parameter.is_some_and(|one| one.value.is_some()) || local(name).is_some_and(|(_, value)| value.is_some())
}

fn dint(bytes: &[u8], at: usize) -> Option<i32> {
    bytes.get(at..)?.first_chunk().map(|bytes| i32::from_le_bytes(*bytes))
}

fn put(bytes: &mut [u8], at: usize, number: i32) {
    if let Some(place) = bytes.get_mut(at..).and_then(<[u8]>::first_chunk_mut) {
        *place = number.to_le_bytes();
    }
}

/// The base of an add-on instruction's own instance.
const INSTANCE: u8 = 1;
