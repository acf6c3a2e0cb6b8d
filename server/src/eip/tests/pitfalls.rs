//! The pitfalls in which other servers fail with real clients (spec/ethernet-ip.md §17), by their numbers.
//!
//! `tests/system/tests/load/io_scanner.rs` measures the real-time accuracy of an interval (11), and `tests/system/benches/network.rs` the
//! cost of a request (14). The tests here do not depend on the machine's speed.

use std::net::SocketAddr;

use arcline_proto::cip::{
    MultipleReplies, Request, encode_attribute_ids, join_multiple, service, split_multiple_replies,
};
use arcline_proto::cpf::{Item, decode_items};
use arcline_proto::encap::{Command, EncapFrame, EncapStatus};
use arcline_proto::epath::{Epath, PortSegment, Segment};
use arcline_proto::identity::Identity;
use arcline_tag::Elementary;
use tokio::net::TcpStream;

use super::*;
use crate::eip::Listener;

#[tokio::test]
async fn pitfall_1_list_identity_on_tcp_and_a_program_name_of_two_length_bytes() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let identity = client.exchange(Command::LIST_IDENTITY, Bytes::new()).await;
    assert_eq!(identity.header.status, EncapStatus::SUCCESS);
    let items = decode_items(&identity.data).expect("items");
    assert!(matches!(items.as_slice(), [Item::Identity(_)]), "one item: {items:?}");
    let name = Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(0x64, 1), Bytes::new());
    let reply = client.ask(&name).await;
    assert!(reply.status.is_success(), "{}", reply.status);
    assert_eq!(
        usize::from(u16::from_le_bytes([reply.data[0], reply.data[1]])),
        reply.data.len() - 2
    );
}

#[tokio::test]
async fn pitfall_2_columns_come_as_asked() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    // Bytes of an entry beside its name.
    for (attributes, width) in [
        (&[1, 2, 3, 5, 6, 8, 10][..], 4 + 2 + 2 + 4 + 4 + 4 + 12 + 1),
        (&[1, 2, 8], 4 + 2 + 2 + 12),
        (&[2, 7, 8, 1], 4 + 2 + 2 + 12 + 2),
        (&[1, 2], 4 + 2 + 2),
        (&[2, 1], 4 + 2 + 2),
    ] {
        let list = |start: u32| {
            let data = encode_attribute_ids(attributes);
            Request::new(service::GET_INSTANCE_ATTRIBUTE_LIST, Epath::object(0x6B, start), data)
        };
        let reply = client.ask(&list(0)).await;
        assert!(
            matches!(reply.status.general(), 0 | 6),
            "{attributes:?}: {}",
            reply.status
        );
        let symbols = arcline_proto::logix::Symbol::decode_list(&reply.data, attributes).expect("symbols");
        let names: usize = symbols.iter().map(|symbol| symbol.name.len()).sum();
        assert_eq!(reply.data.len(), names + width * symbols.len(), "{attributes:?}");
        let beyond = client.ask(&list(0xFFFF)).await;
        assert_eq!(
            (codes(beyond.status), beyond.data.len()),
            ((0, 0), 0),
            "beyond the last"
        );
    }
}

#[tokio::test]
async fn pitfall_3_the_undocumented_attribute_of_a_template() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let ask = Request::new(
        service::GET_ATTRIBUTE_LIST,
        Epath::object(0x6C, 0xFCE),
        encode_attribute_ids(&[4, 3, 2, 1]),
    );
    let reply = client.ask(&ask).await;
    assert!(reply.status.is_success(), "{}", reply.status);
    assert_eq!(reply.data.len(), 2 + 8 + 6 + 6 + 6);
    assert_eq!(reply.data[10..14], [3, 0, 0, 0], "attribute 3, status 0");
    assert_eq!(reply.data[16..22], [2, 0, 0, 0, 2, 0], "two members at pylogix's place");
    assert_eq!(reply.data[26..], 0x0FCE_u16.to_le_bytes());
}

