//! The loop of a simulation: begin the tick, let the program run in it, end it, write down what happened.

use std::collections::BTreeMap;
use std::fmt;

use arcline_controller::image::{Edge, Image, TagKind};
use arcline_controller::machine::Machine;
use arcline_controller::{Cause, ContourRequest, Controller, Event, FaultChange, Snapshot, Ticket, UNNAMED};
use arcline_instruction_set::{
    AxisId, BindError, Call, ControlSlot, Directory, Flag, Mnemonic, MotionControl, SystemId, bind, describe,
};
use arcline_structured_text::{Answer, BoundCall, Hopeless, Interpreter, Request, RuntimeError, unmade_control};
use arcline_tag::{TagPath, Value};

use crate::cli::QueueFull;
use crate::plant::ending;

/// How to run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Longest simulated time, s.
    pub(crate) until: f64,
    pub(crate) keep_going: bool,
    pub(crate) queue_full: QueueFull,
}

/// How a run ended.
#[derive(Debug)]
pub(crate) enum End {
    /// The program ran to its end and all motion ended.
    Finished,
    /// An instruction erred, and the motion that had begun ended.
    Erred(Erred),
    /// The program could not go on.
    Wrong(Wrong),
    /// So many seconds passed.
    TooLong(f64),
    /// Its observer has seen enough.
    Left,
}

/// An instruction that erred.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Erred {
    tag: String,
    mnemonic: Mnemonic,
    line: usize,
    err: i16,
    exerr: i8,
    /// The operand at fault, where it was left out.
    left_out: Option<&'static str>,
}

impl fmt::Display for Erred {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tag = if self.tag.is_empty() { "without tag" } else { &self.tag };
        let text = describe(self.err, self.exerr, Some(self.mnemonic));
        write!(f, "line {}: {} ({tag}): {text}", self.line, self.mnemonic)?;
        match self.left_out {
            Some(operand) => write!(f, ": {operand} was not given"),
            None => Ok(()),
        }
    }
}

/// A statement that cannot be executed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Wrong {
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    #[error(transparent)]
    Hopeless(#[from] Hopeless),
    #[error("line {line}: {error}")]
    Bind { line: usize, error: BindError },
    #[error("line {line}: {error}")]
    Control {
        line: usize,
        error: arcline_controller::image::ControlError,
    },
    #[error("line {line}: there is no axis or coordinate system {name}")]
    NoObject { line: usize, name: String },
    #[error("line {line}: {error}")]
    Read {
        line: usize,
        error: arcline_controller::image::ReadError,
    },
    #[error("line {line}: {error}")]
    Write {
        line: usize,
        error: arcline_controller::image::WriteError,
    },
}

/// Sees a simulation, tick by tick.
pub(crate) trait Observer {
    /// Before the first tick.
    fn begin(&mut self, machine: &Machine) {
        let _ = machine;
    }
    /// An instruction was accepted in this tick.
    fn accepted(&mut self, ticket: Ticket, call: &Call) {
        let _ = (ticket, call);
    }
    /// The state at the end of a tick. False: it has seen enough.
    fn tick(&mut self, tick: u64, machine: &Machine, controller: &mut Controller) -> bool;
    /// A change of an instruction's status, s after the beginning.
    fn event(&mut self, event: &Event, time: f64, image: &Image);
    /// A change of the faults of an axis, s after the beginning.
    fn fault(&mut self, change: &FaultChange, time: f64, machine: &Machine) {
        let _ = (change, time, machine);
    }
}

impl Erred {
    /// ERR, EXERR, the instruction, and the line of its call.
    pub(crate) fn codes(&self) -> (i16, i8, Mnemonic, usize) {
        (self.err, self.exerr, self.mnemonic, self.line)
    }
}

/// What the program does at the next tick.
#[derive(Debug)]
enum Program {
    /// Goes on.
    Ready(Answer),
    /// A WAIT that reads motion control tags only: goes on when one of them shows something else.
    Watching,
    /// Goes on at that tick.
    Until(u64),
    /// A move waits for room in the queue.
    Queued(Box<Call>, usize),
    Ended,
}

