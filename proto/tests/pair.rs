//! Client and server session joined in memory; time is advanced by hand.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;
use std::time::Duration;

use arcline_proto::cip::{CipStatus, Reply, Request};
use arcline_proto::client::{Call, ClientError, ClientSession, Connected, OpenOptions, Outcome, backplane};
use arcline_proto::connection::{ConnectionKey, Count, ForwardOpen, NetworkParameters, UnconnectedSend};
use arcline_proto::cpf::{ConnectionId, Packet};
use arcline_proto::encap::{Command, EncapFrame, EncapStatus, FrameDecoder, Header, RegisterSession, SessionHandle};
use arcline_proto::epath::{Epath, PortSegment, Segment};
use arcline_proto::identity::Identity;
use arcline_proto::session::{CloseReason, Draws, Event, RequestId, ServerSession, Settings, TestHost};
use bytes::{Bytes, BytesMut};

struct Pair {
    client: ClientSession,
    server: ServerSession,
    host: TestHost,
    now: Duration,
    requests: Vec<(RequestId, Request, usize)>,
    sent: Vec<Bytes>,
    closed: Option<CloseReason>,
}

impl Pair {
    fn new() -> Self {
        Self::with(Settings::default())
    }

    fn with(settings: Settings) -> Self {
        let identity = Identity::new("Arcline", 7);
        let host = TestHost {
            most: 3,
            identity,
            ..TestHost::new(Draws::Mixed(1))
        };
        let server = ServerSession::new(Arc::new(settings), "127.0.0.1:44818".parse().unwrap(), Duration::ZERO);
        let client = ClientSession::new(Duration::from_secs(5));
        let (requests, sent) = (Vec::new(), Vec::new());
        Self {
            client,
            server,
            host,
            now: Duration::ZERO,
            requests,
            sent,
            closed: None,
        }
    }

    fn registered() -> Self {
        let mut pair = Self::new();
        let call = pair.client.register(pair.now);
        assert_eq!(pair.outcome(call), Outcome::Registered);
        pair
    }

    /// Moves bytes until nothing moves; the server's requests are kept.
    fn drive(&mut self) {
        loop {
            let mut moved = false;
            while let Some(bytes) = self.client.poll_transmit() {
                moved = true;
                self.input(&bytes);
            }
            let sent = self.sent.len();
            self.collect();
            for bytes in self.sent.split_off(sent.min(self.sent.len())) {
                moved = true;
                self.client.handle_input(&mut BytesMut::from(&bytes[..])).unwrap();
            }
            if !moved {
                return;
            }
        }
    }

    fn input(&mut self, bytes: &[u8]) {
        self.server
            .handle_input(&mut BytesMut::from(bytes), self.now, &mut self.host);
    }

    fn collect(&mut self) {
        while let Some(event) = self.server.poll_event() {
            match event {
                Event::Outgoing(bytes) => self.sent.push(bytes),
                Event::Request {
                    id,
                    request,
                    reply_budget,
                    ..
                } => self.requests.push((id, request, reply_budget)),
                Event::IoReady(_) => {}
                Event::Close(reason) => self.closed = Some(reason),
            }
        }
    }

    fn answer_all(&mut self) {
        for (id, request, _) in std::mem::take(&mut self.requests) {
            assert!(
                self.server
                    .reply(id, &Reply::success(request.service, request.data.clone()), self.now)
            );
            assert!(
                !self.server.reply(id, &Reply::success(1, Bytes::new()), self.now),
                "answered once"
            );
        }
    }

    fn outcome(&mut self, call: Call) -> Outcome {
        self.drive();
        self.answer_all();
        self.drive();
        let event = self.client.poll_event().unwrap();
        assert_eq!(event.call, call);
        event.outcome
    }

    fn open(&mut self) -> Connected {
        let call = self.client.open(options(1), self.now).unwrap();
        match self.outcome(call) {
            Outcome::Opened {
                connection,
                budget: 4000,
            } => connection,
            other => panic!("{other:?}"),
        }
    }

    /// Raw frames in, raw frames out, no client.
    fn raw(&mut self, frame: &EncapFrame) -> Vec<EncapFrame> {
        self.input(&frame.to_bytes());
        self.collect();
        self.sent.drain(..).map(|bytes| decode(&bytes)).collect()
    }
}

