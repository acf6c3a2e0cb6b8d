//! A program that has been read, and the check that its names mean something.

use std::collections::{BTreeMap, BTreeSet};

use arcline_instruction_set::{Attribute, Mnemonic, Object, predefined};
use arcline_tag::{DataType, Location, PathError, TagPath, TagType, Value, nearest};

use crate::code::{Meaning, Op, Path, Use};
use crate::error::{SyntaxError, SyntaxProblem};
use crate::parser::{self, unknown_word};

/// A program: instruction calls, assignments, conditions and loops, ready to run
/// ([`crate::Interpreter`]).
#[derive(Clone, PartialEq, Debug)]
pub struct Program {
    pub(crate) text: String,
    pub(crate) ops: Vec<Op>,
    pub(crate) paths: Vec<Path>,
    pub(crate) calls: Vec<CallStatement>,
    pub(crate) attributes: Vec<ObjectAttribute>,
    pub(crate) uses: Vec<Use>,
    /// The number of variables, hidden ones of FOR included.
    pub(crate) variables: u32,
}

/// One instruction call as it stands in the program.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CallStatement {
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// Name of the object it acts on, as written.
    pub target: String,
    /// The motion control tag, as written; `None` when it was left out.
    pub control: Option<String>,
    /// Line of the mnemonic, from 1.
    pub line: usize,
    /// Column of the mnemonic in characters, from 1.
    pub column: usize,
}

/// An attribute of one axis or coordinate system, as GSV and SSV name it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ObjectAttribute {
    /// The attribute of the class.
    pub attribute: &'static Attribute,
    /// Name of the axis or coordinate system, as written.
    pub name: String,
}

/// Knows which names the machine has, for [`Program::check`]. All names ignore case.
pub trait Names {
    /// Whether there is an object of that sort and name.
    fn is_object(&self, object: Object, name: &str) -> bool;

    /// Whether the path leads to a tag or a part of one: `None` when there is no such tag, an error when it has no such
    /// part.
    fn locate(&self, path: &TagPath) -> Option<Result<(), PathError>>;

    /// The objects of a sort, for "did you mean".
    fn objects(&self, object: Object) -> Vec<String> {
        let _ = object;
        Vec::new()
    }

    /// The tags, for "did you mean".
    fn tags(&self) -> Vec<String> {
        Vec::new()
    }
}

impl Program {
    /// Reads a program. [`Program::check`] checks the names.
    ///
    /// # Errors
    /// The first error, with its position. Programs are read up to 8 MiB and 128 levels of
    /// nesting.
    pub fn parse(text: &str) -> Result<Program, SyntaxError> {
        parser::program(text)
    }

    /// Reads one instruction call, the `;` behind it optional, for `arcline exec`.
    ///
    /// # Errors
    /// As [`Program::parse`], and anything in front of or behind the call.
    pub fn parse_call(text: &str) -> Result<Program, SyntaxError> {
        parser::call(text)
    }

    /// The instruction calls in the order of the text. A call in a loop is one.
    pub fn calls(&self) -> impl Iterator<Item = &CallStatement> {
        self.calls.iter()
    }

    /// The motion control tags that the calls name, each once, in the order of the text, as first written.
    pub fn control_tags(&self) -> impl Iterator<Item = &str> {
        let mut seen = BTreeSet::new();
        let names = self.calls.iter().filter_map(|call| call.control.as_deref());
        names.filter(move |name| seen.insert(name.to_ascii_lowercase()))
    }

    /// Checks that every name means something, and makes a variable of the program of every plain name that
    /// is assigned and is no tag: an LREAL that begins at 0 and is gone when the program has ended.
    ///
    /// A motion control tag that is not there is fine, since its first execution makes it; its members may
    /// be read anywhere in the program.
    ///
    /// # Errors
    /// The first name without meaning, with its place and the nearest name that has one.
    pub fn check(&mut self, names: &dyn Names) -> Result<(), SyntaxError> {
        let controls: BTreeSet<String> = self.control_tags().map(str::to_ascii_lowercase).collect();
        self.find_variables(names, &controls);
        for one in &self.uses {
            self.check_use(one, names, &controls)?;
        }
        Ok(())
    }

