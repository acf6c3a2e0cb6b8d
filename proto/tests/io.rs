//! Class 0 and 1 connections: the hex blocks of spec/ethernet-ip.md §14, the rules for opening, watchdogs, schedules,
//! sequences, and hostile bytes.

#![allow(clippy::unwrap_used)]

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use arcline_proto::cip::{CipStatus, Reply, Request, service};
use arcline_proto::connection::{
    ConnectionKey, ConnectionType, ForwardClose, ForwardOpen, ForwardOpenReply, NetworkParameters, TickTime,
};
use arcline_proto::cpf::{ConnectionId, Item, Packet};
use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, MAX_DATA, RegisterSession, SessionHandle};
use arcline_proto::epath::{ElectronicKey, Epath, PortSegment, Segment};
use arcline_proto::identity::Identity;
use arcline_proto::io::{
    Application, Assemblies, Assembly, DATAGRAM_HEAD, Datagram, Ended, IO_PORT, IoConnections, IoEvent, IoSettings,
    Originator, Ownership,
};
use arcline_proto::session::{Draws, Event, ServerSession, Settings, TestHost, TestIo};
use bytes::{Bytes, BytesMut};
use proptest::prelude::*;

const INPUT: [u8; 32] = [7; 32];
const PEER: IpAddr = IpAddr::V4(Ipv4Addr::new(10, 0, 0, 9));
const GROUP: Ipv4Addr = Ipv4Addr::new(239, 192, 1, 0);
const FROM: SocketAddr = SocketAddr::new(PEER, 40_000);

fn ms(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

fn hex(text: &str) -> Bytes {
    let digits: Vec<u8> = text
        .chars()
        .filter_map(|c| c.to_digit(16))
        .map(|digit| u8::try_from(digit).unwrap())
        .collect();
    assert_eq!(digits.len() % 2, 0, "{text}");
    digits.chunks(2).map(|pair| pair[0] << 4 | pair[1]).collect()
}

/// Where the target's socket is, as the originators see it.
const LOCAL: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::new(10, 0, 0, 1)), IO_PORT);

fn settings() -> IoSettings {
    let assembly = |instance| Assembly { instance, size: 32 };
    IoSettings {
        assemblies: Assemblies {
            input: assembly(0x64),
            output: assembly(0x96),
            configuration: 0x97,
            input_only: 254,
            listen_only: 255,
        },
        max_connections: 4,
        min_interval: 1000,
        volatile: 4,
        local: LOCAL,
    }
}

/// Connections, with a host that draws 1, 2, 3 …
struct Bench {
    io: IoConnections,
    drawn: u32,
    now: Duration,
}

impl Bench {
    fn new() -> Self {
        Self {
            io: IoConnections::new(settings()),
            drawn: 0,
            now: Duration::ZERO,
        }
    }

    fn open_from(&mut self, open: &ForwardOpen, originator: Originator) -> Result<ForwardOpenReply, CipStatus> {
        let drawn = &mut self.drawn;
        let random = || {
            *drawn += 1;
            Some(*drawn)
        };
        let application: Vec<Segment> = open.path.0.clone();
        self.io.open(open, &application, originator, self.now, random)
    }

    fn open(&mut self, open: &ForwardOpen) -> Result<ForwardOpenReply, CipStatus> {
        self.open_from(
            open,
            Originator {
                address: PEER,
                port: None,
                group: Some(GROUP),
            },
        )
    }

    /// Opens, and lets it produce.
    fn run(&mut self, open: &ForwardOpen) -> ConnectionId {
        let id = self.open(open).unwrap().o_to_t_id;
        assert!(self.io.start(id, self.now));
        id
    }

    fn send(&mut self, id: ConnectionId, sequence: u32, data: &[u8]) -> bool {
        let mut out = BytesMut::new();
        Datagram { id, sequence, data }.encode(&mut out);
        self.io.handle_datagram(&out, FROM, self.now)
    }

    /// Owner's data: sequence count, run or idle, 32 bytes.
    fn outputs(&mut self, id: ConnectionId, sequence: u32, run: bool, value: u8) -> bool {
        let mut data = (sequence as u16).to_le_bytes().to_vec();
        data.extend(u32::from(run).to_le_bytes());
        data.extend([value; 32]);
        self.send(id, sequence, &data)
    }

    fn transmit(&mut self) -> Option<(SocketAddr, Bytes)> {
        let mut out = BytesMut::new();
        let to = self.io.poll_transmit(self.now, &INPUT, &mut out)?;
        Some((to, out.freeze()))
    }

    fn events(&mut self) -> Vec<IoEvent> {
        std::iter::from_fn(|| self.io.poll_event()).collect()
    }
}

fn parameters(size: u16) -> NetworkParameters {
    NetworkParameters {
        redundant_owner: false,
        connection_type: ConnectionType::PointToPoint,
        priority: 2,
        variable: false,
        size,
    }
}

fn key(serial: u16) -> ConnectionKey {
    ConnectionKey {
        serial,
        vendor: 0x1337,
        originator: 0x1122_3344,
    }
}

fn points(output: u32, input: u32) -> Epath {
    Epath(vec![
        Segment::Class(4),
        Segment::Instance(0x97),
        Segment::ConnectionPoint(output),
        Segment::ConnectionPoint(input),
    ])
}

