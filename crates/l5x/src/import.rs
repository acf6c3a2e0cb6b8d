//! From an L5X file to the tables of a configuration.

pub(crate) mod motion;
mod tags;
mod types;
mod values;

use std::collections::{BTreeMap, BTreeSet};

use arcline_config::Project;
use roxmltree::Node;
use toml::{Table, Value};

use self::types::Types;
use crate::document::{Source, children, parse};
use crate::overlay::{self, PROVIDER};
use crate::{L5xError, Problem, Reason, Report};

/// The import of an L5X file.
#[derive(Clone, PartialEq, Debug)]
pub struct Import {
    /// The tables of a configuration; [`arcline_config::format`] makes a file of them.
    pub config: Table,
    /// Their project.
    pub project: Project,
    /// The parts of the file that are not in them.
    pub report: Report,
}

/// Reads the machine of an L5X file that has its own program: the tags are the program's, which [`crate::logic()`] reads.
///
/// # Errors
/// As [`import()`].
pub fn machine(text: &str, file: &str) -> Result<Project, L5xError> {
    let mut project = import(text, file)?.project;
    project.tags.clear();
    Ok(project)
}

/// Reads an L5X file. `file` only names the text in errors. At most [`MAX_TEXT`](crate::MAX_TEXT) bytes are read; a DTD is
/// refused.
///
/// # Errors
/// The first error, with line, column and element, and the expected value. Unknown parts are in the report, and no errors.
pub fn import(text: &str, file: &str) -> Result<Import, L5xError> {
    // A byte order mark, as Windows writes it.
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
    let (source, document) = parse(file, text)?;
    let root = document.root_element();
    if root.tag_name().name() != "RSLogix5000Content" {
        let problem = Problem::Value {
            found: crate::document::shortened(root.tag_name().name()),
            expected: "the element RSLogix5000Content of an L5X file",
        };
        return Err(source.error(root, problem));
    }
    let mut importer = Importer {
        source,
        overlay: Table::new(),
        config: Table::new(),
        places: BTreeMap::new(),
        controller_names: BTreeSet::new(),
    };
    importer.source.check(root);
    let controller = importer.source.controller(root)?;
    importer.controller(controller)?;
    importer.finish(controller)
}

/// The state of an import.
pub(crate) struct Importer<'a, 't> {
    source: Source<'t>,
    overlay: Table,
    config: Table,
    /// The element of each entry of a list: `axis[1]`.
    places: BTreeMap<String, Node<'a, 't>>,
    /// Names of the controller's scope, in lower case.
    controller_names: BTreeSet<String>,
}

impl<'a, 't> Importer<'a, 't> {
    fn controller(&mut self, controller: Node<'a, 't>) -> Result<(), L5xError> {
        self.source.check(controller);
        self.overlay(controller)?;
        if let Some(name) = controller.attribute("Name") {
            let fits: String = name
                .chars()
                .filter(|c| *c == ' ' || c.is_ascii_graphic())
                .take(32)
                .collect();
            let said = self
                .overlay
                .get("server")
                .is_some_and(|server| server.get("name").is_some());
            if fits != name && !said {
                let words = "cut to 32 printable ASCII characters";
                self.source.report_attribute(controller, "Name", Reason::Changed(words));
            }
            if !fits.trim().is_empty() {
                let server = Table::from_iter([("name".to_owned(), Value::String(fits))]);
                self.config.insert("server".into(), Value::Table(server));
            }
        }
        let mut types = Types::new();
        for list in children(controller, "DataTypes") {
            self.source.check(list);
            self.data_types(list, &mut types)?;
        }
        let mut scopes = Vec::new();
        for list in children(controller, "Tags") {
            self.source.check(list);
            scopes.push((None, list));
        }
        for programs in children(controller, "Programs") {
            self.source.check(programs);
            for program in children(programs, "Program") {
                self.source.check(program);
                let name = self.source.required(program, "Name", "the program's name")?;
                for list in children(program, "Tags") {
                    self.source.check(list);
                    scopes.push((Some(name), list));
                }
            }
        }
        self.motion(&scopes)?;
        self.tags(&scopes, &types)
    }