    /// A program of that text without any operation, with which the parser begins.
    pub(crate) fn empty(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            ops: Vec::new(),
            paths: Vec::new(),
            calls: Vec::new(),
            attributes: Vec::new(),
            uses: Vec::new(),
            variables: 0,
        }
    }

    fn find_variables(&mut self, names: &dyn Names, controls: &BTreeSet<String>) {
        let mut variables: BTreeMap<String, u32> = BTreeMap::new();
        for one in &self.uses {
            let Meaning::Assigned(path) = one.meaning else {
                continue;
            };
            let path = &self.paths[path as usize];
            let Some(name) = path.plain_name().map(str::to_ascii_lowercase) else {
                continue;
            };
            if variables.contains_key(&name) || controls.contains(&name) || is_tag(names, &path.sample()) {
                continue;
            }
            variables.insert(name, self.variables);
            self.variables += 1;
        }
        for path in &mut self.paths {
            let name = path.plain_name().map(str::to_ascii_lowercase);
            path.variable = name.and_then(|name| variables.get(&name).copied());
        }
    }

    fn check_use(&self, one: &Use, names: &dyn Names, controls: &BTreeSet<String>) -> Result<(), SyntaxError> {
        let error = |problem| Err(SyntaxError::new(&self.text, one.offset, problem));
        let (path, may_be_variable) = match &one.meaning {
            Meaning::Object(object, name) => {
                if names.is_object(*object, name) {
                    return Ok(());
                }
                if let Some(is) = Object::ALL.into_iter().find(|other| names.is_object(*other, name)) {
                    let (name, wanted) = (name.clone(), *object);
                    return error(SyntaxProblem::WrongObject { name, is, wanted });
                }
                let suggestion = nearest(name, names.objects(*object));
                let name = name.chars().take(60).collect();
                return error(SyntaxProblem::UnknownObject {
                    what: object.name(),
                    name,
                    suggestion,
                });
            }
            Meaning::Control(path) => {
                let path = &self.paths[*path as usize];
                if path.plain_name().is_some() {
                    return Ok(());
                }
                (path, false)
            }
            Meaning::Written(path) => (&self.paths[*path as usize], false),
            Meaning::Read(path) | Meaning::Assigned(path) => (&self.paths[*path as usize], true),
        };
        let sample = path.sample();
        if may_be_variable && path.variable.is_some() || is_tag(names, &sample) || is_control(&sample, controls) {
            return Ok(());
        }
        if let Some(word) = &one.word {
            return Err(unknown_word(&self.text, word, names.tags().into_iter()));
        }
        if let Some(no_part) = missing_part(names, &sample, controls) {
            return error(SyntaxProblem::Path { error: no_part });
        }
        let variables = self.paths.iter().filter(|path| path.variable.is_some());
        let variables = variables.filter_map(|path| path.plain_name().map(str::to_owned));
        let known = names
            .tags()
            .into_iter()
            .chain(variables)
            .chain(self.control_tags().map(str::to_owned));
        let suggestion = nearest(sample.tag().unwrap_or_default(), known)
            // A motion control tag that is there once the program runs: its own name would be no help.
            .filter(|name| !sample.tag().is_some_and(|tag| tag.eq_ignore_ascii_case(name)));
        error(SyntaxProblem::UnknownTag {
            path: sample.to_string(),
            suggestion,
        })
    }
}

/// Whether the path leads to a tag or a part of one.
fn is_tag(names: &dyn Names, path: &TagPath) -> bool {
    matches!(names.locate(path), Some(Ok(())))
}

/// Whether the path begins with a motion control tag that the program makes.
fn is_of_control(path: &TagPath, controls: &BTreeSet<String>) -> bool {
    path.tag()
        .is_some_and(|tag| controls.contains(&tag.to_ascii_lowercase()))
}

/// Whether the path leads to a member of a motion control tag that the program makes.
fn is_control(path: &TagPath, controls: &BTreeSet<String>) -> bool {
    is_of_control(path, controls) && unmade_control(path).is_some()
}

/// The part of a path that a present or future tag does not have.
fn missing_part(names: &dyn Names, path: &TagPath, controls: &BTreeSet<String>) -> Option<PathError> {
    match names.locate(path) {
        Some(found) => found.err(),
        None if is_of_control(path, controls) => in_control(path).err(),
        None => None,
    }
}

fn in_control(path: &TagPath) -> Result<Location, PathError> {
    TagType::scalar(predefined::motion_instruction()).locate(path.rest())
}

/// The value of a member of a motion control tag that no execution has made yet: the zero of its type. `None` when
/// a MOTION_INSTRUCTION has no such member.
pub fn unmade_control(path: &TagPath) -> Option<Value> {
    let place = in_control(path).ok()?;
    match place.data_type {
        DataType::Elementary(_) if place.bit.is_some() => Some(Value::Bool(false)),
        DataType::Elementary(elementary) => Some(Value::from_f64(elementary, 0.0)),
        DataType::Structure(_) => None,
    }
}
