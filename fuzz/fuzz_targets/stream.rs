//! Any byte stream into a server session that is registered and has a class 3 connection, in pieces, with time passing.
#![no_main]

use std::sync::Arc;
use std::time::Duration;

use arcline_fuzz::{Device, LOCAL, timed};
use arcline_proto::cip::Reply;
use arcline_proto::client::{ClientSession, OpenOptions};
use arcline_proto::connection::ConnectionKey;
use arcline_proto::cpf::ConnectionId;
use arcline_proto::discovery;
use arcline_proto::session::{Event, Host, ServerSession, Settings};
use bytes::BytesMut;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| timed(|| run(data)));

fn run(data: &[u8]) {
    let mut host = Device::default();
    let mut server = ServerSession::new(Arc::new(Settings::default()), LOCAL, Duration::ZERO);
    let mut client = ClientSession::new(Duration::from_secs(5));
    client.register(host.now);
    pump(&mut client, &mut server, &mut host);
    let key = ConnectionKey {
        serial: 1,
        vendor: 2,
        originator: 3,
    };
    let _ = client.open(OpenOptions::new(key, ConnectionId(4)), host.now);
    pump(&mut client, &mut server, &mut host);

    let mut buf = BytesMut::new();
    for piece in data.chunks(61) {
        host.now += Duration::from_secs(1);
        buf.extend_from_slice(piece);
        server.handle_input(&mut buf, host.now, &mut host);
        server.handle_timeout(host.now, &mut host);
        pump(&mut client, &mut server, &mut host);
        assert_eq!(host.open, server.connections());
    }
    let _ = client.handle_input(&mut BytesMut::from(data));
    let _ = discovery::answer(data, host.identity(), 0, LOCAL);
    server.handle_disconnect(&mut host);
    assert_eq!(host.open, 0);
}

fn pump(client: &mut ClientSession, server: &mut ServerSession, host: &mut Device) {
    while let Some(bytes) = client.poll_transmit() {
        server.handle_input(&mut BytesMut::from(&bytes[..]), host.now, host);
    }
    while let Some(event) = server.poll_event() {
        match event {
            Event::Outgoing(bytes) => drop(client.handle_input(&mut BytesMut::from(&bytes[..]))),
            Event::Request { id, request, .. } => {
                server.reply(id, &Reply::success(request.service, request.data), host.now);
            }
            Event::IoReady(_) | Event::Close(_) => {}
        }
    }
}
