//! A project that is bound to a machine: what keeps it from running, and what a configuration puts around it.

use std::fmt;

use arcline_config::ControllerConfig;
use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_routine::source::{Answer, Project, Wire};
use arcline_routine::{Cell, Finding, FindingKind, Loaded};

use crate::names::{Names, NotPlaced, Places};

/// The treatment of instructions, routines and tasks that do not run, and of what names a tag that is not there.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum UnknownParts {
    /// The project is refused, and they are named.
    Refused,
    /// They are named and passed over.
    Allowed,
}

impl UnknownParts {
    /// Whether a finding keeps a project from running. A tag of an unknown type, or of a module without data, is left out: what
    /// names it does not compile.
    fn are_blocked_by(self, finding: &Finding) -> bool {
        match finding.kind {
            FindingKind::Error => true,
            FindingKind::Type | FindingKind::Module | FindingKind::Shared | FindingKind::FirstNumber => false,
            _ => self == UnknownParts::Refused,
        }
    }
}

/// A project whose tags are tags of a machine.
#[derive(Debug)]
pub struct Bound {
    /// The project.
    pub cell: Cell,
    /// The positions of its tags.
    pub places: Places,
    /// The parts that do not run.
    pub findings: Vec<Finding>,
    /// The names of its tags and types.
    pub names: arcline_routine::Names,
}

/// The reason for which a project does not run on a machine.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum LoadError {
    /// Parts of it do not run.
    #[error(transparent)]
    Parts(#[from] DoesNotRun),
    /// A tag cannot be one of the machine.
    #[error(transparent)]
    Tag(#[from] NotPlaced),
}

/// The parts for which a project is refused.
#[derive(Clone, PartialEq, Debug)]
pub struct DoesNotRun {
    /// Everything that does not run, also what would be passed over.
    pub findings: Vec<Finding>,
    unknown_parts: UnknownParts,
}

impl DoesNotRun {
    /// The findings that keep the project from running.
    pub fn blocking(&self) -> impl Iterator<Item = &Finding> {
        self.findings
            .iter()
            .filter(|finding| self.unknown_parts.are_blocked_by(finding))
    }

    /// The first one and their number.
    pub fn summary(&self) -> String {
        let first = self.blocking().next().map_or_else(String::new, Finding::to_string);
        format!("{first}; {} parts of the project do not run", self.blocking().count())
    }
}

impl fmt::Display for DoesNotRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.summary())?;
        for finding in self.blocking().skip(1).take(SHOWN) {
            write!(f, "\n  {finding}")?;
        }
        Ok(())
    }
}

impl std::error::Error for DoesNotRun {}

/// Loads a project on a machine, and makes its tags tags of the machine.
///
/// # Errors
/// Parts of it do not run, or a tag has no place.
pub fn bind(
    machine: &Machine,
    image: &mut Image,
    source: &Project,
    unknown_parts: UnknownParts,
) -> Result<Bound, LoadError> {
    let mut directory = Names::new(machine, image);
    let Loaded {
        mut cell,
        findings,
        names,
    } = arcline_routine::load(source, &mut directory);
    if findings.iter().any(|finding| unknown_parts.are_blocked_by(finding)) {
        return Err(LoadError::Parts(DoesNotRun {
            findings,
            unknown_parts,
        }));
    }
    let places = directory.place(&mut cell, source)?;
    Ok(Bound {
        cell,
        places,
        findings,
        names,
    })
}

/// The parts of a project that do not run, for a log: the first ones, and the number of the others.
pub fn told(findings: &[Finding]) -> impl Iterator<Item = String> {
    let first = findings.iter().take(TOLD).map(Finding::to_string);
    let more = findings.len().saturating_sub(TOLD);
    let rest = format!("{more} further parts do not run; arcline-server import --report lists them");
    first.chain((more > 0).then_some(rest))
}

/// The surroundings that a configuration gives a program.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Surroundings {
    /// The answers to its messages.
    answers: Vec<Answer>,
    wires: Vec<Wire>,
}

impl Surroundings {
    /// Those of a configuration.
    pub fn of(controller: &ControllerConfig) -> Self {
        let answers = controller.messages.iter().map(|row| Answer {
            service: row.service,
            class: row.class,
            instance: row.instance,
            attribute: row.attribute,
            data: row.answer.clone(),
            delay_ms: row.delay_ms,
            error: row.error,
        });
        let wires = controller.wires.iter().map(|wire| Wire {
            from: wire.from.clone(),
            to: wire.to.clone(),
            delay_ms: wire.delay_ms,
        });
        Surroundings {
            answers: answers.collect(),
            wires: wires.collect(),
        }
    }

    /// Gives them to the program.
    pub fn surround(&self, source: &mut Project) {
        source.answers.clone_from(&self.answers);
        source.wires.clone_from(&self.wires);
    }
}

/// Findings that a log shows.
const TOLD: usize = 50;
/// Further findings that an error shows.
const SHOWN: usize = 20;
