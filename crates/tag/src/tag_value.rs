//! The contents of a tag: values, texts, arrays and structures, decoded from its bytes by its type.
//!
//! Not here: type codes of the tag services, and values that a client writes ([`crate::WriteValue`]).

use std::fmt;

use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::{DataType, Template, Value, string_text};

/// The value of a tag or a part of one.
#[derive(Clone, PartialEq, Debug)]
pub enum TagValue {
    /// An elementary value.
    Value(Value),
    /// A STRING.
    Text(String),
    /// An array; several dimensions come as one, the last index changing fastest.
    Array(Vec<TagValue>),
    /// A structure.
    Structure(StructureValue),
}

/// The members of a structure, hidden ones left out, in template order.
#[derive(Clone, PartialEq, Debug)]
pub struct StructureValue {
    /// Name of the type.
    pub type_name: String,
    /// Names and values.
    pub members: Vec<(String, TagValue)>,
}

impl StructureValue {
    /// The member of that name, case ignored.
    pub fn member(&self, name: &str) -> Option<&TagValue> {
        self.members
            .iter()
            .find(|(member, _)| member.eq_ignore_ascii_case(name))
            .map(|(_, value)| value)
    }
}

impl Template {
    /// The value of a structure from its bytes; `None` when there are too few.
    pub fn decode(&self, bytes: &[u8]) -> Option<TagValue> {
        if self.is_string() {
            return Some(TagValue::Text(string_text(bytes.get(..self.size as usize)?)));
        }
        let mut members = Vec::new();
        for member in self.members.iter().filter(|member| !member.hidden) {
            let from = bytes.get(member.offset as usize..)?;
            let value = match (member.bit, member.dimension) {
                (Some(bit), _) => TagValue::Value(Value::Bool(from.first()? & (1 << bit) != 0)),
                (None, 0) => TagValue::decode(&member.data_type, from)?,
                (None, count) => TagValue::decode_array(&member.data_type, usize::from(count), from)?,
            };
            members.push((member.name.clone(), value));
        }
        Some(TagValue::Structure(StructureValue {
            type_name: self.name.clone(),
            members,
        }))
    }
}

impl TagValue {
    /// Decodes one element; `None` when there are too few bytes.
    pub fn decode(data_type: &DataType, bytes: &[u8]) -> Option<Self> {
        match data_type {
            DataType::Elementary(elementary) => Value::read(*elementary, bytes).map(Self::Value),
            DataType::Structure(template) => template.decode(bytes),
        }
    }

    /// The type of the value in words: `REAL`, `STRING`, `an array of 4`, the name of a structure type.
    pub fn type_name(&self) -> String {
        match self {
            Self::Value(value) => value.elementary().name().to_owned(),
            Self::Text(_) => "STRING".to_owned(),
            Self::Array(elements) => format!("an array of {}", elements.len()),
            Self::Structure(structure) => structure.type_name.clone(),
        }
    }

    /// Decodes `elements` elements.
    pub fn decode_array(data_type: &DataType, elements: usize, bytes: &[u8]) -> Option<Self> {
        let size = data_type.size();
        let all = bytes.get(..elements.checked_mul(size)?)?;
        if size == 0 {
            return Some(Self::Array(Vec::new()));
        }
        all.chunks_exact(size)
            .map(|one| Self::decode(data_type, one))
            .collect::<Option<Vec<_>>>()
            .map(Self::Array)
    }

    /// The elementary value, if it is one.
    pub fn value(&self) -> Option<Value> {
        match self {
            Self::Value(value) => Some(*value),
            _ => None,
        }
    }

    /// The value as a number; `None` for texts, arrays and structures.
    pub fn as_f64(&self) -> Option<f64> {
        self.value().map(Value::as_f64)
    }

    /// Whether the value is not 0; `None` for texts, arrays and structures.
    pub fn as_bool(&self) -> Option<bool> {
        self.value().map(Value::as_bool)
    }

    /// The text of a STRING.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The numbers of an array, or a single one; `None` when something else is among them.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Self::Array(elements) => elements.iter().map(Self::as_f64).collect(),
            single => single.as_f64().map(|number| vec![number]),
        }
    }

    /// A member of a structure, case ignored.
    pub fn member(&self, name: &str) -> Option<&TagValue> {
        match self {
            Self::Structure(structure) => structure.member(name),
            _ => None,
        }
    }

    /// A member of a structure as a number; 0 when there is none of that name.
    pub fn number(&self, name: &str) -> f64 {
        self.member(name).and_then(Self::as_f64).unwrap_or_default()
    }

    /// A member of a structure as a truth value; false when there is none of that name.
    pub fn flag(&self, name: &str) -> bool {
        self.member(name).and_then(Self::as_bool).unwrap_or_default()
    }
}

impl fmt::Display for TagValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let comma = |index| if index == 0 { "" } else { ", " };
        match self {
            Self::Value(value) => write!(f, "{value}"),
            Self::Text(text) => write!(f, "'{}'", text.escape_debug()),
            Self::Array(elements) => {
                f.write_str("[")?;
                for (index, element) in elements.iter().enumerate() {
                    write!(f, "{}{element}", comma(index))?;
                }
                f.write_str("]")
            }
            Self::Structure(structure) => {
                write!(f, "{}(", structure.type_name)?;
                for (index, (name, value)) in structure.members.iter().enumerate() {
                    write!(f, "{}{name} := {value}", comma(index))?;
                }
                f.write_str(")")
            }
        }
    }
}

/// A tag value for readers whose numbers are all 64-bit floats, such as a browser: a whole number beyond 2^53 and a
/// number that is not finite are texts.
#[derive(Clone, Copy, Debug)]
pub struct FloatsOnly<'v>(pub &'v TagValue);

