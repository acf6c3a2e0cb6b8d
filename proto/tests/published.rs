//! Published failures of other stacks (spec/ethernet-ip.md §20) in decoders and in connections that come and go, each a
//! test named after it. The others are in `server/src/eip/tests/published.rs`.
//!
//! `ARCLINE_CYCLES` makes the long ones longer.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;
use std::time::Duration;

use arcline_proto::cip::{self, Reply, Request};
use arcline_proto::connection::{
    ConnectionKey, ForwardClose, ForwardOpen, ForwardOpenReply, NetworkParameters, TRANSPORT_CLASS_3, TickTime,
};
use arcline_proto::cpf::{ConnectionId, Packet, decode_items};
use arcline_proto::discovery;
use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, RegisterSession, SessionHandle};
use arcline_proto::epath::{Epath, Target};
use arcline_proto::identity::Identity;
use arcline_proto::logix::{ReadReply, Symbol, TemplateAttributes};
use arcline_proto::session::{CloseReason, Draws, Event, ServerSession, Settings, TestHost};
use bytes::{Bytes, BytesMut};

/// A registered session, which answers every request that reaches it.
struct Bench {
    host: TestHost,
    session: ServerSession,
    handle: SessionHandle,
    now: Duration,
    replies: Vec<EncapFrame>,
    closed: Option<CloseReason>,
}

impl Bench {
    fn new() -> Self {
        let host = TestHost::new(Draws::Counting(0));
        let local = "127.0.0.1:44818".parse().unwrap();
        let session = ServerSession::new(Arc::new(Settings::default()), local, Duration::ZERO);
        let mut bench = Self {
            host,
            session,
            handle: SessionHandle(0),
            now: Duration::ZERO,
            replies: Vec::new(),
            closed: None,
        };
        bench.send(Command::REGISTER_SESSION, RegisterSession::CURRENT.to_bytes());
        bench.handle = bench.replies[0].header.session;
        bench
    }

    fn send(&mut self, command: Command, data: Bytes) {
        let frame = EncapFrame::request(command, self.handle, [0; 8], data);
        self.replies.clear();
        let mut bytes = BytesMut::from(&frame.to_bytes()[..]);
        self.session.handle_input(&mut bytes, self.now, &mut self.host);
        while let Some(event) = self.session.poll_event() {
            match event {
                Event::Outgoing(bytes) => {
                    let mut bytes = BytesMut::from(&bytes[..]);
                    self.replies
                        .push(FrameDecoder::default().decode(&mut bytes).unwrap().unwrap());
                }
                Event::Request { id, request, .. } => {
                    let reply = Reply::success(request.service, Bytes::new());
                    self.session.reply(id, &reply, self.now);
                }
                Event::IoReady(_) => {}
                Event::Close(reason) => self.closed = Some(reason),
            }
        }
    }

    /// The reply to an unconnected message.
    fn ask(&mut self, message: Bytes) -> Reply {
        self.send(Command::SEND_RR_DATA, Packet::unconnected(message).to_bytes());
        let packet = Packet::decode(&self.replies[0].data).unwrap();
        Reply::decode(packet.unconnected_message().unwrap()).unwrap()
    }

    fn open(&mut self, serial: u16) -> ConnectionId {
        let reply = self.ask(forward_open(serial, true));
        assert!(reply.status.is_success(), "{}", reply.status);
        ForwardOpenReply::decode(&reply.data).unwrap().o_to_t_id
    }
}

fn key(serial: u16) -> ConnectionKey {
    ConnectionKey {
        serial,
        vendor: 2,
        originator: 3,
    }
}

fn forward_open(serial: u16, large: bool) -> Bytes {
    let open = ForwardOpen {
        time: TickTime::DEFAULT,
        o_to_t_id: ConnectionId(0),
        t_to_o_id: ConnectionId(9),
        key: key(serial),
        multiplier: 0,
        o_to_t_rpi: 100_000,
        o_to_t: NetworkParameters::explicit(500),
        t_to_o_rpi: 100_000,
        t_to_o: NetworkParameters::explicit(500),
        transport: TRANSPORT_CLASS_3,
        path: Epath::object(2, 1),
    };
    let service = if large { 0x5B } else { 0x54 };
    let data = open.to_bytes(large).unwrap();
    Request::new(service, Epath::object(6, 1), data).to_bytes().unwrap()
}