fn decode(bytes: &[u8]) -> EncapFrame {
    FrameDecoder::default()
        .decode(&mut BytesMut::from(bytes))
        .unwrap()
        .unwrap()
}

fn options(serial: u16) -> OpenOptions {
    let key = ConnectionKey {
        serial,
        vendor: 0x1009,
        originator: 5,
    };
    OpenOptions::new(key, ConnectionId(0x1234 + u32::from(serial)))
}

fn read(name: &str) -> Request {
    Request::new(0x4C, Epath::symbol(name), Bytes::from_static(&[1, 0]))
}

fn echo(request: &Request) -> Outcome {
    Outcome::Reply(Reply::success(request.service, request.data.clone()))
}

fn raw(command: Command, session: SessionHandle, data: Bytes) -> EncapFrame {
    EncapFrame::request(command, session, *b"context!", data)
}

fn register(pair: &mut Pair) -> SessionHandle {
    let replies = pair.raw(&raw(
        Command::REGISTER_SESSION,
        SessionHandle(0),
        RegisterSession::CURRENT.to_bytes(),
    ));
    assert_eq!(replies[0].header.status, EncapStatus::SUCCESS);
    replies[0].header.session
}

#[test]
fn a_whole_conversation() {
    let mut pair = Pair::registered();
    let call = pair.client.identify(pair.now);
    let Outcome::Identity(Some((address, identity))) = pair.outcome(call) else {
        panic!()
    };
    assert_eq!(
        (address.to_string().as_str(), identity.name()),
        ("127.0.0.1:44818", "Arcline")
    );
    for route in [None, Some(backplane(0)), Some(Epath::default())] {
        let call = pair.client.request(&read("A"), route.as_ref(), pair.now).unwrap();
        assert_eq!(pair.outcome(call), echo(&read("A")), "{route:?}");
    }
    let connection = pair.open();
    assert_eq!((pair.server.connections(), pair.host.open), (1, 1));
    let call = pair.client.request_connected(connection, &read("B"), pair.now).unwrap();
    pair.drive();
    assert_eq!(
        pair.requests[0].2, 4000,
        "reply budget is the size less the sequence count"
    );
    assert_eq!(pair.outcome(call), echo(&read("B")));
    let call = pair.client.close(connection, pair.now).unwrap();
    assert_eq!(pair.outcome(call), Outcome::Closed);
    assert_eq!((pair.server.connections(), pair.host.open), (0, 0));
    assert_eq!(
        pair.client.request_connected(connection, &read("B"), pair.now),
        Err(ClientError::NotOpen)
    );
    pair.client.unregister();
    pair.drive();
    assert_eq!(pair.closed, Some(CloseReason::Unregistered));
    assert_eq!(pair.client.poll_event(), None, "no further events");
}

#[test]
fn routes_elsewhere_are_refused() {
    let mut pair = Pair::registered();
    for (why, segment, code) in [
        ("another slot", Segment::Port(PortSegment::backplane(3)), 0x0312),
        (
            "another port",
            Segment::Port(PortSegment {
                port: 2,
                link: Bytes::from_static(b"10.0.0.5"),
            }),
            0x0311,
        ),
    ] {
        let call = pair
            .client
            .request(&read("A"), Some(&Epath(vec![segment])), pair.now)
            .unwrap();
        let Outcome::Reply(reply) = pair.outcome(call) else {
            panic!()
        };
        assert_eq!(
            (reply.service, reply.status),
            (0x52, CipStatus::connection(code)),
            "{why}"
        );
        assert_eq!(reply.data.len(), 1, "{why}: remaining path size");
    }
    // Unconnected Send in itself.
    let inner = UnconnectedSend {
        time: arcline_proto::connection::TickTime::DEFAULT,
        message: read("A").to_bytes().unwrap(),
        route: backplane(0),
    };
    let nested = Request::new(0x52, Epath::object(6, 1), inner.to_bytes().unwrap());
    let call = pair.client.request(&nested, Some(&backplane(0)), pair.now).unwrap();
    assert_eq!(
        pair.outcome(call),
        Outcome::Reply(Reply::error(0x52, CipStatus::SERVICE_NOT_SUPPORTED))
    );
    assert!(pair.requests.is_empty());
}

