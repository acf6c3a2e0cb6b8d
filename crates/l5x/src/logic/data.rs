//! First values: `Decorated` and `String` data as a tree.

use arcline_routine::source::Datum;
use roxmltree::Node;

use crate::document::{child, children};
use crate::text;

/// The first value of a tag or parameter, whose data stand in elements of that name.
pub(super) fn value(node: Node<'_, '_>, element: &'static str) -> Option<Datum> {
    let data = |format: &str| children(node, element).find(|data| data.attribute("Format") == Some(format));
    if let Some(data) = data("Decorated") {
        return data.children().find(Node::is_element).and_then(|node| datum(node, 0));
    }
    let data = data("String")?;
    text::string(data.text().unwrap_or_default()).map(Datum::Text)
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
                return text::string(text.text().unwrap_or_default()).map(Datum::Text);
            }
            let members =
                members.filter_map(|member| Some((member.attribute("Name")?.to_owned(), datum(member, depth + 1)?)));
            Some(Datum::Structure(kind.to_owned(), members.collect()))
        }
        "DataValue" | "DataValueMember" => match node.attribute("Value") {
            Some(value) => Some(typed(kind, Datum::Number(value.to_owned()))),
            None => text::string(node.text().unwrap_or_default()).map(Datum::Text),
        },
        _ => None,
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
