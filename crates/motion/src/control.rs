//! Motion control tags: the execution that a tag shows, and the life of its bits
//! (spec/coordinated-instructions.md §2).
//!
//! A tag shows its newest execution. An older execution whose tag was used again continues, and reports its changes under its ticket
//! only.

use arcline_instruction_set::{ControlSlot, Flag, Mnemonic, MotionControl, MotionError};
use arcline_planner::profile::Phase;

use crate::cause::Cause;
use crate::events::{Events, InstructionWrite};
use crate::execution::{Execution, Ticket};

/// Slots for motion control tags, the unnamed one included.
pub const CONTROL_SLOTS: usize = 8192;

/// The slot of instructions without a motion control tag. Executions that share it do not collide.
pub const UNNAMED: ControlSlot = ControlSlot(CONTROL_SLOTS as u32 - 1);

/// A change of an execution's status within one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// The tick.
    pub tick: u64,
    /// The execution.
    pub ticket: Ticket,
    /// Its motion control tag.
    pub control: ControlSlot,
    /// The tag still shows this execution.
    pub owner: bool,
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// FLAGS bits that were set.
    pub set: u32,
    /// FLAGS bits that were cleared.
    pub clear: u32,
    /// ERR after the change.
    pub err: i16,
    /// EXERR after the change.
    pub exerr: i8,
    /// SEGMENT after the change.
    pub segment: i32,
    /// The cause of the end, if this change ends the execution without PC and without an error.
    pub cause: Cause,
}

impl Event {
    /// Makes the change in a copy of the execution's status.
    pub fn apply(&self, control: &mut MotionControl) {
        control.flags = (control.flags & !self.clear) | self.set;
        control.err = self.err;
        control.exerr = self.exerr;
        control.segment = self.segment;
    }
}

#[derive(Clone, Copy, Debug)]
struct Control {
    ticket: Ticket,
    mnemonic: Mnemonic,
    word: MotionControl,
    /// FLAGS when the present execution began or was last reported.
    reported: u32,
    /// The reported bits that survived since: EN alone survives the edge of a new execution. The others count as set anew.
    survivors: u32,
    changed: bool,
    /// SEGMENT differs from the last report.
    moved: bool,
    /// The cause of its end.
    cause: Cause,
}

/// Every motion control tag.
#[derive(Debug)]
pub(crate) struct Controls {
    table: Vec<Control>,
    changed: Vec<u32>,
    events: Vec<Event>,
    lost: u64,
    /// The cause with which executions end from now on.
    cause: Cause,
    /// The present tick.
    tick: u64,
    /// The writes of instructions to tags in this tick.
    instruction_writes: Vec<InstructionWrite>,
}

/// FLAGS bits of an execution under way: its end clears them.
const UNDER_WAY: u32 =
    Flag::Ip.mask() | Flag::Ac.mask() | Flag::Accel.mask() | Flag::Decel.mask() | Flag::TrackingMaster.mask();

/// Events that one tick can hold.
const EVENTS: usize = 2 * CONTROL_SLOTS;

/// Most writes to tags in one tick; further ones are lost.
const INSTRUCTION_WRITES: usize = 1024;

/// The FLAGS bits to set and to clear such that ACCEL and DECEL show the phase.
pub(crate) fn phase_flags(phase: Phase) -> (u32, u32) {
    let (accel, decel) = (Flag::Accel.mask(), Flag::Decel.mask());
    match phase {
        Phase::Accelerating => (accel, decel),
        Phase::Decelerating => (decel, accel),
        Phase::Steady => (0, accel | decel),
    }
}

impl Controls {
    pub(crate) fn new() -> Self {
        let unused = Control {
            ticket: Ticket(0),
            mnemonic: Mnemonic::Mcs,
            word: MotionControl::default(),
            reported: 0,
            survivors: u32::MAX,
            changed: false,
            moved: false,
            cause: Cause::Itself,
        };
        Controls {
            table: vec![unused; CONTROL_SLOTS],
            changed: Vec::with_capacity(EVENTS),
            events: Vec::with_capacity(EVENTS),
            lost: 0,
            cause: Cause::Itself,
            tick: 0,
            instruction_writes: Vec::with_capacity(INSTRUCTION_WRITES),
        }
    }

