//! A project for people: its routines with the original text of their rungs and lines, names for the operands, the uses of a
//! tag, and the operands that a viewer watches ([`Monitor`]).
//!
//! Not here: drawing, and the scan, whose state [`Cell::sample`](crate::Cell::sample) shows.

mod uses;

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use arcline_instruction_set::{Kind as MotionKind, Mnemonic};

use crate::cell::{Names, program_scopes};
use crate::compile::{Compiler, Known, Owner};
use crate::error::{Finding, Line};
use crate::expression::{Expression, Step, TagReference};
use crate::monitor::Monitor;
use crate::rll::{Element, Instruction, Rung};
use crate::source::{Content, Project, RoutineSource, RungSource, Usage};
use crate::st::{Statement, StatementKind, Text};
use crate::table::{self, Kind};
use crate::{Directory, NoMachine};
pub use uses::Use;

/// A project that was loaded, for people.
#[derive(Debug)]
pub struct Listing {
    project: Project,
    known: Mutex<Known>,
    findings: Vec<Finding>,
    /// In the order of the compiled routines: those of add-on instructions, then those of programs.
    routines: Vec<(Owner, usize)>,
}

/// A routine.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ListedRoutine<'l> {
    /// Its number, by which [`Listing::rungs`] and [`Listing::monitor`] name it.
    pub number: u32,
    /// The program, or the add-on instruction.
    pub owner: &'l str,
    /// Whether the owner is an add-on instruction.
    pub is_add_on: bool,
    /// Its name.
    pub name: &'l str,
    /// Its language.
    pub language: Language<'l>,
    /// Rungs or lines.
    pub count: usize,
}

/// The language of a routine.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Language<'l> {
    /// Ladder.
    Ladder,
    /// Structured Text.
    Text,
    /// Another one, which does not run.
    Other(&'l str),
}

/// A rung.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ListedRung {
    /// Its number in the file.
    pub number: u32,
    /// Its comment; empty: none.
    pub comment: String,
    /// Its elements from left to right.
    pub elements: Vec<ListedElement>,
}

/// An element of a rung. Its condition is the index of a digit of [`MonitorSample::power`](crate::MonitorSample).
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum ListedElement {
    /// An instruction.
    Instruction {
        /// Its mnemonic as it is written.
        name: String,
        /// Its name in words.
        title: String,
        /// Its operands.
        operands: Vec<ListedOperand>,
        /// The index of its condition.
        condition: usize,
    },
    /// Legs from top to bottom.
    Branch {
        /// The legs.
        legs: Vec<Vec<ListedElement>>,
        /// The index of its condition.
        condition: usize,
    },
}

/// An operand.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ListedOperand {
    /// The name on the faceplate: `Source A`.
    pub name: String,
    /// The text in the project.
    pub text: String,
}

/// A line of Structured Text.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ListedLine {
    /// Its number in the file.
    pub number: u32,
    /// The line.
    pub text: String,
    /// The tags in it, each once.
    pub names: Vec<String>,
}

/// An operand as the instruction's row has it.
struct Described<'t> {
    name: String,
    text: &'t str,
    /// The tag or expression whose value it shows.
    value: Option<String>,
    is_written: bool,
}

impl Listing {
    /// The listing of a project, its names, and its parts that do not run.
    pub fn new(project: Project, names: Names, mut findings: Vec<Finding>) -> Self {
        let mut told = BTreeSet::new();
        findings.retain(|finding| told.insert(finding.to_string()));
        let add_ons = (0..).zip(&project.instructions);
        let add_ons =
            add_ons.flat_map(|(number, one)| (0..one.routines.len()).map(move |at| (Owner::AddOn(number), at)));
        let programs = (0..).zip(&project.programs);
        let programs =
            programs.flat_map(|(number, one)| (0..one.routines.len()).map(move |at| (Owner::Program(number), at)));
        Listing {
            routines: add_ons.chain(programs).collect(),
            known: Mutex::new(names.0),
            findings,
            project,
        }
    }

