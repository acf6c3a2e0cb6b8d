//! Types of plain tags: `[[data_type]]` tables, and how a type is written: `REAL`, `DINT[2,3]`, `Recipe[16]`.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use arcline_controller::image::MAX_PLAIN_BYTES;
use arcline_instruction_set::predefined;
use arcline_tag::{DataType, Elementary, TagType, Template, TemplateBuilder, nearest, string_template};

use super::names::{NAME, is_name};
use crate::error::{ConfigError, Problem};
use crate::section::{Placed, Section};

/// The structure types of a configuration, by name in lower case.
#[derive(Default)]
pub(super) struct Types(BTreeMap<String, Arc<Template>>);

impl Types {
    /// Reads every `[[data_type]]`. A type may use those above it.
    pub(super) fn read(root: &Section<'_>) -> Result<Self, ConfigError> {
        let mut types = Types::default();
        let sections = root.tables("data_type", DATA_TYPE, "tables, [[data_type]]", MAX_TYPES)?;
        for (place, section) in sections.iter().enumerate() {
            let name = section
                .string("name", NAME)?
                .ok_or_else(|| section.missing("name", NAME))?;
            types.check_name(section, &name)?;
            let template = types.members(section, &name.value, FIRST_INSTANCE + place as u16)?;
            types.0.insert(name.value.to_ascii_lowercase(), template);
        }
        Ok(types)
    }

    /// The types as they stand in the file.
    pub(super) fn in_order(&self) -> Vec<Arc<Template>> {
        let mut templates: Vec<_> = self.0.values().cloned().collect();
        templates.sort_by_key(|template| template.instance);
        templates
    }

    fn check_name(&self, section: &Section<'_>, name: &Placed<String>) -> Result<(), ConfigError> {
        let taken = ELEMENTARY.iter().any(|known| known.eq_ignore_ascii_case(&name.value))
            || predefined::all()
                .iter()
                .any(|known| known.name.eq_ignore_ascii_case(&name.value))
            || self.0.contains_key(&name.value.to_ascii_lowercase());
        if !is_name(&name.value) {
            return Err(section.refuse(name, NAME, None));
        }
        if taken {
            return Err(section.refuse(name, "a name that no other type has", None));
        }
        Ok(())
    }

    fn members(&self, section: &Section<'_>, name: &str, instance: u16) -> Result<Arc<Template>, ConfigError> {
        let mut builder = TemplateBuilder::new(name, instance);
        let mut seen: Vec<String> = Vec::new();
        let mut size = 0;
        let members = section.tables("members", MEMBER, MEMBERS, MAX_MEMBERS)?;
        if members.is_empty() {
            return Err(section.missing("members", MEMBERS));
        }
        for member in &members {
            let name = member
                .string("name", NAME)?
                .ok_or_else(|| member.missing("name", NAME))?;
            if !is_name(&name.value) {
                return Err(member.refuse(&name, NAME, None));
            }
            if seen.iter().any(|other| other.eq_ignore_ascii_case(&name.value)) {
                return Err(member.refuse(&name, "a name that no other member has", None));
            }
            let word = member
                .string("type", &MEMBER_TYPE)?
                .ok_or_else(|| member.missing("type", &MEMBER_TYPE))?;
            let member_type = self.parse(member, &word, &MEMBER_TYPE)?;
            let elements = u16::try_from(member_type.elements());
            let (1 | 0, Ok(elements)) = (member_type.rank(), elements) else {
                return Err(member.refuse(&word, "a scalar or an array of one dimension", None));
            };
            size += member_type.size();
            if size > MAX_SIZE {
                return Err(member.refuse(&word, TOO_LARGE, None));
            }
            builder = match member_type.rank() {
                0 => builder.member(&*name.value, member_type.data_type),
                _ => builder.array(&*name.value, member_type.data_type, elements),
            };
            seen.push(name.value);
        }
        Ok(builder.build())
    }

    /// The type that a word means.
    pub(super) fn parse(
        &self,
        section: &Section<'_>,
        word: &Placed<String>,
        expected: &'static str,
    ) -> Result<TagType, ConfigError> {
        let own = |name: &str| self.0.get(&name.to_ascii_lowercase()).cloned();
        let Some(tag_type) = unbounded(&word.value, own) else {
            let element = word.value.split('[').next().unwrap_or_default().trim();
            let known = ELEMENTARY.iter().copied();
            let own = self.0.values().map(|template| template.name.as_str());
            let suggestion = nearest(element, known.chain(own)).filter(|near| !near.eq_ignore_ascii_case(element));
            return Err(section.refuse(word, expected, suggestion));
        };
        if tag_type.size() > MAX_SIZE {
            return Err(section.refuse(word, TOO_LARGE, None));
        }
        Ok(tag_type)
    }

