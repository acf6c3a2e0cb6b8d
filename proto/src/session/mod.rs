//! The server's side of one TCP connection, without I/O: sessions, unconnected messages, and class 3 connections
//! (spec/ethernet-ip.md §2, §7, §8, §18).
//!
//! Bytes go in by [`ServerSession::handle_input`], [`Event`]s come out of [`ServerSession::poll_event`]. The application
//! answers each [`Event::Request`] once by [`ServerSession::reply`]; replies leave in the order of the requests whatever
//! the order of the answers. `now` is the time since any fixed moment; it never runs backwards. Random numbers, shared
//! limits and counters are the [`Host`]'s.

mod host;
mod settings;

use bytes::{Bytes, BytesMut};
use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddrV4;
use std::sync::Arc;
use std::time::Duration;

use crate::cip::{CipStatus, Reply, Request, class, service};
use crate::connection::{
    self, ConnectionKey, ConnectionType, Count, ForwardClose, ForwardOpen, ForwardOpenReply, NetworkParameters,
    UnconnectedSend,
};
use crate::cpf::{ConnectionId, Packet};
use crate::discovery::list_reply;
use crate::encap::{Command, EncapStatus, Frame, FrameDecoder, FrameError, Header, RegisterSession, SessionHandle};
use crate::epath::{Epath, Segment};
use crate::status::connection as extended;

pub use host::Host;
use host::nonzero;
pub use settings::{Settings, Slots, UnknownConnection};

/// The smallest connection size that is of any use: a sequence count, a reply's head and some data.
pub const MIN_CONNECTION_SIZE: u16 = 16;
/// The shortest interval that is confirmed, µs; it only feeds the watchdog.
const MIN_API: u32 = 10_000;
/// The longest time to the first message of a connection is at least this.
const FIRST_MESSAGE: Duration = Duration::from_secs(10);

/// Names a request that waits for its answer; never repeats in a session.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct RequestId(u64);

/// What a session wants.
#[derive(Clone, PartialEq, Debug)]
pub enum Event {
    /// Send this to the peer.
    Outgoing(Bytes),
    /// Execute this and answer it by [`ServerSession::reply`].
    Request {
        /// Name for the answer.
        id: RequestId,
        /// What is asked. Multiple Service Packets come whole.
        request: Request,
        /// The longest router reply, bytes with its head.
        reply_budget: usize,
        /// On what.
        transport: Transport,
    },
    /// Send what is left, then close the socket. Nothing follows.
    Close(CloseReason),
}

/// What a request came on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Transport {
    /// SendRRData; a stray route may follow the data ([`crate::cip::is_stray_route`]).
    Unconnected,
    /// A class 3 connection.
    Connected,
}

/// Why a session ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum CloseReason {
    /// The peer said so.
    #[error("the peer unregistered")]
    Unregistered,
    /// No RegisterSession in time.
    #[error("no session was registered in time")]
    NotRegistered,
    /// Silence.
    #[error("nothing was heard for too long")]
    Inactive,
    /// A frame longer than accepted.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A message for a connection this socket does not have.
    #[error("message for an unknown connection")]
    UnknownConnection,
}

/// A session's life.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Life {
    /// Waits for RegisterSession until then.
    Fresh { until: Duration },
    /// Registered; last heard of then.
    Registered { handle: SessionHandle, heard: Duration },
    /// The socket is to be closed.
    Closed,
}

/// A class 3 connection, by its O→T id in [`ServerSession::connections`].
#[derive(Debug)]
struct Connection {
    key: ConnectionKey,
    t_to_o_id: ConnectionId,
    t_to_o_size: u16,
    o_to_t_api: u32,
    t_to_o_api: u32,
    timeout: Duration,
    deadline: Duration,
    in_flight: usize,
    /// Sequence count of the last request, and its reply when it is there: what a repetition gets.
    last: Option<(u16, Option<Bytes>)>,
}

/// Where a reply goes.
#[derive(Debug)]
enum Way {
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
    const fn budget(&self) -> usize {
        match self {
            Self::Unconnected { budget } | Self::Connected { budget, .. } => *budget,
        }
    }
}

