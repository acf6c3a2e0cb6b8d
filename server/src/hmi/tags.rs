//! Tags for a viewer: a list by pages, values as JSON, and writes with the control that they need.

use arcline_controller::image::{Access, Image, Tag, TagId};
use arcline_tag::{
    DataType, Elementary, FloatsOnly, Fraction, Misfit, PathSegment, TagPath, TagValue, Value, WriteValue,
};
use serde::Deserialize;
use serde_json::{Map, Value as Json, json};

use super::protocol::{Done, Refusal, TagAccess, TagPage, TagRow, Values};
use crate::plant::{Command, Outcome, Plant, Principal, Refused, Transaction};

/// Tags of one page.
const PAGE: usize = 200;
/// The longest pattern, bytes, and the `*` that it may have.
const PATTERN: usize = 100;
const STARS: usize = 8;
/// Names of one message, and values that it may have in all.
const NAMES: usize = 200;
const VALUES: usize = 20_000;
/// Names, and bytes of their tags, whose values the shared threads read.
const FEW: usize = 8;
const FEW_BYTES: usize = 2048;

/// The tags whose names have `pattern` in them, in any case; `*` stands for any text.
///
/// # Errors
/// The pattern is longer than [`PATTERN`], or has more than [`STARS`] `*`.
pub(super) fn list(plant: &Plant, pattern: &str, after: Option<&str>) -> Result<TagPage, Refusal> {
    check_pattern(pattern)?;
    let pattern = pattern.to_ascii_lowercase();
    let after = after.map(str::to_ascii_lowercase);
    Ok(plant.with_image(|image| {
        let mut found: Vec<(String, &Tag)> = image
            .tags()
            .iter()
            .filter(|tag| !tag.kind.is_part_of_project())
            .map(|tag| (image.full_name(tag).to_ascii_lowercase(), tag))
            .filter(|(name, _)| matches(name, &pattern))
            .filter(|(name, _)| after.as_ref().is_none_or(|after| name > after))
            .collect();
        found.sort_by(|(a, _), (b, _)| a.cmp(b));
        let more = found.len() > PAGE;
        let tags = found.iter().take(PAGE).map(|(_, tag)| row(image, tag)).collect();
        TagPage { tags, more }
    }))
}

/// The values of tags, or why there is none.
pub(super) fn values(plant: &Plant, names: &[String]) -> Result<Values, Refusal> {
    if names.len() > NAMES {
        return Err(Refusal::new(format!(
            "{} names, at most {NAMES} are possible",
            names.len()
        )));
    }
    Ok(plant.with_image(|image| {
        let mut budget = VALUES;
        let values: Map<String, Json> = names
            .iter()
            .map(|name| {
                let value = value(image, name, &mut budget);
                (name.clone(), value.unwrap_or_else(|error| json!({"error": error.text})))
            })
            .collect();
        let read_only = names.iter().filter(|name| is_read_only(image, name));
        Values {
            values,
            read_only: read_only.cloned().collect(),
        }
    }))
}

/// The tag that a name means, behind an alias.
pub(super) fn tag_of(image: &Image, name: &str) -> Option<TagId> {
    let (tag, _) = image.locate(&path_of(name).ok()?).ok()?;
    Some(tag)
}

/// Whether the values of tags are too many for the threads that all viewers share.
pub(super) fn are_many(plant: &Plant, names: &[String]) -> bool {
    names.len() > FEW
        || plant.with_image(|image| {
            let bytes = names.iter().map(|name| shown_bytes(image, name).unwrap_or(0));
            bytes.fold(0, usize::saturating_add) > FEW_BYTES
        })
}

/// Writes a value. A write that executes an instruction or changes motion needs control of the object that moves.
pub(super) async fn write(plant: &Plant, principal: Principal, name: &str, value: &Json) -> Result<Done, Refusal> {
    let path = path_of(name)?;
    let (done, pending) = plant.transact(principal, |transaction| put(transaction, &path, value));
    let kept = plant.complete(pending).await;
    done?;
    kept.map_err(Refused::from)?;
    Ok(Done {})
}

/// Whether a name is that of a read-only tag, or of a part of one.
fn is_read_only(image: &Image, name: &str) -> bool {
    let tag = path_of(name).ok().and_then(|path| image.find(&path.full_name()?));
    tag.is_some_and(|tag| matches!(tag.access, Access::ReadOnly))
}

/// The bytes of a tag that [`value`] shows.
fn shown_bytes(image: &Image, name: &str) -> Option<usize> {
    let path = path_of(name).ok()?;
    let (_, place) = image.locate(&path).ok()?;
    let one = matches!(path.0.last(), Some(PathSegment::Element(_)));
    let elements = if one { 1 } else { place.elements.max(1) as usize };
    Some(place.element_size().saturating_mul(elements))
}

/// A pattern is looked for in every name: it is short, and so is its list of parts.
fn check_pattern(pattern: &str) -> Result<(), Refusal> {
    let stars = pattern.bytes().filter(|byte| *byte == b'*').count();
    if pattern.len() > PATTERN || stars > STARS {
        return Err(Refusal::new(format!(
            "the pattern has {} bytes and {stars} \"*\", at most {PATTERN} bytes and {STARS} \"*\" are possible",
            pattern.len()
        )));
    }
    Ok(())
}

/// Whether a name contains a pattern, both in lower case.
fn matches(name: &str, pattern: &str) -> bool {
    let mut rest = name;
    pattern.split('*').all(|part| match rest.find(part) {
        Some(at) => {
            rest = &rest[at + part.len()..];
            true
        }
        None => false,
    })
}

