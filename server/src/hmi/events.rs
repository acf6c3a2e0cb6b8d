//! What has happened to instructions and to the faults of axes: its text, its cause and what to do about it.

use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_controller::{Cause, Event, FaultChange};
use arcline_instruction_set::{Ending, Flag, Object};
use axum::extract::ws::Utf8Bytes;
use serde_json::{Value, json};
use tokio::time::{MissedTickBehavior, interval};

use super::Shared;
use super::message::Refusal;
use super::rights::Thing;
use crate::plant::{Change, Logged, ending};

/// Time between two pushes.
const EVERY: Duration = Duration::from_millis(100);
/// Events of one message at most: the newest.
const MOST: usize = 1000;
/// Pushes that may wait for a viewer; one that is too slow asks for what it missed.
pub(super) const WAITING: usize = 64;

/// Pushes events as they come, until the future is dropped.
pub(super) async fn produce(shared: Arc<Shared>) {
    let mut last = shared.plant.events_since(0, |_, events| newest(&events));
    let mut due = interval(EVERY);
    due.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        due.tick().await;
        if shared.events.receiver_count() == 0 {
            continue;
        }
        let (number, events) = shared.plant.events_since(last.unwrap_or(0), |image, events| {
            (newest(&events), tell(&shared, image, &events))
        });
        if number.is_some() {
            last = number;
            let text: Utf8Bytes = json!({"push": "event", "events": events}).to_string().into();
            // Everybody may just have gone.
            let _ = shared.events.send(text);
        }
    }
}

impl Shared {
    /// The newest events behind a number.
    pub(super) fn events(&self, since: Option<u64>) -> Value {
        let since = since.unwrap_or(0);
        let events = self
            .plant
            .events_since(since, |image, events| tell(self, image, &events));
        json!({"events": events})
    }
}

fn newest(events: &[Logged]) -> Option<u64> {
    events.last().map(|logged| logged.number)
}

fn tell(shared: &Shared, image: &Image, events: &[Logged]) -> Vec<Value> {
    let skipped = events.len().saturating_sub(MOST);
    events[skipped..]
        .iter()
        .map(|logged| event(shared, image, logged))
        .collect()
}

fn event(shared: &Shared, image: &Image, logged: &Logged) -> Value {
    let tick = logged.change.tick();
    let at = logged.at.duration_since(UNIX_EPOCH).unwrap_or_default();
    let mut told = match &logged.change {
        Change::Instruction { event, target } => instruction(shared, image, event, *target),
        Change::Fault(change) => fault(shared, image, change),
    };
    told["seq"] = logged.number.into();
    told["tick"] = tick.into();
    told["time_s"] = (tick as f64 * shared.plant.machine().period()).into();
    told["at_ms"] = (at.as_micros() as f64 / 1e3).into();
    told
}

/// A change of an instruction's status.
fn instruction(shared: &Shared, image: &Image, event: &Event, target: Option<u16>) -> Value {
    let machine = shared.plant.machine();
    let flags = |word| -> Vec<&str> { Flag::in_word(word).map(Flag::name).collect() };
    let object = match (event.mnemonic.instruction().object, target) {
        (Object::MotionGroup, _) => Some(Thing::Group),
        (object, place) => place.map(|place| Thing::of(object, place)),
    };
    let erred = event.set & Flag::Er.mask() != 0;
    let error = erred.then(|| Refusal::motion(event.err, event.exerr, event.mnemonic));
    // Instances are the low half of a ticket.
    let origins = shared.origins();
    let origin = origins.of(event.ticket.0 as u32);
    json!({
        "ticket": event.ticket.0,
        "tag": image.control_name(event.control),
        "instruction": event.mnemonic.to_string(),
        "object": object.map(|object| object.name(machine)),
        "text": origin.and_then(|origin| origin.text.as_deref()),
        "viewer": origin.map(|origin| origin.viewer.as_str()),
        "set": flags(event.set),
        "clear": flags(event.clear),
        "err": event.err,
        "exerr": event.exerr,
        "error": error,
        "ended": cause(machine, image, event.cause),
    })
}

/// A change of the faults of an axis.
fn fault(shared: &Shared, image: &Image, change: &FaultChange) -> Value {
    let machine = shared.plant.machine();
    let axis = machine.axes.get(usize::from(change.axis));
    json!({
        "fault": {
            "axis": axis.map(|axis| axis.name.as_str()),
            "set": Ending::words(change.set),
            "again": Ending::words(change.again),
            "clear": Ending::words(change.clear),
            "by": cause(machine, image, change.by),
            "refused": change.refused.map(|command| json!({
                "text": command.to_string(),
                "by": cause(machine, image, command.by),
                "last": command.last,
                "asked": command.asked,
            })),
        },
    })
}

/// What ended an instruction or cleared a fault: its text and its parts.
fn cause(machine: &Machine, image: &Image, cause: Cause) -> Option<Value> {
    let text = ending(machine, image, cause)?.to_string();
    Some(match cause {
        Cause::Itself => return None,
        Cause::Instruction { ticket, mnemonic, .. } => json!({
            "by": "instruction", "text": text, "ticket": ticket.0, "instruction": mnemonic.to_string(),
        }),
        Cause::Fault { axis, faults } => json!({
            "by": "fault", "text": text,
            "axis": machine.axes.get(usize::from(axis)).map(|axis| axis.name.as_str()),
            "faults": Ending::words(faults),
        }),
        Cause::StopAll => json!({"by": "stop", "text": text}),
        Cause::Jog(why) => json!({"by": "dead-man", "text": text, "reason": why.word()}),
    })
}
