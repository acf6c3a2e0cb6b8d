//! Tags that the configuration makes: `[[instruction]]` and `[[tag]]`.

use std::collections::BTreeMap;

use arcline_controller::image::{Access, MAX_PLAIN_BYTES, NumberRange, WriteRule};
use arcline_controller::machine::Machine;
use arcline_instruction_set::{Mnemonic, Object, predefined};
use arcline_tag::{DataType, Elementary, PathSegment, TagPath, TagType, Value, nearest};

use super::names::{Taken, unknown_name};
use super::types::Types;
use super::value::encode;
use crate::error::Problem;
use crate::section::{Placed, Section};
use crate::{InstructionTag, PlainTag, words};

pub(super) fn instruction_tags(root: &Section<'_>, machine: &Machine, names: &mut Taken) -> Vec<InstructionTag> {
    let tables = root.tables("instruction");
    let tags = tables.iter().filter_map(|section| {
        let name = names.take_name(section, "tag");
        let word = section.text("type")?;
        let Ok(mnemonic) = word.value.parse::<Mnemonic>() else {
            let known: Vec<String> = Mnemonic::ALL.iter().map(ToString::to_string).collect();
            let suggestion = nearest(&word.value, known.iter().map(String::as_str));
            section.refuse("type", &word, suggestion);
            return None;
        };
        let target = match (mnemonic.instruction().object, section.text("target")) {
            (Object::MotionGroup, None) => machine.group.clone(),
            (_, None) => {
                if !section.has("target") {
                    section.missing("target");
                }
                return None;
            }
            (object, Some(given)) => target(section, machine, object, &given)?,
        };
        Some(InstructionTag { name, mnemonic, target })
    });
    tags.collect()
}

/// The object's name as its own table spells it.
fn target(section: &Section<'_>, machine: &Machine, object: Object, given: &Placed<String>) -> Option<String> {
    let (what, known): (_, Vec<&str>) = match object {
        Object::MotionGroup => ("motion group", vec![machine.group.as_str()]),
        Object::Axis => ("axis", machine.axes.iter().map(|axis| axis.name.as_str()).collect()),
        Object::CoordinateSystem => (
            "coordinate system",
            machine.systems.iter().map(|system| system.name.as_str()).collect(),
        ),
    };
    let name = known.iter().find(|name| name.eq_ignore_ascii_case(&given.value));
    if name.is_none() {
        unknown_name(section, given, what, known.iter().copied());
    }
    name.map(|name| (*name).to_owned())
}

/// Every `[[tag]]`, and the programs they are in.
pub(super) fn plain_tags(root: &Section<'_>, types: &Types, names: &mut Taken) -> Vec<PlainTag> {
    let mut programs: BTreeMap<String, Taken> = BTreeMap::new();
    let mut tags: Vec<PlainTag> = Vec::new();
    let mut total = 0;
    for section in root.tables("tag") {
        let program = section.text("program").map(|program| program.value);
        let scope = match &program {
            Some(program) => programs.entry(program.to_ascii_lowercase()).or_default(),
            None => &mut *names,
        };
        let name = scope.take_name(&section, "name");
        let alias = alias(&section, program.as_deref(), &tags);
        let Some(tag_type) = type_of(&section, alias.as_ref(), types) else {
            continue;
        };
        if alias.is_none() {
            total += tag_type.size();
            if total > MAX_PLAIN_BYTES {
                let problem = Problem::TooMany {
                    count: total,
                    limit: MAX_PLAIN_BYTES,
                };
                section.refuse_key("type", problem);
                break;
            }
        }
        let mut tag = PlainTag {
            name,
            program,
            access: section.one_of("access", words::ACCESS),
            rule: rule(&section, &tag_type),
            first: first(&section, &tag_type),
            tag_type,
            alias: alias.map(|alias| alias.path),
        };
        if tag.is_control() {
            tag.access = Access::ReadOnly;
        }
        tags.push(tag);
    }
    tags
}

