//! First values: `Data` in the formats `Decorated` and `String`, by the type of the tag.

use arcline_tag::{Elementary, STRING_CAPACITY};
use roxmltree::Node;
use toml::{Table, Value};

use super::Importer;
use super::types::{Kind, Member, Types};
use crate::document::{child, children, shortened};
use crate::{L5xError, Problem, Reason, text};

/// In lower case.
const CAM_PROFILE: &str = "cam_profile";

impl<'a, 't> Importer<'a, 't> {
    /// The first value of a tag; `None`: zeros, or none that is understood.
    pub(super) fn first_value(
        &mut self,
        tag: Node<'a, 't>,
        types: &Types,
        kind: &Kind,
        dimensions: &[u32],
    ) -> Result<Option<Value>, L5xError> {
        let data = |format: &str| children(tag, "Data").find(|data| data.attribute("Format") == Some(format));
        let value = if let Some(data) = data("Decorated") {
            self.source.check(data);
            match data.children().find(Node::is_element) {
                Some(node) => Some(self.value(node, types, kind, dimensions)?),
                None => None,
            }
        } else if let Some(data) = data("String") {
            self.source.check(data);
            let text = self.characters(data, types, kind)?;
            Some(self.first_of(data, text, kind, dimensions))
        } else {
            for data in children(tag, "Data") {
                self.source.report(
                    data,
                    Reason::Changed("a value that is only there as L5K or bytes becomes 0"),
                );
            }
            None
        };
        Ok(value.filter(|value| !is_zero(value)))
    }

    /// A `DataValue`, `Array`, `Structure` or member.
    fn value(&mut self, node: Node<'a, 't>, types: &Types, kind: &Kind, dimensions: &[u32]) -> Result<Value, L5xError> {
        self.source.check(node);
        if dimensions.is_empty() {
            return match kind {
                Kind::Elementary(elementary) => self.scalar(node, *elementary),
                Kind::Text | Kind::Structure(_) => self.structure(node, types, kind),
            };
        }
        let mut values = Vec::new();
        for element in children(node, "Element") {
            self.source.check(element);
            values.push(match kind {
                Kind::Elementary(elementary) => self.scalar(element, *elementary)?,
                Kind::Text | Kind::Structure(_) => match child(element, "Structure") {
                    Some(structure) => {
                        self.source.check(structure);
                        self.structure(structure, types, kind)?
                    }
                    None => return Err(self.missing(element, "Structure", "the element's structure")),
                },
            });
        }
        let product = dimensions
            .iter()
            .fold(1u64, |all, count| all.saturating_mul(u64::from(*count)));
        if values.len() as u64 != product {
            let found = format!("{} Element", values.len());
            let expected = "as many as the tag's or member's dimensions say";
            return Err(self.source.error(node, Problem::Value { found, expected }));
        }
        Ok(in_rows(values, dimensions))
    }

    /// The value of a tag whose file has one text: that of its first element, when the tag is an array.
    fn first_of(&mut self, data: Node<'a, 't>, text: Value, kind: &Kind, dimensions: &[u32]) -> Value {
        if dimensions.is_empty() {
            return text;
        }
        let words = "of an array of texts the first one is there as a text, the others become empty";
        self.source.report(data, Reason::Changed(words));
        let empty = match kind {
            Kind::Text => Value::String(String::new()),
            Kind::Elementary(_) | Kind::Structure(_) => Value::Table(Table::new()),
        };
        let count = dimensions.iter().map(|count| *count as usize).product::<usize>();
        let others = std::iter::repeat_n(empty, count.saturating_sub(1));
        in_rows(std::iter::once(text).chain(others).collect(), dimensions)
    }

    fn scalar(&mut self, node: Node<'a, 't>, kind: Elementary) -> Result<Value, L5xError> {
        let (value, expected) = match (kind, node.attribute("Value")) {
            (_, None) => (None, "a value"),
            (Elementary::Bool, Some(word)) => {
                let bit = match word {
                    "true" => Some(1),
                    "false" => Some(0),
                    word => text::integer(Elementary::Dint, word),
                };
                (bit.map(|bit| Value::Boolean(bit != 0)), "0 or 1")
            }
            (kind, Some(word)) if kind.is_real() => (text::real(word).map(Value::Float), "a number"),
            (kind, Some(word)) => {
                if word.contains("DT#") || word.contains("T#") {
                    return Ok(self.zero(node, "a value in a radix of time becomes 0"));
                }
                let value = text::integer(kind, word).map(|whole| match i64::try_from(whole) {
                    Ok(whole) => Value::Integer(whole),
                    Err(_) => self.zero(node, "a ULINT of 2^63 or more, for which TOML has no number, becomes 0"),
                });
                (value, "a whole number that the type holds")
            }
        };
        value.ok_or_else(|| self.source.wrong(node, "Value", expected))
    }

    /// The replacement of a value that Arcline cannot have, which is reported.
    fn zero(&mut self, node: Node<'a, 't>, words: &'static str) -> Value {
        self.source.report_attribute(node, "Value", Reason::Changed(words));
        Value::Integer(0)
    }

