//! The scan: compiled routines on their memory. It allocates nothing.

mod add_on;
mod alarm;
mod compute;
mod counters;
mod edges;
mod fault;
mod files;
mod ladder;
mod memory;
mod motion;
mod queues;
mod statements;
mod system;
mod text;
mod value;
mod wires;

use arcline_instruction_set::{Call, ControlSlot, MotionControl, Object};

pub use fault::Fault;
pub(crate) use fault::{FaultAt, MAX_FAULTS};
pub use memory::Memory;
pub(crate) use value::Number;

use crate::code::{Code, Sizes, TextId, Transfer};

/// The machine and the controller around routines.
pub trait Host {
    /// Executes an instruction of motion; brings the changes of axes and coordinate systems on its acceptance to the memory.
    fn execute(&mut self, call: &Call, memory: &mut Memory) -> MotionControl;
    /// The rung condition of the instruction with this motion control tag is false.
    fn rung_false(&mut self, slot: ControlSlot);
    /// Reads an attribute of a motion object.
    fn attribute(&mut self, number: u32) -> f64;
    /// Sets one; false: it cannot be set.
    fn set_attribute(&mut self, number: u32, value: f64) -> bool;
    /// Year, month, day, hour, minute, second, microsecond at a virtual time, ns.
    fn date(&self, now: u64) -> [i32; 7];
    /// A run of a task begins, whose longest time is this, µs; 0: that of the controller.
    fn begin_task(&mut self, _watchdog_us: i32) {}
    /// The inputs of modules have come to the memory, before the first rung of a tick.
    fn inputs_latched(&mut self, _memory: &mut Memory) {}
    /// A wire gives an input of an axis a value.
    fn axis_input(&mut self, _number: u32, _on: bool) {}
    /// Between two rungs or statements: writes of clients come to the memory here.
    fn between(&mut self, _memory: &mut Memory) -> Pace {
        Pace::InTime
    }
}

/// Whether the run of a task is within its time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Pace {
    /// The run goes on.
    InTime,
    /// The watchdog ends it.
    TooLong,
}

/// The point at which execution continues, other than at the next instruction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Exit {
    /// A rung of the routine.
    Jump(u32),
    /// Behind the call of the routine.
    Return,
    /// Behind the FOR that called the routine.
    Break,
    /// Behind the loop of Structured Text.
    Loop,
    /// Nowhere: a major fault.
    Fault,
}

pub(crate) type Run<T> = Result<T, Exit>;

