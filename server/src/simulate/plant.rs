//! The machine beside a project's tasks: its controller, its tags, and the door through which instructions of motion go.

use arcline_controller::image::{Image, TagId};
use arcline_controller::machine::Machine;
use arcline_controller::{ArrayWrite, ContourRequest, Controller, Event, Snapshot, Ticket};
use arcline_instruction_set::{Argument, Call, ControlSlot, Flag, MotionControl, TagAddress};
use arcline_routine::source::Project;
use arcline_routine::{Cell, Host, Loaded};

use super::Observer;
use crate::live::{Missing, Names, NotPlaced, Placed, Places, blocking};

/// A machine under control of a project.
pub(super) struct Plant<'m> {
    machine: &'m Machine,
    controller: Controller,
    image: Image,
    snapshot: Snapshot,
    contour: ContourRequest,
    executed: u64,
    events: Vec<Event>,
    accepted: Vec<(Ticket, Call)>,
    /// Where the project's tags stand.
    places: Places,
}

impl<'m> Plant<'m> {
    pub(super) fn new(machine: &'m Machine, image: Image) -> Self {
        Plant {
            machine,
            controller: Controller::new(machine),
            image,
            snapshot: Snapshot::new(machine),
            contour: ContourRequest::new(),
            executed: 0,
            events: Vec::new(),
            accepted: Vec::new(),
            places: Places::default(),
        }
    }

    /// Loads a project on the machine, and makes its tags tags of the machine.
    pub(super) fn load(&mut self, source: &Project, missing: Missing) -> Result<Loaded, NotPlaced> {
        let mut names = Names::new(self.machine, &mut self.image);
        let mut loaded = arcline_routine::load(source, &mut names);
        if blocking(&loaded.findings, missing).next().is_none() {
            self.places = names.place(&mut loaded.cell, source)?;
        }
        Ok(loaded)
    }

    /// Looks for names of the machine, for what is compiled while it runs.
    pub(super) fn with_names<R>(&self, look: impl FnOnce(&mut Names<'_>) -> R) -> R {
        let mut copy = self.image.clone();
        look(&mut Names::new(self.machine, &mut copy))
    }

    pub(super) fn machine(&self) -> &'m Machine {
        self.machine
    }

    /// Instructions of motion that were executed.
    pub(super) fn executed(&self) -> u64 {
        self.executed
    }

    pub(super) fn tick(&self) -> u64 {
        self.controller.tick_number()
    }

    /// Simulated time at the present tick, s.
    pub(super) fn time(&self) -> f64 {
        (self.tick() as f64 * self.machine.period_ns as f64) / 1e9
    }

    /// Begins a tick, and shows the machine's state to the project.
    pub(super) fn begin_tick(&mut self, cell: &mut Cell) {
        self.controller.begin_tick();
        self.show(cell.memory_mut());
    }

    /// Brings axes and coordinate systems in the project's memory up to this moment.
    fn show(&mut self, memory: &mut [u8]) {
        self.controller.snapshot(&mut self.snapshot);
        self.image.apply_snapshot(&self.snapshot);
        for (at, id) in &self.places.objects {
            let bytes = self.image.bytes(*id);
            let from = *at as usize;
            if let Some(place) = memory.get_mut(from..from + bytes.len()) {
                place.copy_from_slice(bytes);
            }
        }
    }

    /// Ends the tick: what happened goes to the project's tags and to the observer.
    pub(super) fn end_tick(&mut self, cell: &mut Cell, observer: &mut impl Observer) {
        let (tick, time, machine) = (self.tick(), self.time(), self.machine);
        for (ticket, call) in self.accepted.drain(..) {
            observer.accepted(ticket, &call);
        }
        self.controller.plan_contours(&mut self.contour);
        self.controller
            .take_fault_changes(|change| observer.fault(change, time, machine));
        let events = &mut self.events;
        self.controller.end_tick(|event| events.push(*event));
        let (image, places, memory) = (&mut self.image, &self.places, cell.memory_mut());
        self.controller.take_array_writes(|write| {
            take_array(image, places, memory, write);
        });
        for event in self.events.drain(..) {
            self.image.apply_event(&event);
            if event.owner {
                cell.change_control(event.control, |control| event.apply(control));
            }
            observer.event(&event, time, &self.image);
        }
        self.show(cell.memory_mut());
        observer.tick(tick, machine, &mut self.controller);
    }

