//! Programs and tasks that do not run as what they are: those of safety, and equipment phases (spec/programs.md §20). Loading names them, and
//! passes over them.

use arcline_routine::source::{ProgramSource, TaskSource};
use arcline_routine::{Finding, FindingKind};
use roxmltree::Node;

/// A program, or its tags alone when its rungs need another controller.
pub(super) fn program(node: Node<'_, '_>, program: ProgramSource, findings: &mut Vec<Finding>) -> ProgramSource {
    let reason = match node.attribute("Type").unwrap_or("Normal") {
        _ if is_of_safety(node) => "a program of safety is not supported".to_owned(),
        "Normal" | "" => return program,
        "EquipmentPhase" => "an equipment phase is not supported".to_owned(),
        other => format!("a program of the type {other} is not supported"),
    };
    findings.push(finding(FindingKind::Program, &program.name, reason));
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
    findings.push(finding(FindingKind::Task, &task.name, reason));
    None
}

fn is_of_safety(node: Node<'_, '_>) -> bool {
    node.attribute("Class") == Some("Safety")
}

fn finding(kind: FindingKind, name: &str, reason: String) -> Finding {
    Finding {
        kind,
        name: name.to_owned(),
        reason,
        program: None,
        routine: None,
        place: None,
    }
}