fn row(image: &Image, tag: &Tag) -> TagRow {
    let dimensions: Vec<u32> = tag
        .tag_type
        .dimensions
        .iter()
        .copied()
        .take_while(|size| *size > 0)
        .collect();
    let name = image.full_name(tag);
    let single = dimensions.is_empty() && matches!(tag.tag_type.data_type, DataType::Elementary(_));
    let value = single.then(|| value(image, &name, &mut 1).ok()).flatten();
    TagRow {
        name,
        data_type: tag.tag_type.data_type.name().to_owned(),
        dims: dimensions,
        access: match tag.access {
            Access::ReadOnly => TagAccess::Read,
            Access::ReadWrite => TagAccess::ReadWrite,
        },
        value,
    }
}

fn path_of(name: &str) -> Result<TagPath, Refusal> {
    name.parse().map_err(|error| Refusal::new(format!("{error}")))
}

/// The value at a path; `budget` is how many numbers there may still be.
fn value(image: &Image, name: &str, budget: &mut usize) -> Result<Json, Refusal> {
    let path = path_of(name)?;
    let (id, place) = image.locate(&path).map_err(|error| Refusal::new(error.to_string()))?;
    let bytes = image.bytes(id).get(place.offset..).unwrap_or_default();
    if let Some(bit) = place.bit {
        let byte = bytes.get(usize::from(bit / 8)).copied().unwrap_or_default();
        return Ok((byte & 1 << (bit % 8) != 0).into());
    }
    // An index means one element, a name all of them.
    let one = matches!(path.0.last(), Some(PathSegment::Element(_))) || place.elements <= 1;
    let elements = if one { 1 } else { place.elements as usize };
    *budget = budget
        .checked_sub(elements.saturating_mul(place.data_type.leaves()))
        .ok_or_else(|| Refusal::new(format!("more than {VALUES} values")))?;
    let value = match one {
        true => TagValue::decode(&place.data_type, bytes),
        false => TagValue::decode_array(&place.data_type, elements, bytes),
    };
    let json = value.and_then(|value| serde_json::to_value(FloatsOnly(&value)).ok());
    Ok(json.unwrap_or_default())
}

fn put(transaction: &mut Transaction<'_>, path: &TagPath, value: &Json) -> Result<Outcome, Refusal> {
    let (tag, place) = transaction
        .image()
        .locate(path)
        .map_err(|error| Refusal::new(error.to_string()))?;
    let whole_array = place.elements > 1 && !matches!(path.0.last(), Some(PathSegment::Element(_)));
    if whole_array || value.is_array() {
        return Err(Refusal::new(format!(
            "{path} is an array: write one element, such as {path}[0]"
        )));
    }
    let given = WriteValue::deserialize(value).map_err(|_| Refusal::new("expected a number, true, false or a text"))?;
    match (given, &place.data_type) {
        (WriteValue::Bool(on), _) => Ok(transaction.write_value(path, Value::Bool(on))?),
        (given, DataType::Elementary(kind)) => {
            let kind = if place.bit.is_some() { Elementary::Bool } else { *kind };
            let given = whole(given).convert(kind, Fraction::Refuse).map_err(|misfit| {
                let why = match misfit {
                    Misfit::Fraction => "is not a whole number",
                    Misfit::OutOfRange | Misfit::Kind => "does not fit",
                };
                Refusal::new(format!("{path} is {kind}, {value} {why}"))
            })?;
            Ok(transaction.write_value(path, given)?)
        }
        (given @ WriteValue::Text(_), DataType::Structure(template)) if template.is_string() => {
            let mut bytes = vec![0; template.size as usize];
            given
                .encode(&place.data_type, Fraction::Refuse, &mut bytes)
                .map_err(|_| Refusal::new("the text is longer than a STRING"))?;
            let (offset, data) = (place.offset, bytes.as_slice());
            Ok(transaction.apply(Command::WriteTag { tag, offset, data })?)
        }
        (_, DataType::Structure(template)) if template.is_string() => {
            Err(Refusal::new(format!("{path} is a STRING, expected a text in quotes")))
        }
        (_, DataType::Structure(template)) => {
            let name = &template.name;
            Err(Refusal::new(format!("{path} is a {name}, expected one of its members")))
        }
    }
}

/// A text for a number is a whole number that the browser could not keep.
fn whole(given: WriteValue) -> WriteValue {
    match &given {
        WriteValue::Text(text) => text.parse().map_or(given, WriteValue::Integer),
        _ => given,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_are_bounded() {
        #[rustfmt::skip]
        let cases = [
            ("none",           String::new(),       true),
            ("the longest",    "x".repeat(PATTERN), true),
            ("too long",       "x".repeat(101),     false),
            ("as many stars",  "*".repeat(STARS),   true),
            ("too many stars", "*".repeat(9),       false),
            ("very many",      "*".repeat(250_000), false),
        ];
        for (why, pattern, expected) in cases {
            assert_eq!(check_pattern(&pattern).is_ok(), expected, "{why}");
        }
        let error = check_pattern(&"*".repeat(250_000)).expect_err("too many");
        assert_eq!(
            &*error.text,
            "the pattern has 250000 bytes and 250000 \"*\", at most 100 bytes and 8 \"*\" are possible"
        );
    }

    #[test]
    fn patterns() {
        #[rustfmt::skip]
        let cases = [
            ("anything",            "move1",       "",        true),
            ("a part",              "move1",       "ove",     true),
            ("not a part",          "move1",       "x",       false),
            ("parts in order",      "cs1.status",  "cs*stat", true),
            ("parts out of order",  "cs1.status",  "stat*cs", false),
            ("once only",           "aba",         "ab*ba",   false),
        ];
        for (why, name, pattern, expected) in cases {
            assert_eq!(matches(name, pattern), expected, "{why}: {pattern} in {name}");
        }
    }
}
