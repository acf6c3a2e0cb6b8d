//! Reading one table of the file, with the place of everything at hand. Knows TOML and kinds of keys, not machines.
//!
//! [`Section::check`] reports all errors of the keys and values of a table and of the tables in it. A key with a reported error reads
//! like an absent key afterwards, so that reading goes on and finds the other errors.

use std::borrow::Cow;
use std::cell::RefCell;
use std::net::SocketAddr;
use std::ops::Range;

use arcline_tag::nearest;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{ConfigError, Problem};
use crate::keys::{Default, Key, Keys, Kind};
use crate::words::Words;

/// The file, which turns offsets into lines, and the errors found in it.
#[derive(Clone, Copy)]
pub(crate) struct Source<'t> {
    pub(crate) file: &'t str,
    pub(crate) text: &'t str,
    /// The offsets of all ends of lines of the text.
    pub(crate) line_ends: &'t [usize],
    pub(crate) errors: &'t RefCell<Vec<ConfigError>>,
}

impl Source<'_> {
    pub(crate) fn report(&self, offset: usize, key: impl Into<String>, problem: Problem) {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        self.errors.borrow_mut().push(ConfigError {
            file: self.file.to_owned(),
            line: self.line(offset),
            column: before[line_start..].chars().count() + 1,
            key: key.into(),
            problem: Box::new(problem),
        });
    }

    pub(crate) fn line(&self, offset: usize) -> usize {
        self.line_ends.partition_point(|end| *end < offset) + 1
    }

    /// The text of a value as it stands in the file, shortened when it is long.
    fn excerpt(&self, span: Range<usize>) -> String {
        const LONGEST: usize = 60;
        let text = self.text.get(span).unwrap_or_default();
        let line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if line.chars().count() > LONGEST {
            line.chars().take(LONGEST).chain(['…']).collect()
        } else {
            line
        }
    }
}

/// A value and where it stands.
#[derive(Clone)]
pub(crate) struct Placed<T> {
    pub(crate) value: T,
    pub(crate) offset: usize,
    pub(crate) key: String,
}

/// One table, its path in the file (`axis[2]`), and where it stands.
pub(crate) struct Section<'t> {
    pub(crate) source: Source<'t>,
    pub(crate) path: String,
    pub(crate) offset: usize,
    keys: &'static Keys,
    table: Option<&'t DeTable<'t>>,
}

impl<'t> Section<'t> {
    /// The whole file.
    pub(crate) fn root(source: Source<'t>, table: &'t DeTable<'t>, keys: &'static Keys) -> Self {
        Self {
            source,
            path: String::new(),
            offset: 0,
            keys,
            table: Some(table),
        }
    }

    /// Reports unknown keys, missing ones, and values of the wrong kind, here and in the tables within.
    pub(crate) fn check(&self) {
        self.check_names();
        for key in self.keys.keys {
            match self.find(key.name) {
                Some(value) => self.check_value(key, value),
                None if key.default == Default::Required => self.missing(key.name),
                None => {}
            }
        }
    }

    fn check_names(&self) {
        for name in self.table.into_iter().flat_map(DeTable::keys) {
            if self.keys.key(name.get_ref()).is_some() {
                continue;
            }
            let known = self.keys.names();
            let suggestion = nearest(name.get_ref(), known.iter().copied());
            let problem = Problem::UnknownKey { suggestion, known };
            self.source
                .report(name.span().start, self.path_of(name.get_ref()), problem);
        }
    }

