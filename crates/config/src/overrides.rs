//! Single keys of a configuration with other values: `axis.X.max_speed`, `motion_group.coarse_update_period_ms`.

use arcline_tag::{WriteValue, nearest};
use toml::{Table, Value};

use crate::keys::{Kind, ROOT};
use crate::write::format;

/// Whether a name begins with a table of configurations, so that it can be the path of a key.
pub fn is_key(path: &str) -> bool {
    let first = path.split('.').next().unwrap_or_default();
    path.contains('.') && ROOT.keys.iter().any(|key| key.name == first)
}

/// The text of a configuration with keys replaced. The path of a key has the names of its tables; one of several (`[[axis]]`) is named by its `name`,
/// or its place from 0. The values are checked when the text is loaded.
///
/// # Errors
/// The text is not TOML, a path leads nowhere, or a value is none of TOML.
pub fn with_keys(text: &str, keys: &[(String, WriteValue)]) -> Result<String, String> {
    let mut table: Table = toml::from_str(text).map_err(|error| error.message().to_owned())?;
    for (path, value) in keys {
        let value = toml_value(value).ok_or_else(|| format!("{path}: the value does not fit into 64 bits"))?;
        set(&mut table, path, value).map_err(|why| format!("{path}: {why}"))?;
    }
    Ok(format(&table))
}

fn set(root: &mut Table, path: &str, value: Value) -> Result<(), String> {
    let parts: Vec<&str> = path.split('.').collect();
    let Some((last, tables)) = parts.split_last() else {
        return Err("expected a key".to_owned());
    };
    let mut here = root;
    let mut rest = tables.iter();
    let mut is_root = true;
    while let Some(part) = rest.next() {
        // A table inside a table may be new: whether it may be there, the reader knows.
        let may_be = here.contains_key(*part)
            || !is_root
            || ROOT
                .keys
                .iter()
                .any(|key| key.name == *part && matches!(key.kind, Kind::Table(_)));
        is_root = false;
        if !may_be {
            let known: Vec<&str> = here.keys().map(String::as_str).collect();
            return Err(missing(part, &known));
        }
        let next = here
            .entry((*part).to_owned())
            .or_insert_with(|| Value::Table(Table::new()));
        here = match next {
            Value::Table(table) => table,
            Value::Array(list) => {
                let Some(name) = rest.next() else {
                    return Err(format!("expected the name of one {part} behind {part}"));
                };
                element(list, part, name)?
            }
            _ => return Err(format!("{part} is no table")),
        };
    }
    here.insert((*last).to_owned(), value);
    Ok(())
}

/// One of several tables, by its name or its place.
fn element<'t>(list: &'t mut [Value], of: &str, name: &str) -> Result<&'t mut Table, String> {
    let named = |value: &Value| {
        let own = value.get("name").and_then(Value::as_str);
        own.is_some_and(|own| own.eq_ignore_ascii_case(name))
    };
    let place = list.iter().position(named).or_else(|| name.parse().ok());
    let known: Vec<String> = list
        .iter()
        .filter_map(|value| value.get("name").and_then(Value::as_str))
        .map(str::to_owned)
        .collect();
    let found = place
        .and_then(|place| list.get_mut(place))
        .and_then(Value::as_table_mut);
    found.ok_or_else(|| {
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        format!("there is no {of} {}", missing(name, &known))
    })
}

fn missing(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(near) => format!("{name:?}, did you mean {near:?}?"),
        None => format!("{name:?}, expected one of {}", known.join(", ")),
    }
}

fn toml_value(value: &WriteValue) -> Option<Value> {
    Some(match value {
        WriteValue::Bool(on) => Value::Boolean(*on),
        WriteValue::Integer(number) => Value::Integer(i64::try_from(*number).ok()?),
        WriteValue::Number(number) => Value::Float(*number),
        WriteValue::Text(text) => Value::String(text.clone()),
        WriteValue::Array(elements) => Value::Array(elements.iter().map(toml_value).collect::<Option<_>>()?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DEFAULT, load};

    fn with(path: &str, value: &str) -> Result<crate::Project, String> {
        let value = value.parse().expect("never fails");
        let text = with_keys(DEFAULT, &[(path.to_owned(), value)])?;
        load(&text, "config").map_err(|error| error.to_string())
    }

    #[test]
    fn keys_are_replaced_by_name_and_place() {
        let plain = load(DEFAULT, "default").expect("valid");
        let unchanged = load(&with_keys(DEFAULT, &[]).expect("TOML"), "written").expect("valid");
        assert_eq!(unchanged, plain);
        for path in ["axis.X.max_speed", "axis.x.max_speed", "axis.0.max_speed"] {
            let project = with(path, "500").expect(path);
            assert_ne!(project, plain, "{path}");
            assert_eq!(project, with("axis.X.max_speed", "500.0").expect("valid"), "{path}");
        }
        let project = with("axis.X.exception_actions.drive", "shutdown").expect("a table inside the axis");
        assert_ne!(project, plain);
        let project = with("motion_group.coarse_update_period_ms", "2").expect("valid");
        assert_eq!(project.machine.period_ns, 2_000_000);
    }

    #[test]
    fn keys_that_do_not_exist_are_reported() {
        #[rustfmt::skip]
        let cases = [
            ("axis.XX.max_speed",  "5", "there is no axis \"XX\""),
            ("axis.X.max_sped",    "5", "max_sped"),
            ("axis.max_speed",     "5", "expected the name of one axis"),
            ("axis.X.max_speed",   "fast", "max_speed"),
            ("axes.X.max_speed",   "5", "did you mean \"axis\"?"),
        ];
        for (path, value, expected) in cases {
            let error = with(path, value).expect_err(path);
            assert!(error.contains(expected), "{path}: {error}");
        }
        assert!(is_key("axis.X.max_speed") && !is_key("axis") && !is_key("X.max_speed"));
    }
}
