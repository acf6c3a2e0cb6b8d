//! Any byte stream into a server session that is registered and has a class 3 connection, in pieces, with time passing.
#![no_main]

use std::sync::Arc;
use std::time::Duration;

use arcline_proto::cip::Reply;
use arcline_proto::client::{ClientSession, OpenOptions};
use arcline_proto::connection::{ConnectionKey, Count};
use arcline_proto::cpf::ConnectionId;
use arcline_proto::discovery;
use arcline_proto::identity::Identity;
use arcline_proto::session::{Event, Host, ServerSession, Settings};
use bytes::BytesMut;
use libfuzzer_sys::fuzz_target;

/// Draws 1, 2, 3 … so that inputs can name the session (1) and the connection (2).
struct FuzzHost {
    drawn: u32,
    open: usize,
    identity: Identity,
}

impl Host for FuzzHost {
    fn random(&mut self) -> Option<u32> {
        self.drawn = self.drawn.wrapping_add(1);
        Some(self.drawn)
    }
    fn acquire_connection(&mut self) -> bool {
        self.open += 1;
        true
    }
    fn release_connections(&mut self, count: usize) {
        self.open -= count;
    }
    fn count(&mut self, _count: Count) {}
    fn identity(&self) -> &Identity {
        &self.identity
    }
}

fuzz_target!(|data: &[u8]| {
    let local = "127.0.0.1:44818".parse().expect("an address");
    let mut host = FuzzHost {
        drawn: 0,
        open: 0,
        identity: Identity::new("Arcline", 1),
    };
    let mut server = ServerSession::new(Arc::new(Settings::default()), local, Duration::ZERO);
    let mut client = ClientSession::new(Duration::from_secs(5));
    let mut now = Duration::ZERO;
    client.register(now);
    pump(&mut client, &mut server, &mut host, now);
    let key = ConnectionKey {
        serial: 1,
        vendor: 2,
        originator: 3,
    };
    let _ = client.open(OpenOptions::new(key, ConnectionId(4)), now);
    pump(&mut client, &mut server, &mut host, now);

    let mut buf = BytesMut::new();
    for piece in data.chunks(61) {
        now += Duration::from_secs(1);
        buf.extend_from_slice(piece);
        server.handle_input(&mut buf, now, &mut host);
        server.handle_timeout(now, &mut host);
        pump(&mut client, &mut server, &mut host, now);
        assert_eq!(host.open, server.connections());
    }
    let _ = client.handle_input(&mut BytesMut::from(data));
    let _ = discovery::answer(data, &host.identity, 0, local);
    server.handle_disconnect(&mut host);
    assert_eq!(host.open, 0);
});

fn pump(
    client: &mut ClientSession,
    server: &mut ServerSession,
    host: &mut FuzzHost,
    now: Duration,
) {
    while let Some(bytes) = client.poll_transmit() {
        server.handle_input(&mut BytesMut::from(&bytes[..]), now, host);
    }
    while let Some(event) = server.poll_event() {
        match event {
            Event::Outgoing(bytes) => drop(client.handle_input(&mut BytesMut::from(&bytes[..]))),
            Event::Request { id, request, .. } => {
                server.reply(id, &Reply::success(request.service, request.data), now);
            }
            Event::IoReady(_) | Event::Close(_) => {}
        }
    }
}
