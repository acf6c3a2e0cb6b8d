//! The definition of a structure, the data of Read Template, in both directions (spec/ethernet-ip.md §11).
//!
//! `info u16, type u16, offset u32` of each member, then the name of the type and the names of the members, each with a zero
//! behind it. Nested structures stand as template instances, which the caller reads.

use std::sync::Arc;

use arcline_tag::{DataType, Elementary, Member, Template};

use super::TemplateAttributes;
use crate::wire::Reader;

/// Most members that are accepted.
const MAX_MEMBERS: usize = 4096;
/// Largest structure that is accepted, bytes.
const MAX_SIZE: u32 = 1 << 20;

/// A definition as it travels.
#[derive(Clone, PartialEq, Debug)]
pub struct Definition {
    name: String,
    members: Vec<MemberRow>,
}

#[derive(Clone, PartialEq, Debug)]
struct MemberRow {
    name: String,
    /// Elements of an array, the bit of a BOOL, or 0.
    info: u16,
    type_word: u16,
    offset: u32,
}

impl Definition {
    /// The definition of a template, and its class attributes.
    pub fn of(template: &Template) -> (TemplateAttributes, Self) {
        let member = |member: &Member| MemberRow {
            name: member.name.clone(),
            info: member.bit.map_or(member.dimension, u16::from),
            type_word: member.type_word(),
            offset: member.offset,
        };
        let mut name = template.name.clone();
        if template.is_user_type() {
            name.push_str(";n");
            for member in &template.members {
                // Two characters a member; the low two bits of the second are read as access rights, 0 = hidden.
                name.push_str(if member.hidden { "E@" } else { "EA" });
            }
        }
        let this = Self {
            name,
            members: template.members.iter().map(member).collect(),
        };
        let attributes = TemplateAttributes {
            handle: template.handle,
            members: u16::try_from(template.members.len()).unwrap_or(u16::MAX),
            definition_words: this.words(),
            size: template.size,
        };
        (attributes, this)
    }

    /// The definition's size N in 32-bit words, large enough for every client's idea of how many bytes of it to read (4N − 16
    /// at most).
    fn words(&self) -> u32 {
        (self.unpadded().len() as u32 + 23).div_ceil(4)
    }

    /// The data of Read Template: the members, the names, and zeros up to 4N − 16 bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = self.unpadded();
        bytes.resize((4 * self.words() - 16) as usize, 0);
        bytes
    }

    fn unpadded(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.members.len() * 24);
        for member in &self.members {
            bytes.extend(member.info.to_le_bytes());
            bytes.extend(member.type_word.to_le_bytes());
            bytes.extend(member.offset.to_le_bytes());
        }
        for name in [&self.name]
            .into_iter()
            .chain(self.members.iter().map(|member| &member.name))
        {
            bytes.extend(name.as_bytes());
            bytes.push(0);
        }
        bytes
    }

    /// Reads `count` members and the names. Fields may be missing at the end of the names: they are empty then.
    pub fn decode(bytes: &[u8], count: u16) -> Option<Self> {
        if usize::from(count) > MAX_MEMBERS {
            return None;
        }
        let mut reader = Reader::new(bytes);
        let mut rows = Vec::new();
        for _ in 0..count {
            rows.push((reader.u16()?, reader.u16()?, reader.u32()?));
        }
        let mut names = reader
            .rest()
            .split(|byte| *byte == 0)
            .map(|name| String::from_utf8_lossy(name).into_owned());
        let name = names.next()?;
        let member = |(info, type_word, offset)| MemberRow {
            name: names.next().unwrap_or_default(),
            info,
            type_word,
            offset,
        };
        Some(Self {
            name,
            members: rows.into_iter().map(member).collect(),
        })
    }

    /// Template instances of the structures within.
    pub fn nested(&self) -> impl Iterator<Item = u16> + '_ {
        let words = self.members.iter().map(|member| member.type_word);
        words.filter_map(template_instance)
    }

    /// The template; `structure` gives the nested ones. `None` when a type is unknown or a member lies outside.
    pub fn build(
        self,
        instance: u16,
        attributes: TemplateAttributes,
        structure: impl Fn(u16) -> Option<Arc<Template>>,
    ) -> Option<Arc<Template>> {
        let TemplateAttributes { handle, size, .. } = attributes;
        if size > MAX_SIZE {
            return None;
        }
        let mut members = Vec::new();
        for row in self.members {
            let data_type = data_type(row.type_word, &structure)?;
            let is_bool = data_type == DataType::Elementary(Elementary::Bool);
            let is_array = row.type_word & ARRAY != 0;
            let member = Member {
                hidden: row.name.starts_with("ZZZZZZZZZZ") || row.name.starts_with("__") || row.name.is_empty(),
                read_only: false,
                name: row.name,
                data_type,
                offset: row.offset,
                dimension: if is_array { row.info } else { 0 },
                bit: (is_bool && !is_array)
                    .then_some(u8::try_from(row.info).ok().filter(|bit| *bit < 8))
                    .flatten(),
            };
            let end = u64::from(member.offset) + member.size() as u64;
            if end > u64::from(size) || is_bool && member.bit.is_none() {
                return None;
            }
            members.push(member);
        }
        // Without this, members that overlap would make a small structure a large value.
        let (bits, others): (Vec<_>, Vec<_>) = members.iter().partition(|member| member.bit.is_some());
        let bytes: usize = others.iter().map(|member| member.size()).fold(0, usize::saturating_add);
        if bytes > size as usize || bits.len() > 8 * size as usize {
            return None;
        }
        // `;n` and access marks stand behind the name of a user type.
        let name = self.name.split(';').next().unwrap_or_default().to_owned();
        Some(Arc::new(Template {
            name,
            instance,
            handle,
            size,
            members,
        }))
    }
}