/// A controller and a program on a virtual clock.
#[derive(Debug)]
pub(crate) struct Runner<'m> {
    machine: &'m Machine,
    controller: Controller,
    image: Image,
    interpreter: Interpreter,
    options: Options,
    program: Program,
    /// Lines of the calls, by ticket.
    lines: Vec<usize>,
    /// Their instructions and motion control tags, by ticket.
    calls: Vec<(Mnemonic, ControlSlot)>,
    snapshot: Snapshot,
    contour: ContourRequest,
    /// The tick whose state the image shows.
    shown: Option<u64>,
    /// What the WAIT has read so far: the slots and what they showed.
    watched: Vec<(ControlSlot, MotionControl)>,
    /// Whether it has read anything else that changes by itself.
    reads_motion: bool,
    /// The motion control tags that cannot change any more, of those that the WAIT has read, and their slots.
    settled: Vec<(String, Option<ControlSlot>)>,
    /// Whether the WAIT was without hope a tick ago.
    was_hopeless: bool,
    /// The newest execution of a motion control tag.
    newest: BTreeMap<ControlSlot, (Ticket, Mnemonic)>,
    /// What ended executions that did not come to their end.
    causes: BTreeMap<Ticket, Cause>,
    events: Vec<Event>,
    /// What was accepted in this tick.
    accepted: Vec<(Ticket, Call)>,
    erred: Option<Erred>,
    wrong: Option<Wrong>,
}

impl<'m> Runner<'m> {
    pub(crate) fn new(machine: &'m Machine, image: Image, interpreter: Interpreter, options: Options) -> Self {
        Runner {
            machine,
            controller: Controller::new(machine),
            image,
            interpreter,
            options,
            program: Program::Ready(Answer::Start),
            lines: Vec::new(),
            calls: Vec::new(),
            snapshot: Snapshot::new(machine),
            contour: ContourRequest::new(),
            shown: None,
            watched: Vec::new(),
            reads_motion: false,
            settled: Vec::new(),
            was_hopeless: false,
            newest: BTreeMap::new(),
            causes: BTreeMap::new(),
            events: Vec::new(),
            accepted: Vec::new(),
            erred: None,
            wrong: None,
        }
    }

    /// Takes the overrides and injected faults that the image has; a hold would have no end, and is none.
    pub(crate) fn take_overrides(&mut self) {
        for (system, percent) in (0..).map(SystemId).zip(self.image.feed_overrides()) {
            let share = if percent > 0.0 { f64::from(percent) / 100.0 } else { 1.0 };
            self.controller.set_override(system, share);
        }
        for (axis, causes) in (0..).map(AxisId).zip(self.image.injected_faults()) {
            self.controller.inject(axis, causes);
        }
        for (object, index, bits) in self.image.dynamics_bits() {
            self.controller.set_dynamics_bits(object, index, bits);
        }
    }

    /// Executions that a fault ended before their end: line, instruction, tag, and the fault.
    pub(super) fn stopped(&self) -> Vec<String> {
        let by_fault = self
            .causes
            .iter()
            .filter(|(_, cause)| matches!(cause, Cause::Fault { .. }));
        let told = by_fault.filter_map(|(ticket, cause)| {
            let (mnemonic, tag) = self.calls.get((ticket.0 as usize).checked_sub(1)?)?;
            let ending = ending(self.machine, &self.image, *cause)?;
            let tag = self.image.control_name(*tag);
            let blank = if tag.is_empty() { "" } else { " " };
            Some(format!(
                "line {}: {mnemonic}{blank}{tag} was {ending}",
                self.line_of(*ticket)
            ))
        });
        told.collect()
    }

    /// Instructions that were executed.
    pub(super) fn executed(&self) -> usize {
        self.lines.len()
    }