/// The exclusive owner of spec/ethernet-ip.md §14.1, at 10 ms.
fn owner(serial: u16) -> ForwardOpen {
    ForwardOpen {
        time: TickTime::DEFAULT,
        o_to_t_id: ConnectionId(0),
        t_to_o_id: ConnectionId(0x0001_0001),
        key: key(serial),
        multiplier: 0,
        o_to_t_rpi: 10_000,
        o_to_t: parameters(38),
        t_to_o_rpi: 10_000,
        t_to_o: parameters(34),
        transport: 0x01,
        path: points(0x96, 0x64),
    }
}

fn input_only(serial: u16) -> ForwardOpen {
    ForwardOpen {
        o_to_t: parameters(2),
        path: points(254, 0x64),
        ..owner(serial)
    }
}

fn listen_only(serial: u16) -> ForwardOpen {
    ForwardOpen {
        path: points(255, 0x64),
        ..input_only(serial)
    }
}

fn connection(code: u16) -> CipStatus {
    CipStatus::connection(code)
}

/// A session that is registered.
struct Session {
    server: ServerSession,
    /// Its ids are those of spec/ethernet-ip.md §14.1.
    device: TestHost,
}

const CONTEXT: [u8; 8] = *b"scanner!";

impl Session {
    fn new() -> Self {
        let local = "10.0.0.1:44818".parse().unwrap();
        let mut this = Self {
            server: ServerSession::new(Arc::new(Settings::default()), local, Duration::ZERO),
            device: TestHost::with_io(
                Draws::Constant(0xD13E_0013),
                TestIo {
                    connections: IoConnections::new(settings()),
                    peer: PEER,
                    group: GROUP,
                    now: Duration::ZERO,
                },
            ),
        };
        let register = EncapFrame::request(
            Command::REGISTER_SESSION,
            SessionHandle(0),
            CONTEXT,
            RegisterSession::CURRENT.to_bytes(),
        );
        this.feed(&register.to_bytes());
        this.events();
        this
    }

    fn feed(&mut self, bytes: &[u8]) {
        let mut buf = BytesMut::from(bytes);
        self.server.handle_input(&mut buf, Duration::ZERO, &mut self.device);
    }

    fn events(&mut self) -> Vec<Event> {
        std::iter::from_fn(|| self.server.poll_event()).collect()
    }

    /// The items of the reply to a message with further items.
    fn ask(&mut self, message: Bytes, items: &[Item]) -> (Vec<Item>, Vec<Event>) {
        let mut packet = Packet::unconnected(message);
        packet.items.extend_from_slice(items);
        let frame = EncapFrame::request(
            Command::SEND_RR_DATA,
            SessionHandle(0xD13E_0013),
            CONTEXT,
            packet.to_bytes(),
        );
        self.feed(&frame.to_bytes());
        let mut events = self.events();
        let Some(Event::Outgoing(bytes)) = events.first().cloned() else {
            panic!("no reply but {events:?}");
        };
        events.remove(0);
        let frame = FrameDecoder::new(MAX_DATA)
            .decode(&mut BytesMut::from(&bytes[..]))
            .unwrap()
            .unwrap();
        (Packet::decode(&frame.data).unwrap().items, events)
    }
}

const FORWARD_OPEN: &str = "54 02 2006 2401 | 0a 0e | 00000000 | 01000100 | 7700 | 3713 | 44332211 | 00 000000 |
    a0860100 | 2648 | a0860100 | 2248 | 01 | 04 | 2004 2497 2c96 2c64";
const FORWARD_OPEN_REPLY: &str = "d4 00 00 00 | 13003ed1 | 01000100 | 7700 3713 44332211 | a0860100 | a0860100 | 00 00";
const O_TO_T: &str = "0200 | 0280 0800 13003ed1 01000000 | b100 2600 | 0100 | 01000000 |
    000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f";
const T_TO_O: &str = "0200 | 0280 0800 01000100 01000000 | b100 2200 | 0100 |
    000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f";

#[test]
fn forward_open_of_14_1() {
    let mut session = Session::new();
    let (items, events) = session.ask(hex(FORWARD_OPEN), &[]);
    let expected = [
        Item::NullAddress,
        Item::UnconnectedData(hex(FORWARD_OPEN_REPLY)),
        Item::SockaddrOToT("0.0.0.0:2222".parse().unwrap()),
    ];
    assert_eq!(items, expected);
    // The reply leaves first, then the connection may produce.
    assert_eq!(events, [Event::IoReady(ConnectionId(0xD13E_0013))]);

    // The datagrams of spec/ethernet-ip.md §14.2.
    let io = &mut session.device.io().connections;
    assert!(io.start(ConnectionId(0xD13E_0013), ms(0)));
    let data: Vec<u8> = (0..32).collect();
    let mut out = BytesMut::new();
    assert_eq!(
        io.poll_transmit(ms(0), &data, &mut out),
        Some(SocketAddr::new(PEER, IO_PORT))
    );
    assert_eq!(out, hex(T_TO_O));
    assert!(io.handle_datagram(&hex(O_TO_T), FROM, ms(1)));
    assert_eq!(io.poll_event(), Some(IoEvent::Outputs(data.into())));
    assert_eq!(io.outputs(), Ownership::Run);

    // And the close.
    let close = ForwardClose {
        time: TickTime::DEFAULT,
        key: ConnectionKey {
            serial: 0x77,
            vendor: 0x1337,
            originator: 0x1122_3344,
        },
        path: points(0x96, 0x64),
    };
    let close = Request::new(service::FORWARD_CLOSE, Epath::object(6, 1), close.to_bytes().unwrap());
    let (items, _) = session.ask(close.to_bytes().unwrap(), &[]);
    let expected = hex("ce 00 00 00 | 7700 3713 44332211 00 00");
    assert_eq!(items, [Item::NullAddress, Item::UnconnectedData(expected)]);
    let (items, _) = session.ask(close.to_bytes().unwrap(), &[]);
    let expected = hex("ce 00 01 01 0701 | 7700 3713 44332211 00 00");
    assert_eq!(items, [Item::NullAddress, Item::UnconnectedData(expected)]);
}

