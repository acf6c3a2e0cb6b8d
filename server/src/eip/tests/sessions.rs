//! Sessions, discovery and connections.

use std::net::SocketAddr;

use arcline_proto::cip::{Request, service};
use arcline_proto::cpf::{Item, Packet, decode_items};
use arcline_proto::encap::{Command, EncapFrame, EncapStatus, RegisterSession, SessionHandle};
use arcline_proto::epath::Epath;
use arcline_proto::identity::Identity;
use arcline_tag::Elementary;
use bytes::Bytes;
use tokio::net::{TcpStream, UdpSocket};

use super::*;
use crate::eip::Listener;

#[tokio::test]
async fn registering_gives_a_handle_and_echoes_the_context() {
    let client = Bench::new().client().await;
    assert_ne!(client.session, SessionHandle(0));
}

#[tokio::test]
async fn wrong_sessions_are_refused_and_the_stream_goes_on() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let ask = |client: &Client| {
        EncapFrame::request(
            Command::SEND_RR_DATA,
            SessionHandle(client.session.0 ^ 1),
            *b"context!",
            Packet::unconnected(Bytes::from_static(&[1, 2, 0x20, 1, 0x24, 1])).to_bytes(),
        )
    };
    #[rustfmt::skip]
    let cases = [
        ("another session's handle", ask(&client), EncapStatus::INVALID_SESSION),
        ("a second registration",
         EncapFrame::request(Command::REGISTER_SESSION, client.session, *b"context!", RegisterSession::CURRENT.to_bytes()),
         EncapStatus::INVALID_COMMAND),
        ("an obsolete command", EncapFrame::request(Command(0x72), client.session, *b"context!", Bytes::new()),
         EncapStatus::INVALID_COMMAND),
        ("no packet", EncapFrame::request(Command::SEND_RR_DATA, client.session, *b"context!", Bytes::from_static(&[0; 5])),
         EncapStatus::INCORRECT_DATA),
    ];
    for (why, frame, expected) in cases {
        client.send(&frame.to_bytes()).await;
        let reply = client.frame().await.expect("an answer");
        assert_eq!(reply.header.status, expected, "{why}");
        assert_eq!(&reply.header.context, b"context!", "{why}");
    }
    assert_eq!(client.read("aDint").await.data.len(), 4, "the session still works");
}

#[tokio::test]
async fn a_frame_too_long_is_refused_and_the_stream_ends() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut header = EncapFrame::request(Command::SEND_RR_DATA, client.session, *b"context!", Bytes::new())
        .to_bytes()
        .to_vec();
    header[2..4].copy_from_slice(&u16::MAX.to_le_bytes());
    client.send(&header).await;
    let reply = client.frame().await.expect("a refusal");
    assert_eq!(reply.header.status, EncapStatus::INVALID_LENGTH);
    assert_eq!(client.frame().await, None, "closed");
}

#[tokio::test(start_paused = true)]
async fn silence_without_a_session_ends_the_connection() {
    let bench = Bench::new();
    let mut client = Client {
        stream: bench.stream(),
        buf: Default::default(),
        session: SessionHandle(0),
    };
    let started = tokio::time::Instant::now();
    let mut byte = [0];
    let end = tokio::io::AsyncReadExt::read(&mut client.stream, &mut byte).await;
    assert_eq!(end.expect("an end"), 0);
    assert_eq!(started.elapsed().as_secs(), 30);
}

/// Only a registration keeps the connection open.
#[tokio::test(start_paused = true)]
async fn only_a_registration_within_30_seconds_keeps_a_connection() {
    let bench = Bench::new();
    let unregistered = || Client {
        stream: bench.stream(),
        buf: Default::default(),
        session: SessionHandle(0),
    };
    let (mut talker, mut late) = (unregistered(), unregistered());
    let started = tokio::time::Instant::now();
    for _ in 0..29 {
        tokio::time::sleep(Duration::from_secs(1)).await;
        let nop = EncapFrame::request(Command::NOP, SessionHandle(0), [0; 8], Bytes::new());
        talker.send(&nop.to_bytes()).await;
        let identity = talker.exchange(Command::LIST_IDENTITY, Bytes::new()).await;
        assert_eq!(identity.header.status, EncapStatus::SUCCESS);
    }
    let registered = late
        .exchange(Command::REGISTER_SESSION, RegisterSession::CURRENT.to_bytes())
        .await;
    late.session = registered.header.session;
    assert_eq!(talker.frame().await, None, "it only talked");
    assert_eq!(started.elapsed().as_secs(), 30);
    tokio::time::sleep(Duration::from_secs(60)).await;
    assert_eq!(late.read("aDint").await.data.len(), 4);
}

