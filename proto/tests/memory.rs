//! The memory that one packet can make a session hold, measured by the allocator. Alone in its file, so that no other test counts.

#![allow(clippy::unwrap_used)]

use std::alloc::System;
use std::sync::Arc;
use std::time::Duration;

use arcline_proto::cip::{self, MultipleReplies, Request};
use arcline_proto::cpf::{Packet, decode_items};
use arcline_proto::encap::{Command, EncapFrame, RegisterSession, SessionHandle};
use arcline_proto::epath::Epath;
use arcline_proto::session::{Draws, ServerSession, Settings, TestHost};
use bytes::{Bytes, BytesMut};
use cap::Cap;

#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, usize::MAX);

/// The memory that one packet may add at a time, bytes: it brings 8 KiB, which become at most 4,000 requests of a packet.
const LIMIT: usize = 1 << 20;

/// As many requests in one packet as its bytes can name, all of them empty.
fn nothing(length: usize) -> Bytes {
    let count = length / 2 - 1;
    let numbers = std::iter::once(count).chain(std::iter::repeat_n(length, count));
    let data: Vec<u8> = numbers.flat_map(|number| (number as u16).to_le_bytes()).collect();
    data.into()
}

#[test]
fn wireshark_cve_2012_4291_memory_of_one_packet() {
    // A peak of the test's own start counts as well, which does no harm.
    let before = MEMORY.allocated();
    let local = "127.0.0.1:44818".parse().unwrap();
    let mut host = TestHost::new(Draws::Constant(1));
    for count in [0x00FF_u16, 0x7FFF, u16::MAX] {
        for fill in [0_u8, 1, 0x91, 0xFF] {
            // A count with as much data behind it as a frame can hold.
            let mut data = count.to_le_bytes().to_vec();
            data.resize(8000, fill);
            for (service, path) in [
                (0x0A, Epath::object(2, 1)),
                (0x03, Epath::object(1, 1)),
                (0x55, Epath::object(0x6B, 0)),
                (0x4D, Epath::symbol("A")),
                (0x53, Epath::symbol("A")),
            ] {
                let mut session = ServerSession::new(Arc::new(Settings::default()), local, Duration::ZERO);
                let message = Request::new(service, path, data.clone()).to_bytes().unwrap();
                let current = RegisterSession::CURRENT.to_bytes();
                let frames = [
                    EncapFrame::request(Command::REGISTER_SESSION, SessionHandle(0), [0; 8], current),
                    EncapFrame::request(
                        Command::SEND_RR_DATA,
                        SessionHandle(1),
                        [0; 8],
                        Packet::unconnected(message).to_bytes(),
                    ),
                ];
                for frame in frames {
                    session.handle_input(&mut BytesMut::from(&frame.to_bytes()[..]), Duration::ZERO, &mut host);
                }
                // A header that claims as much as it can, and never sends it.
                let mut claim = EncapFrame::request(Command::SEND_RR_DATA, SessionHandle(1), [0; 8], Bytes::new())
                    .to_bytes()
                    .to_vec();
                claim[2..4].copy_from_slice(&count.to_le_bytes());
                session.handle_input(&mut BytesMut::from(&claim[..]), Duration::ZERO, &mut host);
                while session.poll_event().is_some() {}
            }
            let data = Bytes::from(data);
            let _ = (
                cip::split_multiple(&data),
                cip::split_multiple_replies(&data),
                decode_items(&data),
            );
            let _ = (
                cip::split_multiple(&nothing(data.len())),
                cip::decode_attribute_ids(&data),
                MultipleReplies::new(count.into(), 4000),
            );
        }
    }
    let grown = MEMORY.max_allocated() - before;
    println!("{grown} bytes more at the most");
    assert!(grown < LIMIT, "{grown} bytes");
    // The measure would have seen it.
    let held = vec![0_u8; 2 * LIMIT];
    assert!(
        MEMORY.max_allocated() - before >= LIMIT,
        "{} bytes held and not seen",
        held.len()
    );
}