    /// Runs until everything has ended.
    pub(crate) fn run(&mut self, observer: &mut impl Observer) -> End {
        observer.begin(self.machine);
        let period = self.machine.period_ns;
        let time = |tick: u64| (tick as f64 * period as f64) / 1e9;
        loop {
            self.controller.begin_tick();
            let tick = self.controller.tick_number();
            if self.is_due(tick) {
                self.advance(tick);
                self.accepted
                    .drain(..)
                    .for_each(|(ticket, call)| observer.accepted(ticket, &call));
            }
            self.controller.plan_contours(&mut self.contour);
            let machine = self.machine;
            self.controller
                .take_fault_changes(|change| observer.fault(change, time(tick), machine));
            self.controller.end_tick(|event| self.events.push(*event));
            let image = &mut self.image;
            self.controller
                .take_array_writes(|write| image.apply_array_write(write));
            if !self.events.is_empty() {
                self.take_events(observer, time(tick));
            }
            if !observer.tick(tick, self.machine, &mut self.controller) {
                return End::Left;
            }
            if matches!(self.program, Program::Ended) && self.controller.at_rest() {
                return match (self.wrong.take(), self.erred.take()) {
                    (Some(wrong), _) => End::Wrong(wrong),
                    (None, Some(erred)) if !self.options.keep_going => End::Erred(erred),
                    (None, _) => End::Finished,
                };
            }
            if time(tick) >= self.options.until {
                return End::TooLong(self.options.until);
            }
        }
    }

    /// Whether the program has something to do in this tick.
    fn is_due(&self, tick: u64) -> bool {
        match &self.program {
            Program::Ready(_) => true,
            Program::Watching => self
                .watched
                .iter()
                .any(|(slot, shown)| self.controller.control(*slot) != *shown),
            Program::Until(due) => tick >= *due,
            Program::Queued(call, _) => self.controller.has_room(call),
            Program::Ended => false,
        }
    }

    /// Runs the program up to its next pause.
    fn advance(&mut self, tick: u64) {
        self.watched.clear();
        self.settled.clear();
        self.reads_motion = false;
        let mut answer = match std::mem::replace(&mut self.program, Program::Ended) {
            Program::Ready(answer) => answer,
            Program::Watching | Program::Until(_) => Answer::Done,
            Program::Queued(call, line) => {
                self.execute(&call, line);
                Answer::Done
            }
            Program::Ended => return,
        };
        loop {
            // An error ends the program at its own statement, not at the end of the tick.
            if self.erred.is_some() && !self.options.keep_going {
                return;
            }
            match self.request(answer, tick) {
                Ok(Next::Answer(next)) => answer = next,
                Ok(Next::Pause(program)) => {
                    self.program = program;
                    return;
                }
                Err(wrong) => {
                    self.wrong = Some(wrong);
                    return;
                }
            }
        }
    }

    fn request(&mut self, answer: Answer, tick: u64) -> Result<Next, Wrong> {
        let request = self.interpreter.resume(answer)?;
        let line = self.interpreter.line();
        Ok(match request {
            Request::Read(path) => Next::Answer(self.read(&path, tick, line)?),
            Request::ReadArray(path) => {
                self.show(tick);
                let numbers = self
                    .image
                    .read_numbers(&path)
                    .map_err(|error| Wrong::Read { line, error })?;
                Next::Answer(Answer::Array(numbers))
            }
            Request::Write(path, value) => {
                let edge = self
                    .image
                    .write_value(&path, value)
                    .map_err(|error| Wrong::Write { line, error })?;
                self.edge(edge, line)?;
                Next::Answer(Answer::Done)
            }
            Request::GetAttribute(of) => {
                let index = self.image.object(of.attribute.object, &of.name).unwrap_or(u16::MAX);
                let value = self.image.attribute(self.machine, of.attribute, index);
                let value = value.ok_or(Wrong::NoObject { line, name: of.name })?;
                Next::Answer(Answer::Value(Value::Lreal(value)))
            }
            Request::SetAttribute(of, value) => {
                let index = self.image.object(of.attribute.object, &of.name).unwrap_or(u16::MAX);
                let edge = self
                    .image
                    .set_attribute(of.attribute, index, value)
                    .map_err(|error| Wrong::Write { line, error })?;
                self.edge(Some(edge), line)?;
                Next::Answer(Answer::Done)
            }
            Request::Call(bound) => {
                self.was_hopeless = false;
                let call = self.bind(&bound)?;
                if self.options.queue_full == QueueFull::Wait && !self.controller.has_room(&call) {
                    return Ok(Next::Pause(Program::Queued(Box::new(call), line)));
                }
                self.execute(&call, line);
                if let Some(erred) = self.erred.as_mut().filter(|erred| erred.line == line) {
                    let instruction = bound.mnemonic.instruction();
                    erred.left_out = instruction.left_out(erred.err, erred.exerr, &bound.given);
                }
                Next::Answer(Answer::Done)
            }
            Request::NextTick if self.interpreter.is_hopeless() => {
                if std::mem::replace(&mut self.was_hopeless, true) {
                    return Err(self.hopeless(line).into());
                }
                // What ended the instruction in this very tick is known at its end.
                Next::Pause(Program::Ready(Answer::Done))
            }
            Request::NextTick if self.interpreter.is_waiting() && !self.reads_motion => Next::Pause(Program::Watching),
            Request::NextTick => Next::Pause(Program::Ready(Answer::Done)),
            Request::Delay(seconds) => {
                let nanoseconds = (seconds * 1e9).round() as u64;
                let ticks = nanoseconds.div_ceil(self.machine.period_ns).max(1);
                Next::Pause(Program::Until(tick.saturating_add(ticks)))
            }
            Request::End => Next::Pause(Program::Ended),
        })
    }

