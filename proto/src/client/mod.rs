//! The client's side of one TCP connection, without I/O: session, unconnected messages with or without a route, class 3
//! connections, and which reply belongs to which request.
//!
//! Requests give a [`Call`]; [`ClientSession::poll_transmit`] gives bytes to send, [`ClientSession::poll_event`] the
//! outcome of each call. A class 3 connection has one message outstanding; further ones wait inside. `now` is the time since
//! any fixed moment.

mod connection;
mod options;
mod outcome;
mod reply;

use bytes::{Bytes, BytesMut};
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use self::connection::Connection;
use self::reply::{connected_reply, identity, unconnected_reply};
use crate::cip::{Reply, Request, class, service};
use crate::connection::{ConnectionKey, ForwardClose, ForwardOpenReply, TickTime, UnconnectedSend};
use crate::cpf::Packet;
use crate::encap::{Command, EncapFrame, EncapStatus, FrameDecoder, Header, MAX_DATA, RegisterSession, SessionHandle};
use crate::epath::Epath;

pub use self::options::{OpenOptions, backplane};
pub use self::outcome::{ClientError, ClientEvent, Outcome};

/// The identity of a call; it never repeats in a session.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Call(u64);

/// Names an open class 3 connection of this session.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Connected(ConnectionKey);

/// A call whose reply is awaited.
#[derive(Debug)]
enum Wait {
    Register,
    Identity,
    Message,
    Open { options: OpenOptions },
    Close { key: ConnectionKey },
    Connected { key: ConnectionKey },
}

/// A call without its reply.
#[derive(Debug)]
struct Pending {
    wait: Wait,
    command: Command,
    deadline: Duration,
}

/// The client's side of one TCP connection.
#[derive(Debug)]
pub struct ClientSession {
    timeout: Duration,
    handle: Option<SessionHandle>,
    next: u64,
    pending: BTreeMap<Call, Pending>,
    connections: BTreeMap<ConnectionKey, Connection>,
    transmits: VecDeque<Bytes>,
    events: VecDeque<ClientEvent>,
    lost: bool,
}

impl ClientSession {
    /// A session whose requests wait at most `timeout` for their replies.
    pub fn new(timeout: Duration) -> Self {
        Self {
            timeout,
            handle: None,
            next: 1,
            pending: BTreeMap::new(),
            connections: BTreeMap::new(),
            transmits: VecDeque::new(),
            events: VecDeque::new(),
            lost: false,
        }
    }

    /// Registers the session: the first call.
    pub fn register(&mut self, now: Duration) -> Call {
        self.send(
            Wait::Register,
            Command::REGISTER_SESSION,
            RegisterSession::CURRENT.to_bytes(),
            now,
        )
    }

    /// Asks for the identity of the server; needs no session.
    pub fn identify(&mut self, now: Duration) -> Call {
        self.send(Wait::Identity, Command::LIST_IDENTITY, Bytes::new(), now)
    }

    /// Sends a message outside any connection; along `route` it goes inside an Unconnected Send.
    ///
    /// # Errors
    /// `NotRegistered`, `Path`, `Lost`.
    pub fn request(&mut self, request: &Request, route: Option<&Epath>, now: Duration) -> Result<Call, ClientError> {
        self.check()?;
        let message = match route {
            None => request.to_bytes()?,
            Some(route) => {
                let send = UnconnectedSend {
                    time: TickTime::DEFAULT,
                    message: request.to_bytes()?,
                    route: route.clone(),
                };
                connection_manager(service::UNCONNECTED_SEND, send.to_bytes()?).to_bytes()?
            }
        };
        Ok(self.send_unconnected(Wait::Message, message, now))
    }

    /// Opens a class 3 connection.
    ///
    /// # Errors
    /// `NotRegistered`, `Path`, `Lost`.
    pub fn open(&mut self, options: OpenOptions, now: Duration) -> Result<Call, ClientError> {
        self.check()?;
        let code = if options.is_large() {
            service::LARGE_FORWARD_OPEN
        } else {
            service::FORWARD_OPEN
        };
        let open = options.forward_open();
        let message = connection_manager(code, open.to_bytes(options.is_large())?).to_bytes()?;
        Ok(self.send_unconnected(Wait::Open { options }, message, now))
    }

    /// Closes a connection.
    ///
    /// # Errors
    /// `NotRegistered`, `NotOpen`, `Path`, `Lost`.
    pub fn close(&mut self, connected: Connected, now: Duration) -> Result<Call, ClientError> {
        self.check()?;
        let connection = self.connections.get(&connected.0).ok_or(ClientError::NotOpen)?;
        let path = connection.path().clone();
        self.forward_close(connected.0, path, now)
    }

    /// Whether a connection is open, as far as this side knows.
    pub fn is_open(&self, connected: Connected) -> bool {
        self.connections.contains_key(&connected.0)
    }

    /// Sends a Forward Close for a connection that was given up: the target may still have it.
    ///
    /// # Errors
    /// `NotRegistered`, `Path`, `Lost`.
    pub fn close_lost(&mut self, options: &OpenOptions, now: Duration) -> Result<Call, ClientError> {
        self.check()?;
        self.forward_close(options.key, options.path(), now)
    }

