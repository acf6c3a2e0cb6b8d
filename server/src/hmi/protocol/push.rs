//! The messages that the server sends without a request.

use serde::Serialize;
use serde_json::{Map, Value};

use super::answer::{Circle, Controllers};
use super::refusal::Refusal;

/// A message of the server that no request asked for, by its `push`.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(tag = "push", rename_all = "snake_case")]
pub(crate) enum Push<'s> {
    /// The first message.
    Hello {
        /// The name of this viewer, as in `drivers`.
        viewer: &'s str,
        /// Names of the signals of frames of samples, in the order of a row.
        trace_signals: Vec<String>,
    },
    /// Comes after `hello`, and when the session of this viewer has changed.
    Session {
        /// The role that this viewer has now: `viewer`, `operator`, `engineer` or `administrator`.
        role: &'s str,
        /// The user who has logged in; null without one.
        user: Option<&'s str>,
        /// Whether the session is locked: until the user logs in again, this viewer can only view and stop.
        locked: bool,
        /// Whether a user can log in on this connection.
        can_log_in: bool,
    },
    /// Comes when tags have changed, at most 16 times a second.
    Status(Status),
    /// Comes when instructions or faults have changed.
    Event {
        /// Oldest first.
        events: Vec<Event>,
    },
    /// Comes when watched tags have changed, at most ten times a second. The first one has all watched tags.
    Values {
        /// The value of each name that has changed, or `{error}`.
        values: Map<String, Value>,
    },
    /// Comes when the program has changed.
    Program(ProgramStatus<'s>),
    /// Comes when watched rungs or lines have changed, at most five times a second. The first one has all rows.
    Look {
        /// Number of the routine.
        routine: u32,
        /// The rungs or lines that have changed.
        rows: Vec<MonitorRow>,
    },
}

/// The state of a rung or line.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct MonitorRow {
    /// Index in the routine, from 0.
    pub(crate) index: usize,
    /// One digit, `0` or `1`, for the rung condition and for the condition after each element. Empty: the last scan of the program did not
    /// include the rung.
    pub(crate) power: String,
    /// Value of each operand, or of each tag of a line; null: there is none. Whole numbers beyond 2⁵³ are text.
    pub(crate) values: Vec<Value>,
}

/// The controller's own program.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct ControllerStatus {
    /// Requested mode: `program` or `run`.
    pub(crate) mode: &'static str,
    /// State of the program.
    pub(crate) state: ControllerState,
    /// A number that changes with each loaded program.
    pub(crate) version: u64,
    /// Number of ticks in which due tasks were scanned.
    pub(crate) scans: u64,
    /// Duration of the newest scan, µs.
    pub(crate) last_us: u64,
    /// Duration of the longest scan, µs.
    pub(crate) longest_us: u64,
    /// The major fault that has stopped the tasks.
    pub(crate) fault: Option<ControllerFault>,
    /// Forced inputs.
    pub(crate) forces: Vec<ForceRow>,
}

/// State of the controller's own program.
#[derive(Clone, Copy, Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(crate) enum ControllerState {
    /// The tasks do not run.
    Stopped,
    /// The tasks run.
    Running,
    /// A major fault has stopped them.
    Faulted,
}

/// A major fault.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct ControllerFault {
    /// A description, as a sentence.
    pub(crate) text: String,
    /// Number of the routine.
    pub(crate) routine: Option<u32>,
    /// Number of the rung or line in the file.
    pub(crate) line: u32,
    /// Mnemonic; empty for a statement.
    pub(crate) instruction: String,
    /// The operand at fault.
    pub(crate) operand: Option<String>,
    /// Value of that operand.
    pub(crate) value: Option<i64>,
}

/// A forced input.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct ForceRow {
    /// Name of the input.
    pub(crate) tag: String,
    /// The value that the program reads.
    pub(crate) value: Value,
}

/// The state of the machine.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Status {
    /// Tick since the start of the server.
    pub(crate) tick: u64,
    /// Machine time of the tick, s.
    pub(crate) time_s: f64,
    /// Every axis, in the order of the configuration.
    pub(crate) axes: Vec<AxisStatus>,
    /// Every coordinate system, in the order of the configuration.
    pub(crate) coordinate_systems: Vec<SystemStatus>,
    /// The group.
    pub(crate) group: GroupStatus,
    /// Whether STOP inhibits motion until it is released.
    pub(crate) inhibited: bool,
    /// Number of events that the audit has lost since the start; null without an audit.
    pub(crate) audit_lost: Option<u64>,
    /// The real-time thread.
    pub(crate) realtime: RealTime,
    /// The viewer that has control of an object, by the object's name.
    pub(crate) drivers: Controllers,
    /// The controller's own program; null without one.
    pub(crate) controller: Option<Box<ControllerStatus>>,
}

