//! How a class 3 connection is opened, and the way to its target.
//!
//! Not the connection itself. Intervals are in microseconds, sizes in bytes.

use crate::connection::ConnectionKey;
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
}

/// The route through the backplane to `slot`: `01 ss`.
pub fn backplane(slot: u8) -> Epath {
    Epath(vec![Segment::Port(PortSegment::backplane(slot))])
}
