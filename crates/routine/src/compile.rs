//! From a project to [`Code`]: names become addresses, types are checked, and each part that does not run becomes a [`Finding`].

mod add_on;
mod call;
mod expression;
mod first_numbers;
mod fit;
mod message;
mod motion;
mod operand;
mod parameters;
mod reference;
mod statement;
mod structure;
mod system;
mod wire;
mod wrong;

pub(crate) use expression::status_of;
pub(crate) use wrong::Wrong;

use std::collections::BTreeMap;

use arcline_instruction_set::{ControlSlot, Object};
use arcline_tag::TagType;

use self::first_numbers::FirstNumbers;
use crate::code::{Body, Code, FIRST_TEXTS, Program, Routine, Rung, Select, Task, TextId, When};
use crate::error::{Finding, FindingKind, Line};
use crate::expression::Expression;
use crate::memory::Tags;
use crate::rll;
use crate::source::{Content, Project, RoutineSource, Trigger};
use crate::st;
use crate::types::Types;

/// Knows the machine when a project is loaded.
pub trait Directory {
    /// The type of an axis, a coordinate system or the group of that name.
    fn object_type(&self, name: &str) -> Option<TagType>;
    /// Index of a motion object.
    fn object(&self, object: Object, name: &str) -> Option<u16>;
    /// Whether the host executes instructions of motion.
    fn has_motion(&self) -> bool {
        true
    }
    /// The slot of a MOTION_INSTRUCTION by the name of its tag, or a new one.
    fn control(&mut self, name: &str) -> Option<ControlSlot>;
    /// The id of a tag that instructions of motion name as a whole: a path, a cam, an array that is written.
    fn tag(&mut self, name: &str, tag_type: &TagType) -> Option<u32>;
    /// The value of an attribute of a motion object that does not change while the machine runs, for GSV.
    fn constant(&self, _object: Object, _index: u16, _name: &str) -> Option<f64> {
        None
    }
    /// The number of an input of an axis that a wire leads to, such as `X.home_switch`; `None`: it is none.
    fn axis_input(&mut self, _text: &str) -> Option<u32> {
        None
    }
    /// The number of an attribute of a motion object, for GSV and SSV, and its size, bytes.
    fn attribute(&mut self, object: Object, index: u16, name: &str) -> Option<(u32, usize)>;
    /// Whether SSV can set the attribute of this number.
    fn is_settable(&self, _attribute: u32) -> bool {
        false
    }
}

/// The types of a project and the names of its tags.
#[derive(Debug, Default)]
pub(crate) struct Known {
    pub(crate) types: Types,
    pub(crate) tags: Tags,
}

/// The owner of a routine.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Owner {
    Program(usize),
    AddOn(usize),
}

/// The parsed content of a routine.
enum Parsed {
    /// Number and rung.
    Ladder(Vec<(u32, rll::Rung)>),
    /// The text, and the number of each of its lines.
    Text(st::Text, Vec<u32>),
    Missing,
}

/// A project that is being compiled.
pub(crate) struct Compiler<'p> {
    pub(crate) project: &'p Project,
    pub(crate) types: Types,
    pub(crate) tags: Tags,
    pub(crate) code: Code,
    pub(crate) findings: Vec<Finding>,
    pub(crate) directory: &'p mut dyn Directory,
    texts: BTreeMap<String, TextId>,
    /// Routines by owner and name in lower case.
    pub(crate) routines: BTreeMap<(Owner, String), u32>,
    parsed: Vec<Parsed>,
    owners: Vec<Owner>,
    /// The owner of the routine that is compiled.
    pub(crate) owner: Owner,
    routine: String,
    place: Option<Line>,
    /// Rungs by label, of the routine.
    labels: BTreeMap<String, u32>,
    /// Whether Structured Text is compiled.
    pub(crate) is_text: bool,
    /// Objects of motion by their first byte.
    pub(crate) objects: Vec<(u32, Object, u16)>,
    /// Motion control tags by their first byte.
    pub(crate) controls: Vec<(u32, ControlSlot)>,
    /// Tags that instructions of motion take as a whole: index and the host's id.
    pub(crate) shared: BTreeMap<usize, u32>,
    /// Whether a routine reads the carry, which costs time.
    pub(crate) uses_carry: bool,
    first_numbers: FirstNumbers,
}

