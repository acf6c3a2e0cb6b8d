//! Values of arguments: rates, points, and the words of operands, which the instruction catalogue has.

use std::str::FromStr;

use arcline_client::nearest;
use arcline_instruction_set::{FAULTS, FaultKind, Word, Words};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser as _};

/// A magnitude in units or in percent of the maximum.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Rate {
    Units(f64),
    Percent(f64),
}

impl FromStr for Rate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (digits, make): (_, fn(f64) -> Self) = match text.trim().strip_suffix('%') {
            Some(digits) => (digits, Self::Percent),
            None => (text, Self::Units),
        };
        number(digits)
            .map(make)
            .ok_or_else(|| format!("{text:?} is not a number, expected such as 50 or 50%"))
    }
}

/// A percentage of the programmed speeds.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Percent(pub(crate) f64);

impl FromStr for Percent {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.trim();
        let digits = digits.strip_suffix('%').unwrap_or(digits);
        number(digits)
            .filter(|percent| (0.0..=200.0).contains(percent))
            .map(Self)
            .ok_or_else(|| format!("{text:?} is not a percentage from 0 to 200, expected such as 50 or 50%"))
    }
}

/// Coordinates.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Point(pub(crate) Vec<f64>);

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let list = text.trim();
        let list = list
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
            .unwrap_or(list);
        let numbers: Option<Vec<f64>> = list.split(',').map(number).collect();
        numbers
            .map(Self)
            .ok_or_else(|| format!("{text:?} is not a point, expected numbers such as 100,50,0"))
    }
}

/// Finite numbers only.
fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

/// Reads a word of an enumeration, or its number.
pub(super) fn word_parser(
    words: &'static Words,
) -> impl Fn(&str) -> Result<i32, String> + Clone + Send + Sync + 'static {
    move |text| {
        let value = text.parse().ok().or_else(|| words.parse_word(text));
        value.filter(|value| words.contains(*value)).ok_or_else(|| {
            let keywords: Vec<String> = words.words.iter().map(Word::keyword).collect();
            match nearest(text, keywords.iter().map(String::as_str)) {
                Some(near) => format!("did you mean {near}? Expected {}", words.choices()),
                None => format!("expected {}", words.choices()),
            }
        })
    }
}

/// A kind of fault by its word.
pub(super) fn fault_parser() -> impl clap::builder::TypedValueParser<Value = FaultKind> {
    PossibleValuesParser::new(
        FAULTS
            .iter()
            .map(|fault| PossibleValue::new(fault.word).help(fault.meaning)),
    )
    .try_map(|word| FaultKind::from_word(&word).ok_or("no kind of fault"))
}

/// An update period of 1 µs to a minute, ms.
pub(super) fn milliseconds(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|period| (0.001..=60_000.0).contains(period))
        .ok_or_else(|| format!("{text:?} is no update period, expected milliseconds such as 2"))
}

/// A speed of either sign, units/s.
pub(super) fn speed(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|speed| speed.abs() <= 1e15)
        .ok_or_else(|| format!("{text:?} is no speed, expected a number such as 500"))
}

/// A time of 1 ms to a year.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|seconds| (0.001..=3.2e7).contains(seconds))
        .ok_or_else(|| format!("{text:?} is no time, expected seconds such as 0.5"))
}
