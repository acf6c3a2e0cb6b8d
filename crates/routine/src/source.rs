//! A project as its file has it: types, tags with first values, add-on instructions, programs, routines and tasks.
//!
//! Nothing is resolved here; names are those of the text. Times are in ms as in the file.

use std::collections::BTreeMap;

use crate::error::Finding;

/// A project.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Project {
    /// The catalogue number of the controller.
    pub processor: String,
    /// Structure types of the project.
    pub types: Vec<TypeSource>,
    /// Add-on instructions.
    pub instructions: Vec<InstructionSource>,
    /// Tags of the controller, those of modules among them.
    pub tags: Vec<TagSource>,
    /// Programs.
    pub programs: Vec<ProgramSource>,
    /// Tasks.
    pub tasks: Vec<TaskSource>,
    /// The names of the modules.
    pub modules: Vec<String>,
    /// The modules that differ from real hardware: name and reason.
    pub outside: Vec<(String, String)>,
    /// Values that are copied around the scans of programs.
    pub connections: Vec<Connection>,
    /// Parts that the reader of the file found not to run.
    pub findings: Vec<Finding>,
    /// The program of the controller's fault handler.
    pub fault_handler: Option<String>,
    /// The answers to MSG; of several that fit, the first applies. They are not in the file.
    pub answers: Vec<Answer>,
    /// Wires between tags and axes. They are not in the file.
    pub wires: Vec<Wire>,
}

/// The connection of an Input or Output parameter of a program: a copy around its scan.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Connection {
    /// The program.
    pub program: String,
    /// Whether the copy is made before the scan; else behind it.
    pub is_before: bool,
    /// The source, in the controller's scope: `Speed`, `\\Main.Speed`.
    pub from: String,
    /// The destination.
    pub to: String,
}

/// A wire: a bit that another bit, or an input of an axis, follows.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Wire {
    /// A BOOL or a bit: `Local:2:O.Data.3`, `X.home_switch`.
    pub from: String,
    /// A BOOL or a bit of a tag, or an input of an axis: `Local:1:I.Data.0`, `X.enable`.
    pub to: String,
    /// The delay of the wire: the time from a change of `from` to the change of `to`, ms.
    pub delay_ms: u32,
}

/// The answer to a MSG of the type CIP Generic.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Answer {
    /// The service code.
    pub service: u8,
    /// The class.
    pub class: u16,
    /// The instance; `None`: any.
    pub instance: Option<u32>,
    /// The attribute; `None`: any.
    pub attribute: Option<u16>,
    /// The data for the destination.
    pub data: Vec<u8>,
    /// Time from the request to the answer, ms.
    pub delay_ms: u32,
    /// ERR and EXERR; ERR 0: it is answered well.
    pub error: (u16, u32),
}

/// A structure type.
#[derive(Clone, PartialEq, Debug)]
pub struct TypeSource {
    /// Its name.
    pub name: String,
    /// Whether the type is one of texts.
    pub is_string: bool,
    /// Its members, without the hidden hosts of BOOLs.
    pub members: Vec<MemberSource>,
}

/// A member of a structure type, a parameter or a local tag of an add-on instruction.
#[derive(Clone, PartialEq, Debug)]
pub struct MemberSource {
    /// Its name.
    pub name: String,
    /// Its type.
    pub data_type: String,
    /// Elements of each dimension; empty: no array.
    pub dimensions: Vec<u32>,
    /// The access of clients.
    pub access: Access,
}

/// An add-on instruction.
#[derive(Clone, PartialEq, Debug)]
pub struct InstructionSource {
    /// Its name.
    pub name: String,
    /// Its parameters in the order of definition.
    pub parameters: Vec<ParameterSource>,
    /// Its local tags with their first values.
    pub locals: Vec<(MemberSource, Option<Datum>)>,
    /// `Logic`, `Prescan`, `EnableInFalse`, `Postscan`.
    pub routines: Vec<RoutineSource>,
    /// Whether the routine `Prescan` runs.
    pub has_prescan: bool,
    /// Whether the routine `EnableInFalse` runs.
    pub has_enable_in_false: bool,
    /// Whether the instruction's content is encoded.
    pub is_encoded: bool,
}

/// A parameter of an add-on instruction.
#[derive(Clone, PartialEq, Debug)]
pub struct ParameterSource {
    /// Name and type.
    pub member: MemberSource,
    /// Its direction.
    pub usage: Usage,
    /// Whether a call has an operand for the parameter.
    pub is_required: bool,
    /// The local tag or member that the parameter is an alias of.
    pub alias: Option<String>,
    /// Its first value.
    pub value: Option<Datum>,
}

/// The direction of a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Usage {
    /// Copied in.
    Input,
    /// Copied out.
    Output,
    /// A parameter by reference.
    InOut,
}

