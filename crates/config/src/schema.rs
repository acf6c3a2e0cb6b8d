//! The table of keys as a JSON Schema (draft 7), by which editors complete and check a configuration.
//!
//! The reader refuses all that the schema refuses. The reader alone checks the rules between keys, names of other tables and values of tags.
//! Words have the reader's spelling; the reader ignores their case.

use std::ops::RangeInclusive;

use arcline_instruction_set::{Mnemonic, predefined};
use serde_json::{Map, Value, json};

use crate::keys::{Default, Key, Keys, Kind, NAME_PATTERN, ROOT, Range};
use crate::read::ELEMENTARY;

/// The schema of a configuration, ending with a newline.
pub fn schema() -> String {
    let mut schema = object(&ROOT);
    schema.insert("$schema".into(), "http://json-schema.org/draft-07/schema#".into());
    schema.insert("title".into(), "Configuration of arcline-server".into());
    format!("{:#}\n", Value::Object(schema))
}

fn object(keys: &Keys) -> Map<String, Value> {
    let properties: Map<String, Value> = keys
        .keys
        .iter()
        .map(|key| (key.name.to_owned(), Value::Object(property(key))))
        .collect();
    let required = keys.keys.iter().filter(|key| key.default == Default::Required);
    let required: Vec<&str> = required.map(|key| key.name).collect();
    let mut object = Map::new();
    object.insert("type".into(), "object".into());
    object.insert("properties".into(), properties.into());
    object.insert("additionalProperties".into(), false.into());
    if !required.is_empty() {
        object.insert("required".into(), required.into());
    }
    object
}

fn property(key: &Key) -> Map<String, Value> {
    let mut property = values(&key.kind);
    property.insert("description".into(), key.meaning.into());
    let default: Option<Value> = match key.default {
        Default::Number(number) => Some(number.into()),
        Default::Integer(number) => Some(number.into()),
        Default::Boolean(flag) => Some(flag.into()),
        Default::Text(text) => Some(text.into()),
        Default::Required | Default::Prose(_) => None,
    };
    property.extend(default.map(|default| ("default".to_owned(), default)));
    property
}

/// Which values a kind has.
fn values(kind: &Kind) -> Map<String, Value> {
    let text = json!({"type": "string"});
    let value = match kind {
        Kind::Name => json!({"type": "string", "pattern": NAME_PATTERN}),
        Kind::Text(rule) if rule.pattern.is_empty() => text,
        Kind::Text(rule) => json!({"type": "string", "pattern": rule.pattern}),
        Kind::Addresses(most) => {
            json!({"anyOf": [text, {"type": "array", "items": text, "minItems": 1, "maxItems": most}]})
        }
        Kind::AddressOrOff(_) => text,
        Kind::TagType | Kind::MemberType => {
            let mut templates = predefined::for_tags();
            if matches!(kind, Kind::TagType) {
                templates.push(predefined::motion_instruction());
            }
            let templates = templates.iter().map(|template| template.name.as_str());
            let words: Vec<&str> = ELEMENTARY.iter().copied().chain(templates).collect();
            json!({"anyOf": [{"enum": words}, text]})
        }
        Kind::Mnemonic => {
            let words: Vec<String> = Mnemonic::ALL.iter().map(ToString::to_string).collect();
            json!({"anyOf": [{"enum": words}, text]})
        }
        Kind::Word(words) => json!({"enum": words}),
        Kind::Boolean => json!({"type": "boolean"}),
        Kind::Number(range, _) => return number(*range),
        Kind::Integer(range, _) => whole(range),
        Kind::ZeroOr(range, _) => json!({"anyOf": [{"const": 0}, whole(range)]}),
        Kind::Names(range, _) => list(&text, range),
        Kind::Numbers(range, _) => list(&json!({"type": "number"}), range),
        Kind::Table(keys) => return object(keys),
        Kind::Tables(keys, most) => json!({"type": "array", "items": object(keys), "maxItems": most}),
        Kind::Any => json!({}),
    };
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

fn number(range: Range) -> Map<String, Value> {
    let (least, above, most) = match range {
        Range::Any => (None, None, None),
        Range::Above(least) => (None, Some(least), None),
        Range::From(least) => (Some(least), None, None),
        Range::Within(least, most) => (Some(least), None, Some(most)),
        Range::AboveTo(least, most) => (None, Some(least), Some(most)),
    };
    let bounds = [("minimum", least), ("exclusiveMinimum", above), ("maximum", most)];
    let bounds = bounds
        .into_iter()
        .filter_map(|(word, bound)| Some((word.to_owned(), bound?.into())));
    [("type".to_owned(), Value::from("number"))]
        .into_iter()
        .chain(bounds)
        .collect()
}

fn whole(range: &RangeInclusive<usize>) -> Value {
    json!({"type": "integer", "minimum": range.start(), "maximum": range.end()})
}

fn list(items: &Value, range: &RangeInclusive<usize>) -> Value {
    json!({"type": "array", "items": items, "minItems": range.start(), "maxItems": range.end()})
}