    /// Reads a tag: a motion control as the controller has it in this moment, everything else from the image.
    ///
    /// Nothing but the program executes instructions here: one that has ended, or never began, stays so during a WAIT.
    fn read(&mut self, path: &TagPath, tick: u64, line: usize) -> Result<Answer, Wrong> {
        let mut settled = false;
        let tag = path.tag().and_then(|name| self.image.find(name));
        match tag.map(|tag| tag.kind) {
            Some(TagKind::MotionControl(slot)) => settled = self.watch(path, slot),
            Some(TagKind::Instruction(kind)) => settled = self.watch(path, kind.control),
            Some(TagKind::Plain) => {
                self.image.show_uses();
                // Output cams write it.
                self.reads_motion |= self.image.is_output(path);
            }
            Some(TagKind::FeedOverride | TagKind::FaultInject | TagKind::MotionInhibit) => {}
            Some(_) => {
                self.reads_motion = true;
                self.show(tick);
            }
            // A motion control that is made later in the program.
            None => {
                if let Some(value) = unmade_control(path) {
                    self.settled.push((path.tag().unwrap_or_default().to_owned(), None));
                    return Ok(Answer::Settled(value));
                }
            }
        }
        let value = self.image.read(path).map_err(|error| Wrong::Read { line, error })?;
        Ok(if settled {
            Answer::Settled(value)
        } else {
            Answer::Value(value)
        })
    }

    /// Brings a motion control in the image up to the moment, and remembers it for the WAIT. Whether it cannot change any
    /// more.
    fn watch(&mut self, path: &TagPath, slot: ControlSlot) -> bool {
        let control = self.controller.control(slot);
        self.image.set_control(slot, control);
        self.watched.push((slot, control));
        let settled = control.has_ended() || control == MotionControl::default();
        if settled {
            self.settled
                .push((path.tag().unwrap_or_default().to_owned(), Some(slot)));
        }
        settled
    }

    /// Why the WAIT cannot go on: one that ended before its end if there is one among those that it reads.
    fn hopeless(&self, line: usize) -> Hopeless {
        let shown =
            |slot: &Option<ControlSlot>| slot.map_or_else(MotionControl::default, |slot| self.controller.control(slot));
        let failed = |(_, slot): &&(String, Option<ControlSlot>)| !shown(slot).has(Flag::Pc);
        let found = self.settled.iter().find(failed).or(self.settled.first());
        let Some((tag, slot)) = found else {
            return Hopeless::new(line, "", None, &MotionControl::default(), None);
        };
        let newest = slot.and_then(|slot| self.newest.get(&slot)).copied();
        let call = newest.map(|(ticket, mnemonic)| (mnemonic, self.line_of(ticket)));
        let cause = newest.and_then(|(ticket, _)| self.causes.get(&ticket)).copied();
        let ending = cause.and_then(|cause| ending(self.machine, &self.image, cause));
        Hopeless::new(line, tag, call, &shown(slot), ending.as_ref())
    }

    fn line_of(&self, ticket: Ticket) -> usize {
        let place = (ticket.0 as usize).checked_sub(1);
        place
            .and_then(|place| self.lines.get(place))
            .copied()
            .unwrap_or_default()
    }

