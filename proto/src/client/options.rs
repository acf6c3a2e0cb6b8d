//! How a class 3 connection is opened, and the way to its target.
//!
//! Not here: the connection. Intervals are in microseconds, sizes in bytes.

use crate::cip::class;
use crate::connection::{ConnectionKey, ForwardOpen, NetworkParameters, TRANSPORT_CLASS_3, TickTime};
use crate::cpf::ConnectionId;
use crate::epath::{Epath, PortSegment, Segment};

/// How a connection is opened.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct OpenOptions {
    /// Names the connection; unique among those of this originator.
    pub key: ConnectionKey,
    /// Where the target's messages are addressed to; chosen by us, not zero.
    pub t_to_o_id: ConnectionId,
    /// Connection size in both directions, bytes; beyond 511 it takes a Large Forward Open.
    pub size: u16,
    /// Requested interval, µs.
    pub rpi: u32,
    /// Timeout multiplier code, 0-7.
    pub multiplier: u8,
    /// The way to the Message Router.
    pub route: Epath,
}

impl OpenOptions {
    /// 4002 bytes through backplane slot 0, 2 s × 32.
    pub fn new(key: ConnectionKey, t_to_o_id: ConnectionId) -> Self {
        Self {
            key,
            t_to_o_id,
            size: 4002,
            rpi: 2_000_000,
            multiplier: 3,
            route: backplane(0),
        }
    }

    /// Whether the size takes a Large Forward Open.
    pub(super) const fn is_large(&self) -> bool {
        self.size > NetworkParameters::MAX_SMALL
    }

    /// The connection path: the route, then the Message Router.
    pub(super) fn path(&self) -> Epath {
        let mut path = self.route.clone();
        path.0.extend(Epath::object(class::MESSAGE_ROUTER, 1).0);
        path
    }

    /// The request to the target.
    pub(super) fn forward_open(&self) -> ForwardOpen {
        ForwardOpen {
            time: TickTime::DEFAULT,
            o_to_t_id: ConnectionId(0),
            t_to_o_id: self.t_to_o_id,
            key: self.key,
            multiplier: self.multiplier,
            o_to_t_rpi: self.rpi,
            o_to_t: NetworkParameters::explicit(self.size),
            t_to_o_rpi: self.rpi,
            t_to_o: NetworkParameters::explicit(self.size),
            transport: TRANSPORT_CLASS_3,
            path: self.path(),
        }
    }
}

/// The route through the backplane to `slot`: `01 ss`.
pub fn backplane(slot: u8) -> Epath {
    Epath(vec![Segment::Port(PortSegment::backplane(slot))])
}
