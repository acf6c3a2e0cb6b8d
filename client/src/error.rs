//! Errors, by their origin: the network, the server, the machine, or the caller.

use std::io;
use std::time::Duration;

use arcline_proto::client as session;

use arcline_instruction_set::{BindError, Flag, Mnemonic, MotionControl, Object, UnknownMnemonic, describe};
use arcline_proto::cip::CipStatus;
use arcline_tag::{Elementary, PathError, nearest};

use crate::Ended;

/// The reason for which a request gave no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClientError {
    /// The name cannot be resolved, or no server listens there.
    #[error("no connection to {address}: {source}")]
    Connect {
        /// The address of the request.
        address: String,
        /// The error of the system.
        source: io::Error,
    },
    /// The files of TLS are of no use.
    #[error("{file}: {reason}")]
    Credentials {
        /// The file.
        file: String,
        /// The reason.
        reason: String,
    },
    /// The connection broke, the server closed it, or this client has been closed.
    #[error("the connection is closed")]
    Closed,
    /// No answer in time.
    #[error("no answer within {} s", after.as_secs_f64())]
    Timeout {
        /// The time allowed.
        after: Duration,
    },
    /// The encapsulation layer refused, or the server sent a malformed frame.
    #[error("the session failed: {0}")]
    Session(session::ClientError),
    /// The server sent a message that does not answer the request.
    #[error("unexpected answer of the server: {what}")]
    Malformed {
        /// The defect.
        what: &'static str,
    },
    /// The server claims more than this client is willing to hold.
    #[error("{what} is {claimed}, at most {limit} are accepted")]
    TooLarge {
        /// The quantity.
        what: &'static str,
        /// The announced length.
        claimed: usize,
        /// The greatest accepted length.
        limit: usize,
    },
    /// The request was refused.
    #[error("{what}: {}", crate::refusal::in_words(*status))]
    Refused {
        /// The object of the request.
        what: String,
        /// General and additional status.
        status: CipStatus,
    },
    /// A motion instruction erred.
    #[error("{}", describe(*err, *exerr, *mnemonic))]
    Motion {
        /// The instruction, if it is known.
        mnemonic: Option<Mnemonic>,
        /// ERR.
        err: i16,
        /// EXERR.
        exerr: i8,
    },
    /// An operand that the instruction needs was left out: it counts as 0, which is out of its range.
    #[error("{}: {operand} was not given", describe(*err, *exerr, Some(*mnemonic)))]
    MissingOperand {
        /// The instruction.
        mnemonic: Mnemonic,
        /// Name of the operand.
        operand: &'static str,
        /// ERR.
        err: i16,
        /// EXERR.
        exerr: i8,
    },
    /// An object of another kind than the instruction acts on.
    #[error("{name} is {}, {mnemonic} acts on {}", .is.with_article(), .mnemonic.instruction().object.with_article())]
    WrongObject {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The object.
        name: String,
        /// Its kind.
        is: Object,
    },
    /// The motion ended without the awaited bit: by a stop, another instruction or a fault.
    #[error("the motion ended without {flag}: {}", reason(ended.as_deref()))]
    Ended {
        /// The awaited bit.
        flag: Flag,
        /// The status it ended with.
        control: MotionControl,
        /// The cause, where the server has it.
        ended: Option<Box<Ended>>,
    },
    /// The server has dropped the record of an instruction that is waited for.
    #[error("the server no longer knows {mnemonic} {target}; the motion may go on")]
    Forgotten {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The motion object it acts on.
        target: String,
    },
    /// The awaited bit was not set before the deadline.
    #[error("{flag} did not come within {} s", after.as_secs_f64())]
    Deadline {
        /// The awaited bit.
        flag: Flag,
        /// The time allowed.
        after: Duration,
    },
    /// No tag of that name.
    #[error("there is no tag {name:?}{}", suggest(.suggestion))]
    UnknownTag {
        /// The name.
        name: String,
        /// The nearest name there is.
        suggestion: Option<String>,
    },
    /// No motion object of that name.
    #[error("there is no {object} {name:?}{}", suggest(.suggestion))]
    UnknownObject {
        /// The expected kind.
        object: Object,
        /// The name.
        name: String,
        /// The nearest name there is.
        suggestion: Option<String>,
    },
    /// A tag path that cannot be read, or leads nowhere.
    #[error("{path}: {source}")]
    Path {
        /// The path.
        path: String,
        /// The error of the path.
        source: PathError,
    },
    /// A number that the attribute cannot be.
    #[error("{name} cannot be {value}, expected {range}")]
    AttributeValue {
        /// The attribute.
        name: &'static str,
        /// The number.
        value: f64,
        /// What it can be, as a phrase.
        range: &'static str,
    },
    /// A value that the tag cannot hold.
    #[error("{path} is {expected}, {given} does not fit")]
    Value {
        /// The tag.
        path: String,
        /// Its type.
        expected: String,
        /// The value, shortened.
        given: String,
    },
    /// A tag that an expression cannot read.
    #[error("{path} is {type_name}; an expression reads a number or a BOOL")]
    NoNumber {
        /// The tag.
        path: String,
        /// Its type.
        type_name: String,
    },
    /// An operand that the instruction cannot take.
    #[error(transparent)]
    Operand(#[from] BindError),
    /// An operand name that the instruction does not have.
    #[error("{mnemonic} has no operand {name:?}{}", suggest(.suggestion))]
    UnknownOperand {
        /// The instruction.
        mnemonic: Mnemonic,
        /// The name.
        name: String,
        /// The nearest operand.
        suggestion: Option<String>,
    },
    /// A name that is no instruction.
    #[error(transparent)]
    Mnemonic(#[from] UnknownMnemonic),
}

impl ClientError {
    /// Whether the connection to the server is lost, so that further requests fail too.
    pub fn is_connection(&self) -> bool {
        matches!(
            self,
            Self::Connect { .. } | Self::Closed | Self::Timeout { .. } | Self::Session(_) | Self::Malformed { .. }
        )
    }

    /// ERR and EXERR, when a motion instruction erred.
    pub fn motion(&self) -> Option<(i16, i8)> {
        match self {
            Self::Motion { err, exerr, .. } | Self::MissingOperand { err, exerr, .. } => Some((*err, *exerr)),
            _ => None,
        }
    }

    /// The instruction of [`ClientError::motion`], where it is known.
    pub fn instruction(&self) -> Option<Mnemonic> {
        match self {
            Self::Motion { mnemonic, .. } => *mnemonic,
            Self::MissingOperand { mnemonic, .. } => Some(*mnemonic),
            _ => None,
        }
    }

    /// There is no tag of a name; `known` are those there are.
    pub fn unknown_tag<S: AsRef<str>>(name: &str, known: impl IntoIterator<Item = S>) -> Self {
        Self::UnknownTag {
            name: name.to_owned(),
            suggestion: nearest(name, known),
        }
    }

    /// There is no object of a kind and name; `known` are those there are.
    pub fn unknown_object<S: AsRef<str>>(object: Object, name: &str, known: impl IntoIterator<Item = S>) -> Self {
        Self::UnknownObject {
            object,
            name: name.to_owned(),
            suggestion: nearest(name, known),
        }
    }

    pub(crate) fn path(path: &str, source: PathError) -> Self {
        Self::Path {
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn refused(what: impl Into<String>, status: CipStatus) -> Self {
        Self::Refused {
            what: what.into(),
            status,
        }
    }

    pub(crate) fn value(path: &str, expected: Elementary, given: impl std::fmt::Display) -> Self {
        Self::Value {
            path: path.to_owned(),
            expected: expected.name().to_owned(),
            given: given.to_string(),
        }
    }
}

impl From<session::ClientError> for ClientError {
    fn from(error: session::ClientError) -> Self {
        match error {
            session::ClientError::Refused(status) => Self::refused("the connection", status),
            session::ClientError::Lost | session::ClientError::NotOpen | session::ClientError::NotRegistered => {
                Self::Closed
            }
            error => Self::Session(error),
        }
    }
}

fn reason(ended: Option<&Ended>) -> String {
    ended.map_or_else(
        || "it was stopped, superseded or faulted".to_owned(),
        ToString::to_string,
    )
}

/// `, did you mean "CS1"?`
fn suggest(suggestion: &Option<String>) -> String {
    suggestion
        .as_ref()
        .map(|name| format!(", did you mean {name:?}?"))
        .unwrap_or_default()
}
