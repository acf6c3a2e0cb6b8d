//! Requests that only one stock client sends, byte by byte; each test has the name of its client. The clients that
//! `tests/system/tests/foreign/interop.rs` runs against a whole server are not here.

use arcline_proto::cip::{join_multiple, split_multiple_replies};

use super::*;

/// A message as it was captured.
fn message(bytes: &[u8]) -> Request {
    Request::decode(&Bytes::copy_from_slice(bytes)).expect("a request")
}

#[tokio::test]
async fn gologix_writes_a_structure_by_the_handle_that_it_computed() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    // Its names are in lower case. 0x3382 is the CRC of "Point,REAL[2],SINT,SINT"; it has never asked for the template.
    let head = b"\x4D\x0A\x91\x06routes\x28\x01\x91\x06points\x28\x01\xA0\x02\x82\x33\x01\x00";
    let point = [0, 0, 0xC0, 0x3F, 0, 0, 0x20, 0xC0, 1, 7, 0, 0];
    let reply = client.ask(&message(&[&head[..], &point].concat())).await;
    assert_eq!(&reply.to_bytes()[..], b"\xCD\0\0\0");
    assert_eq!(&client.read("Routes[1].Points[1].At[1]").await.data[..], &point[4..8]);
    assert_eq!(&client.read("Routes[1].Points[1].Id").await.data[..], [7]);
}

#[tokio::test]
async fn libplctag_repeats_requests_that_a_full_packet_leaves_out() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(4002, 1).await;
    // Thirty tags of 33 elements: their replies are 4,140 bytes.
    let tag = |start: u8, offset: u8| {
        let path = [b"\x52\x05\x91\x05Dints\x00\x28", &[start][..]].concat();
        message(&[&path[..], &[33, 0, offset, 0, 0, 0]].concat())
    };
    let packet = |requests: &[Request]| {
        let data = join_multiple(requests).expect("short paths");
        Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data)
    };
    let tags: Vec<Request> = (0..30).map(|start| tag(start, 0)).collect();
    let reply = client.ask_connected(&mut connected, &packet(&tags)).await;
    assert_eq!(reply.status.general(), 0x1E);
    let replies = split_multiple_replies(&reply.data).expect("replies");
    let (whole, cut) = replies.split_at(28);
    assert!(whole.iter().all(|reply| reply.status.is_success()));
    assert_eq!(&cut[0].to_bytes()[..6], b"\xD2\0\x06\0\xC4\0");
    assert_eq!(
        &cut[1].to_bytes()[..],
        b"\xD2\0\x06\0",
        "0x11 would be the end of that tag"
    );
    let got = u8::try_from(cut[0].data.len() - 2).expect("less than one tag");
    let rest = packet(&[tag(28, got), tag(29, 0)]);
    let reply = client.ask_connected(&mut connected, &rest).await;
    let replies = split_multiple_replies(&reply.data).expect("replies");
    let lengths: Vec<usize> = replies.iter().map(|reply| reply.data.len() - 2).collect();
    assert_eq!(lengths, [33 * 4 - usize::from(got), 33 * 4]);
}

#[tokio::test]
async fn rust_ethernet_ip_is_refused_attributes_by_name_and_browses() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    for path in [
        &b"\x03\x04\x91\x05aDint\x00"[..],
        b"\x03\x04\x91\x06Routes",
        b"\x03\x05\x91\x06Routes\x28\x01",
        b"\x03\x0B\x91\x0CProgram:Main\x91\x05Count\x00",
    ] {
        let reply = client.ask(&message(&[path, &[2, 0, 1, 0, 2, 0]].concat())).await;
        assert_eq!(&reply.to_bytes()[..], b"\x83\0\x04\x01\0\0", "{path:?}");
    }
}

/// Bytes of hex text; blanks are for the reader.
fn bytes(text: &str) -> Bytes {
    let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
    let pair = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).expect("digits"), 16).expect("digits");
    digits.chunks(2).map(pair).collect()
}

/// The reply to a message without connection, from its service code on.
async fn answer(client: &mut Client, request: &str) -> Bytes {
    client.raw(bytes(request)).await.to_bytes()
}

#[tokio::test]
async fn ethernet_ip_of_npm_reads_and_sets_the_wall_clock_as_a_date() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let read = "52 02 20062401 047d 0800  0e03 208b 2401 3005  0100 0100";
    let now = answer(&mut client, read).await;
    assert_eq!((&now[..4], now.len()), (&bytes("8e000000")[..], 4 + 28));

    // 2030-01-03 04:05:06.789.
    let date = "ee070000 01000000 03000000 04000000 05000000 06000000";
    let set = format!("52 02 20062401 047d 2400  1003 208b 2401 3005 {date} 080a0c00  0100 0100");
    assert_eq!(answer(&mut client, &set).await, bytes("90000000"));
    let shown = bytes(&format!("8e000000 {date}"));
    // Compare to the minute, since the clock goes on.
    let minute = 4 + 20;
    assert_eq!(answer(&mut client, read).await[..minute], shown[..minute]);
    let universal = answer(&mut client, "0e03 208b 2401 3007").await;
    assert_eq!(universal[..minute], shown[..minute], "local time is UTC");
    let micros = answer(&mut client, "0e03 208b 2401 3006").await;
    let micros = u64::from_le_bytes(micros[4..].try_into().expect("eight bytes"));
    assert_eq!(micros / 60_000_000, 1_893_643_500 / 60, "the same minute");

    #[rustfmt::skip]
    let refused = [
        ("no such day",        "ee070000 02000000 1e000000 00000000 00000000 00000000 00000000", "90000900"),
        ("a negative year",    "ffffffff 01000000 01000000 00000000 00000000 00000000 00000000", "90000900"),
        ("a field is missing", "ee070000 01000000 03000000 04000000 05000000 06000000",          "90001300"),
    ];
    for (why, date, reply) in refused {
        let set = format!("1003 208b 2401 3005 {date}");
        assert_eq!(answer(&mut client, &set).await, bytes(reply), "{why}");
    }
    assert_eq!(
        answer(&mut client, read).await[..minute],
        shown[..minute],
        "nothing of that was taken"
    );
}

/// Revision, highest instance, highest class attribute, highest instance attribute: its own tests expect these four of
/// a CompactLogix.
#[tokio::test]
async fn cippy_reads_all_attributes_of_a_class() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    for (why, request, reply) in [
        ("Identity", "0102 2001 2400", "81000000 0100 0100 0700 0a00"),
        ("Connection Manager", "0102 2006 2400", "81000000 0100 0100 0700 6400"),
    ] {
        assert_eq!(answer(&mut client, request).await, bytes(reply), "{why}");
    }
}
