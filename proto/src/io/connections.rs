//! The I/O connections of a device: the rules for opening them, the effects of datagrams, and their watchdogs
//! (spec/ethernet-ip.md §7.2, §7.3, §14).
//!
//! Unlike class 3 connections they outlive the TCP connection that opened them. Bytes go in by
//! [`IoConnections::handle_datagram`], time by [`IoConnections::handle_timeout`]; datagrams come out of
//! [`IoConnections::poll_transmit`], the effects on the outputs out of [`IoConnections::poll_event`].

use bytes::{Bytes, BytesMut};
use std::collections::{BTreeMap, VecDeque};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::time::Duration;

use super::IO_PORT;
use super::application::{Application, Assemblies, OpenRequest};
use super::connection::{Arrival, IoConnection, MAX_INTERVAL, MAX_TIMEOUT, Mode, timeout};
use super::datagram::Datagram;
use super::production::Production;
use crate::cip::CipStatus;
use crate::connection::{ConnectionKey, ForwardOpen, ForwardOpenReply};
use crate::cpf::ConnectionId;
use crate::epath::Segment;
use crate::status::connection as extended;

/// The settings of a device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct IoSettings {
    /// The assemblies that connections can name.
    pub assemblies: Assemblies,
    /// Connections at a time.
    pub max_connections: usize,
    /// The shortest interval that is confirmed, µs; a shorter one is refused.
    pub min_interval: u32,
    /// Bytes at the beginning of the input that are never the same twice: no change of state.
    pub volatile: usize,
    /// The socket that datagrams leave from.
    pub local: SocketAddr,
}

/// The originator of a connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Originator {
    /// The far end of its TCP connection.
    pub address: IpAddr,
    /// The UDP port it says that it listens on (item 0x8001), if it says one.
    pub port: Option<u16>,
    /// The group in which it can be sent inputs by multicast; `None`: it cannot.
    pub group: Option<Ipv4Addr>,
}

/// The reason for the end of a connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Ended {
    /// A Forward Close.
    Closed,
    /// Nothing was heard in time.
    TimedOut,
    /// It only listened, and the last connection that did more has gone.
    NothingToHear,
}

/// A change of a connection.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum IoEvent {
    /// The owner is in run, and these are its outputs: as many bytes as the output assembly has.
    Outputs(Bytes),
    /// The owner has gone from run to idle: its outputs are not to be applied any more.
    Idle,
    /// A connection has gone.
    Ended {
        /// Its O→T id.
        id: ConnectionId,
        /// Its application.
        application: Application,
        /// The reason.
        cause: Ended,
        /// Whether it was an owner in run: its outputs are lost.
        outputs_lost: bool,
    },
}

/// The state of the outputs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Ownership {
    /// They have no owner.
    Free,
    /// They have an owner, which is not in run.
    Idle,
    /// They have an owner in run.
    Run,
}

/// The I/O connections of a device.
#[derive(Debug)]
pub struct IoConnections {
    settings: IoSettings,
    /// By their O→T id.
    connections: BTreeMap<ConnectionId, IoConnection>,
    /// Their productions, by a number that is never used again.
    productions: BTreeMap<u64, Production>,
    next_production: u64,
    events: VecDeque<IoEvent>,
}

impl IoConnections {
    /// None yet.
    pub fn new(settings: IoSettings) -> Self {
        Self {
            settings,
            connections: BTreeMap::new(),
            productions: BTreeMap::new(),
            next_production: 0,
            events: VecDeque::new(),
        }
    }

    /// The settings of [`Self::new`].
    pub fn settings(&self) -> &IoSettings {
        &self.settings
    }

    /// How many are open.
    pub fn len(&self) -> usize {
        self.connections.len()
    }

    /// Whether none is open.
    pub fn is_empty(&self) -> bool {
        self.connections.is_empty()
    }

    /// The state of the outputs.
    pub fn outputs(&self) -> Ownership {
        self.connections
            .values()
            .find(|connection| connection.request.application == Application::ExclusiveOwner)
            .map_or(Ownership::Free, |owner| match owner.mode {
                Mode::Run => Ownership::Run,
                Mode::Silent | Mode::Idle => Ownership::Idle,
            })
    }