impl<'p> Compiler<'p> {
    pub(crate) fn new(project: &'p Project, directory: &'p mut dyn Directory) -> Self {
        let mut types = Types::new(project);
        let of_type = |(name, reason): &(String, String)| Finding::new(FindingKind::Type, name, reason.clone());
        let mut findings: Vec<Finding> = types.wrong.iter().map(of_type).collect();
        findings.extend(project.outside.iter().map(|one| Finding {
            kind: FindingKind::Module,
            ..of_type(one)
        }));
        findings.extend(project.findings.iter().cloned());
        let tags = Tags::new(project, &mut types, &|name| directory.object_type(name), &mut findings);
        let mut compiler = Compiler::with_names(project, directory, Known { types, tags });
        compiler.findings = findings;
        compiler.code.uses_flags = names_status(project, &["S:V", "S:Z", "S:N", "S:C"]);
        compiler.uses_carry = compiler.code.uses_flags && names_status(project, &["S:C"]);
        compiler.motion_objects();
        compiler
    }

    /// A compiler for single operands of a project whose names are known.
    pub(crate) fn with_names(project: &'p Project, directory: &'p mut dyn Directory, known: Known) -> Self {
        let Known { types, tags } = known;
        let mut compiler = Compiler {
            project,
            types,
            tags,
            code: Code::default(),
            findings: Vec::new(),
            directory,
            texts: BTreeMap::new(),
            routines: BTreeMap::new(),
            parsed: Vec::new(),
            owners: Vec::new(),
            owner: Owner::Program(0),
            routine: String::new(),
            place: None,
            labels: BTreeMap::new(),
            is_text: false,
            objects: Vec::new(),
            controls: Vec::new(),
            shared: BTreeMap::new(),
            uses_carry: false,
            first_numbers: FirstNumbers::default(),
        };
        for text in FIRST_TEXTS {
            compiler.text(text);
        }
        compiler
    }

    pub(crate) fn compile(&mut self) {
        let project = self.project;
        for (number, add_on) in project.instructions.iter().enumerate() {
            if add_on.is_encoded {
                self.owner = Owner::AddOn(number);
                self.routine.clear();
                self.find(FindingKind::Routine, &add_on.name, "its content is encoded");
            }
            self.declare(Owner::AddOn(number), &add_on.routines);
        }
        for (number, program) in project.programs.iter().enumerate() {
            self.declare(Owner::Program(number), &program.routines);
        }
        for number in 0..project.instructions.len() {
            let add_on = self.add_on(number);
            self.code.add_ons.push(add_on);
        }
        for number in 0..self.parsed.len() {
            self.routine_body(number);
        }
        self.write_first_numbers();
        for (number, program) in project.programs.iter().enumerate() {
            self.owner = Owner::Program(number);
            self.routine.clear();
            self.place = None;
            let main = program.main.as_deref().and_then(|name| self.routine_id(name));
            let fault = program.fault.as_deref().and_then(|name| self.routine_id(name));
            let name = self.text(&program.name);
            self.code.programs.push(Program {
                name,
                main,
                fault,
                is_disabled: program.is_disabled,
                before: None,
                behind: None,
            });
        }
        let program_of = |name: &str| {
            project
                .programs
                .iter()
                .position(|one| one.name.eq_ignore_ascii_case(name))
        };
        self.code.fault_handler = project
            .fault_handler
            .as_deref()
            .and_then(program_of)
            .and_then(|place| u32::try_from(place).ok());
        for task in &project.tasks {
            self.owner = Owner::Program(usize::MAX);
            let timeout = match &task.trigger {
                Trigger::Event(_, Some(ms)) => Some((ms * 1e6).round().max(1.0) as u64),
                _ => None,
            };
            let when = match &task.trigger {
                Trigger::Continuous => When::Continuous,
                Trigger::Periodic(ms) => When::Periodic((ms * 1e6).round().max(1.0) as u64),
                Trigger::Event(trigger, _) if trigger.eq_ignore_ascii_case("Motion Group Execution") => When::Motion,
                Trigger::Event(trigger, _) => self.event(trigger, &task.event_tag).unwrap_or_else(|| {
                    if !trigger.is_empty() && !trigger.eq_ignore_ascii_case("EVENT Instruction Only") {
                        self.findings.push(Finding {
                            kind: FindingKind::Task,
                            name: task.name.clone(),
                            reason: format!(
                                "the trigger {trigger} of {:?} is not supported, only EVENT runs it",
                                task.event_tag
                            ),
                            program: None,
                            routine: None,
                            place: None,
                        });
                    }
                    When::Triggered
                }),
            };
            let programs = task.programs.iter().filter_map(|name| program_of(name));
            let name = self.text(&task.name);
            self.code.tasks.push(Task {
                name,
                when,
                timeout,
                priority: task.priority,
                watchdog_us: (task.watchdog_ms * 1e3) as i32,
                is_inhibited: task.is_inhibited,
                programs: programs.map(|place| place as u32).collect(),
            });
        }
        self.structure();
        self.connections();
        self.wires();
    }