    /// The project.
    pub fn project(&self) -> &Project {
        &self.project
    }

    /// The parts of the project that do not run, each once.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// All routines, by their numbers.
    pub fn routines(&self) -> Vec<ListedRoutine<'_>> {
        let routines = (0..).zip(&self.routines).filter_map(|(number, (owner, _))| {
            let source = self.source(number)?;
            let (owner, is_add_on) = match owner {
                Owner::Program(at) => (self.project.programs.get(*at)?.name.as_str(), false),
                Owner::AddOn(at) => (self.project.instructions.get(*at)?.name.as_str(), true),
            };
            let (language, count) = match &source.content {
                Content::Ladder(rungs) => (Language::Ladder, rungs.iter().filter(|rung| is_in_force(rung)).count()),
                Content::Text(lines) => (Language::Text, lines.len()),
                Content::Other(words) => (Language::Other(words), 0),
            };
            Some(ListedRoutine {
                number,
                owner,
                is_add_on,
                name: &source.name,
                language,
                count,
            })
        });
        routines.collect()
    }

    /// The number of a routine of a program, or of an add-on instruction.
    pub fn routine(&self, owner: &str, name: &str) -> Option<u32> {
        let routines = self.routines();
        let found = routines
            .iter()
            .find(|one| one.owner.eq_ignore_ascii_case(owner) && one.name.eq_ignore_ascii_case(name));
        found.map(|one| one.number)
    }

    /// The instances of an add-on instruction in the tags of the controller and of programs, by their full names.
    pub fn instances(&self, add_on: &str) -> Vec<String> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let tags = known.tags.list.iter();
        let tags = tags.filter(|tag| tag.tag_type.data_type.name().eq_ignore_ascii_case(add_on));
        let tags = tags.filter(|tag| tag.tag_type.dimensions[0] == 0);
        tags.map(crate::Tag::full_name).take(MAX_INSTANCES).collect()
    }

    fn source(&self, routine: u32) -> Option<&RoutineSource> {
        let (owner, at) = self.routines.get(routine as usize)?;
        match owner {
            Owner::Program(number) => self.project.programs.get(*number)?.routines.get(*at),
            Owner::AddOn(number) => self.project.instructions.get(*number)?.routines.get(*at),
        }
    }

    /// The rungs in force of a routine.
    fn in_force(&self, routine: u32) -> impl Iterator<Item = &RungSource> {
        let rungs = match self.source(routine).map(|source| &source.content) {
            Some(Content::Ladder(rungs)) => rungs.as_slice(),
            _ => &[],
        };
        rungs.iter().filter(|rung| is_in_force(rung))
    }

    /// Rungs of a ladder routine, from an index on; one that is no rung has no elements.
    pub fn rungs(&self, routine: u32, from: usize, count: usize) -> Vec<ListedRung> {
        let rungs = self.in_force(routine).skip(from).take(count);
        let rungs = rungs.map(|source| {
            let rung = Rung::parse(&source.text).unwrap_or_default();
            let mut condition = 1;
            ListedRung {
                number: source.number,
                comment: source.comment.clone(),
                elements: self.elements(&rung.elements, &mut condition),
            }
        });
        rungs.collect()
    }

    fn elements(&self, elements: &[Element], condition: &mut usize) -> Vec<ListedElement> {
        let mut listed = Vec::with_capacity(elements.len());
        for element in elements {
            let one = match element {
                Element::Instruction(instruction) => {
                    let (title, operands) = self.described(instruction);
                    let operands = operands.into_iter().map(|one| ListedOperand {
                        name: one.name,
                        text: one.text.to_owned(),
                    });
                    ListedElement::Instruction {
                        name: instruction.name.clone(),
                        title,
                        operands: operands.collect(),
                        condition: *condition,
                    }
                }
                Element::Branch(legs) => {
                    let legs = legs.iter().map(|leg| self.elements(leg, condition)).collect();
                    ListedElement::Branch {
                        legs,
                        condition: *condition,
                    }
                }
            };
            *condition += 1;
            listed.push(one);
        }
        listed
    }

    /// Lines of a routine of Structured Text, from an index on.
    pub fn lines(&self, routine: u32, from: usize, count: usize) -> Vec<ListedLine> {
        let Some(Content::Text(lines)) = self.source(routine).map(|source| &source.content) else {
            return Vec::new();
        };
        let names = self.names_by_line(lines);
        let lines = lines.iter().zip(names).skip(from).take(count);
        let lines = lines.map(|((number, text), names)| ListedLine {
            number: *number,
            text: text.clone(),
            names,
        });
        lines.collect()
    }

    /// The tags that each line of a text names.
    fn names_by_line(&self, lines: &[(u32, String)]) -> Vec<Vec<String>> {
        let mut names = vec![Vec::new(); lines.len()];
        let (text, starts) = joined(lines);
        let Ok(text) = Text::parse(&text) else { return names };
        visit(&text.statements, &mut |reference, at, _| {
            let line = starts.partition_point(|start| *start <= at).saturating_sub(1);
            let written = reference.to_string();
            if let Some(names) = names.get_mut(line)
                && names.len() < MAX_NAMES
                && !names.contains(&written)
            {
                names.push(written);
            }
        });
        names
    }

    /// The operands to sample of rungs or lines of a routine. The values of an add-on instruction's routine are those of an instance, by
    /// its full name; without an instance there are none.
    pub fn monitor(&self, routine: u32, from: usize, count: usize, instance: Option<&str>) -> Monitor {
        let texts: Vec<Vec<Option<String>>> = match self.source(routine).map(|source| &source.content) {
            Some(Content::Ladder(_)) => {
                let rungs = self.in_force(routine).skip(from).take(count);
                rungs.map(|rung| self.values_of(rung)).collect()
            }
            Some(Content::Text(lines)) => {
                let names = self.names_by_line(lines).into_iter().skip(from).take(count);
                names.map(|names| names.into_iter().map(Some).collect()).collect()
            }
            _ => Vec::new(),
        };
        let owner = self.routines.get(routine as usize).map(|(owner, _)| *owner);
        self.with_compiler(|compiler| {
            let instance = instance.and_then(|name| {
                let Some(Owner::AddOn(number)) = owner else { return None };
                let reference = Expression::parse_reference(&program_scopes(name)).ok()?;
                compiler.owner = Owner::Program(usize::MAX);
                let definition = self.project.instructions.get(number)?;
                compiler.instance(&reference, &definition.name)
            });
            let in_out = match owner {
                Some(Owner::AddOn(number)) => self.in_out(number),
                _ => Vec::new(),
            };
            let has_values = matches!(owner, Some(Owner::Program(_))) || instance.is_some();
            compiler.owner = owner.unwrap_or(Owner::Program(usize::MAX));
            let mut monitored = |text: Option<String>| {
                let expression = Expression::parse(&text.filter(|_| has_values)?).ok()?;
                let mut is_open = false;
                references(&expression, &mut |one| {
                    is_open |= in_out.contains(&one.name.to_ascii_lowercase())
                });
                if is_open { None } else { compiler.monitored(&expression) }
            };
            let rows = texts
                .into_iter()
                .map(|row| row.into_iter().map(&mut monitored).collect());
            let rows = rows.collect();
            Monitor {
                routine,
                from,
                rows,
                instance,
                code: std::mem::take(&mut compiler.code),
            }
        })
    }

    /// The parameters by reference of an add-on instruction, in lower case.
    fn in_out(&self, number: usize) -> Vec<String> {
        let parameters = self
            .project
            .instructions
            .get(number)
            .map(|one| one.parameters.as_slice());
        let parameters = parameters
            .unwrap_or_default()
            .iter()
            .filter(|one| one.usage == Usage::InOut);
        parameters.map(|one| one.member.name.to_ascii_lowercase()).collect()
    }

    /// The operands of a rung whose values are shown, in their order.
    fn values_of(&self, rung: &RungSource) -> Vec<Option<String>> {
        let mut values = Vec::new();
        if let Ok(rung) = Rung::parse(&rung.text) {
            rung.visit(&mut |instruction| {
                let (_, operands) = self.described(instruction);
                values.extend(operands.into_iter().map(|one| one.value));
            });
        }
        values
    }

    /// The title of an instruction, and its operands with their names.
    fn described<'t>(&self, instruction: &'t Instruction) -> (String, Vec<Described<'t>>) {
        let given: Vec<&'t str> = instruction.operands().iter().map(|one| one.text.as_str()).collect();
        let add_on = self
            .project
            .instructions
            .iter()
            .find(|one| one.name.eq_ignore_ascii_case(&instruction.name));
        if let Some(add_on) = add_on {
            let required = add_on
                .parameters
                .iter()
                .filter(|one| one.is_required || one.usage == Usage::InOut);
            let names = required.map(|one| (one.member.name.clone(), one.usage != Usage::Input));
            let names = std::iter::once((add_on.name.clone(), true)).chain(names);
            let operands = given.iter().zip(names);
            let operands = operands.map(|(text, (name, is_written))| Described::plain(name, text, is_written));
            return (add_on.name.clone(), operands.collect());
        }
        if let Ok(mnemonic) = instruction.name.to_ascii_uppercase().parse::<Mnemonic>() {
            let of = mnemonic.instruction();
            let ignored = of.ignored_operand().filter(|_| given.len() == of.operands.len() + 1);
            let mut rows = of.operands.iter();
            let operands = given.iter().enumerate().filter_map(|(index, text)| {
                if Some(index) == ignored {
                    return Some(Described::plain(String::new(), text, false));
                }
                let row = rows.next()?;
                let is_written = matches!(row.kind, MotionKind::MotionControl);
                Some(Described::plain(row.name.to_owned(), text, is_written))
            });
            return (of.title.to_owned(), operands.collect());
        }
        let Some(row) = table::row(&instruction.name) else {
            let operands = given.iter().map(|text| Described::plain(String::new(), text, false));
            return (String::new(), operands.collect());
        };
        let structure = row.operands.iter().zip(&given);
        let structure = structure
            .filter(|((_, kind), _)| matches!(kind, Kind::Structure(_)))
            .map(|(_, text)| *text)
            .next();
        let operands = given
            .iter()
            .enumerate()
            .map(|(index, text)| match row.operands.get(index) {
                Some((name, kind)) => Described::of_row(name, *kind, text, structure),
                None => Described::plain("Parameter".to_owned(), text, false),
            });
        (row.title.to_owned(), operands.collect())
    }

    /// Uses a compiler that knows the names of the project.
    fn with_compiler<R>(&self, work: impl FnOnce(&mut Compiler<'_>) -> R) -> R {
        let mut machine = NoMachine;
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let directory: &mut dyn Directory = &mut machine;
        let mut compiler = Compiler::with_names(&self.project, directory, std::mem::take(&mut *known));
        let result = work(&mut compiler);
        *known = Known {
            types: compiler.types,
            tags: compiler.tags,
        };
        result
    }
}