#[tokio::test]
async fn pitfall_4_surplus_bytes_are_ignored() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let twice = |request: &Request| {
        let message = request.to_bytes().expect("short");
        Bytes::from([&message[..], &[0x2C, 0], &message[..]].concat())
    };
    let set = write("aDint", Elementary::Dint.into(), 1, &7_i32.to_le_bytes());
    assert!(
        client.raw(twice(&set)).await.status.is_success(),
        "pycomm3's write of one tag"
    );
    assert_eq!(&client.read("aDint").await.data[..], 7_i32.to_le_bytes());
    let masks = [&[4, 0, 8, 0, 0, 0][..], &[0xFF; 8]].concat();
    let bits = Request::new(service::READ_MODIFY_WRITE_TAG, path("aDint"), masks);
    assert!(client.ask(&bits).await.status.is_success(), "pycomm3's long mask");
    assert_eq!(&client.read("aDint").await.data[..], 15_i32.to_le_bytes());
    for route in [&[0, 0][..], &[1, 0, 1, 0]] {
        let identity = Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(1, 1), route.to_vec());
        assert!(
            client.ask(&identity).await.status.is_success(),
            "a stray route: {route:?}"
        );
        let mut message = read("aDint", 1).to_bytes().expect("short").to_vec();
        message.extend(route);
        assert!(
            client.raw(message.into()).await.status.is_success(),
            "a stray route: {route:?}"
        );
    }
}

#[tokio::test]
async fn pitfall_5_a_packet_always_has_a_body() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let unknown = Request::new(0x4B, Epath::object(0x300, 1), Bytes::new());
    let requests = [read("Nothing", 1), unknown, read("aDint", 1)];
    let data = join_multiple(&requests).expect("short");
    let reply = client
        .ask(&Request::new(
            service::MULTIPLE_SERVICE_PACKET,
            Epath::object(2, 1),
            data,
        ))
        .await;
    assert_eq!(reply.status.general(), 0x1E);
    let replies = split_multiple_replies(&reply.data).expect("a body");
    let general: Vec<u8> = replies.iter().map(|reply| reply.status.general()).collect();
    assert_eq!(general, [0x05, 0x08, 0]);
    assert!(MultipleReplies::new(3, 500).is_ok());
}

#[tokio::test]
async fn pitfall_6_port_segments_in_connection_paths() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let backplane = Segment::Port(PortSegment::backplane(0));
    // Vendor 0: any.
    let key = Bytes::from_static(&[0x34, 4, 0, 0, 0, 0, 0, 0, 0, 0]);
    let router = Epath::object(2, 1).to_bytes();
    let port = Epath(vec![backplane]).to_bytes();
    for (serial, parts) in [
        (1, vec![&router]),
        (2, vec![&port, &router]),
        (3, vec![&key, &router]),
        (4, vec![&port, &key, &router]),
        (5, vec![&key, &port, &router]),
    ] {
        let bytes: Vec<u8> = parts.iter().flat_map(|part| part.iter().copied()).collect();
        let path = Epath::decode(&bytes.into()).expect("a path");
        let key = ConnectionKey {
            serial,
            vendor: 1,
            originator: 1,
        };
        let mut request = forward_open(500, key);
        let mut open = ForwardOpen::decode(&request.data, true).expect("our own");
        open.path = path.clone();
        request.data = open.to_bytes(true).expect("short");
        let reply = client.ask(&request).await;
        assert!(reply.status.is_success(), "{path:?}: {}", reply.status);
    }
}

#[tokio::test]
async fn pitfall_7_many_clients_at_a_time() {
    let bench = Bench::new();
    let mut clients = Vec::new();
    for _ in 0..20 {
        clients.push(bench.client().await);
    }
    for client in clients.iter_mut().rev() {
        assert_eq!(client.read("aDint").await.data.len(), 4);
    }
}

#[tokio::test]
async fn pitfall_8_whatever_is_unknown_is_answered() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    for class in [
        0x01, 0x02, 0x04, 0x06, 0x47, 0x48, 0x64, 0x6B, 0x6C, 0x8B, 0xAC, 0xB2, 0xF4, 0xF5, 0xF6, 0x300, 0x302,
    ] {
        for code in 1..0x80 {
            let reply = client
                .ask(&Request::new(code, Epath::object(class, 1), Bytes::new()))
                .await;
            assert_eq!(reply.service & 0x7F, code, "class {class:#X}");
        }
    }
    for command in [0x0001, 0x0005, 0x0067, 0x0071, 0x0072, 0x0073, 0xFFFF] {
        let reply = client.exchange(Command(command), Bytes::new()).await;
        assert_eq!(reply.header.status, EncapStatus::INVALID_COMMAND, "{command:#06X}");
    }
    assert_eq!(client.read("aDint").await.data.len(), 4, "the session still works");
}

