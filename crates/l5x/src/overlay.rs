//! What L5X has no place for: keys of a configuration in a `Provider` of Arcline in the controller's `CustomProperties`.
//! They are the difference between a project and what its L5X says without them, so nothing is listed twice.

use std::cmp::Ordering;

use toml::{Table, Value};

/// `ID` of Arcline's provider.
pub(crate) const PROVIDER: &str = "Arcline";
/// The key that holds the full names of all tags in their order, where the file's order is another.
const ORDER: &str = "order";

/// What of `whole` is not in `part`; `None`: nothing.
pub(crate) fn difference(whole: &Table, part: &Table) -> Option<Table> {
    let mut overlay = Table::new();
    for (key, value) in whole {
        if part.get(key) == Some(value) {
            continue;
        }
        let lost = match (value, part.get(key)) {
            (Value::Table(whole), Some(Value::Table(part))) => difference(whole, part).map(Value::Table),
            (Value::Array(whole), other) if whole.iter().all(|item| identity(item).is_some()) => {
                let part = other.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
                let items: Vec<Value> = whole.iter().filter_map(|item| lost_of(item, part)).collect();
                (!items.is_empty()).then_some(Value::Array(items))
            }
            _ => Some(value.clone()),
        };
        overlay.extend(lost.map(|lost| (key.clone(), lost)));
    }
    let names = |table: &Table| -> Vec<String> { sections(table, "tag").filter_map(identity).collect() };
    let (wanted, found) = (names(whole), names(part));
    if wanted != found && !wanted.is_empty() {
        overlay.insert(ORDER.into(), Value::Array(wanted.into_iter().map(Value::String).collect()));
    }
    (!overlay.is_empty()).then_some(overlay)
}

/// An entry of a list as far as it is not in the list's other version, with what identifies it.
fn lost_of(item: &Value, part: &[Value]) -> Option<Value> {
    let (name, whole) = (identity(item)?, item.as_table()?);
    let same = |other: &&Value| identity(other).is_some_and(|other| other.eq_ignore_ascii_case(&name));
    let Some(other) = part.iter().find(same).and_then(Value::as_table) else {
        return Some(item.clone());
    };
    let mut lost = difference(whole, other)?;
    for key in ["name", "tag", "program"] {
        lost.extend(whole.get(key).map(|value| (key.to_owned(), value.clone())));
    }
    Some(Value::Table(lost))
}

/// Puts an overlay over what the rest of a file said.
pub(crate) fn merge(table: &mut Table, overlay: Table) {
    let mut order = None;
    for (key, value) in overlay {
        match (table.get_mut(&key), value) {
            (None, value) if key == ORDER => order = Some(value),
            (Some(Value::Table(table)), Value::Table(overlay)) => merge(table, overlay),
            (Some(Value::Array(items)), Value::Array(overlay)) if overlay.iter().all(|one| identity(one).is_some()) => {
                for item in overlay {
                    merge_item(items, item);
                }
            }
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
    let (Some(Value::Array(order)), Some(Value::Array(tags))) = (order, table.get_mut("tag")) else {
        return;
    };
    let names: Vec<String> = order.iter().filter_map(Value::as_str).map(str::to_ascii_lowercase).collect();
    let place = |tag: &Value| {
        let name = identity(tag).unwrap_or_default().to_ascii_lowercase();
        names.iter().position(|other| *other == name)
    };
    let mut placed: Vec<(Option<usize>, Value)> = std::mem::take(tags).into_iter().map(|tag| (place(&tag), tag)).collect();
    // What the list does not know comes behind all else, in its own order.
    placed.sort_by(|(a, _), (b, _)| match (a, b) {
        (Some(a), Some(b)) => a.cmp(b),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => Ordering::Equal,
    });
    tags.extend(placed.into_iter().map(|(_, tag)| tag));
}

fn merge_item(items: &mut Vec<Value>, item: Value) {
    let name = identity(&item).unwrap_or_default();
    let same = |other: &&mut Value| identity(other).is_some_and(|other| other.eq_ignore_ascii_case(&name));
    match (items.iter_mut().find(same), item) {
        (Some(Value::Table(table)), Value::Table(overlay)) => merge(table, overlay),
        (_, item) => items.push(item),
    }
}

/// Whether the overlay says a key of an entry: `axis`, `X`, `["home", "speed"]`.
pub(crate) fn says(overlay: &Table, section: &str, name: &str, key: &[&str]) -> bool {
    let same = |item: &&Value| identity(item).is_some_and(|other| other.eq_ignore_ascii_case(name));
    let entry = sections(overlay, section).find(same);
    key.iter()
        .try_fold(entry, |value, key| value.map(|value| value.get(*key)))
        .flatten()
        .is_some()
}

fn sections<'t>(table: &'t Table, key: &str) -> impl Iterator<Item = &'t Value> + use<'t> {
    table.get(key).and_then(Value::as_array).into_iter().flatten()
}

/// The name of an entry of a list, a tag's with its program.
fn identity(item: &Value) -> Option<String> {
    let name = item.get("name").or_else(|| item.get("tag"))?.as_str()?;
    Some(match item.get("program").and_then(Value::as_str) {
        Some(program) => format!("Program:{program}.{name}"),
        None => name.to_owned(),
    })
}