#[test]
fn datagrams_cut_at_every_byte() {
    for text in [O_TO_T, T_TO_O] {
        let bytes = hex(text);
        let datagram = Datagram::decode(&bytes).unwrap();
        assert_eq!(datagram.data.len(), bytes.len() - DATAGRAM_HEAD);
        let mut again = BytesMut::new();
        datagram.encode(&mut again);
        assert_eq!(again, bytes);
        for end in 0..bytes.len() {
            assert!(Datagram::decode(&bytes[..end]).is_err(), "cut at {end}");
        }
        // Surplus bytes and items are ignored.
        assert_eq!(Datagram::decode(&[&bytes[..], &[1, 2, 3]].concat()), Ok(datagram));
    }
    #[rustfmt::skip]
    let wrong = [
        ("no items",                 "0000"),
        ("one item",                 "0100 | 0280 0800 0100000001000000"),
        ("address of 7 bytes",       "0200 | 0280 0700 01000000010000 | b100 0000"),
        ("address of 9 bytes",       "0200 | 0280 0900 010000000100000000 | b100 0000"),
        ("a connected address",      "0200 | a100 0400 01000000 | b100 0000"),
        ("unconnected data",         "0200 | 0280 0800 0100000001000000 | b200 0000"),
        ("data beyond the end",      "0200 | 0280 0800 0100000001000000 | b100 ffff"),
        ("an address beyond it",     "0200 | 0280 ffff 0100000001000000 | b100 0000"),
    ];
    for (why, text) in wrong {
        assert!(Datagram::decode(&hex(text)).is_err(), "{why}");
    }
}

