//! A client of the simulation: sessions, messages with and without connection, and the guarantees to its user: each request has one answer, in
//! time, or the connection ends.

use std::fmt;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::time::Duration;

use arcline_instruction_set::Mnemonic;
use arcline_proto::arcline::machine;
use arcline_proto::cip::{Reply, Request, join_multiple, service, split_multiple_replies};
use arcline_proto::connection::{
    ConnectionKey, ForwardClose, ForwardOpen, ForwardOpenReply, NetworkParameters, TRANSPORT_CLASS_3, TickTime,
};
use arcline_proto::cpf::{ConnectionId, Item, Packet};
use arcline_proto::encap::{Command, EncapFrame, EncapStatus, FrameDecoder, MAX_DATA, RegisterSession, SessionHandle};
use arcline_proto::epath::Epath;
use arcline_proto::logix::{ReadReply, ReadTag, Typed, WireType, WriteTag, encode_operands};
use arcline_tag::{Elementary, TagPath, Value};
use bytes::{Bytes, BytesMut};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

use crate::actors::{Alive, InTime};
use crate::network::End;

pub(crate) const DINT: WireType = WireType::Atomic(0xC4);
pub(crate) const REAL: WireType = WireType::Atomic(0xCA);
pub(crate) const BOOL: WireType = WireType::Atomic(0xC1);

/// A client with a session.
pub(crate) struct Client {
    pub(crate) end: End,
    buf: BytesMut,
    session: SessionHandle,
    context: u64,
    in_time: InTime,
    /// Its session, and the connections that it opened.
    pub(crate) alive: Vec<Alive>,
}

/// A class 3 connection.
pub(crate) struct Connected {
    id: ConnectionId,
    sequence: u16,
    key: ConnectionKey,
}

impl Connected {
    /// The id that the server gave.
    pub(crate) fn id(&self) -> u32 {
        self.id.0
    }
}

/// The reason for which a client has no answer.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum NoAnswer {
    /// The connection has ended.
    Ended,
    /// No answer came within [`PATIENCE_MS`].
    Late,
    /// An answer that belongs to no request, or that cannot be read.
    Wrong(String),
    /// The encapsulation refused the request.
    Refused(u32),
}

impl fmt::Display for NoAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoAnswer::Ended => f.write_str("the connection ended"),
            NoAnswer::Late => f.write_str("no answer"),
            NoAnswer::Wrong(why) => write!(f, "a wrong answer: {why}"),
            NoAnswer::Refused(status) => write!(f, "refused with 0x{status:02X}"),
        }
    }
}

/// Longer than any answer takes, ms: the server gives up a write after 5 s, and a partition is shorter than that.
pub(crate) const PATIENCE_MS: u64 = 14_000;

pub(crate) type Answer<T> = Result<T, NoAnswer>;

impl Client {
    /// Registers a session. All of its answers come in time.
    pub(crate) async fn register(end: End, in_time: InTime) -> Answer<Client> {
        let mut client = Client {
            in_time,
            end,
            buf: BytesMut::new(),
            session: SessionHandle(0),
            context: 0,
            alive: Vec::new(),
        };
        let reply = client
            .exchange(Command::REGISTER_SESSION, RegisterSession::CURRENT.to_bytes())
            .await?;
        client.session = reply.header.session;
        Ok(client)
    }

    /// The handle of the session.
    pub(crate) fn session(&self) -> u32 {
        self.session.0
    }

    pub(crate) async fn send(&mut self, bytes: &[u8]) -> Answer<()> {
        self.end.write_all(bytes).await.map_err(|_| NoAnswer::Ended)
    }

    /// The next frame.
    pub(crate) async fn frame(&mut self) -> Answer<EncapFrame> {
        let read = async {
            loop {
                match FrameDecoder::new(MAX_DATA).decode(&mut self.buf) {
                    Ok(Some(frame)) => return Ok(frame),
                    Ok(None) => {}
                    Err(error) => return Err(NoAnswer::Wrong(error.to_string())),
                }
                match self.end.read_buf(&mut self.buf).await {
                    Ok(0) | Err(_) => return Err(NoAnswer::Ended),
                    Ok(_) => {}
                }
            }
        };
        tokio::time::timeout(Duration::from_millis(PATIENCE_MS), read)
            .await
            .unwrap_or(Err(NoAnswer::Late))
    }

    fn request(&mut self, command: Command, data: Bytes) -> EncapFrame {
        self.context += 1;
        EncapFrame::request(command, self.session, self.context.to_le_bytes(), data)
    }

