//! The class 3 connections of one session: their watchdogs, and the last reply of each for a repeated message
//! (spec/ethernet-ip.md §8).
//!
//! Not here: their opening and closing ([`super::connection_manager`]). Times are since the session's fixed moment.

use bytes::Bytes;
use std::collections::BTreeMap;
use std::time::Duration;

use super::{ConnectionEnd, Host};
use crate::connection::{ConnectionKey, Count, ForwardOpen, ForwardOpenReply};
use crate::cpf::ConnectionId;

/// The shortest interval that is confirmed, µs; it only feeds the watchdog.
const MIN_API: u32 = 10_000;
/// The longest time to the first message of a connection is at least this.
const FIRST_MESSAGE: Duration = Duration::from_secs(10);

/// Connections by their O→T id.
#[derive(Debug, Default)]
pub(super) struct Connections(BTreeMap<ConnectionId, Connection>);

/// A class 3 connection.
#[derive(Debug)]
pub(super) struct Connection {
    key: ConnectionKey,
    t_to_o_id: ConnectionId,
    t_to_o_size: u16,
    o_to_t_api: u32,
    t_to_o_api: u32,
    timeout: Duration,
    deadline: Duration,
    in_flight: usize,
    /// Sequence count of the last request, and its reply when it is there, with which a repetition is answered.
    last: Option<(u16, Option<Bytes>)>,
}

impl Connection {
    /// As the originator asks for; its multiplier code is at most 7.
    pub(super) fn new(open: &ForwardOpen, now: Duration) -> Self {
        let o_to_t_api = open.o_to_t_rpi.max(MIN_API);
        let timeout = Duration::from_micros(u64::from(o_to_t_api) << (open.multiplier + 2));
        Self {
            key: open.key,
            t_to_o_id: open.t_to_o_id,
            t_to_o_size: open.t_to_o.size,
            o_to_t_api,
            t_to_o_api: open.t_to_o_rpi.max(MIN_API),
            timeout,
            deadline: now + timeout.max(FIRST_MESSAGE),
            in_flight: 0,
            last: None,
        }
    }

    /// Starts the watchdog again.
    pub(super) fn heard(&mut self, now: Duration) {
        self.deadline = now + self.timeout;
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
}

/// The kind of a message on a connection, by its sequence count.
#[derive(Debug)]
pub(super) enum Arrival {
    /// A new request; its reply goes to `t_to_o_id` and has at most `budget` bytes.
    New { t_to_o_id: ConnectionId, budget: usize },
    /// The last request again, whose packet is this.
    Answered(Bytes),
    /// The last request again, which is still being worked on.
    InProgress,
}

impl Connections {
    /// How many are open.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether an id is in use.
    pub(super) fn contains(&self, id: ConnectionId) -> bool {
        self.0.contains_key(&id)
    }

    /// The connection that an originator names so.
    pub(super) fn find(&mut self, key: ConnectionKey) -> Option<(ConnectionId, &mut Connection)> {
        let (id, connection) = self.0.iter_mut().find(|(_, known)| known.key == key)?;
        Some((*id, connection))
    }

    /// Adds a connection under an id that is not in use.
    pub(super) fn insert(&mut self, id: ConnectionId, connection: Connection) {
        self.0.insert(id, connection);
    }

    /// Removes a connection; `false` if there is none.
    pub(super) fn remove(&mut self, id: ConnectionId) -> bool {
        self.0.remove(&id).is_some()
    }

    /// Takes a message; `None` if there is no such connection.
    pub(super) fn receive(&mut self, id: ConnectionId, sequence: u16, now: Duration) -> Option<Arrival> {
        let connection = self.0.get_mut(&id)?;
        connection.heard(now);
        Some(match &connection.last {
            Some((last, Some(stored))) if *last == sequence => Arrival::Answered(stored.clone()),
            Some((last, None)) if *last == sequence => Arrival::InProgress,
            _ => {
                connection.last = Some((sequence, None));
                connection.in_flight += 1;
                Arrival::New {
                    t_to_o_id: connection.t_to_o_id,
                    budget: usize::from(connection.t_to_o_size).saturating_sub(2),
                }
            }
        })
    }

    /// A request has its reply: keeps the packet for a repetition.
    pub(super) fn answered(&mut self, id: ConnectionId, sequence: u16, packet: &Bytes, now: Duration) {
        let Some(connection) = self.0.get_mut(&id) else { return };
        connection.in_flight = connection.in_flight.saturating_sub(1);
        connection.heard(now);
        if let Some((last, stored)) = &mut connection.last
            && *last == sequence
        {
            *stored = Some(packet.clone());
        }
    }

    /// The packet a repetition gets.
    pub(super) fn stored(&self, id: ConnectionId, sequence: u16) -> Option<Bytes> {
        match &self.0.get(&id)?.last {
            Some((last, stored)) if *last == sequence => stored.clone(),
            _ => None,
        }
    }

    /// When the first watchdog expires; one that has a request in the works does not.
    pub(super) fn deadline(&self) -> Option<Duration> {
        self.0
            .values()
            .filter(|connection| connection.in_flight == 0)
            .map(|connection| connection.deadline)
            .min()
    }

    /// Drops connections whose watchdog has expired.
    pub(super) fn expire(&mut self, now: Duration, host: &mut dyn Host) {
        self.0.retain(|id, connection| {
            let lives = connection.in_flight > 0 || now < connection.deadline;
            if !lives {
                host.count(Count::ConnectionTimeouts);
                host.release_connections(1);
                host.connection_ended(*id, ConnectionEnd::TimedOut);
            }
            lives
        });
    }

    /// Drops them all.
    pub(super) fn clear(&mut self, host: &mut dyn Host) {
        let count = self.0.len();
        self.0.clear();
        if count > 0 {
            host.release_connections(count);
        }
    }
}
