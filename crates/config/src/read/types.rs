//! Types of plain tags: `[[data_type]]` tables, and how a type is written: `REAL`, `DINT[2,3]`, `Recipe[16]`.

use std::collections::BTreeMap;
use std::sync::Arc;

use arcline_instruction_set::predefined;
use arcline_tag::{DataType, Elementary, TagType, Template, TemplateBuilder, nearest, string_template};

use crate::section::{Placed, Section};

/// The structure types of a configuration, by name in lower case.
#[derive(Default)]
pub(super) struct Types(BTreeMap<String, Arc<Template>>);

impl Types {
    /// Reads every `[[data_type]]`. A type may use those above it.
    pub(super) fn read(root: &Section<'_>) -> Self {
        let mut types = Types::default();
        for (section, instance) in root.tables("data_type").iter().zip(FIRST_INSTANCE..) {
            let Some(name) = section.text("name") else {
                continue;
            };
            if types.has(&name.value) {
                section.refuse_as(&name, "a name that no other type has", None);
                continue;
            }
            let template = types.members(section, &name.value, instance);
            types.0.insert(name.value.to_ascii_lowercase(), template);
        }
        types
    }

    /// The types as they stand in the file.
    pub(super) fn in_order(&self) -> Vec<Arc<Template>> {
        let mut templates: Vec<_> = self.0.values().cloned().collect();
        templates.sort_by_key(|template| template.instance);
        templates
    }

    fn has(&self, name: &str) -> bool {
        ELEMENTARY.iter().any(|known| known.eq_ignore_ascii_case(name))
            || predefined::all()
                .iter()
                .any(|known| known.name.eq_ignore_ascii_case(name))
            || self.0.contains_key(&name.to_ascii_lowercase())
    }

    fn members(&self, section: &Section<'_>, name: &str, instance: u16) -> Arc<Template> {
        let mut builder = TemplateBuilder::new(name, instance);
        let mut seen: Vec<String> = Vec::new();
        let mut size = 0;
        for member in &section.tables("members") {
            let (Some(name), Some(word)) = (member.text("name"), member.text("type")) else {
                continue;
            };
            if seen.iter().any(|other| other.eq_ignore_ascii_case(&name.value)) {
                member.refuse_as(&name, "a name that no other member has", None);
            }
            let Some(member_type) = self.parse(member, &word) else {
                continue;
            };
            let elements = u16::try_from(member_type.elements());
            let (1 | 0, Ok(elements)) = (member_type.rank(), elements) else {
                member.refuse_as(&word, "a scalar or an array of one dimension", None);
                continue;
            };
            size += member_type.size();
            if size > MAX_SIZE {
                member.refuse_as(&word, TOO_LARGE, None);
                break;
            }
            builder = match member_type.rank() {
                0 => builder.member(&*name.value, member_type.data_type),
                _ => builder.array(&*name.value, member_type.data_type, elements),
            };
            seen.push(name.value);
        }
        builder.build()
    }

    /// The type that the word under `type` means.
    pub(super) fn parse(&self, section: &Section<'_>, word: &Placed<String>) -> Option<TagType> {
        let own = |name: &str| self.0.get(&name.to_ascii_lowercase()).cloned();
        let Some(tag_type) = unbounded(&word.value, own) else {
            let element = word.value.split('[').next().unwrap_or_default().trim();
            let known = ELEMENTARY.iter().copied();
            let own = self.0.values().map(|template| template.name.as_str());
            let suggestion = nearest(element, known.chain(own)).filter(|near| !near.eq_ignore_ascii_case(element));
            section.refuse("type", word, suggestion);
            return None;
        };
        if tag_type.size() > MAX_SIZE {
            section.refuse_as(word, TOO_LARGE, None);
            return None;
        }
        Some(tag_type)
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

/// The elementary types of tags, and STRING.
pub const ELEMENTARY: &[&str] = &[
    "BOOL", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "REAL", "LREAL", "STRING",
];

const TOO_LARGE: &str = "a type of at most 2 MiB";

/// The possible types of a member, for messages.
pub(crate) fn member_types() -> String {
    format!(
        "{} or a [[data_type]] above, or an array of 1 to 65535 of them such as REAL[16]",
        words()
    )
}

/// The possible types of a tag, for messages.
pub(crate) fn tag_types() -> String {
    format!(
        "{} or a [[data_type]], or an array of 1 to 65535 of them in each of up to three dimensions such as REAL[16] or DINT[2,3], or MOTION_INSTRUCTION, which has no arrays",
        words()
    )
}

/// The types that need no `[[data_type]]`, for people.
fn words() -> String {
    let predefined = predefined::for_tags();
    let predefined = predefined.iter().map(|template| template.name.as_str());
    let words: Vec<&str> = ELEMENTARY.iter().copied().chain(predefined).collect();
    words.join(", ")
}