#[test]
fn permitted_applications_of_a_forward_open() {
    type Change = fn(&mut ForwardOpen);
    #[rustfmt::skip]
    let cases: [(&str, Change, Result<(), CipStatus>); 43] = [
        ("as it should be",               |_| {},                                                    Ok(())),
        ("class 0: no sequence count",    |o| { o.transport = 0; o.o_to_t.size = 36; o.t_to_o.size = 32; }, Ok(())),
        ("server direction",              |o| o.transport = 0x81,                                    Ok(())),
        ("class 2",                       |o| o.transport = 2,                                       Err(connection(0x011C))),
        ("change of state",               |o| o.transport = 0x11,                                    Ok(())),
        ("application trigger",           |o| o.transport = 0x21,                                    Err(connection(0x011D))),
        ("multiplier 512",                |o| o.multiplier = 7,                                      Ok(())),
        ("no such multiplier",            |o| o.multiplier = 8,                                      Err(connection(0x0133))),
        ("1 ms",                          |o| { o.o_to_t_rpi = 1000; o.t_to_o_rpi = 1000; },         Ok(())),
        ("faster in",                     |o| o.t_to_o_rpi = 999,                                    Err(connection(0x0111))),
        ("faster out",                    |o| o.o_to_t_rpi = 999,                                    Err(connection(0x0111))),
        ("never",                         |o| o.o_to_t_rpi = 0,                                      Err(connection(0x0111))),
        ("slowest",                       |o| { o.o_to_t_rpi = 10_000_000; o.t_to_o_rpi = 10_000_000; }, Ok(())),
        ("slower out",                    |o| o.o_to_t_rpi = 10_000_001,                             Err(connection(0x0111))),
        ("slower in",                     |o| o.t_to_o_rpi = u32::MAX,                               Err(connection(0x0111))),
        ("a watchdog of a minute",        |o| { o.o_to_t_rpi = 3_750_000; o.multiplier = 2; },       Ok(())),
        ("a watchdog of more",            |o| { o.o_to_t_rpi = 3_750_001; o.multiplier = 2; },       Err(connection(0x0133))),
        ("multicast out",                 |o| o.o_to_t.connection_type = ConnectionType::Multicast,  Err(connection(0x0123))),
        ("null out",                      |o| o.o_to_t.connection_type = ConnectionType::Null,       Err(connection(0x0123))),
        ("null in",                       |o| o.t_to_o.connection_type = ConnectionType::Null,       Err(connection(0x0124))),
        ("reserved type",                 |o| o.t_to_o.connection_type = ConnectionType::Reserved,   Err(connection(0x0124))),
        ("redundant owner",               |o| o.o_to_t.redundant_owner = true,                       Err(connection(0x0125))),
        ("variable sizes",                |o| { o.o_to_t.variable = true; o.t_to_o.variable = true; }, Ok(())),
        ("no run/idle header",            |o| o.o_to_t.size = 34,                                    Err(connection(0x0127).with(38))),
        ("output too small",              |o| o.o_to_t.size = 37,                                    Err(connection(0x0127).with(38))),
        ("output too large",              |o| o.o_to_t.size = 39,                                    Err(connection(0x0127).with(38))),
        ("input too small",               |o| o.t_to_o.size = 33,                                    Err(connection(0x0128).with(34))),
        ("input with a header",           |o| o.t_to_o.size = 38,                                    Err(connection(0x0128).with(34))),
        ("class 0 with a count",          |o| o.transport = 0,                                       Err(connection(0x0127).with(36))),
        ("input only",                    |o| *o = input_only(1),                                    Ok(())),
        ("input only with a header",      |o| { *o = input_only(1); o.o_to_t.size = 6; },            Ok(())),
        ("heartbeat with data",           |o| { *o = input_only(1); o.o_to_t.size = 38; },           Err(connection(0x0127).with(2))),
        ("listens to nobody",             |o| *o = listen_only(1),                                   Err(connection(0x0119))),
        ("no configuration",              |o| { o.path.0.remove(1); },                               Ok(())),
        ("configuration as a point",      |o| o.path.0[1] = Segment::ConnectionPoint(0x97),          Ok(())),
        ("other configuration",           |o| o.path.0[1] = Segment::Instance(1),                    Err(connection(0x0129))),
        ("other output",                  |o| o.path.0[2] = Segment::ConnectionPoint(0x95),          Err(connection(0x012A))),
        ("other input",                   |o| o.path.0[3] = Segment::ConnectionPoint(0x65),          Err(connection(0x012B))),
        ("empty configuration data",      |o| o.path.0.push(Segment::Data(Bytes::new())),            Ok(())),
        ("configuration data",            |o| o.path.0.push(Segment::Data(hex("0102"))),             Err(connection(0x0126).with(0))),
        ("another class",                 |o| o.path.0[0] = Segment::Class(5),                       Err(connection(0x0117))),
        ("no class",                      |o| { o.path.0.remove(0); },                               Err(connection(0x0315))),
        ("a point too many",              |o| o.path.0.push(Segment::ConnectionPoint(1)),            Err(connection(0x0315))),
    ];
    for (why, change, expected) in cases {
        let mut bench = Bench::new();
        let mut open = owner(1);
        change(&mut open);
        let opened = bench.open(&open);
        assert_eq!(opened.clone().map(drop), expected, "{why}");
        assert_eq!(bench.io.len(), usize::from(expected.is_ok()), "{why}");
        if let Ok(reply) = opened {
            // The reply confirms the requested values, with which the connection works.
            assert_eq!(
                (reply.o_to_t_api, reply.t_to_o_api, reply.t_to_o_id),
                (open.o_to_t_rpi, open.t_to_o_rpi, open.t_to_o_id),
                "{why}"
            );
        }
    }
}

#[test]
fn connections_beside_open_ones() {
    let mut bench = Bench::new();
    let first = bench.run(&owner(1));
    assert_eq!(bench.open(&owner(1)), Err(connection(0x0100)), "the same again");
    assert_eq!(bench.open(&owner(2)), Err(connection(0x0106)), "a second owner");
    let second = bench.run(&input_only(3));
    let third = bench.run(&listen_only(4));
    let fourth = bench.run(&input_only(5));
    assert_eq!(bench.open(&input_only(6)), Err(connection(0x0113)), "no room");
    assert_eq!(bench.io.len(), 4);

    // Only from where it was opened.
    let elsewhere = IpAddr::V4(Ipv4Addr::new(10, 0, 0, 8));
    assert_eq!(bench.io.close(key(1), elsewhere), Err(connection(0x0107)));
    assert_eq!(bench.io.close(key(9), PEER), Err(connection(0x0107)));
    assert!(bench.events().is_empty());

    // The ownership is free again; a listen-only connection stays as long as its multicast production.
    assert_eq!(bench.io.close(key(1), PEER), Ok(()));
    assert_eq!(bench.io.close(key(3), PEER), Ok(()));
    assert_eq!(bench.io.len(), 2);
    assert_eq!(bench.io.outputs(), Ownership::Free);
    assert_eq!(bench.io.close(key(5), PEER), Ok(()));
    assert!(bench.io.is_empty());
    let ended = |id, application, cause| IoEvent::Ended {
        id,
        application,
        cause,
        outputs_lost: false,
    };
    let expected = [
        ended(first, Application::ExclusiveOwner, Ended::Closed),
        ended(second, Application::InputOnly, Ended::Closed),
        ended(fourth, Application::InputOnly, Ended::Closed),
        ended(third, Application::ListenOnly, Ended::NothingToHear),
    ];
    assert_eq!(bench.events(), expected);
    bench.run(&owner(2));
}

