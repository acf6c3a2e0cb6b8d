//! The program of an L5X file: tags, types, add-on instructions, routines and tasks as they are written, for `arcline-routine`.

mod data;
mod l5k;
mod modules;
mod parameters;
mod partial;
mod unsupported;

use std::collections::{BTreeMap, BTreeSet};

use arcline_routine::source::{
    Access, Content, InstructionSource, MemberSource, ParameterSource, ProgramSource, Project, RoutineSource,
    RungSource, TagSource, TaskSource, Trigger, TypeSource, Usage,
};
use arcline_routine::{Finding, FindingKind};
use roxmltree::Node;

use crate::L5xError;
use crate::document::{Source, child, children, is_named_only, parse};

/// Reads the program of an L5X file. `file` only names the text in errors.
///
/// # Errors
/// The first error, with line, column and element. Parts that cannot run are no errors: loading names them.
pub fn logic(text: &str, file: &str) -> Result<Project, L5xError> {
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
    let (source, document) = parse(file, text)?;
    let root = document.root_element();
    let controller = source.controller(root)?;
    let mut project = Project {
        processor: controller.attribute("ProcessorType").unwrap_or_default().to_owned(),
        fault_handler: controller
            .attribute("MajorFaultProgram")
            .filter(|name| !name.is_empty())
            .map(str::to_owned),
        ..Project::default()
    };
    let lists = |name: &'static str, item: &'static str| {
        children(controller, name)
            .flat_map(move |list| children(list, item))
            .collect::<Vec<_>>()
    };
    for node in lists("DataTypes", "DataType") {
        project.types.push(data_type(&source, node)?);
    }
    for node in lists("AddOnInstructionDefinitions", "AddOnInstructionDefinition") {
        project.instructions.push(instruction(&source, node)?);
    }
    for node in lists("AddOnInstructionDefinitions", "AddOnInstructionDefinition") {
        unsupported::edits(node, &mut project.findings);
    }
    for node in lists("AddOnInstructionDefinitions", "EncodedData") {
        project.instructions.push(encoded(&source, node)?);
    }
    for node in lists("Modules", "Module") {
        modules::module(node, &mut project);
    }
    for node in lists("Tags", "Tag") {
        if is_named_only(node, "DataType") {
            continue;
        }
        project.tags.push(tag(&source, node)?);
        project.findings.extend(sharing(node));
    }
    for node in lists("Programs", "Program") {
        let read = program(&source, node)?;
        project
            .programs
            .push(unsupported::program(node, read, &mut project.findings));
    }
    for node in lists("Tasks", "Task") {
        let read = task(&source, node)?;
        project
            .tasks
            .extend(unsupported::task(node, read, &mut project.findings));
    }
    parameters::connections(controller, &mut project);
    let [target, name] = ["TargetType", "TargetName"].map(|word| root.attribute(word).unwrap_or_default());
    partial::complete(&mut project, controller, target, name);
    Ok(project)
}

fn name(source: &Source<'_>, node: Node<'_, '_>) -> Result<String, L5xError> {
    source.required(node, "Name", "the element's name").map(str::to_owned)
}

fn dimensions(node: Node<'_, '_>, attribute: &str) -> Vec<u32> {
    let text = node.attribute(attribute).unwrap_or_default();
    let sizes = text.split([',', ' ']).filter_map(|size| size.parse().ok());
    sizes.filter(|size| *size > 0).take(3).collect()
}

fn data_type(source: &Source<'_>, node: Node<'_, '_>) -> Result<TypeSource, L5xError> {
    let mut members = Vec::new();
    for member in children(node, "Members").flat_map(|list| children(list, "Member")) {
        if member.attribute("Hidden") == Some("true") {
            continue;
        }
        members.push(MemberSource {
            name: name(source, member)?,
            data_type: member.attribute("DataType").unwrap_or_default().to_owned(),
            dimensions: dimensions(member, "Dimension"),
            access: access(member),
        });
    }
    Ok(TypeSource {
        name: name(source, node)?,
        is_string: node.attribute("Family") == Some("StringFamily"),
        members,
    })
}

fn member(source: &Source<'_>, node: Node<'_, '_>) -> Result<MemberSource, L5xError> {
    Ok(MemberSource {
        name: name(source, node)?,
        data_type: node.attribute("DataType").unwrap_or_default().to_owned(),
        dimensions: dimensions(node, "Dimensions"),
        access: access(node),
    })
}

fn flag(node: Node<'_, '_>, name: &str) -> bool {
    node.attribute(name)
        .is_some_and(|word| word.eq_ignore_ascii_case("true"))
}

