//! Tags that the configuration makes: `[[instruction]]` and `[[tag]]`.

use std::collections::BTreeMap;

use arcline_controller::image::{Access, MAX_PLAIN_TAGS};
use arcline_controller::machine::Machine;
use arcline_instruction_set::{Mnemonic, Object};
use arcline_tag::{Elementary, PathSegment, TagPath, TagType, nearest};

use super::names::{NAME, Taken, is_name, required_name, unknown_name};
use super::types::{TAG_TYPE, Types};
use super::value::encode;
use crate::error::{ConfigError, Problem};
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

/// Every `[[tag]]`, and the programs they are in.
pub(super) fn plain_tags(root: &Section<'_>, types: &Types, names: &mut Taken) -> Result<Vec<PlainTag>, ConfigError> {
    let mut programs: BTreeMap<String, Taken> = BTreeMap::new();
    let mut tags: Vec<PlainTag> = Vec::new();
    let mut total = 0;
    for section in root.tables("tag", TAG, "tables, [[tag]]", MAX_PLAIN_TAGS)? {
        let program = section.string("program", NAME)?;
        if let Some(program) = &program
            && !is_name(&program.value)
        {
            return Err(section.refuse(program, NAME, None));
        }
        let program = program.map(|program| program.value);
        let scope = match &program {
            Some(program) => programs.entry(program.to_ascii_lowercase()).or_default(),
            None => &mut *names,
        };
        let name = required_name(&section, "name", scope)?;
        let alias = alias(&section, program.as_deref(), &tags)?;
        let tag_type = match (&alias, section.string("type", &TAG_TYPE)?) {
            (Some(alias), None) => alias.tag_type.clone(),
            (Some(_), Some(_)) => {
                let reason = "an alias has the type of what it stands for";
                return Err(section.refuse_key("type", Problem::Conflict { other: "alias", reason }));
            }
            (None, None) => return Err(section.missing("type", &TAG_TYPE)),
            (None, Some(word)) => types.parse(&section, &word, &TAG_TYPE)?,
        };
        if alias.is_none() {
            total += tag_type.size();
            Types::check_total(&section, total)?;
        }
        let read_only = section.word("access", &["read_write", "read_only"], ACCESS)? == Some(1);
        let mut first = Vec::new();
        if let Some(value) = section.value("value") {
            if alias.is_some() {
                let reason = "an alias has the value of what it stands for";
                return Err(section.refuse_key("value", Problem::Conflict { other: "alias", reason }));
            }
            first = vec![0; tag_type.size()];
            encode(&tag_type, value, &mut first).map_err(|expected| {
                let found = section.found("value");
                section.refuse_key(
                    "value",
                    Problem::Value {
                        found,
                        expected,
                        suggestion: None,
                    },
                )
            })?;
            if first.iter().all(|byte| *byte == 0) {
                first.clear();
            }
        }
        tags.push(PlainTag {
            name,
            program,
            tag_type,
            access: if read_only { Access::ReadOnly } else { Access::ReadWrite },
            first,
            alias: alias.map(|alias| alias.path),
        });
    }
    Ok(tags)
}

/// What an alias stands for.
struct Alias {
    path: TagPath,
    tag_type: TagType,
}

/// The tag above, or the part of one, that `alias` names.
fn alias(section: &Section<'_>, program: Option<&str>, tags: &[PlainTag]) -> Result<Option<Alias>, ConfigError> {
    let Some(given) = section.string("alias", ALIAS)? else {
        return Ok(None);
    };
    let path: TagPath = given.value.parse().map_err(|_| section.refuse(&given, ALIAS, None))?;
    let (given_scope, name, rest) = path.scope();
    let find = |scope: Option<&str>| {
        tags.iter().find(|tag| {
            let same_scope = match (&tag.program, scope) {
                (Some(own), Some(scope)) => own.eq_ignore_ascii_case(scope),
                (own, scope) => own.is_none() && scope.is_none(),
            };
            same_scope && tag.alias.is_none() && name.is_some_and(|name| tag.name.eq_ignore_ascii_case(name))
        })
    };
    // A program sees its own tags first, then those of the controller's scope.
    let mut scope = given_scope.or(program);
    let mut base = find(scope);
    if base.is_none() && given_scope.is_none() {
        scope = None;
        base = find(scope);
    }
    let Some(base) = base else {
        let known = tags.iter().map(|tag| tag.name.as_str());
        return Err(unknown_name(section, &given, "tag above", known));
    };
    let place = base.tag_type.locate(rest);
    let place = place.map_err(|error| section.refuse(&given, ALIAS, error.suggestion()))?;
    let tag_type = match (place.bit, rest.is_empty()) {
        (Some(_), _) => TagType::scalar(Elementary::Bool),
        (None, true) => base.tag_type.clone(),
        (None, false) if place.elements > 1 && !matches!(rest.last(), Some(PathSegment::Element(_))) => {
            TagType::array(place.data_type, place.elements)
        }
        (None, false) => TagType::scalar(place.data_type),
    };
    let path = match scope {
        Some(scope) if path.scope().0.is_none() => {
            let mut full = vec![PathSegment::Symbol(format!("Program:{scope}"))];
            full.extend(path.0);
            TagPath(full)
        }
        _ => path,
    };
    Ok(Some(Alias { path, tag_type }))
}

const MAX_INSTRUCTION_TAGS: usize = 1024;
pub(super) const INSTRUCTION: &[&str] = &["tag", "type", "target"];
pub(super) const TAG: &[&str] = &["name", "type", "program", "access", "value", "alias"];
const MNEMONIC: &str = "the mnemonic of a motion instruction such as \"MCLM\"";
const TARGET: &str = "the name of the coordinate system, axis or group that the instruction acts on";
const ACCESS: &str = "\"read_write\" or \"read_only\"";
const ALIAS: &str = "the path of a tag above or of a part of it, such as \"Recipe[3].Speed\"";