#[tokio::test]
async fn many_requests_in_one_segment_are_answered_in_order() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut all = Vec::new();
    for k in 0..200_u64 {
        let request = read("aDint", 1).to_bytes().expect("short");
        let data = Packet::unconnected(request).to_bytes();
        all.extend(EncapFrame::request(Command::SEND_RR_DATA, client.session, k.to_le_bytes(), data).to_bytes());
    }
    client.send(&all).await;
    for k in 0..200_u64 {
        assert_eq!(client.frame().await.expect("an answer").header.context, k.to_le_bytes());
    }
}

#[tokio::test]
async fn the_end_of_a_session_does_not_overtake_a_request() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let message = read("aDint", 1).to_bytes().expect("short");
    let packet = Packet::unconnected(message).to_bytes();
    let request = EncapFrame::request(Command::SEND_RR_DATA, client.session, *b"context!", packet);
    let end = EncapFrame::request(Command::UNREGISTER_SESSION, client.session, *b"context!", Bytes::new());
    client.send(&[request.to_bytes(), end.to_bytes()].concat()).await;
    let reply = client.frame().await.expect("the reply to the request");
    assert_eq!(reply.header.status, EncapStatus::SUCCESS);
    assert_eq!(client.frame().await, None, "closed");
}

#[tokio::test]
async fn connections_open_answer_and_close() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(4000, 1).await;
    assert_eq!(bench.device.open_connections(), 1);
    let identity = Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(1, 1), Bytes::new());
    let reply = client.ask_connected(&mut connected, &identity).await;
    assert_eq!(Identity::decode_all(&reply.data).expect("an identity").name(), "Bench");
    let twice = client.ask(&forward_open(4000, connected.key)).await;
    assert_eq!(codes(twice.status), (0x01, 0x0100), "the same connection twice");
    let large = client
        .ask(&forward_open(
            5000,
            ConnectionKey {
                serial: 9,
                ..connected.key
            },
        ))
        .await;
    assert_eq!(large.status.additional(), [0x0109, 4002], "the size that would do");
    assert!(client.close(&connected).await.status.is_success());
    assert_eq!(
        codes(client.close(&connected).await.status),
        (0x01, 0x0107),
        "closed already"
    );
    assert_eq!(bench.device.open_connections(), 0);
    let counters = Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(6, 1), Bytes::new());
    let counters: Vec<u16> = client
        .ask(&counters)
        .await
        .data
        .chunks(2)
        .map(|word| u16::from_le_bytes([word[0], word[1]]))
        .collect();
    assert_eq!(counters, [3, 0, 0, 2, 2, 0, 1, 0]);
}

#[tokio::test]
async fn a_repeated_message_is_not_executed_again() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(500, 1).await;
    let set = write("aDint", Elementary::Dint.into(), 1, &1_i32.to_le_bytes());
    assert!(client.ask_connected(&mut connected, &set).await.status.is_success());
    assert!(
        client
            .write("aDint", Elementary::Dint.into(), &2_i32.to_le_bytes())
            .await
            .is_success()
    );
    assert!(
        client.repeat(&connected, &set).await.status.is_success(),
        "the stored reply"
    );
    assert_eq!(&client.read("aDint").await.data[..], 2_i32.to_le_bytes());
}