fn instruction(source: &Source<'_>, node: Node<'_, '_>) -> Result<InstructionSource, L5xError> {
    let mut parameters = Vec::new();
    for one in children(node, "Parameters").flat_map(|list| children(list, "Parameter")) {
        parameters.push(ParameterSource {
            member: member(source, one)?,
            usage: match one.attribute("Usage") {
                Some("Output") => Usage::Output,
                Some("InOut") => Usage::InOut,
                _ => Usage::Input,
            },
            is_required: flag(one, "Required"),
            alias: one.attribute("AliasFor").map(str::to_owned),
            value: data::value(one, "DefaultData"),
        });
    }
    let mut locals = Vec::new();
    for one in children(node, "LocalTags").flat_map(|list| children(list, "LocalTag")) {
        locals.push((member(source, one)?, data::value(one, "DefaultData")));
    }
    Ok(InstructionSource {
        name: name(source, node)?,
        parameters,
        locals,
        routines: routines(source, node)?,
        has_prescan: flag(node, "ExecutePrescan"),
        has_enable_in_false: flag(node, "ExecuteEnableInFalse"),
        is_encoded: child(node, "EncodedData").is_some(),
    })
}

/// A protected instruction: its parameters may stand beside the encoded content.
fn encoded(source: &Source<'_>, node: Node<'_, '_>) -> Result<InstructionSource, L5xError> {
    let mut one = instruction(source, node)?;
    one.is_encoded = true;
    Ok(one)
}

fn routines(source: &Source<'_>, node: Node<'_, '_>) -> Result<Vec<RoutineSource>, L5xError> {
    let mut routines = Vec::new();
    for list in children(node, "Routines") {
        for one in list.children().filter(Node::is_element) {
            let content = if is_named_only(one, "Type") {
                Content::Other(LACKING.to_owned())
            } else if one.tag_name().name() == "EncodedData" {
                Content::Other("encoded content".to_owned())
            } else {
                content(one)
            };
            routines.push(RoutineSource {
                name: name(source, one)?,
                content,
            });
        }
    }
    Ok(routines)
}

/// Leaves out the routines that an export only names and nothing in it calls.
fn without_uncalled(mut routines: Vec<RoutineSource>) -> Vec<RoutineSource> {
    let is_lacking = |one: &RoutineSource| one.content == Content::Other(LACKING.to_owned());
    if routines.iter().any(is_lacking) {
        let words: BTreeSet<String> = routines.iter().flat_map(words).collect();
        routines.retain(|one| !is_lacking(one) || words.contains(&one.name.to_ascii_lowercase()));
    }
    routines
}

/// The words in the text of a routine, in lower case.
fn words(routine: &RoutineSource) -> Vec<String> {
    let texts: Vec<&str> = match &routine.content {
        Content::Ladder(rungs) => rungs.iter().map(|rung| rung.text.as_str()).collect(),
        Content::Text(lines) => lines.iter().map(|(_, line)| line.as_str()).collect(),
        Content::Other(_) => Vec::new(),
    };
    let is_between = |c: char| !(c.is_ascii_alphanumeric() || c == '_');
    let words = texts.into_iter().flat_map(|text| text.split(is_between));
    words.map(str::to_ascii_lowercase).collect()
}

/// The content of a routine that an export only names.
const LACKING: &str = "content that the export lacks";

fn content(node: Node<'_, '_>) -> Content {
    let number = |node: Node<'_, '_>| {
        node.attribute("Number")
            .and_then(|text| text.parse().ok())
            .unwrap_or_default()
    };
    match node.attribute("Type").unwrap_or_default() {
        "RLL" if child(node, "EncodedData").is_none() => {
            let rungs = children(node, "RLLContent").flat_map(|list| children(list, "Rung"));
            let rungs = rungs.map(|rung| RungSource {
                number: number(rung),
                kind: rung.attribute("Type").unwrap_or("N").to_owned(),
                text: child(rung, "Text").map_or_else(|| ";".to_owned(), text_of),
                comment: child(rung, "Comment").map_or_else(String::new, comment_of),
            });
            Content::Ladder(rungs.collect())
        }
        "ST" if child(node, "EncodedData").is_none() => {
            let in_force = unsupported::text_in_force(node);
            let lines = in_force.into_iter().flat_map(|list| children(list, "Line"));
            // Line feeds may stand around CDATA.
            let text = |line| text_of(line).trim_matches(['\r', '\n']).to_owned();
            Content::Text(lines.map(|line| (number(line), text(line))).collect())
        }
        "RLL" | "ST" => Content::Other("encoded content".to_owned()),
        other => Content::Other(other.to_owned()),
    }
}

