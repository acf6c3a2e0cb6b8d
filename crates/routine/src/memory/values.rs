//! First values: from the data of the file to the bytes of a tag.

use std::collections::BTreeMap;

use arcline_tag::{DataType, Elementary, Member, TagType, Template};

use crate::Expression;
use crate::source::{Datum, InstructionSource, Usage};
use crate::types::text_layout;

/// The add-on instructions of a project by name in lower case.
pub(super) type Definitions<'p> = BTreeMap<String, &'p InstructionSource>;

/// Calls `visit` with the template and bytes of each of some elements that are structures, and before it with those in it.
pub(crate) fn for_each_structure(
    data_type: &DataType,
    elements: &mut [u8],
    visit: &mut dyn FnMut(&Template, &mut [u8]),
) {
    structures(data_type, elements, 0, visit);
}

fn structures(data_type: &DataType, elements: &mut [u8], depth: usize, visit: &mut dyn FnMut(&Template, &mut [u8])) {
    let DataType::Structure(template) = data_type else {
        return;
    };
    let size = data_type.size();
    if depth > MAX_DEPTH || size == 0 {
        return;
    }
    for bytes in elements.chunks_exact_mut(size) {
        for member in &template.members {
            let from = member.offset as usize;
            let part = bytes.get_mut(from..from + member.size()).unwrap_or_default();
            structures(&member.data_type, part, depth + 1, visit);
        }
        visit(template, bytes);
    }
}

/// Writes first values, and notes the first one that it cannot write.
pub(super) struct FirstValues<'d> {
    definitions: &'d Definitions<'d>,
    /// The reason for which a value is missing.
    pub(super) wrong: Option<String>,
}

impl<'d> FirstValues<'d> {
    pub(super) fn new(definitions: &'d Definitions<'d>) -> Self {
        FirstValues {
            definitions,
            wrong: None,
        }
    }

    /// The values of instances: those of the definitions' parameters and local tags.
    pub(super) fn instances(&mut self, tag_type: &TagType, bytes: &mut [u8]) {
        for_each_structure(&tag_type.data_type, bytes, &mut |template, bytes| {
            self.instance(template, bytes)
        });
    }

    fn instance(&mut self, template: &Template, bytes: &mut [u8]) {
        let Some(definition) = self.definitions.get(&template.name.to_ascii_lowercase()) else {
            return;
        };
        let parameters = definition.parameters.iter().filter(|one| one.usage != Usage::InOut);
        let values = parameters.map(|one| (&one.member.name, &one.value));
        let locals = definition.locals.iter().map(|(member, value)| (&member.name, value));
        for (name, value) in values.chain(locals) {
            if let (Some(member), Some(value)) = (template.member(name), value) {
                self.member(bytes, member, value);
            }
        }
    }

    fn member(&mut self, bytes: &mut [u8], member: &Member, value: &Datum) {
        let from = member.offset as usize;
        if let Some(bit) = member.bit {
            if let (Some(byte), Datum::Number(text)) = (bytes.get_mut(from), plain(value)) {
                let mask = 1 << bit;
                *byte = if self.literal(text).0 != 0 {
                    *byte | mask
                } else {
                    *byte & !mask
                };
            }
            return;
        }
        if let Some(part) = bytes.get_mut(from..from + member.size()) {
            self.fill(part, &member.data_type, member.dimension > 0, value);
        }
    }

