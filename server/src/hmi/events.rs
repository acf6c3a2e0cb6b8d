//! What has happened to instructions, told with its text, its cause and what to do about it.

use std::sync::Arc;
use std::time::Duration;

use arcline_controller::image::Image;
use arcline_instruction_set::{Flag, Object};
use axum::extract::ws::Utf8Bytes;
use serde_json::{Value, json};
use tokio::time::{MissedTickBehavior, interval};

use super::Shared;
use super::message::Refusal;
use super::rights::Thing;
use crate::plant::Logged;

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
    let event = &logged.event;
    let machine = shared.plant.machine();
    let flags = |word| -> Vec<&str> { Flag::in_word(word).map(Flag::name).collect() };
    let object = event.mnemonic.instruction().object;
    let object = match (object, logged.target) {
        (Object::MotionGroup, _) => Some(Thing::Group),
        (object, place) => place.map(|place| Thing::of(object, place)),
    };
    let erred = event.set & Flag::Er.mask() != 0;
    let error = erred.then(|| Refusal::motion(event.err, event.exerr, event.mnemonic));
    // Instances are the low half of a ticket.
    let origins = shared.origins();
    let origin = origins.of(event.ticket.0 as u32);
    json!({
        "seq": logged.number,
        "tick": event.tick,
        "time_s": event.tick as f64 * machine.period(),
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
    })
}
