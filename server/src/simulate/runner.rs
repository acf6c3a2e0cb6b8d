//! A simulation: the program runs within a tick, and while it waits the ticks pass: each is ended, its events are written
//! down, and the next one begins.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use arcline_controller::image::{Edge, Image, TagKind};
use arcline_controller::machine::Machine;
use arcline_controller::{Cause, ContourRequest, Controller, Event, FaultChange, Snapshot, Ticket, UNNAMED};
use arcline_instruction_set::{
    AxisId, BindError, Call, ControlSlot, Directory, Flag, Mnemonic, MotionControl, SystemId, bind, describe,
};
use arcline_structured_text::{
    BoundCall, Called, Calls, Driver, Interpreter, ObjectAttribute, OnError, Outcome, Pause, Policy, ProgramRun,
    Progress, Reading, RunError, Stopped, immediately, unmade_control,
};
use arcline_tag::{TagPath, Value};

use super::pieces::Piece;
use crate::cli::Failure;
use crate::plant::ending;

/// Calls and their ends that are remembered, so that memory does not grow with the program.
const REMEMBERED: usize = 1 << 16;

/// How to run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Longest simulated time, s.
    pub(crate) until: f64,
    pub(crate) policy: Policy,
}

/// How a run ended.
#[derive(Debug)]
pub(crate) enum End {
    /// The program ran to its end and all motion ended.
    Finished,
    /// An instruction erred, and the motion that had begun ended.
    Erred(Erred),
    /// The program could not go on.
    Wrong(RunError<Refused>),
    /// So many seconds passed.
    TooLong(f64),
    /// Its observer has seen enough.
    Left,
    /// The next piece of the program cannot be read.
    Unread(Failure),
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

/// Why a statement did not run.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Refused {
    #[error(transparent)]
    Bind(#[from] BindError),
    #[error(transparent)]
    Control(#[from] arcline_controller::image::ControlError),
    #[error("there is no axis or coordinate system {name}")]
    NoObject { name: String },
    #[error(transparent)]
    Read(#[from] arcline_controller::image::ReadError),
    #[error(transparent)]
    Write(#[from] arcline_controller::image::WriteError),
    /// An instruction erred: this one, or an earlier one in a tick that has passed.
    #[error("an instruction erred")]
    Erred { err: i16 },
    /// Nothing that could make the condition of a WAIT true goes on.
    #[error("WAIT can no longer come true: every axis is at rest, and nothing has changed for {STILL_SECONDS} s")]
    Still,
    /// The simulation ends while the program waits.
    #[error("the simulation ended")]
    Ended(Box<End>),
}

/// Simulated seconds that a WAIT lasts while the machine is at rest. Only the program moves a simulated machine, and whatever a drive or
/// a servo still does is over long before.
const STILL_SECONDS: u32 = 60;

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

/// A controller and a program on a virtual clock.
#[derive(Debug)]
pub(crate) struct Runner<'m> {
    simulation: Simulation<'m>,
    program: ProgramRun<Ticket>,
}

/// The controller, its tags, and what the program has done to them.
#[derive(Debug)]
struct Simulation<'m> {
    machine: &'m Machine,
    controller: Controller,
    image: Image,
    options: Options,
    /// Line of the statement that runs.
    line: usize,
    /// Instructions that were executed: the newest ticket.
    executed: u64,
    /// The newest calls, by ticket: lines, instructions and motion control tags.
    calls: VecDeque<(usize, Mnemonic, ControlSlot)>,
    snapshot: Snapshot,
    contour: ContourRequest,
    /// The tick whose state the image shows.
    shown: Option<u64>,
    /// What the WAIT has read so far: the slots and what they showed.
    watched: Vec<(ControlSlot, MotionControl)>,
    /// Whether it has read anything else that changes by itself.
    reads_motion: bool,
    /// The newest execution of a motion control tag.
    newest: BTreeMap<ControlSlot, (Ticket, Mnemonic)>,
    /// What ended executions that did not come to their end.
    causes: BTreeMap<Ticket, Cause>,
    events: Vec<Event>,
    /// What was accepted in this tick.
    accepted: Vec<(Ticket, Call)>,
    erred: Option<Erred>,
    /// The first tick since which the program waits for a condition and the machine is at rest.
    still_since: Option<u64>,
}

impl<'m> Runner<'m> {
    pub(crate) fn new(machine: &'m Machine, image: Image, interpreter: Interpreter, options: Options) -> Self {
        let simulation = Simulation {
            machine,
            controller: Controller::new(machine),
            image,
            options,
            line: 1,
            executed: 0,
            calls: VecDeque::new(),
            snapshot: Snapshot::new(machine),
            contour: ContourRequest::new(),
            shown: None,
            watched: Vec::new(),
            reads_motion: false,
            newest: BTreeMap::new(),
            causes: BTreeMap::new(),
            events: Vec::new(),
            accepted: Vec::new(),
            erred: None,
            still_since: None,
        };
        Runner {
            simulation,
            program: ProgramRun::new(interpreter, options.policy),
        }
    }

    /// Takes the overrides and injected faults that the image has; a hold would have no end, and is none.
    pub(crate) fn take_overrides(&mut self) {
        self.simulation.take_overrides();
    }

    /// Executions that a fault ended before their end: line, instruction, tag, and the fault.
    pub(super) fn stopped(&self) -> Vec<String> {
        self.simulation.stopped()
    }

    /// Instructions that were executed.
    pub(super) fn executed(&self) -> u64 {
        self.simulation.executed
    }

    /// Command positions of the axes.
    #[cfg(test)]
    pub(crate) fn positions(&self) -> Vec<f64> {
        self.simulation.controller.trace().map(|axis| axis[0]).collect()
    }

    /// Runs until everything has ended.
    pub(crate) fn run(&mut self, observer: &mut impl Observer) -> End {
        self.run_pieces(observer, &mut |_| Ok(None))
    }

    /// The same with further pieces of the program, each asked for when the one before has run.
    pub(super) fn run_pieces(
        &mut self,
        observer: &mut impl Observer,
        next: &mut dyn FnMut(&Image) -> Result<Option<Piece>, Failure>,
    ) -> End {
        let simulation = &mut self.simulation;
        observer.begin(simulation.machine);
        simulation.controller.begin_tick();
        let mut ticks = Ticks {
            simulation: &mut *simulation,
            observer,
            is_open: true,
        };
        let mut ran = immediately(self.program.run(&mut ticks));
        while ran.is_ok() {
            match next(&ticks.simulation.image) {
                Ok(None) => break,
                Ok(Some(piece)) => self.program.load(piece.interpreter, piece.lines_before),
                Err(failure) => return End::Unread(failure),
            }
            ran = immediately(self.program.run(&mut ticks));
        }
        let wrong = match ran {
            Ok(()) => None,
            Err(RunError::Driver {
                error: Refused::Ended(end),
                ..
            }) => return *end,
            Err(RunError::Driver {
                error: Refused::Erred { .. },
                ..
            }) => None,
            Err(
                wrong @ RunError::Driver {
                    error: Refused::Still, ..
                },
            ) => return End::Wrong(wrong),
            Err(wrong) => Some(wrong),
        };
        if let Err(end) = ticks.come_to_rest() {
            return end;
        }
        match (wrong, simulation.erred.take()) {
            (Some(wrong), _) => End::Wrong(wrong),
            (None, Some(erred)) if !simulation.keeps_going() => End::Erred(erred),
            (None, _) => End::Finished,
        }
    }
}

impl Simulation<'_> {
    fn keeps_going(&self) -> bool {
        self.options.policy.on_error == OnError::KeepGoing
    }

    /// The error that ends the program.
    fn check(&self) -> Result<(), Refused> {
        match &self.erred {
            Some(erred) if !self.keeps_going() => Err(Refused::Erred { err: erred.err }),
            _ => Ok(()),
        }
    }

    /// Simulated time at the end of the present tick, s.
    fn time(&self) -> f64 {
        (self.controller.tick_number() as f64 * self.machine.period_ns as f64) / 1e9
    }

    fn take_overrides(&mut self) {
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

    fn stopped(&self) -> Vec<String> {
        let by_fault = self
            .causes
            .iter()
            .filter(|(_, cause)| matches!(cause, Cause::Fault { .. }));
        let told = by_fault.filter_map(|(ticket, cause)| {
            let (line, mnemonic, tag) = self.call_of(*ticket)?;
            let ending = ending(self.machine, &self.image, *cause)?;
            let tag = self.image.control_name(tag);
            let blank = if tag.is_empty() { "" } else { " " };
            Some(format!("line {line}: {mnemonic}{blank}{tag} was {ending}"))
        });
        told.collect()
    }

    /// Reads a tag: a motion control as the controller has it in this moment, everything else from the image.
    ///
    /// Nothing but the program executes instructions here: one that has ended, or never began, stays so during a WAIT.
    fn read(&mut self, path: &TagPath) -> Result<Reading, Refused> {
        let mut settled = false;
        let tag = path.tag().and_then(|name| self.image.find(name));
        match tag.map(|tag| tag.kind) {
            Some(TagKind::MotionControl(slot)) => settled = self.watch(slot),
            Some(TagKind::Instruction(kind)) => settled = self.watch(kind.control),
            Some(TagKind::Plain) => {
                self.image.show_uses();
                // Output cams write it.
                self.reads_motion |= self.image.is_output(path);
            }
            Some(TagKind::FeedOverride | TagKind::FaultInject | TagKind::MotionInhibit) => {}
            Some(_) => {
                self.reads_motion = true;
                self.show();
            }
            // A motion control that is made later in the program.
            None => {
                if let Some(value) = unmade_control(path) {
                    return Ok(Reading::Settled(value));
                }
            }
        }
        let value = self.image.read(path)?;
        Ok(if settled {
            Reading::Settled(value)
        } else {
            Reading::Value(value)
        })
    }

    /// Brings a motion control in the image up to the moment, and remembers it for the WAIT. Whether it cannot change any
    /// more.
    fn watch(&mut self, slot: ControlSlot) -> bool {
        let control = self.controller.control(slot);
        self.image.set_control(slot, control);
        self.watched.push((slot, control));
        control.has_ended() || control == MotionControl::default()
    }

    /// The state of a motion control tag.
    fn outcome(&self, tag: &str) -> Outcome {
        let slot = match self.image.find(tag).map(|tag| tag.kind) {
            Some(TagKind::MotionControl(slot)) => Some(slot),
            Some(TagKind::Instruction(kind)) => Some(kind.control),
            _ => None,
        };
        let newest = slot.and_then(|slot| self.newest.get(&slot)).copied();
        let cause = newest.and_then(|(ticket, _)| self.causes.get(&ticket)).copied();
        Outcome {
            call: newest.map(|(ticket, mnemonic)| (mnemonic, self.line_of(ticket))),
            control: slot.map_or_else(MotionControl::default, |slot| self.controller.control(slot)),
            ending: cause.and_then(|cause| ending(self.machine, &self.image, cause)),
        }
    }

    /// Ends a WAIT during which the machine has been at rest for [`STILL_SECONDS`].
    fn check_still(&mut self) -> Result<(), Refused> {
        if !self.controller.is_still() {
            self.still_since = None;
            return Ok(());
        }
        let tick = self.controller.tick_number();
        let since = *self.still_since.get_or_insert(tick);
        let still_ns = u128::from(tick - since) * u128::from(self.machine.period_ns);
        if still_ns >= u128::from(STILL_SECONDS) * 1_000_000_000 {
            return Err(Refused::Still);
        }
        Ok(())
    }

    /// Whether the program may have something to do in this tick.
    fn is_due(&self, wake: &Wake) -> bool {
        match wake {
            Wake::Next | Wake::Condition => true,
            Wake::Change => self
                .watched
                .iter()
                .any(|(slot, shown)| self.controller.control(*slot) != *shown),
            Wake::Room(call) => self.controller.has_room(call),
            Wake::At(tick) => self.controller.tick_number() >= *tick,
        }
    }

    /// Line, instruction and motion control tag of a call; `None`: it is too old.
    fn call_of(&self, ticket: Ticket) -> Option<(usize, Mnemonic, ControlSlot)> {
        let first = self.executed + 1 - self.calls.len() as u64;
        let index = usize::try_from(ticket.0.checked_sub(first)?).ok()?;
        self.calls.get(index).copied()
    }

    fn line_of(&self, ticket: Ticket) -> usize {
        self.call_of(ticket).map_or(0, |(line, ..)| line)
    }

    /// Brings axes and coordinate systems in the image up to this tick.
    fn show(&mut self) {
        let tick = self.controller.tick_number();
        if self.shown != Some(tick) {
            self.controller.snapshot(&mut self.snapshot);
            self.image.apply_snapshot(&self.snapshot);
            self.shown = Some(tick);
        }
    }

    fn bind(&mut self, call: &BoundCall) -> Result<Call, Refused> {
        let target = self.image.object(call.mnemonic.instruction().object, &call.target);
        let control = match &call.control {
            Some(name) => self.image.control_slot(name)?,
            None => UNNAMED,
        };
        Ok(bind(call.mnemonic, target, control, &call.given, &self.image)?)
    }

    fn execute(&mut self, call: &Call) -> (Ticket, MotionControl) {
        if self.calls.len() == REMEMBERED {
            self.calls.pop_front();
        }
        self.calls.push_back((self.line, call.mnemonic, call.control));
        self.executed += 1;
        let ticket = Ticket(self.executed);
        self.newest.insert(call.control, (ticket, call.mnemonic));
        self.still_since = None;
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
        (ticket, control)
    }

    fn edge(&mut self, edge: Option<Edge>) -> Result<(), Refused> {
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
                if let Some(call) = self.image.call_of(id).transpose()? {
                    self.execute(&call);
                }
            }
            Some(Edge::Falling(id)) => {
                if let Some(TagKind::Instruction(kind)) = self.image.tag(id).map(|tag| tag.kind) {
                    self.controller.rung_false(kind.control);
                }
            }
        }
        self.check()
    }