    fn check_value(&self, key: &'static Key, value: &'t Spanned<DeValue<'t>>) {
        match (&key.kind, value.get_ref()) {
            (Kind::Table(keys), DeValue::Table(table)) => {
                self.within(key, keys, value.span().start, Some(table)).check();
            }
            (Kind::Tables(_, limit), DeValue::Array(items)) => {
                if items.is_empty() && key.default == Default::Required {
                    self.missing(key.name);
                }
                if let Some(first_too_many) = items.get(*limit) {
                    let problem = Problem::TooMany {
                        count: items.len(),
                        limit: *limit,
                    };
                    self.source
                        .report(first_too_many.span().start, self.path_of(key.name), problem);
                    return;
                }
                for item in items.iter().filter(|item| item.get_ref().as_table().is_none()) {
                    self.wrong(&key.kind, self.path_of(key.name), item);
                }
                self.tables(key.name).iter().for_each(Section::check);
            }
            (Kind::Names(..), DeValue::Array(items)) => {
                for (item, place) in items.iter().zip(1..) {
                    if item.get_ref().as_str().is_none() {
                        self.wrong(&key.kind, format!("{}[{place}]", self.path_of(key.name)), item);
                    }
                }
            }
            (Kind::Addresses(most), DeValue::Array(items)) if (1..=*most).contains(&items.len()) => {
                for (item, place) in items.iter().zip(1..) {
                    self.check_text(&key.kind, format!("{}[{place}]", self.path_of(key.name)), item);
                }
            }
            (Kind::Word(words), DeValue::String(text)) if !key.kind.takes_text(text) => {
                let suggestion = nearest(text, words.iter().copied());
                self.refuse_as(&self.placed(key.name, value, text), key.kind.expected(), suggestion);
            }
            (kind, DeValue::String(_)) if kind.is_text() => self.check_text(kind, self.path_of(key.name), value),
            (Kind::Word(_), DeValue::String(_)) => {}
            (kind, other) if holds(kind, other) => {}
            (kind, _) => self.wrong(kind, self.path_of(key.name), value),
        }
    }

    /// The table under `key`; an absent one reads like an empty one.
    pub(crate) fn table(&self, key: &'static str) -> (Self, bool) {
        let keys = match self.kind(key) {
            Some(Kind::Table(keys)) => keys,
            _ => self.keys,
        };
        let value = self.find(key);
        let table = value.and_then(|value| value.get_ref().as_table());
        let offset = match (value, table) {
            (Some(value), Some(_)) => value.span().start,
            _ => self.offset,
        };
        let path = self.path_of(key);
        let section = Self {
            source: self.source,
            path,
            offset,
            keys,
            table,
        };
        (section, table.is_some())
    }