    /// Opens a connection, whose electronic key and ports have been looked at; `application` is the rest of its path.
    /// `random` draws ids. A null Forward Open of a connection that is open confirms it and changes nothing. It produces
    /// nothing before [`Self::start`].
    ///
    /// # Errors
    /// The status of the refusal: 0x01 with the additional status of spec/ethernet-ip.md §6; 0x02 when `random` gives out.
    pub fn open(
        &mut self,
        open: &ForwardOpen,
        application: &[Segment],
        originator: Originator,
        now: Duration,
        mut random: impl FnMut() -> Option<u32>,
    ) -> Result<ForwardOpenReply, CipStatus> {
        let fail = |code: u16| Err(CipStatus::connection(code));
        self.handle_timeout(now);
        if let Some((id, known)) = self.find(open.key) {
            return if open.is_null() && known.from == originator.address {
                Ok(known.reply(id))
            } else {
                fail(extended::DUPLICATE)
            };
        }
        if open.is_null() {
            return fail(extended::NULL_OPEN_UNSUPPORTED);
        }
        let request = OpenRequest::new(open, application, &self.settings.assemblies)?;
        if request.multicast && originator.group.is_none() {
            return fail(extended::TYPE_T_TO_O);
        }
        let intervals = self.settings.min_interval.max(1)..=MAX_INTERVAL;
        if !intervals.contains(&open.o_to_t_rpi) || !intervals.contains(&open.t_to_o_rpi) {
            return fail(extended::RPI_UNSUPPORTED);
        }
        if timeout(open) > MAX_TIMEOUT {
            return fail(extended::TIMEOUT_MULTIPLIER);
        }
        match request.application {
            Application::ExclusiveOwner if self.outputs() != Ownership::Free => {
                return fail(extended::OWNERSHIP_CONFLICT);
            }
            Application::ListenOnly if !self.something_to_hear() => return fail(extended::NON_LISTEN_ONLY_NOT_OPEN),
            _ => {}
        }
        if self.connections.len() >= self.settings.max_connections {
            return fail(extended::OUT_OF_CONNECTIONS);
        }
        let id = draw(&mut random, |id| self.connections.contains_key(&id)).ok_or(CipStatus::RESOURCE_UNAVAILABLE)?;
        let port = originator.port.filter(|port| *port != 0).unwrap_or(IO_PORT);
        // On one host with us, an originator cannot listen where we do: it answers from another port.
        let is_ourselves = !request.multicast && SocketAddr::new(originator.address, port) == self.settings.local;
        let produced = match originator.group.filter(|_| request.multicast) {
            Some(group) => {
                let to = SocketAddr::new(group.into(), IO_PORT);
                self.join(to, open, request, &mut random)
                    .ok_or(CipStatus::RESOURCE_UNAVAILABLE)?
            }
            None => {
                let to = SocketAddr::new(originator.address, port);
                self.produce(to, open.t_to_o_id, open, request)
            }
        };
        let connection = IoConnection::new(open, request, originator.address, is_ourselves, produced, now);
        let reply = connection.reply(id);
        self.connections.insert(id, connection);
        Ok(reply)
    }

    /// The production of a group: one that there is, or a new one under an id of ours.
    fn join(
        &mut self,
        to: SocketAddr,
        open: &ForwardOpen,
        request: OpenRequest,
        random: &mut impl FnMut() -> Option<u32>,
    ) -> Option<(u64, ConnectionId)> {
        let interval = Duration::from_micros(open.t_to_o_rpi.into());
        let mut known = self.productions.iter_mut();
        if let Some((number, production)) = known.find(|(_, known)| known.serves(to.ip(), interval, request)) {
            production.consumers += 1;
            return Some((*number, production.id));
        }
        let used = |id: ConnectionId| self.productions.values().any(|known| known.id == id);
        let id = draw(random, used)?;
        Some(self.produce(to, id, open, request))
    }

    fn produce(
        &mut self,
        to: SocketAddr,
        id: ConnectionId,
        open: &ForwardOpen,
        request: OpenRequest,
    ) -> (u64, ConnectionId) {
        let number = self.next_production;
        self.next_production += 1;
        let interval = Duration::from_micros(open.t_to_o_rpi.into());
        self.productions
            .insert(number, Production::new(to, id, interval, request));
        (number, id)
    }

    /// The group that a connection is sent its inputs in; `None`: it is sent them alone, or there is none.
    pub fn group(&self, id: ConnectionId) -> Option<SocketAddr> {
        let production = self.productions.get(&self.connections.get(&id)?.production)?;
        Some(production.to).filter(|to| to.ip().is_multicast())
    }

    /// The reply of the Forward Open has left: from now on the connection produces. `false`: there is none.
    pub fn start(&mut self, id: ConnectionId, now: Duration) -> bool {
        let number = self.connections.get(&id).map(|connection| connection.production);
        match number.and_then(|number| self.productions.get_mut(&number)) {
            Some(production) => {
                production.start(now);
                true
            }
            None => false,
        }
    }

    /// Closes a connection.
    ///
    /// # Errors
    /// 0x01/0x0107: there is none, or it was opened from another address.
    pub fn close(&mut self, key: ConnectionKey, from: IpAddr) -> Result<(), CipStatus> {
        match self.find(key) {
            Some((id, known)) if known.from == from => {
                self.end(id, Ended::Closed);
                self.end_listeners();
                Ok(())
            }
            _ => Err(CipStatus::connection(extended::NOT_FOUND)),
        }
    }

