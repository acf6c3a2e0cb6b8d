//! The answers of the server: the type of each answer, and the types of its parts.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value};

use super::push::Event;
use super::refusal::Refusal;

/// The server has carried out the request.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Done {}

/// The sessions of the page.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct SessionList {
    /// In the order in which they began.
    pub(crate) sessions: Vec<SessionRow>,
}

/// A session of the page.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct SessionRow {
    /// Its number since the start of the server.
    pub(crate) session: u64,
    /// Name of its user, or of the token of its script.
    pub(crate) user: String,
    /// Whether it is the session of a script.
    pub(crate) script: bool,
    /// Role of its user or token.
    pub(crate) role: &'static str,
    /// Whether it is locked: its pages look and stop.
    pub(crate) locked: bool,
    /// Address from which it began.
    pub(crate) address: String,
    /// Number of open pages.
    pub(crate) pages: usize,
    /// Time since it began, s.
    pub(crate) age_s: u64,
    /// Time since the newest input of a person, s.
    pub(crate) idle_s: u64,
    /// Whether it is the session of the viewer that asks.
    pub(crate) own: bool,
}

/// An instruction that was accepted.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Executed {
    /// Mnemonic.
    pub(crate) instruction: &'static str,
    /// Instance of class 0x0303.
    pub(crate) instance: u32,
}

/// The line of a form.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct CallLine {
    /// One call as Structured Text.
    pub(crate) text: String,
}

/// The errors of a program.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Checked {
    /// The errors with their lines and columns; empty for a correct program.
    pub(crate) errors: Vec<Refusal>,
}

/// The result of a preview or a dry run.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Simulated {
    /// The path of each coordinate system that moved.
    pub(crate) paths: Vec<SimulatedPath>,
    /// Simulated time, s; null if the motion has no end.
    pub(crate) duration_s: Option<f64>,
    /// Simulated ticks.
    pub(crate) ticks: u64,
    /// The peaks of each axis.
    pub(crate) peaks: Vec<AxisPeaks>,
    /// The first limit that would be exceeded.
    pub(crate) limit: Option<LimitText>,
    /// The first soft travel limit that would be exceeded.
    pub(crate) travel: Option<LimitText>,
    /// The events of the instructions, at most 1,000.
    pub(crate) events: Vec<SimulatedEvent>,
}

/// The path of a coordinate system in a simulation.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct SimulatedPath {
    /// Name of the coordinate system.
    pub(crate) coordinate_system: String,
    /// Positions of its axes, or of the tool of a robot, in position units.
    pub(crate) points: Vec<Vec<f64>>,
    /// The tolerance about the end of each blended move.
    pub(crate) blends: Vec<Circle>,
}

/// A tolerance about a point.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Circle {
    /// The point, in position units.
    pub(crate) centre: Vec<f64>,
    /// The tolerance, in position units.
    pub(crate) radius: f64,
}

/// The greatest magnitudes of an axis in a simulation.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct AxisPeaks {
    /// Name of the axis.
    pub(crate) axis: String,
    /// Position units/s.
    pub(crate) velocity: f64,
    /// Position units/s².
    pub(crate) acceleration: f64,
    /// Position units/s³.
    pub(crate) jerk: f64,
}

/// A limit that a simulation would exceed.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct LimitText {
    /// A description, as a sentence.
    pub(crate) text: String,
}

/// A change of an instruction's status bits in a simulation.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct SimulatedEvent {
    /// Simulated time, s.
    pub(crate) time_s: f64,
    /// Simulated tick.
    pub(crate) tick: u64,
    /// Name of the motion control tag; empty without one.
    pub(crate) tag: String,
    /// Mnemonic.
    pub(crate) instruction: &'static str,
    /// Bits that were set.
    pub(crate) set: Vec<&'static str>,
    /// Bits that were cleared.
    pub(crate) clear: Vec<&'static str>,
    /// ERR.
    pub(crate) err: i16,
    /// EXERR.
    pub(crate) exerr: i8,
    /// The error, if ER was set.
    pub(crate) error: Option<Refusal>,
}

/// Tags by their names.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct TagPage {
    /// At most 200 tags.
    pub(crate) tags: Vec<TagRow>,
    /// Whether more tags follow.
    pub(crate) more: bool,
}

/// A tag of a list.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct TagRow {
    /// Name, with `Program:NAME.` in front of a tag of a program.
    pub(crate) name: String,
    /// Name of the data type.
    #[serde(rename = "type")]
    pub(crate) data_type: String,
    /// Sizes of an array; empty for a single value.
    pub(crate) dims: Vec<u32>,
    /// The access of clients to the tag.
    pub(crate) access: TagAccess,
    /// Value, if the tag is a single value of an elementary type.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) value: Option<Value>,
}

/// The access of clients to a tag.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) enum TagAccess {
    /// Read only.
    #[serde(rename = "read")]
    Read,
    /// Read and write.
    #[serde(rename = "read/write")]
    ReadWrite,
}

/// Values of tags.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Values {
    /// The value of each name, or `{error}`. Whole numbers beyond 2⁵³ are text.
    pub(crate) values: Map<String, Value>,
    /// Names of the read-only tags among them.
    pub(crate) read_only: Vec<String>,
}

/// The signals of the frames of samples.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Signals {
    /// Names of the signals, in the order of a row.
    pub(crate) signals: Vec<String>,
    /// Time of a tick, s.
    pub(crate) period_s: f64,
}