    /// Arcline's own provider; of others it is only said that they are there.
    fn overlay(&mut self, controller: Node<'a, 't>) -> Result<(), L5xError> {
        for properties in children(controller, "CustomProperties") {
            self.source.check(properties);
            for provider in children(properties, "Provider") {
                if provider.attribute("ID") != Some(PROVIDER) {
                    self.source.report(provider, Reason::NoCounterpart);
                    continue;
                }
                self.source.check(provider);
                let text = provider.text().unwrap_or_default();
                self.overlay = text.parse().map_err(|_| {
                    let problem = Problem::Value {
                        found: crate::document::shortened(text.trim()),
                        expected: "TOML as Arcline's export writes it",
                    };
                    self.source.error(provider, problem)
                })?;
            }
        }
        Ok(())
    }

    /// Adds an entry to a list of the configuration.
    fn push(&mut self, section: &str, node: Node<'a, 't>, entry: Table) {
        let list = self
            .config
            .entry(section.to_owned())
            .or_insert_with(|| Value::Array(Vec::new()));
        if let Value::Array(items) = list {
            items.push(Value::Table(entry));
            self.places.insert(format!("{section}[{}]", items.len()), node);
        }
    }

    /// The number of entries in a list.
    fn count(&self, section: &str) -> usize {
        self.config.get(section).and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// Whether the file's overlay has a key of an entry, so that other elements about it do not matter.
    fn overlaid(&self, section: &str, name: &str, key: &[&str]) -> bool {
        overlay::says(&self.overlay, section, name, key)
    }

    /// A file without a motion group may have a tag of its default name: then the group gets an underscore.
    fn name_default_group(&mut self) {
        let mut name = arcline_config::DEFAULT_GROUP.to_owned();
        while self.controller_names.contains(&name.to_ascii_lowercase()) {
            name.push('_');
        }
        if name == arcline_config::DEFAULT_GROUP {
            return;
        }
        let group = self.config.entry("motion_group");
        if let Value::Table(group) = group.or_insert_with(|| Value::Table(Table::new())) {
            group.entry("name").or_insert(Value::String(name));
        }
    }

    fn finish(mut self, controller: Node<'a, 't>) -> Result<Import, L5xError> {
        overlay::apply(&mut self.config, std::mem::take(&mut self.overlay));
        self.name_default_group();
        // The target of an alias is known only when all other tags exist.
        for _ in 0..MAX_DEAD_ALIASES {
            let text = arcline_config::format(&self.config);
            let error = match arcline_config::load(&text, "") {
                Ok(project) => {
                    return Ok(Import {
                        config: self.config,
                        project,
                        report: self.source.report,
                    });
                }
                Err(error) => error,
            };
            let entry = error.key.split_inclusive(']').next().unwrap_or_default();
            let node = self.places.get(entry).copied();
            if error.key.ends_with("].alias")
                && let Some(node) = node
                && let Some(Value::Array(tags)) = self.config.get_mut("tag")
                && let Some(place) = entry.trim_matches(|c: char| !c.is_ascii_digit()).parse::<usize>().ok()
                && (1..=tags.len()).contains(&place)
            {
                tags.remove(place - 1);
                self.source.report(node, Reason::NoCounterpart);
                self.places.remove(entry);
                for next in place..=tags.len() {
                    if let Some(node) = self.places.remove(&format!("tag[{}]", next + 1)) {
                        self.places.insert(format!("tag[{next}]"), node);
                    }
                }
                continue;
            }
            let message = format!("{}: {}", error.key, error.problem);
            return Err(self
                .source
                .error(node.unwrap_or(controller), Problem::Configuration { message }));
        }
        let problem = Problem::TooMuch {
            what: "aliases that lead nowhere",
            found: MAX_DEAD_ALIASES,
            limit: MAX_DEAD_ALIASES - 1,
        };
        Err(self.source.error(controller, problem))
    }
}

/// The most aliases without a target that the importer leaves out before it gives up. Partial exports have many, whose tags they do not have.
const MAX_DEAD_ALIASES: usize = 1024;
