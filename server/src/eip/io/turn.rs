//! A turn of implicit I/O: it takes the datagrams that have arrived, ends the connections that are overdue, and sends the datagrams that are due.
//!
//! Datagrams come before watchdogs, so that a turn that is late itself ends no connection.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use arcline_state::planted::is_planted;
use bytes::BytesMut;
use tracing::debug;

use super::lateness::Lateness;
use super::{Io, apply_events, lock};
use crate::eip::device::Device;

/// The most datagrams that a turn receives before it does the due work.
const BATCH: usize = 128;
/// The longest datagram that a turn accepts.
const MAX_DATAGRAM: usize = 65_535;
/// The longest wait for the next turn, when nothing is due.
const IDLE: Duration = Duration::from_secs(3600);

/// Makes the turns.
#[derive(Debug)]
pub(crate) struct IoTurns {
    device: Arc<Device>,
    io: Arc<Io>,
    received: Vec<u8>,
    input: BytesMut,
    out: BytesMut,
    lateness: Lateness,
}

/// The amount that a turn has received.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Arrived {
    /// All datagrams that had arrived.
    All,
    /// A whole batch: there may be more.
    Batch,
}

impl IoTurns {
    /// The turns of a device's I/O.
    pub(crate) fn new(device: Arc<Device>, io: Arc<Io>) -> Self {
        Self {
            device,
            io,
            received: vec![0; MAX_DATAGRAM],
            input: BytesMut::new(),
            out: BytesMut::new(),
            lateness: Lateness::new(),
        }
    }

    /// A turn.
    pub(crate) fn turn(&mut self) -> Arrived {
        let arrived = self.take();
        self.send_due();
        arrived
    }

    /// The time until a connection is due.
    pub(crate) fn until_due(&self) -> Duration {
        let next = lock(&self.io.connections).poll_timeout();
        next.map_or(IDLE, |next| next.saturating_sub(self.io.now()))
    }

    /// Takes the datagrams that have arrived, up to a batch.
    fn take(&mut self) -> Arrived {
        for _ in 0..BATCH {
            let Ok((length, from)) = self.io.socket.receive(&mut self.received) else {
                // No more datagrams, or an error; an error that lasts shows again.
                return Arrived::All;
            };
            let now = self.io.now();
            let mut connections = lock(&self.io.connections);
            let datagram = self.received.get(..length).unwrap_or_default();
            if !connections.handle_datagram(datagram, from, now) {
                continue;
            }
            apply_events(&self.device, &mut connections);
        }
        Arrived::Batch
    }

    /// Ends the overdue connections and sends the due datagrams.
    fn send_due(&mut self) {
        let mut connections = lock(&self.io.connections);
        if !is_planted("watchdog of an I/O connection") {
            connections.handle_timeout(self.io.now());
        }
        apply_events(&self.device, &mut connections);
        let now = self.io.now();
        if let Some(floor) = self.lateness.changed_floor(now) {
            debug!(floor, "the shortest interval that is confirmed, µs");
            connections.set_min_interval(floor);
        }
        let Some(due) = connections.next_datagram().filter(|due| *due <= now) else {
            return;
        };
        self.lateness.sent(now - due);
        let ownership = connections.outputs();
        self.device
            .assembly_data()
            .refresh_input(&self.device.plant, ownership, &mut self.input);
        loop {
            self.out.clear();
            let Some(to) = connections.poll_transmit(now, &self.input, &mut self.out) else {
                return;
            };
            if let SocketAddr::V4(to) = to
                && to.ip().is_multicast()
            {
                self.io.route(*to.ip());
            }
            if let Err(error) = self.io.socket.send(&self.out, to) {
                debug!(%error, %to, "I/O send");
            }
        }
    }
}
