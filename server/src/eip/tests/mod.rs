//! The interface over in-memory streams and real sockets, with the controller's real thread behind it.

mod allow;
mod attributes;
mod audited;
mod browse;
mod clock;
mod costs;
mod counts;
mod hostile;
mod io;
mod loss;
mod machine;
mod motion;
mod object_table;
mod objects;
mod pitfalls;
mod published;
mod race;
pub(crate) mod roles;
mod rules;
mod security;
mod series;
mod sessions;
mod stock_clients;
mod tag_interface;
mod tag_services;
mod tag_table;
mod trace;

use std::net::{IpAddr, Ipv4Addr, SocketAddrV4};
use std::sync::Arc;
use std::time::Duration;

use arcline_config::{IoListen, ServerConfig};
use arcline_proto::cip::{CipStatus, Reply, Request, service};
use arcline_proto::connection::{
    ConnectionKey, ForwardClose, ForwardOpen, ForwardOpenReply, NetworkParameters, TRANSPORT_CLASS_3, TickTime,
};
use arcline_proto::cpf::{ConnectionId, Packet};
use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, MAX_DATA, RegisterSession, SessionHandle};
use arcline_proto::epath::Epath;
use arcline_proto::logix::{ReadReply, ReadTag, WireType, WriteTag};
use arcline_realtime::Handle;
use arcline_tag::TagPath;
use bytes::{Bytes, BytesMut};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};

use super::connection;
use super::device::{Device, Settings};
use super::io::IoThread;
use crate::plant::Plant;
use crate::work_threads::WorkThreads;

/// The local address of the in-memory streams.
const LOCAL: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 44818);
/// The peer's address of the in-memory streams.
const PEER: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// Longer than any step of these tests may take on a slow machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// The default configuration and plain tags of every type.
const TAGS: &str = r#"
[[tag]]
name = "aBool"
type = "BOOL"
[[tag]]
name = "aSint"
type = "SINT"
[[tag]]
name = "aInt"
type = "INT"
[[tag]]
name = "aDint"
type = "DINT"
[[tag]]
name = "aLint"
type = "LINT"
[[tag]]
name = "aUsint"
type = "USINT"
[[tag]]
name = "aUint"
type = "UINT"
[[tag]]
name = "aUdint"
type = "UDINT"
[[tag]]
name = "aReal"
type = "REAL"
[[tag]]
name = "aLreal"
type = "LREAL"
[[tag]]
name = "aString"
type = "STRING"
[[tag]]
name = "Dints"
type = "DINT[3000]"
[[tag]]
name = "Bools"
type = "BOOL[64]"
[[tag]]
name = "Strings"
type = "STRING[3]"

# In a program's scope, structures, several dimensions, aliases.
[[data_type]]
name = "Point"
members = [{ name = "At", type = "REAL[2]" }, { name = "Valid", type = "BOOL" }, { name = "Id", type = "SINT" }]
[[data_type]]
name = "Route"
members = [{ name = "Name", type = "STRING" }, { name = "Points", type = "Point[2]" }]
[[tag]]
name = "Grid"
type = "INT[2,3]"
value = [[1, 2, 3], [4, 5, 6]]
[[tag]]
name = "Routes"
type = "Route[2]"
[[tag]]
name = "Count"
program = "Main"
type = "DINT"
value = 7
[[tag]]
name = "aDint"
program = "Main"
type = "LINT"
access = "read_only"
value = 9
[[tag]]
name = "Valid"
alias = "Routes[1].Points[0].Valid"
[[tag]]
name = "Row"
alias = "Grid[1,0]"
"#;

/// A device whose controller runs.
pub(super) struct Bench {
    pub(super) device: Arc<Device>,
    _io: Option<IoThread>,
    _thread: Handle,
}

pub(super) fn project() -> arcline_config::Project {
    let text = format!("{}{TAGS}", arcline_config::DEFAULT);
    let mut project = arcline_config::load(&text, "test").expect("a valid configuration");
    // Silent jogs have tests of their own; the clients of other tests may be slow.
    project.server.jog_silence = 0;
    project
}

