//! Plain tags and aliases, of the controller's scope and of programs.

use std::collections::BTreeMap;

use arcline_config::{MAX_ELEMENTS, MAX_SIZE, MAX_TAGS, is_name};
use roxmltree::Node;
use toml::{Table, Value};

use super::Importer;
use super::motion::is_motion;
use super::types::Types;
use crate::document::{children, is_named_only};
use crate::{L5xError, Reason};

/// A `Tags` element and the program it belongs to.
pub(super) type Scope<'a, 't> = (Option<&'a str>, Node<'a, 't>);

/// An alias: its program, and the path of its base.
struct Alias<'a> {
    program: Option<&'a str>,
    path: &'a str,
}

impl<'a, 't> Importer<'a, 't> {
    pub(super) fn tags(&mut self, scopes: &[Scope<'a, 't>], types: &Types) -> Result<(), L5xError> {
        // Every name first, the bases with whether they are in the configuration: an alias may stand above its base,
        // and the base may be an alias, an axis, a module or a tag.
        let mut aliases: BTreeMap<String, Alias<'a>> = BTreeMap::new();
        let mut bases: BTreeMap<String, bool> = BTreeMap::new();
        for (program, list) in scopes {
            for node in children(*list, "Tag") {
                let name = self.source.required(node, "Name", "the tag's name")?;
                if program.is_none() {
                    self.controller_names.insert(name.to_ascii_lowercase());
                }
                if node.attribute("TagType") != Some("Alias") {
                    bases.insert(full_name(*program, name), false);
                    continue;
                }
                let path = self
                    .source
                    .required(node, "AliasFor", "the tag that the alias stands for")?;
                let program = *program;
                aliases.insert(full_name(program, name), Alias { program, path });
            }
        }
        let mut late = Vec::new();
        for (program, list) in scopes {
            for node in children(*list, "Tag") {
                let name = self.source.required(node, "Name", "the tag's name")?;
                let program_fits = program.is_none_or(is_name);
                if node.attribute("TagType") == Some("Alias") {
                    self.source.check(node);
                    if !self.alias(node, *program, name, &aliases, &bases) {
                        late.push((node, *program, name));
                    }
                } else if !is_motion(node) {
                    self.source.check(node);
                    if !program_fits || !is_name(name) || !self.plain(node, *program, name, types)? {
                        self.source.report(node, Reason::NoCounterpart);
                        continue;
                    }
                    bases.insert(full_name(*program, name), true);
                }
            }
        }
        // Aliases whose tag comes later in the file.
        for (node, program, name) in late {
            if !self.alias(node, program, name, &aliases, &bases) {
                self.source.report(node, Reason::NoCounterpart);
            }
        }
        Ok(())
    }

    /// Adds a plain tag; `false`: it is none that Arcline has.
    fn plain(
        &mut self,
        node: Node<'a, 't>,
        program: Option<&str>,
        name: &str,
        types: &Types,
    ) -> Result<bool, L5xError> {
        if is_named_only(node, "DataType") {
            return Ok(false);
        }
        let word = self.source.required(node, "DataType", "the tag's type")?;
        if word.eq_ignore_ascii_case(CONTROL) {
            return Ok(self.control(node, program, name));
        }
        let mut dimensions = Vec::new();
        for count in node
            .attribute("Dimensions")
            .unwrap_or_default()
            .split([',', ' '])
            .filter(|word| !word.is_empty())
        {
            match count.parse() {
                Ok(count) if (1..=MAX_LENGTH).contains(&count) && dimensions.len() < 3 => dimensions.push(count),
                _ => {
                    return Err(self.source.wrong(
                        node,
                        "Dimensions",
                        "up to three whole numbers from 1 to 2147483647",
                    ));
                }
            }
        }
        let Some(kind) = types.kind(word) else {
            return Ok(false);
        };
        let is_bool = word.eq_ignore_ascii_case("BOOL");
        // A configuration has shorter arrays than a controller.
        let is_long = dimensions.iter().any(|count| *count > MAX_ELEMENTS);
        let too_many = is_long || (is_bool && dimensions.len() > 1) || self.count("tag") >= MAX_TAGS;
        if too_many
            || types.size(&kind, &dimensions) > MAX_SIZE as u64
            || node.attribute("ExternalAccess") == Some("None")
        {
            return Ok(false);
        }
        let mut entry = named(program, name);
        entry.insert("type".into(), Value::String(types.word(&kind, &dimensions)));
        if let Some(words) = match node.attribute("TagType") {
            Some("Produced") => Some("a produced tag becomes a plain one"),
            Some("Consumed") => Some("a consumed tag becomes a plain one"),
            _ => None,
        } {
            self.source.report_attribute(node, "TagType", Reason::Changed(words));
        }
        self.access(node, &mut entry);
        if let Some(value) = self.first_value(node, types, &kind, &dimensions)? {
            entry.insert("value".into(), value);
        }
        self.push("tag", node, entry);
        Ok(true)
    }