/// The state of execution: flags, time, the call stack.
#[derive(Clone, Debug, Default)]
pub(crate) struct ExecutionState {
    pub(crate) memory: Memory,
    /// Whether the present step has done something other than writes to the memory, or depends on the time: it does not settle.
    pub(crate) is_restless: bool,
    /// The timer of the present step that times, and its writes.
    pub(crate) timing: Option<Timing>,
    /// Bases of add-on instructions that run, and the first one of the innermost.
    bases: Vec<Base>,
    frame: usize,
    overflow: bool,
    /// Whether the minor fault of the overflow has been counted: a division by 0.
    is_counted: bool,
    zero: bool,
    negative: bool,
    carry: bool,
    pub(crate) minor: bool,
    pub(crate) minor_bits: u32,
    /// Bits by type of the major faults, and the numbers of minor and major ones, since SSV cleared them.
    pub(crate) major_bits: u32,
    pub(crate) events: [i16; 2],
    pub(crate) first_scan: bool,
    pub(crate) prescan: bool,
    /// Whether a zone of MCR is off.
    zone: bool,
    /// The task's time, ms and ns.
    pub(crate) now_ms: i64,
    /// The time of its run before this one, ms.
    pub(crate) before_ms: i64,
    pub(crate) now: u64,
    /// Instructions that the run of the task may still execute.
    pub(crate) budget: i64,
    /// Longest time of the run of the task, µs.
    pub(crate) watchdog_us: i32,
    /// The number of instructions that the watchdog has ended in this run.
    pub(crate) watchdogs: u32,
    depth: usize,
    add_ons: usize,
    /// Routines that are prescanned now.
    path: Vec<u32>,
    fault: Option<FaultAt>,
    /// Whether the fault routines have handled the fault.
    is_handled: bool,
    pub(crate) faults: Vec<FaultAt>,
    in_fault: bool,
    pub(crate) records: Vec<[i32; 11]>,
    pub(crate) program: u32,
    pub(crate) routine: u32,
    pub(crate) line: u32,
    instruction: TextId,
    /// Instructions of motion that this tick executed.
    pub(crate) executions: u32,
    pub(crate) triggered: Vec<bool>,
    pub(crate) inhibited: Vec<bool>,
    pub(crate) disabled: Vec<bool>,
    pub(crate) overlaps: Vec<i32>,
    /// The attribute Status of each task: [`STATUS_EVENT`] and others.
    pub(crate) status: Vec<i32>,
    pub(crate) objects: Vec<(u32, Object, u16)>,
    pub(crate) controls: Vec<(u32, ControlSlot)>,
    /// Tags that the host has too: first byte, end, id.
    pub(crate) shared: Vec<(u32, u32, u32)>,
    messages: Vec<Sent>,
    /// The state of each wire.
    wires: Vec<wires::Signal>,
    /// The power flow of the watched routines, and the position of the next bit.
    pub(crate) traces: Vec<Trace>,
    trace: Cursor,
}

/// A timer that has timed and will go on: its first byte, and its writes to the memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timing {
    pub(crate) at: u32,
    pub(crate) changes: u64,
}

/// The first byte of an instance of an add-on instruction, or the operand of a parameter by reference.
#[derive(Clone, Copy, Debug)]
struct Base {
    at: u32,
    /// The bit of a BOOL.
    mask: u8,
    sizes: Sizes,
}

impl Base {
    fn instance(at: u32) -> Self {
        Base {
            at,
            mask: 1,
            sizes: Sizes::default(),
        }
    }
}

/// A message on its way.
#[derive(Clone, Copy, Debug)]
struct Sent {
    /// The first byte of its tag.
    at: u32,
    /// ns of its answer, or of its timeout.
    due: u64,
    /// Its answer; `None`: it has none.
    reply: Option<u32>,
}

/// The power flow of a routine in its last scan. Each rung has a bit that says it was scanned, its rung condition, and the condition
/// behind each of its elements: those of the legs of a branch, then that of the branch.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    pub(crate) routine: u32,
    /// Its program, whose scans clear it; an add-on instruction shows the last call.
    pub(crate) program: Option<u32>,
    /// The first bit of each rung, then the end.
    pub(crate) starts: Box<[u32]>,
    pub(crate) bits: Box<[u8]>,
}

/// A bit of a trace.
#[derive(Clone, Copy, Debug, Default)]
struct Cursor {
    trace: usize,
    bit: usize,
}

impl ExecutionState {
    /// A message is on its way.
    pub(crate) fn has_messages(&self) -> bool {
        !self.messages.is_empty()
    }

    pub(crate) fn new(memory: Vec<u8>, code: &Code) -> Self {
        ExecutionState {
            memory: Memory::new(memory),
            bases: Vec::with_capacity(MAX_BASES),
            path: Vec::with_capacity(MAX_CALLS + 1),
            faults: Vec::with_capacity(MAX_FAULTS),
            records: vec![[0; 11]; code.programs.len()],
            triggered: vec![false; code.tasks.len()],
            inhibited: code.tasks.iter().map(|task| task.is_inhibited).collect(),
            disabled: code.programs.iter().map(|program| program.is_disabled).collect(),
            overlaps: vec![0; code.tasks.len()],
            status: vec![0; code.tasks.len()],
            messages: Vec::with_capacity(MAX_MESSAGES),
            wires: vec![wires::Signal::default(); code.wires.len()],
            ..ExecutionState::default()
        }
    }
}

