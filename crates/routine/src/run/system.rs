//! GSV, SSV and MSG (spec/programs.md §10.8).

use super::{MAX_MESSAGES, Run, Scan, Sent};
use crate::code::{Area, Attribute, NameOf, Reply, System, TaskAttribute, WallClock, When};
use crate::table::Op;
use arcline_tag::DataType;

/// Flags of a MESSAGE in the byte at 4.
const EW: u8 = 0x04;
const ER: u8 = 0x10;
const DN: u8 = 0x20;
const ST: u8 = 0x40;
const EN: u8 = 0x80;
/// In the next byte.
const TO: u8 = 0x01;
/// A message without answer: the error of a timeout.
const EXERR_TIMEOUT: u32 = 0x0204;
/// Too many messages are under way: ERR, Resource Unavailable.
const ERR_RESOURCE: u16 = 2;
/// Bytes of the LEN of a text.
const LENGTH: usize = 4;
/// Bytes of an attribute of the host.
const NUMBER: usize = 4;
/// The timeout of a message that has none, ns.
const TIMEOUT: u64 = 30_000_000_000;

impl<'s> Scan<'s> {
    pub(crate) fn system(&mut self, op: Op, system: &System) -> Run<()> {
        self.s.is_restless = true;
        let range = self.range(&system.area)?;
        // An attribute goes into the destination, and beyond it in its array.
        let end = if system.area.length > 1 {
            range.array_end
        } else {
            range.end
        };
        let room = (end - range.at) as usize;
        if op == Op::Ssv {
            self.set_system(&system.attribute, &system.area, range.at, room);
            return Ok(());
        }
        let mut value = [0_u8; 44];
        let size = match &system.attribute {
            Attribute::WallClock(WallClock::DateTime) => {
                let date = self.host.date(self.s.now);
                for (place, part) in value.chunks_exact_mut(4).zip(date) {
                    place.copy_from_slice(&part.to_le_bytes());
                }
                28
            }
            Attribute::WallClock(WallClock::Microseconds) => put(&mut value, &(self.s.now / 1000).to_le_bytes()),
            Attribute::Task(task, attribute) => {
                let number = self.task_attribute(*task as usize, *attribute);
                if *attribute == TaskAttribute::Priority {
                    put(&mut value, &(number as i16).to_le_bytes())
                } else {
                    put(&mut value, &number.to_le_bytes())
                }
            }
            Attribute::Record(program) => {
                let record = self.s.records.get(*program as usize).copied().unwrap_or_default();
                for (place, part) in value.chunks_exact_mut(4).zip(record) {
                    place.copy_from_slice(&part.to_le_bytes());
                }
                44
            }
            Attribute::DisableFlag(program) => {
                let flag = self.s.disabled.get(*program as usize).copied().unwrap_or_default();
                put(&mut value, &[u8::from(flag)])
            }
            Attribute::Constant(bytes) => put(&mut value, bytes),
            Attribute::Name(of, Some(to)) => return self.put_characters(to, self.name_of(*of).as_bytes()),
            Attribute::Name(of, None) => {
                let name = self.name_of(*of).as_bytes();
                let (length, characters) = value.split_at_mut(LENGTH);
                length.copy_from_slice(&(name.len() as u32).to_le_bytes());
                LENGTH + put(characters, name)
            }
            Attribute::MinorFaults => put(&mut value, &self.s.minor_bits.to_le_bytes()),
            Attribute::MajorFaults => put(&mut value, &self.s.major_bits.to_le_bytes()),
            Attribute::Events(which) => {
                let count = self.s.events.get(usize::from(*which)).copied().unwrap_or_default();
                put(&mut value, &count.to_le_bytes())
            }
            Attribute::Missing => {
                self.minor();
                room.min(value.len())
            }
            Attribute::Number(number) => return self.put_host(&system.area, range.at, *number),
            Attribute::Member(cell) => {
                let at = self.address(&cell.place)?;
                let number = self.read_real(at, cell.kind);
                self.fits(cell.kind.size(), system.area.size as usize);
                return self.put_host(&system.area, range.at, number);
            }
            Attribute::Host(number) => {
                let number = self.host.attribute(*number);
                self.fits(NUMBER, system.area.size as usize);
                return self.put_host(&system.area, range.at, number);
            }
        };
        self.fits(size, room);
        let size = size.min(room);
        self.s
            .memory
            .write(range.at as usize, value.get(..size).unwrap_or_default());
        Ok(())
    }

