//! The parts that an import left out or changed, by group. They are no errors: the rest is imported.

use std::collections::BTreeMap;
use std::fmt;

/// The reason for which a part of the file is not in the configuration as it is in the file.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Reason {
    /// An element, attribute or value that this version does not know.
    NotUnderstood,
    /// Known, and Arcline has nothing like it.
    NoCounterpart,
    /// Imported as another value, which the words name.
    Changed(&'static str),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::NotUnderstood => f.write_str("not understood"),
            Reason::NoCounterpart => f.write_str("no counterpart in a configuration"),
            Reason::Changed(words) => write!(f, "changed: {words}"),
        }
    }
}

/// Everything with the same reason at the same path.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Group {
    /// The number of such parts.
    pub count: usize,
    /// The first lines, from 1, at most [`Group::LINES`].
    pub lines: Vec<usize>,
    /// The names of tags on these lines, so that a user finds which tags are missing; empty: the parts are no tags.
    pub names: Vec<String>,
}

impl Group {
    /// Highest number of lines in each group.
    pub const LINES: usize = 5;
}

/// The parts that an import left out or changed.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Report {
    groups: BTreeMap<(Reason, String), Group>,
}

impl Report {
    /// Whether the import left out or changed no part.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The number of parts that the import left out or changed.
    pub fn count(&self) -> usize {
        self.groups.values().map(|group| group.count).sum()
    }

    /// The groups by reason and path, such as `Controller/Tags/Tag[TIMER]` or
    /// `Controller/Tags/Tag[AXIS_VIRTUAL]/Data/AxisParameters/@DynamicsConfigurationBits`.
    pub fn groups(&self) -> impl Iterator<Item = (Reason, &str, &Group)> {
        let groups = self.groups.iter();
        groups.map(|((reason, path), group)| (*reason, path.as_str(), group))
    }

    /// `tag`: the name, where the part is a tag.
    pub(crate) fn add(&mut self, reason: Reason, path: String, line: usize, tag: Option<&str>) {
        let group = self.groups.entry((reason, path)).or_default();
        group.count += 1;
        if group.lines.len() < Group::LINES && group.lines.last() != Some(&line) {
            group.lines.push(line);
            group.names.extend(tag.map(str::to_owned));
        }
    }
}

/// A line a group, under a heading a reason.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut heading = None;
        for (reason, path, group) in self.groups() {
            if heading != Some(reason) {
                let of_reason = self.groups().filter(|(other, _, _)| *other == reason);
                let count: usize = of_reason.map(|(_, _, group)| group.count).sum();
                writeln!(f, "{reason} ({count}):")?;
                heading = Some(reason);
            }
            let lines: Vec<String> = group.lines.iter().map(usize::to_string).collect();
            let more = if group.count > group.lines.len() { ", …" } else { "" };
            let word = if group.count == 1 { "line" } else { "lines" };
            let names = match group.names.as_slice() {
                [] => String::new(),
                names => format!(" ({}{more})", names.join(", ")),
            };
            writeln!(
                f,
                "  {} × {path}{names}, {word} {}{more}",
                group.count,
                lines.join(", ")
            )?;
        }
        Ok(())
    }
}