pub(super) fn plant() -> (Plant, Handle) {
    Plant::start(&project()).expect("a thread")
}

/// The defaults under a product name, without implicit I/O.
pub(super) fn settings_of(name: &str) -> Settings {
    Settings::new(&ServerConfig {
        name: name.to_owned(),
        io: IoListen::Off,
        ..ServerConfig::default()
    })
}

impl Bench {
    pub(super) fn new() -> Self {
        Self::with(|_| {})
    }

    pub(super) fn with(change: impl FnOnce(&mut Settings)) -> Self {
        let mut settings = settings_of("Bench");
        change(&mut settings);
        Self::of(plant(), settings)
    }

    pub(super) fn of((plant, thread): (Plant, Handle), settings: Settings) -> Self {
        let device = Arc::new(Device::new(plant, settings, WorkThreads::Pool).expect("a free port"));
        let io = device.io().cloned();
        Self {
            _io: io.map(|io| IoThread::spawn(device.clone(), io).expect("a thread")),
            device,
            _thread: thread,
        }
    }

    /// A stream that the device serves.
    pub(super) fn stream(&self) -> DuplexStream {
        let (ours, theirs) = tokio::io::duplex(64 * 1024);
        tokio::spawn(connection::serve(theirs, LOCAL, PEER, self.device.clone()));
        ours
    }

    /// A client with a session.
    pub(super) async fn client(&self) -> Client {
        self.client_on(self.stream()).await
    }

    /// A client with a session on a stream.
    pub(super) async fn client_on(&self, stream: DuplexStream) -> Client {
        Client::register(stream).await
    }
}

/// The other end of a connection.
pub(super) struct Client {
    pub(super) stream: DuplexStream,
    pub(super) buf: BytesMut,
    pub(super) session: SessionHandle,
}

/// A class 3 connection.
pub(super) struct Connected {
    pub(super) id: ConnectionId,
    pub(super) sequence: u16,
    pub(super) key: ConnectionKey,
}

const CONTEXT: [u8; 8] = *b"context!";

impl Client {
    /// A client with a session on a stream.
    pub(super) async fn register(stream: DuplexStream) -> Self {
        let mut client = Client {
            stream,
            buf: BytesMut::new(),
            session: SessionHandle(0),
        };
        let reply = client
            .exchange(Command::REGISTER_SESSION, RegisterSession::CURRENT.to_bytes())
            .await;
        client.session = reply.header.session;
        client
    }

