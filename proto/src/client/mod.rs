//! The client's side of one TCP connection, without I/O: session, unconnected messages with or without a route, class 3
//! connections, and which reply belongs to which request.
//!
//! Requests give a [`Call`]; [`ClientSession::poll_transmit`] gives bytes to send, [`ClientSession::poll_event`] what has
//! come of each call. A class 3 connection has one message outstanding; further ones wait inside. `now` is the time since
//! any fixed moment.

mod error;
mod options;

use bytes::{Bytes, BytesMut};
use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddrV4;
use std::time::Duration;

use crate::cip::{Reply, Request, class, service};
use crate::connection::{
    ConnectionKey, ForwardClose, ForwardOpen, ForwardOpenReply, NetworkParameters, TRANSPORT_CLASS_3, TickTime,
    UnconnectedSend,
};
use crate::cpf::{ConnectionId, Item, Packet, decode_items};
use crate::encap::{Command, EncapStatus, Frame, FrameDecoder, Header, MAX_DATA, RegisterSession, SessionHandle};
use crate::epath::Epath;
use crate::identity::Identity;

pub use error::ClientError;
pub use options::{OpenOptions, backplane};

/// Names something asked; never repeats in a session.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Call(u64);

/// Names an open class 3 connection of this session.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Connected(ConnectionKey);

/// What has come of a call.
#[derive(Clone, PartialEq, Debug)]
pub enum Outcome {
    /// The session is registered.
    Registered,
    /// Who answers, and at which address it says it listens; `None` if the reply holds no identity.
    Identity(Option<(SocketAddrV4, Identity)>),
    /// A CIP reply, whatever its status.
    Reply(Reply),
    /// A connection is open.
    Opened {
        /// For [`ClientSession::request_connected`].
        connection: Connected,
        /// The longest router request and reply it carries, bytes.
        budget: usize,
    },
    /// A connection is closed.
    Closed,
    /// It failed.
    Failed(ClientError),
}

/// A call and what has come of it.
#[derive(Clone, PartialEq, Debug)]
pub struct ClientEvent {
    /// What was asked.
    pub call: Call,
    /// What has come of it.
    pub outcome: Outcome,
}

/// What a reply is awaited for.
#[derive(Debug)]
enum Wait {
    Register,
    Identity,
    Message,
    Open { options: OpenOptions },
    Close { key: ConnectionKey },
    Connected { key: ConnectionKey },
}

#[derive(Debug)]
struct Pending {
    wait: Wait,
    command: Command,
    deadline: Duration,
}

#[derive(Debug)]
struct Connection {
    o_to_t_id: ConnectionId,
    t_to_o_id: ConnectionId,
    sequence: u16,
    path: Epath,
    outstanding: Option<Call>,
    backlog: VecDeque<(Call, Bytes)>,
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

    /// Registers the session: the first thing to do.
    pub fn register(&mut self, now: Duration) -> Call {
        self.send(
            Wait::Register,
            Command::REGISTER_SESSION,
            RegisterSession::CURRENT.to_bytes(),
            now,
        )
    }

