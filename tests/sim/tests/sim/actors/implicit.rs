//! Connections of implicit I/O: their datagrams in both directions, and their end by silence.

use std::net::SocketAddr;
use std::time::Duration;

use arcline_proto::connection::{ConnectionKey, ForwardOpen, ForwardOpenReply, NetworkParameters, TickTime};
use arcline_proto::cpf::ConnectionId;
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::io::{Datagram, IO_PORT};
use bytes::BytesMut;

use super::{Alive, Environment};
use crate::client::{Answer, Client};
use crate::datagrams::Mailbox;

/// Bytes of the assemblies of the machine: four coordinate systems and eight axes.
const INPUT_SIZE: u16 = 12 + 4 * 24 + 8 * 20;
const OUTPUT_SIZE: u16 = 4 + 4 * 4;
/// The connection points of the inputs and of the configuration (docs/IO.md).
const INPUT: u32 = 100;
const CONFIGURATION: u32 = 151;
/// Run, in the header of the outputs.
const RUN: u32 = 1;

/// The place of the connection id in a datagram: behind the count of its items, and the type and length of the first one.
const T_TO_O_ID: std::ops::Range<usize> = 6..10;

/// The kinds of connections.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// Has the outputs.
    Owner,
    /// Has the inputs.
    InputOnly,
    /// Has the inputs while another connection, that does not only listen, has them.
    ListenOnly,
}

impl Kind {
    /// Its connection point beside that of the inputs (docs/IO.md).
    fn point(self) -> u32 {
        match self {
            Kind::Owner => 150,
            Kind::InputOnly => 254,
            Kind::ListenOnly => 255,
        }
    }

    /// What a datagram to the server has behind its count.
    fn data(self) -> Vec<u8> {
        match self {
            Kind::Owner => {
                let mut data = RUN.to_le_bytes().to_vec();
                data.resize(4 + usize::from(OUTPUT_SIZE), 0);
                data
            }
            Kind::InputOnly | Kind::ListenOnly => Vec::new(),
        }
    }
}

/// A connection.
pub(super) struct Implicit {
    kind: Kind,
    id: ConnectionId,
    /// The id of the datagrams from the server.
    inputs: ConnectionId,
    mailbox: Mailbox,
    sequence: u32,
    /// Between two datagrams, ms.
    pub(super) interval: u64,
    /// Silence after which the connection ends, ms.
    timeout: u64,
    /// When the newest datagram arrives at the server, ms.
    heard: Option<u64>,
    /// When the server sent its newest datagram, ms.
    sent: u64,
    /// Its datagrams once arrived further apart than the time-out: the slow answers of its instructions were between them.
    paused: bool,
    _alive: Alive,
}

impl Implicit {
    /// Opens a connection. `None`: it was refused.
    pub(super) async fn open(
        env: &mut Environment,
        client: &mut Client,
        kind: Kind,
        key: ConnectionKey,
    ) -> Answer<Option<Implicit>> {
        let interval = *env.random.one_of(&[5, 10, 20]);
        let multiplier = *env.random.one_of(&[2, 3]);
        let open = forward_open(key, kind, interval, multiplier);
        let address = SocketAddr::new(env.ip().into(), IO_PORT);
        let random = arcline_tests::random::Random(env.random.bits());
        let mailbox = env.common.post.open(address, env.weather, random);
        let Some(opened) = client.open_io(&open, IO_PORT).await? else {
            return Ok(None);
        };
        let ForwardOpenReply {
            o_to_t_id,
            t_to_o_id,
            o_to_t_api,
            ..
        } = opened;
        Ok(Some(Implicit {
            kind,
            id: o_to_t_id,
            inputs: t_to_o_id,
            mailbox,
            // The 16 bits of the data and the 32 bits of the datagram are over soon.
            sequence: if env.common.near_end { u32::MAX - 20 } else { 0 },
            interval,
            timeout: u64::from(o_to_t_api) / 1000 * (4 << multiplier),
            heard: None,
            sent: 0,
            paused: false,
            _alive: env.alive(o_to_t_id.0),
        }))
    }