impl<'t> Described<'t> {
    fn plain(name: String, text: &'t str, is_written: bool) -> Self {
        Described {
            name,
            text,
            value: Some(text.to_owned()),
            is_written,
        }
    }

    fn of_row(name: &'static str, kind: Kind, text: &'t str, structure: Option<&str>) -> Self {
        let shown = kind.shown_member(name).zip(structure);
        let value = match kind {
            Kind::Shown => shown.map(|(member, structure)| format!("{structure}.{member}")),
            Kind::Routine | Kind::Label | Kind::Task | Kind::Name | Kind::Word(_) => None,
            _ => Some(text.to_owned()),
        };
        let is_written = match kind {
            Kind::OutBit | Kind::Target | Kind::MoveTarget | Kind::TextTarget | Kind::Structure(_) => true,
            Kind::Data => name == "Dest" || name == "Array",
            _ => false,
        };
        Described {
            name: name.to_owned(),
            text,
            value,
            is_written,
        }
    }
}

/// The rungs that run: a pending edit does not.
fn is_in_force(rung: &RungSource) -> bool {
    matches!(rung.kind.as_str(), "N" | "" | "D" | "R")
}

/// The lines of a text as one, and the first byte of each.
fn joined(lines: &[(u32, String)]) -> (String, Vec<usize>) {
    let mut text = String::new();
    let mut starts = Vec::with_capacity(lines.len());
    for (_, line) in lines {
        starts.push(text.len());
        text.push_str(line);
        text.push('\n');
    }
    (text, starts)
}

