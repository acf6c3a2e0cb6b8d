//! What a viewer may ask for, and what it is answered.

use arcline_instruction_set::{Explanation, Mnemonic, MotionError, OperandIndex, describe, explain};
use arcline_structured_text::SyntaxError;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::plant::CallRefused;

/// A request, by its `do`.
#[derive(Deserialize, Debug)]
#[serde(tag = "do", rename_all = "snake_case")]
pub(super) enum Ask {
    /// Is anybody there?
    Ping,
    /// The right to drive an object.
    Take {
        object: String,
        #[serde(default)]
        force: bool,
    },
    /// The right back.
    Release { object: String },
    /// One instruction as Structured Text.
    Execute { text: String },
    /// The Structured Text of a filled form.
    Line {
        instruction: String,
        #[serde(default)]
        operands: Map<String, Value>,
    },
    /// Moves an axis as long as [`Ask::Keep`] comes; u/s with its sign, u/s².
    Jog {
        axis: String,
        speed: f64,
        accel: Option<f64>,
        decel: Option<f64>,
    },
    /// The hand is still on the button.
    Keep { axis: String },
    /// It is not.
    JogEnd { axis: String },
    /// Stops an object, or everything.
    Stop { object: Option<String> },
    /// Takes a share of the programmed speeds, percent.
    Override { coordinate_system: String, percent: f64 },
    /// An override of 0.
    Hold { coordinate_system: String },
    /// The override from before.
    Resume { coordinate_system: String },
    /// What one instruction would do.
    Preview { text: String },
    /// What a program would do.
    DryRun { text: String },
    /// What is wrong with a program.
    Check { text: String },
    /// Runs a program; `step`: it waits in front of its first statement.
    Run {
        text: String,
        #[serde(default, alias = "paused")]
        step: bool,
    },
    /// One statement more.
    Step,
    /// No further statement for now.
    Pause,
    /// All further statements.
    Continue,
    /// No further statement.
    End,
    /// Names and types of tags.
    Tags {
        #[serde(default)]
        pattern: String,
        after: Option<String>,
    },
    /// Values of tags, once.
    Read { names: Vec<String> },
    /// Values of tags, again and again, in place of those before.
    Watch { names: Vec<String> },
    /// A value into a tag.
    Write { tag: String, value: Value },
    /// Frames of samples.
    Trace { on: bool },
    /// A frame of what was before a tick.
    Past { before: u64 },
    /// What has happened to instructions.
    Events { since: Option<u64> },
}

/// Why something was not done.
#[derive(Serialize, Clone, PartialEq, Debug, Default)]
pub(super) struct Refusal {
    /// For people.
    pub(super) text: Box<str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) err: Option<i16>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) exerr: Option<i8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cause: Option<&'static str>,
    /// What EXERR points at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) concerns: Option<Box<str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) remedy: Option<&'static str>,
    /// Place in a text, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) line: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) column: Option<u32>,
    /// The operand at fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) member: Option<Box<str>>,
    /// The control that was missing.
    #[serde(flatten)]
    pub(super) missing: Option<Box<MissingControl>>,
}

/// Control that a request needs and its viewer does not have.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub(super) struct MissingControl {
    /// The object.
    control: Box<str>,
    /// The viewer that has control of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    holder: Option<Box<str>>,
}

impl Refusal {
    /// Without control of an object; `holder` is the viewer that has it.
    pub(super) fn control(object: &str, holder: Option<&str>) -> Self {
        let text = match holder {
            Some(holder) => format!("You do not have control of {object}: {holder} has it."),
            None => format!("You do not have control of {object}."),
        };
        let missing = MissingControl {
            control: object.into(),
            holder: holder.map(Into::into),
        };
        Self {
            missing: Some(Box::new(missing)),
            ..Self::new(text)
        }
    }

    pub(super) fn new(text: impl Into<Box<str>>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }

    /// A motion error, as `arcline explain` tells it.
    pub(super) fn motion(err: i16, exerr: i8, mnemonic: Mnemonic) -> Self {
        let codes = Self {
            err: Some(err),
            exerr: Some(exerr),
            ..Self::default()
        };
        let Some(Explanation {
            headline,
            cause,
            concerns,
            remedy,
        }) = explain(err, exerr, Some(mnemonic))
        else {
            let text = describe(err, exerr, Some(mnemonic)).into();
            return Self { text, ..codes };
        };
        let operand = match MotionError::from_codes(err, exerr) {
            Some(MotionError::ParameterOutOfRange(operand)) => Some(operand),
            _ => None,
        };
        Self {
            text: headline.into(),
            cause: Some(cause),
            concerns: concerns.map(Into::into),
            remedy: Some(remedy),
            member: operand.and_then(|operand| member(mnemonic, operand)),
            ..codes
        }
    }

    /// A call that was not executed.
    pub(super) fn call(refused: &CallRefused, mnemonic: Mnemonic) -> Self {
        let operand = match refused {
            CallRefused::Bind(error) => error.operand(),
            CallRefused::Control(_) | CallRefused::Busy | CallRefused::NoAnswer => None,
        };
        Self {
            member: operand.and_then(|operand| member(mnemonic, operand)),
            ..Self::new(refused.to_string())
        }
    }

    pub(super) fn syntax(error: &SyntaxError) -> Self {
        Self {
            line: u32::try_from(error.line).ok(),
            column: u32::try_from(error.column).ok(),
            ..Self::new(error.problem.to_string())
        }
    }

    pub(super) fn at(self, line: usize) -> Self {
        Self {
            line: u32::try_from(line).ok(),
            ..self
        }
    }
}

fn member(mnemonic: Mnemonic, operand: OperandIndex) -> Option<Box<str>> {
    let operands = mnemonic.instruction().operands;
    operands
        .get(usize::from(operand.0))
        .map(|operand| operand.member().into())
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
pub(super) fn reply(id: &Value, answer: Result<impl Into<Answer>, Refusal>) -> String {
    match answer.map(Into::into) {
        Ok(Answer::Value(ok)) => json!({"id": id, "ok": ok}).to_string(),
        Ok(Answer::Text(ok)) => format!("{{\"id\":{id},\"ok\":{ok}}}"),
        Err(error) => json!({"id": id, "error": error}).to_string(),
    }
}

/// What a request is answered.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Answer {
    /// A short answer.
    Value(Value),
    /// A long one as JSON, which a thread beside has written.
    Text(String),
}

impl From<Value> for Answer {
    fn from(value: Value) -> Self {
        Answer::Value(value)
    }
}
