//! What a viewer may ask for, and what it is answered.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// A request, by its `do`.
#[derive(Deserialize, Debug)]
#[serde(tag = "do", rename_all = "snake_case")]
pub(super) enum Ask {
    /// Is anybody there?
    Ping,
}

/// Why something was not done.
#[derive(Serialize, Clone, Debug, Default)]
pub(super) struct Refusal {
    /// For people.
    pub(super) text: String,
}

impl Refusal {
    pub(super) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into() }
    }
}

/// Reads a message: its `id`, which the answer repeats, and what it asks for.
pub(super) fn read(text: &str) -> (Value, Result<Ask, Refusal>) {
    let message: Value = match serde_json::from_str(text) {
        Ok(message) => message,
        Err(error) => return (Value::Null, Err(Refusal::new(format!("not a message: {error}")))),
    };
    let id = message.get("id").cloned().unwrap_or(Value::Null);
    let ask = serde_json::from_value(message).map_err(|error| Refusal::new(format!("not a request: {error}")));
    (id, ask)
}

/// The answer to a message.
pub(super) fn reply(id: &Value, answer: Result<Value, Refusal>) -> String {
    match answer {
        Ok(ok) => json!({"id": id, "ok": ok}),
        Err(error) => json!({"id": id, "error": error}),
    }
    .to_string()
}