    /// Writes a value to the bytes of a type.
    pub(super) fn fill(&mut self, bytes: &mut [u8], data_type: &DataType, is_array: bool, value: &Datum) {
        let size = data_type.size().max(1);
        match (plain(value), data_type) {
            (Datum::Bytes(image), _) => {
                if image.len() == bytes.len() {
                    put(bytes, image);
                } else {
                    let (found, expected) = (image.len(), bytes.len());
                    self.note(|| format!("it has {found} bytes, expected {expected}"));
                }
            }
            (Datum::Unread(text), _) => self.note(|| format!("{text:?} is not understood")),
            (Datum::Array(items), DataType::Elementary(Elementary::Dword)) => {
                for (place, item) in items.iter().enumerate() {
                    if let (Datum::Number(text), Some(byte)) = (plain(item), bytes.get_mut(place / 8)) {
                        *byte |= u8::from(self.literal(text).0 != 0) << (place % 8);
                    }
                }
            }
            (Datum::Array(items), DataType::Structure(template)) if !is_array => self.in_order(bytes, template, items),
            (Datum::Array(items), _) => self.elements(bytes, data_type, size, items),
            (Datum::Number(text), DataType::Elementary(kind)) => {
                let (whole, real) = self.literal(text);
                let le = whole.to_le_bytes();
                match kind {
                    Elementary::Real => put(bytes, &(real as f32).to_le_bytes()),
                    Elementary::Lreal => put(bytes, &real.to_le_bytes()),
                    Elementary::Bool => put(bytes, &[u8::from(whole != 0)]),
                    kind => put(bytes, le.get(..kind.size()).unwrap_or_default()),
                }
            }
            (Datum::Text(text), DataType::Structure(_)) => {
                if let Some((data, capacity)) = text_layout(data_type) {
                    let length = text.len().min(capacity as usize);
                    put(bytes, &(length as i32).to_le_bytes());
                    let from = data as usize;
                    put(
                        bytes.get_mut(from..).unwrap_or_default(),
                        text.get(..length).unwrap_or_default(),
                    );
                }
            }
            (Datum::Text(text), DataType::Elementary(Elementary::Sint)) if is_array => {
                let length = text.len().min(bytes.len());
                put(bytes, text.get(..length).unwrap_or_default());
            }
            // Characters in place of a number.
            (Datum::Text(text), DataType::Elementary(kind)) if !is_array && text.len() <= kind.size() => {
                put(
                    bytes,
                    of_characters(text).to_le_bytes().get(..kind.size()).unwrap_or_default(),
                );
            }
            (Datum::Structure(_, members), DataType::Structure(template)) => {
                for (name, value) in members {
                    if let Some(member) = template.member(name) {
                        self.member(bytes, member, value);
                    }
                }
            }
            _ => self.note(|| format!("a value of another kind than {}", data_type.name())),
        }
    }

    /// The elements of an array; those of several dimensions may be rows.
    fn elements(&mut self, bytes: &mut [u8], data_type: &DataType, size: usize, items: &[Datum]) {
        let is_row = |item: &Datum| matches!(item, Datum::Array(_)) && matches!(data_type, DataType::Elementary(_));
        let rows = items.iter().any(is_row);
        let flat: Vec<&Datum> = if rows { flattened(items) } else { items.iter().collect() };
        let room = bytes.len() / size;
        if flat.len() > room {
            self.note(|| format!("it has {} elements, expected {room}", flat.len()));
        }
        for (item, part) in flat.into_iter().zip(bytes.chunks_exact_mut(size)) {
            self.fill(part, data_type, false, item);
        }
    }

    /// The members of a structure in their order, as the format L5K has them: BOOLs stand in the words that hold them.
    fn in_order(&mut self, bytes: &mut [u8], template: &Template, items: &[Datum]) {
        if self.definitions.contains_key(&template.name.to_ascii_lowercase()) {
            let name = &template.name;
            self.note(|| format!("an instance of {name} without names of its members"));
            return;
        }
        let members: Vec<&Member> = template.members.iter().filter(|member| member.bit.is_none()).collect();
        if members.len() != items.len() {
            let (name, found, expected) = (&template.name, items.len(), members.len());
            self.note(|| format!("{name} has {found} values, expected {expected}"));
            return;
        }
        for (member, item) in members.into_iter().zip(items) {
            self.member(bytes, member, item);
        }
    }

    fn literal(&mut self, text: &str) -> (i64, f64) {
        literal(text).unwrap_or_else(|| {
            self.note(|| format!("{text:?} is not understood"));
            (0, 0.0)
        })
    }

    fn note(&mut self, reason: impl FnOnce() -> String) {
        if self.wrong.is_none() {
            self.wrong = Some(reason());
        }
    }
}

/// The parameters of a message or an alarm that are members of its tag; others are words.
pub(super) fn attributes(tag_type: &TagType, bytes: &mut [u8], attributes: &BTreeMap<String, String>) {
    let DataType::Structure(template) = &tag_type.data_type else {
        return;
    };
    let definitions = Definitions::new();
    let mut values = FirstValues::new(&definitions);
    for (name, value) in attributes {
        if let Some(member) = template.member(name) {
            values.member(bytes, member, &Datum::Number(value.clone()));
        }
    }
}

