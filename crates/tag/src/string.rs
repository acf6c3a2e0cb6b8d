//! The STRING type (spec/ethernet-ip.md §11): a length and up to 82 bytes of text.

use std::sync::{Arc, LazyLock};

use crate::{DataType, Elementary, Template, TemplateBuilder};

/// Template instance of STRING.
pub const STRING_INSTANCE: u16 = 0xFCE;
/// Structure handle of STRING; clients decode a structure with this handle as a string.
pub const STRING_HANDLE: u16 = 0x0FCE;
/// Characters in a STRING.
pub const STRING_CAPACITY: usize = 82;
/// Bytes of a STRING: length DINT, 82 characters, 2 bytes of padding.
pub const STRING_SIZE: usize = 88;

/// The STRING type: template `ASCIISTRING82` with LEN DINT and DATA SINT\[82\], 88 bytes.
pub fn string_template() -> Arc<Template> {
    static STRING: LazyLock<Arc<Template>> = LazyLock::new(|| {
        TemplateBuilder::new("ASCIISTRING82", STRING_INSTANCE)
            .member("LEN", Elementary::Dint)
            .array("DATA", Elementary::Sint, STRING_CAPACITY as u16)
            .handle(STRING_HANDLE)
            .build()
    });
    STRING.clone()
}

/// The text in the bytes of a STRING; a length beyond the data is cut, bytes that are not UTF-8 are replaced.
pub fn string_text(bytes: &[u8]) -> String {
    let length = bytes.first_chunk().map_or(0, |length| i32::from_le_bytes(*length));
    let data = bytes.get(4..).unwrap_or_default();
    let length = usize::try_from(length)
        .unwrap_or(0)
        .min(STRING_CAPACITY)
        .min(data.len());
    String::from_utf8_lossy(&data[..length]).into_owned()
}

/// Brings the length of every STRING in `bytes`, those of a structure, within 0 to 82.
pub fn clamp_strings(template: &Template, bytes: &mut [u8]) {
    if template.is_string() {
        if let Some(length) = bytes.first_chunk_mut::<4>() {
            let clamped = i32::from_le_bytes(*length).clamp(0, STRING_CAPACITY as i32);
            *length = clamped.to_le_bytes();
        }
        return;
    }
    for member in &template.members {
        let DataType::Structure(inner) = &member.data_type else {
            continue;
        };
        let start = member.offset as usize;
        let Some(bytes) = bytes.get_mut(start..start + member.size()) else {
            continue;
        };
        bytes
            .chunks_mut((inner.size as usize).max(1))
            .for_each(|element| clamp_strings(inner, element));
    }
}

/// Writes text into the bytes of a STRING; `None`, and nothing written, when the text or the room is too
/// long or too short.
pub fn write_string(bytes: &mut [u8], text: &str) -> Option<()> {
    let length = i32::try_from(text.len()).ok()?;
    let bytes = bytes.get_mut(..STRING_SIZE)?;
    if text.len() > STRING_CAPACITY {
        return None;
    }
    bytes.fill(0);
    bytes[..4].copy_from_slice(&length.to_le_bytes());
    bytes[4..4 + text.len()].copy_from_slice(text.as_bytes());
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_cut_and_refused() {
        let mut bytes = [0xFF; STRING_SIZE];
        assert_eq!(string_text(&bytes), "", "a negative length is empty");
        bytes[..4].copy_from_slice(&1000i32.to_le_bytes());
        assert!(string_text(&bytes).chars().count() <= STRING_CAPACITY);
        assert_eq!(string_text(&bytes[..3]), "");
        assert_eq!(write_string(&mut bytes, "CS1"), Some(()));
        assert_eq!(string_text(&bytes), "CS1");
        assert_eq!(write_string(&mut bytes, &"x".repeat(83)), None);
        assert_eq!(write_string(&mut [0; 87], "x"), None);
        assert_eq!(string_text(&bytes), "CS1");
    }

    #[test]
    fn lengths_within_structures_are_clamped() {
        let template = TemplateBuilder::new("Part", 0x123)
            .member("Id", Elementary::Dint)
            .array("Names", string_template(), 2)
            .build();
        let mut bytes = vec![0xFF; template.size as usize];
        bytes[4 + STRING_SIZE..][..4].copy_from_slice(&100i32.to_le_bytes());
        clamp_strings(&template, &mut bytes);
        assert_eq!(bytes[..4], [0xFF; 4], "a number stays");
        assert_eq!(bytes[4..8], 0i32.to_le_bytes());
        assert_eq!(bytes[4 + STRING_SIZE..][..4], 82i32.to_le_bytes());
    }
}
