//! The machine beside a project's tasks: the simulation, and the host that executes their instructions of motion.

use arcline_controller::image::{Image, TagId};
use arcline_controller::machine::Machine;
use arcline_controller::{Event, FaultChange, InstructionWrite, Ticket};
use arcline_instruction_set::{Argument, Call, ControlSlot, Flag, MotionControl, TagAddress};
use arcline_routine::source::Project;
use arcline_routine::{Cell, Host, Loaded};
use arcline_simulation::{Observer, Origin, Simulation};

use crate::live::{Names, NotPlaced, Placed, Places, UnknownParts, blocking};

/// A machine under control of a project.
pub(super) struct Plant {
    simulation: Simulation,
    /// The positions of the project's tags.
    places: Places,
}

impl Plant {
    pub(super) fn new(simulation: Simulation) -> Self {
        Plant {
            simulation,
            places: Places::default(),
        }
    }

    /// Loads a project on the machine, and makes its tags tags of the machine.
    pub(super) fn load(&mut self, source: &Project, unknown_parts: UnknownParts) -> Result<Loaded, NotPlaced> {
        let machine = self.simulation.machine().clone();
        let mut names = Names::new(&machine, self.simulation.image_mut());
        let mut loaded = arcline_routine::load(source, &mut names);
        if blocking(&loaded.findings, unknown_parts).next().is_none() {
            self.places = names.place(&mut loaded.cell, source)?;
        }
        Ok(loaded)
    }

    /// Looks for names of the machine, for code that is compiled while the machine runs.
    pub(super) fn with_names<R>(&self, look: impl FnOnce(&mut Names<'_>) -> R) -> R {
        let mut copy = self.simulation.image().clone();
        look(&mut Names::new(self.simulation.machine(), &mut copy))
    }

    pub(super) fn machine(&self) -> &Machine {
        self.simulation.machine()
    }

    /// Instructions of motion that were executed.
    pub(super) fn executed(&self) -> u64 {
        self.simulation.executed()
    }

    pub(super) fn tick(&self) -> u64 {
        self.simulation.tick()
    }

    /// Simulated time at the present tick, s.
    pub(super) fn time(&self) -> f64 {
        self.simulation.time()
    }

    /// Begins a tick, and shows the machine's state to the project.
    pub(super) fn begin_tick(&mut self, cell: &mut Cell) {
        self.simulation.begin();
        self.show(cell.memory_mut());
    }

    /// Brings axes and coordinate systems in the project's memory up to this moment.
    fn show(&mut self, memory: &mut [u8]) {
        self.simulation.show_now();
        for (at, id) in &self.places.objects {
            let bytes = self.simulation.image().bytes(*id);
            let from = *at as usize;
            if let Some(place) = memory.get_mut(from..from + bytes.len()) {
                place.copy_from_slice(bytes);
            }
        }
    }

    /// Ends the tick and passes its events to the project's tags and to the observer.
    pub(super) fn end_tick(&mut self, cell: &mut Cell, observer: &mut impl Observer) {
        let places = &self.places;
        self.simulation.end(&mut Shown { places, cell, observer });
        self.show(cell.memory_mut());
        let (tick, machine) = (self.tick(), self.simulation.machine().clone());
        observer.tick(tick, &machine, self.simulation.controller_mut());
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
            Direction::ToMachine => self.simulation.image_mut().store(id, bytes),
            Direction::ToProject => {
                let known = self.simulation.image().bytes(id);
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

/// Passes the events of a tick to the project's tags and to an observer. The plant itself shows the end of the tick, when the project has
/// the machine's state.
struct Shown<'s, O> {
    places: &'s Places,
    cell: &'s mut Cell,
    observer: &'s mut O,
}

impl<O: Observer> Observer for Shown<'_, O> {
    fn accepted(&mut self, ticket: Ticket, call: &Call) {
        self.observer.accepted(ticket, call);
    }

    fn fault(&mut self, change: &FaultChange, time: f64, machine: &Machine) {
        self.observer.fault(change, time, machine);
    }

    fn instruction_written(&mut self, write: &InstructionWrite, image: &mut Image) {
        take_instruction_write(image, self.places, self.cell.memory_mut(), write);
    }

    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        if event.owner {
            self.cell.change_control(event.control, |control| event.apply(control));
        }
        self.observer.event(event, time, image);
    }
}

/// The direction of a copy.
#[derive(Clone, Copy)]
enum Direction {
    ToMachine,
    ToProject,
}

/// Takes the values that an instruction wrote to a tag.
fn take_instruction_write(image: &mut Image, places: &Places, memory: &mut [u8], write: &InstructionWrite) {
    let id = TagId(write.tag.tag());
    let tag = places.tag(id);
    if let Some(Placed { from, to, .. }) = tag
        && let Some(bytes) = memory.get(from..to)
    {
        image.store(id, bytes);
    }
    image.apply_instruction_write(write);
    if let Some(Placed { from, to, .. }) = tag
        && let Some(bytes) = memory.get_mut(from..to)
        && image.bytes(id).len() == bytes.len()
    {
        bytes.copy_from_slice(image.bytes(id));
    }
}

impl Host for Plant {
    fn execute(&mut self, call: &Call, memory: &mut [u8]) -> MotionControl {
        self.exchange_all(call, memory, Direction::ToMachine);
        let (_, control) = self.simulation.execute(call, Origin::default());
        self.exchange_all(call, memory, Direction::ToProject);
        if !control.has(Flag::Er) {
            // Bits that the acceptance changes are seen in the same scan.
            self.show(memory);
        }
        control
    }

    fn rung_false(&mut self, slot: ControlSlot) {
        self.simulation.rung_false(slot);
    }

    fn attribute(&mut self, number: u32) -> f64 {
        let attribute = self.places.attributes.get(number as usize);
        let (image, machine) = (self.simulation.image(), self.simulation.machine());
        let value = attribute.and_then(|(attribute, index)| image.attribute(machine, attribute, *index));
        value.unwrap_or_default()
    }

    fn set_attribute(&mut self, number: u32, value: f64) -> bool {
        let Some((attribute, index)) = self.places.attributes.get(number as usize) else {
            return false;
        };
        let written = self.simulation.write(Origin::default(), |image| {
            image.set_attribute(attribute, *index, value).map(Some)
        });
        written.is_ok()
    }

    fn axis_input(&mut self, number: u32, on: bool) {
        if let Some(input) = self.places.input(number, on) {
            self.simulation.controller_mut().input(input);
        }
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