    fn take_events(&mut self, observer: &mut impl Observer, time: f64) {
        for event in std::mem::take(&mut self.events) {
            self.image.apply_event(&event);
            if event.cause != Cause::Itself {
                if self.causes.len() == REMEMBERED {
                    self.causes.pop_first();
                }
                self.causes.insert(event.ticket, event.cause);
            }
            observer.event(&event, time, &self.image);
            if event.set & Flag::Er.mask() != 0 {
                self.err(event.control, event.mnemonic, event.ticket, event.err, event.exerr);
            }
        }
    }

    /// Remembers the first error.
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
    }
}

/// When the program continues.
enum Wake {
    /// In the next tick.
    Next,
    /// In the next tick, in which the condition of a WAIT may have changed.
    Condition,
    /// When a motion control tag that it has read shows something else.
    Change,
    /// When there is room for the move.
    Room(Box<Call>),
    /// In that tick.
    At(u64),
}

/// The ticks of a simulation, which pass while the program waits.
struct Ticks<'s, 'm, O> {
    simulation: &'s mut Simulation<'m>,
    observer: &'s mut O,
    /// Whether instructions can be executed: the present tick has begun and not ended.
    is_open: bool,
}

impl<O: Observer> Ticks<'_, '_, O> {
    fn begin(&mut self) {
        self.simulation.controller.begin_tick();
        self.is_open = true;
    }

