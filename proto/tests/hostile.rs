//! Any bytes give a value or an error; decoding reverses encoding.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;
use std::time::Duration;

use arcline_proto::cip::{self, CipStatus, MultipleReplies, Reply, Request};
use arcline_proto::client::{ClientSession, OpenOptions};
use arcline_proto::connection::{ConnectionKey, NetworkParameters};
use arcline_proto::cpf::{ConnectionId, Packet};
use arcline_proto::discovery;
use arcline_proto::encap::{Command, EncapFrame, RegisterSession, SessionHandle};
use arcline_proto::epath::{Epath, PortSegment, Segment, Target};
use arcline_proto::identity::Identity;
use arcline_proto::logix::{Typed, decode_operands, encode_operands};
use arcline_proto::session::{Draws, Event, ServerSession, Settings, TestHost};
use arcline_tag::{Elementary, Value};
use bytes::{Bytes, BytesMut};
use proptest::prelude::*;

fn segment() -> impl Strategy<Value = Segment> {
    prop_oneof![
        any::<u32>().prop_map(Segment::Class),
        any::<u16>().prop_map(|id| Segment::Instance(id.into())),
        any::<u8>().prop_map(|id| Segment::Member(id.into())),
        any::<u32>().prop_map(Segment::Attribute),
        "[A-Za-z_:][A-Za-z0-9_]{0,20}".prop_map(|name| Segment::Symbol(name.into())),
        (0_u16..20, proptest::collection::vec(any::<u8>(), 1..5)).prop_map(|(port, link)| Segment::Port(PortSegment {
            port,
            link: link.into()
        })),
        proptest::collection::vec(any::<u16>(), 0..5)
            .prop_map(|words| Segment::Data(words.iter().flat_map(|word| word.to_le_bytes()).collect())),
    ]
}

/// A session with an open connection (id 2, as [`TestHost`] draws it), fed with `bytes`; a client, fed with them too.
fn feed(bytes: &[u8]) {
    let mut host = TestHost::new(Draws::Counting(0));
    let mut server = ServerSession::new(
        Arc::new(Settings::default()),
        "127.0.0.1:1".parse().unwrap(),
        Duration::ZERO,
    );
    let register = EncapFrame::request(
        Command::REGISTER_SESSION,
        SessionHandle(0),
        [0; 8],
        RegisterSession::CURRENT.to_bytes(),
    );
    let mut buf = BytesMut::from(&register.to_bytes()[..]);
    let key = ConnectionKey {
        serial: 1,
        vendor: 2,
        originator: 3,
    };
    let mut opener = ClientSession::new(Duration::from_secs(1));
    opener.register(Duration::ZERO);
    let registered = EncapFrame::request(
        Command::REGISTER_SESSION,
        SessionHandle(1),
        [1, 0, 0, 0, 0, 0, 0, 0],
        RegisterSession::CURRENT.to_bytes(),
    );
    opener.handle_frame(&registered);
    opener
        .open(OpenOptions::new(key, ConnectionId(9)), Duration::ZERO)
        .unwrap();
    let open = std::iter::from_fn(|| opener.poll_transmit()).last().unwrap();
    buf.extend_from_slice(&open);
    server.handle_input(&mut buf, Duration::ZERO, &mut host);
    assert_eq!(server.connections(), 1);
    buf.extend_from_slice(bytes);
    server.handle_input(&mut buf, Duration::ZERO, &mut host);
    while let Some(event) = server.poll_event() {
        if let Event::Request {
            id,
            request,
            reply_budget,
            ..
        } = event
        {
            let _ = (Target::new(&request.path), cip::split_multiple(&request.data));
            let _ = MultipleReplies::new(3, reply_budget);
            server.reply(
                id,
                &Reply::error(request.service, CipStatus::SERVICE_NOT_SUPPORTED),
                Duration::ZERO,
            );
        }
    }
    server.handle_timeout(Duration::from_secs(1000), &mut host);
    let mut client = ClientSession::new(Duration::from_secs(1));
    client.register(Duration::ZERO);
    let _ = client.handle_input(&mut BytesMut::from(bytes));
    let _ = discovery::answer(bytes, &host.identity, 0, "127.0.0.1:1".parse().unwrap());
}

