//! One I/O connection: its watchdog, and the data from its originator.
//!
//! Not here: the rules for opening connections, and the data to the originator ([`super::production`]).

use bytes::Bytes;
use std::net::IpAddr;
use std::time::Duration;

use super::application::{Application, OpenRequest, RUN_IDLE, SEQUENCE_COUNT};
use super::datagram::Datagram;
use crate::connection::{ConnectionKey, ForwardOpen, ForwardOpenReply};
use crate::cpf::ConnectionId;

/// The longest requested packet interval, microseconds: an originator sends its first datagram within one.
pub(super) const MAX_INTERVAL: u32 = 10_000_000;
/// The longest watchdog, requested packet interval times multiplier: for so long an originator that has ended without a Forward
/// Close can hold its place.
pub(super) const MAX_TIMEOUT: Duration = Duration::from_secs(60);
/// The time that an originator has for its first datagram, with any watchdog: a Forward Open whose originator never sends
/// holds its place no longer.
const FIRST_DATAGRAM: Duration = Duration::from_secs(10);

/// The owner's mode in its last datagram.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Mode {
    /// Nothing yet.
    Silent,
    /// Its outputs are not to be applied.
    Idle,
    /// Its outputs are applied.
    Run,
}

/// The content of a datagram on a connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Arrival<'a> {
    /// Older than one that came before, or too short: it does not count.
    Dropped,
    /// A sign of life.
    Heartbeat,
    /// The owner is in run; new outputs.
    Outputs(&'a [u8]),
    /// The owner has gone from run to idle.
    Idle,
}

/// A class 0 or 1 connection.
#[derive(Debug)]
pub(super) struct IoConnection {
    pub(super) key: ConnectionKey,
    pub(super) request: OpenRequest,
    /// The originator's address; only datagrams from there count.
    pub(super) from: IpAddr,
    /// The originator's port is taken from its first datagram.
    learns_port: bool,
    /// The number of its production.
    pub(super) production: u64,
    t_to_o_id: ConnectionId,
    o_to_t_api: u32,
    t_to_o_api: u32,
    timeout: Duration,
    /// When the watchdog expires.
    pub(super) deadline: Duration,
    /// 32-bit sequence of the last datagram that counted.
    received: Option<u32>,
    /// 16-bit count of the last data that was new.
    new_data: Option<u16>,
    pub(super) mode: Mode,
}

impl IoConnection {
    /// As the originator asks for; its multiplier code is at most 7 and its intervals are between 1 and [`MAX_INTERVAL`]. It consumes `production`,
    /// whose datagrams have `t_to_o_id`.
    pub(super) fn new(
        open: &ForwardOpen,
        request: OpenRequest,
        from: IpAddr,
        learns_port: bool,
        (production, t_to_o_id): (u64, ConnectionId),
        now: Duration,
    ) -> Self {
        let timeout = timeout(open);
        Self {
            key: open.key,
            request,
            from,
            learns_port,
            production,
            t_to_o_id,
            o_to_t_api: open.o_to_t_rpi,
            t_to_o_api: open.t_to_o_rpi,
            timeout,
            deadline: now + FIRST_DATAGRAM,
            received: None,
            new_data: None,
            mode: Mode::Silent,
        }
    }

    /// The reply to its originator.
    pub(super) fn reply(&self, id: ConnectionId) -> ForwardOpenReply {
        ForwardOpenReply {
            o_to_t_id: id,
            t_to_o_id: self.t_to_o_id,
            key: self.key,
            o_to_t_api: self.o_to_t_api,
            t_to_o_api: self.t_to_o_api,
            application: Bytes::new(),
        }
    }

    /// Takes a datagram that came from the originator's address.
    pub(super) fn receive<'a>(&mut self, datagram: &Datagram<'a>, outputs: usize, now: Duration) -> Arrival<'a> {
        if let Some(last) = self.received
            && datagram.sequence.wrapping_sub(last).cast_signed() <= 0
        {
            return Arrival::Dropped;
        }
        let Some(content) = Content::of(datagram.data, self.request) else {
            return Arrival::Dropped;
        };
        let owner = self.request.application == Application::ExclusiveOwner;
        let outputs = match content.data.get(..outputs) {
            Some(outputs) if owner => Some(outputs),
            None if owner => return Arrival::Dropped,
            _ => None,
        };
        self.received = Some(datagram.sequence);
        self.deadline = now + self.timeout;
        let Some(outputs) = outputs else {
            return Arrival::Heartbeat;
        };
        let was = self.mode;
        self.mode = if content.run { Mode::Run } else { Mode::Idle };
        let is_new = content.count.is_none() || content.count != self.new_data || was != self.mode;
        self.new_data = content.count;
        match (self.mode, was) {
            (Mode::Run, _) if is_new => Arrival::Outputs(outputs),
            (Mode::Idle, Mode::Run) => Arrival::Idle,
            _ => Arrival::Heartbeat,
        }
    }

    /// Whether its originator's port has to be taken from a datagram that came; once.
    pub(super) fn learns_port(&mut self) -> bool {
        self.received.is_some() && std::mem::take(&mut self.learns_port)
    }
}

/// The watchdog that a Forward Open asks for; its multiplier code is at most 7.
pub(super) fn timeout(open: &ForwardOpen) -> Duration {
    Duration::from_micros(u64::from(open.o_to_t_rpi) << (open.multiplier + 2))
}

/// Connected data taken apart.
struct Content<'a> {
    /// Of class 1.
    count: Option<u16>,
    /// Bit 0 of the header; without one the originator is always in run.
    run: bool,
    data: &'a [u8],
}

impl<'a> Content<'a> {
    /// `None`: too short.
    fn of(data: &'a [u8], request: OpenRequest) -> Option<Self> {
        let (count, data) = if request.class_1 {
            let (count, data) = data.split_first_chunk::<{ SEQUENCE_COUNT as usize }>()?;
            (Some(u16::from_le_bytes(*count)), data)
        } else {
            (None, data)
        };
        let (run, data) = match data.split_first_chunk::<{ RUN_IDLE as usize }>() {
            Some((header, data)) if request.header => (header[0] & 1 != 0, data),
            None if request.header => return None,
            _ => (true, data),
        };
        Some(Self { count, run, data })
    }
}