/// Calls `found` with every reference of an expression, those in subscripts too.
fn references(expression: &Expression, found: &mut dyn FnMut(&TagReference)) {
    match expression {
        Expression::Integer(_) | Expression::Real(_) | Expression::Text(_) => {}
        Expression::Reference(reference) => {
            found(reference);
            inner_references(reference, found);
        }
        Expression::Unary(_, operand) => references(operand, found),
        Expression::Binary(_, operands) => {
            references(&operands.0, found);
            references(&operands.1, found);
        }
        Expression::Call(_, arguments) => arguments.iter().for_each(|one| references(one, found)),
    }
}

fn inner_references(reference: &TagReference, found: &mut dyn FnMut(&TagReference)) {
    for step in &reference.steps {
        match step {
            Step::Index(values) => values.iter().for_each(|one| references(one, found)),
            Step::BitAt(value) => references(value, found),
            Step::Member(_) | Step::Bit(_) => {}
        }
    }
}

/// Calls `found` with every reference of statements, its byte in the text, and whether it is written.
fn visit(statements: &[Statement], found: &mut dyn FnMut(&TagReference, usize, bool)) {
    for statement in statements {
        let mut read = |expression: &Expression| references(expression, &mut |one| found(one, one.at, false));
        match &statement.kind {
            StatementKind::Assign { target, value, .. } => {
                read(value);
                found(target, target.at, true);
                inner_references(target, &mut |one| found(one, one.at, false));
            }
            StatementKind::If(branches, otherwise) => {
                for (condition, body) in branches {
                    references(condition, &mut |one| found(one, one.at, false));
                    visit(body, found);
                }
                visit(otherwise, found);
            }
            StatementKind::Case(selector, arms, otherwise) => {
                read(selector);
                arms.iter().for_each(|arm| visit(&arm.body, found));
                visit(otherwise, found);
            }
            StatementKind::For {
                variable,
                from,
                to,
                by,
                body,
            } => {
                [Some(from), Some(to), by.as_ref()]
                    .into_iter()
                    .flatten()
                    .for_each(&mut read);
                found(variable, variable.at, true);
                visit(body, found);
            }
            StatementKind::While(condition, body) | StatementKind::Repeat(body, condition) => {
                read(condition);
                visit(body, found);
            }
            StatementKind::Call(name, operands) => {
                let row = table::row(name).map(|row| row.operands).unwrap_or_default();
                for (index, operand) in operands.iter().enumerate() {
                    let Ok(expression) = Expression::parse(&operand.text) else {
                        continue;
                    };
                    let is_written = row
                        .get(index)
                        .is_some_and(|(name, kind)| Described::of_row(name, *kind, &operand.text, None).is_written);
                    references(&expression, &mut |one| found(one, operand.at + one.at, is_written));
                }
            }
            StatementKind::Exit | StatementKind::Return | StatementKind::Empty => {}
        }
    }
}

/// A rung or line by its number, in words of its language.
fn line_of(is_text: bool, number: u32) -> Line {
    if is_text {
        Line::Text(number)
    } else {
        Line::Rung(number)
    }
}

/// Tags of a line of text whose values are shown.
const MAX_NAMES: usize = 8;
/// Instances of an add-on instruction that are listed.
const MAX_INSTANCES: usize = 200;
