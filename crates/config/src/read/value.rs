//! First values of plain tags: numbers, `true`, text, lists and tables, as bytes on the wire.

use arcline_tag::{DataType, Elementary, TagType, Value, write_string};
use toml::de::DeValue;

/// The kinds of a first value.
const NUMBER: &str = "a number that the type holds";
const TRUTH: &str = "true or false";
const TEXT: &str = "a text of up to 82 bytes";
const LIST: &str = "a list with a value for every element, dimension by dimension";
const MEMBERS: &str = "a table of the structure's members";

/// Writes a value over the bytes of a tag.
///
/// # Errors
/// The expected value, if the value does not fit.
pub(super) fn encode(tag_type: &TagType, value: &DeValue<'_>, bytes: &mut [u8]) -> Result<(), &'static str> {
    let rank = tag_type.rank();
    elements(&tag_type.data_type, &tag_type.dimensions[..rank], value, bytes)
}

fn elements(
    data_type: &DataType,
    dimensions: &[u32],
    value: &DeValue<'_>,
    bytes: &mut [u8],
) -> Result<(), &'static str> {
    let [count, inner @ ..] = dimensions else {
        return one(data_type, value, bytes);
    };
    let DeValue::Array(items) = value else {
        return Err(LIST);
    };
    let is_bools = inner.is_empty() && matches!(data_type, DataType::Elementary(Elementary::Dword));
    let count = *count as usize;
    if is_bools {
        if items.len() > 32 * count {
            return Err(LIST);
        }
        for (place, item) in items.iter().enumerate() {
            let DeValue::Boolean(on) = item.get_ref() else {
                return Err(TRUTH);
            };
            if let Some(byte) = bytes.get_mut(place / 8)
                && *on
            {
                *byte |= 1 << (place % 8);
            }
        }
        return Ok(());
    }
    if items.len() != count {
        return Err(LIST);
    }
    let size = bytes.len() / count.max(1);
    for (item, bytes) in items.iter().zip(bytes.chunks_mut(size.max(1))) {
        elements(data_type, inner, item.get_ref(), bytes)?;
    }
    Ok(())
}

fn one(data_type: &DataType, value: &DeValue<'_>, bytes: &mut [u8]) -> Result<(), &'static str> {
    match data_type {
        DataType::Elementary(Elementary::Bool) => {
            let DeValue::Boolean(on) = value else { return Err(TRUTH) };
            if let Some(byte) = bytes.first_mut() {
                *byte = u8::from(*on);
            }
            Ok(())
        }
        DataType::Elementary(kind) => number(*kind, value).and_then(|value| value.write(bytes)).ok_or(NUMBER),
        DataType::Structure(template) if template.is_string() => {
            let DeValue::String(text) = value else { return Err(TEXT) };
            write_string(bytes, text).ok_or(TEXT)
        }
        DataType::Structure(template) => {
            let DeValue::Table(table) = value else {
                return Err(MEMBERS);
            };
            for (name, value) in table.iter() {
                let member = template
                    .member(name.get_ref())
                    .filter(|member| !member.hidden)
                    .ok_or(MEMBERS)?;
                let offset = member.offset as usize;
                if let Some(bit) = member.bit {
                    let DeValue::Boolean(on) = value.get_ref() else {
                        return Err(TRUTH);
                    };
                    if let Some(byte) = bytes.get_mut(offset).filter(|_| *on) {
                        *byte |= 1 << bit;
                    }
                    continue;
                }
                let bytes = bytes.get_mut(offset..offset + member.size()).ok_or(MEMBERS)?;
                let dimension = [u32::from(member.dimension)];
                let dimensions = if member.dimension == 0 { &[][..] } else { &dimension };
                elements(&member.data_type, dimensions, value.get_ref(), bytes)?;
            }
            Ok(())
        }
    }
}

/// A number as the type keeps it; `None` if the type cannot hold it.
fn number(kind: Elementary, value: &DeValue<'_>) -> Option<Value> {
    match value {
        DeValue::Integer(integer) => {
            let whole = i64::from_str_radix(integer.as_str(), integer.radix()).ok()?;
            Value::from_whole(kind, whole.into())
        }
        DeValue::Float(float) if matches!(kind, Elementary::Real | Elementary::Lreal) => {
            let number: f64 = float.as_str().parse().ok()?;
            Some(Value::from_f64(kind, number))
        }
        _ => None,
    }
}