#[test]
fn pipelined_requests_are_answered_in_order() {
    let mut pair = Pair::registered();
    let calls: Vec<Call> = (0..5)
        .map(|n| pair.client.request(&read(&format!("T{n}")), None, pair.now).unwrap())
        .collect();
    let mut coalesced = BytesMut::new();
    while let Some(bytes) = pair.client.poll_transmit() {
        coalesced.extend_from_slice(&bytes);
    }
    // Coalesced into one segment, then cut after every byte.
    let mut buf = BytesMut::new();
    for byte in coalesced {
        buf.extend_from_slice(&[byte]);
        pair.server.handle_input(&mut buf, pair.now, &mut pair.host);
    }
    pair.collect();
    assert_eq!(pair.requests.len(), 5);
    pair.requests.reverse();
    pair.answer_all();
    pair.drive();
    let order: Vec<Call> = std::iter::from_fn(|| pair.client.poll_event())
        .map(|event| event.call)
        .collect();
    assert_eq!(order, calls);
}

#[test]
fn input_waits_while_too_much_is_unanswered() {
    let mut pair = Pair::with(Settings {
        max_pending: 2,
        ..Settings::default()
    });
    let session = register(&mut pair);
    let frame = raw(
        Command::SEND_RR_DATA,
        session,
        Packet::unconnected(read("A").to_bytes().unwrap()).to_bytes(),
    );
    let mut buf = BytesMut::from(&frame.to_bytes().repeat(3)[..]);
    pair.server.handle_input(&mut buf, pair.now, &mut pair.host);
    pair.collect();
    assert_eq!(
        (pair.requests.len(), buf.is_empty(), pair.server.wants_input()),
        (2, false, false)
    );
    pair.answer_all();
    pair.server.handle_input(&mut buf, pair.now, &mut pair.host);
    assert!(buf.is_empty());
}

#[test]
fn encapsulation_errors() {
    let mut pair = Pair::new();
    let status = |replies: Vec<EncapFrame>| replies.first().map(|reply| (reply.header.status, reply.data.len()));
    let none = SessionHandle(0);
    let current = RegisterSession::CURRENT.to_bytes();
    let rr = Packet::unconnected(read("A").to_bytes().unwrap()).to_bytes();
    #[rustfmt::skip]
    let before = [
        // why,                     command,                   data,                                       reply
        ("no session yet",          Command::SEND_RR_DATA,     rr.clone(),                                 Some((EncapStatus::INVALID_SESSION, 0))),
        ("version 2",               Command::REGISTER_SESSION, Bytes::from_static(&[2, 0, 0, 0]),          Some((EncapStatus::UNSUPPORTED_VERSION, 4))),
        ("five bytes",              Command::REGISTER_SESSION, Bytes::from_static(&[1, 0, 0, 0, 0]),       Some((EncapStatus::INVALID_LENGTH, 0))),
        ("an obsolete command",     Command(0x0072),           Bytes::new(),                               Some((EncapStatus::INVALID_COMMAND, 0))),
        ("NOP",                     Command::NOP,              Bytes::from_static(b"anything"),            None),
        ("interfaces: none",        Command::LIST_INTERFACES,  Bytes::new(),                               Some((EncapStatus::SUCCESS, 2))),
        ("services",                Command::LIST_SERVICES,    Bytes::new(),                               Some((EncapStatus::SUCCESS, 26))),
    ];
    for (why, command, data, expected) in before {
        let replies = pair.raw(&raw(command, none, data));
        assert!(
            replies.iter().all(|reply| &reply.header.context == b"context!"),
            "{why}"
        );
        assert_eq!(status(replies), expected, "{why}");
    }
    let session = register(&mut pair);
    let other = SessionHandle(session.0 ^ 1);
    #[rustfmt::skip]
    let after = [
        ("a second RegisterSession", Command::REGISTER_SESSION,   session, current,                          Some((EncapStatus::INVALID_COMMAND, 0))),
        ("another's handle",         Command::SEND_RR_DATA,       other,   rr.clone(),                       Some((EncapStatus::INVALID_SESSION, 0))),
        ("another's handle, unit",   Command::SEND_UNIT_DATA,     other,   rr.clone(),                       Some((EncapStatus::INVALID_SESSION, 0))),
        ("no items",                 Command::SEND_RR_DATA,       session, Bytes::new(),                     Some((EncapStatus::INCORRECT_DATA, 0))),
        ("an item past the packet",  Command::SEND_RR_DATA,       session, rr.slice(..rr.len() - 1),         Some((EncapStatus::INCORRECT_DATA, 0))),
        ("address item missing",     Command::SEND_UNIT_DATA,     session, rr.clone(),                       Some((EncapStatus::INCORRECT_DATA, 0))),
    ];
    for (why, command, session, data, expected) in after {
        assert_eq!(status(pair.raw(&raw(command, session, data))), expected, "{why}");
    }
    let mut dropped = raw(Command::LIST_IDENTITY, session, Bytes::new());
    dropped.header.status = EncapStatus(1);
    assert_eq!(pair.raw(&dropped), [], "status in a request");
    dropped.header = Header {
        status: EncapStatus::SUCCESS,
        options: 1,
        ..dropped.header
    };
    assert_eq!(pair.raw(&dropped), [], "options in a request");
    assert_eq!(pair.closed, None, "the socket stays open through all of it");
    let long = raw(Command::SEND_RR_DATA, session, Bytes::from(vec![0; 9000]));
    assert_eq!(status(pair.raw(&long)), Some((EncapStatus::INVALID_LENGTH, 0)));
    assert!(matches!(pair.closed, Some(CloseReason::EncapFrame(_))));
}

