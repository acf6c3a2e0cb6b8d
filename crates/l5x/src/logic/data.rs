//! First values: data as a tree. `Decorated` data name their members, so they go first; `String` is a text, L5K has values in the order of
//! members, and data without a format are the bytes of the tag.

use arcline_routine::source::Datum;
use roxmltree::Node;

use super::{dimensions, l5k, text_of};
use crate::document::{child, children, shortened};
use crate::text;

/// The first value of a tag or parameter, whose data stand in elements of that name.
pub(super) fn value(node: Node<'_, '_>, element: &'static str) -> Option<Datum> {
    let data = |format: &str| children(node, element).find(|data| data.attribute("Format") == Some(format));
    if let Some(data) = data("Decorated") {
        return data.children().find(Node::is_element).and_then(|node| datum(node, 0));
    }
    if let Some(first) = data("String") {
        let content = first.text().unwrap_or_default().trim();
        let first = text::string(content).map_or_else(|| Datum::Unread(shortened(content)), Datum::Text);
        let sizes = dimensions(node, "Dimensions").into_iter();
        let value = match sizes.reduce(u32::saturating_mul) {
            Some(count) => texts(unnamed(node, element), first, count),
            None => first,
        };
        return Some(value).filter(|_| !content.is_empty());
    }
    // Axes, messages and alarms have a format of their own.
    let has_own = |data: Node<'_, '_>| data.attribute("Format").is_some_and(|format| format != "L5K");
    if children(node, element).any(has_own) {
        return None;
    }
    unnamed(node, element)
}

/// The value of an array of texts: of the format String is its first element alone; all of them may stand beside it.
fn texts(all: Option<Datum>, first: Datum, count: u32) -> Datum {
    match all {
        Some(Datum::Array(texts)) => Datum::Array(texts),
        // LEN and some characters of each.
        Some(Datum::Bytes(bytes)) if bytes.len() % count as usize == 0 && bytes.len() / count as usize > 4 => {
            Datum::Bytes(bytes)
        }
        _ => Datum::Array(vec![first]),
    }
}

/// Data in the format L5K, or the bytes of the whole tag.
fn unnamed(node: Node<'_, '_>, element: &'static str) -> Option<Datum> {
    let in_format = |format: Option<&str>| children(node, element).find(|data| data.attribute("Format") == format);
    if let Some(data) = in_format(Some("L5K")) {
        let text: String = data.children().filter_map(|part| part.text()).collect();
        return Some(l5k::value(&text)).filter(|_| !text.trim().is_empty());
    }
    let text = in_format(None)?.text().unwrap_or_default().trim();
    let bytes: Option<Vec<u8>> = text
        .split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).ok())
        .collect();
    Some(bytes.map_or_else(|| Datum::Unread(shortened(text)), Datum::Bytes)).filter(|_| !text.is_empty())
}

/// A `DataValue`, `Array`, `Structure`, or a member.
fn datum(node: Node<'_, '_>, depth: usize) -> Option<Datum> {
    if depth > MAX_DEPTH {
        return None;
    }
    let kind = node.attribute("DataType").unwrap_or_default();
    match node.tag_name().name() {
        "Array" | "ArrayMember" => {
            let elements = children(node, "Element").map(|element| match child(element, "Structure") {
                Some(structure) => datum(structure, depth + 1).unwrap_or_else(zero),
                None => Datum::Number(element.attribute("Value").unwrap_or("0").to_owned()),
            });
            Some(typed(kind, Datum::Array(elements.collect())))
        }
        "Structure" | "StructureMember" => {
            let members = node.children().filter(Node::is_element);
            let text = members
                .clone()
                .find(|member| member.attribute("Name") == Some("DATA") && member.attribute("Value").is_none());
            if let Some(text) = text.filter(|member| member.tag_name().name() == "DataValueMember") {
                return characters(text).map(Datum::Text);
            }
            let members =
                members.filter_map(|member| Some((member.attribute("Name")?.to_owned(), datum(member, depth + 1)?)));
            Some(Datum::Structure(kind.to_owned(), members.collect()))
        }
        "DataValue" | "DataValueMember" => match node.attribute("Value") {
            Some(value) => Some(typed(kind, Datum::Number(value.to_owned()))),
            None => characters(node).map(Datum::Text),
        },
        _ => None,
    }
}

/// The characters of a text in quotes; an empty one may have none.
fn characters(node: Node<'_, '_>) -> Option<Vec<u8>> {
    let quoted = text_of(node);
    match quoted.trim() {
        "" => Some(Vec::new()),
        quoted => text::string(quoted),
    }
}

fn zero() -> Datum {
    Datum::Number("0".to_owned())
}

fn typed(kind: &str, value: Datum) -> Datum {
    if kind.is_empty() {
        value
    } else {
        Datum::Typed(kind.to_owned(), Box::new(value))
    }
}

/// Values within one another.
const MAX_DEPTH: usize = 64;
