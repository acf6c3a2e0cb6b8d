//! Defects of a project's structure: names of programs, routines and labels that lead nowhere, or to two places.

use std::collections::BTreeMap;

use super::Compiler;
use crate::error::{Finding, FindingKind, Line};
use crate::rll;
use crate::source::Trigger;

impl Compiler<'_> {
    /// Names tasks and programs that lead nowhere. A program that no task runs may be a part of another project.
    pub(super) fn structure(&mut self) {
        let project = self.project;
        let program_of = |name: &str| project.programs.iter().find(|one| one.name.eq_ignore_ascii_case(name));
        let mut continuous: Option<&str> = None;
        let mut programs = Vec::new();
        for (number, task) in project.tasks.iter().enumerate() {
            for name in &task.programs {
                match program_of(name) {
                    Some(program) => programs.push(program),
                    None => {
                        let reason = format!("there is no program {name}, which it runs");
                        self.findings.push(Finding::new(FindingKind::Task, &task.name, reason));
                    }
                }
            }
            if task.trigger != Trigger::Continuous {
                continue;
            }
            match continuous {
                None => continuous = Some(&task.name),
                Some(first) => {
                    let reason = format!("it does not run, since {first} is continuous too");
                    self.findings.push(Finding::new(FindingKind::Task, &task.name, reason));
                    if let Some(task) = self.code.tasks.get_mut(number) {
                        task.is_inhibited = true;
                    }
                }
            }
        }
        if let Some(name) = &project.fault_handler {
            match program_of(name) {
                Some(program) => programs.push(program),
                None => {
                    let reason = "there is no such program, which is to handle major faults".to_owned();
                    self.findings.push(Finding::new(FindingKind::Program, name, reason));
                }
            }
        }
        for program in programs {
            let names = [(&program.main, "main"), (&program.fault, "fault")];
            for (name, role) in names
                .into_iter()
                .filter_map(|(name, role)| Some((name.as_ref()?, role)))
            {
                if !program.routines.iter().any(|one| one.name.eq_ignore_ascii_case(name)) {
                    let reason = format!("there is no routine {name}, its {role} routine");
                    let finding = Finding::new(FindingKind::Program, &program.name, reason);
                    if !self.findings.contains(&finding) {
                        self.findings.push(finding);
                    }
                }
            }
        }
    }

    /// The rungs of a routine by their labels, in lower case.
    pub(super) fn labels_of(&mut self, rungs: &[(u32, rll::Rung)]) -> BTreeMap<String, u32> {
        let mut labels = BTreeMap::new();
        let mut twice = Vec::new();
        for (place, (number, rung)) in rungs.iter().enumerate() {
            rung.visit(&mut |one| {
                if one.name.eq_ignore_ascii_case("LBL")
                    && let Some(label) = one.operands().first()
                    && labels.insert(label.text.to_ascii_lowercase(), place as u32).is_some()
                {
                    twice.push((*number, label.text.clone()));
                }
            });
        }
        for (number, label) in twice {
            self.place = Some(Line::Rung(number));
            self.find(
                FindingKind::Error,
                "LBL",
                &format!("another rung has the label {label} too"),
            );
        }
        labels
    }
}