#[tokio::test]
async fn pitfall_9_sessions_and_versions_are_looked_at() {
    let bench = Bench::new();
    let mut client = Client {
        stream: bench.stream(),
        buf: BytesMut::new(),
        session: SessionHandle(0),
    };
    let early = client
        .exchange(
            Command::SEND_RR_DATA,
            Packet::unconnected(Bytes::from_static(&[1, 0])).to_bytes(),
        )
        .await;
    assert_eq!(early.header.status, EncapStatus::INVALID_SESSION, "without a session");
    let wrong = client
        .exchange(Command::REGISTER_SESSION, Bytes::from_static(&[2, 0, 0, 0]))
        .await;
    assert_eq!(wrong.header.status, EncapStatus::UNSUPPORTED_VERSION);
    assert_eq!(wrong.data[..2], [1, 0], "the version that would do");
    let right = client
        .exchange(Command::REGISTER_SESSION, RegisterSession::CURRENT.to_bytes())
        .await;
    assert_eq!(right.header.status, EncapStatus::SUCCESS);
    client.session = SessionHandle(right.header.session.0.wrapping_add(1));
    let packet = Packet::unconnected(read("aDint", 1).to_bytes().expect("short")).to_bytes();
    let other = client.exchange(Command::SEND_RR_DATA, packet).await;
    assert_eq!(other.header.status, EncapStatus::INVALID_SESSION, "a wrong handle");
    client.session = right.header.session;
    assert_eq!(client.read("aDint").await.data.len(), 4);
}

#[tokio::test]
async fn pitfall_10_a_header_over_several_segments() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let packet = Packet::unconnected(read("aDint", 1).to_bytes().expect("short")).to_bytes();
    let frame = EncapFrame::request(Command::SEND_RR_DATA, client.session, CONTEXT, packet).to_bytes();
    for byte in &frame {
        client.send(std::slice::from_ref(byte)).await;
        tokio::task::yield_now().await;
    }
    let reply = client.frame().await.expect("an answer");
    assert_eq!(
        (reply.header.status, reply.header.context),
        (EncapStatus::SUCCESS, CONTEXT)
    );
}

#[tokio::test]
async fn pitfall_12_the_address_of_an_identity_can_be_connected_to() {
    let (plant, _thread) = plant();
    let any = SocketAddr::from(([0, 0, 0, 0], 0));
    let listener = Listener::bind(any, plant, settings_of("Found")).await.expect("a port");
    let reached = SocketAddr::from(([127, 0, 0, 1], listener.local_addr().port()));
    let server = tokio::spawn(listener.serve());
    let ask = EncapFrame::request(Command::LIST_IDENTITY, SessionHandle(0), CONTEXT, Bytes::new());
    let mut stream = TcpStream::connect(reached).await.expect("a connection");
    stream.write_all(&ask.to_bytes()).await.expect("sent");
    let mut reply = vec![0; 24 + 2 + 4 + 33 + 6];
    let read = tokio::time::timeout(PATIENCE, stream.read_exact(&mut reply)).await;
    read.expect("in time").expect("an answer");
    let items = decode_items(&Bytes::from(reply).slice(24..)).expect("items");
    let [Item::Identity(item)] = items.as_slice() else {
        panic!("one identity item, not {items:?}")
    };
    let (address, _) = Identity::decode_item(item).expect("an identity");
    assert_eq!(SocketAddr::from(address), reached);
    server.abort();
}

#[tokio::test]
async fn pitfall_13_no_reply_is_longer_than_its_connection() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let all = read("Dints", 3000);
    let list = Request::new(
        service::GET_INSTANCE_ATTRIBUTE_LIST,
        Epath::object(0x6B, 0),
        encode_attribute_ids(&[1, 2, 3, 5, 6, 8, 10]),
    );
    let many = vec![read("Dints", 40); 30];
    let packet = Request::new(
        service::MULTIPLE_SERVICE_PACKET,
        Epath::object(2, 1),
        join_multiple(&many).expect("short"),
    );
    for (serial, size) in (1..).zip([64, 100, 101, 252, 500, 504, 508, 1000, 2000, 4000, 4002]) {
        let mut connected = client.open(size, serial).await;
        for request in [&all, &list, &packet, &read("Move1", 1), &read("X", 1)] {
            let reply = client.ask_connected(&mut connected, request).await;
            assert!(reply.len() + 2 <= usize::from(size), "{size}: {} bytes", reply.len());
        }
        client.close(&connected).await;
    }
}

