//! Why something a client asked for has failed, and whose fault it is.
//!
//! Not the status of a reply that has come: that is in the reply.

use crate::cip::CipStatus;
use crate::cpf::CpfError;
use crate::encap::{Command, EncapStatus, FrameError};
use crate::epath::PathError;

/// Why something failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ClientError {
    /// The peer refused the frame.
    #[error("{command} refused: {status}")]
    Encapsulation {
        /// What was asked.
        command: Command,
        /// Why not.
        status: EncapStatus,
    },
    /// The peer misbehaves: its stream cannot be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
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
    /// We were called wrongly: no such connection is open.
    #[error("no such connection is open")]
    NotOpen,
    /// We were called wrongly: there is no session yet.
    #[error("no session is registered")]
    NotRegistered,
}