/// A comment, in the first of its languages.
fn comment_of(node: Node<'_, '_>) -> String {
    let mut parts = node.descendants().map(text_of).map(|text| text.trim().to_owned());
    parts.find(|text| !text.is_empty()).unwrap_or_default()
}

/// All text of an element, which CDATA may split.
fn text_of(node: Node<'_, '_>) -> String {
    node.children().filter_map(|part| part.text()).collect()
}

fn tag(source: &Source<'_>, node: Node<'_, '_>) -> Result<TagSource, L5xError> {
    let is_alias = node.attribute("TagType") == Some("Alias");
    Ok(TagSource {
        name: name(source, node)?,
        data_type: node.attribute("DataType").unwrap_or_default().to_owned(),
        dimensions: dimensions(node, "Dimensions"),
        alias: node.attribute("AliasFor").filter(|_| is_alias).map(str::to_owned),
        value: data::value(node, "Data"),
        access: access(node),
        is_module: false,
        attributes: message_parameters(node),
    })
}

/// The sharing of a tag with other controllers, which does not take place here.
fn sharing(node: Node<'_, '_>) -> Option<Finding> {
    let reason = match node.attribute("TagType")? {
        "Produced" => "is produced, but nobody receives it: it is a plain tag".to_owned(),
        "Consumed" => {
            let producer = child(node, "ConsumeInfo").and_then(|info| info.attribute("Producer"));
            let producer = producer.unwrap_or("another controller");
            format!("is consumed from {producer}, but nothing comes: it is a plain tag")
        }
        _ => return None,
    };
    Some(Finding::new(FindingKind::Shared, node.attribute("Name")?, reason))
}

/// The parameters of a tag of the type MESSAGE or ALARM_DIGITAL.
fn message_parameters(node: Node<'_, '_>) -> BTreeMap<String, String> {
    let data = children(node, "Data");
    let lists = data.flat_map(|data| ["MessageParameters", "AlarmDigitalParameters"].map(|name| children(data, name)));
    let lists = lists.flatten();
    let all = lists.flat_map(|list| list.attributes());
    all.map(|one| (one.name().to_owned(), one.value().to_owned())).collect()
}

fn access(node: Node<'_, '_>) -> Access {
    match node.attribute("ExternalAccess") {
        Some("None") => Access::Hidden,
        Some("Read Only") => Access::ReadOnly,
        _ if flag(node, "Constant") => Access::ReadOnly,
        _ => Access::ReadWrite,
    }
}

fn program(source: &Source<'_>, node: Node<'_, '_>) -> Result<ProgramSource, L5xError> {
    let word = |attribute: &str| {
        node.attribute(attribute)
            .filter(|word| !word.is_empty())
            .map(str::to_owned)
    };
    let mut tags = Vec::new();
    let listed = children(node, "Tags").flat_map(|list| children(list, "Tag"));
    for one in listed.filter(|one| !is_named_only(*one, "DataType")) {
        tags.push(tag(source, one)?);
    }
    Ok(ProgramSource {
        name: name(source, node)?,
        main: word("MainRoutineName"),
        fault: word("FaultRoutineName"),
        is_disabled: flag(node, "Disabled"),
        tags,
        routines: without_uncalled(routines(source, node)?),
    })
}

fn task(source: &Source<'_>, node: Node<'_, '_>) -> Result<TaskSource, L5xError> {
    let rate = source.number(node, "Rate")?;
    let event = child(node, "EventInfo");
    let trigger = match node.attribute("Type").unwrap_or_default() {
        "PERIODIC" => Trigger::Periodic(rate.filter(|rate| *rate > 0.0).unwrap_or(10.0)),
        "EVENT" => {
            let word = event
                .and_then(|event| event.attribute("EventTrigger"))
                .unwrap_or_default();
            let timeout = rate.filter(|_| event.is_some_and(|event| flag(event, "EnableTimeout")));
            Trigger::Event(word.to_owned(), timeout)
        }
        _ => Trigger::Continuous,
    };
    let programs = children(node, "ScheduledPrograms").flat_map(|list| children(list, "ScheduledProgram"));
    let programs = programs.filter_map(|one| one.attribute("Name")).map(str::to_owned);
    Ok(TaskSource {
        name: name(source, node)?,
        trigger,
        event_tag: event
            .and_then(|event| event.attribute("EventTag"))
            .unwrap_or_default()
            .to_owned(),
        priority: source.number(node, "Priority")?.unwrap_or(10.0) as u32,
        watchdog_ms: source.number(node, "Watchdog")?.unwrap_or(500.0),
        is_inhibited: flag(node, "InhibitTask"),
        programs: programs.collect(),
    })
}
