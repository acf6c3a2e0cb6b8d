//! The order of replies: each request of a session has its place, and nothing overtakes (spec/ethernet-ip.md §8, §18).
//!
//! Not what a reply says. Budgets are in bytes of the router reply, head included.

use bytes::Bytes;
use std::collections::VecDeque;

use super::connections::Connections;
use super::{IoOpened, Transport};
use crate::cip::{CipStatus, Reply};
use crate::cpf::{ConnectionId, Item, Packet};
use crate::encap::{Frame, Header};

/// Names a request that waits for its answer; never repeats in a session.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct RequestId(u64);

/// Replies that have not left yet, oldest first.
#[derive(Debug, Default)]
pub(super) struct Replies {
    places: VecDeque<Place>,
    next_id: u64,
}

/// A place in the order.
#[derive(Debug)]
enum Place {
    /// The application works on it.
    Waiting {
        id: RequestId,
        service: u8,
        header: Header,
        way: Way,
    },
    /// Ready to leave; an I/O connection may wait for that.
    Ready(Frame, Option<ConnectionId>),
    /// Repeats the reply in front of it, which is not there yet.
    Repeat {
        header: Header,
        id: ConnectionId,
        sequence: u16,
    },
}

/// Where a reply goes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Way {
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

impl Way {
    pub(super) const fn budget(&self) -> usize {
        match self {
            Self::Unconnected { budget } | Self::Connected { budget, .. } => *budget,
        }
    }

    pub(super) const fn transport(&self) -> Transport {
        match self {
            Self::Unconnected { .. } => Transport::Unconnected,
            Self::Connected { id, .. } => Transport::Connected(*id),
        }
    }

    fn packet(&self, reply: Bytes, io: Option<&IoOpened>) -> Bytes {
        let mut packet = match self {
            Self::Unconnected { .. } => Packet::unconnected(reply),
            Self::Connected {
                t_to_o_id, sequence, ..
            } => Packet::connected(*t_to_o_id, *sequence, &reply),
        };
        if let Some(io) = io {
            packet.items.push(Item::SockaddrOToT(io.listens));
            packet.items.extend(io.group.map(Item::SockaddrTToO));
        }
        packet.to_bytes()
    }
}

impl Replies {
    /// How many have not left.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether all have left.
    pub(super) fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Forgets all that have not left.
    pub(super) fn clear(&mut self) {
        self.places.clear();
    }

    /// A place for a reply that is still to be made.
    pub(super) fn wait(&mut self, service: u8, header: Header, way: Way) -> RequestId {
        let id = RequestId(self.next_id);
        self.next_id += 1;
        self.places.push_back(Place::Waiting {
            id,
            service,
            header,
            way,
        });
        id
    }

    /// A reply that is there.
    pub(super) fn push(&mut self, frame: Frame) {
        self.places.push_back(Place::Ready(frame, None));
    }

    /// A place for the reply of a request that still waits in front.
    pub(super) fn repeat(&mut self, header: Header, id: ConnectionId, sequence: u16) {
        self.places.push_back(Place::Repeat { header, id, sequence });
    }

    /// Puts a reply in its place; one beyond the budget becomes 0x11. Gives the packet and its way; `None` if nothing
    /// waits by this name.
    /// `io` is the I/O connection that it confirms.
    pub(super) fn answer(&mut self, id: RequestId, reply: &Reply, io: Option<&IoOpened>) -> Option<(Way, Bytes)> {
        self.places.iter_mut().find_map(|place| match *place {
            Place::Waiting {
                id: waiting,
                service,
                header,
                way,
            } if waiting == id => {
                let bytes = if reply.len() <= way.budget() {
                    reply.to_bytes()
                } else {
                    Reply::error(service, CipStatus::REPLY_TOO_LARGE).to_bytes()
                };
                let packet = way.packet(bytes, io);
                *place = Place::Ready(Frame::reply(&header, packet.clone()), io.map(IoOpened::id));
                Some((way, packet))
            }
            _ => None,
        })
    }

    /// The next reply that may leave, and the I/O connection that waits for that. A repetition leaves with what
    /// `connections` have kept.
    pub(super) fn pop(&mut self, connections: &Connections) -> Option<(Frame, Option<ConnectionId>)> {
        loop {
            let frame = match self.places.front()? {
                Place::Waiting { .. } => return None,
                Place::Ready(frame, io) => Some((frame.clone(), *io)),
                Place::Repeat { header, id, sequence } => connections
                    .stored(*id, *sequence)
                    .map(|packet| (Frame::reply(header, packet), None)),
            };
            self.places.pop_front();
            if frame.is_some() {
                return frame;
            }
        }
    }
}
