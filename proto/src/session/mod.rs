//! The server's side of one TCP connection, without I/O: sessions, unconnected messages, and class 3 connections
//! (spec/ethernet-ip.md §2, §7, §8, §18).
//!
//! Bytes go in by [`ServerSession::handle_input`], [`Event`]s come out of [`ServerSession::poll_event`]. The application
//! answers each [`Event::Request`] once by [`ServerSession::reply`]; replies leave in the order of the requests, in whatever
//! order the answers come. `now` is the time since any fixed moment; it never runs backwards. Random numbers, shared
//! limits and counters are the [`Host`]'s.

mod connection_manager;
mod connections;
mod host;
mod replies;
mod route;
mod settings;
#[cfg(feature = "test-util")]
mod test_host;

use bytes::{Bytes, BytesMut};
use std::collections::VecDeque;
use std::net::SocketAddrV4;
use std::sync::Arc;
use std::time::Duration;

use self::connection_manager::Managed;
use self::connections::{Arrival, Connections};
use self::host::nonzero;
use self::replies::{Replies, ReplyRoute};
use self::route::unwrap_route;
use crate::cip::{Reply, Request};
use crate::cpf::{ConnectionId, Item, Packet};
use crate::discovery::list_reply;
use crate::encap::{
    Command, EncapFrame, EncapFrameError, EncapStatus, FrameDecoder, Header, RegisterSession, SessionHandle,
};

pub use self::connection_manager::MIN_CONNECTION_SIZE;
pub use self::host::{ConnectionEnd, Host, IoOpen, IoOpened};
pub use self::replies::RequestId;
pub use self::route::Slots;
pub use self::settings::{Settings, UnknownConnection};
#[cfg(feature = "test-util")]
pub use self::test_host::{Draws, TestHost, TestIo};

/// A request of the session to its application.
#[derive(Clone, PartialEq, Debug)]
pub enum Event {
    /// Send this to the peer.
    Outgoing(Bytes),
    /// Execute this and answer it by [`ServerSession::reply`].
    Request {
        /// Name for the answer.
        id: RequestId,
        /// The message. A Multiple Service Packet comes whole.
        request: Request,
        /// The longest router reply, bytes with its head.
        reply_budget: usize,
        /// The transport on which it came.
        transport: Transport,
    },
    /// The reply of this I/O connection's Forward Open is among the bytes to send: send them, then let the connection
    /// produce.
    IoReady(ConnectionId),
    /// Send the remaining bytes, then close the socket. It is the last event.
    Close(CloseReason),
}

/// The transport of a request.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Transport {
    /// SendRRData; a stray route may follow the data ([`crate::cip::is_stray_route`]).
    Unconnected,
    /// The class 3 connection of this O→T id.
    Connected(ConnectionId),
}