    /// Begins a tick: later changes carry its number.
    pub(crate) fn begin_tick(&mut self, tick: u64) {
        self.tick = tick;
    }

    /// Sets the cause with which executions end from now on. Returns the earlier cause, for the caller to restore.
    pub(crate) fn because(&mut self, cause: Cause) -> Cause {
        std::mem::replace(&mut self.cause, cause)
    }

    /// The cause with which executions end from now on.
    pub(crate) fn cause(&self) -> Cause {
        self.cause
    }

    /// A false-to-true edge: the tag shows the new execution, with EN alone set.
    ///
    /// # Errors
    /// `ExecutionCollision` (3) when the tag's last execution has set neither DN nor ER yet; the tag shows the
    /// new execution all the same.
    pub(crate) fn begin(&mut self, execution: Execution) -> Result<(), MotionError> {
        self.report(execution.control);
        let Some(control) = self.table.get_mut(execution.control.0 as usize) else {
            return Err(MotionError::ExecutionCollision);
        };
        let busy = control.word.has(Flag::En) && !control.word.has(Flag::Dn) && !control.word.has(Flag::Er);
        *control = Control {
            ticket: execution.ticket,
            mnemonic: execution.mnemonic,
            word: MotionControl::default(),
            reported: control.word.flags,
            survivors: Flag::En.mask(),
            changed: control.changed,
            moved: false,
            cause: Cause::Itself,
        };
        self.write(execution, Flag::En.mask(), 0);
        if busy && execution.control != UNNAMED {
            return Err(MotionError::ExecutionCollision);
        }
        Ok(())
    }

    /// Sets and clears FLAGS bits of an execution.
    pub(crate) fn write(&mut self, execution: Execution, set: u32, clear: u32) {
        self.change(execution, set, clear, None);
    }

    /// Sets or clears one FLAGS bit of an execution.
    pub(crate) fn flag(&mut self, execution: Execution, flag: Flag, on: bool) {
        let (set, clear) = if on { (flag.mask(), 0) } else { (0, flag.mask()) };
        self.write(execution, set, clear);
    }

    /// Ends an execution with an error. IP and AC clear; DN stays as it is.
    pub(crate) fn fail(&mut self, execution: Execution, error: MotionError) {
        self.change(execution, Flag::Er.mask(), UNDER_WAY, Some(error));
    }

    /// Sets SEGMENT of an execution that its tag still shows.
    pub(crate) fn set_segment(&mut self, execution: Execution, segment: i32) {
        let Some(control) = self.table.get_mut(execution.control.0 as usize) else {
            return;
        };
        if control.ticket == execution.ticket && control.word.segment != segment {
            control.word.segment = segment;
            control.moved = true;
            self.change(execution, 0, 0, None);
        }
    }

    /// A false rung: EN clears once DN or ER is set.
    pub(crate) fn rung_false(&mut self, slot: ControlSlot) {
        let Some(control) = self.table.get(slot.0 as usize) else {
            return;
        };
        if control.word.has(Flag::Dn) || control.word.has(Flag::Er) {
            let shown = Execution {
                ticket: control.ticket,
                control: slot,
                mnemonic: control.mnemonic,
            };
            self.write(shown, 0, Flag::En.mask());
        }
    }

    /// The status that the tag shows.
    pub(crate) fn word(&self, slot: ControlSlot) -> MotionControl {
        self.table
            .get(slot.0 as usize)
            .map_or_else(MotionControl::default, |control| control.word)
    }

    /// Every change and every write to a tag is reported.
    pub(crate) fn are_reported(&self) -> bool {
        self.changed.is_empty() && self.events.is_empty() && self.instruction_writes.is_empty()
    }

    /// Reports every change since the last call, in the order in which they began.
    pub(crate) fn drain(&mut self, mut report: impl FnMut(&Event)) {
        for index in 0..self.changed.len() {
            let slot = ControlSlot(self.changed[index]);
            self.report(slot);
        }
        self.changed.clear();
        self.events.iter().for_each(&mut report);
        self.events.clear();
    }

