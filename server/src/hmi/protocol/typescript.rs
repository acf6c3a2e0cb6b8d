//! Writes `web/types/protocol.d.ts` and the tables of `docs/HMI.md` from the types of the messages.

use std::fmt::Write as _;

use schemars::generate::{SchemaGenerator, SchemaSettings};
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value};

use super::super::{instructions, machine};
use super::{Push, Refusal, request};
use crate::pages::{compare_or_write, compare_or_write_part};

/// Collects the schemas of messages: the schema of reading for messages of a page, the schema of writing for those of the server.
pub(super) struct Schemas {
    read: SchemaGenerator,
    written: SchemaGenerator,
}

/// A request: its name in Rust, its fields, and the name of its answer's type.
pub(super) struct Row {
    name: &'static str,
    fields: Schema,
    answer: String,
}

impl Schemas {
    fn new() -> Self {
        Schemas {
            read: SchemaSettings::draft2020_12().for_deserialize().into_generator(),
            written: SchemaSettings::draft2020_12().for_serialize().into_generator(),
        }
    }

    pub(super) fn row<R: JsonSchema, A: JsonSchema>(&mut self, name: &'static str) -> Row {
        self.written.subschema_for::<A>();
        Row {
            name,
            fields: self.read.root_schema_for::<R>(),
            answer: A::schema_name().into_owned(),
        }
    }
}

/// `JogEnd` as `jog_end`.
fn snake_case(name: &str) -> String {
    let mut out = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.extend(letter.to_lowercase());
    }
    out
}

fn description(schema: &Value) -> Option<String> {
    let text = schema.get("description")?.as_str()?;
    Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
}

fn comment(out: &mut String, indent: &str, schema: &Value) {
    if let Some(text) = description(schema) {
        let _ = writeln!(out, "{indent}/** {text} */");
    }
}

/// The type of a schema, in TypeScript.
fn kind(schema: &Value, indent: &str) -> String {
    let Value::Object(schema) = schema else {
        return "unknown".into();
    };
    let mut parts = Vec::new();
    if let Some(Value::String(name)) = schema.get("$ref") {
        parts.push(name.rsplit('/').next().unwrap_or_default().to_owned());
    }
    if let Some(value) = schema.get("const") {
        parts.push(value.to_string());
    }
    if let Some(Value::Array(values)) = schema.get("enum") {
        parts.push(values.iter().map(Value::to_string).collect::<Vec<_>>().join(" | "));
    }
    let is_const = schema.contains_key("const") || schema.contains_key("enum");
    if let Some(named) = schema.get("type").filter(|_| !is_const) {
        let names: Vec<&Value> = match named {
            Value::Array(names) => names.iter().collect(),
            name => vec![name],
        };
        let names = names
            .iter()
            .filter_map(|name| name.as_str())
            .map(|name| one(name, schema, indent));
        parts.push(names.collect::<Vec<_>>().join(" | "));
    }
    for of in ["anyOf", "oneOf"] {
        if let Some(Value::Array(choices)) = schema.get(of) {
            let choices: Vec<String> = choices.iter().map(|choice| kind(choice, indent)).collect();
            parts.push(choices.join(" | "));
        }
    }
    match parts.as_slice() {
        [] => "unknown".into(),
        [one] => one.clone(),
        many => {
            let in_brackets = |part: &String| {
                if part.contains(" | ") {
                    format!("({part})")
                } else {
                    part.clone()
                }
            };
            many.iter().map(in_brackets).collect::<Vec<_>>().join(" & ")
        }
    }
}

/// A type of JSON with the constraints of its schema.
fn one(name: &str, schema: &Map<String, Value>, indent: &str) -> String {
    match name {
        "integer" | "number" => "number".into(),
        "array" => {
            let items = schema
                .get("items")
                .map_or("unknown".into(), |items| kind(items, indent));
            match schema.get("maxItems").and_then(Value::as_u64) {
                Some(count) => format!("[{}]", vec![items; count as usize].join(", ")),
                None if items.contains([' ', '{']) => format!("({items})[]"),
                None => format!("{items}[]"),
            }
        }
        "object" if schema.contains_key("properties") => members(schema, indent),
        "object" => match schema.get("additionalProperties") {
            Some(Value::Bool(false)) | None => "{}".into(),
            Some(values) => format!("Record<string, {}>", kind(values, indent)),
        },
        other => other.into(),
    }
}