    /// The event of a task; `None`: there is none but EVENT.
    fn event(&mut self, trigger: &str, tag: &str) -> Option<When> {
        let word: String = trigger.chars().filter(|letter| !letter.is_whitespace()).collect();
        let bit = match word.to_ascii_lowercase().as_str() {
            "axishome" => "HomeEventStatus",
            "axiswatch" => "WatchEventStatus",
            "axisregistration1" => "RegEvent1Status",
            "axisregistration2" => "RegEvent2Status",
            "moduleinputdatastatechange" => {
                let area = self.area_of(tag).ok()?;
                let from = area.place.fixed()?;
                let length = if area.is_whole { area.length } else { 1 };
                let to = from + area.size * length;
                return Some(When::Change { from, to });
            }
            _ => return None,
        };
        let reference = Expression::parse_reference(&format!("{tag}.{bit}")).ok()?;
        let bit = self.resolve(&reference).ok()?.as_bit()?;
        match (bit.select, bit.place.fixed()) {
            (Select::Mask(mask), Some(at)) => Some(When::Bit { at, mask }),
            _ => None,
        }
    }

    /// Parses the routines of an owner, and numbers them.
    fn declare(&mut self, owner: Owner, routines: &[RoutineSource]) {
        for source in routines {
            self.owner = owner;
            self.routine.clone_from(&source.name);
            self.place = None;
            let number = self.parsed.len() as u32;
            self.routines.insert((owner, source.name.to_ascii_lowercase()), number);
            let parsed = self.parse(source);
            self.parsed.push(parsed);
            self.owners.push(owner);
            let name = self.text(&source.name);
            let program = self.text(&self.owner_name());
            let of_program = match owner {
                Owner::Program(number) => u32::try_from(number).ok(),
                Owner::AddOn(_) => None,
            };
            self.code.routines.push(Routine {
                name,
                program,
                of_program,
                first_step: None,
                body: Body::Ladder(Box::default()),
            });
        }
    }

    fn parse(&mut self, source: &RoutineSource) -> Parsed {
        match &source.content {
            Content::Ladder(rungs) => {
                let mut parsed = Vec::new();
                for rung in rungs {
                    self.place = Some(Line::Rung(rung.number));
                    match rung.kind.as_str() {
                        // In force: a rung that a pending edit replaces or deletes stays until the edit is accepted.
                        "N" | "" => {}
                        "D" | "R" => {
                            self.find(FindingKind::Error, "rung", "has a pending edit; the rung in force runs")
                        }
                        _ => {
                            self.find(FindingKind::Error, "rung", "is a pending edit, which does not run");
                            continue;
                        }
                    }
                    match rll::Rung::parse(&rung.text) {
                        Ok(read) => parsed.push((rung.number, read)),
                        Err(error) => {
                            let words = error.to_string();
                            let beginning = rung.text.chars().skip(error.at().saturating_sub(10)).take(30);
                            let beginning: String = beginning.collect();
                            self.find(FindingKind::Error, &beginning, &words);
                        }
                    }
                }
                Parsed::Ladder(parsed)
            }
            Content::Text(lines) => {
                let text: Vec<&str> = lines.iter().map(|(_, text)| text.as_str()).collect();
                let numbers = lines.iter().map(|(number, _)| *number).collect();
                match st::Text::parse(&text.join("\n")) {
                    Ok(text) => Parsed::Text(text, numbers),
                    Err(error) => {
                        let before = text.join("\n");
                        let line = before.bytes().take(error.at()).filter(|byte| *byte == b'\n').count();
                        self.place = lines.get(line).map(|(number, _)| Line::Text(*number));
                        self.find(
                            FindingKind::Error,
                            text.get(line).copied().unwrap_or_default(),
                            &error.to_string(),
                        );
                        Parsed::Missing
                    }
                }
            }
            Content::Other(language) => {
                let words = format!("{language} is not supported");
                let name = source.name.clone();
                self.find(FindingKind::Routine, &name, &words);
                Parsed::Missing
            }
        }
    }

    fn routine_body(&mut self, number: usize) {
        let Some(slot) = self.parsed.get_mut(number) else {
            return;
        };
        let parsed = std::mem::replace(slot, Parsed::Missing);
        self.owner = self.owners.get(number).copied().unwrap_or(Owner::Program(0));
        self.routine = self
            .code
            .routines
            .get(number)
            .map_or_else(String::new, |one| self.code.text(one.name).to_owned());
        let body = match &parsed {
            Parsed::Ladder(rungs) => {
                self.is_text = false;
                self.labels = self.labels_of(rungs);
                let mut compiled = Vec::with_capacity(rungs.len());
                for (number, rung) in rungs {
                    self.place = Some(Line::Rung(*number));
                    let nodes = self.nodes(&rung.elements);
                    compiled.push(Rung::new(*number, nodes));
                }
                Body::Ladder(compiled.into())
            }
            Parsed::Text(text, numbers) => {
                self.is_text = true;
                self.labels.clear();
                Body::Text(self.statements(&text.statements, &Lines::new(&text.source, numbers)))
            }
            Parsed::Missing => Body::Ladder(Box::default()),
        };
        if let Some(slot) = self.parsed.get_mut(number) {
            *slot = parsed;
        }
        if let Some(routine) = self.code.routines.get_mut(number) {
            routine.body = body;
        }
    }

