//! A value to write to a tag, before its type is known.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

use crate::{DataType, Elementary, Value, write_string};

/// A value to write. The tag's type decides the conversion; a value that does not fit is refused, never cut.
#[derive(Clone, PartialEq, Debug)]
pub enum WriteValue {
    /// A truth value: 0 or 1 for numbers.
    Bool(bool),
    /// A whole number, wide enough for LINT and ULINT.
    Integer(i128),
    /// A number.
    Number(f64),
    /// A text, for a STRING.
    Text(String),
    /// The first elements of an array.
    Array(Vec<WriteValue>),
}

/// The treatment of a number with a fraction when the tag is an integer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fraction {
    /// The nearest whole number, a half to the even one.
    Round,
    /// The value is refused.
    Refuse,
}

/// The reason for which a value does not fit a type.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Misfit {
    /// The type has no such value.
    OutOfRange,
    /// The type is an integer, the value is not whole.
    Fraction,
    /// The value is of another kind: a text for a number, a number for a structure.
    Kind,
}

impl WriteValue {
    /// The value as an elementary type.
    ///
    /// # Errors
    /// The value does not fit.
    pub fn convert(&self, to: Elementary, fraction: Fraction) -> Result<Value, Misfit> {
        match self {
            Self::Bool(truth) => Ok(Value::Bool(*truth).convert(to)),
            Self::Integer(number) => Value::from_whole(to, *number).ok_or(Misfit::OutOfRange),
            Self::Number(number) if to.is_real() || to == Elementary::Bool => Ok(Value::from_f64(to, *number)),
            Self::Number(number) if fraction == Fraction::Refuse && number.fract() != 0.0 => Err(Misfit::Fraction),
            Self::Number(number) => {
                let whole = Value::Lreal(*number).to_integer().ok_or(Misfit::OutOfRange)?;
                Self::Integer(whole.into()).convert(to, fraction)
            }
            Self::Text(_) | Self::Array(_) => Err(Misfit::Kind),
        }
    }

    /// Writes the value over the bytes of one element, `data_type.size()` of them: a number, or the text of a STRING.
    ///
    /// # Errors
    /// The value does not fit; nothing is written.
    pub fn encode(&self, data_type: &DataType, fraction: Fraction, bytes: &mut [u8]) -> Result<(), Misfit> {
        match (data_type, self) {
            (DataType::Elementary(kind), value) => {
                value.convert(*kind, fraction)?.write(bytes).ok_or(Misfit::OutOfRange)
            }
            (DataType::Structure(template), Self::Text(text)) if template.is_string() => {
                write_string(bytes, text).ok_or(Misfit::OutOfRange)
            }
            _ => Err(Misfit::Kind),
        }
    }
}

impl fmt::Display for WriteValue {
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

impl FromStr for WriteValue {
    type Err = Infallible;

    /// `true`, `12`, `-1.5e3`, `0x1F`, `[1, 2, 3]`, `'text'`; anything else is a text.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(parse(text.trim()))
    }
}

fn parse(text: &str) -> WriteValue {
    let inside = |open, close| text.strip_prefix(open).and_then(|rest: &str| rest.strip_suffix(close));
    if let Some(list) = inside('[', ']') {
        let elements = split(list);
        return WriteValue::Array(elements.into_iter().map(|element| parse(element.trim())).collect());
    }
    if let Some(quoted) = inside('\'', '\'').or_else(|| inside('"', '"')) {
        return WriteValue::Text(quoted.to_owned());
    }
    if text.eq_ignore_ascii_case("true") || text.eq_ignore_ascii_case("false") {
        return WriteValue::Bool(text.eq_ignore_ascii_case("true"));
    }
    let hex = text
        .strip_prefix("0x")
        .and_then(|digits| i128::from_str_radix(digits, 16).ok());
    if let Some(number) = hex.or_else(|| text.parse().ok()) {
        return WriteValue::Integer(number);
    }
    match text.parse() {
        Ok(number) if text.contains(|c: char| c.is_ascii_digit()) => WriteValue::Number(number),
        _ => WriteValue::Text(text.to_owned()),
    }
}

/// Splits a list at the commas outside quotes; an empty list has no elements.
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

impl From<bool> for WriteValue {
    fn from(truth: bool) -> Self {
        Self::Bool(truth)
    }
}

impl From<f64> for WriteValue {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<i64> for WriteValue {
    fn from(number: i64) -> Self {
        Self::Integer(number.into())
    }
}

impl From<u64> for WriteValue {
    fn from(number: u64) -> Self {
        Self::Integer(number.into())
    }
}

impl From<i32> for WriteValue {
    fn from(number: i32) -> Self {
        Self::Integer(number.into())
    }
}

impl From<&str> for WriteValue {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl<T: Into<WriteValue>> From<Vec<T>> for WriteValue {
    fn from(elements: Vec<T>) -> Self {
        Self::Array(elements.into_iter().map(Into::into).collect())
    }
}

impl From<Value> for WriteValue {
    fn from(value: Value) -> Self {
        match value {
            Value::Bool(truth) => Self::Bool(truth),
            integer => integer.to_whole().map_or(Self::Number(value.as_f64()), Self::Integer),
        }
    }
}

/// Truth values, numbers, texts and arrays, as JSON has them.
impl<'de> Deserialize<'de> for WriteValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = WriteValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, true, false or a text")
    }

