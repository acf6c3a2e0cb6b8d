//! The parsed file with its positions: errors and findings by line and element path.

use roxmltree::{Attribute, Document, Node, ParsingOptions};

use crate::mapping::{self, Meaning};
use crate::{L5xError, Problem, Reason, Report, scan};

/// The file, its lines, and the findings about parts that are not imported.
pub(crate) struct Source<'t> {
    file: &'t str,
    text: &'t str,
    lines: Vec<usize>,
    pub(crate) report: Report,
}

/// Parses a text that keeps the bounds. A DTD is refused, so there are no entities but the five of XML.
pub(crate) fn parse<'t>(file: &'t str, text: &'t str) -> Result<(Source<'t>, Document<'t>), L5xError> {
    let starts = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
    let source = Source {
        file,
        text,
        lines: std::iter::once(0).chain(starts.map(|(place, _)| place + 1)).collect(),
        report: Report::default(),
    };
    scan::check(text).map_err(|(offset, problem)| source.error_at(offset, String::new(), problem))?;
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    match Document::parse_with_options(text, options) {
        Ok(document) => Ok((source, document)),
        Err(error) => {
            let place = error.pos();
            let message = error.to_string().lines().collect::<Vec<_>>().join(", ");
            Err(L5xError {
                file: file.to_owned(),
                line: place.row as usize,
                column: place.col as usize,
                path: String::new(),
                problem: Problem::Syntax { message },
            })
        }
    }
}

impl Source<'_> {
    pub(crate) fn line(&self, offset: usize) -> usize {
        self.lines.partition_point(|start| *start <= offset).max(1)
    }

    fn error_at(&self, offset: usize, path: String, problem: Problem) -> L5xError {
        let line = self.line(offset);
        let start = self.lines.get(line - 1).copied().unwrap_or(0);
        let before = self.text.get(start..offset).unwrap_or_default();
        L5xError {
            file: self.file.to_owned(),
            line,
            column: before.chars().count() + 1,
            path,
            problem,
        }
    }

    /// The error of an element.
    pub(crate) fn error(&self, node: Node<'_, '_>, problem: Problem) -> L5xError {
        self.error_at(node.range().start, path(node), problem)
    }

    /// The controller of a file.
    pub(crate) fn controller<'a>(&self, root: Node<'a, 'a>) -> Result<Node<'a, 'a>, L5xError> {
        let problem = Problem::Missing {
            what: "Controller",
            expected: "the element that holds data types and tags; an export of a module alone has none",
        };
        child(root, "Controller").ok_or_else(|| self.error(root, problem))
    }

    /// The error of an attribute that is there but does not do.
    pub(crate) fn wrong(&self, node: Node<'_, '_>, name: &'static str, expected: &'static str) -> L5xError {
        let Some(attribute) = node.attribute_node(name) else {
            return self.error(node, Problem::Missing { what: name, expected });
        };
        let found = shortened(attribute.value());
        let path = format!("{}/@{name}", path(node));
        self.error_at(attribute.range().start, path, Problem::Value { found, expected })
    }

    /// An attribute that must be there.
    pub(crate) fn required<'a>(
        &self,
        node: Node<'a, '_>,
        name: &'static str,
        expected: &'static str,
    ) -> Result<&'a str, L5xError> {
        node.attribute(name).ok_or_else(|| self.wrong(node, name, expected))
    }

    /// A number, if it is there.
    pub(crate) fn number(&self, node: Node<'_, '_>, name: &'static str) -> Result<Option<f64>, L5xError> {
        let Some(text) = node.attribute(name) else {
            return Ok(None);
        };
        match text.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Some(number)),
            _ => Err(self.wrong(node, name, "a finite number")),
        }
    }

    /// Adds an element to the report.
    pub(crate) fn report(&mut self, node: Node<'_, '_>, reason: Reason) {
        let line = self.line(node.range().start);
        let tag = node.attribute("Name").filter(|_| node.has_tag_name("Tag"));
        self.report.add(reason, path(node), line, tag);
    }

    /// Adds an attribute to the report.
    pub(crate) fn report_attribute(&mut self, node: Node<'_, '_>, name: &str, reason: Reason) {
        let line = self.line(
            node.attribute_node(name)
                .map_or(node.range().start, |one| one.range().start),
        );
        self.report.add(reason, format!("{}/@{name}", path(node)), line, None);
    }

    /// Adds attributes and children to the report that the table of [`mapping`] does not have or calls lost.
    pub(crate) fn check(&mut self, node: Node<'_, '_>) {
        let rows = mapping::rows(node.tag_name().name());
        for attribute in node.attributes() {
            let row = rows
                .iter()
                .find(|row| row.what.strip_prefix('@') == Some(attribute.name()));
            self.judge(node, row.map(|row| row.meaning), &attribute);
        }
        for child in node.children().filter(Node::is_element) {
            let row = rows.iter().find(|row| row.what == child.tag_name().name());
            match row.map(|row| row.meaning) {
                None => self.report(child, Reason::NotUnderstood),
                Some(Meaning::Without(_)) => self.report(child, Reason::NoCounterpart),
                Some(Meaning::Each) => {
                    for grandchild in child.children().filter(Node::is_element) {
                        self.report(grandchild, Reason::NoCounterpart);
                    }
                }
                Some(Meaning::Key(_) | Meaning::Form(_)) => {}
            }
        }
    }

    fn judge(&mut self, node: Node<'_, '_>, meaning: Option<Meaning>, attribute: &Attribute<'_, '_>) {
        match meaning {
            None => self.report_attribute(node, attribute.name(), Reason::NotUnderstood),
            Some(Meaning::Without(neutral)) if !is_neutral(neutral, attribute.value()) => {
                self.report_attribute(node, attribute.name(), Reason::NoCounterpart);
            }
            Some(_) => {}
        }
    }
}