    /// Adds a motion control tag, always of the controller's scope; `false`: an array of them, or another tag has its name.
    fn control(&mut self, node: Node<'a, 't>, program: Option<&str>, name: &str) -> bool {
        let is_array = node.attribute("Dimensions").is_some_and(|count| count != "0");
        let taken = program.is_some() && self.controller_names.contains(&name.to_ascii_lowercase());
        if is_array || taken || self.count("tag") >= MAX_TAGS || node.attribute("ExternalAccess") == Some("None") {
            return false;
        }
        if program.is_some() {
            self.controller_names.insert(name.to_ascii_lowercase());
            let words = "a motion control tag of a program becomes one of the controller";
            self.source.report(node, Reason::Changed(words));
        }
        let mut entry = named(None, name);
        entry.insert("type".into(), Value::String(CONTROL.to_owned()));
        self.push("tag", node, entry);
        true
    }

    fn access(&mut self, node: Node<'a, 't>, entry: &mut Table) {
        let constant = node.attribute("Constant") == Some("true");
        match node.attribute("ExternalAccess") {
            Some("Read Only") => {}
            Some("Read/Write") | None if constant => {}
            Some("Read/Write") | None => return,
            Some(_) => {
                self.source
                    .report_attribute(node, "ExternalAccess", Reason::NotUnderstood);
                return;
            }
        }
        entry.insert("access".into(), Value::String("read_only".into()));
    }

    /// Adds an alias whose tag exists already; an alias of an alias becomes an alias of its base.
    fn alias(
        &mut self,
        node: Node<'a, 't>,
        program: Option<&str>,
        name: &str,
        aliases: &BTreeMap<String, Alias<'a>>,
        bases: &BTreeMap<String, bool>,
    ) -> bool {
        let allowed = is_name(name) && program.is_none_or(is_name) && node.attribute("ExternalAccess") != Some("None");
        let mut scope = program;
        let mut path = node.attribute("AliasFor").unwrap_or_default().to_owned();
        for _ in 0..MAX_CHAIN {
            let (given, rest) = match path.strip_prefix("Program:").and_then(|path| path.split_once('.')) {
                Some((given, rest)) => (Some(given.to_owned()), rest.to_owned()),
                None => (None, path.clone()),
            };
            let end = rest.find(['.', '[']).unwrap_or(rest.len());
            let (first, behind) = rest.split_at(end);
            // A program sees its own tags first, then the controller's.
            let seen = match &given {
                Some(given) => vec![Some(given.as_str())],
                None if scope.is_some() => vec![scope, None],
                None => vec![None],
            };
            let known = |scope: &&Option<&str>| {
                let full = full_name(**scope, first);
                bases.contains_key(&full) || aliases.contains_key(&full)
            };
            let Some(found) = seen.iter().find(known).copied() else {
                return false;
            };
            let full = full_name(found, first);
            if let Some(alias) = aliases.get(&full).filter(|_| !bases.contains_key(&full)) {
                scope = alias.program;
                path = format!("{}{behind}", alias.path);
                if path.len() > MAX_PATH {
                    return false;
                }
                continue;
            }
            let is_there = bases.get(&full).copied().unwrap_or(false);
            if !is_there || !allowed || self.count("tag") >= MAX_TAGS {
                return false;
            }
            let path = match found {
                Some(program) => format!("Program:{program}.{rest}"),
                None => rest,
            };
            let mut entry = named(program, name);
            entry.insert("alias".into(), Value::String(path));
            self.access(node, &mut entry);
            self.push("tag", node, entry);
            return true;
        }
        false
    }
}

fn named(program: Option<&str>, name: &str) -> Table {
    let pairs = [("name", Some(name)), ("program", program)];
    let pairs = pairs
        .into_iter()
        .filter_map(|(key, word)| Some((key.to_owned(), Value::String(word?.to_owned()))));
    pairs.collect()
}

/// A tag's name with its program, in lower case.
fn full_name(program: Option<&str>, name: &str) -> String {
    match program {
        Some(program) => format!("program:{program}.{name}").to_ascii_lowercase(),
        None => name.to_ascii_lowercase(),
    }
}

/// The type of motion control tags.
const CONTROL: &str = "MOTION_INSTRUCTION";
/// Most elements of a dimension in a file.
const MAX_LENGTH: u32 = i32::MAX as u32;
/// Aliases of aliases that are followed.
const MAX_CHAIN: usize = 16;
/// Longest path of an alias, bytes.
const MAX_PATH: usize = 255;
