//! Reading one table of the file, with the place of everything at hand. Knows TOML, not machines.

use std::ops::{Range, RangeInclusive};

use arcline_tag::nearest;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{ConfigError, Problem};

/// The file, for turning offsets into lines.
#[derive(Clone, Copy)]
pub(crate) struct Source<'t> {
    pub(crate) file: &'t str,
    pub(crate) text: &'t str,
}

impl Source<'_> {
    pub(crate) fn error(&self, offset: usize, key: impl Into<String>, problem: Problem) -> ConfigError {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        ConfigError {
            file: self.file.to_owned(),
            line: self.line(offset),
            column: before[line_start..].chars().count() + 1,
            key: key.into(),
            problem: Box::new(problem),
        }
    }

    pub(crate) fn line(&self, offset: usize) -> usize {
        self.text
            .as_bytes()
            .iter()
            .take(offset)
            .filter(|byte| **byte == b'\n')
            .count()
            + 1
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

/// Which numbers a key takes: the test and the words that name it.
pub(crate) struct NumberRule {
    pub(crate) expected: &'static str,
    pub(crate) holds: fn(f64) -> bool,
}

/// One table, its path in the file (`axis[2]`), and where it stands.
pub(crate) struct Section<'t> {
    pub(crate) source: Source<'t>,
    pub(crate) path: String,
    pub(crate) offset: usize,
    table: Option<&'t DeTable<'t>>,
}