fn flattened(items: &[Datum]) -> Vec<&Datum> {
    let mut flat = Vec::new();
    for item in items {
        match item {
            Datum::Array(inner) => flat.extend(flattened(inner)),
            item => flat.push(item),
        }
    }
    flat
}

fn plain(value: &Datum) -> &Datum {
    match value {
        Datum::Typed(_, inner) => inner,
        value => value,
    }
}

fn put(bytes: &mut [u8], value: &[u8]) {
    if let Some(place) = bytes.get_mut(..value.len()) {
        place.copy_from_slice(value);
    }
}

/// A number of the file as a whole number and as one with a point; 0: it is none.
pub(crate) fn number(text: &str) -> (i64, f64) {
    literal(text).unwrap_or_default()
}

/// A number of the file as a whole number and as one with a point.
fn literal(text: &str) -> Option<(i64, f64)> {
    let text = text.trim();
    if text.eq_ignore_ascii_case("true") {
        return Some((1, 1.0));
    }
    if text.eq_ignore_ascii_case("false") {
        return Some((0, 0.0));
    }
    // All of 64 bits, signed or not.
    if let Ok(whole) = text.parse::<i128>() {
        let bits = i64::try_from(whole).or_else(|_| u64::try_from(whole).map(u64::cast_signed));
        return bits.ok().map(|bits| (bits, whole as f64));
    }
    let upper = text.to_ascii_uppercase();
    if let Some(date) = upper.strip_prefix("LDT#") {
        return date_time(date, 1_000_000_000).map(|whole| (whole, whole as f64));
    }
    if let Some(date) = upper.strip_prefix("DT#") {
        return date_time(date, 1_000_000).map(|whole| (whole, whole as f64));
    }
    let constant = |expression: &Expression| match expression {
        Expression::Integer(value) => Some((*value, *value as f64)),
        Expression::Real(value) => Some((value.round_ties_even() as i64, *value)),
        Expression::Text(bytes) => {
            let whole = of_characters(bytes);
            Some((whole, whole as f64))
        }
        _ => None,
    };
    match Expression::parse(text).ok()? {
        Expression::Unary(crate::Unary::Negate, inner) => {
            constant(&inner).map(|(whole, real)| (whole.wrapping_neg(), -real))
        }
        expression => constant(&expression),
    }
}

/// The number of the radix ASCII: the first character is the highest byte.
fn of_characters(bytes: &[u8]) -> i64 {
    bytes.iter().fold(0, |value, byte| value << 8 | i64::from(*byte))
}

/// The parts of a second since 1970 of a date, `2020-01-31-12:00:00.000_000Z` or with a zone, `(UTC-05:00)`.
fn date_time(text: &str, parts: i64) -> Option<i64> {
    let (text, offset) = match text.split_once("(UTC") {
        Some((text, zone)) => {
            let zone = zone.strip_suffix(')')?;
            let sign = if zone.starts_with('-') { -1 } else { 1 };
            let (hours, minutes) = zone
                .trim_start_matches(['+', '-'])
                .split_once(':')
                .unwrap_or(("0", "0"));
            (
                text,
                sign * (hours.parse::<i64>().ok()? * 60 + minutes.parse::<i64>().ok()?),
            )
        }
        None => (text.trim_end_matches('Z'), 0),
    };
    let (date, fraction) = text.split_once('.').unwrap_or((text, ""));
    let numbers: Option<Vec<i64>> = date.split(['-', ':']).map(|part| part.parse().ok()).collect();
    let [year, month, day, hour, minute, second] = numbers?.try_into().ok()?;
    let is_valid = (1970..=9999).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    if !is_valid || hour > 23 || minute > 59 || second > 59 {
        return None;
    }
    // Days since 1970 in the Gregorian calendar, of years that begin with March.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days = 365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day - 1 - 719_468;
    let seconds = ((days * 24 + hour) * 60 + minute - offset) * 60 + second;
    let digits: String = fraction.chars().filter(|letter| *letter != '_').collect();
    let width = parts.ilog10() as usize;
    let digits = format!("{digits:0<width$}");
    let fraction: i64 = digits.get(..width)?.parse().ok()?;
    seconds.checked_mul(parts)?.checked_add(fraction)
}

/// Structures within one another.
const MAX_DEPTH: usize = 32;
