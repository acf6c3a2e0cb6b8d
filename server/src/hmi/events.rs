//! The events of instructions and of the faults of axes: text, cause and remedy.

use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_controller::{Cause, FaultChange};
use arcline_instruction_set::{Ending, Flag, Object};
use axum::extract::ws::Utf8Bytes;
use tokio::time::sleep;

use super::Shared;
use super::protocol::{
    CauseKind, EndCause, Event, EventChange, EventPage, FaultEvent, InstructionEvent, Push, Refusal, RefusedCommand,
    RestEvent, SlowPart, text_of,
};
use crate::plant::control::MotionObject;
use crate::plant::{Change, ContourRest, Executions, Logged, Plant, RestCause};

/// Time between two pushes.
const EVERY: Duration = Duration::from_millis(100);
/// Events of one message at most: the newest.
const MOST: usize = 1000;
/// Pushes that may wait for a viewer; a viewer that is too slow asks for the missed ones.
pub(super) const WAITING: usize = 64;

/// Pushes events as they come, until the future is dropped.
pub(super) async fn produce(shared: Arc<Shared>) {
    let mut last = shared.plant.events_since(0, |_, _, events| newest(&events));
    let mut changes = shared.plant.changes();
    loop {
        // The changes of tags include those of instructions and faults.
        sleep(EVERY).await;
        if changes.next().await.is_none() {
            return;
        }
        if shared.events.receiver_count() == 0 {
            continue;
        }
        let (number, events) = shared
            .plant
            .events_since(last.unwrap_or(0), |image, executions, events| {
                (newest(&events), tell(&shared.plant, (image, executions), &events))
            });
        if number.is_some() {
            last = number;
            let text: Utf8Bytes = text_of(&Push::Event { events }).into();
            // The last viewer may just have gone.
            let _ = shared.events.send(text);
        }
    }
}

/// The newest events behind a number.
pub(super) fn since(plant: &Plant, since: Option<u64>) -> EventPage {
    let since = since.unwrap_or(0);
    let events = plant.events_since(since, |image, executions, events| {
        tell(plant, (image, executions), &events)
    });
    EventPage { events }
}

fn newest(events: &[Logged]) -> Option<u64> {
    events.last().map(|logged| logged.number)
}

fn tell(plant: &Plant, known: (&Image, &Executions), events: &[Logged]) -> Vec<Event> {
    let skipped = events.len().saturating_sub(MOST);
    events[skipped..]
        .iter()
        .map(|logged| event(plant, known, logged))
        .collect()
}

fn event(plant: &Plant, known: (&Image, &Executions), logged: &Logged) -> Event {
    let tick = logged.change.tick();
    let at = logged.at.duration_since(UNIX_EPOCH).unwrap_or_default();
    Event {
        seq: logged.number,
        tick,
        time_s: tick as f64 * plant.machine().period(),
        at_ms: at.as_micros() as f64 / 1e3,
        change: match &logged.change {
            Change::Instruction { event, target } => {
                EventChange::Instruction(instruction(plant, known, event, *target))
            }
            Change::Fault(change) => EventChange::Fault {
                fault: fault(plant, known.0, change),
            },
            Change::Rest(rest) => EventChange::Rest {
                rest: rest_event(plant, rest),
            },
        },
    }
}

/// A change of an instruction's status.
fn instruction(
    plant: &Plant,
    (image, executions): (&Image, &Executions),
    event: &arcline_controller::Event,
    target: Option<u16>,
) -> InstructionEvent {
    let machine = plant.machine();
    let flags = |word| -> Vec<&'static str> { Flag::in_word(word).map(Flag::name).collect() };
    let object = match (event.mnemonic.instruction().object, target) {
        (Object::MotionGroup, _) => Some(MotionObject::Group),
        (object, place) => place.map(|place| MotionObject::of(object, place)),
    };
    let erred = event.set & Flag::Er.mask() != 0;
    let error = erred.then(|| Refusal::motion(event.err, event.exerr, event.mnemonic));
    let origin = executions.origin(event.ticket);
    let viewer = origin.filter(|origin| origin.principal.viewer().is_some());
    InstructionEvent {
        ticket: event.ticket.0,
        tag: image.control_name(event.control).to_owned(),
        instruction: event.mnemonic.name(),
        object: object.map(|object| object.name(machine).to_owned()),
        text: origin.and_then(|origin| origin.text.as_deref()).map(str::to_owned),
        viewer: viewer.map(|viewer| viewer.client.address.clone()),
        set: flags(event.set),
        clear: flags(event.clear),
        err: event.err,
        exerr: event.exerr,
        error,
        ended: cause(machine, image, event.cause),
    }
}

/// A change of the faults of an axis.
fn fault(plant: &Plant, image: &Image, change: &FaultChange) -> FaultEvent {
    let machine = plant.machine();
    let axis = machine.axes.get(usize::from(change.axis));
    FaultEvent {
        axis: axis.map(|axis| axis.name.clone()),
        set: Ending::words(change.set),
        again: Ending::words(change.again),
        clear: Ending::words(change.clear),
        by: cause(machine, image, change.by),
        refused: change.refused.map(|command| RefusedCommand {
            text: command.to_string(),
            by: cause(machine, image, command.by),
            last: command.last,
            asked: command.asked,
        }),
    }
}

/// A rest on the way.
fn rest_event(plant: &Plant, rest: &ContourRest) -> RestEvent {
    let system = plant.machine().systems.get(usize::from(rest.system));
    let (slow, text) = match rest.cause {
        RestCause::Starved => (
            SlowPart::Program,
            "The queue was empty: the program sent its next move too late",
        ),
        RestCause::Unplanned => (
            SlowPart::Planner,
            "Moves waited in the queue, but their plan was not ready in time",
        ),
    };
    RestEvent {
        system: system.map(|system| system.name.clone()),
        slow,
        count: rest.count,
        text,
    }
}

/// The cause that ended an instruction or cleared a fault: its text and its parts.
fn cause(machine: &Machine, image: &Image, cause: Cause) -> Option<EndCause> {
    let text = image.ending(machine, cause)?.to_string();
    let by = match cause {
        Cause::Itself => return None,
        Cause::Instruction { ticket, mnemonic, .. } => CauseKind::Instruction {
            ticket: ticket.0,
            instruction: mnemonic.name(),
        },
        Cause::Fault { axis, faults } => CauseKind::Fault {
            axis: machine.axes.get(usize::from(axis)).map(|axis| axis.name.clone()),
            faults: Ending::words(faults),
        },
        Cause::StopAll => CauseKind::Stop {},
        Cause::Jog(why) => CauseKind::DeadMan { reason: why.word() },
    };
    Some(EndCause { text, by })
}
