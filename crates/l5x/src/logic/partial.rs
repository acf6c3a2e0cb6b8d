//! Partial exports: a program, a routine, rungs or an add-on instruction alone. They have no tasks; so that one can be tried, its target
//! runs on a task of 10 ms. An add-on instruction gets a program with one rung that calls it, and a tag for each of its operands.

use arcline_routine::source::{
    Content, Datum, InstructionSource, ProgramSource, Project, RoutineSource, RungSource, TagSource, TaskSource,
    Trigger, Usage,
};
use roxmltree::Node;

use crate::document::children;

/// Completes a project whose file is an export of this kind (`TargetType`), and of this name.
pub(super) fn complete(project: &mut Project, controller: Node<'_, '_>, target: &str, name: &str) {
    if !project.tasks.is_empty() {
        return;
    }
    let program = match target {
        "AddOnInstructionDefinition" => {
            let is_target = |one: &&InstructionSource| one.name.eq_ignore_ascii_case(name);
            let Some(add_on) = project.instructions.iter().find(is_target).cloned() else {
                return;
            };
            call(project, &add_on);
            TRIAL.to_owned()
        }
        "Program" | "Routine" | "Rung" => match targets(controller, target) {
            Some((program, routine)) => {
                if let Some(routine) = routine
                    && let Some(of) = project.programs.iter_mut().find(|one| one.name == program)
                {
                    of.main = Some(routine);
                }
                program
            }
            None => return,
        },
        _ => return,
    };
    project
        .tasks
        .push(TaskSource::new(TRIAL, Trigger::Periodic(10.0), &[&program]));
}

/// The program, and the routine that is or has the target.
fn targets(controller: Node<'_, '_>, target: &str) -> Option<(String, Option<String>)> {
    let is_target = |node: &Node<'_, '_>| node.attribute("Use") == Some("Target");
    let name = |node: Node<'_, '_>| node.attribute("Name").map(str::to_owned);
    for program in children(controller, "Programs").flat_map(|list| children(list, "Program")) {
        if target == "Program" {
            if is_target(&program) {
                return Some((name(program)?, None));
            }
            continue;
        }
        for routine in children(program, "Routines").flat_map(|list| children(list, "Routine")) {
            let mut inside = routine.descendants();
            if inside.any(|node| is_target(&node)) {
                return Some((name(program)?, name(routine)));
            }
        }
    }
    None
}

/// A program that calls an add-on instruction in every scan. Its tags have the names of the parameters; one that is taken gets an
/// underscore. A parameter that is an alias has the type of its target, which the file does not repeat: its operand is that member of the instance.
fn call(project: &mut Project, add_on: &InstructionSource) {
    let mut add = |mut name: String, data_type: &str, dimensions: &[u32], value: Option<Datum>| {
        let is_taken = |name: &str| {
            let all = project.tags.iter().map(|tag| tag.name.as_str());
            // A motion group without a name has its default one.
            all.chain([arcline_config::DEFAULT_GROUP])
                .any(|one| one.eq_ignore_ascii_case(name))
        };
        while is_taken(&name) {
            name.push('_');
        }
        let tag = TagSource::new(name.clone(), data_type.to_owned(), dimensions.to_vec(), value);
        project.tags.push(tag);
        name
    };
    let instance = add(format!("{}1", add_on.name), &add_on.name, &[], None);
    let mut operands = vec![instance.clone()];
    let required = add_on
        .parameters
        .iter()
        .filter(|one| one.is_required || one.usage == Usage::InOut);
    operands.extend(required.map(|one| {
        let member = &one.member;
        match one.alias {
            Some(_) => format!("{instance}.{}", member.name),
            None => add(
                member.name.clone(),
                &member.data_type,
                &member.dimensions,
                one.value.clone(),
            ),
        }
    }));
    let rung = RungSource {
        number: 0,
        kind: "N".to_owned(),
        text: format!("{}({});", add_on.name, operands.join(",")),
        comment: String::new(),
    };
    project.programs.push(ProgramSource {
        name: TRIAL.to_owned(),
        main: Some(TRIAL.to_owned()),
        fault: None,
        is_disabled: false,
        tags: Vec::new(),
        routines: vec![RoutineSource {
            name: TRIAL.to_owned(),
            content: Content::Ladder(vec![rung]),
        }],
    });
}

/// The program, routine and task that are made.
const TRIAL: &str = "Trial";
