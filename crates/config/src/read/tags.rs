//! Tags that the configuration makes: `[[instruction]]` and `[[tag]]`.

use arcline_controller::machine::Machine;
use arcline_instruction_set::{Mnemonic, Object};
use arcline_tag::{DataType, Elementary, TagType, string_template};

use super::names::{Taken, required_name, unknown_name};
use crate::error::{ConfigError, nearest};
use crate::section::{Placed, Section};
use crate::{InstructionTag, PlainTag};

pub(super) fn instruction_tags(
    root: &Section<'_>,
    machine: &Machine,
    names: &mut Taken,
) -> Result<Vec<InstructionTag>, ConfigError> {
    let mut tags = Vec::new();
    for section in root.tables(
        "instruction",
        INSTRUCTION,
        "tables, [[instruction]]",
        MAX_INSTRUCTION_TAGS,
    )? {
        let name = required_name(&section, "tag", names)?;
        let word = section
            .string("type", MNEMONIC)?
            .ok_or_else(|| section.missing("type", MNEMONIC))?;
        let Ok(mnemonic) = word.value.parse::<Mnemonic>() else {
            let known: Vec<String> = Mnemonic::ALL.iter().map(ToString::to_string).collect();
            let suggestion = nearest(&word.value, known.iter().map(String::as_str));
            return Err(section.refuse(&word, MNEMONIC, suggestion));
        };
        let target = match (mnemonic.instruction().object, section.string("target", TARGET)?) {
            (Object::MotionGroup, None) => machine.group.clone(),
            (_, None) => return Err(section.missing("target", TARGET)),
            (object, Some(given)) => target(&section, machine, object, &given)?,
        };
        tags.push(InstructionTag { name, mnemonic, target });
    }
    Ok(tags)
}

/// The object's name as its own table spells it.
fn target(
    section: &Section<'_>,
    machine: &Machine,
    object: Object,
    given: &Placed<String>,
) -> Result<String, ConfigError> {
    let (what, known): (_, Vec<&str>) = match object {
        Object::MotionGroup => ("motion group", vec![machine.group.as_str()]),
        Object::Axis => ("axis", machine.axes.iter().map(|axis| axis.name.as_str()).collect()),
        Object::CoordinateSystem => (
            "coordinate system",
            machine.systems.iter().map(|system| system.name.as_str()).collect(),
        ),
    };
    match known.iter().find(|name| name.eq_ignore_ascii_case(&given.value)) {
        Some(name) => Ok((*name).to_owned()),
        None => Err(unknown_name(section, given, what, known.iter().copied())),
    }
}

pub(super) fn plain_tags(root: &Section<'_>, names: &mut Taken) -> Result<Vec<PlainTag>, ConfigError> {
    let mut tags = Vec::new();
    for section in root.tables("tag", TAG, "tables, [[tag]]", MAX_TAGS)? {
        let name = required_name(&section, "name", names)?;
        let word = section
            .string("type", TAG_TYPE)?
            .ok_or_else(|| section.missing("type", TAG_TYPE))?;
        let Some(tag_type) = tag_type(&word.value) else {
            let element = word.value.split('[').next().unwrap_or_default().trim();
            let suggestion =
                nearest(element, TYPE_NAMES.iter().copied()).filter(|name| !name.eq_ignore_ascii_case(element));
            return Err(section.refuse(&word, TAG_TYPE, suggestion));
        };
        tags.push(PlainTag { name, tag_type });
    }
    Ok(tags)
}

/// `REAL`, `REAL[16]`, `STRING[4]`.
fn tag_type(text: &str) -> Option<TagType> {
    let (element, dimension) = match text.trim().split_once('[') {
        None => (text.trim(), 0),
        Some((element, rest)) => {
            let count: u32 = rest.strip_suffix(']')?.trim().parse().ok()?;
            if !(1..=MAX_ELEMENTS).contains(&count) {
                return None;
            }
            (element.trim(), count)
        }
    };
    let name = TYPE_NAMES.iter().find(|name| name.eq_ignore_ascii_case(element))?;
    if *name == "BOOL" && dimension > 0 {
        return Some(TagType::bool_array(dimension));
    }
    let data_type = match Elementary::from_name(name) {
        Some(elementary) => DataType::Elementary(elementary),
        None => DataType::Structure(string_template()),
    };
    Some(TagType {
        data_type,
        dimensions: [dimension, 0, 0],
    })
}

const MAX_INSTRUCTION_TAGS: usize = 1024;
const MAX_TAGS: usize = 4096;
/// Elements of one array.
const MAX_ELEMENTS: u32 = 65_535;

pub(super) const INSTRUCTION: &[&str] = &["tag", "type", "target"];
pub(super) const TAG: &[&str] = &["name", "type"];
const TYPE_NAMES: &[&str] = &[
    "BOOL", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "REAL", "LREAL", "STRING",
];

const MNEMONIC: &str = "the mnemonic of a motion instruction such as \"MCLM\"";
const TARGET: &str = "the name of the coordinate system, axis or group that the instruction acts on";
const TAG_TYPE: &str = "BOOL, SINT, INT, DINT, LINT, USINT, UINT, UDINT, REAL, LREAL or STRING, \
     or an array of 1 to 65535 of them such as REAL[16]";
