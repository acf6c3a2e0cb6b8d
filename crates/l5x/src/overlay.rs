//! Keys without a counterpart in L5X: they stand in a `Provider` of Arcline in the controller's `CustomProperties`.
//! They are the difference between a project and its L5X without them, so no value is there twice.

use std::collections::BTreeMap;

use toml::{Table, Value};

/// `ID` of Arcline's provider.
pub(crate) const PROVIDER: &str = "Arcline";
/// The key that holds the full names of all tags in their order, where the file's order is another.
const ORDER: &str = "order";

/// The keys of `whole` that are not in `part`, both tables of a configuration; `None`: no key.
pub(crate) fn difference(whole: &Table, part: &Table) -> Option<Table> {
    let mut overlay = Table::new();
    for (key, value) in whole {
        let lost = match (value, part.get(key)) {
            (value, Some(other)) if value == other => None,
            (Value::Table(whole), Some(Value::Table(part))) => lost_keys(whole, part).map(Value::Table),
            (Value::Array(whole), Some(Value::Array(part))) => {
                let index = index(part);
                let lost = |item: &Value| lost_of(item, identity(item).and_then(|name| part.get(*index.get(&name)?)));
                let items: Vec<Value> = whole.iter().filter_map(lost).collect();
                (!items.is_empty()).then_some(Value::Array(items))
            }
            _ => Some(value.clone()),
        };
        overlay.extend(lost.map(|lost| (key.clone(), lost)));
    }
    let names = |table: &Table| -> Vec<String> { sections(table, "tag").filter_map(identity).collect() };
    let (wanted, found) = (names(whole), names(part));
    if wanted != found && !wanted.is_empty() {
        overlay.insert(
            ORDER.into(),
            Value::Array(wanted.into_iter().map(Value::String).collect()),
        );
    }
    (!overlay.is_empty()).then_some(overlay)
}

/// The part of a list's entry that the other version of the list does not have, with the keys that identify the entry.
fn lost_of(item: &Value, other: Option<&Value>) -> Option<Value> {
    let (Value::Table(whole), Some(Value::Table(other))) = (item, other) else {
        return Some(item.clone());
    };
    let mut lost = lost_keys(whole, other)?;
    for key in ["name", "tag", "program"] {
        lost.extend(whole.get(key).map(|value| (key.to_owned(), value.clone())));
    }
    Some(Value::Table(lost))
}

fn lost_keys(whole: &Table, part: &Table) -> Option<Table> {
    let mut lost = Table::new();
    for (key, value) in whole {
        let value = match (value, part.get(key)) {
            (value, Some(other)) if value == other => None,
            (Value::Table(whole), Some(Value::Table(part))) => lost_keys(whole, part).map(Value::Table),
            _ => Some(value.clone()),
        };
        lost.extend(value.map(|value| (key.clone(), value)));
    }
    (!lost.is_empty()).then_some(lost)
}

/// Puts an overlay over another.
pub(crate) fn merge(table: &mut Table, overlay: Table) {
    for (key, value) in overlay {
        match (table.get_mut(&key), value) {
            (Some(Value::Table(table)), Value::Table(overlay)) => merge_keys(table, overlay),
            (Some(Value::Array(items)), Value::Array(overlay)) if key != ORDER => {
                let index = index(items);
                for item in overlay {
                    let place = identity(&item).and_then(|name| index.get(&name));
                    match (place.and_then(|place| items.get_mut(*place)), item) {
                        (Some(Value::Table(table)), Value::Table(overlay)) => merge_keys(table, overlay),
                        (_, item) => items.push(item),
                    }
                }
            }
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}

fn merge_keys(table: &mut Table, overlay: Table) {
    for (key, value) in overlay {
        match (table.get_mut(&key), value) {
            (Some(Value::Table(table)), Value::Table(overlay)) => merge_keys(table, overlay),
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}

/// Puts an overlay over the rest of a file, and the tags into their order. Tags that the order does not know
/// come behind all others.
pub(crate) fn apply(table: &mut Table, mut overlay: Table) {
    let order = overlay.remove(ORDER);
    merge(table, overlay);
    let (Some(Value::Array(order)), Some(Value::Array(tags))) = (order, table.get_mut("tag")) else {
        return;
    };
    let names = order.iter().filter_map(Value::as_str).enumerate();
    let places: BTreeMap<String, usize> = names.map(|(place, name)| (name.to_ascii_lowercase(), place)).collect();
    tags.sort_by_cached_key(|tag| {
        let place = identity(tag).and_then(|name| places.get(&name.to_ascii_lowercase()));
        place.copied().unwrap_or(usize::MAX)
    });
}

/// The indices of the entries of a list, by their identity.
fn index(items: &[Value]) -> BTreeMap<String, usize> {
    let named = items.iter().enumerate();
    named
        .filter_map(|(place, item)| Some((identity(item)?, place)))
        .collect()
}

/// Whether the overlay has a key of an entry: `axis`, `X`, `["home", "speed"]`.
pub(crate) fn says(overlay: &Table, section: &str, name: &str, key: &[&str]) -> bool {
    let same = |item: &&Value| {
        item.get("name")
            .and_then(Value::as_str)
            .is_some_and(|other| other.eq_ignore_ascii_case(name))
    };
    let entry = sections(overlay, section).find(same);
    key.iter()
        .try_fold(entry, |value, key| value.map(|value| value.get(*key)))
        .flatten()
        .is_some()
}

fn sections<'t>(table: &'t Table, key: &str) -> impl Iterator<Item = &'t Value> + use<'t> {
    table.get(key).and_then(Value::as_array).into_iter().flatten()
}

/// The name of an entry of a list in lower case, a tag's with its program.
fn identity(item: &Value) -> Option<String> {
    let name = item.get("name").or_else(|| item.get("tag"))?.as_str()?;
    Some(match item.get("program").and_then(Value::as_str) {
        Some(program) => format!("Program:{program}.{name}").to_ascii_lowercase(),
        None => name.to_ascii_lowercase(),
    })
}
