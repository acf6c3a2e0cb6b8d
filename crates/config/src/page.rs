//! The tables of docs/CONFIGURATION.md from the table of keys.

use std::fmt::Write as _;

use crate::keys::{self, Default, Key, Keys};

/// The page with the table under each heading of the keys written anew; the text between them stays.
///
/// # Errors
/// The heading that the page does not have, or that no table follows.
pub fn page(page: &str) -> Result<String, String> {
    let mut page = page.to_owned();
    for keys in TABLES {
        let heading = keys.heading;
        let missing = || format!("no table under {heading}");
        let from = page.find(&format!("\n{heading}\n")).ok_or_else(missing)?;
        let below = page.get(from + 1..).unwrap_or_default();
        let head = below.find(HEAD).ok_or_else(missing)?;
        if below.find("\n#").is_some_and(|next| next < head) {
            return Err(missing());
        }
        let from = from + 1 + head;
        let rest = page.get(from..).unwrap_or_default();
        let rows = rest.split_inclusive('\n').take_while(|line| line.starts_with('|'));
        let length: usize = rows.map(str::len).sum();
        page.replace_range(from..from + length, &table(keys));
    }
    Ok(page)
}

fn table(keys: &Keys) -> String {
    let mut text = format!("{HEAD}\n|---|---|---|\n");
    let same = |a: &Key, b: &Key| (a.default, a.meaning) == (b.default, b.meaning);
    for row in keys.keys.chunk_by(same) {
        let Some(first) = row.first() else { continue };
        let names: Vec<String> = row.iter().map(|key| format!("`{}`", key.name)).collect();
        // Writing to a String cannot fail.
        let _ = match default(first.default) {
            none if none.is_empty() => writeln!(text, "| {} | | {} |", names.join(", "), first.meaning),
            default => writeln!(text, "| {} | {default} | {} |", names.join(", "), first.meaning),
        };
    }
    text
}

fn default(default: Default) -> String {
    match default {
        Default::Required => String::new(),
        Default::Number(number) => format!("`{number:?}`"),
        Default::Integer(number) => format!("`{number}`"),
        Default::Boolean(flag) => format!("`{flag}`"),
        Default::Text(text) => format!("`{text:?}`"),
        Default::Prose(prose) => prose.to_owned(),
    }
}

const HEAD: &str = "| key | default | meaning |";

const TABLES: [&Keys; 23] = [
    &keys::SERVER,
    &keys::SECURITY,
    &keys::CERTIFICATE,
    &keys::CONTROLLER,
    &keys::MESSAGE,
    &keys::MOTION_GROUP,
    &keys::AXIS,
    &keys::START,
    &keys::DRIVE,
    &keys::FEED,
    &keys::REGISTRATION,
    &keys::EXCEPTION_ACTIONS,
    &keys::COMMAND_LIMITS,
    &keys::TRAVEL,
    &keys::HOME,
    &keys::SWITCH,
    &keys::MARKER,
    &keys::COORDINATE_SYSTEM,
    &keys::TRANSFORM,
    &keys::INSTRUCTION,
    &keys::DATA_TYPE,
    &keys::MEMBER,
    &keys::TAG,
];