    fn within(
        &self,
        key: &'static Key,
        keys: &'static Keys,
        offset: usize,
        table: Option<&'t DeTable<'t>>,
    ) -> Section<'t> {
        Section {
            source: self.source,
            path: self.path_of(key.name),
            offset,
            keys,
            table,
        }
    }

    /// The tables under `[[key]]`, at most as many as there can be.
    pub(crate) fn tables(&self, key: &'static str) -> Vec<Self> {
        let Some(Kind::Tables(keys, limit)) = self.kind(key) else {
            return Vec::new();
        };
        let items = self.find(key).and_then(|value| value.get_ref().as_array());
        let items = items.into_iter().flat_map(|items| items.iter()).take(*limit);
        let tables = items.zip(1..).filter_map(|(item, place)| {
            Some(Self {
                source: self.source,
                path: format!("{}[{place}]", self.path_of(key)),
                offset: item.span().start,
                keys,
                table: Some(item.get_ref().as_table()?),
            })
        });
        tables.collect()
    }

    /// The text that stands under a key.
    pub(crate) fn text(&self, key: &'static str) -> Option<Placed<String>> {
        let value = self.find(key)?;
        let text = value.get_ref().as_str()?;
        let takes = self.kind(key).is_some_and(|kind| kind.takes_text(text));
        takes.then(|| self.placed(key, value, text))
    }

    /// The text that stands under a key, or its default.
    pub(crate) fn text_or_default(&self, key: &'static str) -> String {
        match (self.text(key), self.default(key)) {
            (Some(text), _) => text.value,
            (None, Some(Default::Text(text))) => text.to_owned(),
            _ => String::new(),
        }
    }

    /// The address that is the default of a key.
    pub(crate) fn default_address(&self, key: &str) -> Option<SocketAddr> {
        match self.default(key) {
            Some(Default::Text(text)) => text.parse().ok(),
            _ => None,
        }
    }

    /// A list of texts, or a single one; absent: none.
    pub(crate) fn texts(&self, key: &'static str) -> Vec<Placed<String>> {
        let Some(kind) = self.kind(key) else { return Vec::new() };
        match self.find(key).map(Spanned::get_ref) {
            Some(DeValue::Array(items)) => {
                let texts = items.iter().zip(1..).filter_map(|(item, place)| {
                    let text = item.get_ref().as_str().filter(|text| kind.takes_text(text))?;
                    Some(Placed {
                        value: text.to_owned(),
                        offset: item.span().start,
                        key: format!("{}[{place}]", self.path_of(key)),
                    })
                });
                texts.collect()
            }
            _ => self.text(key).into_iter().collect(),
        }
    }

    /// The number of values in a list; 0 when there is none.
    pub(crate) fn count(&self, key: &str) -> usize {
        let items = self.find(key).and_then(|value| value.get_ref().as_array());
        items.map_or(0, |items| items.len())
    }

    /// One of the words of a key as the table of keys spells it, or its default.
    pub(crate) fn word(&self, key: &'static str) -> Option<&'static str> {
        let Some(Kind::Word(words)) = self.kind(key) else {
            return None;
        };
        let given = self.find(key).and_then(|value| value.get_ref().as_str());
        let word = given.and_then(|given| words.iter().find(|word| word.eq_ignore_ascii_case(given)));
        word.copied().or(match self.default(key) {
            Some(Default::Text(word)) => Some(word),
            _ => None,
        })
    }

    /// The number that stands under a key, or its default; whole numbers are numbers too.
    pub(crate) fn number(&self, key: &'static str) -> Option<f64> {
        let Some(Kind::Number(range, _)) = self.kind(key) else {
            return None;
        };
        let given = self.find(key).and_then(|value| number(value.get_ref()));
        given.filter(|number| range.holds(*number)).or(match self.default(key) {
            Some(Default::Number(number)) => Some(number),
            _ => None,
        })
    }

    /// A number that is there: a required one, or one with a default. 1 stands for a missing one, which is reported.
    pub(crate) fn required(&self, key: &'static str) -> f64 {
        self.number(key).unwrap_or(1.0)
    }

    /// The meaning of the word of a key, or its default. A missing key, which is reported, has the meaning of the first word.
    pub(crate) fn one_of<T: Copy>(&self, key: &'static str, words: Words<T>) -> T {
        let word = self.word(key);
        let given = words.iter().find(|(known, _)| Some(*known) == word);
        let (_, meaning) = given.or(words.first()).expect("a key has words");
        *meaning
    }

    /// A whole number that is there, of a type that holds all that the key takes. 0 stands for a missing one, which is reported.
    pub(crate) fn whole<T: TryFrom<usize> + std::default::Default>(&self, key: &'static str) -> T {
        let number = self.integer(key).map(T::try_from);
        number.and_then(Result::ok).unwrap_or_default()
    }

    /// `true` or `false`, with a default.
    pub(crate) fn flag(&self, key: &'static str) -> bool {
        self.boolean(key) == Some(true)
    }

    /// The address that stands under a key, or its default; `None`: `off`.
    pub(crate) fn address(&self, key: &'static str) -> Option<SocketAddr> {
        self.text_or_default(key).parse().ok()
    }

    /// A list of as many numbers as there is room for; an absent one leaves them as they are.
    pub(crate) fn numbers(&self, key: &'static str, expected: &'static str, room: &mut [f64]) {
        let Some(kind) = self.kind(key) else { return };
        let given = self.find(key).map(Spanned::get_ref).filter(|value| holds(kind, value));
        let Some(items) = given.and_then(DeValue::as_array) else {
            return;
        };
        if items.len() != room.len() {
            return self.refuse_value(key, expected);
        }
        for (room, item) in room.iter_mut().zip(items.iter()) {
            *room = number(item.get_ref()).unwrap_or_default();
        }
    }

    /// The whole number that stands under a key, or its default.
    pub(crate) fn integer(&self, key: &'static str) -> Option<usize> {
        let kind = self.kind(key)?;
        let given = self.find(key).map(Spanned::get_ref).filter(|value| holds(kind, value));
        given.and_then(whole).or(match self.default(key) {
            Some(Default::Integer(number)) => Some(number),
            _ => None,
        })
    }

    /// A value of any type.
    pub(crate) fn value(&self, key: &str) -> Option<&'t DeValue<'t>> {
        self.find(key).map(Spanned::get_ref)
    }

    /// `true` or `false`.
    pub(crate) fn boolean(&self, key: &'static str) -> Option<bool> {
        let given = self.find(key).and_then(|value| value.get_ref().as_bool());
        given.or(match self.default(key) {
            Some(Default::Boolean(flag)) => Some(flag),
            _ => None,
        })
    }

    /// Whether the file has the key.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.find(key).is_some()
    }

    /// Reports a key that must be there, at the table's place.
    pub(crate) fn missing(&self, key: &str) {
        let expected = self.kind(key).map_or(Cow::Borrowed(""), Kind::expected);
        let problem = Problem::Missing { expected };
        self.source.report(self.offset, self.path_of(key), problem);
    }

    /// Reports a text that is not of the key's kind.
    pub(crate) fn refuse(&self, key: &str, text: &Placed<String>, suggestion: Option<String>) {
        let expected = self.kind(key).map_or(Cow::Borrowed(""), Kind::expected);
        self.refuse_as(text, expected, suggestion);
    }

    /// Reports a text that was read but does not do.
    pub(crate) fn refuse_as(
        &self,
        text: &Placed<String>,
        expected: impl Into<Cow<'static, str>>,
        suggestion: Option<String>,
    ) {
        let problem = Problem::Value {
            found: format!("{:?}", text.value.chars().take(60).collect::<String>()),
            expected: expected.into(),
            suggestion,
        };
        self.source.report(text.offset, text.key.clone(), problem);
    }

    /// Reports a key that is there but has a value that does not do.
    pub(crate) fn refuse_value(&self, key: &str, expected: impl Into<Cow<'static, str>>) {
        let value = self.find(key);
        let problem = Problem::Value {
            found: value.map_or_else(String::new, |value| self.source.excerpt(value.span())),
            expected: expected.into(),
            suggestion: None,
        };
        self.refuse_key(key, problem);
    }

    /// Reports a key that cannot stand with another.
    pub(crate) fn conflict(&self, key: &str, other: &'static str, reason: &'static str) {
        self.refuse_key(key, Problem::Conflict { other, reason });
    }

    /// Reports a problem of a key.
    pub(crate) fn refuse_key(&self, key: &str, problem: Problem) {
        let offset = self.find(key).map_or(self.offset, |value| value.span().start);
        self.source.report(offset, self.path_of(key), problem);
    }

    fn find(&self, key: &str) -> Option<&'t Spanned<DeValue<'t>>> {
        self.table?.get(key)
    }

    fn kind(&self, key: &str) -> Option<&'static Kind> {
        self.keys.key(key).map(|key| &key.kind)
    }

    fn default(&self, key: &str) -> Option<Default> {
        self.keys.key(key).map(|key| key.default)
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.path)
        }
    }

    fn placed(&self, key: &str, value: &Spanned<DeValue<'_>>, text: &str) -> Placed<String> {
        Placed {
            value: text.to_owned(),
            offset: value.span().start,
            key: self.path_of(key),
        }
    }

    fn check_text(&self, kind: &Kind, path: String, value: &Spanned<DeValue<'_>>) {
        let Some(text) = value.get_ref().as_str() else {
            return self.wrong(kind, path, value);
        };
        if !kind.takes_text(text) {
            let text = Placed {
                value: text.to_owned(),
                offset: value.span().start,
                key: path,
            };
            self.refuse_as(&text, kind.expected(), None);
        }
    }

    fn wrong(&self, kind: &Kind, path: String, value: &Spanned<DeValue<'_>>) {
        let problem = Problem::Value {
            found: self.source.excerpt(value.span()),
            expected: kind.expected(),
            suggestion: None,
        };
        self.source.report(value.span().start, path, problem);
    }
}

