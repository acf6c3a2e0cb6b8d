//! The bytes of tags as values. An array of BOOLs is one of truths, as routines see it.

use arcline_routine::Tag;
use arcline_tag::{DataType, Elementary, StructureValue, TagValue, Template, Value};

/// The value of a whole tag in the memory of its project.
pub(crate) fn of_tag(tag: &Tag, memory: &[u8]) -> Option<TagValue> {
    let bytes = memory.get(tag.at as usize..)?;
    match tag.bits() {
        Some(bits) => truths(bytes, bits as usize),
        None => array(&tag.tag_type.data_type, &tag.tag_type.dimensions, bytes),
    }
}

/// A value, or lists of them by dimension.
pub(crate) fn array(data_type: &DataType, dimensions: &[u32], bytes: &[u8]) -> Option<TagValue> {
    let [count, rest @ ..] = dimensions else {
        return one(data_type, bytes);
    };
    if *count == 0 {
        return one(data_type, bytes);
    }
    let inner = rest.iter().take_while(|size| **size > 0);
    let size = inner.fold(data_type.size(), |size, count| size.saturating_mul(*count as usize));
    let elements = (0..*count as usize).map(|index| array(data_type, rest, bytes.get(index * size..)?));
    elements.collect::<Option<_>>().map(TagValue::Array)
}

fn one(data_type: &DataType, bytes: &[u8]) -> Option<TagValue> {
    match data_type {
        DataType::Elementary(Elementary::Bool) => truth(bytes, 0),
        DataType::Elementary(kind) => Value::read(*kind, bytes).map(TagValue::Value),
        DataType::Structure(template) => match text_layout(data_type) {
            Some((data, capacity)) => text(bytes, data, capacity),
            None => structure(template, bytes),
        },
    }
}

fn structure(template: &Template, bytes: &[u8]) -> Option<TagValue> {
    let members = template.members.iter().filter(|member| !member.hidden).map(|member| {
        let from = bytes.get(member.offset as usize..)?;
        let is_word = member.data_type == DataType::Elementary(Elementary::Dword);
        let value = match (member.bit, member.dimension) {
            (Some(bit), _) => truth(from, usize::from(bit)),
            (None, count) if is_word && count > 0 => truths(from, 32 * usize::from(count)),
            (None, count) => array(&member.data_type, &[u32::from(count)], from),
        };
        Some((member.name.clone(), value?))
    });
    Some(TagValue::Structure(StructureValue {
        type_name: template.name.clone(),
        members: members.collect::<Option<_>>()?,
    }))
}

/// The first byte of the text in a type with LEN and DATA, and how many it has.
pub(crate) fn text_layout(data_type: &DataType) -> Option<(usize, usize)> {
    let DataType::Structure(template) = data_type else {
        return None;
    };
    let (length, data) = (template.member("LEN")?, template.member("DATA")?);
    let visible = template.members.iter().filter(|member| !member.hidden).count();
    let is_text = visible == 2 && data.dimension > 0 && data.data_type.size() == 1 && length.offset == 0;
    is_text.then(|| (data.offset as usize, data.size()))
}

fn text(bytes: &[u8], data: usize, capacity: usize) -> Option<TagValue> {
    let length = i32::from_le_bytes(bytes.first_chunk().copied()?);
    let length = usize::try_from(length).unwrap_or(0).min(capacity);
    let text = bytes.get(data..data + length)?;
    Some(TagValue::Text(String::from_utf8_lossy(text).into_owned()))
}

pub(crate) fn truths(bytes: &[u8], count: usize) -> Option<TagValue> {
    let all = (0..count).map(|bit| truth(bytes, bit));
    all.collect::<Option<_>>().map(TagValue::Array)
}

pub(crate) fn truth(bytes: &[u8], bit: usize) -> Option<TagValue> {
    let byte = bytes.get(bit / 8)?;
    Some(TagValue::Value(Value::Bool(byte >> (bit % 8) & 1 == 1)))
}