#[test]
fn pitfall_11_a_confirmed_interval_is_kept_or_it_is_refused() {
    use arcline_proto::io::{Assemblies, Assembly, Datagram, IoConnections, IoSettings, Originator};
    let assembly = |instance, size| Assembly { instance, size };
    let assemblies = Assemblies {
        input: assembly(100, 8),
        output: assembly(150, 4),
        configuration: 151,
        input_only: 254,
        listen_only: 255,
    };
    let mut connections = IoConnections::new(IoSettings {
        assemblies,
        max_connections: 8,
        min_interval: 1000,
        volatile: 0,
        local: SocketAddr::from(([127, 0, 0, 1], 2222)),
    });
    let originator = Originator {
        address: PEER,
        port: Some(4000),
        group: None,
    };
    let application = [
        Segment::Class(4),
        Segment::Instance(151),
        Segment::ConnectionPoint(254),
        Segment::ConnectionPoint(100),
    ];
    let intervals = [999, 1000, 1001, 2000, 5000, 9999, 10_000, 100_000];
    let mut drawn = 0;
    let mut kept = Vec::new();
    let mut ids = Vec::new();
    for (serial, interval) in (1..).zip(intervals) {
        let parameters = |size| NetworkParameters {
            variable: false,
            ..NetworkParameters::explicit(size)
        };
        let open = ForwardOpen {
            time: TickTime::DEFAULT,
            o_to_t_id: ConnectionId(0),
            t_to_o_id: ConnectionId(interval),
            key: ConnectionKey {
                serial,
                vendor: 1,
                originator: 1,
            },
            multiplier: 7,
            o_to_t_rpi: 100_000,
            o_to_t: parameters(2),
            t_to_o_rpi: interval,
            t_to_o: parameters(10),
            transport: 1,
            path: Epath(application.to_vec()),
        };
        let random = || {
            drawn += 1;
            Some(drawn)
        };
        match connections.open(&open, &application, originator, Duration::ZERO, random) {
            Ok(reply) => {
                assert_eq!(reply.t_to_o_api, interval, "confirmed as it was asked for");
                connections.start(reply.o_to_t_id, Duration::ZERO);
                ids.push(reply.o_to_t_id);
                kept.push((interval, 0_u32));
            }
            Err(status) => assert_eq!((interval, codes(status)), (999, (0x01, 0x0111))),
        }
    }
    assert_eq!(kept.len(), intervals.len() - 1);
    // A minute of a thread that wakes up when a datagram is due, and at times half a millisecond late.
    let (mut now, mut woken) = (Duration::ZERO, 0_u32);
    let mut out = BytesMut::new();
    // The originator is heard every 5 s: no watchdog ends a connection within the minute.
    let mut heard = 0_u32;
    while now < Duration::from_secs(60) {
        if now >= Duration::from_secs(5) * heard {
            heard += 1;
            for id in &ids {
                out.clear();
                let data = (heard as u16).to_le_bytes();
                Datagram {
                    id: *id,
                    sequence: heard,
                    data: &data,
                }
                .encode(&mut out);
                let from = SocketAddr::new(PEER, 4000);
                assert!(connections.handle_datagram(&out, from, now), "a sign of life");
            }
        }
        now = connections.poll_timeout().expect("something is always due").max(now);
        woken += 1;
        let late = if woken.is_multiple_of(97) { 500 } else { 0 };
        let at = now + Duration::from_micros(late);
        loop {
            out.clear();
            if connections.poll_transmit(at, &[0; 8], &mut out).is_none() {
                break;
            }
            let id = u32::from_le_bytes(out[6..10].try_into().expect("four bytes"));
            let (interval, sent) = kept
                .iter_mut()
                .find(|(interval, _)| *interval == id)
                .expect("one of them");
            let due = Duration::from_micros(u64::from(*interval) * u64::from(*sent));
            assert!(
                at >= due && at - due <= Duration::from_micros(500),
                "{interval} µs: {sent} was due at {due:?}, left at {at:?}"
            );
            *sent += 1;
        }
    }
}

/// With 10 ms for a read, 32 clients would wait for a third of a second: here all of them together have their answers in far less.
#[tokio::test]
async fn pitfall_14_a_read_costs_no_client_the_time_of_another() {
    const CLIENTS: usize = 32;
    const READS: u32 = 50;
    let bench = Bench::new();
    let mut clients = Vec::new();
    for _ in 0..CLIENTS {
        clients.push(bench.client().await);
    }
    let began = std::time::Instant::now();
    for _ in 0..READS {
        for client in &mut clients {
            assert_eq!(client.read("aDint").await.data.len(), 4);
        }
    }
    let each = began.elapsed() / (READS * CLIENTS as u32);
    println!("{each:?} a read");
    assert!(each < Duration::from_millis(3), "{each:?} a read");
}