    /// Ends the present tick.
    fn end(&mut self) -> Result<(), End> {
        let Ticks {
            simulation, observer, ..
        } = self;
        let tick = simulation.controller.tick_number();
        let (time, machine) = (simulation.time(), simulation.machine);
        for (ticket, call) in simulation.accepted.drain(..) {
            observer.accepted(ticket, &call);
        }
        let controller = &mut simulation.controller;
        controller.plan_contours(&mut simulation.contour);
        controller.take_fault_changes(|change| observer.fault(change, time, machine));
        controller.end_tick(|event| simulation.events.push(*event));
        let image = &mut simulation.image;
        controller.take_array_writes(|write| image.apply_array_write(write));
        if !simulation.events.is_empty() {
            simulation.take_events(*observer, time);
        }
        self.is_open = false;
        if observer.tick(tick, machine, &mut simulation.controller) {
            Ok(())
        } else {
            Err(End::Left)
        }
    }

    /// The end of the simulated time.
    fn check_time(&self) -> Result<(), End> {
        let Options { until, .. } = self.simulation.options;
        if self.simulation.time() >= until {
            return Err(End::TooLong(until));
        }
        Ok(())
    }

    /// Lets ticks pass until the program may continue.
    fn pass(&mut self, wake: &Wake) -> Result<(), Refused> {
        loop {
            self.end()?;
            self.simulation.check()?;
            self.check_time()?;
            if matches!(wake, Wake::Change | Wake::Condition) {
                self.simulation.check_still()?;
            }
            self.begin();
            if self.simulation.is_due(wake) {
                return Ok(());
            }
        }
    }