fn forward_close(serial: u16) -> Bytes {
    let close = ForwardClose {
        time: TickTime::DEFAULT,
        key: key(serial),
        path: Epath::object(2, 1),
    };
    let data = close.to_bytes().unwrap();
    Request::new(0x4E, Epath::object(6, 1), data).to_bytes().unwrap()
}

#[test]
fn opener_cve_2020_13556_2022_43604_2022_43605_every_attribute_count() {
    for count in 0..=u16::MAX {
        for length in 0..6 {
            let mut data = count.to_le_bytes().to_vec();
            data.resize(2 + length, 1);
            if let Ok(ids) = cip::decode_attribute_ids(&data) {
                assert!(ids.len() <= length / 2, "{count} in {length} bytes");
            }
            let mut list = cip::AttributeListReader::new(&data).unwrap();
            let mut entries = 0;
            while list.next_entry().is_some() {
                entries += 1;
            }
            assert!(entries <= length / 4, "{count} in {length} bytes");
        }
    }
}

#[test]
fn opener_cve_2021_21777_27478_27482_27498_27500_datagrams() {
    let identity = Identity::new("Arcline", 1);
    let local = "127.0.0.1:44818".parse().unwrap();
    for command in [Command::LIST_IDENTITY, Command::LIST_SERVICES, Command::LIST_INTERFACES] {
        let whole = EncapFrame::request(command, SessionHandle(0), *b"\x0A\0trace!", Bytes::new()).to_bytes();
        assert!(discovery::answer(&whole, &identity, 0, local).is_some(), "{command:?}");
        for cut in 0..whole.len() {
            let answer = discovery::answer(&whole[..cut], &identity, 0, local);
            assert_eq!(answer, None, "{command:?} cut at {cut}");
        }
        for place in 0..whole.len() {
            for value in 0..=u8::MAX {
                let mut altered = whole.to_vec();
                altered[place] = value;
                if let Some(answer) = discovery::answer(&altered, &identity, 0, local) {
                    assert!(answer.frame.data.len() < 128 && answer.max_delay <= Duration::from_secs(2));
                }
            }
        }
    }
}

#[test]
fn opener_cve_2026_51536_51537_51540_75347_75349_75350_lengths() {
    // Forward Open of both kinds cut at every byte, with more behind it, and with every path size.
    for large in [false, true] {
        let message = forward_open(1, large);
        for length in 0..message.len() + 40 {
            let mut bytes = message.to_vec();
            bytes.resize(length, 0x20);
            let mut bench = Bench::new();
            bench.send(Command::SEND_RR_DATA, Packet::unconnected(bytes.into()).to_bytes());
            assert_eq!(bench.replies.len(), 1, "{length} bytes");
            assert!(bench.host.open == 0 || length >= message.len(), "{length} bytes");
        }
        let size = message.len() - 5;
        for words in 0..=u8::MAX {
            let mut bytes = message.to_vec();
            bytes[size] = words;
            let mut bench = Bench::new();
            bench.ask(bytes.into());
            assert!(bench.host.open == 0 || words == 2, "{words} words");
        }
    }
    // Connected messages of every length, from none at all over less than a sequence count.
    let mut bench = Bench::new();
    let id = bench.open(1);
    let whole = Packet::connected(id, 1, &[0x01, 2, 0x20, 1, 0x24, 1]).to_bytes();
    for cut in 0..=whole.len() {
        bench.send(Command::SEND_UNIT_DATA, whole.slice(..cut));
        assert_eq!(bench.closed, None, "cut at {cut}");
    }
    for length in 0..9_u16 {
        let mut bytes = whole.to_vec();
        let at = bytes.len() - 10;
        bytes[at..at + 2].copy_from_slice(&length.to_le_bytes());
        bench.send(Command::SEND_UNIT_DATA, bytes.into());
        assert_eq!(bench.closed, None, "an item of {length} bytes");
    }
    // Lengths in paths.
    for kind in 0..=u8::MAX {
        for length in 0..=u8::MAX {
            for behind in 0..4 {
                let mut path = vec![kind, length];
                path.resize(2 + 2 * behind, 0x41);
                if let Ok(path) = Epath::decode(&path.into()) {
                    let _ = Target::new(&path);
                }
            }
        }
    }
}