    /// Ends an instruction that is under way; it reports no further changes.
    pub(crate) fn end_move(&mut self, execution: Execution, set: u32) {
        // Homing is done when it ends, even without PC.
        let set = match execution.mnemonic {
            Mnemonic::Mah => set | Flag::Dn.mask(),
            _ => set,
        };
        // Calculated Data of a move that did not reach its end is invalid.
        let calculated = if set & Flag::Pc.mask() == 0 {
            Flag::CalculatedDataAvailable.mask()
        } else {
            0
        };
        self.write(execution, set, (UNDER_WAY | calculated) & !set);
    }

    /// Ends the instructions of the links that exist.
    pub(crate) fn end_links(&mut self, ended: impl IntoIterator<Item = Option<Execution>>) {
        for execution in ended.into_iter().flatten() {
            self.end_move(execution, 0);
        }
    }

    /// Writes Calculated Data and sets the bit that announces it.
    pub(crate) fn give(&mut self, execution: Execution, events: &Events) {
        self.write_to_tag(events.write(self.tick));
        self.write(execution, Flag::CalculatedDataAvailable.mask(), 0);
    }

    /// The tick has room for another write to a tag.
    pub(crate) fn has_room_for_instruction_write(&self) -> bool {
        self.instruction_writes.len() < INSTRUCTION_WRITES
    }

    /// Notes a write to a tag, if there is room for it.
    pub(crate) fn write_to_tag(&mut self, write: InstructionWrite) {
        if self.has_room_for_instruction_write() {
            self.instruction_writes.push(write);
        }
    }

    /// Reports every write to a tag since the last call, in order.
    pub(crate) fn take_instruction_writes(&mut self, report: impl FnMut(&InstructionWrite)) {
        self.instruction_writes.iter().for_each(report);
        self.instruction_writes.clear();
    }

    /// The number of events lost for lack of room since the start.
    pub(crate) fn lost(&self) -> u64 {
        self.lost
    }

    fn change(&mut self, execution: Execution, set: u32, clear: u32, error: Option<MotionError>) {
        let ends = clear & Flag::Ip.mask() != 0 && set & (Flag::Pc.mask() | Flag::Er.mask()) == 0;
        let cause = if ends { self.cause } else { Cause::Itself };
        let Some(control) = self.table.get_mut(execution.control.0 as usize) else {
            return;
        };
        if control.ticket != execution.ticket {
            let (err, exerr) = error.map_or((0, 0), |error| (error.err(), error.exerr()));
            self.push(Event {
                tick: self.tick,
                ticket: execution.ticket,
                control: execution.control,
                owner: false,
                mnemonic: execution.mnemonic,
                set,
                clear,
                err,
                exerr,
                segment: 0,
                cause,
            });
            return;
        }
        if ends && control.word.has(Flag::Ip) {
            control.cause = cause;
        }
        control.word.flags = (control.word.flags & !clear) | set;
        if let Some(error) = error {
            control.word.err = error.err();
            control.word.exerr = error.exerr();
        }
        if !control.changed {
            control.changed = true;
            self.changed.push(execution.control.0);
        }
    }

    fn report(&mut self, slot: ControlSlot) {
        let Some(control) = self.table.get_mut(slot.0 as usize) else {
            return;
        };
        if !control.changed {
            return;
        }
        let now = control.word.flags;
        let event = Event {
            tick: self.tick,
            ticket: control.ticket,
            control: slot,
            owner: true,
            mnemonic: control.mnemonic,
            set: now & !(control.reported & control.survivors),
            clear: control.reported & !now,
            err: control.word.err,
            exerr: control.word.exerr,
            segment: control.word.segment,
            cause: std::mem::take(&mut control.cause),
        };
        control.reported = now;
        control.survivors = u32::MAX;
        control.changed = false;
        let moved = std::mem::take(&mut control.moved);
        if event.set | event.clear != 0 || moved {
            self.push(event);
        }
    }

    fn push(&mut self, event: Event) {
        if self.events.len() < EVENTS {
            self.events.push(event);
        } else {
            self.lost += 1;
        }
    }
}
