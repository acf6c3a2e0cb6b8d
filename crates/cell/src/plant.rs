//! The machine beside a project's tasks: the simulation, and the host that executes their instructions of motion.

use arcline_controller::image::{Image, TagId};
use arcline_controller::machine::Machine;
use arcline_controller::{Event, FaultChange, InstructionWrite, Ticket};
use arcline_instruction_set::{Argument, Call, ControlSlot, Flag, MotionControl, TagAddress};
use arcline_routine::{Cell, Host, Memory};
use arcline_simulation::{Observer, Origin, Simulation};

use crate::names::{Names, Placed, Places};

/// A machine under control of a project.
#[derive(Debug)]
pub(crate) struct Plant {
    simulation: Simulation,
    /// The positions of the project's tags.
    places: Places,
    /// The project's memory has the present state of the machine.
    is_shown: bool,
}

impl Plant {
    /// A machine, and the places of the tags of the project that was bound to it.
    pub(crate) fn new(simulation: Simulation, places: Places) -> Self {
        Plant {
            simulation,
            places,
            is_shown: false,
        }
    }

    /// Looks for names of the machine, for code that is compiled while the machine runs.
    pub(crate) fn with_names<R>(&self, look: impl FnOnce(&mut Names<'_>) -> R) -> R {
        let mut copy = self.simulation.image().clone();
        look(&mut Names::new(self.simulation.machine(), &mut copy))
    }

    pub(crate) fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    pub(crate) fn simulation_mut(&mut self) -> &mut Simulation {
        self.is_shown = false;
        &mut self.simulation
    }

    /// Whether a condition reads an axis, a coordinate system or the group.
    pub(crate) fn is_read_by(&self, condition: &arcline_routine::Condition) -> bool {
        let image = self.simulation.image();
        let mut objects = self.places.objects.iter();
        objects.any(|(at, id)| condition.reads(*at, image.bytes(*id).len()))
    }

    pub(crate) fn places(&self) -> &Places {
        &self.places
    }

    /// Begins the next tick in which something may happen, at most `most` ticks later, and returns the number of those before it.
    pub(crate) fn begin_after(&mut self, most: u64) -> u64 {
        self.simulation_mut().begin_after(most)
    }

    /// Brings axes and coordinate systems in the project's memory up to this moment, unless they are.
    pub(crate) fn show_changes(&mut self, memory: &mut Memory) {
        if !self.is_shown {
            self.show(memory);
        }
    }

    /// Brings axes and coordinate systems in the project's memory up to this moment.
    pub(crate) fn show(&mut self, memory: &mut Memory) {
        self.is_shown = true;
        self.simulation.show_now();
        for (at, id) in &self.places.objects {
            memory.write(*at as usize, self.simulation.image().bytes(*id));
        }
    }

    /// Ends the tick and passes its events to the project's tags and to the observer. False: the observer ends the run.
    pub(crate) fn end_tick(&mut self, cell: &mut Cell, observer: &mut impl Observer) -> bool {
        let places = &self.places;
        self.simulation.end(&mut Shown { places, cell, observer });
        self.is_shown = false;
        let (tick, machine) = (self.simulation.tick(), self.simulation.machine().clone());
        observer.tick(tick, &machine, self.simulation.controller_mut())
    }

    /// Brings the bytes of a tag that a call names from the project to the machine's tags, or back.
    fn exchange(&mut self, address: TagAddress, memory: &mut Memory, direction: Direction) {
        let id = TagId(address.tag());
        let Some(Placed { from, to, .. }) = self.places.tag(id) else {
            return;
        };
        let Some(bytes) = memory.get(from..to) else {
            return;
        };
        match direction {
            Direction::ToMachine => self.simulation.image_mut().store(id, bytes),
            Direction::ToProject => {
                let known = self.simulation.image().bytes(id);
                if known.len() == bytes.len() {
                    memory.write(from, known);
                }
            }
        }
    }

    fn exchange_all(&mut self, call: &Call, memory: &mut Memory, direction: Direction) {
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
fn take_instruction_write(image: &mut Image, places: &Places, memory: &mut Memory, write: &InstructionWrite) {
    let id = TagId(write.tag.tag());
    let tag = places.tag(id);
    if let Some(Placed { from, to, .. }) = tag
        && let Some(bytes) = memory.get(from..to)
    {
        image.store(id, bytes);
    }
    image.apply_instruction_write(write);
    if let Some(Placed { from, to, .. }) = tag
        && image.bytes(id).len() == to - from
    {
        memory.write(from, image.bytes(id));
    }
}

impl Host for Plant {
    fn execute(&mut self, call: &Call, memory: &mut Memory) -> MotionControl {
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
        date(now)
    }
}

/// The date at a virtual time, ns: a simulation begins on 1 January 2026. Year, month, day, hour, minute, second, microsecond.
fn date(now: u64) -> [i32; 7] {
    let seconds = now / 1_000_000_000;
    let (mut day, mut year) = (seconds / 86_400, FIRST_YEAR);
    let is_leap = |year: i32| year % 4 == 0 && year % 100 != 0 || year % 400 == 0;
    let days = |year: i32| if is_leap(year) { 366 } else { 365 };
    while day >= days(year) {
        day -= days(year);
        year += 1;
    }
    let mut month = 1;
    for length in [
        31,
        if is_leap(year) { 29 } else { 28 },
        31,
        30,
        31,
        30,
        31,
        31,
        30,
        31,
        30,
    ] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    let of_day = |unit: u64, count: u64| (seconds / unit % count) as i32;
    let microsecond = (now / 1_000 % 1_000_000) as i32;
    [
        year,
        month,
        day as i32 + 1,
        of_day(3_600, 24),
        of_day(60, 60),
        of_day(1, 60),
        microsecond,
    ]
}

/// The year in which a simulation begins.
const FIRST_YEAR: i32 = 2026;

#[cfg(test)]
mod tests {
    use super::date;

    #[test]
    fn dates_of_virtual_times() {
        const DAY: u64 = 86_400_000_000_000;
        #[rustfmt::skip]
        let cases = [
            ("the beginning",                     0,                                     [2026, 1, 1, 0, 0, 0, 0]),
            ("a microsecond before the next day", DAY - 1_000,                           [2026, 1, 1, 23, 59, 59, 999_999]),
            ("the next month",                    31 * DAY,                              [2026, 2, 1, 0, 0, 0, 0]),
            ("the last day of the year",          364 * DAY + 3_661_000_000_000,         [2026, 12, 31, 1, 1, 1, 0]),
            ("the next year",                     365 * DAY,                             [2027, 1, 1, 0, 0, 0, 0]),
            ("a leap day",                        (365 + 365 + 31 + 28) * DAY,           [2028, 2, 29, 0, 0, 0, 0]),
            ("the day behind it",                 (365 + 365 + 31 + 29) * DAY,           [2028, 3, 1, 0, 0, 0, 0]),
            ("the last day of a leap year",       (365 + 365 + 365) * DAY,               [2028, 12, 31, 0, 0, 0, 0]),
        ];
        for (why, now, expected) in cases {
            assert_eq!(date(now), expected, "{why}");
        }
    }
}
