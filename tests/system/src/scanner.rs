//! A scanner: opens a class 1 connection to a server and exchanges data with it in cycles. Blocking, one thread.
//!
//! It knows the wire, by `arcline-proto`, and not the meaning of the assemblies. Sizes are those of the data.

use std::io::{ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, SocketAddrV4, TcpStream, UdpSocket};
use std::time::{Duration, Instant};

use arcline_proto::cip::{CipStatus, Reply, Request, service};
use arcline_proto::connection::{
    ConnectionKey, ConnectionType, ForwardClose, ForwardOpen, ForwardOpenReply, NetworkParameters, TickTime,
};
use arcline_proto::cpf::{ConnectionId, Item, Packet};
use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, MAX_DATA, RegisterSession, SessionHandle};
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::io::Datagram;
use bytes::{Bytes, BytesMut};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// The longest wait for a reply.
const REPLY: Duration = Duration::from_secs(20);

/// A session over TCP, for messages without connection.
pub struct Session {
    stream: TcpStream,
    buf: BytesMut,
    handle: SessionHandle,
}

/// The parameters of a connection.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Serial number of the connection.
    pub serial: u16,
    /// Connection points, originator to target and back.
    pub points: [u32; 2],
    /// Bytes of both assemblies; a heartbeat has 0 and is sent without a header.
    pub sizes: [u16; 2],
    /// Requested interval of both directions, µs.
    pub rpi: u32,
    /// Code of the timeout multiplier.
    pub multiplier: u8,
    /// The sending of its data.
    pub sent: Sent,
}

/// The sending of data to an originator.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sent {
    /// At the interval, to the originator.
    Alone,
    /// At the interval, to a group that the target names; the scanner does not join it.
    ToGroup,
    /// The same when data has changed, every 2 ms at most.
    ToGroupOnChange,
}

/// An open connection.
pub struct Connection {
    socket: UdpSocket,
    target: SocketAddr,
    id: ConnectionId,
    sequence: u32,
    wanted: Wanted,
    /// Intervals that the target confirmed, µs.
    pub confirmed: [u32; 2],
    /// The longest time in which [`Self::exchange`] did not read the socket, since the machine delayed it.
    pub longest_pause: Duration,
}

/// A datagram that came.
#[derive(Clone, Debug)]
pub struct Arrival {
    /// When it was taken from the socket.
    pub at: Instant,
    /// 32-bit sequence number.
    pub sequence: u32,
    /// 16-bit sequence count.
    pub count: u16,
    /// The assembly.
    pub data: Vec<u8>,
}

impl Session {
    /// Connects and registers.
    ///
    /// # Panics
    /// When the server does not answer.
    #[must_use]
    pub fn connect(server: SocketAddr) -> Self {
        let stream = TcpStream::connect(server).expect("the server listens");
        stream.set_read_timeout(Some(REPLY)).expect("a time-out");
        stream.set_nodelay(true).expect("a socket");
        let mut this = Self {
            stream,
            buf: BytesMut::new(),
            handle: SessionHandle(0),
        };
        let reply = this.exchange(Command::REGISTER_SESSION, RegisterSession::CURRENT.to_bytes());
        this.handle = reply.header.session;
        this
    }

    fn exchange(&mut self, command: Command, data: Bytes) -> EncapFrame {
        let request = EncapFrame::request(command, self.handle, *b"scanner\0", data);
        self.stream.write_all(&request.to_bytes()).expect("the server reads");
        let mut piece = [0; 4096];
        loop {
            if let Some(frame) = FrameDecoder::new(MAX_DATA).decode(&mut self.buf).expect("a frame") {
                return frame;
            }
            let length = match self.stream.read(&mut piece) {
                // A machine that was halted ends a wait with a limit.
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                answer => answer.expect("an answer in time"),
            };
            assert!(length > 0, "the server closed the connection");
            self.buf.extend_from_slice(&piece[..length]);
        }
    }

    /// Sends a message with further items behind it; the reply and its further items.
    ///
    /// # Panics
    /// When the server does not answer, or sends another reply.
    pub fn ask(&mut self, request: &Request, items: &[Item]) -> (Reply, Vec<Item>) {
        let mut packet = Packet::unconnected(request.to_bytes().expect("a short path"));
        packet.items.extend_from_slice(items);
        let frame = self.exchange(Command::SEND_RR_DATA, packet.to_bytes());
        let packet = Packet::decode(&frame.data).expect("a packet");
        let reply = Reply::decode(packet.unconnected_message().expect("a message")).expect("a reply");
        (reply, packet.items)
    }

