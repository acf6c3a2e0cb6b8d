//! Trace, class 0x0304: samples of every tick, by signal and from a trigger on. The layout is docs/TRACE.md.

use arcline_controller::samples::{self, Column};
use arcline_instruction_set::Flag;
use arcline_proto::cip::{CipStatus, REPLY_HEAD, Reply, Request, service};
use arcline_proto::epath::Target;
use bytes::{BufMut, Bytes, BytesMut};

use super::{Class, Extent, attributes, no_attribute, short_string, u8_value, u16_value, u32_value, u64_value};
use crate::eip::router::Context;
use crate::eip::tags::unknown;
use crate::plant::Plant;
use crate::trace::{Config, Phase, Standing, Trigger};

/// The class code.
pub(super) const CLASS: u16 = 0x0304;

/// On the class: the names of the signals.
const LIST_SIGNALS: u8 = 0x32;
/// On an instance: rows.
const READ: u8 = 0x33;
/// On an instance: arms it again.
const START: u8 = 0x06;
/// On an instance: stops it.
const STOP: u8 = 0x07;

/// Signals of a trace at most.
const MOST_SIGNALS: u16 = 256;
/// Bytes in front of the rows of a reply.
const READ_HEAD: usize = 16;
/// In place of a signal: the trigger's.
const THE_TRIGGER: u16 = 0xFFFF;

/// Answers a request for the class or a trace.
pub(super) fn serve(context: &Context<'_>, request: &Request, target: &Target<'_>) -> Reply {
    let plant = &context.device.plant;
    let room = context.budget.saturating_sub(REPLY_HEAD);
    let instance = target.instance.unwrap_or(0);
    let done = match (request.service, instance) {
        (LIST_SIGNALS, 0) => list(plant, &request.data, room),
        (service::CREATE, 0) => create(plant, &request.data),
        (READ, 1..) => read(plant, instance, &request.data, room),
        (START, 1..) => known(plant.trace().arm(instance)),
        (STOP, 1..) => known(plant.trace().stop(instance)),
        (service::DELETE, 1..) => known(plant.trace().delete(instance)),
        _ => return attributes(context, &Traces(plant), request, target),
    };
    match done {
        Ok(data) => Reply::success(request.service, data),
        Err(status) => Reply::error(request.service, status),
    }
}

struct Traces<'a>(&'a Plant);

impl Traces<'_> {
    fn standing(&self, instance: u32) -> Result<Standing, CipStatus> {
        self.0.trace().standing(instance).ok_or_else(unknown)
    }
}

impl Class for Traces<'_> {
    fn extent(&self) -> Extent {
        let instances = self.0.trace().instances();
        Extent {
            highest: instances.last().copied().unwrap_or(0),
            count: instances.len() as u32,
            last_attribute: 7,
        }
    }

    fn last_class_attribute(&self) -> u16 {
        13
    }

    fn class_attribute(&self, id: u16) -> Result<Bytes, CipStatus> {
        let machine = self.0.machine();
        let narrow = |wide: u64| u32::try_from(wide).unwrap_or(u32::MAX);
        let kept = self.0.trace().kept();
        match id {
            8 => u32_value(narrow(machine.period_ns)),
            9 => u16_value(signals(self.0)),
            10 => u64_value(kept.first),
            11 => u64_value(kept.next),
            12 => u32_value(narrow(kept.most)),
            13 => u32_value(narrow(kept.missing)),
            _ => no_attribute(),
        }
    }

    fn check(&self, instance: u32) -> Result<(), CipStatus> {
        self.standing(instance).map(|_| ())
    }

    fn attribute(&self, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let standing = self.standing(instance)?;
        match id {
            1 => u8_value(phase(standing.phase)),
            2 => u64_value(standing.trigger),
            3 => u64_value(standing.first),
            4 => u64_value(standing.next),
            5 => u16_value(standing.signals as u16),
            6 => u16_value(standing.every),
            7 => u32_value(u32::try_from(standing.missing).unwrap_or(u32::MAX)),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7]
    }
}

fn phase(phase: Phase) -> u8 {
    match phase {
        Phase::Armed => 0,
        Phase::Running => 1,
        Phase::Complete => 2,
        Phase::Stopped => 3,
    }
}

fn known(done: bool) -> Result<Bytes, CipStatus> {
    if done { Ok(Bytes::new()) } else { Err(unknown()) }
}

/// Columns of a row behind the tick.
fn signals(plant: &Plant) -> u16 {
    u16::try_from(samples::width(plant.machine()) - 1).unwrap_or(u16::MAX)
}

