//! Programs and tasks that do not run as what they are: those of safety, and equipment phases (spec/programs.md §20). Loading names them, and
//! passes over them.

use arcline_routine::source::{ProgramSource, TaskSource};
use arcline_routine::{Finding, FindingKind};
use roxmltree::Node;

use crate::document::{child, children};

/// A program, or its tags alone when its rungs need another controller.
pub(super) fn program(node: Node<'_, '_>, program: ProgramSource, findings: &mut Vec<Finding>) -> ProgramSource {
    edits(node, findings);
    let reason = match node.attribute("Type").unwrap_or("Normal") {
        _ if is_of_safety(node) => "a program of safety is not supported".to_owned(),
        "Normal" | "" => return program,
        "EquipmentPhase" => "an equipment phase is not supported".to_owned(),
        other => format!("a program of the type {other} is not supported"),
    };
    findings.push(Finding::new(FindingKind::Program, &program.name, reason));
    ProgramSource {
        main: None,
        fault: None,
        routines: Vec::new(),
        ..program
    }
}

/// A task, unless it is one of safety.
pub(super) fn task(node: Node<'_, '_>, task: TaskSource, findings: &mut Vec<Finding>) -> Option<TaskSource> {
    if !is_of_safety(node) {
        return Some(task);
    }
    let reason = "a task of safety is not supported".to_owned();
    findings.push(Finding::new(FindingKind::Task, &task.name, reason));
    None
}

/// The lines of a routine of Structured Text that run: those without its pending edits.
pub(super) fn text_in_force<'a, 't>(routine: Node<'a, 't>) -> Option<Node<'a, 't>> {
    let is_original = |text: &Node<'_, '_>| matches!(text.attribute("OnlineEditType"), None | Some("Original"));
    let original = children(routine, "STContent").find(is_original);
    original.or_else(|| child(routine, "STContent"))
}

/// Names the routines of Structured Text with pending edits.
pub(super) fn edits(owner: Node<'_, '_>, findings: &mut Vec<Finding>) {
    for routine in children(owner, "Routines").flat_map(|list| children(list, "Routine")) {
        if children(routine, "STContent").count() > 1 {
            let reason = "has pending edits; the text in force runs".to_owned();
            findings.push(Finding {
                program: owner.attribute("Name").map(str::to_owned),
                routine: routine.attribute("Name").map(str::to_owned),
                ..Finding::new(FindingKind::Error, "text", reason)
            });
        }
    }
}

fn is_of_safety(node: Node<'_, '_>) -> bool {
    node.attribute("Class") == Some("Safety")
}