    /// The id of a routine of the present owner.
    pub(crate) fn routine_id(&self, name: &str) -> Option<u32> {
        self.routines.get(&(self.owner, name.to_ascii_lowercase())).copied()
    }

    /// The operands of the first SBR or RET of a routine.
    pub(crate) fn operands_of(&self, routine: u32, name: &str) -> Option<Vec<String>> {
        match self.parsed.get(routine as usize)? {
            Parsed::Ladder(rungs) => {
                let mut found = None;
                for (_, rung) in rungs {
                    rung.visit(&mut |one| {
                        if found.is_none() && one.name.eq_ignore_ascii_case(name) {
                            found = Some(one.operands().iter().map(|operand| operand.text.clone()).collect());
                        }
                    });
                }
                found
            }
            Parsed::Text(text, _) => text.statements.iter().find_map(|statement| match &statement.kind {
                st::StatementKind::Call(called, operands) if called.eq_ignore_ascii_case(name) => {
                    Some(operands.iter().map(|operand| operand.text.clone()).collect())
                }
                _ => None,
            }),
            Parsed::Missing => None,
        }
    }

    pub(crate) fn label(&self, name: &str) -> Option<u32> {
        self.labels.get(&name.to_ascii_lowercase()).copied()
    }

    pub(crate) fn set_line(&mut self, line: Line) {
        self.place = Some(line);
    }

    /// The number of a text for messages.
    pub(crate) fn text(&mut self, text: &str) -> TextId {
        if let Some(id) = self.texts.get(text) {
            return *id;
        }
        let id = self.code.texts.len() as TextId;
        self.code.texts.push(text.to_owned());
        self.texts.insert(text.to_owned(), id);
        id
    }

    fn owner_name(&self) -> String {
        let name = match self.owner {
            Owner::Program(number) => self.project.programs.get(number).map(|one| &one.name),
            Owner::AddOn(number) => self.project.instructions.get(number).map(|one| &one.name),
        };
        name.cloned().unwrap_or_default()
    }

    /// Notes a part that does not run.
    pub(crate) fn find(&mut self, kind: FindingKind, name: &str, reason: &str) {
        let finding = Finding {
            kind,
            name: name.to_owned(),
            reason: reason.to_owned(),
            program: Some(self.owner_name()),
            routine: (!self.routine.is_empty()).then(|| self.routine.clone()),
            place: self.place,
        };
        if self.findings.len() < MAX_FINDINGS && !self.findings.contains(&finding) {
            self.findings.push(finding);
        }
    }
}

/// Whether a routine of a project names one of these status bits.
fn names_status(project: &Project, bits: &[&str]) -> bool {
    let is_one = |word: &[u8]| bits.iter().any(|bit| word.eq_ignore_ascii_case(bit.as_bytes()));
    let names_one = |text: &str| text.as_bytes().windows(3).any(is_one);
    let programs = project.programs.iter().flat_map(|one| &one.routines);
    let add_ons = project.instructions.iter().flat_map(|one| &one.routines);
    programs.chain(add_ons).any(|routine| match &routine.content {
        Content::Ladder(rungs) => rungs.iter().any(|rung| names_one(&rung.text)),
        Content::Text(lines) => lines.iter().any(|(_, text)| names_one(text)),
        Content::Other(_) => false,
    })
}

/// The lines of a text by byte.
pub(crate) struct Lines<'n> {
    starts: Vec<usize>,
    numbers: &'n [u32],
}

impl<'n> Lines<'n> {
    fn new(text: &str, numbers: &'n [u32]) -> Self {
        let starts = text
            .bytes()
            .enumerate()
            .filter(|(_, byte)| *byte == b'\n')
            .map(|(at, _)| at + 1);
        Lines {
            starts: std::iter::once(0).chain(starts).collect(),
            numbers,
        }
    }

    pub(crate) fn number(&self, at: usize) -> u32 {
        let line = self.starts.partition_point(|start| *start <= at).saturating_sub(1);
        self.numbers.get(line).copied().unwrap_or(line as u32)
    }
}

/// Findings that are listed.
const MAX_FINDINGS: usize = 10_000;