/// Frames of every kind, as a base for bit flips; session 1 as [`TestHost`] draws it.
fn corpus() -> Vec<Bytes> {
    let request = |service, path, data: &'static [u8]| Request::new(service, path, data).to_bytes().unwrap();
    let messages = [
        request(0x4C, Epath::symbol("Tag.Member[3]"), &[1, 0]),
        request(
            0x0A,
            Epath::object(2, 1),
            &[2, 0, 6, 0, 10, 0, 1, 1, 0x20, 1, 1, 1, 0x20, 1],
        ),
        request(
            0x52,
            Epath::object(6, 1),
            &[10, 5, 6, 0, 1, 2, 0x20, 1, 0x24, 1, 1, 0, 1, 0],
        ),
        request(
            0x4E,
            Epath::object(6, 1),
            &[10, 5, 1, 0, 2, 0, 3, 0, 0, 0, 2, 0, 0x20, 2, 0x24, 1],
        ),
    ];
    let mut frames: Vec<Bytes> = messages
        .iter()
        .map(|message| {
            let data = Packet::unconnected(message.clone()).to_bytes();
            EncapFrame::request(Command::SEND_RR_DATA, SessionHandle(1), [7; 8], data).to_bytes()
        })
        .collect();
    let unit = Packet::connected(ConnectionId(2), 1, &messages[0]).to_bytes();
    frames.push(EncapFrame::request(Command::SEND_UNIT_DATA, SessionHandle(1), [7; 8], unit).to_bytes());
    frames.push(EncapFrame::request(Command::LIST_IDENTITY, SessionHandle(0), [0; 8], Bytes::new()).to_bytes());
    frames
}

proptest! {
    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        feed(&bytes);
        let bytes = Bytes::from(bytes);
        let _ = (Request::decode(&bytes), Reply::decode(&bytes), Packet::decode(&bytes), Epath::decode(&bytes));
        let _ = (decode_operands(&bytes), cip::split_multiple_replies(&bytes), cip::decode_attribute_ids(&bytes));
    }

    #[test]
    fn any_flip_and_any_prefix(which in 0_usize..6, at in any::<prop::sample::Index>(), flip in 1_u8.., cut in any::<prop::sample::Index>()) {
        let mut bytes = corpus().swap_remove(which).to_vec();
        feed(&bytes);
        let place = at.index(bytes.len());
        bytes[place] ^= flip;
        feed(&bytes);
        bytes.truncate(cut.index(bytes.len() + 1));
        feed(&bytes);
    }

    #[test]
    fn paths_round_trip(segments in proptest::collection::vec(segment(), 0..12)) {
        let path = Epath(segments);
        prop_assert_eq!(Epath::decode(&path.to_bytes()), Ok(path));
    }

    #[test]
    fn requests_and_replies_round_trip(service in 0_u8..0x80, segments in proptest::collection::vec(segment(), 0..8), data in proptest::collection::vec(any::<u8>(), 0..50), general in any::<u8>(), words in proptest::collection::vec(any::<u16>(), 0..4)) {
        let request = Request::new(service, Epath(segments), data.clone());
        prop_assert_eq!(Request::decode(&request.to_bytes().unwrap()), Ok(request));
        let status = words.iter().fold(CipStatus::new(general), |status, word| status.with(*word));
        let reply = Reply::with_status(service, status, data);
        prop_assert_eq!(reply.len(), reply.to_bytes().len());
        prop_assert_eq!(Reply::decode(&reply.to_bytes()), Some(reply));
    }

    #[test]
    fn operands_round_trip(numbers in proptest::collection::vec(any::<i32>(), 1..20), name in "[a-zA-Z]{0,40}") {
        let operands = [Typed::ShortString(name), Typed::Numbers(Elementary::Dint, numbers.into_iter().map(Value::Dint).collect())];
        let mut out = BytesMut::new();
        encode_operands(&operands, &mut out);
        prop_assert_eq!(decode_operands(&out).unwrap(), operands);
    }

    #[test]
    fn network_parameters_round_trip(large in any::<u32>(), small in any::<u16>()) {
        let kept = 0b1110_1110_0000_0000_1111_1111_1111_1111;
        prop_assert_eq!(NetworkParameters::from_large(large).to_large(), large & kept);
        prop_assert_eq!(NetworkParameters::from_small(small).to_small(), small & 0b1110_1111_1111_1111);
    }

    #[test]
    fn multiple_replies_never_exceed_their_budget(sizes in proptest::collection::vec(0_usize..200, 0..20), budget in 0_usize..1000) {
        let Ok(mut replies) = MultipleReplies::new(sizes.len(), budget) else { return Ok(()) };
        for size in &sizes {
            replies.push(&Reply::success(0x4C, vec![0; *size]));
        }
        let reply = replies.finish();
        prop_assert!(reply.len() <= budget);
        prop_assert_eq!(cip::split_multiple_replies(&reply.data).unwrap().len(), sizes.len());
    }
}

