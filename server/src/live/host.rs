//! The machine around the program's routines: its tags, exchanged with those that clients see, and the commands of its instructions.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use arcline_cell::{Placed, Places};
use arcline_controller::image::{ChangedPart, ForeignChanges, Image, TagId};
use arcline_instruction_set::{Argument, Call, ControlSlot, Mnemonic, MotionControl, MotionError, TagAddress};
use arcline_realtime::thread_time;
use arcline_routine::{Cell, Host, Memory, Pace};
use time::OffsetDateTime;

use crate::plant::{ANSWER_WITHIN, Command, Outcome, Plant, Principal, Program};

/// Lets a moment pass while an instruction waits for the tick.
pub(crate) type Pause = Box<dyn FnMut() + Send>;

/// The host of a program on a running machine.
pub(super) struct LiveHost {
    plant: Plant,
    program: Arc<Program>,
    places: Places,
    /// Forced inputs of modules, and the change of the forces that they are of.
    forced: Vec<Forced>,
    forces: u64,
    /// First bytes of motion control structures by slot.
    controls: BTreeMap<u32, usize>,
    /// The numbers of the placed tags.
    numbers: BTreeMap<TagId, usize>,
    /// The memory as clients see it.
    shown: Vec<u8>,
    /// The changes of the program's memory at the last exchange, behind which both were the same.
    changes: u64,
    /// The instructions that were executed last with each slot.
    executed: BTreeMap<u32, Mnemonic>,
    /// Slots whose false rung condition was sent.
    false_rungs: BTreeSet<u32>,
    pause: Pause,
    watchdog: Watchdog,
    /// Rungs until the next check of the clock.
    unseen: u32,
    shown_at: Instant,
}

impl LiveHost {
    pub(super) fn new(plant: Plant, program: Arc<Program>, cell: &Cell, places: Places, pause: Pause) -> Self {
        let memory = cell.memory();
        let controls = cell.controls().iter().map(|(at, slot)| (slot.0, *at as usize));
        let numbers = (0..).zip(&places.tags).map(|(number, tag)| (tag.id, number));
        LiveHost {
            controls: controls.collect(),
            numbers: numbers.collect(),
            shown: memory.to_vec(),
            changes: memory.changes(),
            plant,
            program,
            places,
            forced: Vec::new(),
            forces: 0,
            executed: BTreeMap::new(),
            false_rungs: BTreeSet::new(),
            pause,
            watchdog: Watchdog::new(LONGEST_RUN),
            unseen: LOOK_EVERY,
            shown_at: Instant::now(),
        }
    }

    /// Becomes the host of another program on the same machine.
    pub(super) fn take_over(&mut self, cell: &Cell, places: Places) {
        let pause = std::mem::replace(&mut self.pause, Box::new(|| {}));
        *self = LiveHost::new(self.plant.clone(), self.program.clone(), cell, places, pause);
    }

    /// Takes the changes of the clients and shows those of the program: from now on both memories are the same. Returns the tick.
    pub(super) fn exchange(&mut self, memory: &mut Memory) -> u64 {
        let Self {
            places,
            controls,
            numbers,
            shown,
            ..
        } = self;
        let has_changed = memory.changes() != self.changes;
        let differs = |tag: &&Placed| has_changed && shown.get(tag.from..tag.to) != memory.get(tag.from..tag.to);
        let changed: Vec<Placed> = places.tags.iter().filter(differs).copied().collect();
        let tick = self.plant.exchange(!changed.is_empty(), |image| {
            let foreign = image.take_foreign_changes();
            let mut both = Both { image, memory, shown };
            both.take(&foreign, &places.tags, numbers, controls);
            for (at, id) in &places.objects {
                both.take_whole(*id, *at as usize);
            }
            for tag in &changed {
                both.show(*tag);
            }
            both.image.snapshot_tick()
        });
        self.shown_at = Instant::now();
        self.changes = memory.changes();
        self.force(memory);
        tick
    }

    /// Puts forced values over those of the inputs. Without forces this reads one number.
    fn force(&mut self, memory: &mut Memory) {
        let changes = self.program.forces.changes();
        if changes != self.forces {
            self.forces = changes;
            let before = std::mem::take(&mut self.forced);
            // The inputs have the values again that clients gave them.
            before.iter().rev().for_each(|one| one.release(memory));
            let all = self.program.forces.all().into_iter();
            self.forced = all
                .filter_map(|force| {
                    let at = self
                        .numbers
                        .get(&force.tag)
                        .and_then(|number| self.places.tags.get(*number))?
                        .from;
                    Some(Forced {
                        at: at + force.offset,
                        given: vec![0; force.bytes.len()],
                        bytes: force.bytes,
                        is_new: true,
                    })
                })
                .collect();
        }
        self.forced.iter_mut().for_each(|one| one.apply(memory));
    }

