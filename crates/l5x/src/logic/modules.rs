//! Modules: the tags of their connections, with the types that their data name.

use arcline_routine::source::{Datum, Project, TagSource};
use roxmltree::Node;

use super::data;
use crate::document::{child, children};

/// Adds a module and its tags.
pub(super) fn module(node: Node<'_, '_>, project: &mut Project) {
    let name = node.attribute("Name").unwrap_or_default();
    project.modules.push(name.to_owned());
    let ports = children(node, "Ports").flat_map(|list| children(list, "Port"));
    let upstream = ports
        .into_iter()
        .find(|port| port.attribute("Upstream") == Some("true"));
    // A module in a rack is named by its slot, one on a network by its own name.
    let prefix = match upstream {
        Some(port) if port.attribute("Type") != Some("Ethernet") => {
            let parent = node.attribute("ParentModule").unwrap_or("Local");
            format!("{parent}:{}", port.attribute("Address").unwrap_or("0"))
        }
        _ => name.to_owned(),
    };
    let Some(communications) = child(node, "Communications") else {
        return;
    };
    if let Some(config) = child(communications, "ConfigTag") {
        add(config, format!("{prefix}:C"), project);
    }
    for connection in children(communications, "Connections").flat_map(|list| list.children()) {
        let suffix = |attribute: &str, default: &'static str| {
            format!("{prefix}:{}", connection.attribute(attribute).unwrap_or(default))
        };
        for part in connection.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "InputTag" => add(part, suffix("InputTagSuffix", "I"), project),
                "OutputTag" => add(part, suffix("OutputTagSuffix", "O"), project),
                "InAliasTag" => alias(node, suffix("InputTagSuffix", "I"), "I", project),
                "OutAliasTag" => alias(node, suffix("OutputTagSuffix", "O"), "O", project),
                _ => {}
            }
        }
    }
}

/// Adds a tag with the members that its first value names.
fn add(node: Node<'_, '_>, name: String, project: &mut Project) {
    if has(project, &name) {
        return;
    }
    let value = data::value(node, "Data");
    if let Some(Datum::Structure(kind, _) | Datum::Typed(kind, _)) = &value {
        let tag = TagSource::new(name, kind.clone(), [], value.clone());
        project.tags.push(TagSource { is_module: true, ..tag });
        return;
    }
    let what = if children(node, "Data").next().is_some() {
        "has no data of the format Decorated"
    } else {
        "has no data"
    };
    let reason = format!("{what}, which name its members: there is no such tag");
    project.outside.push((name, reason));
}

/// Adds the tag of a module whose data its adapter has for the whole rack.
fn alias(node: Node<'_, '_>, name: String, direction: &str, project: &mut Project) {
    if has(project, &name) {
        return;
    }
    let adapter = format!("{}:{direction}", node.attribute("ParentModule").unwrap_or_default());
    let slot = name.split(':').nth(1).and_then(|slot| slot.parse::<u32>().ok());
    match slot.filter(|_| has(project, &adapter)) {
        Some(slot) => project.tags.push(TagSource {
            alias: Some(format!("{adapter}.Data[{slot}]")),
            is_module: true,
            ..TagSource::new(name, "", [], None)
        }),
        None => {
            let reason = format!("its data is that of {adapter}, which is not there: there is no such tag");
            project.outside.push((name, reason));
        }
    }
}

fn has(project: &Project, name: &str) -> bool {
    project.tags.iter().any(|tag| tag.name.eq_ignore_ascii_case(name))
}