    /// Lets ticks pass until all motion has ended.
    fn come_to_rest(&mut self) -> Result<(), End> {
        loop {
            if self.is_open {
                self.end()?;
            }
            if self.simulation.controller.at_rest() {
                return Ok(());
            }
            self.check_time()?;
            self.begin();
        }
    }
}

impl From<End> for Refused {
    fn from(end: End) -> Self {
        Refused::Ended(Box::new(end))
    }
}

impl<O: Observer> Driver for Ticks<'_, '_, O> {
    type Error = Refused;
    type Execution = Ticket;

    // Events report errors.
    const LOOKS: usize = 0;

    async fn turn(&mut self, line: usize) -> Result<(), Refused> {
        self.simulation.line = line;
        Ok(())
    }

    async fn read(&mut self, path: &TagPath, _calls: &Calls<Ticket>) -> Result<Reading, Refused> {
        self.simulation.read(path)
    }

    async fn read_array(&mut self, path: &TagPath) -> Result<Vec<f64>, Refused> {
        self.simulation.show();
        Ok(self.simulation.image.read_numbers(path)?)
    }

    async fn write(&mut self, path: &TagPath, value: Value) -> Result<(), Refused> {
        let edge = self.simulation.image.write_value(path, value)?;
        self.simulation.edge(edge)
    }