#[test]
fn a_null_forward_open_confirms_the_open_connection() {
    let mut bench = Bench::new();
    let mut null = owner(1);
    null.o_to_t.connection_type = ConnectionType::Null;
    null.t_to_o.connection_type = ConnectionType::Null;
    assert_eq!(bench.open(&null), Err(connection(0x0132)), "nothing to confirm");
    let reply = bench.open(&owner(1)).unwrap();
    bench.now = ms(9_999);
    assert_eq!(bench.open(&null), Ok(reply));
    let elsewhere = Originator {
        address: LOCAL.ip(),
        port: None,
        group: None,
    };
    assert_eq!(bench.open_from(&null, elsewhere), Err(connection(0x0100)));
    // It is no sign of life.
    bench.now = ms(10_000);
    assert_eq!(bench.open(&null), Err(connection(0x0132)));
}

#[test]
fn the_watchdog_is_exact() {
    let mut bench = Bench::new();
    let id = bench.run(&owner(1));
    // The first datagram may take 10 s, the next ones 4 intervals of 10 ms.
    bench.now = ms(9_999);
    bench.io.handle_timeout(bench.now);
    assert!(bench.outputs(id, 1, true, 1));
    assert_eq!(bench.events(), [IoEvent::Outputs(Bytes::from_static(&[1; 32]))]);
    bench.now += ms(40) - Duration::from_nanos(1);
    bench.io.handle_timeout(bench.now);
    assert_eq!(bench.io.outputs(), Ownership::Run);
    bench.now += Duration::from_nanos(1);
    bench.io.handle_timeout(bench.now);
    let lost = |cause| IoEvent::Ended {
        id,
        application: Application::ExclusiveOwner,
        cause,
        outputs_lost: true,
    };
    assert_eq!(bench.events(), [lost(Ended::TimedOut)]);
    assert_eq!(bench.io.poll_timeout(), None);
    assert!(!bench.outputs(id, 2, true, 1), "a stale id");

    // A stale connection is ended by the Forward Open that finds it, also under the same name.
    let id = bench.run(&owner(1));
    bench.outputs(id, 1, true, 1);
    bench.now += ms(40);
    bench.run(&owner(1));
    assert_eq!(bench.events().len(), 2);
    assert_eq!(bench.io.len(), 1);
}

/// A Forward Open whose originator sends nothing holds its place for 10 s, with any watchdog.
#[test]
fn a_silent_originator_frees_its_place() {
    let mut bench = Bench::new();
    let slow = ForwardOpen {
        o_to_t_rpi: 100_000,
        multiplier: 7,
        ..owner(1)
    };
    bench.run(&slow);
    bench.now = ms(9_999);
    bench.io.handle_timeout(bench.now);
    assert_eq!(bench.open(&owner(2)), Err(connection(0x0106)));
    bench.now = ms(10_000);
    assert!(bench.open(&owner(2)).is_ok());
}

#[test]
fn those_that_listen_end_when_the_owner_is_silent() {
    let mut bench = Bench::new();
    let id = bench.run(&owner(1));
    let listener = bench.run(&listen_only(2));
    bench.outputs(id, 1, true, 1);
    bench.send(listener, 1, &[1, 0]);
    bench.now = ms(30);
    bench.send(listener, 2, &[2, 0]);
    bench.now = ms(40);
    bench.io.handle_timeout(bench.now);
    assert!(bench.io.is_empty());
    let causes: Vec<_> = bench
        .events()
        .into_iter()
        .filter_map(|event| match event {
            IoEvent::Ended { cause, .. } => Some(cause),
            _ => None,
        })
        .collect();
    assert_eq!(causes, [Ended::TimedOut, Ended::NothingToHear]);
}

#[test]
fn the_schedule_is_absolute() {
    let mut bench = Bench::new();
    let id = bench.open(&owner(1)).unwrap().o_to_t_id;
    assert_eq!(bench.transmit(), None, "nothing before the reply has left");
    assert!(!bench.io.is_due(ms(5)));
    bench.now = ms(5);
    bench.io.start(id, bench.now);
    bench.io.start(id, ms(6));
    let mut sent = Vec::new();
    // 45.5: late by half a millisecond; 80: three were missed.
    for at in [
        5_000, 14_999, 15_000, 25_000, 35_000, 45_500, 54_999, 55_000, 89_999, 90_000, 95_000,
    ] {
        bench.now = Duration::from_micros(at);
        while let Some((to, bytes)) = bench.transmit() {
            assert_eq!(to, SocketAddr::new(PEER, IO_PORT));
            let datagram = Datagram::decode(&bytes).unwrap();
            assert_eq!(datagram.id, ConnectionId(0x0001_0001));
            assert_eq!(datagram.data[2..], INPUT);
            let count = u16::from_le_bytes([datagram.data[0], datagram.data[1]]);
            assert_eq!(u32::from(count), datagram.sequence);
            sent.push((at, datagram.sequence));
        }
    }
    let expected = [
        (5_000, 1),
        (15_000, 2),
        (25_000, 3),
        (35_000, 4),
        (45_500, 5),
        (55_000, 6),
        (89_999, 7),
        (95_000, 8),
    ];
    assert_eq!(sent, expected);
    assert_eq!(bench.io.poll_timeout(), Some(ms(105)));
}

#[test]
fn class_0_has_no_sequence_count() {
    let mut bench = Bench::new();
    let mut open = owner(1);
    open.transport = 0;
    open.o_to_t.size = 36;
    open.t_to_o.size = 32;
    let id = bench.run(&open);
    let (_, bytes) = bench.transmit().unwrap();
    assert_eq!(Datagram::decode(&bytes).unwrap().data, INPUT);
    let mut data = vec![1, 0, 0, 0];
    data.extend([5; 32]);
    assert!(bench.send(id, 1, &data));
    assert!(bench.send(id, 2, &data), "nothing tells that it is not new");
    assert_eq!(bench.events().len(), 2);
}