/// A place in the order of replies.
#[derive(Debug)]
enum Slot {
    /// The application works on it.
    Waiting {
        id: RequestId,
        service: u8,
        header: Header,
        way: Way,
    },
    /// Ready to leave.
    Ready(Frame),
    /// Repeats the reply in front of it, which is not there yet.
    Repeat {
        header: Header,
        id: ConnectionId,
        sequence: u16,
    },
}

/// The server's side of one TCP connection.
#[derive(Debug)]
pub struct ServerSession {
    settings: Arc<Settings>,
    local: SocketAddrV4,
    life: Life,
    connections: BTreeMap<ConnectionId, Connection>,
    slots: VecDeque<Slot>,
    events: VecDeque<Event>,
    next_id: u64,
    unknown_connections: u64,
}

impl ServerSession {
    /// A session on a socket just accepted at address `local` (what ListIdentity tells).
    pub fn new(settings: Arc<Settings>, local: SocketAddrV4, now: Duration) -> Self {
        let until = now + settings.register_timeout;
        Self {
            settings,
            local,
            life: Life::Fresh { until },
            connections: BTreeMap::new(),
            slots: VecDeque::new(),
            events: VecDeque::new(),
            next_id: 0,
            unknown_connections: 0,
        }
    }

    /// Takes whole frames off the front of `buf`, as many as [`Self::wants_input`] allows. Call it again after replies
    /// when `buf` was not empty.
    pub fn handle_input(&mut self, buf: &mut BytesMut, now: Duration, host: &mut dyn Host) {
        let decoder = FrameDecoder::new(self.settings.frame_limit);
        while self.wants_input() {
            match decoder.decode(buf) {
                Ok(Some(frame)) => self.handle_frame(&frame, now, host),
                Ok(None) => return,
                Err(error) => {
                    let FrameError::TooLong { header, .. } = error;
                    self.push_ready(Frame::error(&header, EncapStatus::INVALID_LENGTH));
                    self.close(CloseReason::Frame(error), host);
                }
            }
        }
    }

    /// Whether more input is taken: the session is open and not too many requests wait for answers.
    pub fn wants_input(&self) -> bool {
        self.life != Life::Closed && self.slots.len() < self.settings.max_pending.max(1)
    }

    /// Takes one frame.
    pub fn handle_frame(&mut self, frame: &Frame, now: Duration, host: &mut dyn Host) {
        if self.life == Life::Closed {
            return;
        }
        self.expire_connections(now, host);
        if let Life::Registered { heard, .. } = &mut self.life {
            *heard = now;
        }
        let header = &frame.header;
        if header.status != EncapStatus::SUCCESS || header.options != 0 {
            return;
        }
        match header.command {
            Command::NOP => {}
            Command::REGISTER_SESSION => self.register(frame, now, host),
            Command::UNREGISTER_SESSION => match self.check_session(header) {
                Ok(()) => self.close(CloseReason::Unregistered, host),
                Err(status) => self.push_ready(Frame::error(header, status)),
            },
            Command::SEND_RR_DATA => self.send_rr_data(frame, now, host),
            Command::SEND_UNIT_DATA => self.send_unit_data(frame, now, host),
            command => {
                let reply = match list_reply(command, host.identity(), self.settings.capability, self.local) {
                    Some(data) => Frame::reply(header, data),
                    None => Frame::error(header, EncapStatus::INVALID_COMMAND),
                };
                self.push_ready(reply);
            }
        }
    }

    /// Answers a request. A reply beyond the budget becomes 0x11. `false`: there is no such request, or it has been
    /// answered.
    pub fn reply(&mut self, id: RequestId, reply: &Reply, now: Duration) -> bool {
        let found = self
            .slots
            .iter_mut()
            .find(|slot| matches!(slot, Slot::Waiting { id: waiting, .. } if *waiting == id));
        let Some(slot) = found else { return false };
        let Slot::Waiting {
            service, header, way, ..
        } = slot
        else {
            return false;
        };
        let bytes = if reply.len() <= way.budget() {
            reply.to_bytes()
        } else {
            Reply::error(*service, CipStatus::REPLY_TOO_LARGE).to_bytes()
        };
        let data = packet(way, bytes);
        if let Way::Connected { id, sequence, .. } = way
            && let Some(connection) = self.connections.get_mut(id)
        {
            connection.in_flight = connection.in_flight.saturating_sub(1);
            connection.deadline = now + connection.timeout;
            if let Some((last, stored)) = &mut connection.last
                && last == sequence
            {
                *stored = Some(data.clone());
            }
        }
        *slot = Slot::Ready(Frame::reply(header, data));
        self.flush();
        true
    }

