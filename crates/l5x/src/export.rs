//! From a project to an L5X file that imports as the same project.

mod motion;
mod values;
mod xml;

use arcline_config::Project;
use arcline_controller::image::{Access, PlainTag};
use arcline_tag::{DataType, Elementary, Template};
use toml::Table;

use self::xml::Xml;
use crate::import::import;
use crate::overlay::{PROVIDER, difference, merge};

/// Writes a project as L5X: the format's own elements where they exist, and a `Provider` of Arcline in the
/// controller's `CustomProperties` for the rest. [`import`] makes the same project of it, with an empty report.
pub fn export(project: &Project) -> String {
    let whole = arcline_config::table(project);
    let mut overlay = Table::new();
    let mut text = document(project, &overlay);
    // The configuration of the file so far. If the file does not describe a machine yet, the overlay has everything. A key of the overlay can
    // be the default of another key, which then comes in the next round.
    for _ in 0..ROUNDS {
        let part = import(&text, "").map(|import| arcline_config::table(&import.project));
        let Some(lost) = difference(&whole, &part.unwrap_or_default()) else {
            break;
        };
        merge(&mut overlay, lost);
        text = document(project, &overlay);
    }
    text
}

/// No default depends on more than two others.
const ROUNDS: usize = 4;

fn document(project: &Project, overlay: &Table) -> String {
    let mut xml = Xml::new();
    let name = identifier(&project.server.name);
    xml.open(
        "RSLogix5000Content",
        &[
            ("SchemaRevision", "1.0"),
            ("SoftwareRevision", "33.00"),
            ("TargetName", &name),
            ("TargetType", "Controller"),
            ("ContainsContext", "false"),
            ("Owner", "Arcline"),
        ],
    );
    xml.open(
        "Controller",
        &[
            ("Use", "Target"),
            ("Name", &name),
            ("ProcessorType", "1756-L83E"),
            ("MajorRev", "33"),
            ("MinorRev", "11"),
        ],
    );
    xml.open("DataTypes", &[]);
    for template in &project.types {
        data_type(&mut xml, template);
    }
    xml.close("DataTypes");
    xml.open("Tags", &[]);
    motion::motion(&mut xml, &project.machine);
    let (own, of_programs): (Vec<&PlainTag>, Vec<_>) = project.tags.iter().partition(|tag| tag.program.is_none());
    own.iter().for_each(|one| tag(&mut xml, one));
    xml.close("Tags");
    let mut programs: Vec<&str> = Vec::new();
    for program in of_programs.iter().filter_map(|tag| tag.program.as_deref()) {
        if !programs.iter().any(|known| known.eq_ignore_ascii_case(program)) {
            programs.push(program);
        }
    }
    xml.open("Programs", &[]);
    for program in programs {
        xml.open("Program", &[("Name", program), ("Type", "Normal")]);
        xml.open("Tags", &[]);
        let inside = |tag: &&&PlainTag| {
            tag.program
                .as_deref()
                .is_some_and(|name| name.eq_ignore_ascii_case(program))
        };
        of_programs.iter().filter(inside).for_each(|one| tag(&mut xml, one));
        xml.close("Tags");
        xml.close("Program");
    }
    xml.close("Programs");
    if !overlay.is_empty() {
        xml.open("CustomProperties", &[]);
        xml.text(
            "Provider",
            &[("ID", PROVIDER), ("Ext", "TOML")],
            &toml::to_string(overlay).unwrap_or_default(),
        );
        xml.close("CustomProperties");
    }
    xml.close("Controller");
    xml.close("RSLogix5000Content");
    xml.finish()
}

/// A controller's name: letters, digits and underscores, no digit first.
fn identifier(name: &str) -> String {
    let clean: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect();
    if clean.starts_with(|c: char| c.is_ascii_digit()) {
        format!("_{}", clean.get(..31).unwrap_or(&clean))
    } else {
        clean
    }
}

fn data_type(xml: &mut Xml, template: &Template) {
    xml.open(
        "DataType",
        &[("Name", &template.name), ("Family", "NoFamily"), ("Class", "User")],
    );
    xml.open("Members", &[]);
    let mut host = "";
    for member in &template.members {
        let dimension = member.dimension.to_string();
        let name = ("Name", member.name.as_str());
        if member.hidden && member.name.starts_with("ZZZZZZZZZZ") {
            host = &member.name;
            xml.empty(
                "Member",
                &[
                    name,
                    ("DataType", "SINT"),
                    ("Dimension", "0"),
                    ("Radix", "Decimal"),
                    ("Hidden", "true"),
                ],
            );
        } else if let Some(bit) = member.bit {
            let bit = bit.to_string();
            let target = [("Target", host), ("BitNumber", &bit)];
            let head = [
                name,
                ("DataType", "BIT"),
                ("Dimension", "0"),
                ("Radix", "Decimal"),
                ("Hidden", "false"),
            ];
            xml.empty("Member", &[&head[..], &target[..]].concat());
        } else {
            let (word, dimension) = match &member.data_type {
                DataType::Elementary(Elementary::Dword) => ("BOOL", (32 * u32::from(member.dimension)).to_string()),
                data_type => (data_type.name(), dimension),
            };
            let radix = values::radix(&member.data_type);
            xml.empty(
                "Member",
                &[
                    name,
                    ("DataType", word),
                    ("Dimension", &dimension),
                    ("Radix", radix),
                    ("Hidden", "false"),
                ],
            );
        }
    }
    xml.close("Members");
    xml.close("DataType");
}

fn tag(xml: &mut Xml, tag: &PlainTag) {
    let access = match tag.access {
        Access::ReadOnly => "Read Only",
        _ => "Read/Write",
    };
    if let Some(path) = &tag.alias {
        let attributes = [
            ("Name", tag.name.as_str()),
            ("TagType", "Alias"),
            ("AliasFor", &path.to_string()),
            ("ExternalAccess", access),
        ];
        xml.empty("Tag", &attributes);
        return;
    }
    let data_type = &tag.tag_type.data_type;
    let bits = matches!(data_type, DataType::Elementary(Elementary::Dword));
    let counts = tag.tag_type.dimensions.iter().take_while(|count| **count > 0);
    let counts: Vec<String> = counts
        .map(|count| (if bits { 32 * count } else { *count }).to_string())
        .collect();
    let dimensions = counts.join(",");
    let mut attributes = vec![("Name", tag.name.as_str()), ("TagType", "Base")];
    attributes.push(("DataType", if bits { "BOOL" } else { data_type.name() }));
    if !counts.is_empty() {
        attributes.push(("Dimensions", &dimensions));
    }
    if matches!(data_type, DataType::Elementary(_)) {
        attributes.push(("Radix", values::radix(data_type)));
    }
    attributes.extend([("Constant", "false"), ("ExternalAccess", access)]);
    if tag.first.iter().all(|byte| *byte == 0) {
        xml.empty("Tag", &attributes);
        return;
    }
    xml.open("Tag", &attributes);
    xml.open("Data", &[("Format", "Decorated")]);
    let place = values::ValueKind::Value;
    values::value(
        xml,
        place,
        data_type,
        &tag.tag_type.dimensions[..tag.tag_type.rank()],
        &tag.first,
    );
    xml.close("Data");
    xml.close("Tag");
}
