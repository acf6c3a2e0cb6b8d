//! `tags`, `read`, `write`.

use serde_json::json;

use arcline_client::{Access, Client, ClientError, Elementary, TagValue, WriteValue, nearest};
use arcline_proto::cip::CipStatus;

use super::args::{CreateTag, DeleteTag, TagAccess, Tags, TagsChange, Write};
use super::output::table;
use super::{Failure, Output};

/// `tags`.
pub(crate) async fn tags(client: &Client, command: &Tags, output: &Output) -> Result<(), Failure> {
    match &command.change {
        None => list(client, command.pattern.as_deref(), output).await,
        Some(TagsChange::Create(command)) => create(client, command, output).await,
        Some(TagsChange::Delete(command)) => delete(client, command, output).await,
    }
}

async fn create(client: &Client, command: &CreateTag, output: &Output) -> Result<(), Failure> {
    let name = full_name(command.program.as_deref(), &command.name);
    let access = match command.access {
        TagAccess::ReadWrite => Access::ReadWrite,
        TagAccess::ReadOnly => Access::ReadOnly,
    };
    let created = client.create_tag(&name, &command.data_type, access).await;
    let instance = created.map_err(|error| not_created(error, command))?;
    output.result(
        format!("{name} created"),
        || json!({"tag": name, "type": command.data_type, "instance": instance}),
    );
    Ok(())
}

/// The reason for which a tag was not created, as far as the name or the type is the cause.
fn not_created(error: ClientError, command: &CreateTag) -> Failure {
    let CreateTag { name, data_type, .. } = command;
    let hint = match &error {
        ClientError::Refused { status, .. } if status.is(CipStatus::OBJECT_ALREADY_EXISTS) => {
            let hint = "choose another name, or delete that tag first".to_owned();
            return Failure::Hint { source: error, hint };
        }
        ClientError::Refused { status, .. } if status.is(CipStatus::INVALID_PARAMETER) && !is_name(name) => {
            format!(
                "{name:?} cannot be the name of a tag: a name has 1 to 40 letters, digits and underscores and begins with no digit"
            )
        }
        ClientError::Refused { status, .. } if status.is(CipStatus::INVALID_PARAMETER) => {
            let element = data_type.split('[').next().unwrap_or_default().trim();
            if element.eq_ignore_ascii_case("MOTION_INSTRUCTION") {
                "a motion control tag is made by the first instruction that names it".to_owned()
            } else if Elementary::ALL
                .iter()
                .any(|known| known.name().eq_ignore_ascii_case(element))
            {
                format!(
                    "{data_type:?} cannot be its type: an array has one to three dimensions from 1 up, such as {element}[4] or {element}[2,3]"
                )
            } else {
                let known: Vec<&str> = Elementary::ALL.iter().map(|known| known.name()).collect();
                format!(
                    "{element:?} cannot be its type; types are {}, STRING, those of the configuration, and arrays of them such as REAL[4]",
                    known.join(", ")
                )
            }
        }
        _ => return error.into(),
    };
    Failure::Usage(hint)
}