#[test]
fn forward_open_refusals() {
    let mut pair = Pair::registered();
    let good = ForwardOpen {
        time: arcline_proto::connection::TickTime::DEFAULT,
        o_to_t_id: ConnectionId(0),
        t_to_o_id: ConnectionId(9),
        key: ConnectionKey {
            serial: 9,
            vendor: 1,
            originator: 1,
        },
        multiplier: 1,
        o_to_t_rpi: 1_000_000,
        o_to_t: NetworkParameters::explicit(4002),
        t_to_o_rpi: 1_000_000,
        t_to_o: NetworkParameters::explicit(4002),
        transport: 0xA3,
        path: Epath(vec![
            Segment::Port(PortSegment::backplane(0)),
            Segment::Key(arcline_proto::epath::ElectronicKey::default()),
            Segment::Class(2),
            Segment::Instance(1),
        ]),
    };
    let key = |vendor, device_type, major| {
        let key = arcline_proto::epath::ElectronicKey {
            vendor,
            device_type,
            major,
            ..Default::default()
        };
        Epath(vec![Segment::Key(key), Segment::Class(2), Segment::Instance(1)])
    };
    let mut null = NetworkParameters::explicit(0);
    null.connection_type = arcline_proto::connection::ConnectionType::Null;
    let failed = |code| CipStatus::connection(code);
    #[rustfmt::skip]
    let cases = [
        ("size", ForwardOpen { t_to_o: NetworkParameters::explicit(4003), ..good.clone() }, failed(0x0109).with(4002)),
        ("class 1", ForwardOpen { transport: 0x01, ..good.clone() }, failed(0x011C)),
        ("multiplier", ForwardOpen { multiplier: 8, ..good.clone() }, failed(0x0133)),
        ("null, unknown", ForwardOpen { o_to_t: null, t_to_o: null, ..good.clone() }, failed(0x0132)),
        ("vendor", ForwardOpen { path: key(1, 0, 0), ..good.clone() }, failed(0x0114)),
        ("device type", ForwardOpen { path: key(0, 12, 0), ..good.clone() }, failed(0x0115)),
        ("revision", ForwardOpen { path: key(0, 0, 34), ..good.clone() }, failed(0x0116)),
        ("another slot", ForwardOpen { path: backplane(7), ..good.clone() }, failed(0x0312)),
        ("another object", ForwardOpen { path: Epath::object(4, 1), ..good.clone() }, failed(0x0315)),
    ];
    for (why, open, status) in cases {
        let request = Request::new(0x5B, Epath::object(6, 1), open.to_bytes(true).unwrap());
        let call = pair.client.request(&request, None, pair.now).unwrap();
        let Outcome::Reply(reply) = pair.outcome(call) else {
            panic!()
        };
        assert_eq!((reply.status, reply.data.len()), (status, 10), "{why}");
    }
    let bytes = good.to_bytes(true).unwrap();
    for end in 0..bytes.len() {
        let request = Request::new(0x5B, Epath::object(6, 1), bytes.slice(..end));
        let call = pair.client.request(&request, None, pair.now).unwrap();
        let Outcome::Reply(reply) = pair.outcome(call) else {
            panic!()
        };
        assert!(!reply.status.is_success(), "cut at {end}");
    }
    assert_eq!(pair.host.open, 0);
    let request = Request::new(0x5B, Epath::object(6, 1), bytes);
    for status in [CipStatus::SUCCESS, failed(0x0100)] {
        let call = pair.client.request(&request, None, pair.now).unwrap();
        let Outcome::Reply(reply) = pair.outcome(call) else {
            panic!()
        };
        assert_eq!(reply.status, status, "the same key again");
    }
    for serial in [1, 2] {
        let call = pair.client.open(options(serial), pair.now).unwrap();
        assert!(matches!(pair.outcome(call), Outcome::Opened { .. }));
    }
    let call = pair.client.open(options(3), pair.now).unwrap();
    assert_eq!(
        pair.outcome(call),
        Outcome::Failed(ClientError::Refused(failed(0x0113)))
    );
    let counters = pair.host.counters;
    assert_eq!(
        (
            counters.of(Count::OpenResourceRejects),
            counters.of(Count::OpenOtherRejects)
        ),
        (1, 10)
    );
    pair.server.handle_disconnect(&mut pair.host);
    assert_eq!(pair.host.open, 0, "a lost socket frees its connections");
}