/// The type of a symbol's or member's type word, without its dimensions; `structure` gives the template of an instance.
pub fn data_type(word: u16, structure: impl Fn(u16) -> Option<Arc<Template>>) -> Option<DataType> {
    match template_instance(word) {
        Some(instance) => structure(instance).map(DataType::Structure),
        None => Elementary::from_code((word & 0x00FF) as u8).map(DataType::Elementary),
    }
}

/// The template instance of a type word; `None` when it is of an elementary type.
pub const fn template_instance(word: u16) -> Option<u16> {
    if word & 0x8000 != 0 { Some(word & 0x0FFF) } else { None }
}

/// Bits of a type word: the number of dimensions.
const ARRAY: u16 = 0x6000;

#[cfg(test)]
mod tests {
    use super::*;
    use arcline_tag::{TemplateBuilder, string_template};

    fn pair() -> Arc<Template> {
        TemplateBuilder::new("Vec2", 0x1A1)
            .member("X", Elementary::Real)
            .member("Y", Elementary::Real)
            .build()
    }

    #[test]
    fn a_user_type_travels_as_the_wire_reference_shows() {
        let bytes = Definition::of(&pair()).1.to_bytes();
        // spec/ethernet-ip.md §11: two REALs, "Vec2;nEAEA", the member names.
        let expected = [
            0x00, 0x00, 0xCA, 0x00, 0, 0, 0, 0, // X REAL @0
            0x00, 0x00, 0xCA, 0x00, 4, 0, 0, 0, // Y REAL @4
        ];
        assert_eq!(bytes[..16], expected);
        assert_eq!(&bytes[16..31], b"Vec2;nEAEA\0X\0Y\0");
        assert!(bytes[31..].iter().all(|&b| b == 0));
    }

    #[test]
    fn every_client_finds_the_definition_within_its_read() {
        for template in [pair(), string_template()] {
            let (attributes, definition) = Definition::of(&template);
            let words = attributes.definition_words as usize;
            let data = definition.unpadded().len();
            assert!(4 * words - 23 >= data, "gologix reads 4N - 23");
            assert_eq!(
                definition.to_bytes().len(),
                4 * words - 16,
                "the longest read is answered"
            );
        }
        let string = Definition::of(&string_template()).1.unpadded();
        assert!(string.ends_with(b"ASCIISTRING82\0LEN\0DATA\0"));
    }

    #[test]
    fn a_definition_reads_back() {
        let user = TemplateBuilder::new("Part", 0x123)
            .member("Ready", Elementary::Bool)
            .member("Done", Elementary::Bool)
            .array("Position", Elementary::Real, 9)
            .member("Name", string_template())
            .build();
        let (attributes, definition) = Definition::of(&user);
        let decoded = Definition::decode(&definition.to_bytes(), attributes.members).expect("a definition");
        assert_eq!(decoded, definition);
        assert_eq!(decoded.nested().collect::<Vec<_>>(), [0xFCE]);
        let built = decoded
            .build(0x123, attributes, |_| Some(string_template()))
            .expect("a template");
        assert_eq!(*built, *user);
    }

    #[test]
    fn hostile_definitions_are_refused() {
        let (attributes, definition) = Definition::of(&string_template());
        let bytes = definition.to_bytes();
        for length in 0..bytes.len() {
            // Any prefix: no panic, and never a member outside.
            let decoded = Definition::decode(&bytes[..length], 2);
            if let Some(built) = decoded.and_then(|d| d.build(1, attributes, |_| None)) {
                assert!(
                    built
                        .members
                        .iter()
                        .all(|m| m.offset as usize + m.size() <= built.size as usize)
                );
            }
        }
        assert_eq!(Definition::decode(&bytes, u16::MAX), None, "more members than bytes");
        let decoded = Definition::decode(&bytes, 2).expect("a definition");
        for (why, size) in [
            ("a member outside the structure", 80),
            ("a structure beyond the limit", u32::MAX),
        ] {
            let attributes = TemplateAttributes { size, ..attributes };
            assert_eq!(decoded.clone().build(1, attributes, |_| None), None, "{why}");
        }
    }
}
