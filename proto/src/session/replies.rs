//! The order of replies: they leave in the order of their requests (spec/ethernet-ip.md §8, §18).
//!
//! Not here: the content of replies. Budgets are in bytes of the router reply, head included.

use bytes::{BufMut, Bytes, BytesMut};
use std::collections::VecDeque;

use super::connections::Connections;
use super::{IoOpened, Transport};
use crate::cip::{CipStatus, Reply};
use crate::cpf::{ConnectionId, ITEM_HEAD, ItemWriter, PACKET_HEAD, SOCKADDR, item_type};
use crate::encap::{EncapFrame, Header, MAX_DATA};

/// Names a request that waits for its answer; never repeats in a session.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct RequestId(u64);

/// Replies that have not left yet, oldest first.
#[derive(Debug, Default)]
pub(super) struct Replies {
    pending: VecDeque<PendingReply>,
    next_id: u64,
}

/// A reply that has not left.
#[derive(Debug)]
enum PendingReply {
    /// The application works on it.
    Waiting {
        id: RequestId,
        service: u8,
        header: Header,
        route: ReplyRoute,
    },
    /// Ready to leave, a whole frame, and the I/O connection that produces from then on.
    Ready(Bytes, Option<ConnectionId>),
    /// Repeats the reply in front of it, which is not there yet.
    Repeat {
        header: Header,
        id: ConnectionId,
        sequence: u16,
    },
}

/// Where a reply goes.
#[derive(Clone, Copy, Debug)]
pub(super) enum ReplyRoute {
    Unconnected {
        budget: usize,
    },
    Connected {
        id: ConnectionId,
        t_to_o_id: ConnectionId,
        sequence: u16,
        budget: usize,
    },
}

impl ReplyRoute {
    /// Bytes of the longest reply; never more than a frame holds.
    pub(super) fn budget(&self) -> usize {
        match self {
            Self::Unconnected { budget } | Self::Connected { budget, .. } => (*budget).min(MOST),
        }
    }

    pub(super) const fn transport(&self) -> Transport {
        match self {
            Self::Unconnected { .. } => Transport::Unconnected,
            Self::Connected { id, .. } => Transport::Connected(*id),
        }
    }

    /// The reply to a frame with `header`, written once: header, packet and reply.
    fn frame(&self, header: &Header, reply: &Reply, io: Option<&IoOpened>) -> Bytes {
        let (address, sequence) = match self {
            Self::Unconnected { .. } => (ITEM_HEAD, None),
            Self::Connected {
                t_to_o_id, sequence, ..
            } => (ITEM_HEAD + 4, Some((*t_to_o_id, *sequence))),
        };
        let data = reply.len() + if sequence.is_some() { SEQUENCE } else { 0 };
        let group = io.and_then(|io| io.group);
        let sockaddrs = usize::from(io.is_some()) + usize::from(group.is_some());
        let length = PACKET_HEAD + address + ITEM_HEAD + data + sockaddrs * (ITEM_HEAD + SOCKADDR);
        // Within the budget, which is that of a connection or of an unconnected reply: 16 bits hold it.
        let short = |length: usize| u16::try_from(length).unwrap_or(u16::MAX);
        let mut out = BytesMut::with_capacity(Header::LEN + length);
        let header = Header {
            length: short(length),
            ..EncapFrame::reply(header, Bytes::new()).header
        };
        header.encode(&mut out);
        let mut items = ItemWriter::packet(short(2 + sockaddrs), &mut out);
        match sequence {
            None => {
                items.null_address();
                reply.encode(items.data(item_type::UNCONNECTED_DATA, short(data)));
            }
            Some((id, sequence)) => {
                items.connected_address(id);
                let out = items.data(item_type::CONNECTED_DATA, short(data));
                out.put_u16_le(sequence);
                reply.encode(out);
            }
        }
        if let Some(io) = io {
            items.sockaddr(item_type::SOCKADDR_O_TO_T, io.listens);
        }
        if let Some(group) = group {
            items.sockaddr(item_type::SOCKADDR_T_TO_O, group);
        }
        out.freeze()
    }
}

impl Replies {
    /// How many have not left.
    pub(super) fn len(&self) -> usize {
        self.pending.len()
    }

    /// Whether all have left.
    pub(super) fn is_empty(&self) -> bool {
        self.pending.is_empty()
    }

    /// Forgets all that have not left.
    pub(super) fn clear(&mut self) {
        self.pending.clear();
    }

    /// Adds a reply that is still to be made.
    pub(super) fn wait(&mut self, service: u8, header: Header, route: ReplyRoute) -> RequestId {
        let id = RequestId(self.next_id);
        self.next_id += 1;
        self.pending.push_back(PendingReply::Waiting {
            id,
            service,
            header,
            route,
        });
        id
    }

    /// Adds a finished reply.
    pub(super) fn push(&mut self, frame: EncapFrame) {
        self.pending.push_back(PendingReply::Ready(frame.to_bytes(), None));
    }

    /// Adds a repetition of the reply to a request that still waits in front.
    pub(super) fn repeat(&mut self, header: Header, id: ConnectionId, sequence: u16) {
        self.pending.push_back(PendingReply::Repeat { header, id, sequence });
    }

    /// Finishes the reply to a request; one beyond the budget becomes 0x11. Gives the packet and its route; `None` if no request of
    /// this id waits. `io` is the I/O connection that the reply confirms.
    pub(super) fn answer(
        &mut self,
        id: RequestId,
        reply: &Reply,
        io: Option<&IoOpened>,
    ) -> Option<(ReplyRoute, Bytes)> {
        self.pending.iter_mut().find_map(|pending| match *pending {
            PendingReply::Waiting {
                id: waiting,
                service,
                header,
                route,
            } if waiting == id => {
                let frame = if reply.len() <= route.budget() {
                    route.frame(&header, reply, io)
                } else {
                    route.frame(&header, &Reply::error(service, CipStatus::REPLY_TOO_LARGE), io)
                };
                let packet = frame.slice(Header::LEN..);
                *pending = PendingReply::Ready(frame, io.map(IoOpened::id));
                Some((route, packet))
            }
            _ => None,
        })
    }

    /// The next reply that may leave, and the I/O connection that waits for it. A repetition leaves with the reply that
    /// `connections` have stored.
    pub(super) fn pop(&mut self, connections: &Connections) -> Option<(Bytes, Option<ConnectionId>)> {
        loop {
            if let PendingReply::Waiting { .. } = self.pending.front()? {
                return None;
            }
            match self.pending.pop_front()? {
                PendingReply::Waiting { .. } => {}
                PendingReply::Ready(frame, io) => return Some((frame, io)),
                PendingReply::Repeat { header, id, sequence } => {
                    if let Some(packet) = connections.stored(id, sequence) {
                        return Some((EncapFrame::reply(&header, packet).to_bytes(), None));
                    }
                }
            }
        }
    }
}

/// Bytes of the sequence count of a connected message.
const SEQUENCE: usize = 2;
/// The longest reply that a frame holds with everything around it.
const MOST: usize = MAX_DATA - PACKET_HEAD - (ITEM_HEAD + 4) - ITEM_HEAD - SEQUENCE - 2 * (ITEM_HEAD + SOCKADDR);
