//! First values as decorated data.

use arcline_tag::{DataType, Elementary, Template, Value, shortest, string_text};

use super::xml::Xml;
use crate::text;

/// The position of a value, which decides its element.
#[derive(Clone, Copy)]
pub(super) enum ValueKind<'n> {
    /// The value of a tag.
    Value,
    /// The value of a member.
    Member(&'n str),
}

/// The radix that Studio shows a type in.
pub(super) fn radix(data_type: &DataType) -> &'static str {
    match data_type {
        DataType::Elementary(kind) if kind.is_real() => "Float",
        DataType::Elementary(_) => "Decimal",
        DataType::Structure(_) => "NullType",
    }
}

/// Writes a value of a type from its bytes.
pub(super) fn value(xml: &mut Xml, kind: ValueKind<'_>, data_type: &DataType, dimensions: &[u32], bytes: &[u8]) {
    let bits = matches!(data_type, DataType::Elementary(Elementary::Dword));
    let word = if bits { "BOOL" } else { data_type.name() };
    let named = |element: &'static str, member: &'static str| match kind {
        ValueKind::Value => (element, Vec::new()),
        ValueKind::Member(name) => (member, vec![("Name", name)]),
    };
    if dimensions.is_empty() {
        match data_type {
            DataType::Elementary(kind) => {
                let (element, mut attributes) = named("DataValue", "DataValueMember");
                let number = number(*kind, bytes);
                attributes.extend([("DataType", word), ("Radix", radix(data_type)), ("Value", &number)]);
                xml.empty(element, &attributes);
            }
            DataType::Structure(template) => {
                let (element, mut attributes) = named("Structure", "StructureMember");
                attributes.push(("DataType", word));
                xml.open(element, &attributes);
                members(xml, template, bytes);
                xml.close(element);
            }
        }
        return;
    }
    let (element, mut attributes) = named("Array", "ArrayMember");
    let scale = if bits { 32 } else { 1 };
    let counts: Vec<String> = dimensions.iter().map(|count| (count * scale).to_string()).collect();
    let counts = counts.join(",");
    attributes.extend([("DataType", word), ("Dimensions", &counts)]);
    if matches!(data_type, DataType::Elementary(_)) {
        attributes.push(("Radix", radix(data_type)));
    }
    xml.open(element, &attributes);
    let elements: usize = dimensions.iter().map(|count| (count * scale) as usize).product();
    let size = data_type.size().max(1);
    for place in 0..elements {
        let index = index(place, dimensions, scale);
        match data_type {
            DataType::Elementary(_) if bits => {
                let on = bytes.get(place / 8).is_some_and(|byte| byte >> (place % 8) & 1 == 1);
                xml.empty("Element", &[("Index", &index), ("Value", if on { "1" } else { "0" })]);
            }
            DataType::Elementary(kind) => {
                let number = number(*kind, bytes.get(place * size..).unwrap_or_default());
                xml.empty("Element", &[("Index", &index), ("Value", &number)]);
            }
            DataType::Structure(template) => {
                xml.open("Element", &[("Index", &index)]);
                xml.open("Structure", &[("DataType", word)]);
                members(xml, template, bytes.get(place * size..).unwrap_or_default());
                xml.close("Structure");
                xml.close("Element");
            }
        }
    }
    xml.close(element);
}

fn members(xml: &mut Xml, template: &Template, bytes: &[u8]) {
    if template.is_string() {
        let content = string_text(bytes);
        let length = content.len().to_string();
        let head = [
            ("Name", "LEN"),
            ("DataType", "DINT"),
            ("Radix", "Decimal"),
            ("Value", length.as_str()),
        ];
        xml.empty("DataValueMember", &head);
        let head = [("Name", "DATA"), ("DataType", "STRING"), ("Radix", "ASCII")];
        xml.text("DataValueMember", &head, &text::write_string(content.as_bytes()));
        return;
    }
    for member in template.members.iter().filter(|member| !member.hidden) {
        let from = member.offset as usize;
        if let Some(bit) = member.bit {
            let on = bytes.get(from).is_some_and(|byte| byte >> bit & 1 == 1);
            let head = [
                ("Name", member.name.as_str()),
                ("DataType", "BOOL"),
                ("Value", if on { "1" } else { "0" }),
            ];
            xml.empty("DataValueMember", &head);
            continue;
        }
        let dimension = [u32::from(member.dimension)];
        let dimensions = if member.dimension == 0 { &[][..] } else { &dimension };
        let bytes = bytes.get(from..from + member.size()).unwrap_or_default();
        value(
            xml,
            ValueKind::Member(&member.name),
            &member.data_type,
            dimensions,
            bytes,
        );
    }
}

fn number(kind: Elementary, bytes: &[u8]) -> String {
    match Value::read(kind, bytes) {
        Some(Value::Real(number)) => text::write_real(shortest(number)),
        Some(Value::Lreal(number)) => text::write_real(number),
        Some(value) => value.to_whole().unwrap_or(0).to_string(),
        None => "0".to_owned(),
    }
}

/// `[0,1,2]`: the indices of an element.
fn index(place: usize, dimensions: &[u32], scale: u32) -> String {
    let mut rest = place;
    let mut indices: Vec<String> = Vec::new();
    for count in dimensions.iter().rev() {
        let count = (count * scale).max(1) as usize;
        indices.push((rest % count).to_string());
        rest /= count;
    }
    indices.reverse();
    format!("[{}]", indices.join(","))
}
