//! The requests that are answered over UDP 44818: ListIdentity, ListServices, ListInterfaces (spec/ethernet-ip.md §1, §2).
//!
//! No socket and no waiting: the delay a broadcast asks for comes out as a bound, the caller draws the time.

use bytes::{BufMut, Bytes, BytesMut};
use std::net::SocketAddrV4;
use std::time::Duration;

use crate::cpf::{Item, encode_items};
use crate::encap::{Command, EncapFrame, EncapStatus, FrameDecoder, Service};
use crate::identity::Identity;

/// The longest delay that a peer can ask for.
pub const MAX_DELAY: Duration = Duration::from_millis(500);
/// The delay for a request that names none.
const DEFAULT_DELAY: Duration = MAX_DELAY;

/// An answer to a datagram.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Answer {
    /// The reply.
    pub frame: EncapFrame,
    /// When the request was a broadcast, wait a random time up to this before sending.
    pub max_delay: Duration,
}

/// Answers a datagram that arrived on `local` (never 0.0.0.0). `None`: silence, also for everything that UDP does not
/// offer and for every malformed datagram.
///
/// A request has no data (CIP Vol. 2, 2-4.2 to 2-4.5); a reply always has some. A datagram with data is never answered, so two
/// devices cannot answer each other's replies for ever, even when the sender's address is forged.
pub fn answer(datagram: &[u8], identity: &Identity, capability: u16, local: SocketAddrV4) -> Option<Answer> {
    let request = FrameDecoder::default().decode_datagram(datagram)?;
    if request.header.status != EncapStatus::SUCCESS || request.header.options != 0 || !request.data.is_empty() {
        return None;
    }
    let data = list_reply(request.header.command, identity, capability, local)?;
    let max_delay = match (request.header.command, request.header.context) {
        (Command::LIST_IDENTITY, [0, 0, ..]) => DEFAULT_DELAY,
        (Command::LIST_IDENTITY, [low, high, ..]) => {
            Duration::from_millis(u16::from_le_bytes([low, high]).into()).min(MAX_DELAY)
        }
        _ => Duration::ZERO,
    };
    Some(Answer {
        frame: EncapFrame::reply(&request.header, data),
        max_delay,
    })
}

/// The data of a List reply, over TCP or UDP; `None` for every other command.
pub fn list_reply(command: Command, identity: &Identity, capability: u16, local: SocketAddrV4) -> Option<Bytes> {
    match command {
        Command::LIST_IDENTITY => Some(identity.list_identity(local)),
        Command::LIST_SERVICES => {
            let mut service = BytesMut::with_capacity(20);
            Service::communications(capability).encode(&mut service);
            let mut out = BytesMut::with_capacity(26);
            encode_items(&[Item::Services(service.freeze())], &mut out);
            Some(out.freeze())
        }
        Command::LIST_INTERFACES => {
            let mut out = BytesMut::with_capacity(2);
            out.put_u16_le(0);
            Some(out.freeze())
        }
        _ => None,
    }
}