/// A tag.
#[derive(Clone, PartialEq, Debug)]
pub struct TagSource {
    /// Its name.
    pub name: String,
    /// Its type; empty for an alias.
    pub data_type: String,
    /// Elements of each dimension; empty: no array.
    pub dimensions: Vec<u32>,
    /// The tag or part of one that an alias stands for.
    pub alias: Option<String>,
    /// Its first value; `None`: zeros.
    pub value: Option<Datum>,
    /// The access of clients.
    pub access: Access,
    /// The type of a module's tag, whose members are those of its value.
    pub is_module: bool,
    /// Further data of the tag: parameters of a message.
    pub attributes: BTreeMap<String, String>,
}

impl TagSource {
    /// A tag that clients may read and write. No `dimensions`: no array. No `value`: zeros.
    pub fn new(
        name: impl Into<String>,
        data_type: impl Into<String>,
        dimensions: impl Into<Vec<u32>>,
        value: Option<Datum>,
    ) -> Self {
        Self {
            name: name.into(),
            data_type: data_type.into(),
            dimensions: dimensions.into(),
            alias: None,
            value,
            access: Access::ReadWrite,
            is_module: false,
            attributes: BTreeMap::new(),
        }
    }
}

/// Whether a type is that of modules, whose tags and parameters have a name but no data.
pub(crate) fn is_module(data_type: &str) -> bool {
    data_type.eq_ignore_ascii_case("MODULE")
}

/// The access of clients to a tag or member (`ExternalAccess`, `Constant`).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Access {
    /// Read and write it.
    #[default]
    ReadWrite,
    /// Read it.
    ReadOnly,
    /// Clients do not see it.
    Hidden,
}

/// A first value.
#[derive(Clone, PartialEq, Debug)]
pub enum Datum {
    /// A number, `true`, `false`, or a literal in a radix.
    Number(String),
    /// A text, its bytes.
    Text(Vec<u8>),
    /// Elements, the last subscript fastest; of a structure, the values of its members in their order, as the format L5K has them.
    Array(Vec<Datum>),
    /// The bytes of the whole tag.
    Bytes(Vec<u8>),
    /// A value that is not understood: the beginning of its text.
    Unread(String),
    /// Members by name; the second text is the member's type.
    Structure(String, Vec<(String, Datum)>),
    /// A number with its type: only in the tags of modules.
    Typed(String, Box<Datum>),
}

/// A program.
#[derive(Clone, PartialEq, Debug)]
pub struct ProgramSource {
    /// Its name.
    pub name: String,
    /// The routine that its task runs.
    pub main: Option<String>,
    /// The routine that runs after a major fault.
    pub fault: Option<String>,
    /// Whether the task passes over the program.
    pub is_disabled: bool,
    /// Its tags.
    pub tags: Vec<TagSource>,
    /// Its routines.
    pub routines: Vec<RoutineSource>,
}

/// A routine.
#[derive(Clone, PartialEq, Debug)]
pub struct RoutineSource {
    /// Its name.
    pub name: String,
    /// Its content.
    pub content: Content,
}

/// The content of a routine.
#[derive(Clone, PartialEq, Debug)]
pub enum Content {
    /// Rungs: number, type and text.
    Ladder(Vec<RungSource>),
    /// Lines: number and text.
    Text(Vec<(u32, String)>),
    /// A language that does not run: FBD, SFC, or encoded content.
    Other(String),
}

/// A rung.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RungSource {
    /// Its number in the file.
    pub number: u32,
    /// `N`, or a pending edit.
    pub kind: String,
    /// Neutral text.
    pub text: String,
    /// The comment of the author; empty without one.
    pub comment: String,
}

/// A task.
#[derive(Clone, PartialEq, Debug)]
pub struct TaskSource {
    /// Its name.
    pub name: String,
    /// When it runs.
    pub trigger: Trigger,
    /// The axis or the tag of its event; empty: none.
    pub event_tag: String,
    /// 1, the highest, to 15.
    pub priority: u32,
    /// Longest time of a run, ms.
    pub watchdog_ms: f64,
    /// Whether the task is inhibited.
    pub is_inhibited: bool,
    /// Its programs in their order.
    pub programs: Vec<String>,
}

impl TaskSource {
    /// A task of priority 10 with a watchdog of 500 ms.
    pub fn new(name: impl Into<String>, trigger: Trigger, programs: &[&str]) -> Self {
        Self {
            name: name.into(),
            trigger,
            event_tag: String::new(),
            priority: 10,
            watchdog_ms: 500.0,
            is_inhibited: false,
            programs: programs.iter().map(|program| (*program).to_owned()).collect(),
        }
    }
}

/// When a task runs.
#[derive(Clone, PartialEq, Debug)]
pub enum Trigger {
    /// Again and again.
    Continuous,
    /// With this period, ms.
    Periodic(f64),
    /// At an event, and after this time without one, ms.
    Event(String, Option<f64>),
}
