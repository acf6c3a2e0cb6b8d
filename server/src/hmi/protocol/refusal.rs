//! The reason for which the server refuses a request of a page, with the known details of the cause.

use arcline_instruction_set::{Explanation, Mnemonic, MotionError, OperandIndex, describe, explain};
use arcline_structured_text::SyntaxError;
use serde::Serialize;

use crate::plant::{CallRefused, Refused};

/// The reason for which the server refuses a request, or the error of an instruction.
#[derive(Serialize, Clone, PartialEq, Debug, Default)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Refusal {
    /// The reason, as a sentence.
    pub(crate) text: Box<str>,
    /// ERR of a motion instruction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) err: Option<i16>,
    /// EXERR of a motion instruction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) exerr: Option<i8>,
    /// The usual cause of ERR, as `arcline explain` prints it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) cause: Option<&'static str>,
    /// The operand, axis or detail that EXERR identifies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) concerns: Option<Box<str>>,
    /// The remedy for ERR.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) remedy: Option<&'static str>,
    /// Line of the text, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) line: Option<u32>,
    /// Column of the text, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) column: Option<u32>,
    /// The member of the operand at fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) member: Option<Box<str>>,
    /// The control that was missing.
    #[serde(flatten)]
    pub(crate) missing: Option<Box<MissingControl>>,
}

/// Control that a request needs and its viewer does not have.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct MissingControl {
    /// The object whose control the request needs.
    control: Box<str>,
    /// The viewer that has control of that object.
    #[serde(skip_serializing_if = "Option::is_none")]
    holder: Option<Box<str>>,
}

impl Refusal {
    /// A refusal for missing control of an object; `holder` is the viewer that has it.
    pub(crate) fn control(object: &str, holder: Option<&str>) -> Self {
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

    pub(crate) fn new(text: impl Into<Box<str>>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }

    /// A motion error, with the text of `arcline explain`.
    pub(crate) fn motion(err: i16, exerr: i8, mnemonic: Mnemonic) -> Self {
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
    pub(crate) fn call(refused: &CallRefused, mnemonic: Mnemonic) -> Self {
        let operand = match refused {
            CallRefused::Bind(error) => error.operand(),
            CallRefused::Control(_) | CallRefused::NotOfSeries { .. } | CallRefused::Busy | CallRefused::NoAnswer => {
                None
            }
        };
        Self {
            member: operand.and_then(|operand| member(mnemonic, operand)),
            ..Self::new(refused.to_string())
        }
    }

    pub(crate) fn syntax(error: &SyntaxError) -> Self {
        Self {
            line: u32::try_from(error.line).ok(),
            column: u32::try_from(error.column).ok(),
            ..Self::new(error.problem.to_string())
        }
    }

    pub(crate) fn at(self, line: usize) -> Self {
        Self {
            line: u32::try_from(line).ok(),
            ..self
        }
    }
}

impl From<Refused> for Refusal {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::NoControl { object, holder } => Self::control(&object, holder.as_deref()),
            Refused::Role { .. }
            | Refused::MovedByAnother { .. }
            | Refused::Write(_)
            | Refused::Table(_)
            | Refused::Call(_)
            | Refused::NoProgram
            | Refused::Force(_)
            | Refused::NotStepped
            | Refused::NotPersisted(_) => Self::new(refused.to_string()),
        }
    }
}

fn member(mnemonic: Mnemonic, operand: OperandIndex) -> Option<Box<str>> {
    let operands = mnemonic.instruction().operands;
    operands
        .get(usize::from(operand.0))
        .map(|operand| operand.member().into())
}
