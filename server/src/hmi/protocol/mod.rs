//! The messages between a page and the server, as types in both directions: [`Request`] with an answer type for each request, [`Push`],
//! and the two descriptions that HTTP serves.
//!
//! A test writes `web/types/protocol.d.ts` and the tables of `docs/HMI.md` from these types, doc comments included. Binary frames of
//! samples are not here (`hmi::frames`).

mod answer;
mod push;
mod refusal;
mod request;
#[cfg(test)]
mod typescript;

use serde::Serialize;
use serde_json::Value;

pub(super) use answer::*;
pub(super) use push::*;
pub(super) use refusal::Refusal;
pub(super) use request::*;

/// Reads a message: its `id`, which the answer repeats, and its request.
pub(super) fn read(text: &str) -> (Value, Result<Request, Refusal>) {
    let message: Value = match serde_json::from_str(text) {
        Ok(message) => message,
        Err(error) => return (Value::Null, Err(Refusal::new(format!("not a message: {error}")))),
    };
    let id = message.get("id").cloned().unwrap_or(Value::Null);
    let request = serde_json::from_value(message).map_err(|error| Refusal::new(format!("not a request: {error}")));
    (id, request)
}

/// The text of the answer to a message.
pub(super) fn reply(id: &Value, answer: Result<Answer, Refusal>) -> String {
    match answer {
        Ok(Answer(ok)) => format!("{{\"id\":{id},\"ok\":{ok}}}"),
        Err(error) => format!("{{\"id\":{id},\"error\":{}}}", text_of(&error)),
    }
}

/// The answer to a request, as JSON. [`Asks::answer`] makes it, so that each request has the answer of its own type.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Answer(String);

/// A request of a page, with the type of its answer.
pub(super) trait Asks {
    /// The answer.
    type Answer: Serialize;

    /// The answer as JSON.
    fn answer(&self, answer: Result<Self::Answer, Refusal>) -> Result<Answer, Refusal> {
        answer.map(|answer| Answer(text_of(&answer)))
    }
}

/// A message as JSON.
pub(super) fn text_of(message: &impl Serialize) -> String {
    serde_json::to_string(message).expect("the keys of a message are text and its numbers are JSON's")
}