    /// Sends a request and does not wait for its answer.
    pub(crate) async fn send_request(&mut self, request: &Request) -> Answer<()> {
        let message = request.to_bytes().map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        let frame = self.request(Command::SEND_RR_DATA, Packet::unconnected(message).to_bytes());
        self.send(&frame.to_bytes()).await
    }

    async fn exchange(&mut self, command: Command, data: Bytes) -> Answer<EncapFrame> {
        let asked = self.in_time.now();
        let frame = self.request(command, data);
        self.send(&frame.to_bytes()).await?;
        let reply = self.frame().await?;
        self.in_time.judge(asked, frame.data.len() + reply.data.len());
        if (reply.header.command, reply.header.context) != (command, frame.header.context) {
            return Err(NoAnswer::Wrong("it belongs to another request".to_owned()));
        }
        if reply.header.status != EncapStatus::SUCCESS {
            return Err(NoAnswer::Refused(reply.header.status.0));
        }
        Ok(reply)
    }

    /// As [`Client::ask`] under the handle of another session.
    pub(crate) async fn ask_as(&mut self, session: u32, request: &Request) -> Answer<Reply> {
        let own = std::mem::replace(&mut self.session, SessionHandle(session));
        let reply = self.ask(request).await;
        self.session = own;
        reply
    }

    /// Sends a message without connection.
    pub(crate) async fn ask(&mut self, request: &Request) -> Answer<Reply> {
        let message = request.to_bytes().map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        let frame = self
            .exchange(Command::SEND_RR_DATA, Packet::unconnected(message).to_bytes())
            .await?;
        let packet = Packet::decode(&frame.data).map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        let message = packet
            .unconnected_message()
            .map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        Reply::decode(message).ok_or_else(|| NoAnswer::Wrong("no reply".to_owned()))
    }

    /// Opens a class 3 connection with a time-out of 512 times its interval of 4 ms, about 2 s. Its sequence counts come behind `first`.
    pub(crate) async fn open(&mut self, serial: u16, first: u16) -> Answer<Option<Connected>> {
        let key = ConnectionKey {
            serial,
            vendor: 0x1337,
            originator: 42,
        };
        let open = ForwardOpen {
            time: TickTime::DEFAULT,
            o_to_t_id: ConnectionId(0),
            t_to_o_id: ConnectionId(0x0102_0304),
            key,
            multiplier: 4,
            o_to_t_rpi: 32_000,
            o_to_t: NetworkParameters::explicit(500),
            t_to_o_rpi: 32_000,
            t_to_o: NetworkParameters::explicit(500),
            transport: TRANSPORT_CLASS_3,
            path: Epath::object(2, 1),
        };
        let Some(data) = open.to_bytes(true).ok() else {
            return Ok(None);
        };
        let request = Request::new(service::LARGE_FORWARD_OPEN, Epath::object(6, 1), data);
        let reply = self.ask(&request).await?;
        if !reply.status.is_success() {
            return Ok(None);
        }
        let open = ForwardOpenReply::decode(&reply.data).ok_or_else(|| NoAnswer::Wrong("Forward Open".to_owned()))?;
        Ok(Some(Connected {
            id: open.o_to_t_id,
            sequence: first,
            key,
        }))
    }