/// The contents of the binary frame before this answer.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct HistoryPiece {
    /// Tick of its first row.
    pub(crate) first: u64,
    /// Number of ticks that a row covers.
    pub(crate) every: u64,
    /// Number of rows; 0 if the server has no older samples.
    pub(crate) rows: usize,
}

/// Events of instructions and faults.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct EventPage {
    /// Oldest first.
    pub(crate) events: Vec<Event>,
}

/// The controller's own program.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RoutineList {
    /// A number that changes with each loaded program.
    pub(crate) version: u64,
    /// Name of its file.
    pub(crate) file: String,
    /// Its tasks.
    pub(crate) tasks: Vec<TaskRow>,
    /// Its programs.
    pub(crate) programs: Vec<ProgramRow>,
    /// Its add-on instructions.
    pub(crate) add_ons: Vec<AddOnRow>,
    /// Its parts that do not run and are passed over, at most 200.
    pub(crate) passed_over: Vec<PassedOver>,
    /// The number of all of them.
    pub(crate) passed_over_count: usize,
}

/// A part of the project that does not run.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct PassedOver {
    /// The part and the reason.
    pub(crate) text: String,
    /// Its position, in words; empty: the project as a whole.
    pub(crate) place: String,
    /// Number of its routine.
    pub(crate) routine: Option<u32>,
    /// Number of its rung or line in the file.
    pub(crate) number: Option<u32>,
}

/// A task.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct TaskRow {
    /// Name.
    pub(crate) name: String,
    /// Description of its trigger.
    pub(crate) trigger: String,
    /// Priority: 1, the highest, to 15.
    pub(crate) priority: u32,
    /// Watchdog time, ms.
    pub(crate) watchdog_ms: f64,
    /// Whether the task is inhibited.
    pub(crate) inhibited: bool,
    /// Names of its programs, in their order.
    pub(crate) programs: Vec<String>,
}

/// A program of the controller.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct ProgramRow {
    /// Name.
    pub(crate) name: String,
    /// Name of the routine that its task runs.
    pub(crate) main: Option<String>,
    /// Name of the routine that runs after a major fault.
    pub(crate) fault: Option<String>,
    /// Whether the task skips the program.
    pub(crate) disabled: bool,
    /// Its routines.
    pub(crate) routines: Vec<RoutineRow>,
}

/// An add-on instruction.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct AddOnRow {
    /// Name.
    pub(crate) name: String,
    /// Its instances among the tags, at most 200.
    pub(crate) instances: Vec<String>,
    /// Its routines.
    pub(crate) routines: Vec<RoutineRow>,
}

/// A routine.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RoutineRow {
    /// Number of the routine, as in the requests.
    pub(crate) routine: u32,
    /// Name.
    pub(crate) name: String,
    /// `ladder` or `text`; a routine of another language does not run.
    pub(crate) language: String,
    /// Number of rungs or lines.
    pub(crate) count: usize,
}

/// Rungs or lines of a routine.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RoutinePage {
    /// Version of the program.
    pub(crate) version: u64,
    /// The rungs of a ladder routine.
    pub(crate) rungs: Vec<Rung>,
    /// The lines of a routine of Structured Text.
    pub(crate) lines: Vec<TextLine>,
}

/// A rung.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Rung {
    /// Number in the file.
    pub(crate) number: u32,
    /// Comment; empty without one.
    pub(crate) comment: String,
    /// Elements from left to right.
    pub(crate) elements: Vec<RungElement>,
}

/// An element of a rung: an instruction, or a branch with legs.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RungElement {
    /// Index of its condition in `power` of the push `look`.
    pub(crate) condition: usize,
    /// Mnemonic; empty for a branch.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[cfg_attr(test, schemars(default))]
    pub(crate) name: String,
    /// Name of the instruction in words.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[cfg_attr(test, schemars(default))]
    pub(crate) title: String,
    /// Operands, in the order of the values of the push `look`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, schemars(default))]
    pub(crate) operands: Vec<RungOperand>,
    /// Legs of a branch, from top to bottom.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, schemars(default))]
    pub(crate) legs: Vec<Vec<RungElement>>,
}

/// An operand.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RungOperand {
    /// Name of the operand.
    pub(crate) name: String,
    /// Its text in the project.
    pub(crate) text: String,
}

/// A line of Structured Text.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct TextLine {
    /// Number in the file.
    pub(crate) number: u32,
    /// The line.
    pub(crate) text: String,
    /// Tags of the line, in the order of the values of the push `look`.
    pub(crate) names: Vec<String>,
}

/// The uses of a tag.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct UseList {
    /// Full name of the tag, with its aliases resolved.
    pub(crate) tag: String,
    /// The uses, at most 500.
    pub(crate) uses: Vec<UseRow>,
    /// Whether there are more uses.
    pub(crate) more: bool,
}

/// A use of a tag.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct UseRow {
    /// Number of the routine.
    pub(crate) routine: u32,
    /// Description of the rung or line.
    pub(crate) line: String,
    /// Index of the rung or line in the routine, from 0.
    pub(crate) index: usize,
    /// Mnemonic; empty for a statement of Structured Text.
    pub(crate) instruction: String,
    /// The text of the tag in the operand.
    pub(crate) operand: String,
    /// Whether the instruction writes the tag.
    pub(crate) writes: bool,
}

/// Names of viewers by the objects that they control.
pub(crate) type Controllers = BTreeMap<String, String>;
