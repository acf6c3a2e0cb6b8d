//! Any sequence of Forward Opens, Forward Closes, datagrams and times on a session and the I/O connections beside it. Most
//! fields come from a small set, so that sequences meet; every message may have a byte altered or be cut.
#![no_main]

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use arcline_fuzz::{Device, LOCAL, MOST, PEER, SIZE, timed};
use arcline_proto::cip::{CipStatus, Request, service};
use arcline_proto::connection::{
    ConnectionKey, ConnectionType, ForwardClose, ForwardOpen, NetworkParameters, TickTime,
};
use arcline_proto::cpf::{ConnectionId, Packet};
use arcline_proto::encap::{Command, EncapFrame, RegisterSession, SessionHandle};
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::io::{Datagram, Ownership};
use arcline_proto::session::{Event, ServerSession, Settings};
use bytes::{Bytes, BytesMut};
use libfuzzer_sys::fuzz_target;

/// Bytes of the input, zeros behind its end.
struct Source<'a>(&'a [u8]);

impl Source<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[usize::from(self.byte()) % choices.len()]
    }

    /// The message as it is, or with a byte altered, or cut.
    fn spoil(&mut self, message: &Bytes) -> Bytes {
        let (how, place) = (self.byte(), usize::from(self.byte()) % message.len().max(1));
        match how % 8 {
            0 => message.slice(..place),
            1 => {
                let mut altered = message.to_vec();
                altered[place] ^= self.byte();
                altered.into()
            }
            _ => message.clone(),
        }
    }

    fn key(&mut self) -> ConnectionKey {
        ConnectionKey {
            serial: u16::from(self.byte() % 8),
            vendor: 1,
            originator: 2,
        }
    }

    fn parameters(&mut self) -> NetworkParameters {
        use ConnectionType::{Multicast, Null, PointToPoint, Reserved};
        NetworkParameters {
            redundant_owner: self.byte() == 255,
            connection_type: self.of(&[PointToPoint, PointToPoint, PointToPoint, Null, Multicast, Reserved]),
            priority: 0,
            variable: self.byte().is_multiple_of(2),
            size: self.of(&[SIZE + 6, SIZE + 2, 2, 6, 500, 4, SIZE, u16::MAX]),
        }
    }

    fn open(&mut self) -> ForwardOpen {
        let path = match self.byte() % 4 {
            0 => Epath::object(2, 1),
            _ => Epath(vec![
                Segment::Class(4),
                Segment::Instance(151),
                Segment::ConnectionPoint(self.of(&[150, 254, 255, 1])),
                Segment::ConnectionPoint(100),
            ]),
        };
        ForwardOpen {
            time: TickTime::DEFAULT,
            o_to_t_id: ConnectionId(0),
            t_to_o_id: ConnectionId(self.byte().into()),
            key: self.key(),
            multiplier: self.byte() % 9,
            o_to_t_rpi: self.of(&[1000, 2000, 1_000_000, u32::MAX, 0, 999]),
            o_to_t: self.parameters(),
            t_to_o_rpi: self.of(&[1000, 2000, 1_000_000, u32::MAX, 0, 999]),
            t_to_o: self.parameters(),
            transport: self.of(&[1, 1, 0, 0xA3, 0x11, 2]),
            path,
        }
    }
}

fuzz_target!(|data: &[u8]| timed(|| run(data)));

fn run(data: &[u8]) {
    let mut device = Device::default();
    let mut session = ServerSession::new(Arc::new(Settings::default()), LOCAL, device.now);
    let register = EncapFrame::request(
        Command::REGISTER_SESSION,
        SessionHandle(0),
        [0; 8],
        RegisterSession::CURRENT.to_bytes(),
    );
    session.handle_frame(&register, device.now, &mut device);

    let mut source = Source(data);
    let mut out = BytesMut::new();
    for _ in 0..256 {
        if source.0.is_empty() {
            break;
        }
        let message = match source.byte() % 6 {
            0 | 1 => {
                let large = source.byte() % 2 == 0;
                let code = if large {
                    service::LARGE_FORWARD_OPEN
                } else {
                    service::FORWARD_OPEN
                };
                let open = source.open().to_bytes(large).expect("a short path");
                Some(Request::new(code, Epath::object(6, 1), open))
            }
            2 => {
                let close = ForwardClose {
                    time: TickTime::DEFAULT,
                    key: source.key(),
                    path: Epath::object(2, 1),
                };
                let close = close.to_bytes().expect("a short path");
                Some(Request::new(service::FORWARD_CLOSE, Epath::object(6, 1), close))
            }
            3 | 4 => {
                let length = usize::from(source.byte()) % 24;
                let data: Vec<u8> = (0..length).map(|_| source.byte()).collect();
                let datagram = Datagram {
                    id: ConnectionId(u32::from(source.byte())),
                    sequence: u32::from(source.byte()).wrapping_sub(8),
                    data: &data,
                };
                out.clear();
                datagram.encode(&mut out);
                let bytes = source.spoil(&Bytes::copy_from_slice(&out));
                let from = source.of(&[PEER, PEER, PEER, (*LOCAL.ip()).into()]);
                device
                    .io
                    .handle_datagram(&bytes, SocketAddr::new(from, 2222), device.now);
                None
            }
            _ => {
                device.now += Duration::from_micros(source.of(&[1, 500, 1000, 4000, 10_000_000]));
                device.io.handle_timeout(device.now);
                session.handle_timeout(device.now, &mut device);
                None
            }
        };
        if let Some(request) = message {
            let message = source.spoil(&request.to_bytes().expect("a short path"));
            let packet = Packet::unconnected(message).to_bytes();
            let frame = EncapFrame::request(Command::SEND_RR_DATA, SessionHandle(1), [0; 8], packet);
            let now = device.now;
            session.handle_frame(&frame, now, &mut device);
        }
        while let Some(event) = session.poll_event() {
            match event {
                Event::IoReady(id) => {
                    device.io.start(id, device.now);
                }
                Event::Request { id, request, .. } => {
                    let reply = arcline_proto::cip::Reply::error(request.service, CipStatus::SERVICE_NOT_SUPPORTED);
                    session.reply(id, &reply, device.now);
                }
                Event::Outgoing(_) | Event::Close(_) => {}
            }
        }
        // Every connection sends at most once at one time.
        let mut sent = 0;
        out.clear();
        while device
            .io
            .poll_transmit(device.now, &[0; SIZE as usize], &mut out)
            .is_some()
        {
            sent += 1;
            assert!(sent <= MOST);
        }
        let events = std::iter::from_fn(|| device.io.poll_event()).count();
        assert!(events <= MOST + 1, "{events} events of one step");
        assert!(device.io.len() <= MOST);
        assert!(!device.io.is_due(device.now));
        assert_eq!(device.open, session.connections());
        if device.io.is_empty() {
            assert_eq!(device.io.outputs(), Ownership::Free);
            assert_eq!(device.io.poll_timeout(), None);
        }
    }
    // All of them expire.
    device.now += Duration::from_secs(u64::from(u32::MAX));
    device.io.handle_timeout(device.now);
    assert!(device.io.is_empty());
    session.handle_disconnect(&mut device);
    assert_eq!(device.open, 0);
}