    /// The next thing to do.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// When [`Self::handle_timeout`] is due; ask again after every call that changes the session.
    pub fn poll_timeout(&self) -> Option<Duration> {
        let life = match self.life {
            Life::Fresh { until } => Some(until),
            Life::Registered { heard, .. } if self.slots.is_empty() => {
                self.settings.inactivity.map(|time| heard + time)
            }
            Life::Registered { .. } => None,
            Life::Closed => return None,
        };
        self.connections
            .values()
            .filter(|c| c.in_flight == 0)
            .map(|c| c.deadline)
            .chain(life)
            .min()
    }

    /// Drops connections whose watchdog has expired, and the session if it was silent for too long.
    pub fn handle_timeout(&mut self, now: Duration, host: &mut dyn Host) {
        self.expire_connections(now, host);
        match self.life {
            Life::Fresh { until } if until <= now => self.close(CloseReason::NotRegistered, host),
            Life::Registered { heard, .. } => {
                let limit = self.settings.inactivity.map(|time| heard + time);
                if self.slots.is_empty() && limit.is_some_and(|limit| limit <= now) {
                    self.close(CloseReason::Inactive, host);
                }
            }
            _ => {}
        }
    }

    /// The socket has gone: frees the connections. Events that are left need not be polled.
    pub fn handle_disconnect(&mut self, host: &mut dyn Host) {
        self.life = Life::Closed;
        self.slots.clear();
        self.drop_connections(host);
    }

    /// Class 3 connections that are open.
    pub fn connections(&self) -> usize {
        self.connections.len()
    }

    /// Whether RegisterSession has succeeded and the session lives.
    pub fn is_registered(&self) -> bool {
        matches!(self.life, Life::Registered { .. })
    }

    /// Class 3 messages for connections that this socket does not have.
    pub fn unknown_connections(&self) -> u64 {
        self.unknown_connections
    }

    fn check_session(&self, header: &Header) -> Result<(), EncapStatus> {
        match self.life {
            Life::Registered { handle, .. } if handle == header.session => Ok(()),
            _ => Err(EncapStatus::INVALID_SESSION),
        }
    }

    fn register(&mut self, frame: &Frame, now: Duration, host: &mut dyn Host) {
        let header = &frame.header;
        let reply = match (self.life, RegisterSession::decode(&frame.data)) {
            (Life::Registered { .. }, _) => Frame::error(header, EncapStatus::INVALID_COMMAND),
            (_, None) => Frame::error(header, EncapStatus::INVALID_LENGTH),
            (_, Some(RegisterSession::CURRENT)) => {
                let handle = SessionHandle(nonzero(host, |_| true));
                self.life = Life::Registered { handle, heard: now };
                Frame::reply(
                    &Header {
                        session: handle,
                        ..*header
                    },
                    RegisterSession::CURRENT.to_bytes(),
                )
            }
            (_, Some(_)) => {
                let mut reply = Frame::reply(header, RegisterSession::CURRENT.to_bytes());
                reply.header.status = EncapStatus::UNSUPPORTED_VERSION;
                reply
            }
        };
        self.push_ready(reply);
    }

    fn send_rr_data(&mut self, frame: &Frame, now: Duration, host: &mut dyn Host) {
        let header = frame.header;
        if let Err(status) = self.check_session(&header) {
            return self.push_ready(Frame::error(&header, status));
        }
        let message = Packet::decode(&frame.data).and_then(|packet| packet.unconnected_message().cloned());
        match message {
            Ok(message) => {
                let way = Way::Unconnected {
                    budget: self.settings.unconnected_reply_limit,
                };
                self.message(header, way, &message, now, host);
            }
            Err(_) => self.push_ready(Frame::error(&header, EncapStatus::INCORRECT_DATA)),
        }
    }

