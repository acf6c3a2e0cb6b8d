//! The Stop bit of implicit outputs (class 1), under the load of others: from the datagram to the ramp.

use std::net::{SocketAddrV4, UdpSocket};

use arcline_proto::cip::Reply;
use arcline_proto::connection::{ConnectionKey, ForwardOpen, ForwardOpenReply, NetworkParameters, TickTime};
use arcline_proto::cpf::{ConnectionId, Item};
use arcline_proto::epath::Segment;
use arcline_proto::io::Datagram;

use super::turns::Session;
use super::*;

/// Bytes of the assemblies of the default machine: four coordinate systems, seven axes.
const INPUT_SIZE: u16 = 12 + 4 * 24 + 7 * 20;
const OUTPUT_SIZE: u16 = 4 + 4 * 4;
/// Bit of `Command`.
const STOP: u32 = 1 << 2;
/// The offset of `ConnectionStatus` behind the sequence count, and its bit of an owner in run.
const STATUS: usize = 2 + 4;
const RUN: u8 = 2;
/// Requested packet interval, µs; times 512, it outlasts each load.
const RPI: u32 = 100_000;

/// The owner of the outputs, in run.
struct Owner {
    udp: UdpSocket,
    target: SocketAddr,
    id: ConnectionId,
    sequence: u32,
    _session: Session,
}

impl Owner {
    fn open(server: &Server) -> Self {
        let udp = UdpSocket::bind("127.0.0.1:0").expect("a port");
        udp.set_read_timeout(Some(SOON)).expect("a socket");
        let parameters = |size| NetworkParameters {
            variable: false,
            priority: 2,
            ..NetworkParameters::explicit(size)
        };
        let open = ForwardOpen {
            time: TickTime::DEFAULT,
            o_to_t_id: ConnectionId(0),
            t_to_o_id: ConnectionId(1),
            key: ConnectionKey {
                serial: 1,
                vendor: 0x1337,
                originator: 42,
            },
            multiplier: 7,
            o_to_t_rpi: RPI,
            o_to_t: parameters(OUTPUT_SIZE + 6),
            t_to_o_rpi: RPI,
            t_to_o: parameters(INPUT_SIZE + 2),
            transport: 1,
            path: Epath(vec![
                Segment::Class(4),
                Segment::Instance(151),
                Segment::ConnectionPoint(150),
                Segment::ConnectionPoint(100),
            ]),
        };
        let request = Request::new(
            service::FORWARD_OPEN,
            Epath::object(6, 1),
            open.to_bytes(false).expect("a short path"),
        );
        let mut packet = Packet::unconnected(request.to_bytes().expect("a short path"));
        let port = udp.local_addr().expect("bound").port();
        let listens = SocketAddrV4::new(std::net::Ipv4Addr::UNSPECIFIED, port);
        packet.items.push(Item::SockaddrTToO(listens));
        let (session, frame) = server.clients.block_on(async {
            let mut session = Session::open(server.eip).await;
            let frame = session.exchange(Command::SEND_RR_DATA, packet.to_bytes()).await;
            (session, frame)
        });
        let packet = Packet::decode(&frame.data).expect("a packet");
        let reply = Reply::decode(packet.unconnected_message().expect("a message")).expect("a reply");
        assert!(reply.status.is_success(), "{}", reply.status);
        let port = packet.items.iter().find_map(|item| match item {
            Item::SockaddrOToT(address) => Some(address.port()),
            _ => None,
        });
        let mut owner = Owner {
            udp,
            target: SocketAddr::new(server.eip.ip(), port.expect("item 0x8000")),
            id: ForwardOpenReply::decode(&reply.data).expect("its data").o_to_t_id,
            sequence: 0,
            _session: session,
        };
        owner.send(0);
        let (mut input, began) = ([0; 1500], Instant::now());
        loop {
            let length = owner.udp.recv(&mut input).expect("inputs");
            let datagram = Datagram::decode(&input[..length]).expect("a datagram");
            if datagram.data.get(STATUS).is_some_and(|status| status & RUN != 0) {
                return owner;
            }
            assert!(began.elapsed() < SOON, "it does not run");
        }
    }

    /// Outputs in run, with a command word.
    fn send(&mut self, word: u32) {
        self.sequence += 1;
        let mut data = (self.sequence as u16).to_le_bytes().to_vec();
        data.extend(1_u32.to_le_bytes());
        data.extend(word.to_le_bytes());
        (0..4).for_each(|_| data.extend(100_f32.to_le_bytes()));
        let mut out = BytesMut::new();
        let datagram = Datagram {
            id: self.id,
            sequence: self.sequence,
            data: &data,
        };
        datagram.encode(&mut out);
        self.udp.send_to(&out, self.target).expect("sent");
    }
}

#[test]
fn stop_of_class_1_waits_for_no_client() {
    let server = Server::start();
    let mut owner = Owner::open(&server);
    server.under_loads("STOP of class 1", BOUND, |server, load| {
        server.jog();
        load.begin(server);
        let began = Instant::now();
        owner.send(STOP);
        server.until("STOP of class 1", |speed| speed < 50.0);
        let took = began.elapsed();
        owner.send(0);
        took
    });
}
