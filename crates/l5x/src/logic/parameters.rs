//! Parameters of programs: `Usage` of their tags, and `ParameterConnections`.
//!
//! An InOut parameter is an alias of the other end of its connection. Values of Input parameters are copied before the scan of their program, those
//! of Output parameters behind it. A Public parameter is a tag of the program that others name.

use arcline_routine::source::{Connection, Project, TagSource};
use arcline_routine::{Finding, FindingKind};
use roxmltree::Node;

use crate::document::children;

/// An end of a connection: `\Main.Speed.Set`, or a path in the controller's scope.
#[derive(Clone, Copy)]
struct End<'t> {
    text: &'t str,
    program: &'t str,
    /// The tag, when the end is a whole one of the program.
    tag: Option<&'t str>,
    usage: Option<&'t str>,
}

/// Reads the connections of a project whose tags are read.
pub(super) fn connections(controller: Node<'_, '_>, project: &mut Project) {
    let mut usages = Vec::new();
    for program in children(controller, "Programs").flat_map(|list| children(list, "Program")) {
        for tag in children(program, "Tags").flat_map(|list| children(list, "Tag")) {
            if let (Some(program), Some(name), Some(usage)) =
                (program.attribute("Name"), tag.attribute("Name"), tag.attribute("Usage"))
            {
                usages.push((program, name, usage));
            }
        }
    }
    let lists = children(controller, "ParameterConnections");
    for node in lists.flat_map(|list| children(list, "ParameterConnection")) {
        let [one, other] =
            ["EndPoint1", "EndPoint2"].map(|name| end(node.attribute(name).unwrap_or_default(), &usages));
        connect(one, other, project);
    }
    for (program, name, _) in usages.iter().filter(|(_, _, usage)| *usage == "InOut") {
        let tag = tag_of(project, program, name);
        if tag.is_some_and(|tag| tag.alias.is_none()) {
            let reason = "is a parameter by reference (InOut) without a connection";
            project.findings.push(Finding {
                program: Some((*program).to_owned()),
                ..Finding::new(FindingKind::Tag, name, reason.to_owned())
            });
        }
    }
}

fn end<'t>(text: &'t str, usages: &[(&'t str, &'t str, &'t str)]) -> End<'t> {
    let (program, path) = text
        .strip_prefix('\\')
        .and_then(|rest| rest.split_once('.'))
        .unwrap_or_default();
    let name = path.split(['.', '[']).next().unwrap_or_default();
    let usage = usages
        .iter()
        .find(|(of, tag, _)| of.eq_ignore_ascii_case(program) && tag.eq_ignore_ascii_case(name));
    End {
        text,
        program,
        tag: Some(path).filter(|path| !path.is_empty() && *path == name),
        usage: usage.map(|(_, _, usage)| *usage),
    }
}

fn connect(one: End<'_>, other: End<'_>, project: &mut Project) {
    for (this, that) in [(one, other), (other, one)] {
        if this.usage == Some("InOut")
            && let Some(tag) = this.tag.and_then(|name| tag_of(project, this.program, name))
        {
            let path = that.text.strip_prefix('\\').map(|path| format!("Program:{path}"));
            tag.alias = Some(path.unwrap_or_else(|| that.text.to_owned()));
            return;
        }
    }
    let copy = |program: &str, is_before, from: End<'_>, to: End<'_>| Connection {
        program: program.to_owned(),
        is_before,
        from: from.text.to_owned(),
        to: to.text.to_owned(),
    };
    for (this, that) in [(one, other), (other, one)] {
        match this.usage {
            Some("Input") => return project.connections.push(copy(this.program, true, that, this)),
            Some("Output") if that.usage != Some("Input") => {
                return project.connections.push(copy(this.program, false, this, that));
            }
            _ => {}
        }
    }
    let reason = format!(
        "its connection with {} does not take place: neither is an Input, Output or InOut parameter",
        other.text
    );
    project.findings.push(Finding::new(FindingKind::Tag, one.text, reason));
}

fn tag_of<'p>(project: &'p mut Project, program: &str, name: &str) -> Option<&'p mut TagSource> {
    let of = project
        .programs
        .iter_mut()
        .find(|one| one.name.eq_ignore_ascii_case(program))?;
    of.tags.iter_mut().find(|tag| tag.name.eq_ignore_ascii_case(name))
}