/// Whether the server accepts a name for a tag.
fn is_name(name: &str) -> bool {
    let begins = name.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
    begins && name.len() <= 40 && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

async fn delete(client: &Client, command: &DeleteTag, output: &Output) -> Result<(), Failure> {
    let name = full_name(command.program.as_deref(), &command.name);
    match client.delete_tag(&name).await {
        Err(source @ ClientError::Refused { status, .. }) if status.is(CipStatus::PRIVILEGE_VIOLATION) => {
            let hint = "only plain tags can be deleted".to_owned();
            return Err(Failure::Hint { source, hint });
        }
        result => result?,
    }
    output.result(format!("{name} deleted"), || json!({"tag": name}));
    Ok(())
}

fn full_name(program: Option<&str>, name: &str) -> String {
    program.map_or_else(|| name.to_owned(), |program| format!("Program:{program}.{name}"))
}

async fn list(client: &Client, pattern: Option<&str>, output: &Output) -> Result<(), Failure> {
    let tags = client.browse().await?;
    let mut rows = Vec::new();
    for tag in tags
        .iter()
        .filter(|tag| pattern.is_none_or(|pattern| matches(pattern, &tag.name)))
    {
        let access = match tag.access {
            Access::ReadWrite => "read/write",
            Access::ReadOnly => "read-only",
            Access::None => "none",
        };
        if output.is_json() {
            output.result(
                "",
                || json!({"name": tag.name, "type": tag.type_name(), "access": access}),
            );
        }
        rows.push(vec![tag.name.clone(), tag.type_name(), access.to_owned()]);
    }
    if let Some(pattern) = pattern.filter(|_| rows.is_empty()) {
        let near = nearest(pattern, tags.iter().map(|tag| &tag.name));
        let near = near.map(|near| format!(", did you mean {near:?}?")).unwrap_or_default();
        output.note(&format!("no tag matches {pattern:?}{near}"));
    } else if !output.is_json() {
        output.result(table(&["tag", "type", "access"], &rows), || json!(null));
    }
    Ok(())
}

/// Whether a pattern matches a name: with `*` or `?` the whole name, otherwise a part of it; case is ignored.
fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name) = (pattern.to_ascii_lowercase(), name.to_ascii_lowercase());
    if pattern.contains(['*', '?']) {
        glob(pattern.as_bytes(), name.as_bytes())
    } else {
        name.contains(&pattern)
    }
}

/// Goes back to the last star only, so it takes at most the product of the lengths.
fn glob(pattern: &[u8], name: &[u8]) -> bool {
    let (mut p, mut n, mut star) = (0, 0, None);
    while n < name.len() {
        match pattern.get(p) {
            Some(b'*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(one) if *one == b'?' || name.get(n) == Some(one) => {
                p += 1;
                n += 1;
            }
            _ => {
                let Some((at, from)) = star else { return false };
                star = Some((at, from + 1));
                p = at + 1;
                n = from + 1;
            }
        }
    }
    pattern.get(p..).unwrap_or_default().iter().all(|rest| *rest == b'*')
}

/// `read`.
pub(crate) async fn read(client: &Client, tags: &[String], output: &Output) -> Result<(), Failure> {
    let counts: Vec<(&str, Option<usize>)> = tags.iter().map(|tag| counted_path(tag)).collect();
    let paths: Vec<&str> = counts.iter().map(|(path, _)| *path).collect();
    let readings = client.read_many(&paths).await?.into_iter().zip(&counts);
    let readings = readings.map(|(reading, (path, count))| first(reading?, path, *count));
    let (mut failures, alone) = (Vec::new(), tags.len() == 1);
    for (tag, reading) in tags.iter().zip(readings) {
        match reading {
            Ok(reading) => output.result(text(tag, &reading, alone), || json!({"tag": tag, "value": reading})),
            Err(error) => failures.push(Failure::from(error)),
        }
    }
    let last = failures.pop();
    failures.iter().for_each(|failure| output.failure(failure));
    last.map_or(Ok(()), Err)
}

/// `Tag{3}`, as pycomm3 writes the first three elements of an array: the path without the count, and the count.
fn counted_path(tag: &str) -> (&str, Option<usize>) {
    let counted = tag.strip_suffix('}').and_then(|rest| rest.rsplit_once('{'));
    match counted.and_then(|(path, count)| Some((path, count.parse().ok()?))) {
        Some((path, count)) => (path, Some(count)),
        None => (tag, None),
    }
}