    /// Takes the changes of the clients, between two rungs.
    fn take(&mut self, memory: &mut Memory) {
        let Self {
            places,
            controls,
            numbers,
            shown,
            ..
        } = self;
        self.plant.exchange(false, |image| {
            let foreign = image.take_foreign_changes();
            Both { image, memory, shown }.take(&foreign, &places.tags, numbers, controls);
        });
        self.force(memory);
    }

    /// Takes the tags that an instruction names as a whole: it may have written to them.
    fn take_arguments(&mut self, call: &Call, memory: &mut Memory) {
        let tags = call.arguments.iter().filter_map(|argument| match argument {
            Argument::Tag(address) => Some(address),
            Argument::Written(array) => Some(&array.tag),
            _ => None,
        });
        let named: Vec<Placed> = tags.filter_map(|address| self.placed(*address)).collect();
        let shown = &mut self.shown;
        self.plant.exchange(false, |image| {
            let mut both = Both { image, memory, shown };
            for tag in named {
                both.take_whole(tag.id, tag.from);
            }
        });
    }

    fn placed(&self, address: TagAddress) -> Option<Placed> {
        let number = self.numbers.get(&TagId(address.tag()))?;
        self.places.tags.get(*number).copied()
    }

    /// Sends a command of the program to the plant, and waits until its instructions are answered.
    fn command(&mut self, command: Command<'_>) -> Option<Outcome> {
        let began = Instant::now();
        let apply = |transaction: &mut crate::plant::Transaction<'_>| transaction.apply(command);
        let (outcome, mut pending) = self.plant.transact(Principal::Controller, apply);
        while !pending.is_answered() && began.elapsed() < ANSWER_WITHIN {
            (self.pause)();
            // Takes the answers of the newest tick.
            self.plant.with_image(|_| ());
        }
        outcome.ok()
    }
}

/// Bounds the processor time of a run of a task: neither other work on the computer nor the wait for motion ends a program.
struct Watchdog {
    longest: Duration,
    /// Processor time of the thread at the beginning of the run.
    began: Duration,
    /// The run has not had its time before this. Looking at the processor time is a system call.
    earliest: Option<Instant>,
}

impl Watchdog {
    /// A run that begins now.
    fn new(longest: Duration) -> Self {
        Watchdog {
            longest,
            began: thread_time(),
            earliest: Instant::now().checked_add(longest),
        }
    }

    fn is_over(&mut self, now: Instant) -> bool {
        if self.earliest.is_none_or(|earliest| now <= earliest) {
            return false;
        }
        let left = self.longest.saturating_sub(thread_time().saturating_sub(self.began));
        self.earliest = now.checked_add(left);
        left.is_zero()
    }
}

/// A forced input in the project's memory.
struct Forced {
    at: usize,
    /// The forced bits of each byte, and their values.
    bytes: Vec<(u8, u8)>,
    /// The values that clients gave.
    given: Vec<u8>,
    is_new: bool,
}

impl Forced {
    /// Puts the values over those of the input, which are remembered.
    fn apply(&mut self, memory: &mut Memory) {
        for ((at, (mask, value)), given) in (self.at..).zip(&self.bytes).zip(&mut self.given) {
            let present = memory.get(at).map_or(0, |byte| byte & mask);
            if self.is_new || present != *value {
                *given = present;
            }
            memory.put_bits(at, *mask, *value);
        }
        self.is_new = false;
    }

    /// Gives the input its own values back.
    fn release(&self, memory: &mut Memory) {
        if self.is_new {
            return;
        }
        for ((at, (mask, _)), given) in (self.at..).zip(&self.bytes).zip(&self.given) {
            memory.put_bits(at, *mask, *given);
        }
    }
}

/// Both memories during an exchange.
struct Both<'a> {
    image: &'a mut Image,
    memory: &'a mut Memory,
    shown: &'a mut Vec<u8>,
}

impl Both<'_> {
    fn take(
        &mut self,
        foreign: &ForeignChanges,
        tags: &[Placed],
        numbers: &BTreeMap<TagId, usize>,
        controls: &BTreeMap<u32, usize>,
    ) {
        if foreign.is_cut {
            for tag in tags {
                self.take_differences(*tag);
            }
        }
        for part in &foreign.parts {
            if let Some(tag) = numbers.get(&part.tag).and_then(|number| tags.get(*number)) {
                self.take_part(part, tag.from);
            }
        }
        for event in foreign.events.iter().filter(|event| event.owner) {
            if let Some(at) = controls.get(&event.control.0) {
                self.memory.change_control(*at, |control| event.apply(control));
            }
        }
    }

    fn take_part(&mut self, part: &ChangedPart, from: usize) {
        let bytes = self.image.bytes(part.tag);
        let bytes = bytes.get(part.offset..).unwrap_or_default();
        let at = from + part.offset;
        let places = self.shown.iter_mut().skip(at).zip(at..);
        for ((shown, at), byte) in places.zip(bytes.iter().take(part.length)) {
            *shown = *shown & !part.mask | byte & part.mask;
            self.memory.put_bits(at, part.mask, *byte);
        }
    }

    /// Takes the bytes that differ from those that were shown.
    fn take_differences(&mut self, tag: Placed) {
        let bytes = self.image.bytes(tag.id).iter();
        for (byte, (shown, at)) in bytes.zip(self.shown.iter_mut().skip(tag.from).zip(tag.from..)) {
            if byte != shown {
                *shown = *byte;
                self.memory.put_bits(at, 0xFF, *byte);
            }
        }
    }

    fn take_whole(&mut self, id: TagId, from: usize) {
        let bytes = self.image.bytes(id);
        self.memory.write(from, bytes);
        if let Some(shown) = self.shown.get_mut(from..from + bytes.len()) {
            shown.copy_from_slice(bytes);
        }
    }

    fn show(&mut self, tag: Placed) {
        let (Some(bytes), Some(shown)) = (self.memory.get(tag.from..tag.to), self.shown.get_mut(tag.from..tag.to))
        else {
            return;
        };
        self.image.store(tag.id, bytes);
        shown.copy_from_slice(bytes);
    }
}