    /// Brings axes and coordinate systems in the image up to this tick.
    fn show(&mut self, tick: u64) {
        if self.shown != Some(tick) {
            self.controller.snapshot(&mut self.snapshot);
            self.image.apply_snapshot(&self.snapshot);
            self.shown = Some(tick);
        }
    }

    fn bind(&mut self, call: &BoundCall) -> Result<Call, Wrong> {
        let line = call.line;
        let target = self.image.object(call.mnemonic.instruction().object, &call.target);
        let control = match &call.control {
            Some(name) => self
                .image
                .control_slot(name)
                .map_err(|error| Wrong::Control { line, error })?,
            None => UNNAMED,
        };
        bind(call.mnemonic, target, control, &call.given, &self.image).map_err(|error| Wrong::Bind { line, error })
    }

    fn execute(&mut self, call: &Call, line: usize) {
        self.lines.push(line);
        self.calls.push((call.mnemonic, call.control));
        let ticket = Ticket(self.lines.len() as u64);
        self.newest.insert(call.control, (ticket, call.mnemonic));
        self.shown = None;
        let (data, staged) = self.image.prepare(call);
        let control = self.controller.execute_with(ticket, call, data);
        if let Some(staged) = staged {
            self.image.settle(staged, &control);
        }
        if control.has(Flag::Er) {
            self.err(call.control, call.mnemonic, ticket, control.err, control.exerr);
        } else {
            self.accepted.push((ticket, *call));
        }
    }

    fn edge(&mut self, edge: Option<Edge>, line: usize) -> Result<(), Wrong> {
        match edge {
            None => {}
            Some(Edge::FeedOverride) => {
                for (system, percent) in (0..).map(SystemId).zip(self.image.feed_overrides()) {
                    self.controller.set_override(system, f64::from(percent) / 100.0);
                }
                self.shown = None;
            }
            Some(Edge::FaultInject) => {
                for (axis, causes) in (0..).map(AxisId).zip(self.image.injected_faults()) {
                    self.controller.inject(axis, causes);
                }
            }
            Some(Edge::Inhibit(on)) => {
                self.controller.inhibit(on);
                if on {
                    self.controller.stop_all();
                }
                self.shown = None;
            }
            Some(Edge::DynamicsBits) => {
                for (object, index, bits) in self.image.dynamics_bits() {
                    self.controller.set_dynamics_bits(object, index, bits);
                }
            }
            Some(Edge::Input) => {
                for input in self.image.take_inputs() {
                    self.controller.input(input);
                }
                self.shown = None;
            }
            Some(Edge::Rising(id)) => {
                let call = self
                    .image
                    .call_of(id)
                    .transpose()
                    .map_err(|error| Wrong::Bind { line, error })?;
                if let Some(call) = call {
                    self.execute(&call, line);
                }
            }
            Some(Edge::Falling(id)) => {
                if let Some(TagKind::Instruction(kind)) = self.image.tag(id).map(|tag| tag.kind) {
                    self.controller.rung_false(kind.control);
                }
            }
        }
        Ok(())
    }

    fn take_events(&mut self, observer: &mut impl Observer, time: f64) {
        for event in std::mem::take(&mut self.events) {
            self.image.apply_event(&event);
            if event.cause != Cause::Itself {
                self.causes.insert(event.ticket, event.cause);
            }
            observer.event(&event, time, &self.image);
            if event.set & Flag::Er.mask() != 0 {
                self.err(event.control, event.mnemonic, event.ticket, event.err, event.exerr);
            }
        }
    }

    /// Remembers the first error, and ends the program unless it is to go on.
    fn err(&mut self, control: ControlSlot, mnemonic: Mnemonic, ticket: Ticket, err: i16, exerr: i8) {
        if self.erred.is_none() {
            self.erred = Some(Erred {
                tag: self.image.control_name(control).to_owned(),
                mnemonic,
                line: self.line_of(ticket),
                err,
                exerr,
                left_out: None,
            });
        }
        if !self.options.keep_going {
            self.program = Program::Ended;
        }
    }
}

/// What follows a request.
enum Next {
    Answer(Answer),
    Pause(Program),
}