/// The reason for the end of a session.
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
    EncapFrame(#[from] EncapFrameError),
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

/// The server's side of one TCP connection.
#[derive(Debug)]
pub struct ServerSession {
    settings: Arc<Settings>,
    local: SocketAddrV4,
    life: Life,
    /// Silence after which the session ends; `None`: never.
    inactivity: Option<Duration>,
    connections: Connections,
    replies: Replies,
    events: VecDeque<Event>,
    unknown_connections: u64,
}

impl ServerSession {
    /// A session on a socket just accepted at address `local` (the address that ListIdentity shows).
    pub fn new(settings: Arc<Settings>, local: SocketAddrV4, now: Duration) -> Self {
        let until = now + settings.register_timeout;
        Self {
            inactivity: settings.inactivity,
            settings,
            local,
            life: Life::Fresh { until },
            connections: Connections::default(),
            replies: Replies::default(),
            events: VecDeque::new(),
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
                    let EncapFrameError::TooLong { header, .. } = error;
                    self.replies.clear();
                    self.push_ready(EncapFrame::error(&header, EncapStatus::INVALID_LENGTH));
                    self.close(CloseReason::EncapFrame(error), host);
                }
            }
        }
    }

    /// Whether more input is taken: the session is open and not too many requests wait for answers.
    pub fn wants_input(&self) -> bool {
        self.life != Life::Closed && self.replies.len() < self.settings.max_pending.max(1)
    }

    /// Takes one frame.
    pub fn handle_frame(&mut self, frame: &EncapFrame, now: Duration, host: &mut dyn Host) {
        if self.life == Life::Closed {
            return;
        }
        self.connections.expire(now, host);
        if let Life::Registered { heard, .. } = &mut self.life {
            *heard = now;
        }
        let header = &frame.header;
        if header.status != EncapStatus::SUCCESS || header.options != 0 {
            return;
        }
        match header.command {
            Command::NOP => {}
            Command::REGISTER_SESSION
            | Command::UNREGISTER_SESSION
            | Command::SEND_RR_DATA
            | Command::SEND_UNIT_DATA
                if self.settings.discovery_only =>
            {
                self.push_ready(EncapFrame::error(header, EncapStatus::NOT_ALLOWED_ON_PORT));
            }
            Command::REGISTER_SESSION => self.register(frame, now, host),
            Command::UNREGISTER_SESSION => match self.check_session(header) {
                Ok(()) => self.close(CloseReason::Unregistered, host),
                Err(status) => self.push_ready(EncapFrame::error(header, status)),
            },
            Command::SEND_RR_DATA => self.send_rr_data(frame, now, host),
            Command::SEND_UNIT_DATA => self.send_unit_data(frame, now, host),
            command => {
                let reply = match list_reply(command, host.identity(), self.settings.capability, self.local) {
                    Some(data) => EncapFrame::reply(header, data),
                    None => EncapFrame::error(header, EncapStatus::INVALID_COMMAND),
                };
                self.push_ready(reply);
            }
        }
    }

    /// Answers a request. A reply beyond the budget becomes 0x11. `false`: there is no such request, or it has been
    /// answered.
    pub fn reply(&mut self, id: RequestId, reply: &Reply, now: Duration) -> bool {
        self.answer(id, reply, None, now)
    }

    fn answer(&mut self, id: RequestId, reply: &Reply, io: Option<&IoOpened>, now: Duration) -> bool {
        let Some((route, packet)) = self.replies.answer(id, reply, io) else {
            return false;
        };
        if let ReplyRoute::Connected { id, sequence, .. } = route {
            self.connections.answered(id, sequence, &packet, now);
        }
        self.flush();
        true
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// When [`Self::handle_timeout`] is due; ask again after every call that changes the session.
    pub fn poll_timeout(&self) -> Option<Duration> {
        if self.life == Life::Closed {
            return None;
        }
        self.connections
            .deadline()
            .into_iter()
            .chain(self.life_deadline())
            .min()
    }

    /// Drops connections whose watchdog has expired, and the session if it was silent for too long.
    pub fn handle_timeout(&mut self, now: Duration, host: &mut dyn Host) {
        self.connections.expire(now, host);
        if self.life_deadline().is_some_and(|deadline| deadline <= now) {
            let reason = match self.life {
                Life::Fresh { .. } => CloseReason::NotRegistered,
                Life::Registered { .. } | Life::Closed => CloseReason::Inactive,
            };
            self.close(reason, host);
        }
    }

    /// Sets the silence after which the session ends, from the last frame on; `None`: never. Ask
    /// [`Self::poll_timeout`] anew.
    pub fn set_inactivity(&mut self, time: Option<Duration>) {
        self.inactivity = time;
    }

    /// The socket has gone: frees the connections. Events that are left need not be polled.
    pub fn handle_disconnect(&mut self, host: &mut dyn Host) {
        self.life = Life::Closed;
        self.replies.clear();
        self.connections.clear(host);
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

    /// The time at which the session ends if no bytes arrive; none while a request is being executed.
    fn life_deadline(&self) -> Option<Duration> {
        match self.life {
            Life::Fresh { until } => Some(until),
            Life::Registered { heard, .. } if self.replies.is_empty() => self.inactivity.map(|time| heard + time),
            Life::Registered { .. } | Life::Closed => None,
        }
    }

    fn check_session(&self, header: &Header) -> Result<(), EncapStatus> {
        match self.life {
            Life::Registered { handle, .. } if handle == header.session => Ok(()),
            _ => Err(EncapStatus::INVALID_SESSION),
        }
    }

    fn register(&mut self, frame: &EncapFrame, now: Duration, host: &mut dyn Host) {
        let header = &frame.header;
        let reply = match (self.life, RegisterSession::decode(&frame.data)) {
            (Life::Registered { .. }, _) => EncapFrame::error(header, EncapStatus::INVALID_COMMAND),
            (_, None) => EncapFrame::error(header, EncapStatus::INVALID_LENGTH),
            (_, Some(RegisterSession::CURRENT)) => match nonzero(host, |_| true).map(SessionHandle) {
                Some(session) => {
                    self.life = Life::Registered {
                        handle: session,
                        heard: now,
                    };
                    EncapFrame::reply(&Header { session, ..*header }, RegisterSession::CURRENT.to_bytes())
                }
                None => EncapFrame::error(header, EncapStatus::NO_MEMORY),
            },
            (_, Some(_)) => {
                let mut reply = EncapFrame::reply(header, RegisterSession::CURRENT.to_bytes());
                reply.header.status = EncapStatus::UNSUPPORTED_VERSION;
                reply
            }
        };
        self.push_ready(reply);
    }

    fn send_rr_data(&mut self, frame: &EncapFrame, now: Duration, host: &mut dyn Host) {
        let header = frame.header;
        if let Err(status) = self.check_session(&header) {
            return self.push_ready(EncapFrame::error(&header, status));
        }
        let packet = Packet::decode(&frame.data);
        let message = packet.and_then(|packet| Ok((packet.unconnected_message()?.clone(), originator_port(&packet))));
        match message {
            Ok((message, port)) => {
                let route = ReplyRoute::Unconnected {
                    budget: self.settings.unconnected_reply_limit,
                };
                self.message(header, route, &message, port, now, host);
            }
            Err(_) => self.push_ready(EncapFrame::error(&header, EncapStatus::INCORRECT_DATA)),
        }
    }

    fn send_unit_data(&mut self, frame: &EncapFrame, now: Duration, host: &mut dyn Host) {
        let header = frame.header;
        if let Err(status) = self.check_session(&header) {
            return self.push_ready(EncapFrame::error(&header, status));
        }
        let Ok((id, sequence, message)) = Packet::decode_connected(&frame.data) else {
            return self.push_ready(EncapFrame::error(&header, EncapStatus::INCORRECT_DATA));
        };
        match self.connections.receive(id, sequence, now) {
            Some(Arrival::New { t_to_o_id, budget }) => {
                let route = ReplyRoute::Connected {
                    id,
                    t_to_o_id,
                    sequence,
                    budget,
                };
                self.message(header, route, &message, None, now, host);
            }
            Some(Arrival::Answered(packet)) => self.push_ready(EncapFrame::reply(&header, packet)),
            Some(Arrival::InProgress) => self.replies.repeat(header, id, sequence),
            None => {
                self.unknown_connections += 1;
                if self.settings.unknown_connection == UnknownConnection::Close {
                    self.close(CloseReason::UnknownConnection, host);
                }
            }
        }
    }

    /// Adds a message to the order of replies; answers it if it is for the Connection Manager.
    fn message(
        &mut self,
        header: Header,
        route: ReplyRoute,
        message: &Bytes,
        port: Option<u16>,
        now: Duration,
        host: &mut dyn Host,
    ) {
        let outcome = Request::decode(message)
            .map_err(|error| error.reply())
            .and_then(|request| unwrap_route(request, &self.settings.slots))
            .map_err(Managed::from)
            .and_then(|request| self.connections.manage(request, port, &self.settings, now, host));
        match outcome {
            Ok(request) => {
                let id = self.replies.wait(request.service, header, route);
                self.events.push_back(Event::Request {
                    id,
                    request,
                    reply_budget: route.budget(),
                    transport: route.transport(),
                });
            }
            Err(Managed { reply, io }) => {
                let id = self.replies.wait(reply.service, header, route);
                self.answer(id, &reply, io.as_ref(), now);
            }
        }
    }

    /// Drops the waiting requests; replies that have left their order are still sent.
    fn close(&mut self, reason: CloseReason, host: &mut dyn Host) {
        self.replies.clear();
        self.connections.clear(host);
        self.life = Life::Closed;
        self.events.push_back(Event::Close(reason));
    }

    fn push_ready(&mut self, frame: EncapFrame) {
        self.replies.push(frame);
        self.flush();
    }

    /// Lets the replies at the front go.
    fn flush(&mut self) {
        while let Some((frame, io)) = self.replies.pop(&self.connections) {
            self.events.push_back(Event::Outgoing(frame));
            self.events.extend(io.map(Event::IoReady));
        }
    }
}

/// The UDP port in item 0x8001. Its address is not looked at: that of the TCP connection counts.
fn originator_port(packet: &Packet) -> Option<u16> {
    packet.items.iter().find_map(|item| match item {
        Item::SockaddrTToO(address) => Some(address.port()),
        _ => None,
    })
}