    fn visit_bool<E: Error>(self, truth: bool) -> Result<WriteValue, E> {
        Ok(truth.into())
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<WriteValue, E> {
        Ok(number.into())
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<WriteValue, E> {
        Ok(number.into())
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<WriteValue, E> {
        Ok(number.into())
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<WriteValue, E> {
        Ok(text.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<WriteValue, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = elements.next_element()? {
            values.push(value);
        }
        Ok(WriteValue::Array(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_values() {
        let array = |numbers: &[i128]| WriteValue::Array(numbers.iter().map(|n| WriteValue::Integer(*n)).collect());
        #[rustfmt::skip]
        let cases = [
            ("true", WriteValue::Bool(true)), ("FALSE", WriteValue::Bool(false)), ("12", WriteValue::Integer(12)),
            ("-1.5e3", WriteValue::Number(-1500.0)), ("0x1F", WriteValue::Integer(31)), ("[1, 2,3]", array(&[1, 2, 3])),
            ("[]", array(&[])), ("'a, b'", WriteValue::Text("a, b".into())), ("hello", WriteValue::Text("hello".into())),
            ("inf", WriteValue::Text("inf".into())), ("nan", WriteValue::Text("nan".into())), ("", WriteValue::Text(String::new())),
            ("['a,b', 1]", WriteValue::Array(vec![WriteValue::Text("a,b".into()), WriteValue::Integer(1)])),
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
            ("it fits",                WriteValue::Integer(-128), Elementary::Sint, Some(Value::Sint(-128))),
            ("one too many",           WriteValue::Integer(128), Elementary::Sint,  None),
            ("half to even",           WriteValue::Number(2.5), Elementary::Dint,   Some(Value::Dint(2))),
            ("not a number",           WriteValue::Number(f64::NAN), Elementary::Dint, None),
            ("a real takes any",       WriteValue::Integer(3),  Elementary::Real,   Some(Value::Real(3.0))),
            ("negative into unsigned", WriteValue::Integer(-1), Elementary::Udint,  None),
            ("a truth value",          WriteValue::Integer(2),  Elementary::Bool,   Some(Value::Bool(true))),
            ("a bool as a number",     WriteValue::Bool(true),  Elementary::Dint,   Some(Value::Dint(1))),
            ("a text is no number",    WriteValue::from("1"),   Elementary::Dint,   None),
            ("64 bits",                WriteValue::Integer(u64::MAX.into()), Elementary::Ulint, Some(Value::Ulint(u64::MAX))),
            ("65 bits",                WriteValue::Integer(1 << 64), Elementary::Ulint, None),
            ("negative into 64 bits",  WriteValue::Integer(-1), Elementary::Ulint, None),
            ("one too many for LINT",  WriteValue::Integer(1 << 63), Elementary::Lint, None),
        ];
        for (why, given, to, value) in cases {
            assert_eq!(given.convert(to, Fraction::Round).ok(), value, "{why}");
        }
    }

    #[test]
    fn values_that_do_not_fit_have_their_error() {
        #[rustfmt::skip]
        let cases = [
            ("a fraction",           WriteValue::Number(2.5),   Elementary::Dint, Err(Misfit::Fraction)),
            ("whole, as a float",    WriteValue::Number(2.0),   Elementary::Dint, Ok(Value::Dint(2))),
            ("a fraction, too large", WriteValue::Number(300.5), Elementary::Sint, Err(Misfit::Fraction)),
            ("too large",            WriteValue::Number(300.0), Elementary::Sint, Err(Misfit::OutOfRange)),
            ("beyond 64 bits",       WriteValue::Number(1e300), Elementary::Lint, Err(Misfit::OutOfRange)),
            ("a BOOL of a fraction", WriteValue::Number(0.5),   Elementary::Bool, Ok(Value::Bool(true))),
            ("a text",               WriteValue::from("1"),     Elementary::Dint, Err(Misfit::Kind)),
        ];
        for (why, given, to, expected) in cases {
            assert_eq!(given.convert(to, Fraction::Refuse), expected, "{why}");
        }
        let string = DataType::from(crate::string_template());
        let mut bytes = [0; crate::STRING_SIZE];
        let long = WriteValue::Text("x".repeat(83));
        assert_eq!(
            long.encode(&string, Fraction::Round, &mut bytes),
            Err(Misfit::OutOfRange)
        );
        assert_eq!(
            WriteValue::from(1).encode(&string, Fraction::Round, &mut bytes),
            Err(Misfit::Kind)
        );
        assert_eq!(
            WriteValue::from("CS1").encode(&string, Fraction::Round, &mut bytes),
            Ok(())
        );
        assert_eq!(crate::string_text(&bytes), "CS1");
    }

    #[test]
    fn json_becomes_values() {
        #[rustfmt::skip]
        let cases = [
            ("true", Some(WriteValue::Bool(true))), ("-5", Some(WriteValue::Integer(-5))),
            ("18446744073709551615", Some(WriteValue::Integer(u64::MAX.into()))), ("1.5", Some(WriteValue::Number(1.5))),
            ("\"a\"", Some(WriteValue::from("a"))), ("[1, 2]", Some(WriteValue::from(vec![1, 2]))),
            ("null", None), ("{}", None),
        ];
        for (text, expected) in cases {
            assert_eq!(serde_json::from_str(text).ok(), expected, "{text}");
        }
    }
}