impl Host for LiveHost {
    fn execute(&mut self, call: &Call, memory: &mut Memory) -> MotionControl {
        // Operands in tags go to the machine.
        self.exchange(memory);
        self.executed.insert(call.control.0, call.mnemonic);
        self.false_rungs.remove(&call.control.0);
        let control = match self.command(Command::Execute(call)) {
            Some(Outcome::Begun(instance)) => self.plant.instruction_instance(instance).unwrap_or_default(),
            _ => MotionControl::refused(MotionError::ExecutionCollision),
        };
        self.exchange(memory);
        self.take_arguments(call, memory);
        control
    }

    fn rung_false(&mut self, slot: ControlSlot) {
        let Some(mnemonic) = self.executed.get(&slot.0).copied() else {
            return;
        };
        // The controller remembers it until the instruction executes again.
        if self.false_rungs.insert(slot.0) {
            self.command(Command::RungFalse(mnemonic, slot));
        }
    }

    fn attribute(&mut self, number: u32) -> f64 {
        let Some((attribute, index)) = self.places.attributes.get(number as usize).copied() else {
            return 0.0;
        };
        let machine = self.plant.machine();
        let value = self
            .plant
            .with_image(|image| image.attribute(machine, attribute, index));
        value.unwrap_or_default()
    }

    fn set_attribute(&mut self, number: u32, value: f64) -> bool {
        let Some((attribute, index)) = self.places.attributes.get(number as usize).copied() else {
            return false;
        };
        let command = Command::SetAttribute {
            attribute,
            index,
            value,
        };
        self.command(command).is_some()
    }

    fn date(&self, _now: u64) -> [i32; 7] {
        let now = OffsetDateTime::from(SystemTime::now());
        [
            now.year(),
            i32::from(u8::from(now.month())),
            i32::from(now.day()),
            i32::from(now.hour()),
            i32::from(now.minute()),
            i32::from(now.second()),
            now.microsecond() as i32,
        ]
    }

    fn axis_input(&mut self, number: u32, on: bool) {
        if let Some(input) = self.places.input(number, on) {
            self.plant.give_input(input);
        }
    }

    /// Forces stay above wires.
    fn inputs_latched(&mut self, memory: &mut Memory) {
        self.force(memory);
    }

    fn begin_task(&mut self, watchdog_us: i32) {
        let longest = match u64::try_from(watchdog_us) {
            Ok(us) if us > 0 => Duration::from_micros(us),
            _ => LONGEST_RUN,
        };
        self.watchdog = Watchdog::new(longest);
        self.unseen = LOOK_EVERY;
    }

    fn between(&mut self, memory: &mut Memory) -> Pace {
        if self.plant.has_foreign_changes() {
            self.take(memory);
        }
        self.unseen -= 1;
        if self.unseen > 0 {
            return Pace::InTime;
        }
        self.unseen = LOOK_EVERY;
        let now = Instant::now();
        if self.watchdog.is_over(now) {
            return Pace::TooLong;
        }
        if now.duration_since(self.shown_at) > SHOW_WITHIN {
            self.exchange(memory);
        }
        Pace::InTime
    }
}

/// Rungs between two checks of the clock.
const LOOK_EVERY: u32 = 64;
/// The longest time after which clients see the changes of a scan that still runs.
const SHOW_WITHIN: Duration = Duration::from_millis(10);
/// The watchdog of a task without one that is not continuous (spec/programs.md §8).
const LONGEST_RUN: Duration = Duration::from_millis(500);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_is_held_up_is_not_ended() {
        let longest = Duration::from_millis(5);
        let mut watchdog = Watchdog::new(longest);
        for minutes in 1..=10 {
            let held_up = Instant::now() + Duration::from_mins(minutes);
            assert!(!watchdog.is_over(held_up), "it had no processor for {minutes} min");
        }
        let mut watchdog = Watchdog::new(longest);
        let began = thread_time();
        while !watchdog.is_over(Instant::now()) {}
        let took = thread_time() - began;
        assert!(took >= longest.mul_f64(0.99), "{took:?} is less than the watchdog");
    }
}