    /// Opens a connection of implicit I/O whose datagrams are to come to a port. `None`: it was refused.
    pub(crate) async fn open_io(&mut self, open: &ForwardOpen, port: u16) -> Answer<Option<ForwardOpenReply>> {
        let wrong = |what: &str| NoAnswer::Wrong(what.to_owned());
        let data = open
            .to_bytes(false)
            .map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        let request = Request::new(service::FORWARD_OPEN, Epath::object(6, 1), data);
        let message = request.to_bytes().map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        let mut packet = Packet::unconnected(message);
        let here = SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, port);
        packet.items.push(Item::SockaddrTToO(here));
        let frame = self.exchange(Command::SEND_RR_DATA, packet.to_bytes()).await?;
        let packet = Packet::decode(&frame.data).map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        let message = packet.unconnected_message().map_err(|_| wrong("no message"))?;
        let reply = Reply::decode(message).ok_or_else(|| wrong("no reply"))?;
        if !reply.status.is_success() {
            return Ok(None);
        }
        let opened = ForwardOpenReply::decode(&reply.data).ok_or_else(|| wrong("Forward Open"))?;
        Ok(Some(opened))
    }

    pub(crate) async fn close(&mut self, connected: Connected) -> Answer<()> {
        self.forward_close(connected.key).await
    }

    /// Asks to close a connection whose serial number none of this client's connections has; whether it was refused.
    pub(crate) async fn is_close_refused(&mut self, connected: &Connected, serial: u16) -> Answer<bool> {
        let key = ConnectionKey {
            serial,
            ..connected.key
        };
        let reply = self.close_with(key).await?;
        Ok(!reply.status.is_success())
    }

    /// Closes the connection of a key.
    pub(crate) async fn forward_close(&mut self, key: ConnectionKey) -> Answer<()> {
        self.close_with(key).await.map(drop)
    }

    async fn close_with(&mut self, key: ConnectionKey) -> Answer<Reply> {
        let close = ForwardClose {
            time: TickTime::DEFAULT,
            key,
            path: Epath::object(2, 1),
        };
        let data = close.to_bytes().map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        self.ask(&Request::new(service::FORWARD_CLOSE, Epath::object(6, 1), data))
            .await
    }

    pub(crate) async fn ask_connected(&mut self, connected: &mut Connected, request: &Request) -> Answer<Reply> {
        connected.sequence = connected.sequence.wrapping_add(1);
        self.ask_with_last_count(connected, request).await
    }

    /// As [`Client::ask_connected`], with the sequence count of the message before.
    pub(crate) async fn ask_with_last_count(&mut self, connected: &Connected, request: &Request) -> Answer<Reply> {
        let message = request.to_bytes().map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        let packet = Packet::connected(connected.id, connected.sequence, &message);
        let frame = self.exchange(Command::SEND_UNIT_DATA, packet.to_bytes()).await?;
        let wrong = || NoAnswer::Wrong("a connected reply".to_owned());
        let packet = Packet::decode(&frame.data).map_err(|_| wrong())?;
        let (_, sequence, message) = packet.connected_message().map_err(|_| wrong())?;
        if sequence != connected.sequence {
            return Err(NoAnswer::Wrong("the sequence count of another message".to_owned()));
        }
        Reply::decode(&message).ok_or_else(wrong)
    }

    /// Sends several requests as one message; `None`: the packet was refused.
    pub(crate) async fn ask_all(&mut self, requests: &[Request]) -> Answer<Option<Vec<Reply>>> {
        let reply = self.ask(&packet(requests)).await?;
        Ok(split_multiple_replies(&reply.data).filter(|replies| replies.len() == requests.len()))
    }

    /// Ends the session in order.
    pub(crate) async fn leave(mut self) {
        let frame = self.request(Command::UNREGISTER_SESSION, Bytes::new());
        let _ = self.send(&frame.to_bytes()).await;
    }
}

/// Several requests as one message.
pub(crate) fn packet(requests: &[Request]) -> Request {
    let data = join_multiple(requests).expect("the paths are short");
    Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data)
}

pub(crate) fn path(tag: &str) -> Epath {
    Epath::from_tag(&tag.parse::<TagPath>().expect("a tag path")).0
}

pub(crate) fn read(tag: &str, elements: u16) -> Request {
    Request::new(service::READ_TAG, path(tag), ReadTag { elements, offset: 0 }.to_bytes())
}

pub(crate) fn write(tag: &str, data_type: WireType, elements: u16, data: &[u8]) -> Request {
    let write = WriteTag {
        data_type,
        elements,
        offset: 0,
        data: Bytes::copy_from_slice(data),
    };
    Request::new(service::WRITE_TAG, path(tag), write.to_bytes())
}

/// A service of class 0x0305, Machine.
pub(crate) fn machine_service(code: u8) -> Request {
    Request::new(code, Epath::object(machine::CLASS, machine::INSTANCE), Bytes::new())
}

/// An instruction as a service of an object.
pub(crate) fn instruction(mnemonic: Mnemonic, instance: u32, control: &str, operands: &[f64]) -> Request {
    let (class, service) = mnemonic.instruction().service();
    let mut typed = vec![Typed::ShortString(control.to_owned())];
    typed.extend(
        operands
            .iter()
            .map(|number| Typed::Numbers(Elementary::Lreal, vec![Value::from_f64(Elementary::Lreal, *number)])),
    );
    let mut data = BytesMut::new();
    encode_operands(&typed, &mut data);
    Request::new(service, Epath::object(class, instance), data.freeze())
}

/// The bytes of a read tag.
pub(crate) fn value(reply: &Reply) -> Option<Bytes> {
    reply
        .status
        .is_success()
        .then(|| ReadReply::decode(&reply.data).map(|read| read.data))
        .flatten()
}

pub(crate) fn dint(reply: &Reply) -> Option<i32> {
    let bytes = value(reply)?;
    Some(i32::from_le_bytes(bytes.get(..4)?.try_into().ok()?))
}