    async fn attribute(&mut self, of: &ObjectAttribute) -> Result<f64, Refused> {
        let Simulation { image, machine, .. } = &*self.simulation;
        let index = image.object(of.attribute.object, &of.name);
        let value = index.and_then(|index| image.attribute(machine, of.attribute, index));
        value.ok_or_else(|| no_object(of))
    }

    async fn set_attribute(&mut self, of: &ObjectAttribute, value: f64) -> Result<(), Refused> {
        let image = &mut self.simulation.image;
        let index = image.object(of.attribute.object, &of.name);
        let index = index.ok_or_else(|| no_object(of))?;
        let edge = image.set_attribute(of.attribute, index, value)?;
        self.simulation.edge(Some(edge))
    }

    async fn has_room(&mut self, call: &BoundCall) -> Result<bool, Refused> {
        let call = self.simulation.bind(call)?;
        Ok(self.simulation.controller.has_room(&call))
    }

    async fn call(&mut self, bound: &BoundCall) -> Result<Ticket, Refused> {
        let simulation = &mut *self.simulation;
        let call = simulation.bind(bound)?;
        let (ticket, control) = simulation.execute(&call);
        if let Some(erred) = simulation.erred.as_mut().filter(|erred| erred.line == bound.line) {
            let instruction = bound.mnemonic.instruction();
            erred.left_out = instruction.left_out(erred.err, erred.exerr, &bound.given);
        }
        if control.has(Flag::Er) {
            return Err(Refused::Erred { err: control.err });
        }
        Ok(ticket)
    }

    async fn pause(&mut self, pause: Pause<'_>) -> Result<(), Refused> {
        if pause != Pause::Condition {
            self.simulation.still_since = None;
        }
        let wake = match pause {
            Pause::Condition if !self.simulation.reads_motion => Wake::Change,
            Pause::Condition => Wake::Condition,
            Pause::Tick | Pause::Queue { .. } | Pause::Motion => Wake::Next,
            Pause::Room(call) => Wake::Room(Box::new(self.simulation.bind(call)?)),
            Pause::Seconds(seconds) => {
                let nanoseconds = (seconds * 1e9).round() as u64;
                let ticks = nanoseconds.div_ceil(self.simulation.machine.period_ns).max(1);
                Wake::At(self.simulation.controller.tick_number().saturating_add(ticks))
            }
        };
        self.pass(&wake)?;
        self.simulation.watched.clear();
        self.simulation.reads_motion = false;
        Ok(())
    }

    async fn progress(&mut self, _called: &Called<Ticket>) -> Result<Progress<Refused>, Refused> {
        Ok(Progress::Ended)
    }

    async fn stopped(&mut self, _called: &Called<Ticket>) -> Result<Option<Stopped<Refused>>, Refused> {
        Ok(None)
    }

    async fn outcome(&mut self, tag: &str, _called: Option<&Called<Ticket>>) -> Result<Outcome, Refused> {
        Ok(self.simulation.outcome(tag))
    }

    fn err(error: &Refused) -> Option<i16> {
        match error {
            Refused::Erred { err } => Some(*err),
            _ => None,
        }
    }
}

fn no_object(of: &ObjectAttribute) -> Refused {
    Refused::NoObject { name: of.name.clone() }
}