#[test]
fn hostile_counts_and_nesting() {
    let inner: Bytes = Request::new(0x0A, Epath::object(2, 1), vec![0, 0]).to_bytes().unwrap();
    let mut packet = vec![1, 0, 4, 0];
    packet.extend_from_slice(&inner);
    let requests = cip::split_multiple(&packet.into()).unwrap();
    assert_eq!(
        requests[0].as_ref().unwrap_err().status,
        CipStatus::SERVICE_NOT_SUPPORTED
    );
    for count in [0_u16, 1, 2, 255, 256, 257, 65_535] {
        for length in 0..20 {
            let mut data = count.to_le_bytes().to_vec();
            data.resize(2 + length, 0xFF);
            let _ = (
                cip::decode_attribute_ids(&data),
                cip::split_multiple(&Bytes::from(data.clone())),
            );
            let mut list = cip::AttributeListReader::new(&data).unwrap();
            while list.next_entry().is_some() {}
        }
    }
    for kind in 0..=255_u8 {
        for filler in [0_u8, 1, 0x91, 0xFF] {
            let mut path = vec![filler; 510];
            path[0] = kind;
            let _ = Epath::decode(&path.into()).map(|path| Target::new(&path).is_ok());
        }
    }
}

/// Two devices that answer each other's replies never stop: a datagram with a forged sender began it.
#[test]
fn a_reply_is_never_answered() {
    let identity = Identity::new("Arcline", 1);
    let local = "127.0.0.1:44818".parse().unwrap();
    for command in [Command::LIST_IDENTITY, Command::LIST_SERVICES, Command::LIST_INTERFACES] {
        let request = EncapFrame::request(command, SessionHandle(0), [0; 8], Bytes::new()).to_bytes();
        let reply = discovery::answer(&request, &identity, 0x120, local).unwrap().frame;
        assert_eq!(
            discovery::answer(&reply.to_bytes(), &identity, 0x120, local),
            None,
            "{command:?}"
        );
    }
}

#[test]
fn identity_over_udp_cut_at_every_byte() {
    let identity = Identity::new("A name that is longer than thirty-two bytes", 1);
    assert_eq!(identity.name().len(), 32);
    let local = "127.0.0.1:44818".parse().unwrap();
    let request = EncapFrame::request(
        Command::LIST_IDENTITY,
        SessionHandle(0),
        [10, 0, 0, 0, 0, 0, 0, 0],
        Bytes::new(),
    )
    .to_bytes();
    for end in 0..request.len() {
        assert_eq!(
            discovery::answer(&request[..end], &identity, 0, local),
            None,
            "cut at {end}"
        );
    }
    let answer = discovery::answer(&request, &identity, 0, local).unwrap();
    assert_eq!(answer.max_delay, Duration::from_millis(10));
    let register = EncapFrame::request(
        Command::REGISTER_SESSION,
        SessionHandle(0),
        [0; 8],
        RegisterSession::CURRENT.to_bytes(),
    );
    assert_eq!(
        discovery::answer(&register.to_bytes(), &identity, 0, local),
        None,
        "not over UDP"
    );
}
