//! The tags of a project as JSON: structures as objects, arrays as arrays, texts as text.

use arcline_routine::{Cell, Line, Tag};
use arcline_tag::{DataType, Elementary, Template, shortest};
use serde_json::{Map, Value, json};

/// Every tag, the simulated time, and the faults.
pub(super) fn json(cell: &Cell, time: f64) -> String {
    let mut all = Map::new();
    for tag in cell.tags() {
        let from = tag.at as usize;
        let bytes = cell.memory().get(from..from + tag.tag_type.size()).unwrap_or_default();
        all.insert(tag.full_name(), value(tag, bytes));
    }
    all.insert("@time_s".to_owned(), json!(time));
    let faults = cell.faults().map(|fault| {
        let (key, number) = match fault.place {
            Line::Rung(number) => ("rung", number),
            Line::Text(number) => ("line", number),
        };
        json!({"type": fault.kind, "code": fault.code, "program": fault.program, "routine": fault.routine, key: number,
            "instruction": fault.instruction})
    });
    all.insert("@faults".to_owned(), Value::Array(faults.collect()));
    Value::Object(all).to_string()
}

fn value(tag: &Tag, bytes: &[u8]) -> Value {
    let of = &tag.tag_type;
    if let Some(bits) = tag.bits() {
        return Value::Array(
            (0..bits as usize)
                .map(|bit| Value::Bool(has(bytes, bit / 8, (bit % 8) as u8)))
                .collect(),
        );
    }
    array(&of.data_type, &of.dimensions, bytes)
}

/// A value, or lists of them by dimension.
fn array(data_type: &DataType, dimensions: &[u32], bytes: &[u8]) -> Value {
    match dimensions {
        [count, rest @ ..] if *count > 0 => {
            let size = bytes.len() / (*count as usize);
            Value::Array(
                bytes
                    .chunks_exact(size.max(1))
                    .map(|part| array(data_type, rest, part))
                    .collect(),
            )
        }
        _ => one(data_type, bytes),
    }
}

fn one(data_type: &DataType, bytes: &[u8]) -> Value {
    match data_type {
        DataType::Elementary(kind) => number(*kind, bytes),
        DataType::Structure(template) => text(template, bytes).unwrap_or_else(|| structure(template, bytes)),
    }
}

fn structure(template: &Template, bytes: &[u8]) -> Value {
    let mut members = Map::new();
    for member in template.members.iter().filter(|member| !member.hidden) {
        let from = member.offset as usize;
        let value = match member.bit {
            Some(bit) => Value::Bool(has(bytes, from, bit)),
            None => {
                let part = bytes.get(from..from + member.size()).unwrap_or_default();
                if member.data_type == DataType::Elementary(Elementary::Dword) && member.dimension > 0 {
                    Value::Array(
                        (0..part.len() * 8)
                            .map(|bit| Value::Bool(has(part, bit / 8, (bit % 8) as u8)))
                            .collect(),
                    )
                } else {
                    array(&member.data_type, &[u32::from(member.dimension)], part)
                }
            }
        };
        members.insert(member.name.clone(), value);
    }
    Value::Object(members)
}

/// The text of a type with LEN and DATA.
fn text(template: &Template, bytes: &[u8]) -> Option<Value> {
    let (length, data) = (template.member("LEN")?, template.member("DATA")?);
    let visible = template.members.iter().filter(|member| !member.hidden).count();
    let is_text = visible == 2 && data.dimension > 0 && data.data_type.size() == 1 && length.offset == 0;
    if !is_text {
        return None;
    }
    let from = data.offset as usize;
    let length = i32::from_le_bytes(bytes.first_chunk().copied()?);
    let length = usize::try_from(length).unwrap_or(0).min(data.size());
    Some(Value::String(
        String::from_utf8_lossy(bytes.get(from..from + length)?).into_owned(),
    ))
}

fn number(kind: Elementary, bytes: &[u8]) -> Value {
    use arcline_tag::Value::{Bool, Dint, Int, Lint, Lreal, Real, Sint};
    match arcline_tag::Value::read(kind, bytes) {
        Some(Bool(_)) => Value::Bool(has(bytes, 0, 0)),
        Some(Real(number)) => json!(shortest(number)),
        Some(Lreal(number)) => json!(number),
        Some(Sint(number)) => json!(number),
        Some(Int(number)) => json!(number),
        Some(Dint(number)) => json!(number),
        Some(Lint(number)) => json!(number),
        Some(unsigned) => unsigned.to_whole().map_or(Value::Null, |whole| json!(whole as u64)),
        None => Value::Null,
    }
}

fn has(bytes: &[u8], at: usize, bit: u8) -> bool {
    bytes.get(at).is_some_and(|byte| byte & 1 << bit != 0)
}