/// Up to here 64-bit floats distinguish whole numbers.
const EXACT: u128 = 1 << 53;

impl Serialize for TagValue {
    /// Numbers, truth values, texts, arrays and objects. A value without a number in JSON becomes null.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => serialize_value(*value, serializer),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Array(elements) => serializer.collect_seq(elements),
            Self::Structure(structure) => {
                let mut map = serializer.serialize_map(Some(structure.members.len()))?;
                for (name, value) in &structure.members {
                    map.serialize_entry(name, value)?;
                }
                map.end()
            }
        }
    }
}

impl Serialize for FloatsOnly<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            TagValue::Value(value) => match value.to_whole() {
                Some(whole) if whole.unsigned_abs() > EXACT => serializer.collect_str(&whole),
                None if !value.as_f64().is_finite() => serializer.collect_str(value),
                _ => serialize_value(*value, serializer),
            },
            TagValue::Text(text) => serializer.serialize_str(text),
            TagValue::Array(elements) => serializer.collect_seq(elements.iter().map(FloatsOnly)),
            TagValue::Structure(structure) => {
                let members = structure.members.iter();
                serializer.collect_map(members.map(|(name, value)| (name, FloatsOnly(value))))
            }
        }
    }
}

/// A REAL has the digits that it needs: 0.1 is not 0.10000000149.
fn serialize_value<S: Serializer>(value: Value, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Value::Bool(truth) => serializer.serialize_bool(truth),
        Value::Real(number) if number.is_finite() => serializer.serialize_f64(shortest(number)),
        Value::Lreal(number) if number.is_finite() => serializer.serialize_f64(number),
        Value::Real(_) | Value::Lreal(_) => serializer.serialize_none(),
        Value::Ulint(number) | Value::Lword(number) => serializer.serialize_u64(number),
        integer => serializer.serialize_i64(integer.to_integer().unwrap_or_default()),
    }
}

/// The 64-bit float whose shortest text is that of a 32-bit one.
pub fn shortest(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Elementary, TemplateBuilder, string_template, write_string};

    fn sample() -> (DataType, Vec<u8>) {
        let template = TemplateBuilder::new("Part", 0x123)
            .member("Ready", Elementary::Bool)
            .member("Done", Elementary::Bool)
            .array("Position", Elementary::Real, 2)
            .member("Name", string_template())
            .build();
        let mut bytes = vec![0; template.size as usize];
        bytes[0] = 0b10;
        bytes[4..8].copy_from_slice(&1.5_f32.to_le_bytes());
        bytes[8..12].copy_from_slice(&f32::NAN.to_le_bytes());
        write_string(&mut bytes[12..], "it's").expect("room");
        (template.into(), bytes)
    }

    fn json(value: &impl Serialize) -> String {
        serde_json::to_string(value).expect("serialises")
    }

    #[test]
    fn structures_decode_print_and_serialise() {
        let (data_type, bytes) = sample();
        let value = TagValue::decode(&data_type, &bytes).expect("enough bytes");
        assert_eq!(
            value.to_string(),
            r"Part(Ready := false, Done := true, Position := [1.5, NaN], Name := 'it\'s')"
        );
        assert_eq!(
            json(&value),
            r#"{"Ready":false,"Done":true,"Position":[1.5,null],"Name":"it's"}"#
        );
        assert_eq!(
            json(&FloatsOnly(&value)),
            r#"{"Ready":false,"Done":true,"Position":[1.5,"NaN"],"Name":"it's"}"#
        );
        assert!(value.flag("done"));
        assert_eq!(
            value.member("position").and_then(|p| p.numbers()).map(|p| p.len()),
            Some(2)
        );
        assert_eq!(data_type.leaves(), 5);
    }

    #[test]
    fn numbers_in_json() {
        #[rustfmt::skip]
        let cases = [
            // why                        value                            exact                   floats only
            ("a REAL by its digits",      Value::Real(0.1),                "0.1",                  "0.1"),
            ("a whole REAL",              Value::Real(100.0),              "100.0",                "100.0"),
            ("an LREAL",                  Value::Lreal(0.1),               "0.1",                  "0.1"),
            ("the last exact whole one",  Value::Lint(1 << 53),            "9007199254740992",     "9007199254740992"),
            ("one more",                  Value::Lint((1 << 53) + 1),      "9007199254740993",     "\"9007199254740993\""),
            ("as far down",               Value::Lint(-(1 << 53) - 1),     "-9007199254740993",    "\"-9007199254740993\""),
            ("the largest",               Value::Ulint(u64::MAX),          "18446744073709551615", "\"18446744073709551615\""),
            ("infinity",                  Value::Real(f32::NEG_INFINITY),  "null",                 "\"-inf\""),
            ("not a number",              Value::Lreal(f64::NAN),          "null",                 "\"NaN\""),
            ("a truth value",             Value::Bool(true),               "true",                 "true"),
        ];
        for (why, value, exact, floats_only) in cases {
            let value = TagValue::Value(value);
            assert_eq!(
                (json(&value).as_str(), json(&FloatsOnly(&value)).as_str()),
                (exact, floats_only),
                "{why}"
            );
        }
    }

    #[test]
    fn too_few_bytes_are_no_value() {
        let (data_type, bytes) = sample();
        for length in 0..bytes.len() {
            assert_eq!(TagValue::decode(&data_type, &bytes[..length]), None, "{length}");
        }
        let real = DataType::from(Elementary::Real);
        assert_eq!(TagValue::decode_array(&real, usize::MAX, &bytes), None);
        assert_eq!(TagValue::decode_array(&real, 2, &bytes[..7]), None);
    }
}