    /// Sends a datagram; an owner's has outputs that command nothing, in run.
    pub(super) fn produce(&mut self) {
        self.sequence = self.sequence.wrapping_add(1);
        let mut data = (self.sequence as u16).to_le_bytes().to_vec();
        data.extend(self.kind.data());
        let mut bytes = BytesMut::new();
        let datagram = Datagram {
            id: self.id,
            sequence: self.sequence,
            data: &data,
        };
        datagram.encode(&mut bytes);
        if let Some(arrives) = self.mailbox.send(&bytes) {
            self.paused |= self.heard.is_some_and(|heard| arrives > heard + self.timeout);
            self.heard = Some(arrives);
        }
    }

    /// Whether the server still sends inputs, and has received a datagram.
    pub(super) fn is_open(&self, now: u64) -> bool {
        self.heard.is_some() && now <= self.sent + 3 * self.interval
    }

    /// Takes the arrived datagrams, of which some may be those of an earlier connection that the server still holds.
    pub(super) fn consume(&mut self, env: &Environment) {
        while let Some((sent, bytes)) = self.mailbox.receive() {
            if bytes[T_TO_O_ID] == self.inputs.0.to_le_bytes() {
                self.sent = sent;
            }
            env.common.record.saw(env.name, &bytes[..12]);
        }
    }

    /// Sends and receives for a number of intervals.
    pub(super) async fn run(&mut self, env: &Environment, intervals: u64) {
        for _ in 0..intervals {
            self.produce();
            tokio::time::sleep(Duration::from_millis(self.interval)).await;
            self.consume(env);
        }
    }

    /// When the connection ends if nothing more is sent, ms; `None`: the server still waits for the first datagram.
    pub(super) fn ends(&self) -> Option<u64> {
        Some(self.heard? + self.timeout)
    }

    /// Sends nothing more. The server ends the connection after its time-out, and never before (L2): one that only listens also with the last that it
    /// listens to.
    pub(super) async fn fall_silent(&mut self, env: &Environment, lives: u64) {
        let (Some(heard), Some(ends)) = (self.heard, self.ends()) else {
            return;
        };
        while env.now() < ends + 3 * self.interval {
            tokio::time::sleep(Duration::from_millis(1)).await;
            self.consume(env);
        }
        // The connection may have ended with the server, or in a stall of it, or the datagrams of either were lost on the way.
        let disturbed_until = env.common.post.held_until().max(env.stalled_until());
        let is_disturbed = env.lives() != lives
            || disturbed_until + self.timeout >= heard
            || disturbed_until + 2 * self.interval >= self.sent;
        if is_disturbed || self.paused || self.sent == 0 {
            return;
        }
        env.sometimes(match self.kind {
            Kind::Owner => "a silent owner is judged",
            Kind::InputOnly => "a silent connection of inputs is judged",
            Kind::ListenOnly => "a silent listener is judged",
        });
        let first = match self.kind {
            Kind::ListenOnly => 0,
            Kind::Owner | Kind::InputOnly => ends.saturating_sub(self.interval + 2),
        };
        let last = ends + self.interval + 2;
        if !(first..=last).contains(&self.sent) {
            let why = format!(
                "its connection, heard last at {heard} with a time-out of {} ms, was last sent inputs at {}",
                self.timeout, self.sent
            );
            env.common.record.violated("L2", &why);
        }
    }
}

/// The Forward Open of a connection; the interval in ms.
fn forward_open(key: ConnectionKey, kind: Kind, interval: u64, multiplier: u8) -> ForwardOpen {
    let parameters = |size| NetworkParameters {
        variable: false,
        priority: 2,
        ..NetworkParameters::explicit(size)
    };
    ForwardOpen {
        time: TickTime::DEFAULT,
        o_to_t_id: ConnectionId(0),
        t_to_o_id: ConnectionId(u32::from(key.serial)),
        key,
        multiplier,
        o_to_t_rpi: interval as u32 * 1000,
        o_to_t: parameters(2 + kind.data().len() as u16),
        t_to_o_rpi: interval as u32 * 1000,
        t_to_o: parameters(INPUT_SIZE + 2),
        transport: 1,
        path: Epath(vec![
            Segment::Class(4),
            Segment::Instance(CONFIGURATION),
            Segment::ConnectionPoint(kind.point()),
            Segment::ConnectionPoint(INPUT),
        ]),
    }
}
