//! The machine beside a project's tasks: its controller, its tags, and the door through which instructions of motion go.

use arcline_controller::image::{Image, PlainTag, TagId, TagKind};
use arcline_controller::machine::Machine;
use arcline_controller::{ArrayWrite, ContourRequest, Controller, Event, Snapshot, Ticket};
use arcline_instruction_set::{
    Argument, Attribute, Call, ControlSlot, Directory as _, Flag, MotionControl, Object, TagAddress,
};
use arcline_routine::{Cell, Directory, Host};
use arcline_tag::TagType;

use super::Observer;

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
    /// Axes, coordinate systems and the group: first byte in the project's memory, and the tag.
    shown: Vec<(u32, TagId)>,
    /// Tags that both have: first byte, end, and the tag.
    shared: Vec<(u32, u32, TagId)>,
    /// Attributes that the project reads or sets.
    attributes: Vec<(&'static Attribute, u16)>,
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
            shown: Vec::new(),
            shared: Vec::new(),
            attributes: Vec::new(),
        }
    }

    /// The names of the machine, for what is compiled while it runs.
    pub(super) fn twin(&self) -> Plant<'m> {
        Plant::new(self.machine, self.image.clone())
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

    /// Learns where a project has the tags of the machine.
    pub(super) fn show_tags(&mut self, cell: &Cell) {
        let of_machine = cell
            .tags()
            .iter()
            .filter(|tag| tag.program.is_none())
            .filter_map(|tag| {
                let known = self.image.find(&tag.name)?;
                let is_object = matches!(
                    known.kind,
                    TagKind::Axis(_) | TagKind::CoordinateSystem(_) | TagKind::MotionGroup
                );
                is_object.then_some((tag.at, known.id))
            });
        self.shown = of_machine.collect();
        self.shared = cell
            .shared()
            .iter()
            .map(|(from, to, id)| (*from, *to, TagId(*id)))
            .collect();
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
        for (at, id) in &self.shown {
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
        let (image, shared, memory) = (&mut self.image, &self.shared, cell.memory_mut());
        self.controller.take_array_writes(|write| {
            take_array(image, shared, memory, write);
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
        let Some((from, to, _)) = self.shared.iter().find(|(.., of)| *of == id).copied() else {
            return;
        };
        let Some(bytes) = memory.get_mut(from as usize..to as usize) else {
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
fn take_array(image: &mut Image, shared: &[(u32, u32, TagId)], memory: &mut [u8], write: &ArrayWrite) {
    let id = TagId(write.tag.tag());
    let tag = shared.iter().find(|(.., of)| *of == id);
    if let Some((from, to, _)) = tag
        && let Some(bytes) = memory.get(*from as usize..*to as usize)
    {
        image.store(id, bytes);
    }
    image.apply_array_write(write);
    if let Some((from, to, _)) = tag
        && let Some(bytes) = memory.get_mut(*from as usize..*to as usize)
        && image.bytes(id).len() == bytes.len()
    {
        bytes.copy_from_slice(image.bytes(id));
    }
}

impl Directory for Plant<'_> {
    fn object_type(&self, name: &str) -> Option<TagType> {
        let tag = self.image.find(name)?;
        let is_object = matches!(
            tag.kind,
            TagKind::Axis(_) | TagKind::CoordinateSystem(_) | TagKind::MotionGroup
        );
        is_object.then(|| tag.tag_type.clone())
    }

    fn object(&self, object: Object, name: &str) -> Option<u16> {
        self.image.object(object, name)
    }

    fn control(&mut self, name: &str) -> Option<ControlSlot> {
        // A member, an element or a tag of a program has a name of its own in events.
        let plain: String = name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
            .collect();
        let short: String = plain.chars().skip(plain.len().saturating_sub(40)).collect();
        let short = if short.starts_with(|c: char| c.is_ascii_digit()) {
            short.replacen(|_| true, "_", 1)
        } else {
            short
        };
        let known = |image: &mut Image, name: &str| image.control_slot(name).ok();
        if name == plain {
            return known(&mut self.image, name).or_else(|| known(&mut self.image, &format!("{short:.36}_mi")));
        }
        known(&mut self.image, &short)
    }

    fn tag(&mut self, name: &str, tag_type: &TagType) -> Option<u32> {
        if let Some(tag) = self.image.find(name) {
            return (tag.kind == TagKind::Plain && tag.tag_type.size() == tag_type.size()).then_some(tag.id.0);
        }
        let (program, name) = match name.strip_prefix("Program:").and_then(|name| name.split_once('.')) {
            Some((program, name)) => (Some(program.to_owned()), name),
            None => (None, name),
        };
        let tag = PlainTag {
            program,
            ..PlainTag::new(name, tag_type.clone())
        };
        self.image.create(&tag).ok().map(|id| id.0)
    }

    fn attribute(&mut self, object: Object, index: u16, name: &str) -> Option<(u32, usize)> {
        let attribute = Attribute::named(object, name)?;
        self.image.attribute(self.machine, attribute, index)?;
        self.attributes.push((attribute, index));
        Some((self.attributes.len() as u32 - 1, 4))
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
        let attribute = self.attributes.get(number as usize);
        let value = attribute.and_then(|(attribute, index)| self.image.attribute(self.machine, attribute, *index));
        value.unwrap_or_default()
    }

    fn set_attribute(&mut self, number: u32, value: f64) -> bool {
        let Some((attribute, index)) = self.attributes.get(number as usize) else {
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