#[test]
fn micro850_cve_2025_7693_forward_close_at_every_length_and_value() {
    let mut bench = Bench::new();
    bench.open(1);
    let message = forward_close(1);
    for cut in 0..message.len() {
        bench.send(
            Command::SEND_RR_DATA,
            Packet::unconnected(message.slice(..cut)).to_bytes(),
        );
        assert_eq!(bench.replies.len(), 1, "cut at {cut}");
    }
    for place in 0..message.len() {
        for value in 0..=u8::MAX {
            let mut altered = message.to_vec();
            altered[place] = value;
            bench.send(Command::SEND_RR_DATA, Packet::unconnected(altered.into()).to_bytes());
            assert_eq!(bench.replies.len(), 1, "byte {place} is {value}");
            if bench.host.open == 0 {
                bench.open(1);
            }
        }
    }
    assert!(bench.ask(message).status.is_success());
    assert_eq!((bench.host.open, bench.session.connections()), (0, 0));
}

#[test]
fn codesys_vde_2026_040_slots_return_to_zero() {
    let cycles = std::env::var("ARCLINE_CYCLES").map_or(20_000, |cycles| cycles.parse().unwrap());
    let mut bench = Bench::new();
    for cycle in 0..cycles {
        let serial = u16::try_from(cycle % 60_000).unwrap();
        bench.open(serial);
        if cycle % 2 == 0 {
            assert!(bench.ask(forward_close(serial)).status.is_success());
        } else {
            // It expires when no first message comes, long before the session does.
            bench.now += Duration::from_secs(11);
            bench.session.handle_timeout(bench.now, &mut bench.host);
        }
        assert_eq!((bench.host.open, bench.session.connections()), (0, 0), "cycle {cycle}");
    }
    assert_eq!(bench.closed, None);
}

#[test]
fn libplctag_pr_664_671_367_counts_and_lengths_from_the_peer() {
    let symbol = [&[1, 0, 0, 0, 4, 0][..], b"Name", &[0xC4, 0]].concat();
    let template = [&[4, 0, 4, 0, 0, 0, 9, 0, 0, 0][..], &[5, 0, 0, 0, 8, 0, 0, 0]].concat();
    let packet = vec![2, 0, 6, 0, 10, 0, 0xCC, 0, 0, 0, 0xCC, 0, 0, 0];
    let identity = Identity::new("Arcline", 1).list_identity("127.0.0.1:44818".parse().unwrap());
    let opened = Bench::new().ask(forward_open(1, true)).data;
    for base in [symbol, template, packet, identity.to_vec(), opened.to_vec()] {
        for place in 0..base.len() {
            for value in [0, 1, 2, 0x7F, 0x80, 0xFE, 0xFF] {
                let mut altered = base.clone();
                altered[place] = value;
                if place + 1 < altered.len() && value == 0xFF {
                    altered[place + 1] = value;
                }
                for end in [place + 1, altered.len()] {
                    let data = Bytes::copy_from_slice(&altered[..end]);
                    if let Some(symbols) = Symbol::decode_list(&data, &[1, 2]) {
                        assert!(symbols.len() <= data.len() / 8 && symbols.iter().all(|s| s.name.len() <= data.len()));
                    }
                    let _ = (TemplateAttributes::decode(&data), ReadReply::decode(&data));
                    if let Some(replies) = cip::split_multiple_replies(&data) {
                        assert!(replies.len() <= data.len());
                    }
                    let _ = (
                        Identity::decode_item(&data),
                        Identity::decode_all(&data),
                        decode_items(&data),
                    );
                    let _ = (ForwardOpenReply::decode(&data), Reply::decode(&data));
                }
            }
        }
    }
}