impl ExecutionState {
    /// The beginning of a task's run.
    pub(crate) fn begin_run(&mut self, watchdog_us: i32, host: &mut dyn Host) {
        (self.budget, self.watchdog_us, self.watchdogs) = (BUDGET, watchdog_us, 0);
        host.begin_task(watchdog_us);
    }

    /// The beginning of a program's scan.
    pub(crate) fn begin(&mut self) {
        for trace in &mut self.traces {
            if trace.program == Some(self.program) {
                trace.bits.fill(0);
            }
        }
        (self.overflow, self.zero, self.negative, self.carry, self.minor) = (false, false, false, false, false);
        self.zone = false;
        (self.depth, self.add_ons, self.frame) = (0, 0, 0);
        self.bases.clear();
        self.path.clear();
    }

    /// Ends the zone of MCR that a program has left open.
    pub(crate) fn leave_zone(&mut self) {
        self.zone = false;
    }

    /// Prepares the evaluation of operands between two scans; returns the flag that it may change.
    pub(crate) fn begin_sample(&mut self) -> bool {
        self.frame = 0;
        self.bases.clear();
        self.overflow
    }

    /// Ends the evaluation of operands.
    pub(crate) fn end_sample(&mut self, overflow: bool) {
        self.bases.clear();
        self.overflow = overflow;
    }

    /// The next bits of a trace are those of a rung: it was scanned, with this condition.
    fn trace_rung(&mut self, rung: usize, power: bool) {
        let Cursor { trace, .. } = self.trace;
        let Some(trace) = self.traces.get_mut(trace) else {
            return;
        };
        let from = trace.starts.get(rung).copied().unwrap_or(u32::MAX) as usize;
        let end = trace.starts.get(rung + 1).copied().unwrap_or_default() as usize;
        for bit in from..end {
            set_bit(&mut trace.bits, bit, bit == from);
        }
        self.trace.bit = from + 1;
        self.trace_power(power);
    }

    /// The next bit of a trace.
    fn trace_power(&mut self, power: bool) {
        if let Some(trace) = self.traces.get_mut(self.trace.trace) {
            set_bit(&mut trace.bits, self.trace.bit, power);
        }
        self.trace.bit += 1;
    }
}

fn set_bit(bits: &mut [u8], bit: usize, on: bool) {
    if let Some(byte) = bits.get_mut(bit / 8) {
        let mask = 1 << (bit % 8);
        *byte = if on { *byte | mask } else { *byte & !mask };
    }
}

impl Scan<'_> {
    /// Places of an add-on instruction are from now on those of the instance at a byte.
    pub(crate) fn enter_instance(&mut self, at: u32) {
        self.s.bases.push(Base::instance(at));
    }
}

/// A scan.
pub(crate) struct Scan<'s> {
    pub(crate) code: &'s Code,
    pub(crate) s: &'s mut ExecutionState,
    pub(crate) host: &'s mut dyn Host,
    /// The call of the routine that runs.
    pub(crate) caller: Option<&'s Transfer>,
}

/// Status of a task: EVENT triggered it.
pub(crate) const STATUS_EVENT: i32 = 1;
/// Its timeout ran it.
pub(crate) const STATUS_TIMEOUT: i32 = 2;
/// A release was lost.
pub(crate) const STATUS_OVERLAP: i32 = 4;
/// Routines within one another.
const MAX_CALLS: usize = 48;
/// Add-on instructions within one another.
const MAX_ADD_ONS: usize = 16;
/// Bases of add-on instructions that run.
const MAX_BASES: usize = 1024;
/// Instructions of motion in one tick.
const MAX_EXECUTIONS: u32 = 1024;
/// Messages on their way.
const MAX_MESSAGES: usize = 256;
/// Instructions of one run of a task: stands for the watchdog.
pub(crate) const BUDGET: i64 = 5_000_000;