    fn forward_close(&mut self, key: ConnectionKey, path: Epath, now: Duration) -> Result<Call, ClientError> {
        let close = ForwardClose {
            time: TickTime::DEFAULT,
            key,
            path,
        };
        let message = connection_manager(service::FORWARD_CLOSE, close.to_bytes()?).to_bytes()?;
        Ok(self.send_unconnected(Wait::Close { key }, message, now))
    }

    /// Sends a message on a connection, after those that wait for it already. A message that could not be sent before the
    /// connection was lost fails with `NotOpen`.
    ///
    /// # Errors
    /// `NotRegistered`, `NotOpen`, `Path`, `Lost`.
    pub fn request_connected(&mut self, on: Connected, request: &Request, now: Duration) -> Result<Call, ClientError> {
        self.check()?;
        let message = request.to_bytes()?;
        if !self.connections.contains_key(&on.0) {
            return Err(ClientError::NotOpen);
        }
        let call = self.await_reply(Wait::Connected { key: on.0 }, Command::SEND_UNIT_DATA, now);
        if let Some(connection) = self.connections.get_mut(&on.0) {
            connection.push(call, message);
        }
        self.send_next(on.0);
        Ok(call)
    }

    /// Ends the session: the last frame to send. The peer closes the socket.
    pub fn unregister(&mut self) {
        if let Some(handle) = self.handle.take() {
            let frame = EncapFrame::request(Command::UNREGISTER_SESSION, handle, [0; 8], Bytes::new());
            self.transmits.push_back(frame.to_bytes());
        }
    }

    /// Whether the session is registered.
    pub fn is_registered(&self) -> bool {
        self.handle.is_some()
    }

    /// Bytes to send.
    pub fn poll_transmit(&mut self) -> Option<Bytes> {
        self.transmits.pop_front()
    }

    /// The next outcome of a call.
    pub fn poll_event(&mut self) -> Option<ClientEvent> {
        self.events.pop_front()
    }

    /// When [`Self::handle_timeout`] is due.
    pub fn poll_timeout(&self) -> Option<Duration> {
        self.pending.values().map(|pending| pending.deadline).min()
    }

    /// Fails calls whose reply has not come in time. A connection whose reply is missing is given up: its state at the peer
    /// is unknown. Its calls that were not sent fail with `NotOpen`.
    pub fn handle_timeout(&mut self, now: Duration) {
        let late: Vec<Call> = self
            .pending
            .iter()
            .filter(|(_, pending)| pending.deadline <= now)
            .map(|(call, _)| *call)
            .collect();
        for call in late {
            let Some(pending) = self.pending.remove(&call) else {
                continue;
            };
            self.finish(call, Outcome::Failed(ClientError::TimedOut));
            if let Wait::Connected { key } | Wait::Close { key } = pending.wait {
                self.give_up(key, ClientError::TimedOut);
            }
        }
    }

    /// The socket has gone: every call fails with `Lost`.
    pub fn handle_disconnect(&mut self) {
        self.fail_all(ClientError::Lost);
    }

    /// Takes whole frames off the front of `buf`.
    ///
    /// # Errors
    /// The stream cannot be read on; every call has failed with the same error. Close the socket.
    pub fn handle_input(&mut self, buf: &mut BytesMut) -> Result<(), ClientError> {
        let decoder = FrameDecoder::new(MAX_DATA);
        while !self.lost {
            match decoder.decode(buf) {
                Ok(Some(frame)) => self.handle_frame(&frame),
                Ok(None) => break,
                Err(error) => {
                    self.fail_all(error.into());
                    return Err(error.into());
                }
            }
        }
        Ok(())
    }

    /// Takes one frame. One that no call waits for is ignored.
    pub fn handle_frame(&mut self, frame: &EncapFrame) {
        let Some(call) = self.match_reply(frame) else {
            return;
        };
        let Some(pending) = self.pending.remove(&call) else {
            return;
        };
        let Header {
            command,
            status,
            session,
            ..
        } = frame.header;
        let on = match pending.wait {
            Wait::Connected { key } => Some(key),
            _ => None,
        };
        if let Some(connection) = on.and_then(|key| self.connections.get_mut(&key)) {
            connection.replied();
        }
        let outcome = if status == EncapStatus::SUCCESS {
            match pending.wait {
                Wait::Register => self.registered(session, &frame.data),
                Wait::Identity => Ok(Outcome::Identity(identity(&frame.data))),
                Wait::Message => unconnected_reply(frame).map(Outcome::Reply),
                Wait::Open { options } => unconnected_reply(frame).and_then(|reply| self.opened(options, &reply)),
                Wait::Close { key } => unconnected_reply(frame).and_then(|reply| self.closed(key, &reply)),
                Wait::Connected { .. } => connected_reply(frame).map(Outcome::Reply),
            }
        } else {
            Err(ClientError::Encapsulation { command, status })
        };
        match on {
            // A peer that refuses the packet has no such connection.
            Some(key) if status != EncapStatus::SUCCESS => self.give_up(key, ClientError::NotOpen),
            Some(key) => self.send_next(key),
            None => {}
        }
        self.finish(call, outcome.unwrap_or_else(Outcome::Failed));
    }