    /// Takes a datagram. `false`: it does not count, being malformed, for no connection, from elsewhere than its
    /// originator, or older than one before.
    pub fn handle_datagram(&mut self, bytes: &[u8], from: SocketAddr, now: Duration) -> bool {
        let Ok(datagram) = Datagram::decode(bytes) else {
            return false;
        };
        let outputs = usize::from(self.settings.assemblies.output.size);
        let Some(connection) = self
            .connections
            .get_mut(&datagram.id)
            .filter(|connection| connection.from == from.ip())
        else {
            return false;
        };
        match connection.receive(&datagram, outputs, now) {
            Arrival::Dropped => return false,
            Arrival::Heartbeat => {}
            Arrival::Outputs(outputs) => self.events.push_back(IoEvent::Outputs(Bytes::copy_from_slice(outputs))),
            Arrival::Idle => self.events.push_back(IoEvent::Idle),
        }
        if connection.learns_port()
            && let Some(production) = self.productions.get_mut(&connection.production)
        {
            production.to.set_port(from.port());
        }
        true
    }

    /// Ends the connections whose watchdog has expired.
    pub fn handle_timeout(&mut self, now: Duration) {
        let mut any = false;
        let late = |(id, known): (&ConnectionId, &IoConnection)| (known.deadline <= now).then_some(*id);
        while let Some(id) = self.connections.iter().find_map(late) {
            self.end(id, Ended::TimedOut);
            any = true;
        }
        if any {
            self.end_listeners();
        }
    }

    /// Appends the next datagram that is due, with `input` as its data, and gives its destination; ask again until `None`.
    pub fn poll_transmit(&mut self, now: Duration, input: &[u8], out: &mut BytesMut) -> Option<SocketAddr> {
        let volatile = self.settings.volatile;
        self.productions.values_mut().find_map(|production| {
            let sent = production.produce(now, input, volatile, LOOK, out);
            sent.then_some(production.to)
        })
    }

    /// From now on the shortest interval that is confirmed, µs. Connections that are open stay as they are.
    pub fn set_min_interval(&mut self, micros: u32) {
        self.settings.min_interval = micros;
    }

    /// When a datagram is due next; `None`: none ever is.
    pub fn next_datagram(&self) -> Option<Duration> {
        self.productions.values().filter_map(Production::due).min()
    }

    /// Whether a datagram is due.
    pub fn is_due(&self, now: Duration) -> bool {
        self.next_datagram().is_some_and(|due| due <= now)
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<IoEvent> {
        self.events.pop_front()
    }

    /// The time at which a datagram or a watchdog is due next.
    pub fn poll_timeout(&self) -> Option<Duration> {
        let deadlines = self.connections.values().map(|connection| connection.deadline);
        self.next_datagram().into_iter().chain(deadlines).min()
    }

    fn find(&self, key: ConnectionKey) -> Option<(ConnectionId, &IoConnection)> {
        let (id, connection) = self.connections.iter().find(|(_, known)| known.key == key)?;
        Some((*id, connection))
    }

    fn something_to_hear(&self) -> bool {
        self.connections
            .values()
            .any(|connection| connection.request.application != Application::ListenOnly)
    }

    fn end(&mut self, id: ConnectionId, cause: Ended) {
        if let Some(connection) = self.connections.remove(&id) {
            let number = connection.production;
            if let Some(production) = self.productions.get_mut(&number) {
                production.consumers -= 1;
                if production.consumers == 0 {
                    self.productions.remove(&number);
                }
            }
            self.events.push_back(IoEvent::Ended {
                id,
                application: connection.request.application,
                cause,
                outputs_lost: connection.mode == Mode::Run,
            });
        }
    }

    /// Those that only listen end with the last connection that does more.
    fn end_listeners(&mut self) {
        if self.something_to_hear() {
            return;
        }
        while let Some(id) = self.connections.keys().next().copied() {
            self.end(id, Ended::NothingToHear);
        }
    }
}

/// From one look for a change of state to the next.
const LOOK: Duration = Duration::from_millis(1);

/// An id that is not 0 and not in use.
fn draw(random: &mut impl FnMut() -> Option<u32>, used: impl Fn(ConnectionId) -> bool) -> Option<ConnectionId> {
    for _ in 0..DRAWS {
        let id = ConnectionId(random()?);
        if id.0 != 0 && !used(id) {
            return Some(id);
        }
    }
    None
}

/// More than a source of randomness needs that does not repeat itself.
const DRAWS: usize = 64;