    /// A destination that is too small for the attribute is a minor fault (4/7).
    fn fits(&mut self, size: usize, room: usize) {
        if size > room {
            self.minor();
        }
    }

    fn put_host(&mut self, area: &Area, at: u32, number: f64) -> Run<()> {
        if let DataType::Elementary(kind) = area.data_type {
            let value = if kind.is_real() {
                super::value::Number::Real(number)
            } else {
                super::value::Number::Whole(number as i64)
            };
            self.write(at, kind, value);
        }
        Ok(())
    }

    fn set_system(&mut self, attribute: &Attribute, area: &Area, at: u32, room: usize) {
        match attribute {
            Attribute::Record(program) => {
                let mut record = [0; 11];
                for (place, part) in record.iter_mut().zip((at..).step_by(4)).take(room / 4) {
                    *place = self.dint(part);
                }
                if let Some(place) = self.s.records.get_mut(*program as usize) {
                    *place = record;
                }
            }
            Attribute::DisableFlag(program) => {
                let on = self.has(at, 1);
                if let Some(flag) = self.s.disabled.get_mut(*program as usize) {
                    *flag = on;
                }
            }
            Attribute::Task(task, TaskAttribute::InhibitTask) => {
                let on = self.dint(at) != 0;
                if let Some(flag) = self.s.inhibited.get_mut(*task as usize) {
                    *flag = on;
                }
            }
            Attribute::Task(task, TaskAttribute::Status) => {
                let status = self.dint(at);
                if let Some(place) = self.s.status.get_mut(*task as usize) {
                    *place = status;
                }
            }
            Attribute::MinorFaults => {
                self.s.minor_bits = self.dint(at) as u32;
                self.s.minor = self.s.minor_bits != 0;
            }
            Attribute::MajorFaults => self.s.major_bits = self.dint(at) as u32,
            Attribute::Events(which) => {
                let count = self.bytes::<2>(at);
                if let Some(place) = self.s.events.get_mut(usize::from(*which)) {
                    *place = i16::from_le_bytes(count);
                }
            }
            Attribute::Missing => self.minor(),
            Attribute::Host(number) => {
                if let DataType::Elementary(kind) = area.data_type {
                    let value = self.read_real(at, kind);
                    if !self.host.set_attribute(*number, value) {
                        self.minor();
                    }
                }
            }
            // SSV of these is refused when the project is loaded.
            Attribute::WallClock(_)
            | Attribute::Task(..)
            | Attribute::Name(..)
            | Attribute::Constant(_)
            | Attribute::Number(_)
            | Attribute::Member(_) => self.minor(),
        }
    }

