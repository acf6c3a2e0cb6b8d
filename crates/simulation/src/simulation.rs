//! A machine with its tags on the virtual clock.

use std::sync::Arc;

use arcline_config::Project;
use arcline_controller::drive::Drives;
use arcline_controller::drive::simulated::{MechanicalModel, ModelDrives};
use arcline_controller::image::{Image, TagKind, WriteEffect, WriteError};
use arcline_controller::machine::Machine;
use arcline_controller::{Cause, ContourRequest, Controller, Event, Snapshot, Ticket};
use arcline_instruction_set::{AxisId, BindError, Call, ControlSlot, Flag, Mnemonic, MotionControl, SystemId};
use arcline_structured_text::Outcome;

use crate::calls::{Called, Calls, Origin};
use crate::end::{Erred, Refused};
use crate::observer::Observer;

/// A controller, its tags, and the instructions executed on it. Between [`Simulation::begin`] and [`Simulation::end`] a tick is open:
/// instructions are executed at its instant. Between ticks, the last one is closed.
#[derive(Debug)]
pub struct Simulation {
    machine: Arc<Machine>,
    controller: Controller,
    image: Image,
    snapshot: Snapshot,
    /// The tick that `snapshot` and the image show.
    filled: Option<u64>,
    contour: ContourRequest,
    /// The tick whose state the image shows.
    shown: Option<u64>,
    is_open: bool,
    calls: Calls,
    events: Vec<Event>,
    /// The calls accepted in this tick.
    accepted: Vec<(Ticket, Call)>,
}

impl Simulation {
    /// A machine with simulated drives and these tags, before tick 0.
    pub fn new(machine: Arc<Machine>, image: Image) -> Self {
        let controller = Controller::new(&machine);
        Self::of(machine, controller, image)
    }

    /// A machine with specific drives, in the order of its axes, and these tags, before tick 0.
    pub fn with_drives(machine: Arc<Machine>, image: Image, drives: Box<dyn Drives>) -> Self {
        let controller = Controller::with_drives(&machine, drives);
        Self::of(machine, controller, image)
    }

    /// A machine with simulated drives and these tags, before tick 0, and with a model of the mechanics that moves some of their axes.
    pub fn with_model(machine: Arc<Machine>, image: Image, model: Box<dyn MechanicalModel>, axes: &[AxisId]) -> Self {
        let drives = ModelDrives::new(arcline_controller::simulated(&machine), model, axes);
        Self::with_drives(machine, image, Box::new(drives))
    }

    /// The machine and the tags of a project, before tick 0.
    pub fn of_project(project: &Project) -> Self {
        Self::new(Arc::new(project.machine.clone()), project.image())
    }

    fn of(machine: Arc<Machine>, controller: Controller, image: Image) -> Self {
        Simulation {
            snapshot: Snapshot::new(&machine),
            filled: None,
            machine,
            controller,
            image,
            contour: ContourRequest::new(),
            shown: None,
            is_open: false,
            calls: Calls::default(),
            events: Vec::new(),
            accepted: Vec::new(),
        }
    }

    /// The machine as configured.
    pub fn machine(&self) -> &Arc<Machine> {
        &self.machine
    }

    /// The controller.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// The controller, for operations without an instruction.
    pub fn controller_mut(&mut self) -> &mut Controller {
        self.shown = None;
        &mut self.controller
    }

    /// The tags as last updated: see [`Simulation::show`].
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// The tags. Writes that do more than change bytes go through [`Simulation::apply`].
    pub fn image_mut(&mut self) -> &mut Image {
        &mut self.image
    }

    /// The present tick: the open one, or the last closed one.
    pub fn tick(&self) -> u64 {
        self.controller.tick_number()
    }

    /// Simulated time at the present tick, s.
    pub fn time(&self) -> f64 {
        (self.tick() as f64 * self.machine.period_ns as f64) / 1e9
    }

    /// The present tick is open: it has begun and not ended.
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// The number of executed instructions.
    pub fn executed(&self) -> u64 {
        self.calls.executed()
    }

    pub(crate) fn calls(&self) -> &Calls {
        &self.calls
    }

    pub(crate) fn calls_mut(&mut self) -> &mut Calls {
        &mut self.calls
    }

    /// Begins the next tick; the first one is tick 0.
    pub fn begin(&mut self) {
        self.begin_after(0);
    }

