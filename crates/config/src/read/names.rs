//! Names of tags: their syntax, their uniqueness, and the nearest name for one that does not exist.

use std::collections::BTreeMap;

pub use arcline_controller::image::is_tag_name as is_name;
use arcline_tag::nearest;

use crate::error::Problem;
use crate::section::{Placed, Section};

/// The names in use, in lower case, with the line of each.
#[derive(Default)]
pub(super) struct Taken(BTreeMap<String, usize>);

impl Taken {
    /// Takes a name, and reports one that is taken already.
    pub(super) fn take(&mut self, section: &Section<'_>, name: Placed<String>) -> String {
        let line = section.source.line(name.offset);
        let key = name.value.to_ascii_lowercase();
        if let Some(line) = self.0.get(&key) {
            let problem = Problem::Duplicate {
                name: name.value.clone(),
                line: *line,
            };
            section.source.report(name.offset, name.key, problem);
        } else {
            self.0.insert(key, line);
        }
        name.value
    }

    /// Takes the name under a key; empty when there is none, which is reported already.
    pub(super) fn take_name(&mut self, section: &Section<'_>, key: &'static str) -> String {
        section
            .text(key)
            .map(|name| self.take(section, name))
            .unwrap_or_default()
    }
}

/// Reports a name that nothing has.
pub(super) fn unknown_name<'n>(
    section: &Section<'_>,
    given: &Placed<String>,
    what: &'static str,
    known: impl IntoIterator<Item = &'n str>,
) {
    let suggestion = nearest(&given.value, known);
    let name = given.value.chars().take(60).collect();
    let problem = Problem::UnknownName { what, name, suggestion };
    section.source.report(given.offset, given.key.clone(), problem);
}
