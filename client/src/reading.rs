//! What a tag holds: values, texts, arrays and structures, decoded by their type.
//!
//! Not the wire: bytes come in as the tag services give them, without type codes.

use std::fmt;

use arcline_tag::{DataType, STRING_HANDLE, Template, Value, string_text};
use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

/// The value of a tag or a part of one.
#[derive(Clone, PartialEq, Debug)]
pub enum Reading {
    /// An elementary value.
    Value(Value),
    /// A STRING.
    Text(String),
    /// An array; several dimensions come as one, the last index changing fastest.
    Array(Vec<Reading>),
    /// A structure.
    Structure(Structure),
}

/// The members of a structure, hidden ones left out, in template order.
#[derive(Clone, PartialEq, Debug)]
pub struct Structure {
    /// Name of the type.
    pub type_name: String,
    /// Names and values.
    pub members: Vec<(String, Reading)>,
}

impl Structure {
    /// The member of that name, case ignored.
    pub fn member(&self, name: &str) -> Option<&Reading> {
        self.members
            .iter()
            .find(|(member, _)| member.eq_ignore_ascii_case(name))
            .map(|(_, reading)| reading)
    }
}

impl Reading {
    /// Decodes one element; `None` when there are too few bytes.
    pub fn decode(data_type: &DataType, bytes: &[u8]) -> Option<Self> {
        match data_type {
            DataType::Elementary(elementary) => Value::read(*elementary, bytes).map(Self::Value),
            DataType::Structure(template) if template.handle == STRING_HANDLE => {
                Some(Self::Text(string_text(bytes.get(..data_type.size())?)))
            }
            DataType::Structure(template) => Self::decode_structure(template, bytes).map(Self::Structure),
        }
    }

    /// What it is: `REAL`, `STRING`, `an array of 4`, the name of a structure type.
    pub(crate) fn type_name(&self) -> String {
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

    fn decode_structure(template: &Template, bytes: &[u8]) -> Option<Structure> {
        let mut members = Vec::new();
        for member in template.members.iter().filter(|member| !member.hidden) {
            let from = bytes.get(member.offset as usize..)?;
            let reading = match (member.bit, member.dimension) {
                (Some(bit), _) => Self::Value(Value::Bool(from.first()? & (1 << bit) != 0)),
                (None, 0) => Self::decode(&member.data_type, from)?,
                (None, count) => Self::decode_array(&member.data_type, usize::from(count), from)?,
            };
            members.push((member.name.clone(), reading));
        }
        Some(Structure {
            type_name: template.name.clone(),
            members,
        })
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
    pub fn member(&self, name: &str) -> Option<&Reading> {
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

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(value) => write!(f, "{value}"),
            Self::Text(text) => write!(f, "'{}'", text.escape_debug()),
            Self::Array(elements) => {
                f.write_str("[")?;
                for (place, element) in elements.iter().enumerate() {
                    write!(f, "{}{element}", if place == 0 { "" } else { ", " })?;
                }
                f.write_str("]")
            }
            Self::Structure(structure) => {
                write!(f, "{}(", structure.type_name)?;
                for (place, (name, reading)) in structure.members.iter().enumerate() {
                    write!(f, "{}{name} := {reading}", if place == 0 { "" } else { ", " })?;
                }
                f.write_str(")")
            }
        }
    }
}

impl Serialize for Reading {
    /// Numbers, truth values, texts, arrays and objects. What JSON has no number for becomes null.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => serialize_value(*value, serializer),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Array(elements) => {
                let mut sequence = serializer.serialize_seq(Some(elements.len()))?;
                for element in elements {
                    sequence.serialize_element(element)?;
                }
                sequence.end()
            }
            Self::Structure(structure) => {
                let mut map = serializer.serialize_map(Some(structure.members.len()))?;
                for (name, reading) in &structure.members {
                    map.serialize_entry(name, reading)?;
                }
                map.end()
            }
        }
    }
}

fn serialize_value<S: Serializer>(value: Value, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Value::Bool(truth) => serializer.serialize_bool(truth),
        Value::Real(number) if number.is_finite() => serializer.serialize_f32(number),
        Value::Lreal(number) if number.is_finite() => serializer.serialize_f64(number),
        Value::Real(_) | Value::Lreal(_) => serializer.serialize_none(),
        Value::Ulint(number) | Value::Lword(number) => serializer.serialize_u64(number),
        integer => serializer.serialize_i64(integer.to_integer().unwrap_or_default()),
    }
}

/// The type's name as it is printed: `REAL[9]`, `STRING`, `BOOL`.
pub(crate) fn type_name(data_type: &DataType, dimensions: &[u32]) -> String {
    let used: Vec<String> = dimensions
        .iter()
        .take_while(|size| **size > 0)
        .map(u32::to_string)
        .collect();
    let brackets = if used.is_empty() {
        String::new()
    } else {
        format!("[{}]", used.join(","))
    };
    format!("{}{brackets}", data_type.name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcline_tag::Elementary;
    use arcline_tag::{TemplateBuilder, string_template, write_string};

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

    #[test]
    fn structures_decode_print_and_serialise() {
        let (data_type, bytes) = sample();
        let reading = Reading::decode(&data_type, &bytes).expect("enough bytes");
        assert_eq!(
            reading.to_string(),
            r"Part(Ready := false, Done := true, Position := [1.5, NaN], Name := 'it\'s')"
        );
        let json = serde_json::to_string(&reading).expect("serialises");
        assert_eq!(
            json,
            r#"{"Ready":false,"Done":true,"Position":[1.5,null],"Name":"it's"}"#
        );
        assert!(reading.flag("done"));
        assert_eq!(
            reading.member("position").and_then(|p| p.numbers()).map(|p| p.len()),
            Some(2)
        );
    }

    #[test]
    fn too_few_bytes_are_no_value() {
        let (data_type, bytes) = sample();
        for length in 0..bytes.len() {
            let short = Reading::decode(&data_type, &bytes[..length]);
            assert!(short.is_none() || length > 90, "{length}");
        }
        let real = DataType::from(Elementary::Real);
        assert_eq!(Reading::decode_array(&real, usize::MAX, &bytes), None);
        assert_eq!(Reading::decode_array(&real, 2, &bytes[..7]), None);
    }
}