    /// Begins the next tick in which something may happen, at most `most` ticks later, and returns the number of those before it
    /// ([`Controller::begin_tick_after`]).
    pub fn begin_after(&mut self, most: u64) -> u64 {
        self.is_open = true;
        self.controller.begin_tick_after(most)
    }

    /// The number of ticks from the present one on, before a simulated time in seconds, that the observer need not see if they are uneventful: so
    /// few that it can soon end the run.
    pub fn unseen_ticks(&self, until: f64, observer: &impl Observer) -> u64 {
        if observer.needs_every_tick() {
            return 0;
        }
        // The conversion saturates. Two ticks fewer: the present one, and one as times are rounded.
        let before = ((until - self.time()) / self.machine.period() - 2.0) as u64;
        before.min(MOST_UNSEEN)
    }

    /// Ends the present tick. Returns false if the observer ends the run.
    pub fn end(&mut self, observer: &mut impl Observer) -> bool {
        let (tick, time) = (self.tick(), self.time());
        let Simulation {
            machine,
            controller,
            image,
            calls,
            events,
            accepted,
            ..
        } = self;
        for (ticket, call) in accepted.drain(..) {
            observer.accepted(ticket, &call);
        }
        controller.plan_contours(&mut self.contour);
        controller.take_fault_changes(|change| observer.fault(change, time, machine));
        controller.end_tick(|event| events.push(*event));
        controller.take_instruction_writes(|write| observer.instruction_written(write, image));
        for event in events.drain(..) {
            image.apply_event(&event);
            if event.cause != Cause::Itself {
                calls.end(event.ticket, event.cause);
            }
            observer.event(&event, time, image);
            if event.set & Flag::Er.mask() != 0 {
                let Event {
                    control,
                    mnemonic,
                    err,
                    exerr,
                    ..
                } = event;
                calls.err(event.ticket, erred(image, mnemonic, control, err, exerr));
            }
        }
        self.is_open = false;
        observer.tick(tick, machine, controller)
    }

    /// Executes an instruction at the present tick. Returns its ticket and the status of its motion control tag.
    pub fn execute(&mut self, call: &Call, origin: Origin) -> (Ticket, MotionControl) {
        let (mnemonic, control) = (call.mnemonic, call.control);
        let ticket = self.calls.add(Called {
            origin,
            mnemonic,
            control,
        });
        self.shown = None;
        let (data, staged) = self.image.prepare(call);
        let shown = self.controller.execute_with(ticket, call, data);
        if let Some(staged) = staged {
            self.image.settle(staged, &shown);
        }
        if shown.has(Flag::Er) {
            let erred = erred(&self.image, mnemonic, control, shown.err, shown.exerr);
            self.calls.err(ticket, erred);
        } else {
            self.accepted.push((ticket, *call));
        }
        (ticket, shown)
    }

    /// Performs the effect of a write to the tags. Returns the executed instruction.
    ///
    /// # Errors
    /// The operands of an instruction tag do not fit.
    pub fn apply(&mut self, effect: WriteEffect, origin: Origin) -> Result<Option<(Ticket, MotionControl)>, BindError> {
        match effect {
            WriteEffect::FeedOverride => {
                for (system, percent) in (0..).map(SystemId).zip(self.image.feed_overrides()) {
                    self.controller.set_override(system, f64::from(percent) / 100.0);
                }
                self.shown = None;
            }
            WriteEffect::FaultInject => self.inject(),
            WriteEffect::Inhibit(on) => {
                self.controller.inhibit(on);
                if on {
                    self.controller.stop_all();
                }
                self.shown = None;
            }
            WriteEffect::Setting => self.set_attributes(),
            // Only the caller executes ticks.
            WriteEffect::Steps(_) => {}
            WriteEffect::Input => {
                for input in self.image.take_inputs() {
                    self.controller.input(input);
                }
                self.shown = None;
            }
            WriteEffect::Rising(id) => {
                if let Some(call) = self.image.call_of(id).transpose()? {
                    return Ok(Some(self.execute(&call, origin)));
                }
            }
            WriteEffect::Falling(id) => {
                if let Some(TagKind::Instruction(kind)) = self.image.tag(id).map(|tag| tag.kind) {
                    self.rung_false(kind.control);
                }
            }
        }
        Ok(None)
    }