    fn check(&self) -> Result<(), ClientError> {
        match (self.lost, self.handle) {
            (true, _) => Err(ClientError::Lost),
            (false, None) => Err(ClientError::NotRegistered),
            (false, Some(_)) => Ok(()),
        }
    }

    /// Names a call and waits for its reply from now on.
    fn await_reply(&mut self, wait: Wait, command: Command, now: Duration) -> Call {
        let call = Call(self.next);
        self.next += 1;
        let deadline = now + self.timeout;
        let pending = Pending {
            wait,
            command,
            deadline,
        };
        self.pending.insert(call, pending);
        call
    }

    fn transmit(&mut self, call: Call, command: Command, data: Bytes) {
        let handle = self.handle.unwrap_or_default();
        let frame = EncapFrame::request(command, handle, call.0.to_le_bytes(), data);
        self.transmits.push_back(frame.to_bytes());
    }

    fn send(&mut self, wait: Wait, command: Command, data: Bytes, now: Duration) -> Call {
        let call = self.await_reply(wait, command, now);
        self.transmit(call, command, data);
        call
    }

    fn send_unconnected(&mut self, wait: Wait, message: Bytes, now: Duration) -> Call {
        self.send(
            wait,
            Command::SEND_RR_DATA,
            Packet::unconnected(message).to_bytes(),
            now,
        )
    }

    /// Sends the next message of a connection that has none outstanding.
    fn send_next(&mut self, key: ConnectionKey) {
        if let Some((call, packet)) = self.connections.get_mut(&key).and_then(Connection::next) {
            self.transmit(call, Command::SEND_UNIT_DATA, packet.to_bytes());
        }
    }

    /// By sender context; on a connection by its id and sequence count, since a target may not echo the context there.
    fn match_reply(&self, frame: &EncapFrame) -> Option<Call> {
        if frame.header.command == Command::SEND_UNIT_DATA && frame.header.status == EncapStatus::SUCCESS {
            let (id, sequence, _) = Packet::decode_connected(&frame.data).ok()?;
            let connection = self.connections.values().find(|connection| connection.hears(id))?;
            return connection.awaited(sequence);
        }
        let call = Call(u64::from_le_bytes(frame.header.context));
        self.pending
            .get(&call)
            .is_some_and(|pending| pending.command == frame.header.command)
            .then_some(call)
    }

    fn registered(&mut self, session: SessionHandle, data: &[u8]) -> Result<Outcome, ClientError> {
        match RegisterSession::decode(data) {
            Some(RegisterSession::CURRENT) if session != SessionHandle(0) => {
                self.handle = Some(session);
                Ok(Outcome::Registered)
            }
            _ => Err(ClientError::Malformed(Command::REGISTER_SESSION)),
        }
    }

    fn opened(&mut self, options: OpenOptions, reply: &Reply) -> Result<Outcome, ClientError> {
        if !reply.status.is_success() {
            return Err(ClientError::Refused(reply.status));
        }
        let opened = ForwardOpenReply::decode(&reply.data).filter(|opened| opened.key == options.key);
        let opened = opened.ok_or(ClientError::Malformed(Command::SEND_RR_DATA))?;
        let connection = Connection::new(&opened, options.path());
        self.connections.insert(options.key, connection);
        let budget = usize::from(options.size).saturating_sub(2);
        Ok(Outcome::Opened {
            connection: Connected(options.key),
            budget,
        })
    }

    fn closed(&mut self, key: ConnectionKey, reply: &Reply) -> Result<Outcome, ClientError> {
        self.give_up(key, ClientError::NotOpen);
        if reply.status.is_success() {
            Ok(Outcome::Closed)
        } else {
            Err(ClientError::Refused(reply.status))
        }
    }

    /// Forgets a connection. The call that awaits a reply on it fails with `error`, those that were not sent with `NotOpen`.
    fn give_up(&mut self, key: ConnectionKey, error: ClientError) {
        let Some(connection) = self.connections.remove(&key) else {
            return;
        };
        let sent = connection.outstanding().map(|call| (call, error));
        let unsent = connection.into_unsent().map(|call| (call, ClientError::NotOpen));
        for (call, error) in sent.into_iter().chain(unsent) {
            if self.pending.remove(&call).is_some() {
                self.finish(call, Outcome::Failed(error));
            }
        }
    }

    fn fail_all(&mut self, error: ClientError) {
        self.lost = true;
        self.handle = None;
        self.connections.clear();
        for call in std::mem::take(&mut self.pending).into_keys() {
            self.finish(call, Outcome::Failed(error));
        }
    }

    fn finish(&mut self, call: Call, outcome: Outcome) {
        self.events.push_back(ClientEvent { call, outcome });
    }
}

fn connection_manager(code: u8, data: Bytes) -> Request {
    Request::new(code, Epath::object(class::CONNECTION_MANAGER, 1), data)
}
