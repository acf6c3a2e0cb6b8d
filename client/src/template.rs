//! Reads the definition of a structure as a server sends it: the other direction of
//! [`arcline_tag::Template::definition`].
//!
//! Bytes in, members out; who fetches the definitions of nested structures is the caller's matter.

use std::sync::Arc;

use arcline_proto::logix::TemplateAttributes;
use arcline_proto::wire::Reader;
use arcline_tag::{DataType, Elementary, Member, Template};

/// Most members that are accepted.
pub(crate) const MAX_MEMBERS: usize = 4096;
/// Largest structure that is accepted, bytes.
pub(crate) const MAX_SIZE: u32 = 1 << 20;

/// A definition whose nested structures are still numbers.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Definition {
    name: String,
    members: Vec<RawMember>,
}

#[derive(Clone, PartialEq, Debug)]
struct RawMember {
    name: String,
    info: u16,
    type_word: u16,
    offset: u32,
}

impl Definition {
    /// Reads `count` members and the names. Fields may be missing at the end of the names: they are empty then.
    pub(crate) fn decode(bytes: &[u8], count: u16) -> Option<Self> {
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
        // A user type's name is followed by `;n` and access marks.
        let name = name.split(';').next().unwrap_or_default().to_owned();
        let member = |(info, type_word, offset)| {
            let name = names.next().unwrap_or_default();
            RawMember {
                name,
                info,
                type_word,
                offset,
            }
        };
        Some(Self {
            name,
            members: rows.into_iter().map(member).collect(),
        })
    }

    /// Template instances of the structures within.
    pub(crate) fn nested(&self) -> impl Iterator<Item = u16> + '_ {
        self.members
            .iter()
            .filter(|member| is_structure(member.type_word))
            .map(|member| instance(member.type_word))
    }

    /// The template; `structure` gives the nested ones. `None` when a type is unknown or a member lies outside.
    pub(crate) fn build(
        self,
        instance_id: u16,
        attributes: TemplateAttributes,
        structure: impl Fn(u16) -> Option<Arc<Template>>,
    ) -> Option<Arc<Template>> {
        let TemplateAttributes { handle, size, .. } = attributes;
        if size > MAX_SIZE {
            return None;
        }
        let mut members = Vec::new();
        for raw in self.members {
            let data_type = data_type(raw.type_word, &structure)?;
            let is_bool = data_type == DataType::Elementary(Elementary::Bool);
            let is_array = raw.type_word & ARRAY != 0;
            let member = Member {
                hidden: raw.name.starts_with("ZZZZZZZZZZ") || raw.name.starts_with("__") || raw.name.is_empty(),
                name: raw.name,
                data_type,
                offset: raw.offset,
                dimension: if is_array { raw.info } else { 0 },
                bit: (is_bool && !is_array)
                    .then_some(u8::try_from(raw.info).ok().filter(|bit| *bit < 8))
                    .flatten(),
            };
            let end = u64::from(member.offset) + member.size() as u64;
            if end > u64::from(size) || is_bool && member.bit.is_none() {
                return None;
            }
            members.push(member);
        }
        // Without this, members that overlap would make a small structure a large reading.
        let (bits, others): (Vec<_>, Vec<_>) = members.iter().partition(|member| member.bit.is_some());
        let bytes: usize = others.iter().map(|member| member.size()).fold(0, usize::saturating_add);
        if bytes > size as usize || bits.len() > 8 * size as usize {
            return None;
        }
        Some(Arc::new(Template {
            name: self.name,
            instance: instance_id,
            handle,
            size,
            members,
        }))
    }
}

/// The type of a symbol's or member's type word, its dimensions left aside.
pub(crate) fn data_type(word: u16, structure: impl Fn(u16) -> Option<Arc<Template>>) -> Option<DataType> {
    if is_structure(word) {
        return structure(instance(word)).map(DataType::Structure);
    }
    let code = (word & 0x00FF) as u8;
    Elementary::from_code(code).map(DataType::Elementary)
}

/// Bit 15 of a type word.
pub(crate) const fn is_structure(word: u16) -> bool {
    word & 0x8000 != 0
}

/// Template instance of a structure's type word.
pub(crate) const fn instance(word: u16) -> u16 {
    word & 0x0FFF
}

const ARRAY: u16 = 0x6000;

#[cfg(test)]
mod tests {
    use super::*;
    use arcline_tag::{TemplateBuilder, string_template};

    fn attributes(template: &Template) -> TemplateAttributes {
        TemplateAttributes {
            handle: template.handle,
            members: template.members.len() as u16,
            definition_words: template.definition_words(),
            size: template.size,
        }
    }

    #[test]
    fn a_definition_reads_back() {
        let user = TemplateBuilder::new("Part", 0x123)
            .member("Ready", Elementary::Bool)
            .member("Done", Elementary::Bool)
            .array("Position", Elementary::Real, 9)
            .member("Name", string_template())
            .build();
        let decoded = Definition::decode(&user.definition(), user.members.len() as u16).expect("a definition");
        assert_eq!(decoded.nested().collect::<Vec<_>>(), [0xFCE]);
        let built = decoded
            .build(0x123, attributes(&user), |_| Some(string_template()))
            .expect("a template");
        assert_eq!(*built, *user);
    }

    #[test]
    fn hostile_definitions_are_refused() {
        let template = string_template();
        let bytes = template.definition();
        for length in 0..bytes.len() {
            // Any prefix: no panic, and never a member outside.
            let decoded = Definition::decode(&bytes[..length], 2);
            if let Some(built) = decoded.and_then(|d| d.build(1, attributes(&template), |_| None)) {
                assert!(
                    built
                        .members
                        .iter()
                        .all(|m| m.offset as usize + m.size() <= built.size as usize)
                );
            }
        }
        assert_eq!(Definition::decode(&bytes, u16::MAX), None, "more members than bytes");
        let small = TemplateAttributes {
            size: 80,
            ..attributes(&template)
        };
        let decoded = Definition::decode(&bytes, 2).expect("a definition");
        assert_eq!(
            decoded.clone().build(1, small, |_| None),
            None,
            "a member outside the structure"
        );
        let huge = TemplateAttributes {
            size: u32::MAX,
            ..attributes(&template)
        };
        assert_eq!(decoded.build(1, huge, |_| None), None, "a structure beyond the limit");
    }
}
