//! The outcome of a client's call: its reply, or the reason why there is none and whose fault that is.
//!
//! Not here: the status in a reply that has come.

use std::net::SocketAddrV4;

use super::{Call, Connected};
use crate::cip::{CipStatus, Reply};
use crate::cpf::CpfError;
use crate::encap::{Command, EncapFrameError, EncapStatus};
use crate::epath::PathError;
use crate::identity::Identity;

/// A call with its outcome.
#[derive(Clone, PartialEq, Debug)]
pub struct ClientEvent {
    /// The call.
    pub call: Call,
    /// Its outcome.
    pub outcome: Outcome,
}

/// The outcome of a call.
#[derive(Clone, PartialEq, Debug)]
pub enum Outcome {
    /// The session is registered.
    Registered,
    /// The identity of the target and the address at which it says it listens; `None` if the reply holds no identity.
    Identity(Option<(SocketAddrV4, Identity)>),
    /// A CIP reply with any status.
    Reply(Reply),
    /// A connection is open.
    Opened {
        /// For [`ClientSession::request_connected`](super::ClientSession::request_connected).
        connection: Connected,
        /// The longest router request and reply it carries, bytes.
        budget: usize,
    },
    /// A connection is closed.
    Closed,
    /// It failed.
    Failed(ClientError),
}

/// The reason for the failure of a call.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ClientError {
    /// The peer refused the frame.
    #[error("{command} refused: {status}")]
    Encapsulation {
        /// The request.
        command: Command,
        /// The reason.
        status: EncapStatus,
    },
    /// The peer misbehaves: its stream cannot be read.
    #[error(transparent)]
    EncapFrame(#[from] EncapFrameError),
    /// The peer misbehaves: its packet cannot be read.
    #[error(transparent)]
    Packet(#[from] CpfError),
    /// The peer misbehaves: its reply cannot be read.
    #[error("the reply to {0} cannot be read")]
    Malformed(Command),
    /// The connection was not opened or not closed.
    #[error("connection refused: {0}")]
    Refused(CipStatus),
    /// No reply in time.
    #[error("no reply in time")]
    TimedOut,
    /// The session was lost before the reply.
    #[error("the connection was lost before the reply")]
    Lost,
    /// We were called wrongly: the path cannot be encoded.
    #[error(transparent)]
    Path(#[from] PathError),
    /// No such connection is open; the message was not sent.
    #[error("no such connection is open")]
    NotOpen,
    /// We were called wrongly: there is no session yet.
    #[error("no session is registered")]
    NotRegistered,
}