#[test]
fn duplicates_get_the_stored_reply() {
    let mut pair = Pair::registered();
    let connection = pair.open();
    pair.client.request_connected(connection, &read("A"), pair.now).unwrap();
    let bytes = pair.client.poll_transmit().unwrap();
    pair.input(&bytes);
    pair.input(&bytes);
    pair.collect();
    assert_eq!(pair.requests.len(), 1, "executed once, also while it is not answered");
    pair.answer_all();
    pair.collect();
    assert_eq!(pair.sent.len(), 2);
    assert_eq!(pair.sent[0], pair.sent[1]);
    pair.input(&bytes);
    pair.collect();
    assert_eq!((pair.requests.len(), pair.sent.len()), (0, 3), "and afterwards");
}

#[test]
fn watchdog_and_unknown_connections() {
    let mut pair = Pair::registered();
    let connection = pair.open();
    // 2 s × 32, restarted by each request.
    pair.now = Duration::from_secs(60);
    let call = pair.client.request_connected(connection, &read("A"), pair.now).unwrap();
    assert_eq!(pair.outcome(call), echo(&read("A")));
    assert_eq!(pair.server.poll_timeout(), Some(Duration::from_secs(124)));
    pair.now = Duration::from_millis(123_999);
    pair.server.handle_timeout(pair.now, &mut pair.host);
    assert_eq!(pair.server.connections(), 1);
    pair.now = Duration::from_secs(124);
    pair.server.handle_timeout(pair.now, &mut pair.host);
    assert_eq!((pair.server.connections(), pair.host.open), (0, 0));
    assert_eq!(pair.host.counters.of(Count::ConnectionTimeouts), 1);
    let call = pair.client.request_connected(connection, &read("A"), pair.now).unwrap();
    pair.drive();
    assert_eq!(
        pair.closed,
        Some(CloseReason::UnknownConnection),
        "the client notices at once"
    );
    assert_eq!(pair.server.unknown_connections(), 1);
    pair.client.handle_timeout(pair.now + Duration::from_secs(5));
    let event = pair.client.poll_event().unwrap();
    assert_eq!(
        (event.call, event.outcome),
        (call, Outcome::Failed(ClientError::TimedOut))
    );
}