/// The state of an axis, in its position units.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct AxisStatus {
    /// Name.
    pub(crate) name: String,
    /// Command position.
    pub(crate) command: f64,
    /// Actual position.
    pub(crate) actual: f64,
    /// Following error.
    pub(crate) error: f64,
    /// Command velocity, position units/s.
    pub(crate) velocity: f64,
    /// Command acceleration, position units/s².
    pub(crate) acceleration: f64,
    /// Actual velocity, position units/s.
    pub(crate) actual_velocity: f64,
    /// CIPAxisState in words.
    pub(crate) state: &'static str,
    /// Whether the axis is homed.
    pub(crate) homed: bool,
    /// Whether the servo is on.
    pub(crate) servo_on: bool,
    /// Whether the command velocity is not 0.
    pub(crate) moving: bool,
    /// The client, page or program that moves it, or moves its coordinate system; null while nothing does.
    pub(crate) moved_by: Option<String>,
    /// Names of the status bits that are set, without those of faults and alarms.
    pub(crate) bits: Vec<String>,
    /// Words of the faults that are set.
    pub(crate) faults: Vec<&'static str>,
}

/// The state of a coordinate system.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct SystemStatus {
    /// Name.
    pub(crate) name: String,
    /// Actual positions of its axes.
    pub(crate) position: Vec<f64>,
    /// The client, page or program that moves it; null while nothing does.
    pub(crate) moved_by: Option<String>,
    /// The active move.
    pub(crate) active: Option<ActiveMove>,
    /// Pending moves, oldest first, at most 200.
    pub(crate) pending: Vec<PendingMove>,
    /// A number that changes with the paths.
    pub(crate) path_version: u64,
    /// Path speed, position units/s.
    pub(crate) speed: f64,
    /// Feed override, percent.
    #[serde(rename = "override")]
    pub(crate) feed_override: f64,
    /// Whether a feed hold is in force.
    pub(crate) held: bool,
    /// Names of the status bits that are set.
    pub(crate) bits: Vec<String>,
    /// The programmed paths; only when `path_version` has changed, and never for a robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) path: Option<Paths>,
}

/// The active move of a coordinate system.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct ActiveMove {
    /// Name of its motion control tag; empty without one.
    pub(crate) tag: String,
    /// Mnemonic.
    pub(crate) instruction: &'static str,
    /// Completed share of its path, 0 to 1.
    pub(crate) progress: f64,
    /// Distance to go, position units.
    pub(crate) remaining: f64,
    /// Time to go, s; null while it is not known.
    pub(crate) eta_s: Option<f64>,
}

/// A move that waits in the queue.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct PendingMove {
    /// Name of its motion control tag; empty without one.
    pub(crate) tag: String,
    /// Mnemonic.
    pub(crate) instruction: &'static str,
}

/// Programmed paths as points, in position units.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Paths {
    /// The path of the active move; empty without one.
    pub(crate) active: Vec<Vec<f64>>,
    /// The paths of pending moves.
    pub(crate) pending: Vec<Vec<Vec<f64>>>,
    /// The tolerance at the end of each blended move.
    pub(crate) tolerance: Vec<Circle>,
}

/// The state of the group.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct GroupStatus {
    /// Name.
    pub(crate) name: String,
    /// Names of the status bits that are set.
    pub(crate) bits: Vec<String>,
}

/// Measurements of the real-time thread.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RealTime {
    /// Tick lateness: median, µs.
    pub(crate) p50_us: f64,
    /// Tick lateness: 99th percentile, µs.
    pub(crate) p99_us: f64,
    /// Tick lateness: maximum, µs.
    pub(crate) max_us: f64,
    /// Computing time of a tick: 99th percentile, µs.
    pub(crate) compute_p99_us: f64,
    /// Computing time of a tick: maximum, µs.
    pub(crate) compute_max_us: f64,
    /// Missed ticks.
    pub(crate) missed: u64,
    /// Whether the thread has real-time priority.
    pub(crate) fifo: bool,
    /// Whether the thread's memory is locked.
    pub(crate) memory_locked: bool,
}

/// The program that runs, or ran last.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct ProgramStatus<'s> {
    /// State.
    pub(crate) state: ProgramState,
    /// Line of the statement that runs or comes next, from 1.
    pub(crate) line: Option<usize>,
    /// The viewer that began it.
    pub(crate) viewer: Option<&'s str>,
    /// Error of a failed program.
    pub(crate) error: Option<&'s Refusal>,
    /// A number that changes with each program.
    pub(crate) run: u64,
    /// Its text; only with a new `run`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) text: Option<&'s str>,
}