/// The first elements of an array.
fn first(reading: TagValue, path: &str, count: Option<usize>) -> Result<TagValue, ClientError> {
    match (reading, count) {
        (reading, None) => Ok(reading),
        (TagValue::Array(mut elements), Some(count)) if (1..=elements.len()).contains(&count) => {
            elements.truncate(count);
            Ok(TagValue::Array(elements))
        }
        (reading, Some(count)) => Err(ClientError::Value {
            path: path.to_owned(),
            expected: match reading {
                TagValue::Array(elements) => format!("an array of {}", elements.len()),
                _ => "no array".to_owned(),
            },
            given: format!("a count of {count}"),
        }),
    }
}

/// A value alone, or `tag = value`; members of a structure one a line.
fn text(tag: &str, reading: &TagValue, alone: bool) -> String {
    match reading {
        TagValue::Structure(structure) => {
            let mut lines = vec![format!("{tag} ({})", structure.type_name)];
            members(reading, 1, &mut lines);
            lines.join("\n")
        }
        value if alone => value.to_string(),
        value => format!("{tag} = {value}"),
    }
}

fn members(reading: &TagValue, depth: usize, lines: &mut Vec<String>) {
    let TagValue::Structure(structure) = reading else {
        return;
    };
    let shown = || {
        structure
            .members
            .iter()
            .filter(|(name, _)| !name.starts_with("DEAD_ZONE"))
    };
    let width = shown().map(|(name, _)| name.len()).max().unwrap_or_default();
    for (name, member) in shown() {
        let indent = 2 * depth;
        if matches!(member, TagValue::Structure(_)) {
            lines.push(format!("{:indent$}{name}", ""));
            members(member, depth + 1, lines);
        } else {
            lines.push(format!("{:indent$}{name:width$}  {member}", ""));
        }
    }
}

/// `write`.
pub(crate) async fn write(client: &Client, command: &Write, output: &Output) -> Result<(), Failure> {
    let value = as_text_where_needed(client, command).await?;
    client.write(&command.tag, value).await?;
    let reading = client.read(&command.tag).await?;
    output.result(
        format!("{} = {reading}", command.tag),
        || json!({"tag": command.tag, "value": reading}),
    );
    Ok(())
}

/// The first number with decimals that is written to an integer: the integer's type, and the number.
fn fraction(reading: &TagValue, value: &WriteValue) -> Option<(String, f64)> {
    match (reading, value) {
        (TagValue::Array(elements), WriteValue::Array(values)) => {
            values.iter().find_map(|value| fraction(elements.first()?, value))
        }
        (TagValue::Value(now), WriteValue::Number(number)) if number.is_finite() && number.fract() != 0.0 => {
            let elementary = now.elementary();
            let takes_any = elementary.is_real() || elementary == Elementary::Bool;
            (!takes_any).then(|| (elementary.name().to_owned(), *number))
        }
        _ => None,
    }
}

/// `12` for a STRING is a text, though it looks like a number.
async fn as_text_where_needed(client: &Client, command: &Write) -> Result<WriteValue, Failure> {
    let reading = client.read(&command.tag).await?;
    if let Some((integer, number)) = fraction(&reading, &command.value) {
        return Err(ClientError::Value {
            path: command.tag.clone(),
            expected: integer,
            given: number.to_string(),
        }
        .into());
    }
    let is_text = matches!(reading, TagValue::Text(_));
    Ok(match &command.value {
        value @ (WriteValue::Bool(_) | WriteValue::Integer(_) | WriteValue::Number(_)) if is_text => {
            WriteValue::Text(value.to_string())
        }
        value => value.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match() {
        #[rustfmt::skip]
        let cases = [
            ("move", "Move1", true), ("OVE", "Move1", true), ("x", "Move1", false), ("", "Move1", true),
            ("move*", "Move1", true), ("*1", "Move1", true), ("m*e?", "Move1", true), ("m*e", "Move1", false),
            ("?", "X", true), ("?", "XY", false), ("**", "", true), ("a*b*c", "aXbXbc", true), ("*a", "", false),
        ];
        for (pattern, name, expected) in cases {
            assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
        }
    }
}
