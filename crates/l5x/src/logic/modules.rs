//! Modules: the tags of their connections, with the types that their data name.

use arcline_routine::source::{Project, TagSource};
use roxmltree::Node;

use super::data;
use crate::document::{child, children};

/// Adds a module and its tags.
pub(super) fn module(node: Node<'_, '_>, project: &mut Project) {
    let name = node.attribute("Name").unwrap_or_default();
    project.modules.push((
        name.to_owned(),
        node.attribute("CatalogNumber").unwrap_or_default().to_owned(),
    ));
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
    let mut add = |node: Option<Node<'_, '_>>, suffix: &str| {
        let Some(node) = node else { return };
        let Some(value) = data::value(node, "Data") else { return };
        let name = format!("{prefix}:{suffix}");
        if project.tags.iter().any(|tag| tag.name.eq_ignore_ascii_case(&name)) {
            return;
        }
        let data_type = match &value {
            arcline_routine::source::Datum::Structure(name, _) | arcline_routine::source::Datum::Typed(name, _) => {
                name.clone()
            }
            _ => String::new(),
        };
        project.tags.push(TagSource {
            is_module: true,
            ..TagSource::new(name, data_type, [], Some(value))
        });
    };
    add(child(communications, "ConfigTag"), "C");
    for connection in children(communications, "Connections").flat_map(|list| children(list, "Connection")) {
        let suffix =
            |attribute: &str, default: &'static str| connection.attribute(attribute).unwrap_or(default).to_owned();
        add(child(connection, "InputTag"), &suffix("InputTagSuffix", "I"));
        add(child(connection, "OutputTag"), &suffix("OutputTagSuffix", "O"));
    }
}