    /// Writes to the tags by a function, and performs the effect of the write.
    ///
    /// # Errors
    /// The write is refused, or the operands of an instruction tag do not fit.
    pub fn write(
        &mut self,
        origin: Origin,
        write: impl FnOnce(&mut Image) -> Result<Option<WriteEffect>, WriteError>,
    ) -> Result<Option<(Ticket, MotionControl)>, Refused> {
        match write(&mut self.image)? {
            Some(effect) => Ok(self.apply(effect, origin)?),
            None => Ok(None),
        }
    }

    /// The rung condition of the instruction with this motion control tag is false.
    pub fn rung_false(&mut self, control: ControlSlot) {
        self.controller.rung_false(control);
    }

    /// Takes the overrides, injected faults and attributes of the image; an override of 0 is ignored, as the run would not end.
    pub fn take_overrides(&mut self) {
        for (system, percent) in (0..).map(SystemId).zip(self.image.feed_overrides()) {
            let share = if percent > 0.0 { f64::from(percent) / 100.0 } else { 1.0 };
            self.controller.set_override(system, share);
        }
        self.inject();
        self.set_attributes();
    }

    fn inject(&mut self) {
        for (axis, causes) in (0..).map(AxisId).zip(self.image.injected_faults()) {
            self.controller.inject(axis, causes);
        }
    }

    fn set_attributes(&mut self) {
        for setting in self.image.settings() {
            self.controller.set(*setting);
        }
    }

    /// Updates axes and coordinate systems in the tags to the present moment.
    pub fn show(&mut self) {
        let tick = self.tick();
        if self.shown != Some(tick) {
            self.show_now();
            self.shown = Some(tick);
        }
    }

    /// As [`Simulation::show`], even if an instruction was executed since.
    pub fn show_now(&mut self) {
        let changed = self.controller.update(&mut self.snapshot, self.filled);
        self.filled = Some(self.snapshot.tick);
        self.image.apply_changes(&self.snapshot, &changed);
    }

    /// Updates a motion control in the tags to the present moment, and returns it.
    pub fn show_control(&mut self, slot: ControlSlot) -> MotionControl {
        let control = self.controller.control(slot);
        self.image.set_control(slot, control);
        control
    }

    /// The state of a motion control tag.
    pub fn outcome(&self, tag: &str) -> Outcome {
        let slot = match self.image.find(tag).map(|tag| tag.kind) {
            Some(TagKind::MotionControl(slot)) => Some(slot),
            Some(TagKind::Instruction(kind)) => Some(kind.control),
            _ => None,
        };
        let newest = slot.and_then(|slot| self.calls.newest(slot));
        let cause = newest.and_then(|(ticket, _)| self.calls.cause(ticket));
        Outcome {
            call: newest.map(|(ticket, mnemonic)| (mnemonic, self.calls.line_of(ticket))),
            control: slot.map_or_else(MotionControl::default, |slot| self.controller.control(slot)),
            ending: cause.and_then(|cause| self.image.ending(&self.machine, cause)),
        }
    }

    /// Executions that a fault ended before completion: line, instruction, tag, and the fault.
    pub fn stopped(&self) -> Vec<String> {
        let by_fault = self
            .calls
            .causes()
            .filter(|(_, cause)| matches!(cause, Cause::Fault { .. }));
        let told = by_fault.filter_map(|(ticket, cause)| {
            let Called {
                origin,
                mnemonic,
                control,
            } = self.calls.get(ticket)?;
            let ending = self.image.ending(&self.machine, cause)?;
            let tag = self.image.control_name(*control);
            let blank = if tag.is_empty() { "" } else { " " };
            Some(format!("line {}: {mnemonic}{blank}{tag} was {ending}", origin.line))
        });
        told.collect()
    }

    /// The state of the machine at the present tick.
    pub fn snapshot(&self) -> Snapshot {
        let mut snapshot = Snapshot::new(&self.machine);
        self.controller.snapshot(&mut snapshot);
        snapshot
    }
}

/// Ticks in a row that an observer does not see: some milliseconds of a processor.
const MOST_UNSEEN: u64 = 50_000;

/// The error of a call on a line.
fn erred(image: &Image, mnemonic: Mnemonic, control: ControlSlot, err: i16, exerr: i8) -> impl FnOnce(usize) -> Erred {
    move |line| Erred {
        tag: image.control_name(control).to_owned(),
        mnemonic,
        line,
        err,
        exerr,
        left_out: None,
    }
}
