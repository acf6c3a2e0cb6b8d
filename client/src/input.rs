//! What is written to a tag, before its type is known.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

use arcline_tag::{Elementary, Value};

/// A value to write. The tag's type decides what becomes of it; what does not fit is refused, never cut.
#[derive(Clone, PartialEq, Debug)]
pub enum Input {
    /// A truth value: 0 or 1 for numbers.
    Bool(bool),
    /// A whole number, wide enough for LINT and ULINT.
    Integer(i128),
    /// A number; integers take it rounded half to even.
    Number(f64),
    /// A text, for a STRING.
    Text(String),
    /// The first elements of an array.
    Array(Vec<Input>),
}

impl Input {
    /// The value as a type; `None` when it does not fit.
    pub(crate) fn convert(&self, to: Elementary) -> Option<Value> {
        match self {
            Self::Bool(truth) => Some(Value::Bool(*truth).convert(to)),
            Self::Integer(number) => Value::from_whole(to, *number),
            Self::Number(number) if to.is_real() || to == Elementary::Bool => Some(Value::from_f64(to, *number)),
            Self::Number(number) => Value::Lreal(*number)
                .to_integer()
                .and_then(|n| Self::Integer(n.into()).convert(to)),
            Self::Text(_) | Self::Array(_) => None,
        }
    }
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(truth) => write!(f, "{truth}"),
            Self::Integer(number) => write!(f, "{number}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Text(text) => write!(f, "{:?}", text.chars().take(60).collect::<String>()),
            Self::Array(elements) => write!(f, "an array of {}", elements.len()),
        }
    }
}

impl FromStr for Input {
    type Err = Infallible;

    /// `true`, `12`, `-1.5e3`, `0x1F`, `[1, 2, 3]`, `'text'`; anything else is a text.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(parse(text.trim()))
    }
}

fn parse(text: &str) -> Input {
    let inside = |open, close| text.strip_prefix(open).and_then(|rest: &str| rest.strip_suffix(close));
    if let Some(list) = inside('[', ']') {
        let elements = split(list);
        return Input::Array(elements.into_iter().map(|element| parse(element.trim())).collect());
    }
    if let Some(quoted) = inside('\'', '\'').or_else(|| inside('"', '"')) {
        return Input::Text(quoted.to_owned());
    }
    if text.eq_ignore_ascii_case("true") || text.eq_ignore_ascii_case("false") {
        return Input::Bool(text.eq_ignore_ascii_case("true"));
    }
    let hex = text
        .strip_prefix("0x")
        .and_then(|digits| i128::from_str_radix(digits, 16).ok());
    if let Some(number) = hex.or_else(|| text.parse().ok()) {
        return Input::Integer(number);
    }
    match text.parse() {
        Ok(number) if text.contains(|c: char| c.is_ascii_digit()) => Input::Number(number),
        _ => Input::Text(text.to_owned()),
    }
}

/// At the commas outside quotes; an empty list has no elements.
fn split(list: &str) -> Vec<&str> {
    if list.trim().is_empty() {
        return Vec::new();
    }
    let mut quote = None;
    list.split(|c: char| {
        match quote {
            Some(open) if c == open => quote = None,
            None if c == '\'' || c == '"' => quote = Some(c),
            _ => {}
        }
        quote.is_none() && c == ','
    })
    .collect()
}

impl From<bool> for Input {
    fn from(truth: bool) -> Self {
        Self::Bool(truth)
    }
}

impl From<f64> for Input {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<i64> for Input {
    fn from(number: i64) -> Self {
        Self::Integer(number.into())
    }
}

impl From<u64> for Input {
    fn from(number: u64) -> Self {
        Self::Integer(number.into())
    }
}

impl From<i32> for Input {
    fn from(number: i32) -> Self {
        Self::Integer(number.into())
    }
}

impl From<&str> for Input {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl<T: Into<Input>> From<Vec<T>> for Input {
    fn from(elements: Vec<T>) -> Self {
        Self::Array(elements.into_iter().map(Into::into).collect())
    }
}

impl From<Value> for Input {
    fn from(value: Value) -> Self {
        match value {
            Value::Bool(truth) => Self::Bool(truth),
            integer => integer.to_whole().map_or(Self::Number(value.as_f64()), Self::Integer),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_values() {
        let array = |numbers: &[i128]| Input::Array(numbers.iter().map(|n| Input::Integer(*n)).collect());
        #[rustfmt::skip]
        let cases = [
            ("true", Input::Bool(true)), ("FALSE", Input::Bool(false)), ("12", Input::Integer(12)),
            ("-1.5e3", Input::Number(-1500.0)), ("0x1F", Input::Integer(31)), ("[1, 2,3]", array(&[1, 2, 3])),
            ("[]", array(&[])), ("'a, b'", Input::Text("a, b".into())), ("hello", Input::Text("hello".into())),
            ("inf", Input::Text("inf".into())), ("nan", Input::Text("nan".into())), ("", Input::Text(String::new())),
            ("['a,b', 1]", Input::Array(vec![Input::Text("a,b".into()), Input::Integer(1)])),
        ];
        for (text, expected) in cases {
            assert_eq!(text.parse(), Ok(expected), "{text}");
        }
    }

    #[test]
    fn values_take_the_tags_type_or_are_refused() {
        #[rustfmt::skip]
        let cases = [
            // why,                    given,              type,               value
            ("it fits",                Input::Integer(-128), Elementary::Sint, Some(Value::Sint(-128))),
            ("one too many",           Input::Integer(128), Elementary::Sint,  None),
            ("half to even",           Input::Number(2.5), Elementary::Dint,   Some(Value::Dint(2))),
            ("not a number",           Input::Number(f64::NAN), Elementary::Dint, None),
            ("a real takes any",       Input::Integer(3),  Elementary::Real,   Some(Value::Real(3.0))),
            ("negative into unsigned", Input::Integer(-1), Elementary::Udint,  None),
            ("a truth value",          Input::Integer(2),  Elementary::Bool,   Some(Value::Bool(true))),
            ("a bool as a number",     Input::Bool(true),  Elementary::Dint,   Some(Value::Dint(1))),
            ("a text is no number",    Input::from("1"),   Elementary::Dint,   None),
            ("64 bits",                Input::Integer(u64::MAX.into()), Elementary::Ulint, Some(Value::Ulint(u64::MAX))),
            ("65 bits",                Input::Integer(1 << 64), Elementary::Ulint, None),
            ("negative into 64 bits",  Input::Integer(-1), Elementary::Ulint, None),
            ("one too many for LINT",  Input::Integer(1 << 63), Elementary::Lint, None),
        ];
        for (why, given, to, value) in cases {
            assert_eq!(given.convert(to), value, "{why}");
        }
    }
}