    /// The members of a structure; those that are not there are 0.
    fn structure(&mut self, node: Node<'a, 't>, types: &Types, kind: &Kind) -> Result<Value, L5xError> {
        let Kind::Structure(key) = kind else {
            let member = |name| node.children().find(|child| child.attribute("Name") == Some(name));
            for member in [member("LEN"), member("DATA")].into_iter().flatten() {
                self.source.check(member);
            }
            return match member("DATA") {
                Some(data) => self.characters(data, types, kind),
                None => Ok(Value::String(String::new())),
            };
        };
        if key == CAM_PROFILE {
            return Ok(self.cam_profile(node));
        }
        let mut table = Table::new();
        let members: &[Member] = types.structure(key).map_or(&[], |structure| &structure.members);
        for child in node.children().filter(Node::is_element) {
            let name = self.source.required(child, "Name", "the member's name")?;
            let Some(member) = members.iter().find(|member| member.name.eq_ignore_ascii_case(name)) else {
                self.source.check(child);
                self.source.report(child, Reason::NoCounterpart);
                continue;
            };
            let is_text = member.kind == Kind::Elementary(Elementary::Sint)
                && member.dimension > 0
                && child.tag_name().name() == "DataValueMember";
            let value = if is_text {
                self.source.check(child);
                self.bytes(child, member.dimension)?
            } else {
                let dimensions = if member.dimension == 0 {
                    &[][..]
                } else {
                    &[member.dimension]
                };
                self.value(child, types, &member.kind, dimensions)?
            };
            if !is_zero(&value) {
                table.insert(member.name.clone(), value);
            }
        }
        Ok(Value::Table(table))
    }

    /// An export has only the Status of a calculated profile: an empty profile replaces it.
    fn cam_profile(&mut self, node: Node<'a, 't>) -> Value {
        for member in node.children().filter(Node::is_element) {
            self.source.check(member);
            if member.attribute("Name") == Some("Status") && member.attribute("Value") != Some("0") {
                let words = "a calculated cam profile becomes an empty one, which MCCP fills";
                self.source.report_attribute(member, "Value", Reason::Changed(words));
            }
        }
        Value::Table(Table::new())
    }

    /// A text in quotes: of STRING, or of a structure with LEN and DATA.
    fn characters(&mut self, node: Node<'a, 't>, types: &Types, kind: &Kind) -> Result<Value, L5xError> {
        if let Kind::Structure(key) = kind {
            let members: &[Member] = types.structure(key).map_or(&[], |structure| &structure.members);
            let data = members.iter().find(|member| member.name.eq_ignore_ascii_case("DATA"));
            let Some(data) = data.filter(|data| data.kind == Kind::Elementary(Elementary::Sint)) else {
                self.source.report(node, Reason::NotUnderstood);
                return Ok(Value::Table(Table::new()));
            };
            let length = text::string(node.text().unwrap_or_default()).map_or(0, |bytes| bytes.len());
            let value = self.bytes(node, data.dimension)?;
            return Ok(Value::Table(Table::from_iter([
                ("LEN".to_owned(), Value::Integer(length as i64)),
                ("DATA".to_owned(), value),
            ])));
        }
        let bytes = self.quoted(node, STRING_CAPACITY)?;
        Ok(Value::String(String::from_utf8(bytes).unwrap_or_else(|error| {
            self.source.report(
                node,
                Reason::Changed("bytes of a text that are not UTF-8 become \u{FFFD} or fall away"),
            );
            let mut text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            while text.len() > STRING_CAPACITY {
                text.pop();
            }
            text
        })))
    }

    /// A text in quotes as a list of SINT, filled up with zeros.
    fn bytes(&mut self, node: Node<'a, 't>, room: u32) -> Result<Value, L5xError> {
        let mut bytes = self.quoted(node, room as usize)?;
        bytes.resize(room as usize, 0);
        let numbers = bytes.into_iter().map(|byte| Value::Integer(i64::from(byte as i8)));
        Ok(Value::Array(numbers.collect()))
    }

    fn quoted(&self, node: Node<'a, 't>, room: usize) -> Result<Vec<u8>, L5xError> {
        let content = node.text().unwrap_or_default();
        if content.trim().is_empty() {
            return Ok(Vec::new());
        }
        let bytes = text::string(content).filter(|bytes| bytes.len() <= room);
        bytes.ok_or_else(|| {
            let found = shortened(content.trim());
            let expected = "a text in single quotes, no longer than the type";
            self.source.error(node, Problem::Value { found, expected })
        })
    }

    fn missing(&self, node: Node<'a, 't>, what: &'static str, expected: &'static str) -> L5xError {
        self.source.error(node, Problem::Missing { what, expected })
    }
}

/// Elements, the last subscript fastest, as lists of lists.
fn in_rows(mut values: Vec<Value>, dimensions: &[u32]) -> Value {
    for count in dimensions.iter().skip(1).rev() {
        let mut rows = Vec::with_capacity(values.len() / *count as usize);
        let mut rest = values.into_iter();
        loop {
            let row: Vec<Value> = rest.by_ref().take(*count as usize).collect();
            if row.is_empty() {
                break;
            }
            rows.push(Value::Array(row));
        }
        values = rows;
    }
    Value::Array(values)
}

/// Whether a value equals the default. Minus zero does not.
fn is_zero(value: &Value) -> bool {
    match value {
        Value::String(text) => text.is_empty(),
        Value::Integer(number) => *number == 0,
        Value::Float(number) => number.to_bits() == 0,
        Value::Boolean(flag) => !flag,
        Value::Array(items) => items.iter().all(is_zero),
        Value::Table(table) => table.values().all(is_zero),
        Value::Datetime(_) => false,
    }
}