#[test]
fn a_refused_packet_loses_the_connection() {
    let mut pair = Pair::registered();
    let connection = pair.open();
    let sent = pair.client.request_connected(connection, &read("A"), pair.now).unwrap();
    let waiting = pair.client.request_connected(connection, &read("B"), pair.now).unwrap();
    let mut bytes = BytesMut::from(&pair.client.poll_transmit().unwrap()[..]);
    let frame = FrameDecoder::default().decode(&mut bytes).unwrap().unwrap();
    pair.client
        .handle_frame(&EncapFrame::error(&frame.header, EncapStatus::INCORRECT_DATA));
    let refused = ClientError::Encapsulation {
        command: Command::SEND_UNIT_DATA,
        status: EncapStatus::INCORRECT_DATA,
    };
    let mut outcomes: Vec<_> = std::iter::from_fn(|| pair.client.poll_event()).collect();
    outcomes.sort_by_key(|event| event.call);
    let outcomes = outcomes.into_iter().map(|event| (event.call, event.outcome));
    assert_eq!(
        outcomes.collect::<Vec<_>>(),
        [
            (sent, Outcome::Failed(refused)),
            (waiting, Outcome::Failed(ClientError::NotOpen)),
        ]
    );
    assert!(!pair.client.is_open(connection));
    assert_eq!(pair.client.poll_transmit(), None, "no further packet");
}

#[test]
fn a_lost_connection_is_closed_at_the_server() {
    let mut pair = Pair::registered();
    let connection = pair.open();
    let call = pair.client.request_connected(connection, &read("A"), pair.now).unwrap();
    pair.drive();
    pair.client.handle_timeout(pair.now + Duration::from_secs(5));
    assert_eq!(pair.outcome(call), Outcome::Failed(ClientError::TimedOut));
    assert_eq!(pair.server.connections(), 1);
    let close = pair.client.close_lost(&options(1), pair.now).unwrap();
    assert_eq!(pair.outcome(close), Outcome::Closed);
    assert_eq!(pair.server.connections(), 0);
}

#[test]
fn silence_closes() {
    let mut pair = Pair::new();
    assert_eq!(pair.server.poll_timeout(), Some(Duration::from_secs(30)));
    pair.server.handle_timeout(Duration::from_secs(30), &mut pair.host);
    pair.collect();
    assert_eq!(pair.closed, Some(CloseReason::NotRegistered));
    let mut pair = Pair::registered();
    assert_eq!(pair.server.poll_timeout(), Some(Duration::from_secs(120)));
    pair.server.handle_timeout(Duration::from_secs(120), &mut pair.host);
    pair.collect();
    assert_eq!(pair.closed, Some(CloseReason::Inactive));
}

#[test]
fn replies_never_exceed_their_budget() {
    let mut pair = Pair::registered();
    let call = pair.client.request(&read("A"), None, pair.now).unwrap();
    pair.drive();
    let (id, request, budget) = pair.requests.pop().unwrap();
    assert_eq!(budget, 504);
    pair.server
        .reply(id, &Reply::success(request.service, vec![0; 501]), pair.now);
    assert_eq!(
        pair.outcome(call),
        Outcome::Reply(Reply::error(0x4C, CipStatus::REPLY_TOO_LARGE))
    );
}

#[test]
fn slots_return_to_zero() {
    let mut pair = Pair::registered();
    for _ in 0..20_000 {
        let connection = pair.open();
        let call = pair.client.close(connection, pair.now).unwrap();
        assert_eq!(pair.outcome(call), Outcome::Closed);
    }
    assert_eq!((pair.host.open, pair.server.connections()), (0, 0));
}

#[test]
fn without_randomness_nothing_is_given_out() {
    let mut pair = Pair::new();
    let draws = std::mem::replace(&mut pair.host.draws, Draws::Fails);
    let call = pair.client.register(pair.now);
    let refused = ClientError::Encapsulation {
        command: Command::REGISTER_SESSION,
        status: EncapStatus::NO_MEMORY,
    };
    assert_eq!(pair.outcome(call), Outcome::Failed(refused));
    assert!(!pair.server.is_registered());

    pair.host.draws = draws;
    let call = pair.client.register(pair.now);
    assert_eq!(pair.outcome(call), Outcome::Registered, "the source has recovered");

    pair.host.draws = Draws::Fails;
    let call = pair.client.open(options(1), pair.now).unwrap();
    let refused = ClientError::Refused(CipStatus::RESOURCE_UNAVAILABLE);
    assert_eq!(pair.outcome(call), Outcome::Failed(refused));
    assert_eq!((pair.server.connections(), pair.host.open), (0, 0));
    assert_eq!(pair.host.counters.of(Count::OpenResourceRejects), 1);
}