/// State of a program.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(crate) enum ProgramState {
    /// No program has run yet.
    Idle,
    /// The program runs.
    Running,
    /// The program is paused before a statement.
    Paused,
    /// The program has ended.
    Ended,
    /// An error ended it.
    Failed,
}

/// A change of an instruction or of an axis's faults.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Event {
    /// Number of the event, ascending.
    pub(crate) seq: u64,
    /// Tick.
    pub(crate) tick: u64,
    /// Machine time of the tick, s.
    pub(crate) time_s: f64,
    /// Time of the day, ms since 1970-01-01 UTC.
    pub(crate) at_ms: f64,
    /// The change.
    #[serde(flatten)]
    pub(crate) change: EventChange,
}

/// The subject of an event.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(crate) enum EventChange {
    /// An instruction.
    Instruction(InstructionEvent),
    /// The faults of an axis.
    Fault {
        /// The change of the faults.
        fault: FaultEvent,
    },
    /// The rest of a planned contour between moves that go on.
    Rest {
        /// The rest.
        rest: RestEvent,
    },
}

/// The rest of a planned contour between moves that go on.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RestEvent {
    /// The coordinate system.
    pub(crate) system: Option<String>,
    /// The part that was too slow: `program`, whose next move came late, or `planner`.
    pub(crate) slow: SlowPart,
    /// Number of rests of that cause since the start.
    pub(crate) count: u32,
    /// A description, as a sentence.
    pub(crate) text: &'static str,
}

/// The part that was too slow.
#[derive(Serialize, Clone, Copy, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub(crate) enum SlowPart {
    /// The program that sends the moves.
    Program,
    /// The planner.
    Planner,
}

/// A change of an instruction's status bits.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct InstructionEvent {
    /// Number of the execution.
    pub(crate) ticket: u64,
    /// Name of its motion control tag; empty without one.
    pub(crate) tag: String,
    /// Mnemonic.
    pub(crate) instruction: &'static str,
    /// The axis, coordinate system or group on which the instruction acts.
    pub(crate) object: Option<String>,
    /// Its line of Structured Text, if a page executed it.
    pub(crate) text: Option<String>,
    /// The viewer that executed it.
    pub(crate) viewer: Option<String>,
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
    /// The cause that ended the instruction prematurely.
    pub(crate) ended: Option<EndCause>,
}

/// A change of an axis's faults.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct FaultEvent {
    /// Name of the axis.
    pub(crate) axis: Option<String>,
    /// Words of the faults that were set.
    pub(crate) set: Vec<&'static str>,
    /// Words of the faults that were reset and set again at once, since their cause persists.
    pub(crate) again: Vec<&'static str>,
    /// Words of the faults that were cleared.
    pub(crate) clear: Vec<&'static str>,
    /// The cause that cleared the faults.
    pub(crate) by: Option<EndCause>,
    /// The command that the axis refused.
    pub(crate) refused: Option<RefusedCommand>,
}

/// A command position that an axis refused.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RefusedCommand {
    /// A description, as a sentence.
    pub(crate) text: String,
    /// The instruction that commanded it.
    pub(crate) by: Option<EndCause>,
    /// Position and velocity of the last command, position units and position units/s.
    pub(crate) last: [f64; 2],
    /// Position and velocity of the refused command; null for a value that is not a number.
    pub(crate) asked: [f64; 2],
}

/// The cause that ended an instruction or cleared a fault.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct EndCause {
    /// A description, as a sentence.
    pub(crate) text: String,
    /// The kind of cause.
    #[serde(flatten)]
    pub(crate) by: CauseKind,
}

/// A kind of cause, by its `by`.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(tag = "by")]
pub(crate) enum CauseKind {
    /// Another instruction.
    #[serde(rename = "instruction")]
    Instruction {
        /// Number of its execution.
        ticket: u64,
        /// Mnemonic.
        instruction: &'static str,
    },
    /// A fault.
    #[serde(rename = "fault")]
    Fault {
        /// Name of the axis.
        axis: Option<String>,
        /// Words of the faults.
        faults: Vec<&'static str>,
    },
    /// A stop of all motion.
    #[serde(rename = "stop")]
    Stop {},
    /// The end of a jog whose viewer did not confirm it.
    #[serde(rename = "dead-man")]
    DeadMan {
        /// Reason for the end.
        reason: &'static str,
    },
}