fn list(plant: &Plant, data: &[u8], room: usize) -> Result<Bytes, CipStatus> {
    let mut data = Reader(data);
    let first = data.u16()?;
    data.end()?;
    let mut out = BytesMut::new();
    out.put_u16_le(signals(plant));
    out.put_u16_le(0);
    let mut count = 0u16;
    for name in samples::names(plant.machine()).iter().skip(first.into()) {
        let name = short_string(name);
        if out.len() + name.len() > room || count == u16::MAX {
            break;
        }
        out.put_slice(&name);
        count += 1;
    }
    if let Some(place) = out.get_mut(2..4) {
        place.copy_from_slice(&count.to_le_bytes());
    }
    Ok(out.freeze())
}

fn create(plant: &Plant, data: &[u8]) -> Result<Bytes, CipStatus> {
    let mut data = Reader(data);
    let (before, length, every) = (data.u32()?, data.u32()?, data.u16()?);
    let find = |name: &str, place: u16| {
        samples::find(plant.machine(), name).ok_or(CipStatus::PATH_DESTINATION_UNKNOWN.with(place))
    };
    let trigger = match data.u8()? {
        0 => Trigger::None,
        kind @ 1..=2 => {
            let signal = find(data.name()?, THE_TRIGGER)?;
            let level = data.f64()?;
            if !level.is_finite() {
                return Err(CipStatus::INVALID_PARAMETER);
            }
            match kind {
                1 => Trigger::Rises(signal, level),
                _ => Trigger::Falls(signal, level),
            }
        }
        3 => Trigger::BecomesTrue(find(data.name()?, THE_TRIGGER)?),
        4 => Trigger::BecomesFalse(find(data.name()?, THE_TRIGGER)?),
        5 => {
            let of = data.name()?.to_owned();
            let flags = match data.u32()? {
                0 => Flag::Er.mask(),
                flags => flags,
            };
            Trigger::Instruction { of, flags }
        }
        _ => return Err(CipStatus::INVALID_PARAMETER),
    };
    let count = data.u16()?;
    if count == 0 || count > MOST_SIGNALS {
        return Err(CipStatus::INVALID_PARAMETER);
    }
    let signals: Vec<Column> = (0..count)
        .map(|place| find(data.name()?, place))
        .collect::<Result<_, CipStatus>>()?;
    data.end()?;
    let config = Config {
        signals,
        before,
        length,
        every,
        trigger,
    };
    let instance = plant
        .trace()
        .create(config)
        .map_err(|_| CipStatus::RESOURCE_UNAVAILABLE)?;
    u32_value(instance)
}

fn read(plant: &Plant, instance: u32, data: &[u8], room: usize) -> Result<Bytes, CipStatus> {
    let mut data = Reader(data);
    let (from, most) = (data.u64()?, usize::from(data.u16()?));
    data.end()?;
    let signals = plant.trace().standing(instance).ok_or_else(unknown)?.signals;
    let fit = room.saturating_sub(READ_HEAD) / (signals * size_of::<f64>());
    if fit == 0 {
        return Err(CipStatus::REPLY_TOO_LARGE);
    }
    let most = if most == 0 { fit } else { most.min(fit) };
    let block = plant.trace().read(instance, from, most).ok_or_else(unknown)?;
    let mut out = BytesMut::with_capacity(READ_HEAD + block.values.len() * size_of::<f64>());
    out.put_u8(phase(block.standing.phase));
    out.put_u8(0);
    out.put_u16_le(block.rows as u16);
    out.put_u16_le(signals as u16);
    out.put_u16_le(block.standing.every);
    out.put_u64_le(block.first);
    block.values.iter().for_each(|value| out.put_f64_le(*value));
    Ok(out.freeze())
}

/// The parts of a request in order.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], CipStatus> {
        let (taken, rest) = self.0.split_first_chunk().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn u8(&mut self) -> Result<u8, CipStatus> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, CipStatus> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, CipStatus> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, CipStatus> {
        self.array().map(u64::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64, CipStatus> {
        self.array().map(f64::from_le_bytes)
    }

    fn name(&mut self) -> Result<&'a str, CipStatus> {
        let length = usize::from(self.u8()?);
        let (name, rest) = self.0.split_at_checked(length).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        self.0 = rest;
        std::str::from_utf8(name).map_err(|_| CipStatus::INVALID_PARAMETER)
    }

    fn end(self) -> Result<(), CipStatus> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(CipStatus::TOO_MUCH_DATA)
        }
    }
}