fn members(schema: &Map<String, Value>, indent: &str) -> String {
    let mut out = String::from("{\n");
    let inner = format!("{indent}  ");
    for (name, optional, member) in fields(schema) {
        comment(&mut out, &inner, member);
        let _ = writeln!(
            out,
            "{inner}{name}{}: {};",
            if optional { "?" } else { "" },
            kind(member, &inner)
        );
    }
    out + indent + "}"
}

/// Name, whether it may be left out, and schema of each member.
fn fields(schema: &Map<String, Value>) -> Vec<(&str, bool, &Value)> {
    let required = schema.get("required").and_then(Value::as_array);
    let properties = schema.get("properties").and_then(Value::as_object);
    let properties = properties.into_iter().flatten();
    let is_required = |name: &str| required.is_some_and(|required| required.iter().any(|one| one == name));
    properties
        .map(|(name, member)| (name.as_str(), !is_required(name), member))
        .collect()
}

fn declarations(rows: &[Row], push: &Value, definitions: &Map<String, Value>) -> String {
    let mut out = String::from(
        "// The messages between a page and the server. A test of the server writes this file from its types: run\n\
         // `UPDATE_EXPECT=1 cargo test -p arcline-server --lib hmi::protocol` after a change of them.\n\n\
         /** The fields and the answer of each request, by its `do`. */\nexport interface Requests {\n",
    );
    for row in rows {
        comment(&mut out, "  ", row.fields.as_value());
        let (name, fields) = (snake_case(row.name), kind(row.fields.as_value(), "    "));
        let _ = writeln!(
            out,
            "  {name}: {{\n    fields: {fields};\n    answer: {};\n  }};",
            row.answer
        );
    }
    out.push_str("}\n\n");
    comment(&mut out, "", push);
    out.push_str("export type Push =");
    for choice in push["oneOf"].as_array().into_iter().flatten() {
        let _ = write!(out, "\n  | {}", kind(choice, "    "));
    }
    out.push_str(";\n");
    for (name, schema) in definitions {
        out.push('\n');
        comment(&mut out, "", schema);
        let _ = writeln!(out, "export type {name} = {};", kind(schema, ""));
    }
    out
}

fn tables(rows: &[Row], push: &Value) -> String {
    let mut out = String::from("| `do` | meaning | fields | answer |\n|---|---|---|---|\n");
    for row in rows {
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} |",
            snake_case(row.name),
            description(row.fields.as_value()).unwrap_or_default(),
            row.fields.as_value().as_object().map(in_a_cell).unwrap_or_default(),
            if row.answer == "Done" {
                String::new()
            } else {
                format!("`{}`", row.answer)
            },
        );
    }
    out.push_str("\n| `push` | meaning | fields |\n|---|---|---|\n");
    for choice in push["oneOf"].as_array().into_iter().flatten() {
        let mut cell = choice.as_object().map(in_a_cell).unwrap_or_default();
        if let Some(name) = choice["$ref"].as_str() {
            cell = format!("those of `{}`", name.rsplit('/').next().unwrap_or_default());
        }
        let _ = writeln!(
            out,
            "| `{}` | {} | {cell} |",
            choice["properties"]["push"]["const"].as_str().unwrap_or_default(),
            description(choice).unwrap_or_default(),
        );
    }
    out
}

/// The fields of a message in one line.
fn in_a_cell(schema: &Map<String, Value>) -> String {
    let fields = fields(schema).into_iter().filter(|(name, ..)| *name != "push");
    let fields = fields.map(|(name, optional, member)| {
        let kind = kind(member, "").replace('|', "\\|");
        let described = description(member).map(|text| format!(" {}", text.trim_end_matches('.')));
        let mark = if optional { "?" } else { "" };
        format!("`{name}{mark}: {kind}`{}", described.unwrap_or_default())
    });
    fields.collect::<Vec<_>>().join("; ")
}

#[test]
fn the_types_of_the_page_and_its_tables_are_those_of_the_server() {
    let mut schemas = Schemas::new();
    let rows = request::rows(&mut schemas);
    for name in ["machine", "catalogue"] {
        let _ = match name {
            "machine" => schemas.written.subschema_for::<machine::Machine>(),
            _ => schemas.written.subschema_for::<instructions::Catalogue>(),
        };
    }
    let _ = schemas.written.subschema_for::<Refusal>();
    let push = schemas.written.root_schema_for::<Push<'static>>();
    let push = push.as_value();
    let definitions = schemas.written.definitions();
    compare_or_write("web/types/protocol.d.ts", &declarations(&rows, push, definitions));
    compare_or_write_part("docs/HMI.md", "protocol", &tables(&rows, push));
}