#[tokio::test]
async fn a_closed_stream_frees_its_connections() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    client.open(500, 1).await;
    client.open(500, 2).await;
    drop(client);
    let gone = async {
        while bench.device.open_connections() > 0 {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(PATIENCE, gone).await.expect("freed");
}

#[tokio::test]
async fn the_device_is_found_over_tcp_and_udp() {
    let (plant, _thread) = plant();
    let listener = Listener::bind(SocketAddr::from(([127, 0, 0, 1], 0)), plant, settings_of("Found"))
        .await
        .expect("a port");
    let address = listener.local_addr();
    let server = tokio::spawn(listener.serve());
    let ask = EncapFrame::request(Command::LIST_IDENTITY, SessionHandle(0), *b"\x01\0finder", Bytes::new());

    let mut stream = TcpStream::connect(address).await.expect("a connection");
    stream.write_all(&ask.to_bytes()).await.expect("sent");
    let mut over_tcp = vec![0; 24 + 2 + 4 + 33 + 6];
    tokio::time::timeout(PATIENCE, stream.read_exact(&mut over_tcp))
        .await
        .expect("in time")
        .expect("read");

    let socket = UdpSocket::bind(("127.0.0.1", 0)).await.expect("a socket");
    let whole = ask.to_bytes();
    for cut in 0..whole.len() {
        socket.send_to(&whole[..cut], address).await.expect("sent");
    }
    socket.send_to(&whole, address).await.expect("sent");
    let mut over_udp = [0; 512];
    let (length, _) = tokio::time::timeout(PATIENCE, socket.recv_from(&mut over_udp))
        .await
        .expect("in time")
        .expect("read");

    for reply in [&over_tcp[..], &over_udp[..length]] {
        let items = decode_items(&Bytes::copy_from_slice(&reply[24..])).expect("items");
        let [Item::Identity(item)] = items.as_slice() else {
            panic!("one identity item, not {items:?}")
        };
        let (at, identity) = Identity::decode_item(item).expect("an identity");
        assert_eq!((SocketAddr::from(at), identity.name()), (address, "Found"));
    }
    server.abort();
}

#[tokio::test]
async fn a_crowd_waits_and_is_served_in_turn() {
    let (plant, _thread) = plant();
    let mut settings = settings_of("Small");
    settings.config.max_clients = 2;
    let listener = Listener::bind(SocketAddr::from(([127, 0, 0, 1], 0)), plant, settings)
        .await
        .expect("a port");
    let address = listener.local_addr();
    let server = tokio::spawn(listener.serve());
    let register = EncapFrame::request(
        Command::REGISTER_SESSION,
        SessionHandle(0),
        [0; 8],
        RegisterSession::CURRENT.to_bytes(),
    )
    .to_bytes();
    for round in 0..6 {
        let mut stream = TcpStream::connect(address).await.expect("a connection");
        stream.write_all(&register).await.expect("sent");
        let mut reply = [0; 28];
        let read = tokio::time::timeout(PATIENCE, stream.read_exact(&mut reply)).await;
        assert!(read.expect("in time").is_ok(), "connection {round}");
    }
    server.abort();
}

/// A client of a real socket that reads a tag.
async fn read_over(address: SocketAddr) -> std::io::Result<usize> {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut stream = TcpStream::connect(address).await?;
    let register = EncapFrame::request(
        Command::REGISTER_SESSION,
        SessionHandle(0),
        [0; 8],
        RegisterSession::CURRENT.to_bytes(),
    );
    stream.write_all(&register.to_bytes()).await?;
    let mut head = [0; 28];
    stream.read_exact(&mut head).await?;
    let session = SessionHandle(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
    let message = read("aDint", 1).to_bytes().expect("a short path");
    let ask = EncapFrame::request(
        Command::SEND_RR_DATA,
        session,
        [0; 8],
        Packet::unconnected(message).to_bytes(),
    );
    stream.write_all(&ask.to_bytes()).await?;
    let mut reply = [0; 256];
    stream.read(&mut reply).await
}

async fn listener(change: impl FnOnce(&mut Settings)) -> (SocketAddr, Vec<SocketAddr>, arcline_realtime::Handle) {
    let (plant, handle) = plant();
    let mut settings = settings_of("Bench");
    change(&mut settings);
    let listener = Listener::bind("127.0.0.1:0".parse().expect("an address"), plant, settings)
        .await
        .expect("free ports");
    let (first, all) = (listener.local_addr(), listener.local_addrs());
    tokio::spawn(listener.serve());
    (first, all, handle)
}

#[tokio::test]
async fn every_listener_serves_over_ipv4_and_ipv6() {
    let also = ["127.0.0.2:0", "[::1]:0"].map(|address| address.parse().expect("an address"));
    let (first, all, _thread) = listener(|settings| settings.config.listen_also = also.to_vec()).await;
    assert_eq!((all.len(), all[0]), (3, first));
    for address in all {
        let length = tokio::time::timeout(PATIENCE, read_over(address))
            .await
            .expect("in time");
        assert_eq!(length.expect("an answer"), 24 + 16 + 4 + 6, "{address}");
        let udp = UdpSocket::bind((address.ip(), 0)).await.expect("a free port");
        let ask = EncapFrame::request(Command::LIST_SERVICES, SessionHandle(0), [0; 8], Bytes::new());
        udp.send_to(&ask.to_bytes(), address).await.expect("loopback");
        let mut answer = [0; 128];
        let received = tokio::time::timeout(PATIENCE, udp.recv(&mut answer))
            .await
            .expect("in time");
        assert_eq!(received.expect("an answer"), 24 + 26, "{address}");
    }
}

/// OpENer #131: half-open TCP connections that were never freed.
#[tokio::test(flavor = "multi_thread")]
async fn silent_sockets_keep_no_client_out() {
    let sockets = std::env::var("ARCLINE_SILENT")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(300);
    let (address, _, _thread) = listener(|settings| settings.config.max_clients = 64).await;
    let mut silent = Vec::new();
    for number in 0..sockets {
        match TcpStream::connect(address).await {
            Ok(stream) => silent.push(stream),
            // The test's own limit of open files.
            Err(error) => panic!("socket {number}: {error}"),
        }
    }
    let began = std::time::Instant::now();
    let length = tokio::time::timeout(PATIENCE, read_over(address))
        .await
        .expect("in time");
    assert_eq!(length.expect("an answer"), 24 + 16 + 4 + 6);
    println!("{sockets} silent sockets, then a client in {:?}", began.elapsed());
}

#[tokio::test]
async fn sessions_of_one_address_are_limited_and_the_one_too_many_is_closed() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let (address, _, _thread) = listener(|settings| settings.config.max_clients_per_address = 2).await;
    let mut held = Vec::new();
    for _ in 0..2 {
        let mut stream = TcpStream::connect(address).await.expect("room");
        let register = EncapFrame::request(
            Command::REGISTER_SESSION,
            SessionHandle(0),
            [0; 8],
            RegisterSession::CURRENT.to_bytes(),
        );
        stream.write_all(&register.to_bytes()).await.expect("room");
        stream.read_exact(&mut [0; 28]).await.expect("a session");
        held.push(stream);
    }
    let mut third = TcpStream::connect(address).await.expect("accepted, then closed");
    let end = tokio::time::timeout(PATIENCE, third.read(&mut [0; 1]))
        .await
        .expect("at once");
    assert!(matches!(end, Ok(0) | Err(_)), "{end:?}");
    drop(held);
    let again = async {
        while read_over(address).await.unwrap_or(0) == 0 {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(PATIENCE, again)
        .await
        .expect("their places are free again");
}

#[tokio::test]
async fn connections_are_limited_in_all_and_of_one_address() {
    for change in [
        (|settings: &mut Settings| settings.config.max_connections = 2) as fn(&mut Settings),
        |settings| settings.config.max_connections_per_address = 2,
    ] {
        let bench = Bench::with(change);
        let (mut one, mut other) = (bench.client().await, bench.client().await);
        let first = one.open(500, 1).await;
        other.open(500, 2).await;
        let key = ConnectionKey {
            serial: 3,
            vendor: 1,
            originator: 1,
        };
        let full = one.ask(&forward_open(500, key)).await;
        assert_eq!(codes(full.status), (0x01, 0x0113));
        assert!(one.close(&first).await.status.is_success());
        one.open(500, 4).await;
        // The connections of a client end with it.
        drop((one, other));
        let free = async {
            while bench.device.open_connections() > 0 {
                tokio::task::yield_now().await;
            }
        };
        tokio::time::timeout(PATIENCE, free).await.expect("they are closed");
        bench.client().await.open(500, 5).await;
    }
}

#[tokio::test(start_paused = true)]
async fn a_client_that_reads_nothing_is_closed_and_delays_no_other() {
    let bench = Bench::with(|settings| settings.write_timeout = Duration::from_secs(5));
    let mut slow = bench.client().await;
    let mut other = bench.client().await;
    let message = read("Dints", 100).to_bytes().expect("a short path");
    let ask = EncapFrame::request(
        Command::SEND_RR_DATA,
        slow.session,
        [0; 8],
        Packet::unconnected(message).to_bytes(),
    )
    .to_bytes();
    // Until the server reads no more from it: its replies fill their room, and no more.
    let flood = async {
        let mut sent = 0_usize;
        while slow.stream.write_all(&ask).await.is_ok() {
            sent += 1;
            assert!(sent < 100_000, "it is read without end");
        }
    };
    tokio::pin!(flood);
    tokio::select! {
        () = &mut flood => {}
        () = async { loop {
            assert_eq!(other.read("aDint").await.data.len(), 4);
            tokio::time::sleep(Duration::from_millis(100)).await;
        } } => {}
    }
}
