//! The part of a server that its sessions share: randomness, limits, counters and the identity.
//!
//! Not here: their storage; the server implements [`Host`].

use std::net::SocketAddrV4;

use crate::cip::CipStatus;
use crate::connection::{ConnectionKey, Count, ForwardOpen, ForwardOpenReply};
use crate::cpf::ConnectionId;
use crate::epath::Segment;
use crate::identity::Identity;
use crate::status::connection as extended;

/// The part of a server that its sessions share.
pub trait Host {
    /// An unpredictable number, for session handles and connection ids. Zero is asked again; so is one that this session
    /// uses. Values should not repeat among live sessions. `None` when the source of randomness fails: the session
    /// then refuses a request that needs a number, so that no number can be guessed.
    fn random(&mut self) -> Option<u32>;
    /// Whether one more class 3 connection may open; counts it if so.
    fn acquire_connection(&mut self) -> bool;
    /// `count` connections have gone.
    fn release_connections(&mut self, count: usize);
    /// A class 3 connection is open; its key has the vendor and the serial number of the originator.
    fn connection_opened(&mut self, _id: ConnectionId, _key: ConnectionKey) {}
    /// A class 3 connection is no more. When the session ends, its connections end with it, without a call for each.
    fn connection_ended(&mut self, _id: ConnectionId, _how: ConnectionEnd) {}
    /// Counts for the Connection Manager's attributes.
    fn count(&mut self, count: Count);
    /// The identity of the device at present.
    fn identity(&self) -> &Identity;
    /// Opens an I/O connection, see [`crate::io::IoConnections::open`].
    ///
    /// # Errors
    /// The status of the refusal; without I/O 0x01/0x011C.
    fn open_io(&mut self, open: &IoOpen<'_>) -> Result<IoOpened, CipStatus> {
        Err(without_io(open))
    }
    /// Closes an I/O connection. `false`: this originator has none of that name.
    fn close_io(&mut self, _key: ConnectionKey) -> bool {
        false
    }
}

/// How a device without I/O refuses a Forward Open of class 0 or 1.
pub(super) fn without_io(open: &IoOpen<'_>) -> CipStatus {
    CipStatus::connection(if open.open.is_null() {
        extended::NULL_OPEN_UNSUPPORTED
    } else {
        extended::CLASS_UNSUPPORTED
    })
}

/// How a class 3 connection ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConnectionEnd {
    /// By a Forward Close.
    Closed,
    /// Nothing was heard for too long.
    TimedOut,
}

/// A Forward Open of transport class 0 or 1, or a null one that is for no class 3 connection of the session. Its route
/// and electronic key are in order.
#[derive(Clone, Copy, Debug)]
pub struct IoOpen<'a> {
    /// The request.
    pub open: &'a ForwardOpen,
    /// Its path without ports, key and network segments.
    pub application: &'a [Segment],
    /// The UDP port that the originator listens on, when it says so (item 0x8001).
    pub port: Option<u16>,
}

/// An I/O connection that is open; it begins to produce when [`super::Event::IoReady`] has come.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct IoOpened {
    /// The reply to the originator.
    pub reply: ForwardOpenReply,
    /// Where the target listens (item 0x8000); the address 0.0.0.0 is that of the TCP connection.
    pub listens: SocketAddrV4,
    /// The group in which the originator is sent its inputs (item 0x8001), if it is one.
    pub group: Option<SocketAddrV4>,
}

impl IoOpened {
    /// Its name for the host.
    pub fn id(&self) -> ConnectionId {
        self.reply.o_to_t_id
    }
}

/// A number that is not zero and that `free` accepts; a host that always draws the same gets it counted up. `None` when
/// the host cannot draw.
pub(super) fn nonzero(host: &mut dyn Host, free: impl Fn(u32) -> bool) -> Option<u32> {
    let mut number = host.random()?;
    while number == 0 || !free(number) {
        number = number.wrapping_add(1).wrapping_add(host.random()? & 0xFFFF);
    }
    Some(number)
}
