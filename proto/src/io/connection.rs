//! One I/O connection: its watchdog, its sequence numbers both ways, and when it produces next.
//!
//! Not which connections there may be.

use bytes::{BufMut, Bytes, BytesMut};
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use super::application::{Application, RUN_IDLE, SEQUENCE_COUNT, Wanted};
use super::datagram::Datagram;
use crate::connection::{ConnectionKey, ForwardOpen, ForwardOpenReply};
use crate::cpf::ConnectionId;

/// The longest time to the first datagram of a connection is at least this.
const FIRST_DATAGRAM: Duration = Duration::from_secs(10);

/// What the owner last said.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Mode {
    /// Nothing yet.
    Silent,
    /// Its outputs are not to be applied.
    Idle,
    /// Its outputs are applied.
    Run,
}

/// What a datagram on a connection brought.
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
    pub(super) wanted: Wanted,
    /// The originator's address; only datagrams from there count.
    pub(super) from: IpAddr,
    /// Where inputs go.
    to: SocketAddr,
    /// The originator's port is taken from its first datagram.
    learns_port: bool,
    t_to_o_id: ConnectionId,
    o_to_t_api: u32,
    t_to_o_api: u32,
    timeout: Duration,
    /// When the watchdog expires.
    pub(super) deadline: Duration,
    /// When the next datagram leaves; `None` before the Forward Open's reply has left.
    pub(super) next: Option<Duration>,
    /// 32-bit sequence of the last datagram that counted.
    received: Option<u32>,
    /// 16-bit count of the last data that was new.
    new_data: Option<u16>,
    sent: u32,
    count: u16,
    pub(super) mode: Mode,
}

impl IoConnection {
    /// As the originator asks for; its multiplier code is at most 7 and its intervals are not 0.
    pub(super) fn new(
        open: &ForwardOpen,
        wanted: Wanted,
        from: IpAddr,
        port: u16,
        learns_port: bool,
        now: Duration,
    ) -> Self {
        let timeout = Duration::from_micros(u64::from(open.o_to_t_rpi) << (open.multiplier + 2));
        Self {
            key: open.key,
            wanted,
            from,
            to: SocketAddr::new(from, port),
            learns_port,
            t_to_o_id: open.t_to_o_id,
            o_to_t_api: open.o_to_t_rpi,
            t_to_o_api: open.t_to_o_rpi,
            timeout,
            deadline: now + timeout.max(FIRST_DATAGRAM),
            next: None,
            received: None,
            new_data: None,
            sent: 0,
            count: 0,
            mode: Mode::Silent,
        }
    }

    /// What its originator is told.
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

    /// Takes a datagram that came from `from`; the address, not the port, has been looked at.
    pub(super) fn receive<'a>(
        &mut self,
        datagram: &Datagram<'a>,
        outputs: usize,
        from: SocketAddr,
        now: Duration,
    ) -> Arrival<'a> {
        if let Some(last) = self.received
            && datagram.sequence.wrapping_sub(last).cast_signed() <= 0
        {
            return Arrival::Dropped;
        }
        let Some(content) = Content::of(datagram.data, self.wanted) else {
            return Arrival::Dropped;
        };
        let owner = self.wanted.application == Application::ExclusiveOwner;
        let outputs = match content.data.get(..outputs) {
            Some(outputs) if owner => Some(outputs),
            None if owner => return Arrival::Dropped,
            _ => None,
        };
        self.received = Some(datagram.sequence);
        self.deadline = now + self.timeout;
        if self.learns_port {
            self.learns_port = false;
            self.to.set_port(from.port());
        }
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

    /// Appends the next datagram with `input` and says where it goes, if it is due. The schedule is absolute: a late
    /// datagram does not move the next one, and those that were missed altogether are left out.
    pub(super) fn produce(&mut self, now: Duration, input: &[u8], out: &mut BytesMut) -> Option<SocketAddr> {
        let due = self.next.filter(|due| *due <= now)?;
        let interval = Duration::from_micros(self.t_to_o_api.into());
        let missed = (now - due).as_nanos() / interval.as_nanos().max(1);
        let missed = u32::try_from(missed).unwrap_or(u32::MAX);
        self.next = Some(due + interval * missed.saturating_add(1));
        self.sent = self.sent.wrapping_add(1);
        let count = if self.wanted.class_1 { SEQUENCE_COUNT } else { 0 };
        let length = u16::try_from(input.len()).unwrap_or(u16::MAX).saturating_add(count);
        Datagram::encode_head(self.t_to_o_id, self.sent, length, out);
        if self.wanted.class_1 {
            self.count = self.count.wrapping_add(1);
            out.put_u16_le(self.count);
        }
        out.put_slice(input);
        Some(self.to)
    }
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
    fn of(data: &'a [u8], wanted: Wanted) -> Option<Self> {
        let (count, data) = if wanted.class_1 {
            let (count, data) = data.split_first_chunk::<{ SEQUENCE_COUNT as usize }>()?;
            (Some(u16::from_le_bytes(*count)), data)
        } else {
            (None, data)
        };
        let (run, data) = match data.split_first_chunk::<{ RUN_IDLE as usize }>() {
            Some((header, data)) if wanted.header => (header[0] & 1 != 0, data),
            None if wanted.header => return None,
            _ => (true, data),
        };
        Some(Self { count, run, data })
    }
}