    /// Opens a connection whose datagrams come to `socket`.
    ///
    /// # Errors
    /// The status of the refusal.
    ///
    /// # Panics
    /// When the reply is malformed.
    pub fn open(&mut self, wanted: Wanted, socket: UdpSocket) -> Result<Connection, CipStatus> {
        let parameters = |size| NetworkParameters {
            variable: false,
            priority: 2,
            ..NetworkParameters::explicit(size)
        };
        let [output, input] = wanted.sizes;
        let inhibit = Segment::Network {
            kind: 0x43,
            data: Bytes::from_static(&[2]),
        };
        let on_change = wanted.sent == Sent::ToGroupOnChange;
        let mut path = vec![
            Segment::Class(4),
            Segment::Instance(151),
            Segment::ConnectionPoint(wanted.points[0]),
            Segment::ConnectionPoint(wanted.points[1]),
        ];
        if on_change {
            path.insert(0, inhibit);
        }
        let mut t_to_o = parameters(input + 2);
        if wanted.sent != Sent::Alone {
            t_to_o.connection_type = ConnectionType::Multicast;
        }
        let open = ForwardOpen {
            time: TickTime::DEFAULT,
            o_to_t_id: ConnectionId(0),
            t_to_o_id: ConnectionId(0x5CA0_0000 | u32::from(wanted.serial)),
            key: key(wanted.serial),
            multiplier: wanted.multiplier,
            o_to_t_rpi: wanted.rpi,
            o_to_t: parameters(if output > 0 { output + 6 } else { 2 }),
            t_to_o_rpi: wanted.rpi,
            t_to_o,
            transport: if on_change { 0x11 } else { 1 },
            path: Epath(path),
        };
        let request = Request::new(
            service::FORWARD_OPEN,
            Epath::object(6, 1),
            open.to_bytes(false).expect("a short path"),
        );
        let port = socket.local_addr().expect("bound").port();
        let listens = SocketAddrV4::new(std::net::Ipv4Addr::UNSPECIFIED, port);
        let (reply, items) = self.ask(&request, &[Item::SockaddrTToO(listens)]);
        if !reply.status.is_success() {
            return Err(reply.status);
        }
        let reply = ForwardOpenReply::decode(&reply.data).expect("a Forward Open reply");
        let target = items.iter().find_map(|item| match item {
            Item::SockaddrOToT(address) => Some(*address),
            _ => None,
        });
        let target = target.expect("item 0x8000 of a point-to-point connection");
        let peer = self.stream.peer_addr().expect("connected").ip();
        let address = if target.ip().is_unspecified() {
            peer
        } else {
            IpAddr::V4(*target.ip())
        };
        socket.set_nonblocking(true).expect("a socket");
        Ok(Connection {
            socket,
            target: SocketAddr::new(address, target.port()),
            id: reply.o_to_t_id,
            sequence: 0,
            wanted,
            confirmed: [reply.o_to_t_api, reply.t_to_o_api],
            longest_pause: Duration::ZERO,
        })
    }

    /// Closes a connection.
    pub fn close(&mut self, serial: u16) -> CipStatus {
        let close = ForwardClose {
            time: TickTime::DEFAULT,
            key: key(serial),
            path: Epath::object(4, 151),
        };
        let data = close.to_bytes().expect("a short path");
        let request = Request::new(service::FORWARD_CLOSE, Epath::object(6, 1), data);
        self.ask(&request, &[]).0.status
    }
}

impl Connection {
    /// Sends one datagram: run, and the output assembly; of a heartbeat nothing but the sequence count.
    ///
    /// # Panics
    /// When the system refuses.
    pub fn send(&mut self, output: &[u8]) {
        self.sequence = self.sequence.wrapping_add(1);
        let mut data = (self.sequence as u16).to_le_bytes().to_vec();
        if self.wanted.sizes[0] > 0 {
            data.extend(1_u32.to_le_bytes());
            data.extend(output);
        }
        let mut out = BytesMut::new();
        Datagram {
            id: self.id,
            sequence: self.sequence,
            data: &data,
        }
        .encode(&mut out);
        self.socket.send_to(&out, self.target).expect("sent");
    }

    /// Exchanges data for a time: sends at the confirmed interval, and takes the datagrams. Returns all of them, in order.
    ///
    /// # Panics
    /// On a malformed datagram, or one from elsewhere than the target.
    pub fn exchange(&mut self, time: Duration, output: &[u8]) -> Vec<Arrival> {
        let interval = Duration::from_micros(self.confirmed[0].into());
        let began = Instant::now();
        let mut next = began;
        let mut arrivals = Vec::new();
        let mut looked = began;
        loop {
            let now = Instant::now();
            self.longest_pause = self.longest_pause.max(now - looked);
            looked = now;
            if now >= began + time {
                return arrivals;
            }
            if now >= next {
                self.send(output);
                next += interval;
            }
            match self.take() {
                Some(arrival) => arrivals.push(arrival),
                None => {
                    let until = next.min(began + time);
                    self.wait(until.saturating_duration_since(now));
                    // A sleep until the time is no pause; a longer one is.
                    looked = Instant::now().min(until);
                }
            }
        }
    }

    /// Sleeps until a datagram has come, or for a time.
    fn wait(&self, time: Duration) {
        let timeout = Timespec::try_from(time).expect("a short time");
        // A signal ends it early: the caller looks again.
        let _ = poll(&mut [PollFd::new(&self.socket, PollFlags::IN)], Some(&timeout));
    }

    /// The next datagram, if one has come.
    ///
    /// # Panics
    /// As [`Self::exchange`].
    pub fn take(&mut self) -> Option<Arrival> {
        let mut buf = [0; 2048];
        let (length, from) = self.socket.recv_from(&mut buf).ok()?;
        let at = Instant::now();
        assert_eq!(from, self.target, "it leaves from the port of I/O");
        let datagram = Datagram::decode(&buf[..length]).expect("a datagram");
        let (count, data) = datagram.data.split_first_chunk().expect("class 1");
        assert_eq!(
            data.len(),
            usize::from(self.wanted.sizes[1]),
            "the size that was opened"
        );
        Some(Arrival {
            at,
            sequence: datagram.sequence,
            count: u16::from_le_bytes(*count),
            data: data.to_vec(),
        })
    }
}

fn key(serial: u16) -> ConnectionKey {
    ConnectionKey {
        serial,
        vendor: 0x1337,
        originator: std::process::id(),
    }
}