    /// The name of a part of the project.
    fn name_of(&self, of: NameOf) -> &'s str {
        let code = self.code;
        let program = |place: u32| code.programs.get(place as usize).map(|one| one.name);
        let task = |place: u32| code.tasks.get(place as usize).map(|one| one.name);
        let name = match of {
            NameOf::Program(place) => program(place.unwrap_or(self.s.program)),
            NameOf::Task(Some(place)) => task(place),
            NameOf::Task(None) => code
                .tasks
                .iter()
                .find(|one| one.programs.contains(&self.s.program))
                .map(|one| one.name),
            NameOf::Routine => code.routines.get(self.s.routine as usize).map(|one| one.name),
        };
        name.map_or("", |name| code.text(name))
    }

    fn task_attribute(&self, task: usize, attribute: TaskAttribute) -> i32 {
        let Some(of) = self.code.tasks.get(task) else { return 0 };
        match attribute {
            TaskAttribute::Rate => match of.when {
                When::Periodic(ns) => (ns / 1000) as i32,
                _ => 0,
            },
            TaskAttribute::Watchdog => of.watchdog_us,
            TaskAttribute::Priority => of.priority as i32,
            TaskAttribute::Instance => task as i32 + 1,
            TaskAttribute::OverlapCount => self.s.overlaps.get(task).copied().unwrap_or_default(),
            TaskAttribute::InhibitTask => i32::from(self.s.inhibited.get(task).copied().unwrap_or_default()),
            // Scans cost no virtual time.
            TaskAttribute::Status => self.s.status.get(task).copied().unwrap_or_default(),
            TaskAttribute::LastScanTime | TaskAttribute::MaxScanTime => 0,
        }
    }

    /// MSG: its answer comes from the table after its delay; without one it errs after its timeout.
    pub(crate) fn message(&mut self, area: &Area, reply: Option<u32>, power: bool) -> Run<()> {
        let at = self.address(&area.place)?;
        let flags = at + 4;
        if self.s.prescan {
            self.set(flags, EN, false);
            return Ok(());
        }
        if !power {
            if self.has(flags, DN | ER) {
                self.set(flags, EN, false);
            }
            return Ok(());
        }
        if self.has(flags, EN) {
            return Ok(());
        }
        self.set(flags, DN | ER | ST, false);
        self.set(flags, EN | EW, true);
        self.set(flags + 1, TO, false);
        let timeout = u64::try_from(self.dint(at + 40)).unwrap_or(0) * 1000;
        let delay = match reply.and_then(|reply| self.code.replies.get(reply as usize)) {
            Some(reply) => reply.delay,
            None if timeout == 0 => TIMEOUT,
            None => timeout,
        };
        let due = self.s.now + delay;
        if self.s.messages.len() < MAX_MESSAGES {
            self.s.messages.push(Sent { at, due, reply });
        } else {
            self.message_fails(at, (ERR_RESOURCE, 0));
        }
        Ok(())
    }

    /// Ends messages whose answer has come, or whose time is over.
    pub(crate) fn messages(&mut self) {
        let mut next = 0;
        while let Some(Sent { at, due, reply }) = self.s.messages.get(next).copied() {
            // A program that sets TO ends the message.
            let is_ended = self.has(at + 5, TO);
            if due > self.s.now && !is_ended {
                next += 1;
                continue;
            }
            self.s.messages.remove(next);
            let code = self.code;
            let reply = reply.filter(|_| !is_ended);
            let reply = reply.and_then(|reply| code.replies.get(reply as usize));
            let error = reply.map_or((1, EXERR_TIMEOUT), |reply| reply.error);
            if error.0 != 0 {
                self.message_fails(at, error);
                continue;
            }
            let length = reply.map_or(0, |reply| self.answer(reply));
            self.set(at + 4, EW | ST, false);
            self.put(at + 6, 0_u16.to_le_bytes());
            self.put(at + 8, error.1.to_le_bytes());
            self.put(at + 14, length.to_le_bytes());
            self.set(at + 4, DN, true);
        }
    }

    /// A message errs with ERR and EXERR.
    fn message_fails(&mut self, at: u32, (err, exerr): (u16, u32)) {
        self.set(at + 4, EW | ST, false);
        self.put(at + 6, err.to_le_bytes());
        self.put(at + 8, exerr.to_le_bytes());
        self.set(at + 4, ER, true);
    }

    /// Writes the data of an answer to its destination; returns how many bytes.
    fn answer(&mut self, reply: &Reply) -> u16 {
        let range = reply.destination.as_ref().and_then(|area| self.range(area).ok());
        // A subscript out of range is no fault of the task that runs next.
        let _ = self.take_fault();
        let Some(range) = range else { return 0 };
        let room = range.end.max(range.array_end).saturating_sub(range.at) as usize;
        let length = reply.data.len().min(room);
        self.s
            .memory
            .write(range.at as usize, reply.data.get(..length).unwrap_or_default());
        u16::try_from(length).unwrap_or(u16::MAX)
    }
}

fn put(value: &mut [u8], bytes: &[u8]) -> usize {
    let count = bytes.len().min(value.len());
    if let (Some(place), Some(bytes)) = (value.get_mut(..count), bytes.get(..count)) {
        place.copy_from_slice(bytes);
    }
    count
}