impl Kind {
    /// Whether values of the kind are texts.
    fn is_text(&self) -> bool {
        use Kind::{AddressOrOff, Addresses, MemberType, Mnemonic, Name, TagType, Text};
        matches!(
            self,
            Name | Text(_) | Addresses(_) | AddressOrOff(_) | Mnemonic | TagType | MemberType
        )
    }
}

/// Whether a value other than a text or a table is of the kind.
fn holds(kind: &Kind, value: &DeValue<'_>) -> bool {
    match kind {
        Kind::Boolean => value.as_bool().is_some(),
        Kind::Number(range, _) => number(value).is_some_and(|number| range.holds(number)),
        Kind::Integer(range, _) => whole(value).is_some_and(|number| range.contains(&number)),
        Kind::ZeroOr(range, _) => whole(value).is_some_and(|number| number == 0 || range.contains(&number)),
        Kind::Numbers(range, _) => value.as_array().is_some_and(|items| {
            let finite = |item: &Spanned<DeValue<'_>>| number(item.get_ref()).is_some_and(f64::is_finite);
            range.contains(&items.len()) && items.iter().all(finite)
        }),
        Kind::Any => true,
        _ => false,
    }
}

/// A number, whole or not.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .map(|whole| whole as f64),
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    }
}

/// A whole number, 0 or more.
fn whole(value: &DeValue<'_>) -> Option<usize> {
    let DeValue::Integer(integer) = value else { return None };
    usize::from_str_radix(integer.as_str(), integer.radix()).ok()
}