    /// Brings the bytes of a tag that a call names from the project to the machine's tags, or back.
    fn exchange(&mut self, address: TagAddress, memory: &mut [u8], direction: Direction) {
        let id = TagId(address.tag());
        let Some(Placed { from, to, .. }) = self.places.tag(id) else {
            return;
        };
        let Some(bytes) = memory.get_mut(from..to) else {
            return;
        };
        match direction {
            Direction::ToMachine => self.image.store(id, bytes),
            Direction::ToProject => {
                let known = self.image.bytes(id);
                if known.len() == bytes.len() {
                    bytes.copy_from_slice(known);
                }
            }
        }
    }

    fn exchange_all(&mut self, call: &Call, memory: &mut [u8], direction: Direction) {
        for argument in &call.arguments {
            match argument {
                Argument::Tag(address) => self.exchange(*address, memory, direction),
                Argument::Written(array) => self.exchange(array.tag, memory, direction),
                _ => {}
            }
        }
    }
}

/// Where bytes go.
#[derive(Clone, Copy)]
enum Direction {
    ToMachine,
    ToProject,
}

/// What an instruction wrote to an array.
fn take_array(image: &mut Image, places: &Places, memory: &mut [u8], write: &ArrayWrite) {
    let id = TagId(write.tag.tag());
    let tag = places.tag(id);
    if let Some(Placed { from, to, .. }) = tag
        && let Some(bytes) = memory.get(from..to)
    {
        image.store(id, bytes);
    }
    image.apply_array_write(write);
    if let Some(Placed { from, to, .. }) = tag
        && let Some(bytes) = memory.get_mut(from..to)
        && image.bytes(id).len() == bytes.len()
    {
        bytes.copy_from_slice(image.bytes(id));
    }
}

impl Host for Plant<'_> {
    fn execute(&mut self, call: &Call, memory: &mut [u8]) -> MotionControl {
        self.exchange_all(call, memory, Direction::ToMachine);
        self.executed += 1;
        let ticket = Ticket(self.executed);
        let (data, staged) = self.image.prepare(call);
        let control = self.controller.execute_with(ticket, call, data);
        if let Some(staged) = staged {
            self.image.settle(staged, &control);
        }
        self.exchange_all(call, memory, Direction::ToProject);
        if !control.has(Flag::Er) {
            self.accepted.push((ticket, *call));
            // Bits that the acceptance changes are seen in the same scan.
            self.show(memory);
        }
        control
    }

    fn rung_false(&mut self, slot: ControlSlot) {
        self.controller.rung_false(slot);
    }

    fn attribute(&mut self, number: u32) -> f64 {
        let attribute = self.places.attributes.get(number as usize);
        let value = attribute.and_then(|(attribute, index)| self.image.attribute(self.machine, attribute, *index));
        value.unwrap_or_default()
    }

    fn set_attribute(&mut self, number: u32, value: f64) -> bool {
        let Some((attribute, index)) = self.places.attributes.get(number as usize) else {
            return false;
        };
        if self.image.set_attribute(attribute, *index, value).is_err() {
            return false;
        }
        for (object, index, bits) in self.image.dynamics_bits() {
            self.controller.set_dynamics_bits(object, index, bits);
        }
        true
    }

    fn date(&self, now: u64) -> [i32; 7] {
        let start = time::Date::from_calendar_date(START.0, time::Month::January, START.1);
        let Ok(start) = start else { return [0; 7] };
        let at = start.midnight() + std::time::Duration::from_nanos(now);
        [
            at.year(),
            i32::from(u8::from(at.month())),
            i32::from(at.day()),
            i32::from(at.hour()),
            i32::from(at.minute()),
            i32::from(at.second()),
            at.microsecond() as i32,
        ]
    }
}

/// Year, and day of January, on which a simulation begins.
const START: (i32, u8) = (2026, 1);