#[test]
fn sequences_addresses_and_modes() {
    let mut bench = Bench::new();
    let id = bench.run(&owner(1));
    let outputs = |value: u8| IoEvent::Outputs(vec![value; 32].into());
    assert!(bench.outputs(id, u32::MAX, true, 1), "any first one");
    assert!(!bench.outputs(id, u32::MAX, true, 2), "the same again");
    assert!(!bench.outputs(id, u32::MAX - 1, true, 3), "an older one");
    assert!(bench.outputs(id, 0, true, 4), "it wraps");
    assert!(bench.outputs(id, 5, true, 5), "some were lost");
    assert!(!bench.outputs(id, 5 + (1 << 31), true, 6), "half way round is older");
    assert!(!bench.outputs(ConnectionId(77), 6, true, 7), "an id that was guessed");
    assert_eq!(bench.events(), [outputs(1), outputs(4), outputs(5)]);

    // From another address it does not count, from another port it does.
    let mut out = BytesMut::new();
    let mut data = vec![6, 0, 1, 0, 0, 0];
    data.extend([8; 32]);
    Datagram {
        id,
        sequence: 6,
        data: &data,
    }
    .encode(&mut out);
    assert!(
        !bench
            .io
            .handle_datagram(&out, SocketAddr::new(LOCAL.ip(), 40_000), ms(0))
    );
    assert!(bench.io.handle_datagram(&out, SocketAddr::new(PEER, 41_000), ms(0)));
    assert_eq!(bench.events(), [outputs(8)]);

    // The same 16-bit count: a sign of life, but no new data.
    data[6..].fill(9);
    assert!(bench.send(id, 7, &data));
    assert_eq!(bench.events(), []);
    // Idle is said once, and again after the next run.
    assert!(bench.outputs(id, 8, false, 9));
    assert!(bench.outputs(id, 9, false, 9));
    assert_eq!(bench.events(), [IoEvent::Idle]);
    assert_eq!(bench.io.outputs(), Ownership::Idle);
    assert!(bench.outputs(id, 10, true, 9));
    assert!(bench.outputs(id, 11, false, 9));
    assert_eq!(bench.events(), [outputs(9), IoEvent::Idle]);
    // An idle owner that goes takes nothing with it.
    bench.now = ms(40);
    bench.io.handle_timeout(bench.now);
    assert!(matches!(
        bench.events().as_slice(),
        [IoEvent::Ended {
            outputs_lost: false,
            ..
        }]
    ));
}

#[test]
fn data_of_every_length() {
    let mut bench = Bench::new();
    let id = bench.run(&owner(1));
    let mut data = [0; 64];
    data[2] = 1;
    for (sequence, length) in (1..).zip(0..=64) {
        data[0] = sequence as u8;
        let taken = bench.send(id, sequence, &data[..length]);
        // Surplus bytes are ignored, and a short datagram does not count.
        assert_eq!(taken, length >= 38, "{length} bytes");
        assert_eq!(bench.events().len(), usize::from(taken), "{length} bytes");
    }
    let id = bench.run(&input_only(2));
    assert!(!bench.send(id, 1, &[]));
    assert!(!bench.send(id, 1, &[1]));
    assert!(bench.send(id, 1, &[1, 0]));
    assert_eq!(bench.events(), []);
}

#[test]
fn where_inputs_go() {
    let mut bench = Bench::new();
    let to = |bench: &mut Bench, address, port| {
        bench.io = IoConnections::new(settings());
        let id = bench
            .open_from(
                &owner(1),
                Originator {
                    address,
                    port,
                    group: None,
                },
            )
            .unwrap()
            .o_to_t_id;
        bench.io.start(id, bench.now);
        let mut data = vec![1, 0, 1, 0, 0, 0];
        data.extend([8; 32]);
        let mut out = BytesMut::new();
        Datagram {
            id,
            sequence: 1,
            data: &data,
        }
        .encode(&mut out);
        let before = bench.transmit().unwrap().0.port();
        assert!(
            bench
                .io
                .handle_datagram(&out, SocketAddr::new(address, 40_000), bench.now)
        );
        bench.now += ms(10);
        (before, bench.transmit().unwrap().0.port())
    };
    assert_eq!(to(&mut bench, PEER, None), (2222, 2222), "the port of I/O");
    assert_eq!(to(&mut bench, PEER, Some(5000)), (5000, 5000), "where it listens");
    assert_eq!(to(&mut bench, PEER, Some(0)), (2222, 2222), "no port");
    // On our own host our port is ours: it listens where it sends from.
    assert_eq!(to(&mut bench, LOCAL.ip(), None), (2222, 40_000));
    assert_eq!(to(&mut bench, LOCAL.ip(), Some(5000)), (5000, 5000));
}