    fn send_unit_data(&mut self, frame: &Frame, now: Duration, host: &mut dyn Host) {
        let header = frame.header;
        if let Err(status) = self.check_session(&header) {
            return self.push_ready(Frame::error(&header, status));
        }
        let Ok((id, sequence, message)) = Packet::decode(&frame.data).and_then(|packet| packet.connected_message())
        else {
            return self.push_ready(Frame::error(&header, EncapStatus::INCORRECT_DATA));
        };
        let Some(connection) = self.connections.get_mut(&id) else {
            self.unknown_connections += 1;
            if self.settings.unknown_connection == UnknownConnection::Close {
                self.close(CloseReason::UnknownConnection, host);
            }
            return;
        };
        connection.deadline = now + connection.timeout;
        match &connection.last {
            Some((last, Some(stored))) if *last == sequence => {
                let reply = Frame::reply(&header, stored.clone());
                self.push_ready(reply);
            }
            Some((last, None)) if *last == sequence => self.slots.push_back(Slot::Repeat { header, id, sequence }),
            _ => {
                connection.last = Some((sequence, None));
                connection.in_flight += 1;
                let budget = usize::from(connection.t_to_o_size).saturating_sub(2);
                let way = Way::Connected {
                    id,
                    t_to_o_id: connection.t_to_o_id,
                    sequence,
                    budget,
                };
                self.message(header, way, &message, now, host);
            }
        }
    }

    /// Gives a message a place in the order of replies; answers it if the Connection Manager can.
    fn message(&mut self, header: Header, way: Way, message: &Bytes, now: Duration, host: &mut dyn Host) {
        let id = RequestId(self.next_id);
        self.next_id += 1;
        let transport = match way {
            Way::Unconnected { .. } => Transport::Unconnected,
            Way::Connected { .. } => Transport::Connected,
        };
        let reply_budget = way.budget();
        let outcome = Request::decode(message).map_err(|error| error.reply());
        let outcome = outcome.and_then(|request| self.unwrap_route(request, host));
        let outcome = outcome.and_then(|request| self.manage_connections(request, now, host));
        let service = match &outcome {
            Ok(request) => request.service,
            Err(reply) => reply.service,
        };
        self.slots.push_back(Slot::Waiting {
            id,
            service,
            header,
            way,
        });
        match outcome {
            Ok(request) => self.events.push_back(Event::Request {
                id,
                request,
                reply_budget,
                transport,
            }),
            Err(reply) => {
                self.reply(id, &reply, now);
            }
        }
    }

    /// Takes a request out of its Unconnected Send, if the route leads here. `Err` is the reply.
    fn unwrap_route(&self, request: Request, _host: &dyn Host) -> Result<Request, Reply> {
        if request.service != service::UNCONNECTED_SEND || !is_connection_manager(&request.path) {
            return Ok(request);
        }
        let send = UnconnectedSend::decode(&request.data).map_err(|status| Reply::error(request.service, status))?;
        self.check_route(&send.route.0)
            .map_err(|(code, left)| connection::route_refusal(code, left))?;
        let inner = Request::decode(&send.message).map_err(|error| error.reply())?;
        if inner.service == service::UNCONNECTED_SEND && is_connection_manager(&inner.path) {
            return Err(Reply::error(inner.service, CipStatus::SERVICE_NOT_SUPPORTED));
        }
        Ok(inner)
    }

    /// Whether a route leads to this controller; otherwise the additional status and the words that remain.
    fn check_route(&self, route: &[Segment]) -> Result<(), (u16, u8)> {
        let words = || u8::try_from(Epath(route.to_vec()).to_bytes().len() / 2).unwrap_or(u8::MAX);
        match route {
            [] => Ok(()),
            [Segment::Port(port)] => match port.backplane_slot() {
                Some(slot) if self.is_our_slot(slot) => Ok(()),
                Some(_) => Err((extended::LINK_ADDRESS_INVALID, words())),
                None => Err((extended::PORT_UNAVAILABLE, words())),
            },
            [Segment::Port(port), ..] if port.backplane_slot().is_some() => {
                Err((extended::LINK_ADDRESS_INVALID, words()))
            }
            _ => Err((extended::PORT_UNAVAILABLE, words())),
        }
    }

    fn is_our_slot(&self, slot: u8) -> bool {
        match &self.settings.slots {
            Slots::Any => true,
            Slots::Only(slots) => slots.contains(&slot),
        }
    }

