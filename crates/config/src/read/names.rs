//! Names of tags: what one may be, that each is there once, and what was probably meant by one that is not there.

use std::collections::BTreeMap;

pub use arcline_controller::image::is_tag_name as is_name;
use arcline_tag::nearest;

use crate::error::{ConfigError, Problem};
use crate::section::{Placed, Section};

/// The names in use, in lower case, with the line of each.
#[derive(Default)]
pub(super) struct Taken(BTreeMap<String, usize>);

impl Taken {
    pub(super) fn take(&mut self, section: &Section<'_>, name: Placed<String>) -> Result<String, ConfigError> {
        if !is_name(&name.value) {
            return Err(section.refuse(&name, NAME, None));
        }
        let line = section.source.line(name.offset);
        match self.0.insert(name.value.to_ascii_lowercase(), line) {
            None => Ok(name.value),
            Some(line) => {
                let problem = Problem::Duplicate { name: name.value, line };
                Err(section.source.error(name.offset, name.key, problem))
            }
        }
    }
}

pub(super) fn required_name(
    section: &Section<'_>,
    key: &'static str,
    names: &mut Taken,
) -> Result<String, ConfigError> {
    let name = section.string(key, NAME)?.ok_or_else(|| section.missing(key, NAME))?;
    names.take(section, name)
}

pub(super) fn unknown_name<'n>(
    section: &Section<'_>,
    given: &Placed<String>,
    what: &'static str,
    known: impl IntoIterator<Item = &'n str>,
) -> ConfigError {
    let suggestion = nearest(&given.value, known);
    let name = given.value.chars().take(60).collect();
    let problem = Problem::UnknownName { what, name, suggestion };
    section.source.error(given.offset, given.key.clone(), problem)
}

pub(super) const NAME: &str = "a name: 1 to 40 letters, digits and underscores, no digit first";
