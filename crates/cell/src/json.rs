//! The tags of a project as JSON: structures as objects, arrays as arrays, texts as text.

use arcline_routine::{Cell, Line};
use arcline_tag::{TagValue, Value as Number, shortest};
use serde_json::{Map, Value, json};

use crate::decode;

/// Every tag, the simulated time, and the faults.
pub(crate) fn json(cell: &Cell, time: f64) -> String {
    let mut all = Map::new();
    for tag in cell.tags() {
        let of_tag = decode::of_tag(tag, cell.memory());
        all.insert(tag.full_name(), of_tag.as_ref().map_or(Value::Null, value));
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

fn value(of_tag: &TagValue) -> Value {
    match of_tag {
        TagValue::Value(one) => number(*one),
        TagValue::Text(text) => Value::String(text.clone()),
        TagValue::Array(elements) => Value::Array(elements.iter().map(value).collect()),
        TagValue::Structure(structure) => {
            let members = structure.members.iter();
            Value::Object(members.map(|(name, member)| (name.clone(), value(member))).collect())
        }
    }
}

fn number(one: Number) -> Value {
    match one {
        Number::Bool(on) => Value::Bool(on),
        Number::Real(number) => json!(shortest(number)),
        Number::Lreal(number) => json!(number),
        Number::Sint(number) => json!(number),
        Number::Int(number) => json!(number),
        Number::Dint(number) => json!(number),
        Number::Lint(number) => json!(number),
        unsigned => unsigned.to_whole().map_or(Value::Null, |whole| json!(whole as u64)),
    }
}