    /// Opens and closes connections. `Err` is the reply, of success too; other requests pass.
    fn manage_connections(&mut self, request: Request, now: Duration, host: &mut dyn Host) -> Result<Request, Reply> {
        if !is_connection_manager(&request.path) {
            return Ok(request);
        }
        match request.service {
            service::FORWARD_OPEN | service::LARGE_FORWARD_OPEN => Err(self.forward_open(&request, now, host)),
            service::FORWARD_CLOSE => Err(self.forward_close(&request, host)),
            _ => Ok(request),
        }
    }

    fn forward_open(&mut self, request: &Request, now: Duration, host: &mut dyn Host) -> Reply {
        host.count(Count::OpenRequests);
        let large = request.service == service::LARGE_FORWARD_OPEN;
        let open = match ForwardOpen::decode(&request.data, large) {
            Ok(open) => open,
            Err(error) => {
                host.count(Count::OpenFormatRejects);
                return connection::refusal(request.service, error.key, error.status, 0);
            }
        };
        match self.try_open(&open, now, host) {
            Ok(reply) => Reply::success(request.service, reply.to_bytes()),
            Err((status, left)) => {
                let resource = status == CipStatus::connection(extended::OUT_OF_CONNECTIONS);
                host.count(if resource {
                    Count::OpenResourceRejects
                } else {
                    Count::OpenOtherRejects
                });
                connection::refusal(request.service, open.key, status, left)
            }
        }
    }

    fn try_open(
        &mut self,
        open: &ForwardOpen,
        now: Duration,
        host: &mut dyn Host,
    ) -> Result<ForwardOpenReply, (CipStatus, u8)> {
        let fail = |code: u16| (CipStatus::connection(code), 0);
        if let Some((id, known)) = self.connections.iter_mut().find(|(_, known)| known.key == open.key) {
            if !open.is_null() {
                return Err(fail(extended::DUPLICATE));
            }
            known.deadline = now + known.timeout;
            return Ok(open_reply(*id, known));
        }
        if open.is_null() {
            return Err(fail(extended::NULL_OPEN_UNSUPPORTED));
        }
        if open.transport_class() != 3 {
            return Err(fail(extended::CLASS_UNSUPPORTED));
        }
        if open.multiplier > 7 {
            return Err(fail(extended::TIMEOUT_MULTIPLIER));
        }
        self.check_connection_path(&open.path, host)?;
        let types = [
            (open.o_to_t, extended::TYPE_O_TO_T),
            (open.t_to_o, extended::TYPE_T_TO_O),
        ];
        for (parameters, code) in types {
            if parameters.connection_type != ConnectionType::PointToPoint {
                return Err(fail(code));
            }
            self.check_size(parameters)?;
        }
        if self.connections.len() >= self.settings.max_connections || !host.acquire_connection() {
            return Err(fail(extended::OUT_OF_CONNECTIONS));
        }
        let id = ConnectionId(nonzero(host, |id| !self.connections.contains_key(&ConnectionId(id))));
        let o_to_t_api = open.o_to_t_rpi.max(MIN_API);
        let timeout = Duration::from_micros(u64::from(o_to_t_api) << (open.multiplier + 2));
        let connection = Connection {
            key: open.key,
            t_to_o_id: open.t_to_o_id,
            t_to_o_size: open.t_to_o.size,
            o_to_t_api,
            t_to_o_api: open.t_to_o_rpi.max(MIN_API),
            timeout,
            deadline: now + timeout.max(FIRST_MESSAGE),
            in_flight: 0,
            last: None,
        };
        let reply = open_reply(id, &connection);
        self.connections.insert(id, connection);
        Ok(reply)
    }

    fn check_size(&self, parameters: NetworkParameters) -> Result<(), (CipStatus, u8)> {
        let most = self.settings.max_connection_size;
        if (MIN_CONNECTION_SIZE..=most).contains(&parameters.size) {
            Ok(())
        } else {
            Err((CipStatus::connection(extended::INVALID_SIZE).with(most), 0))
        }
    }

