//! Trace, class 0x0304: samples of every tick, by signal and from a trigger on. The layout is docs/TRACE.md.

use arcline_controller::samples::{self, Column};
use arcline_instruction_set::Flag;
use arcline_proto::arcline::trace::service::{LIST_SIGNALS, READ, START, STOP};
use arcline_proto::arcline::trace::{
    self as wire, ListSignals, ReadRows, Rows, SignalList, State, TRIGGER_INDEX, TraceRequest, attribute,
    class_attribute,
};
use arcline_proto::cip::{CipStatus, REPLY_HEAD, Reply, service};
use bytes::Bytes;

use super::object::{Access, Extent, Object, ObjectContext, On, OwnService};
use super::values::{no_attribute, u8_value, u16_value, u32_value, u64_value};
use crate::eip::status::unknown;
use crate::plant::{Plant, Right};
use crate::trace::{Config, Phase, TraceStatus, Trigger};

#[derive(Debug)]
pub(super) struct Traces;

fn standing(cx: &ObjectContext<'_, '_>, instance: u32) -> Result<TraceStatus, CipStatus> {
    cx.device().plant.trace().standing(instance).ok_or_else(unknown)
}

impl Object for Traces {
    fn class(&self) -> u16 {
        wire::CLASS
    }

    fn name(&self) -> &'static str {
        "Trace"
    }

    fn is_late(&self) -> bool {
        true
    }

    fn services(&self) -> &'static [OwnService] {
        const fn row(code: u8, name: &'static str, on: On, right: Right) -> OwnService {
            OwnService {
                code,
                name,
                on,
                access: Access::Late,
                right,
            }
        }
        &const {
            [
                row(LIST_SIGNALS, "List Signals", On::Class, Right::Look),
                row(service::CREATE, "Create", On::Class, Right::SetUpTrace),
                row(READ, "Read", On::Instance, Right::Look),
                row(START, "Start", On::Instance, Right::SetUpTrace),
                row(STOP, "Stop", On::Instance, Right::SetUpTrace),
                row(service::DELETE, "Delete", On::Instance, Right::SetUpTrace),
            ]
        }
    }

    fn serve(&self, cx: &mut ObjectContext<'_, '_>, instance: u32) -> Result<Reply, CipStatus> {
        let (plant, data) = (&cx.device().plant, &cx.request.data);
        let room = cx.context.budget.saturating_sub(REPLY_HEAD);
        let data = match cx.request.service {
            LIST_SIGNALS => list(plant, data, room),
            service::CREATE => create(plant, data),
            READ => read(plant, instance, data, room),
            START => known(plant.trace().arm(instance)),
            STOP => known(plant.trace().stop(instance)),
            service::DELETE => known(plant.trace().delete(instance)),
            _ => Err(CipStatus::SERVICE_NOT_SUPPORTED),
        }?;
        Ok(Reply::success(cx.request.service, data))
    }

    fn extent(&self, cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        let instances = cx.device().plant.trace().instances();
        Ok(Extent {
            highest: instances.last().copied().unwrap_or(0),
            count: instances.len() as u32,
            last_attribute: attribute::MISSING,
        })
    }

    fn last_class_attribute(&self) -> u16 {
        class_attribute::MISSING
    }

    fn class_attribute(&self, cx: &ObjectContext<'_, '_>, id: u16) -> Result<Bytes, CipStatus> {
        let plant = &cx.device().plant;
        let machine = plant.machine();
        let narrow = |wide: u64| u32::try_from(wide).unwrap_or(u32::MAX);
        let stored = plant.trace().stored_ticks();
        match id {
            class_attribute::PERIOD => u32_value(narrow(machine.period_ns)),
            class_attribute::SIGNALS => u16_value(signals(plant)),
            class_attribute::FIRST_TICK => u64_value(stored.first),
            class_attribute::NEXT_TICK => u64_value(stored.next),
            class_attribute::CAPACITY => u32_value(narrow(stored.capacity)),
            class_attribute::MISSING => u32_value(narrow(stored.missing)),
            _ => no_attribute(),
        }
    }

    fn check(&self, cx: &ObjectContext<'_, '_>, instance: u32) -> Result<(), CipStatus> {
        standing(cx, instance).map(|_| ())
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let standing = standing(cx, instance)?;
        match id {
            attribute::STATE => u8_value(state(standing.phase).code()),
            attribute::TRIGGER_TICK => u64_value(standing.trigger),
            attribute::FIRST_TICK => u64_value(standing.first),
            attribute::NEXT_TICK => u64_value(standing.next),
            attribute::SIGNALS => u16_value(standing.signals as u16),
            attribute::EVERY => u16_value(standing.every),
            attribute::MISSING => u32_value(u32::try_from(standing.missing).unwrap_or(u32::MAX)),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7]
    }
}

fn state(phase: Phase) -> State {
    match phase {
        Phase::Armed => State::Armed,
        Phase::Running => State::Running,
        Phase::Complete => State::Complete,
        Phase::Stopped => State::Stopped,
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
    let ListSignals { first } = ListSignals::decode(data)?;
    let names = samples::names(plant.machine());
    let names = names.iter().skip(first.into());
    Ok(SignalList::encode(signals(plant), names, room))
}

fn create(plant: &Plant, data: &[u8]) -> Result<Bytes, CipStatus> {
    let request = TraceRequest::decode(data)?;
    let find = |name: &str, index: u16| {
        samples::find(plant.machine(), name).ok_or(CipStatus::PATH_DESTINATION_UNKNOWN.with(index))
    };
    let trigger = match request.trigger {
        wire::Trigger::Now => Trigger::None,
        wire::Trigger::Rises { signal, level } => Trigger::Rises(find(&signal, TRIGGER_INDEX)?, level),
        wire::Trigger::Falls { signal, level } => Trigger::Falls(find(&signal, TRIGGER_INDEX)?, level),
        wire::Trigger::BecomesTrue { signal } => Trigger::BecomesTrue(find(&signal, TRIGGER_INDEX)?),
        wire::Trigger::BecomesFalse { signal } => Trigger::BecomesFalse(find(&signal, TRIGGER_INDEX)?),
        wire::Trigger::Instruction { name, flags } => Trigger::Instruction {
            of: name,
            flags: if flags == 0 { Flag::Er.mask() } else { flags },
        },
    };
    let signals = (0..).zip(&request.signals).map(|(index, name)| find(name, index));
    let config = Config {
        signals: signals.collect::<Result<Vec<Column>, CipStatus>>()?,
        before: request.before,
        length: request.length,
        every: request.every,
        trigger,
    };
    let instance = plant
        .trace()
        .create(config)
        .map_err(|_| CipStatus::RESOURCE_UNAVAILABLE)?;
    u32_value(instance)
}

fn read(plant: &Plant, instance: u32, data: &[u8], room: usize) -> Result<Bytes, CipStatus> {
    let ReadRows { from, most } = ReadRows::decode(data)?;
    let signals = plant.trace().standing(instance).ok_or_else(unknown)?.signals;
    let fit = Rows::fit(room, signals);
    if fit == 0 {
        return Err(CipStatus::REPLY_TOO_LARGE);
    }
    let most = if most == 0 { fit } else { fit.min(most.into()) };
    let block = plant.trace().read(instance, from, most).ok_or_else(unknown)?;
    let rows = Rows {
        state: state(block.standing.phase),
        // At most MAX_SIGNALS.
        signals: signals as u16,
        every: block.standing.every,
        first: block.first,
        samples: block.values,
    };
    Ok(rows.to_bytes())
}