#[test]
fn key_ports_and_network_segments_are_looked_at_first() {
    let mut session = Session::new();
    let identity = Identity::new("Arcline", 1);
    let key = |vendor, device_type, major| {
        Segment::Key(ElectronicKey {
            vendor,
            device_type,
            product_code: 0,
            major,
            minor: 0,
        })
    };
    let inhibit = Segment::Network {
        kind: 0x43,
        data: Bytes::from_static(&[1]),
    };
    let slot = |slot| Segment::Port(PortSegment::backplane(slot));
    #[rustfmt::skip]
    let cases = [
        ("any device",         vec![key(0, 0, 0)],                                  CipStatus::SUCCESS),
        ("this device",        vec![slot(0), key(identity.vendor, 0x0E, 0x80 | 33)], CipStatus::SUCCESS),
        ("inhibit time",       vec![inhibit],                                       CipStatus::SUCCESS),
        ("another vendor",     vec![key(1, 0, 0)],                                  connection(0x0114)),
        ("another type",       vec![key(0, 0x0C, 0)],                               connection(0x0115)),
        ("another revision",   vec![key(0, 0, 34)],                                 connection(0x0116)),
        ("another slot",       vec![slot(1)],                                       connection(0x0312)),
    ];
    for (serial, (why, mut segments, expected)) in (1..).zip(cases) {
        let mut open = input_only(serial);
        segments.append(&mut open.path.0);
        open.path = Epath(segments);
        let request = Request::new(
            service::LARGE_FORWARD_OPEN,
            Epath::object(6, 1),
            open.to_bytes(true).unwrap(),
        );
        let (items, events) = session.ask(request.to_bytes().unwrap(), &[]);
        let Some(Item::UnconnectedData(data)) = items.get(1) else {
            panic!("{why}: {items:?}");
        };
        let reply = Reply::decode(data).unwrap();
        assert_eq!(reply.status, expected, "{why}");
        assert_eq!(items.len(), if expected.is_success() { 3 } else { 2 }, "{why}");
        assert_eq!(events.len(), usize::from(expected.is_success()), "{why}");
        let _ = session.device.io().connections.close(open.key, PEER);
    }
}

#[test]
fn the_originators_port_is_item_8001() {
    let mut session = Session::new();
    let address = Item::SockaddrTToO("239.192.1.1:5000".parse().unwrap());
    session.ask(hex(FORWARD_OPEN), &[address]);
    let io = &mut session.device.io().connections;
    io.start(ConnectionId(0xD13E_0013), ms(0));
    let to = io.poll_transmit(ms(0), &INPUT, &mut BytesMut::new());
    assert_eq!(
        to,
        Some(SocketAddr::new(PEER, 5000)),
        "the address is that of the TCP connection"
    );
}

#[test]
fn forward_open_and_close_at_every_length_and_byte() {
    let open = hex(FORWARD_OPEN);
    let close = hex("4e 02 2006 2401 | 0a 0e | 7700 3713 44332211 | 04 00 | 2004 2497 2c96 2c64");
    for message in [&open, &close] {
        for end in 0..message.len() {
            let mut session = Session::new();
            session.ask(message.slice(..end), &[]);
            assert!(session.device.io().connections.len() <= 1);
        }
        for place in 0..message.len() {
            for bit in 0..8 {
                let mut session = Session::new();
                session.ask(open.clone(), &[]);
                let mut altered = message.to_vec();
                altered[place] ^= 1 << bit;
                let frame = EncapFrame::request(
                    Command::SEND_RR_DATA,
                    SessionHandle(0xD13E_0013),
                    CONTEXT,
                    Packet::unconnected(altered.into()).to_bytes(),
                );
                session.feed(&frame.to_bytes());
                assert!(session.device.io().connections.len() <= 2, "byte {place}, bit {bit}");
            }
        }
    }
}

#[test]
fn a_million_open_and_close_and_expire_leave_nothing() {
    // Half as many of each kind; an id may come back only when it is free.
    let mut bench = Bench::new();
    for round in 0..500_000_u32 {
        let serial = round as u16;
        bench.run(&owner(serial));
        bench.io.close(key(serial), PEER).unwrap();
        bench.run(&input_only(serial));
        bench.now += ms(10_000);
        bench.io.handle_timeout(bench.now);
        assert!(bench.io.is_empty());
        assert_eq!(bench.events().len(), 2);
    }
}

proptest! {
    #[test]
    fn any_datagram_is_taken_or_dropped(bytes in proptest::collection::vec(any::<u8>(), 0..80), at in 0_usize..60, with in any::<u8>()) {
        let mut bench = Bench::new();
        let id = bench.run(&owner(1));
        bench.io.handle_datagram(&bytes, FROM, ms(1));
        let mut valid = BytesMut::new();
        let mut data = vec![1, 0, 1, 0, 0, 0];
        data.extend([8; 32]);
        Datagram { id, sequence: 1, data: &data }.encode(&mut valid);
        if let Some(byte) = valid.get_mut(at) {
            *byte = with;
        }
        bench.io.handle_datagram(&valid, FROM, ms(2));
        prop_assert!(bench.events().len() <= 2);
        prop_assert_eq!(bench.io.len(), 1);
    }
}

fn multicast(open: ForwardOpen) -> ForwardOpen {
    ForwardOpen {
        t_to_o: NetworkParameters {
            connection_type: ConnectionType::Multicast,
            ..open.t_to_o
        },
        ..open
    }
}