/// The writers of a tag, and the range of its numbers.
fn rule(section: &Section<'_>, tag_type: &TagType) -> WriteRule {
    for key in ["write_role", "min", "max"] {
        if section.has(key) && section.has("alias") {
            section.conflict(key, "alias", "an alias has the rules of what it stands for");
        } else if section.has(key) && section.word("access") == Some("read_only") {
            section.conflict(key, "access", "no client writes a read-only tag");
        }
    }
    let writers = section.one_of("write_role", words::WRITERS);
    let bounds = ["min", "max"].map(|key| section.number(key).map(|number| (key, number)));
    if bounds == [None; 2] {
        return WriteRule { writers, range: None };
    }
    let kind = match tag_type.data_type {
        DataType::Elementary(kind) if NumberRange::is_of(kind) => kind,
        _ => {
            for (key, _) in bounds.into_iter().flatten() {
                section.conflict(key, "type", "only numbers have a range");
            }
            return WriteRule { writers, range: None };
        }
    };
    let [least, most] = bounds.map(|bound| {
        let (key, number) = bound?;
        let rounded = Value::from_f64(kind, number).as_f64();
        // A REAL has the nearest number, an integer must have this one.
        let fits = if kind.is_real() {
            rounded.is_finite()
        } else {
            rounded == number
        };
        if !fits {
            section.refuse_value(key, format!("a number that {} has", kind.name()));
        }
        fits.then_some(rounded)
    });
    let range = NumberRange {
        least: least.unwrap_or(f64::NEG_INFINITY),
        most: most.unwrap_or(f64::INFINITY),
    };
    if range.least > range.most {
        section.refuse_value("max", "a number that is not below `min`");
    }
    let mut first = first(section, tag_type);
    first.resize(tag_type.size(), 0);
    let mut values = first
        .chunks_exact(kind.size())
        .filter_map(|bytes| Value::read(kind, bytes));
    if !values.all(|value| range.holds(value)) {
        let key = if section.has("value") { "value" } else { "min" };
        section.refuse_value(key, format!("a first value in the range of the tag, {range}"));
    }
    WriteRule {
        writers,
        range: Some(range),
    }
}

/// The type of a tag: its own, or that of its base tag.
fn type_of(section: &Section<'_>, alias: Option<&Alias>, types: &Types) -> Option<TagType> {
    if section.has("alias") {
        for (key, reason) in [
            ("type", "an alias has the type of what it stands for"),
            ("value", "an alias has the value of what it stands for"),
        ] {
            if section.has(key) {
                section.conflict(key, "alias", reason);
            }
        }
        return alias.map(|alias| alias.tag_type.clone());
    }
    if !section.has("type") {
        section.missing("type");
    }
    let word = section.text("type")?;
    if !word.value.trim().eq_ignore_ascii_case(CONTROL) {
        return types.parse(section, &word);
    }
    for (key, reason) in [
        ("program", "a motion control tag is in the controller's scope"),
        ("value", "only instructions write a motion control tag"),
        ("write_role", "only instructions write a motion control tag"),
    ] {
        if section.has(key) {
            section.conflict(key, "type = \"MOTION_INSTRUCTION\"", reason);
        }
    }
    Some(TagType::scalar(predefined::motion_instruction()))
}

/// The type of motion control tags.
const CONTROL: &str = "MOTION_INSTRUCTION";

/// The bytes of the first value; empty when all are 0.
fn first(section: &Section<'_>, tag_type: &TagType) -> Vec<u8> {
    let Some(value) = section.value("value").filter(|_| !section.has("alias")) else {
        return Vec::new();
    };
    let mut first = vec![0; tag_type.size()];
    if let Err(expected) = encode(tag_type, value, &mut first) {
        section.refuse_value("value", expected);
    }
    if first.iter().all(|byte| *byte == 0) {
        first.clear();
    }
    first
}

/// The base of an alias.
struct Alias {
    path: TagPath,
    tag_type: TagType,
}

/// The tag above, or the part of one, that `alias` names.
fn alias(section: &Section<'_>, program: Option<&str>, tags: &[PlainTag]) -> Option<Alias> {
    let given = section.text("alias")?;
    let Ok(path) = given.value.parse::<TagPath>() else {
        section.refuse("alias", &given, None);
        return None;
    };
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
        unknown_name(section, &given, "tag above", known);
        return None;
    };
    let place = base.tag_type.locate(rest);
    let place = place
        .map_err(|error| section.refuse("alias", &given, error.suggestion()))
        .ok()?;
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
    Some(Alias { path, tag_type })
}