    /// [ports] [electronic key] Message Router; network segments are passed over.
    fn check_connection_path(&self, path: &Epath, host: &dyn Host) -> Result<(), (CipStatus, u8)> {
        let (mut route, mut application) = (Vec::new(), Vec::new());
        for segment in &path.0 {
            match segment {
                Segment::Key(key) => {
                    host.identity()
                        .check_key(key)
                        .map_err(|code| (CipStatus::connection(code), 0))?;
                }
                Segment::Network { .. } => {}
                Segment::Port(_) if application.is_empty() => route.push(segment.clone()),
                other => application.push(other.clone()),
            }
        }
        self.check_route(&route)
            .map_err(|(code, left)| (CipStatus::connection(code), left))?;
        if Epath(application).is_object(class::MESSAGE_ROUTER, 1) {
            Ok(())
        } else {
            Err((CipStatus::connection(extended::INVALID_SEGMENT), 0))
        }
    }

    fn forward_close(&mut self, request: &Request, host: &mut dyn Host) -> Reply {
        host.count(Count::CloseRequests);
        let close = match ForwardClose::decode(&request.data) {
            Ok(close) => close,
            Err(status) => {
                host.count(Count::CloseFormatRejects);
                return connection::refusal(request.service, ConnectionKey::default(), status, 0);
            }
        };
        let id = self
            .connections
            .iter()
            .find(|(_, known)| known.key == close.key)
            .map(|(id, _)| *id);
        match id.and_then(|id| self.connections.remove(&id)) {
            Some(_) => {
                host.release_connections(1);
                ForwardClose::reply(close.key)
            }
            None => {
                host.count(Count::CloseOtherRejects);
                connection::refusal(
                    request.service,
                    close.key,
                    CipStatus::connection(extended::NOT_FOUND),
                    0,
                )
            }
        }
    }

    fn expire_connections(&mut self, now: Duration, host: &mut dyn Host) {
        let before = self.connections.len();
        self.connections
            .retain(|_, connection| connection.in_flight > 0 || now < connection.deadline);
        let expired = before - self.connections.len();
        if expired > 0 {
            (0..expired).for_each(|_| host.count(Count::ConnectionTimeouts));
            host.release_connections(expired);
        }
    }

    fn drop_connections(&mut self, host: &mut dyn Host) {
        let count = self.connections.len();
        self.connections.clear();
        if count > 0 {
            host.release_connections(count);
        }
    }

    /// Requests that wait are forgotten; what is ready in front of them still leaves.
    fn close(&mut self, reason: CloseReason, host: &mut dyn Host) {
        if let (CloseReason::Frame(_), Some(Slot::Ready(refusal))) = (reason, self.slots.pop_back()) {
            self.events.push_back(Event::Outgoing(refusal.to_bytes()));
        }
        self.slots.clear();
        self.drop_connections(host);
        self.life = Life::Closed;
        self.events.push_back(Event::Close(reason));
    }

    fn push_ready(&mut self, frame: Frame) {
        self.slots.push_back(Slot::Ready(frame));
        self.flush();
    }

    /// Lets the replies at the front go.
    fn flush(&mut self) {
        while let Some(slot) = self.slots.front() {
            let frame = match slot {
                Slot::Waiting { .. } => return,
                Slot::Ready(frame) => Some(frame.clone()),
                Slot::Repeat { header, id, sequence } => {
                    self.stored(*id, *sequence).map(|data| Frame::reply(header, data))
                }
            };
            self.slots.pop_front();
            if let Some(frame) = frame {
                self.events.push_back(Event::Outgoing(frame.to_bytes()));
            }
        }
    }

    fn stored(&self, id: ConnectionId, sequence: u16) -> Option<Bytes> {
        match &self.connections.get(&id)?.last {
            Some((last, stored)) if *last == sequence => stored.clone(),
            _ => None,
        }
    }
}

fn packet(way: &Way, reply: Bytes) -> Bytes {
    match way {
        Way::Unconnected { .. } => Packet::unconnected(reply).to_bytes(),
        Way::Connected {
            t_to_o_id, sequence, ..
        } => Packet::connected(*t_to_o_id, *sequence, &reply).to_bytes(),
    }
}

fn open_reply(id: ConnectionId, connection: &Connection) -> ForwardOpenReply {
    ForwardOpenReply {
        o_to_t_id: id,
        t_to_o_id: connection.t_to_o_id,
        key: connection.key,
        o_to_t_api: connection.o_to_t_api,
        t_to_o_api: connection.t_to_o_api,
        application: Bytes::new(),
    }
}

fn is_connection_manager(path: &Epath) -> bool {
    path.is_object(class::CONNECTION_MANAGER, 1)
}