/// Consumers of one group at one interval share one production under an id of the target's: one datagram for all of them.
#[test]
fn a_group_is_sent_each_datagram_once() {
    let mut bench = Bench::new();
    let first = bench.open(&multicast(owner(1))).unwrap();
    assert_ne!(first.t_to_o_id, owner(1).t_to_o_id, "the target chooses it");
    assert!(bench.io.start(first.o_to_t_id, bench.now));
    let second = bench.open(&multicast(listen_only(2))).unwrap();
    assert_eq!(second.t_to_o_id, first.t_to_o_id, "shared");
    assert!(bench.io.start(second.o_to_t_id, bench.now));
    let mut slow = multicast(listen_only(3));
    slow.t_to_o_rpi = 20_000;
    let slow = bench.open(&slow).unwrap();
    assert_ne!(slow.t_to_o_id, first.t_to_o_id, "another interval");
    assert!(bench.io.start(slow.o_to_t_id, bench.now));
    let group = SocketAddr::new(GROUP.into(), IO_PORT);
    for id in [&first, &second, &slow].map(|reply| reply.o_to_t_id) {
        assert_eq!(bench.io.group(id), Some(group));
    }
    let sent = |bench: &mut Bench| {
        let mut sent = Vec::new();
        while let Some((to, bytes)) = bench.transmit() {
            assert_eq!(to, group);
            let datagram = Datagram::decode(&bytes).unwrap();
            sent.push((datagram.id, datagram.sequence));
        }
        sent.sort_unstable();
        sent
    };
    let (fast_id, slow_id) = (first.t_to_o_id, slow.t_to_o_id);
    let mut both = vec![(fast_id, 1), (slow_id, 1)];
    both.sort_unstable();
    assert_eq!(sent(&mut bench), both);
    bench.now = ms(10);
    assert_eq!(sent(&mut bench), [(fast_id, 2)]);
    // The connection that opened it closes; the others receive further data, and no production begins anew.
    assert!(bench.io.close(key(1), PEER).is_ok());
    assert!(bench.io.is_empty(), "those that only listened have gone with it");
    bench.now = ms(20);
    assert_eq!(sent(&mut bench), []);
    let owner_again = bench.open(&multicast(owner(4))).unwrap();
    let listener = bench.open(&multicast(input_only(5))).unwrap();
    bench.io.start(owner_again.o_to_t_id, bench.now);
    bench.io.start(listener.o_to_t_id, bench.now);
    let id = listener.t_to_o_id;
    assert_eq!(sent(&mut bench), [(id, 1)]);
    assert!(bench.io.close(key(4), PEER).is_ok());
    bench.now = ms(30);
    assert_eq!(sent(&mut bench), [(id, 2)]);
    assert!(bench.io.close(key(5), PEER).is_ok());
    bench.now = ms(40);
    assert_eq!(sent(&mut bench), []);
}

#[test]
fn without_a_group_multicast_is_refused() {
    let mut bench = Bench::new();
    let nowhere = Originator {
        address: PEER,
        port: None,
        group: None,
    };
    assert_eq!(bench.open_from(&multicast(owner(1)), nowhere), Err(connection(0x0124)));
}

/// Sent when it changes, not more often than the inhibit time allows, and at the interval when it does not. The first bytes,
/// the tick, are no change. The sequence count goes up with new data only.
#[test]
fn a_change_of_state_is_sent_when_it_comes() {
    let mut bench = Bench::new();
    let mut open = input_only(1);
    open.transport = 0x11;
    open.t_to_o_rpi = 100_000;
    open.path.0.insert(
        0,
        Segment::Network {
            kind: 0x43,
            data: Bytes::from_static(&[5]),
        },
    );
    let drawn = &mut bench.drawn;
    let random = || {
        *drawn += 1;
        Some(*drawn)
    };
    let originator = Originator {
        address: PEER,
        port: None,
        group: None,
    };
    let application = &open.path.0[1..];
    let id = bench
        .io
        .open(&open, application, originator, Duration::ZERO, random)
        .unwrap();
    bench.io.start(id.o_to_t_id, Duration::ZERO);
    let mut data = INPUT;
    let mut sent = Vec::new();
    for time in 0..400_u64 {
        bench.now = ms(time);
        data[..4].copy_from_slice(&(time as u32).to_le_bytes());
        // A single change, one that lasts, and two that are closer than 5 ms.
        data[10] = match time {
            0..50 => 0,
            50..120 => 1,
            120..140 => time as u8,
            _ => 2,
        };
        if bench.io.is_due(bench.now) {
            let mut out = BytesMut::new();
            while bench.io.poll_transmit(bench.now, &data, &mut out).is_some() {
                let datagram = Datagram::decode(&out).unwrap();
                let count = u16::from_le_bytes([datagram.data[0], datagram.data[1]]);
                sent.push((time, datagram.sequence, count));
                out.clear();
            }
            assert!(!bench.io.is_due(bench.now), "once is enough");
        }
    }
    let expected: Vec<(u64, u32, u16)> = [
        (0, 1),
        (50, 2),
        (120, 3),
        (125, 4),
        (130, 5),
        (135, 6),
        (140, 7),
        (240, 7),
        (340, 7),
    ]
    .iter()
    .zip(1..)
    .map(|((time, count), sequence)| (*time, sequence, *count))
    .collect();
    assert_eq!(sent, expected);
}