    /// Asks who answers; needs no session.
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
        let large = options.size > NetworkParameters::MAX_SMALL;
        let mut path = options.route.clone();
        path.0.extend(Epath::object(class::MESSAGE_ROUTER, 1).0);
        let open = ForwardOpen {
            time: TickTime::DEFAULT,
            o_to_t_id: ConnectionId(0),
            t_to_o_id: options.t_to_o_id,
            key: options.key,
            multiplier: options.multiplier,
            o_to_t_rpi: options.rpi,
            o_to_t: NetworkParameters::explicit(options.size),
            t_to_o_rpi: options.rpi,
            t_to_o: NetworkParameters::explicit(options.size),
            transport: TRANSPORT_CLASS_3,
            path,
        };
        let code = if large {
            service::LARGE_FORWARD_OPEN
        } else {
            service::FORWARD_OPEN
        };
        let message = connection_manager(code, open.to_bytes(large)?).to_bytes()?;
        Ok(self.send_unconnected(Wait::Open { options }, message, now))
    }

    /// Closes a connection.
    ///
    /// # Errors
    /// `NotRegistered`, `NotOpen`, `Path`, `Lost`.
    pub fn close(&mut self, connected: Connected, now: Duration) -> Result<Call, ClientError> {
        self.check()?;
        let connection = self.connections.get(&connected.0).ok_or(ClientError::NotOpen)?;
        let close = ForwardClose {
            time: TickTime::DEFAULT,
            key: connected.0,
            path: connection.path.clone(),
        };
        let message = connection_manager(service::FORWARD_CLOSE, close.to_bytes()?).to_bytes()?;
        Ok(self.send_unconnected(Wait::Close { key: connected.0 }, message, now))
    }

    /// Sends a message on a connection, after those that wait for it already.
    ///
    /// # Errors
    /// `NotRegistered`, `NotOpen`, `Path`, `Lost`.
    pub fn request_connected(&mut self, on: Connected, request: &Request, now: Duration) -> Result<Call, ClientError> {
        self.check()?;
        let message = request.to_bytes()?;
        let connection = self.connections.get_mut(&on.0).ok_or(ClientError::NotOpen)?;
        let call = Call(self.next);
        self.next += 1;
        connection.backlog.push_back((call, message));
        let wait = Wait::Connected { key: on.0 };
        let deadline = now + self.timeout;
        self.pending.insert(
            call,
            Pending {
                wait,
                command: Command::SEND_UNIT_DATA,
                deadline,
            },
        );
        self.send_next(on.0);
        Ok(call)
    }

    /// Ends the session: the last thing to send. The peer closes the socket.
    pub fn unregister(&mut self) {
        if let Some(handle) = self.handle.take() {
            let frame = Frame::request(Command::UNREGISTER_SESSION, handle, [0; 8], Bytes::new());
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

    /// What has come of a call.
    pub fn poll_event(&mut self) -> Option<ClientEvent> {
        self.events.pop_front()
    }

    /// When [`Self::handle_timeout`] is due.
    pub fn poll_timeout(&self) -> Option<Duration> {
        self.pending.values().map(|pending| pending.deadline).min()
    }

    /// Fails calls whose reply has not come in time. A connection whose reply is missing is given up with all that waits
    /// for it: its state at the peer is unknown.
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

    /// Takes one frame. One that nobody waits for is ignored.
    pub fn handle_frame(&mut self, frame: &Frame) {
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
        if let Wait::Connected { key } = pending.wait
            && let Some(connection) = self.connections.get_mut(&key)
        {
            connection.outstanding = None;
        }
        let outcome = if status == EncapStatus::SUCCESS {
            match pending.wait {
                Wait::Register => self.registered(session, &frame.data),
                Wait::Identity => Ok(Outcome::Identity(identity(&frame.data))),
                Wait::Message => unconnected_reply(frame).map(Outcome::Reply),
                Wait::Open { options } => unconnected_reply(frame).and_then(|reply| self.opened(options, &reply)),
                Wait::Close { key } => unconnected_reply(frame).and_then(|reply| self.closed(key, &reply)),
                Wait::Connected { key } => {
                    let outcome = connected_reply(frame).map(Outcome::Reply);
                    self.send_next(key);
                    outcome
                }
            }
        } else {
            if let Wait::Connected { key } = pending.wait {
                self.send_next(key);
            }
            Err(ClientError::Encapsulation { command, status })
        };
        self.finish(call, outcome.unwrap_or_else(Outcome::Failed));
    }

    fn check(&self) -> Result<(), ClientError> {
        match (self.lost, self.handle) {
            (true, _) => Err(ClientError::Lost),
            (false, None) => Err(ClientError::NotRegistered),
            (false, Some(_)) => Ok(()),
        }
    }

    fn send(&mut self, wait: Wait, command: Command, data: Bytes, now: Duration) -> Call {
        let call = Call(self.next);
        self.next += 1;
        let frame = Frame::request(command, self.handle.unwrap_or_default(), call.0.to_le_bytes(), data);
        self.transmits.push_back(frame.to_bytes());
        self.pending.insert(
            call,
            Pending {
                wait,
                command,
                deadline: now + self.timeout,
            },
        );
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
        let Some(connection) = self.connections.get_mut(&key) else {
            return;
        };
        if connection.outstanding.is_some() {
            return;
        }
        let Some((call, message)) = connection.backlog.pop_front() else {
            return;
        };
        connection.sequence = connection.sequence.wrapping_add(1);
        connection.outstanding = Some(call);
        let packet = Packet::connected(connection.o_to_t_id, connection.sequence, &message);
        let handle = self.handle.unwrap_or_default();
        let frame = Frame::request(Command::SEND_UNIT_DATA, handle, call.0.to_le_bytes(), packet.to_bytes());
        self.transmits.push_back(frame.to_bytes());
    }

    /// By sender context; on a connection by its id and sequence count, since a target may not echo the context there.
    fn match_reply(&self, frame: &Frame) -> Option<Call> {
        if frame.header.command == Command::SEND_UNIT_DATA && frame.header.status == EncapStatus::SUCCESS {
            let (id, sequence, _) = Packet::decode(&frame.data).ok()?.connected_message().ok()?;
            let connection = self
                .connections
                .values()
                .find(|connection| connection.t_to_o_id == id)?;
            return connection.outstanding.filter(|_| connection.sequence == sequence);
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
        let mut path = options.route;
        path.0.extend(Epath::object(class::MESSAGE_ROUTER, 1).0);
        let connection = Connection {
            o_to_t_id: opened.o_to_t_id,
            t_to_o_id: opened.t_to_o_id,
            sequence: 0,
            path,
            outstanding: None,
            backlog: VecDeque::new(),
        };
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

    /// Forgets a connection; what waits on it fails.
    fn give_up(&mut self, key: ConnectionKey, error: ClientError) {
        let Some(connection) = self.connections.remove(&key) else {
            return;
        };
        let waiting = connection.backlog.into_iter().map(|(call, _)| call);
        for call in connection.outstanding.into_iter().chain(waiting) {
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

fn unconnected_reply(frame: &Frame) -> Result<Reply, ClientError> {
    let packet = Packet::decode(&frame.data)?;
    Reply::decode(packet.unconnected_message()?).ok_or(ClientError::Malformed(Command::SEND_RR_DATA))
}

fn connected_reply(frame: &Frame) -> Result<Reply, ClientError> {
    let (_, _, message) = Packet::decode(&frame.data)?.connected_message()?;
    Reply::decode(&message).ok_or(ClientError::Malformed(Command::SEND_UNIT_DATA))
}

fn identity(data: &Bytes) -> Option<(SocketAddrV4, Identity)> {
    decode_items(data).ok()?.iter().find_map(|item| match item {
        Item::Identity(data) => Identity::decode_item(data),
        _ => None,
    })
}