/// Whether a value is neutral, alone or in each element of a list.
fn is_neutral(neutral: &str, value: &str) -> bool {
    let same = |word: &str| match (word.parse::<f64>(), neutral.parse::<f64>()) {
        (Ok(a), Ok(b)) => a == b,
        _ => word == neutral,
    };
    !neutral.is_empty() && (value == neutral || value.split_whitespace().all(same))
}

/// `Controller/Tags/Tag[TIMER]/Data`: the elements from the controller on, tags with their type.
pub(crate) fn path(node: Node<'_, '_>) -> String {
    let mut names: Vec<String> = Vec::new();
    for node in node.ancestors().filter(Node::is_element) {
        let name = shortened(node.tag_name().name());
        match node.attribute("DataType") {
            Some(data_type) if name == "Tag" => names.push(format!("Tag[{}]", shortened(data_type))),
            _ => names.push(name),
        }
    }
    if names.len() > 1 {
        names.pop();
    }
    names.reverse();
    names.join("/")
}

/// A text of the file for a message: short and without control characters.
pub(crate) fn shortened(text: &str) -> String {
    let clean = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    clean.take(60).collect()
}

/// A partial export names an element around its target without this attribute, and without its content.
pub(crate) fn is_named_only(node: Node<'_, '_>, attribute: &str) -> bool {
    node.attribute("Use") == Some("Reference") && !node.has_attribute(attribute) && !node.has_attribute("AliasFor")
}

/// The elements with that name in a node.
pub(crate) fn children<'a, 't>(
    node: Node<'a, 't>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 't>> + use<'a, 't> {
    node.children()
        .filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// The first element with that name.
pub(crate) fn child<'a, 't>(node: Node<'a, 't>, name: &'static str) -> Option<Node<'a, 't>> {
    children(node, name).next()
}

/// Elements and texts: far more than the largest project has.
const MAX_NODES: u32 = 8_000_000;