    /// The problem of memory that all tags together would need.
    pub(super) fn check_total(section: &Section<'_>, total: usize) -> Result<(), ConfigError> {
        if total > MAX_PLAIN_BYTES {
            return Err(section.refuse_key(
                "type",
                Problem::TooMany {
                    count: total,
                    limit: MAX_PLAIN_BYTES,
                },
            ));
        }
        Ok(())
    }
}

/// The type of a tag that a text means, such as `REAL[16]` or `DINT[2,3]`; `structure` knows the types of the configuration
/// by their names. `None`: it means none, or one of more than 2 MiB.
pub fn tag_type(text: &str, structure: impl Fn(&str) -> Option<Arc<Template>>) -> Option<TagType> {
    unbounded(text, structure).filter(|tag_type| tag_type.size() <= MAX_SIZE)
}

fn unbounded(text: &str, structure: impl Fn(&str) -> Option<Arc<Template>>) -> Option<TagType> {
    let text = text.trim();
    let (element, dimensions) = match text.split_once('[') {
        None => (text, [0; 3]),
        Some((element, rest)) => (element.trim(), dimensions(rest)?),
    };
    let data_type = match ELEMENTARY.iter().find(|name| name.eq_ignore_ascii_case(element)) {
        Some(name) => match Elementary::from_name(name) {
            Some(elementary) => DataType::Elementary(elementary),
            None => DataType::Structure(string_template()),
        },
        None => DataType::Structure(predefined::of_tags(element).or_else(|| structure(element))?),
    };
    let is_bool = matches!(data_type, DataType::Elementary(Elementary::Bool));
    match dimensions {
        [bits, 0, 0] if is_bool && bits > 0 => Some(TagType::bool_array(bits)),
        [_, rows, _] if is_bool && rows > 0 => None,
        dimensions => Some(TagType { data_type, dimensions }),
    }
}

/// `16]`, `2,3]`, `2, 3, 4]`.
fn dimensions(rest: &str) -> Option<[u32; 3]> {
    let mut dimensions = [0; 3];
    let list = rest.strip_suffix(']')?;
    for (place, number) in list.split(',').enumerate() {
        let count: u32 = number.trim().parse().ok()?;
        if !(1..=MAX_ELEMENTS).contains(&count) {
            return None;
        }
        *dimensions.get_mut(place)? = count;
    }
    Some(dimensions)
}

/// Most `[[data_type]]` tables.
pub const MAX_TYPES: usize = 1024;
/// Most members of one.
pub const MAX_MEMBERS: usize = 512;
/// Most elements of one dimension.
pub const MAX_ELEMENTS: u32 = 65_535;
/// Most bytes of one tag or type.
pub const MAX_SIZE: usize = 2 << 20;
/// Template instance of the first type; those of instruction tags are below.
const FIRST_INSTANCE: u16 = 0x200;

pub(super) const DATA_TYPE: &[&str] = &["name", "members"];
pub(super) const MEMBER: &[&str] = &["name", "type"];
/// The elementary types of tags, and STRING.
pub const ELEMENTARY: &[&str] = &[
    "BOOL", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "REAL", "LREAL", "STRING",
];

const MEMBERS: &str = "a list of tables such as { name = \"Speed\", type = \"REAL\" }";
const TOO_LARGE: &str = "a type of at most 2 MiB";
static MEMBER_TYPE: LazyLock<String> = LazyLock::new(|| {
    format!(
        "{} or a [[data_type]] above, or an array of 1 to 65535 of them such as REAL[16]",
        words()
    )
});
pub(super) static TAG_TYPE: LazyLock<String> = LazyLock::new(|| {
    format!(
        "{} or a [[data_type]], or an array of 1 to 65535 of them in each of up to three dimensions such as REAL[16] or DINT[2,3]",
        words()
    )
});

/// The types that need no `[[data_type]]`, for people.
fn words() -> String {
    let predefined = predefined::for_tags();
    let predefined = predefined.iter().map(|template| template.name.as_str());
    let words: Vec<&str> = ELEMENTARY.iter().copied().chain(predefined).collect();
    words.join(", ")
}