    pub(super) async fn send(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).await.expect("the device reads");
    }

    /// The next frame; `None` when the device closed the stream.
    pub(super) async fn frame(&mut self) -> Option<EncapFrame> {
        let read = async {
            loop {
                if let Some(frame) = FrameDecoder::new(MAX_DATA).decode(&mut self.buf).expect("a frame") {
                    return Some(frame);
                }
                if self.stream.read_buf(&mut self.buf).await.unwrap_or(0) == 0 {
                    return None;
                }
            }
        };
        tokio::time::timeout(PATIENCE, read).await.expect("an answer in time")
    }

    pub(super) async fn exchange(&mut self, command: Command, data: Bytes) -> EncapFrame {
        let frame = EncapFrame::request(command, self.session, CONTEXT, data);
        self.send(&frame.to_bytes()).await;
        let reply = self.frame().await.expect("an answer");
        assert_eq!(
            (reply.header.command, reply.header.context),
            (command, CONTEXT),
            "the reply belongs to the request"
        );
        reply
    }

    /// A message of any bytes without connection.
    pub(super) async fn raw(&mut self, message: Bytes) -> Reply {
        let frame = self
            .exchange(Command::SEND_RR_DATA, Packet::unconnected(message).to_bytes())
            .await;
        let packet = Packet::decode(&frame.data).expect("a packet");
        Reply::decode(packet.unconnected_message().expect("a message")).expect("a reply")
    }

    pub(super) async fn ask(&mut self, request: &Request) -> Reply {
        self.raw(request.to_bytes().expect("a short path")).await
    }

    pub(super) async fn open(&mut self, size: u16, serial: u16) -> Connected {
        let key = ConnectionKey {
            serial,
            vendor: 0x1337,
            originator: 42,
        };
        let reply = self.ask(&forward_open(size, key)).await;
        assert!(reply.status.is_success(), "Forward Open: {}", reply.status);
        let open = ForwardOpenReply::decode(&reply.data).expect("a Forward Open reply");
        Connected {
            id: open.o_to_t_id,
            sequence: 0,
            key,
        }
    }

    pub(super) async fn close(&mut self, connected: &Connected) -> Reply {
        let close = ForwardClose {
            time: TickTime::DEFAULT,
            key: connected.key,
            path: Epath::object(2, 1),
        };
        self.ask(&Request::new(
            service::FORWARD_CLOSE,
            Epath::object(6, 1),
            close.to_bytes().expect("short"),
        ))
        .await
    }

    pub(super) async fn ask_connected(&mut self, connected: &mut Connected, request: &Request) -> Reply {
        connected.sequence = connected.sequence.wrapping_add(1);
        self.repeat(connected, request).await
    }

    /// Sends with the sequence count of the last message.
    pub(super) async fn repeat(&mut self, connected: &Connected, request: &Request) -> Reply {
        let message = request.to_bytes().expect("a short path");
        let packet = Packet::connected(connected.id, connected.sequence, &message);
        let frame = self.exchange(Command::SEND_UNIT_DATA, packet.to_bytes()).await;
        connected_reply(&frame, connected)
    }

    pub(super) async fn read(&mut self, tag: &str) -> ReadReply {
        let reply = self.ask(&read(tag, 1)).await;
        assert!(reply.status.is_success(), "{tag}: {}", reply.status);
        ReadReply::decode(&reply.data).expect("a value")
    }

    pub(super) async fn write(&mut self, tag: &str, data_type: WireType, data: &[u8]) -> CipStatus {
        self.ask(&write(tag, data_type, 1, data)).await.status
    }
}

/// The reply in a frame to the last message of a connection.
pub(super) fn connected_reply(frame: &EncapFrame, connected: &Connected) -> Reply {
    let (_, sequence, message) = Packet::decode(&frame.data)
        .expect("a packet")
        .connected_message()
        .expect("class 3");
    assert_eq!(sequence, connected.sequence);
    Reply::decode(&message).expect("a reply")
}

pub(super) fn path(tag: &str) -> Epath {
    Epath::from_tag(&tag.parse::<TagPath>().expect("a tag path")).0
}

pub(super) fn read(tag: &str, elements: u16) -> Request {
    Request::new(service::READ_TAG, path(tag), ReadTag { elements, offset: 0 }.to_bytes())
}

pub(super) fn write(tag: &str, data_type: WireType, elements: u16, data: &[u8]) -> Request {
    let write = WriteTag {
        data_type,
        elements,
        offset: 0,
        data: Bytes::copy_from_slice(data),
    };
    Request::new(service::WRITE_TAG, path(tag), write.to_bytes())
}

pub(super) fn forward_open(size: u16, key: ConnectionKey) -> Request {
    let open = ForwardOpen {
        time: TickTime::DEFAULT,
        o_to_t_id: ConnectionId(0),
        t_to_o_id: ConnectionId(0x0102_0304),
        key,
        multiplier: 7,
        o_to_t_rpi: 2_000_000,
        o_to_t: NetworkParameters::explicit(size),
        t_to_o_rpi: 2_000_000,
        t_to_o: NetworkParameters::explicit(size),
        transport: TRANSPORT_CLASS_3,
        path: Epath::object(2, 1),
    };
    let data = open.to_bytes(true).expect("a short path");
    Request::new(service::LARGE_FORWARD_OPEN, Epath::object(6, 1), data)
}

/// General status and first additional word (0 if there is none).
pub(super) fn codes(status: CipStatus) -> (u8, u16) {
    (status.general(), status.additional().first().copied().unwrap_or(0))
}