impl<'t> Section<'t> {
    /// The whole file.
    pub(crate) fn root(
        source: Source<'t>,
        table: &'t DeTable<'t>,
        known: &'static [&'static str],
    ) -> Result<Self, ConfigError> {
        let section = Self {
            source,
            path: String::new(),
            offset: 0,
            table: Some(table),
        };
        section.refuse_unknown_keys(known)?;
        Ok(section)
    }

    /// The table under `key`; an absent one reads like an empty one.
    pub(crate) fn table(
        &self,
        key: &'static str,
        known: &'static [&'static str],
        expected: &'static str,
    ) -> Result<(Self, bool), ConfigError> {
        let mut section = Self {
            source: self.source,
            path: self.key(key),
            offset: self.offset,
            table: None,
        };
        let Some(value) = self.find(key) else {
            return Ok((section, false));
        };
        let DeValue::Table(table) = value.get_ref() else {
            return Err(self.wrong(key, value, expected));
        };
        section.offset = value.span().start;
        section.table = Some(table);
        section.refuse_unknown_keys(known)?;
        Ok((section, true))
    }

    /// The tables under `[[key]]`.
    pub(crate) fn tables(
        &self,
        key: &'static str,
        known: &'static [&'static str],
        expected: &'static str,
        limit: usize,
    ) -> Result<Vec<Self>, ConfigError> {
        let Some(value) = self.find(key) else {
            return Ok(Vec::new());
        };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong(key, value, expected));
        };
        if let Some(first_too_many) = items.get(limit) {
            let problem = Problem::TooMany {
                count: items.len(),
                limit,
            };
            return Err(self.source.error(first_too_many.span().start, self.key(key), problem));
        }
        let mut sections = Vec::with_capacity(items.len());
        for (place, item) in items.iter().enumerate() {
            let DeValue::Table(table) = item.get_ref() else {
                return Err(self.wrong(key, item, expected));
            };
            let section = Self {
                source: self.source,
                path: format!("{}[{}]", self.key(key), place + 1),
                offset: item.span().start,
                table: Some(table),
            };
            section.refuse_unknown_keys(known)?;
            sections.push(section);
        }
        Ok(sections)
    }

    /// A string.
    pub(crate) fn string(
        &self,
        key: &'static str,
        expected: &'static str,
    ) -> Result<Option<Placed<String>>, ConfigError> {
        let Some(value) = self.find(key) else {
            return Ok(None);
        };
        let DeValue::String(text) = value.get_ref() else {
            return Err(self.wrong(key, value, expected));
        };
        Ok(Some(Placed {
            value: text.to_string(),
            offset: value.span().start,
            key: self.key(key),
        }))
    }

    /// A list of strings.
    pub(crate) fn strings(
        &self,
        key: &'static str,
        expected: &'static str,
        count: RangeInclusive<usize>,
    ) -> Result<Vec<Placed<String>>, ConfigError> {
        let Some(value) = self.find(key) else {
            return Err(self.missing(key, expected));
        };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong(key, value, expected));
        };
        if !count.contains(&items.len()) {
            return Err(self.wrong(key, value, expected));
        }
        let mut strings = Vec::with_capacity(items.len());
        for (place, item) in items.iter().enumerate() {
            let DeValue::String(text) = item.get_ref() else {
                return Err(self.wrong(key, item, expected));
            };
            strings.push(Placed {
                value: text.to_string(),
                offset: item.span().start,
                key: format!("{}[{}]", self.key(key), place + 1),
            });
        }
        Ok(strings)
    }

    /// A string, or a list of them; absent: none.
    pub(crate) fn one_or_more(
        &self,
        key: &'static str,
        expected: &'static str,
        count: RangeInclusive<usize>,
    ) -> Result<Vec<Placed<String>>, ConfigError> {
        match self.find(key).map(Spanned::get_ref) {
            None => Ok(Vec::new()),
            Some(DeValue::Array(_)) => self.strings(key, expected, count),
            Some(_) => Ok(self.string(key, expected)?.into_iter().collect()),
        }
    }

    /// One of some words, case ignored: its place among them.
    pub(crate) fn word(
        &self,
        key: &'static str,
        words: &[&str],
        expected: &'static str,
    ) -> Result<Option<usize>, ConfigError> {
        let Some(text) = self.string(key, expected)? else {
            return Ok(None);
        };
        match words.iter().position(|word| word.eq_ignore_ascii_case(&text.value)) {
            Some(place) => Ok(Some(place)),
            None => {
                let suggestion = nearest(&text.value, words.iter().copied());
                Err(self.refuse(&text, expected, suggestion))
            }
        }
    }

    /// A finite number that the rule allows; whole numbers are numbers too.
    pub(crate) fn number(&self, key: &'static str, rule: &NumberRule) -> Result<Option<f64>, ConfigError> {
        let Some(value) = self.find(key) else {
            return Ok(None);
        };
        match number(value.get_ref()) {
            Some(number) if number.is_finite() && (rule.holds)(number) => Ok(Some(number)),
            _ => Err(self.wrong(key, value, rule.expected)),
        }
    }

    /// A list of as many finite numbers as there is room for; an absent one leaves them as they are.
    pub(crate) fn numbers(
        &self,
        key: &'static str,
        expected: &'static str,
        room: &mut [f64],
    ) -> Result<(), ConfigError> {
        let Some(value) = self.find(key) else {
            return Ok(());
        };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong(key, value, expected));
        };
        let numbers: Option<Vec<f64>> = items.iter().map(|item| number(item.get_ref())).collect();
        match numbers.filter(|numbers| numbers.len() == room.len() && numbers.iter().all(|one| one.is_finite())) {
            Some(numbers) => {
                room.copy_from_slice(&numbers);
                Ok(())
            }
            None => Err(self.wrong(key, value, expected)),
        }
    }

    /// A number that must be there.
    pub(crate) fn required_number(&self, key: &'static str, rule: &NumberRule) -> Result<f64, ConfigError> {
        self.number(key, rule)?.ok_or_else(|| self.missing(key, rule.expected))
    }

    /// A whole number within a range.
    pub(crate) fn integer(
        &self,
        key: &'static str,
        range: RangeInclusive<usize>,
        expected: &'static str,
    ) -> Result<Option<usize>, ConfigError> {
        let Some(value) = self.find(key) else {
            return Ok(None);
        };
        if let DeValue::Integer(integer) = value.get_ref()
            && let Ok(number) = usize::from_str_radix(integer.as_str(), integer.radix())
            && range.contains(&number)
        {
            return Ok(Some(number));
        }
        Err(self.wrong(key, value, expected))
    }

    /// A value of any type.
    pub(crate) fn value(&self, key: &str) -> Option<&'t DeValue<'t>> {
        self.find(key).map(Spanned::get_ref)
    }

    /// `true` or `false`.
    pub(crate) fn boolean(&self, key: &'static str) -> Result<Option<bool>, ConfigError> {
        let Some(value) = self.find(key) else {
            return Ok(None);
        };
        match value.get_ref() {
            DeValue::Boolean(flag) => Ok(Some(*flag)),
            _ => Err(self.wrong(key, value, "true or false")),
        }
    }

    /// The error of a key that must be there, at the table's place.
    pub(crate) fn missing(&self, key: &str, expected: &'static str) -> ConfigError {
        self.source
            .error(self.offset, self.key(key), Problem::Missing { expected })
    }

    /// The error of a string that was read but does not do.
    pub(crate) fn refuse(
        &self,
        text: &Placed<String>,
        expected: &'static str,
        suggestion: Option<String>,
    ) -> ConfigError {
        let found = format!("{:?}", text.value.chars().take(60).collect::<String>());
        self.source.error(
            text.offset,
            text.key.clone(),
            Problem::Value {
                found,
                expected,
                suggestion,
            },
        )
    }

    /// The error of a key that is there but has a value that does not do.
    pub(crate) fn refuse_key(&self, key: &str, problem: Problem) -> ConfigError {
        let offset = self.find(key).map_or(self.offset, |value| value.span().start);
        self.source.error(offset, self.key(key), problem)
    }

    /// The text of the value under `key` as it stands in the file.
    pub(crate) fn found(&self, key: &str) -> String {
        self.find(key)
            .map(|value| self.source.excerpt(value.span()))
            .unwrap_or_default()
    }

    fn find(&self, key: &str) -> Option<&'t Spanned<DeValue<'t>>> {
        self.table?.get(key)
    }

    fn key(&self, key: &str) -> String {
        if self.path.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.path)
        }
    }

    fn wrong(&self, key: &str, value: &Spanned<DeValue<'_>>, expected: &'static str) -> ConfigError {
        let found = self.source.excerpt(value.span());
        let problem = Problem::Value {
            found,
            expected,
            suggestion: None,
        };
        self.source.error(value.span().start, self.key(key), problem)
    }

    fn refuse_unknown_keys(&self, known: &'static [&'static str]) -> Result<(), ConfigError> {
        let unknown = self.table.into_iter().flat_map(DeTable::keys);
        let unknown = unknown.filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(first) = unknown.min_by_key(|key| key.span().start) else {
            return Ok(());
        };
        let suggestion = nearest(first.get_ref(), known.iter().copied());
        let problem = Problem::UnknownKey { suggestion, known };
        Err(self
            .source
            .error(first.span().start, self.key(first.get_ref()), problem))
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
