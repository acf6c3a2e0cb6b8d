//! The one table of keys: the keys of a configuration with their kinds, defaults and meanings. Reading, checking, the
//! list of known keys, writing, docs/CONFIGURATION.md and the JSON Schema follow from it. `read` has the rules between keys.

mod tables;

use std::borrow::Cow;
use std::net::SocketAddr;
use std::ops::RangeInclusive;

pub(crate) use self::tables::*;
use crate::read::{is_name, member_types, tag_types};

/// The keys of one table.
#[derive(Debug)]
pub(crate) struct Keys {
    /// Its heading in docs/CONFIGURATION.md.
    pub(crate) heading: &'static str,
    /// The expected kind of table, for messages.
    pub(crate) expected: &'static str,
    pub(crate) keys: &'static [Key],
}

/// One key.
#[derive(Debug)]
pub(crate) struct Key {
    pub(crate) name: &'static str,
    pub(crate) kind: Kind,
    pub(crate) default: Default,
    /// A sentence of Markdown, without a period.
    pub(crate) meaning: &'static str,
}

/// The value of a key that the file leaves out.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Default {
    /// The key must be there.
    Required,
    Number(f64),
    Integer(usize),
    Boolean(bool),
    Text(&'static str),
    /// The default depends on other keys, or there is none: a phrase of Markdown.
    Prose(&'static str),
}

/// Which values a key takes.
#[derive(Debug)]
pub(crate) enum Kind {
    /// The name of a tag.
    Name,
    Text(&'static TextRule),
    /// An address and port, or a list of up to this number.
    Addresses(usize),
    /// An address and port such as this one, or `off`.
    AddressOrOff(&'static str),
    /// The mnemonic of an instruction.
    Mnemonic,
    /// The type of a tag, or of a member of a structure.
    TagType,
    MemberType,
    /// One of these words, case ignored.
    Word(&'static [&'static str]),
    Boolean,
    /// A number and its unit.
    Number(Range, &'static str),
    /// A whole number and its unit.
    Integer(RangeInclusive<usize>, &'static str),
    /// A whole number in the range, or 0, and its unit.
    ZeroOr(RangeInclusive<usize>, &'static str),
    /// A list of names; its possible lengths and the name of such a list. Other keys may narrow it.
    Names(RangeInclusive<usize>, &'static str),
    /// A list of numbers, likewise.
    Numbers(RangeInclusive<usize>, &'static str),
    Table(&'static Keys),
    /// At most this number of tables.
    Tables(&'static Keys, usize),
    /// A value of a tag: its type decides.
    Any,
}

/// Which numbers a key takes; all of them are finite.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Range {
    Any,
    Above(f64),
    From(f64),
    Within(f64, f64),
    /// Above the first, up to the second.
    AboveTo(f64, f64),
}

/// The texts that a key takes.
#[derive(Debug)]
pub(crate) struct TextRule {
    pub(crate) expected: &'static str,
    pub(crate) holds: fn(&str) -> bool,
    /// The rule as a regular expression of JSON Schema, where there is one.
    pub(crate) pattern: &'static str,
}

impl TextRule {
    /// Any text; whether it means something is seen later.
    const fn any(expected: &'static str) -> Self {
        Self {
            expected,
            holds: |_| true,
            pattern: "",
        }
    }
}

impl Keys {
    pub(crate) fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    pub(crate) fn names(&self) -> Vec<&'static str> {
        self.keys.iter().map(|key| key.name).collect()
    }
}

impl Range {
    pub(crate) fn holds(self, number: f64) -> bool {
        number.is_finite()
            && match self {
                Self::Any => true,
                Self::Above(least) => number > least,
                Self::From(least) => number >= least,
                Self::Within(least, most) => (least..=most).contains(&number),
                Self::AboveTo(least, most) => number > least && number <= most,
            }
    }
}

impl Kind {
    /// The expected value of the kind, for messages.
    pub(crate) fn expected(&self) -> Cow<'static, str> {
        let with = |text: String, unit: &str| match unit {
            "" => text,
            unit => format!("{text} ({unit})"),
        };
        let whole = |range: &RangeInclusive<usize>| format!("a whole number from {} to {}", range.start(), range.end());
        Cow::Owned(match self {
            Self::Name => return NAME.into(),
            Self::Text(rule) => return rule.expected.into(),
            Self::Addresses(most) => {
                format!("an address and port such as \"127.0.0.1:44818\", or a list of up to {most}")
            }
            Self::AddressOrOff(such) => format!("an address and port such as \"{such}\", or \"off\""),
            Self::Mnemonic => return "the mnemonic of a motion instruction such as \"MCLM\"".into(),
            Self::TagType => tag_types(),
            Self::MemberType => member_types(),
            Self::Word(words) => alternatives(words),
            Self::Boolean => return "true or false".into(),
            Self::Number(range, unit) => {
                let text = match range {
                    Range::Any => "a finite number".to_owned(),
                    Range::Above(least) => format!("a number above {least}"),
                    Range::From(least) => format!("a number, {least} or more"),
                    Range::Within(least, most) => format!("a number from {least} to {most}"),
                    Range::AboveTo(least, most) => format!("a number above {least}, at most {most}"),
                };
                with(text, unit)
            }
            Self::Integer(range, unit) => with(whole(range), unit),
            Self::ZeroOr(range, unit) => with(format!("0, or {}", whole(range)), unit),
            Self::Names(_, expected) | Self::Numbers(_, expected) => return (*expected).into(),
            Self::Table(keys) | Self::Tables(keys, _) => return keys.expected.into(),
            Self::Any => return "a value".into(),
        })
    }

    /// Whether a text is of the kind.
    pub(crate) fn takes_text(&self, text: &str) -> bool {
        match self {
            Self::Name => is_name(text),
            Self::Text(rule) => (rule.holds)(text),
            Self::Addresses(_) => text.parse::<SocketAddr>().is_ok(),
            Self::AddressOrOff(_) => text.eq_ignore_ascii_case("off") || text.parse::<SocketAddr>().is_ok(),
            Self::Word(words) => words.iter().any(|word| word.eq_ignore_ascii_case(text)),
            _ => true,
        }
    }
}

/// `"a", "b" or "c"`.
fn alternatives(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("{word:?}")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

pub(crate) const NAME: &str = "a name: 1 to 40 letters, digits and underscores, no digit first";
/// A list of networks.
pub(crate) const NETWORKS: &str = "a list of 1 to 64 networks such as \"10.1.2.0/24\"";
/// [`NAME`] as a regular expression.
pub(crate) const NAME_PATTERN: &str = "^[A-Za-z_][A-Za-z0-9_]{0,39}$";
