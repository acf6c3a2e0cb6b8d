//! The objects that every controller shows: each class, instance and attribute with its bytes, and the status of objects and attributes
//! that do not exist (spec/ethernet-ip.md §6, §13).

use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::Path;

use arcline_proto::cip::{Reply, Request, class, service};
use arcline_proto::connection::ConnectionKey;
use arcline_proto::epath::{Epath, Segment};
use bytes::Bytes;

use super::{Bench, Client, codes, forward_open};
use crate::eip::adapter;
use crate::eip::connection;

/// The local address to which the client of these tests has connected.
const LOCAL: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(192, 168, 1, 10), 44818);

/// Class, instance (0: the class), attribute, and its bytes in hexadecimal; `*` is any byte.
#[rustfmt::skip]
const ATTRIBUTES: &[(u16, u32, u16, &str)] = &[
    // Identity: vendor, type, code, revision, status, serial, name, state, consistency, heartbeat.
    (0x01, 0, 1, "0100"), (0x01, 0, 2, "0100"), (0x01, 0, 3, "0100"), (0x01, 0, 4, "0000"), (0x01, 0, 5, "0000"),
    (0x01, 0, 6, "0700"), (0x01, 0, 7, "0a00"),
    (0x01, 1, 1, "c1a2"), (0x01, 1, 2, "0e00"), (0x01, 1, 3, "0100"), (0x01, 1, 4, "210b"), (0x01, 1, 5, "6030"),
    (0x01, 1, 6, "59d46a34"), (0x01, 1, 7, "0542656e6368"), (0x01, 1, 8, "03"), (0x01, 1, 9, "0000"), (0x01, 1, 10, "00"),
    // Message Router: the classes, most connections, open connections.
    (0x02, 0, 1, "0100"), (0x02, 0, 7, "0300"),
    (0x02, 1, 2, "0010"), (0x02, 1, 3, "0000"),
    // Connection Manager: one Forward Open was refused, one Forward Close too.
    (0x06, 0, 1, "0100"), (0x06, 0, 2, "0100"), (0x06, 0, 3, "0100"), (0x06, 0, 7, "6400"),
    (0x06, 1, 1, "0100"), (0x06, 1, 2, "0000"), (0x06, 1, 3, "0000"), (0x06, 1, 4, "0100"),
    (0x06, 1, 5, "0100"), (0x06, 1, 6, "0100"), (0x06, 1, 7, "0000"), (0x06, 1, 8, "0000"),
    (0x06, 1, 100, "00"),
    // QoS.
    (0x48, 0, 1, "0100"), (0x48, 0, 7, "0800"),
    (0x48, 1, 1, "00"), (0x48, 1, 2, "3b"), (0x48, 1, 3, "2f"), (0x48, 1, 4, "37"),
    (0x48, 1, 5, "2f"), (0x48, 1, 6, "2b"), (0x48, 1, 7, "1f"), (0x48, 1, 8, "1b"),
    // The security objects without TLS; the rest of them is in `security`.
    (0x5D, 0, 1, "0300"), (0x5D, 0, 7, "0300"), (0x5D, 1, 1, "00"),
    (0x5E, 0, 1, "0700"), (0x5E, 0, 7, "1000"), (0x5E, 1, 1, "00"),
    (0x5F, 0, 1, "0200"), (0x5F, 0, 7, "0500"), (0x5F, 1, 2, "00"),
    // Program name.
    (0x64, 0, 1, "0100"), (0x64, 1, 1, "050042656e6368"),
    // Symbol: the motion group, of template 0xFxx.
    (0x6B, 0, 1, "0100"), (0x6B, 0, 7, "0b00"),
    (0x6B, 1, 1, "06004d6f74696f6e"), (0x6B, 1, 2, "*8f"), (0x6B, 1, 3, "01000000"), (0x6B, 1, 5, "01000000"),
    (0x6B, 1, 6, "00000004"), (0x6B, 1, 8, "000000000000000000000000"), (0x6B, 1, 9, "00"), (0x6B, 1, 10, "02"),
    (0x6B, 1, 11, "00"),
    // Template: STRING.
    (0x6C, 0, 1, "0100"), (0x6C, 0, 7, "0500"),
    (0x6C, 0xFCE, 1, "ce0f"), (0x6C, 0xFCE, 2, "0200"), (0x6C, 0xFCE, 3, "0000"), (0x6C, 0xFCE, 5, "58000000"),
    // Wall clock.
    (0x8B, 0, 1, "0100"), (0x8B, 1, 5, "****************************"), (0x8B, 1, 6, "********"),
    (0x8B, 1, 7, "****************************"), (0x8B, 1, 10, "00"), (0x8B, 1, 11, "********"),
    // Change detection.
    (0xAC, 0, 7, "0a00"), (0xAC, 1, 1, "0100"), (0xAC, 1, 2, "0100"), (0xAC, 1, 3, "****"), (0xAC, 1, 4, "01000000"),
    (0xAC, 1, 10, "01000000"),
    // Port: EtherNet/IP is port 2, and instance 1.
    (0xF4, 0, 1, "0100"), (0xF4, 0, 2, "0100"), (0xF4, 0, 3, "0100"), (0xF4, 0, 6, "0900"), (0xF4, 0, 7, "0700"),
    (0xF4, 0, 8, "0100"), (0xF4, 0, 9, "0000000004000200"),
    (0xF4, 1, 1, "0400"), (0xF4, 1, 2, "0200"), (0xF4, 1, 3, "020020f52401"),
    (0xF4, 1, 4, "0b45746865724e65742f4950"), (0xF4, 1, 7, "120c3139322e3136382e312e3130"),
    // TCP/IP Interface: as the system has it.
    (0xF5, 0, 1, "0400"), (0xF5, 0, 2, "0100"), (0xF5, 0, 3, "0100"), (0xF5, 0, 7, "0e00"),
    (0xF5, 1, 1, "02000000"), (0xF5, 1, 2, "00000000"), (0xF5, 1, 3, "00000000"), (0xF5, 1, 4, "020020f62401"),
    (0xF5, 1, 5, "0a01a8c000ffffff0101a8c00201a8c0040408080000"), (0xF5, 1, 6, "050063656c6c3400"),
    (0xF5, 1, 8, "01"), (0xF5, 1, 9, "000020002002c0ef"), (0xF5, 1, 10, "00"),
    (0xF5, 1, 11, "0000000000000000000000000000000000000000000000000000000000000000000000"),
    (0xF5, 1, 13, "7800"),
    // "EtherNet/IP TCP", "… UDP", "… I/O", "… TLS", each with its port, protocol, whether it is open, and that it cannot be set.
    (0xF5, 1, 14, "04\
      0f45746865724e65742f49502054435012af060100\
      0f45746865724e65742f49502055445012af110100\
      0f45746865724e65742f495020492f4fae08110000\
      0f45746865724e65742f495020544c53ad08060000"),
    // Ethernet Link: 1000 Mbit/s, up, full duplex, counters.
    (0xF6, 0, 1, "0400"), (0xF6, 0, 2, "0100"), (0xF6, 0, 3, "0100"), (0xF6, 0, 7, "0b00"),
    (0xF6, 1, 1, "e8030000"), (0xF6, 1, 2, "0f000000"), (0xF6, 1, 3, "001b54aa0b0c"),
    (0xF6, 1, 4, "0200000007000000030000000000000000000000000000000000000008000000000000000000000000000000"),
    (0xF6, 1, 5, "000000000500000000000000000000000000000000000000000000000000000000000000000000000000000000000000"),
    (0xF6, 1, 6, "01000000"), (0xF6, 1, 7, "02"), (0xF6, 1, 8, "01"), (0xF6, 1, 9, "01"), (0xF6, 1, 10, "0465746830"),
    (0xF6, 1, 11, "0200000000"),
    // The motion classes: 1 group, 7 axes, 4 coordinate systems, and nothing executed.
    (0x300, 0, 2, "0100"), (0x301, 0, 2, "0700"), (0x302, 0, 2, "0400"), (0x303, 0, 3, "0000"),
    // Machine: no STOP, no program.
    (0x305, 0, 1, "0100"), (0x305, 0, 7, "0600"), (0x305, 1, 1, "00"), (0x305, 1, 3, "00"), (0x305, 1, 4, "0000"), (0x305, 1, 5, "********"), (0x305, 1, 6, "00"),
    // A Cartesian coordinate system has no links.
    (0x302, 1, 12, "0000000000000000"), (0x302, 1, 25, "0000000000000000"),
];

/// Class, instance, and the attributes of Get Attributes All in their order; empty: 0x08.
#[rustfmt::skip]
const ALL: &[(u16, u32, &[u16])] = &[
    (0x01, 0, &[1, 2, 6, 7]), (0x01, 1, &[1, 2, 3, 4, 5, 6, 7]), (0x02, 1, &[1, 2, 3]),
    (0x06, 0, &[1, 2, 6, 7]), (0x06, 1, &[1, 2, 3, 4, 5, 6, 7, 8]), (0x48, 1, &[]), (0x64, 1, &[1]),
    (0x6B, 1, &[1, 2, 7, 8]), (0x6C, 0xFCE, &[]), (0x8B, 1, &[]), (0xF4, 0, &[1, 2, 3, 8, 9]), (0xF4, 1, &[1, 2, 3, 4, 7]), (0xF5, 1, &[1, 2, 3, 4, 5, 6]),
    (0xF6, 1, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]), (0xAC, 1, &[1, 2, 3, 4, 10]),
];

/// Service, class, instance, attribute, data, and the general and first additional status.
type Refused = (u8, u16, u32, Option<u16>, &'static [u8], (u8, u16));

/// A client that came in at [`LOCAL`] of a host that [`adapter::tests::host`] has put together.
async fn client(root: &Path) -> (Bench, Client) {
    adapter::tests::host(root);
    let bench = Bench::with(|settings| settings.system = root.to_owned());
    let (ours, theirs) = tokio::io::duplex(64 * 1024);
    tokio::spawn(connection::serve(
        theirs,
        LOCAL,
        Ipv4Addr::new(192, 168, 1, 20).into(),
        bench.device.clone(),
    ));
    let client = bench.client_on(ours).await;
    (bench, client)
}

fn attribute(code: u8, class: u16, instance: u32, id: u16, data: &[u8]) -> Request {
    let mut path = Epath::object(class, instance);
    path.0.push(Segment::Attribute(id.into()));
    Request::new(code, path, Bytes::copy_from_slice(data))
}

async fn get(client: &mut Client, class: u16, instance: u32, id: u16) -> Reply {
    let request = attribute(service::GET_ATTRIBUTE_SINGLE, class, instance, id, &[]);
    client.ask(&request).await
}

async fn ask(client: &mut Client, code: u8, class: u16, instance: u32, data: &[u8]) -> Reply {
    let request = Request::new(code, Epath::object(class, instance), Bytes::copy_from_slice(data));
    client.ask(&request).await
}

fn list(ids: &[u16]) -> Vec<u8> {
    let count = ids.len() as u16;
    [count].iter().chain(ids).flat_map(|word| word.to_le_bytes()).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn matches(pattern: &str, bytes: &[u8]) -> bool {
    let mut rest = hex(bytes);
    for part in pattern.split_inclusive('*') {
        let fixed = part.trim_end_matches('*');
        let Some(behind) = rest.strip_prefix(fixed) else {
            return false;
        };
        let any = if part.ends_with('*') { 2 } else { 0 };
        let Some(behind) = behind.get(any..) else { return false };
        rest = behind.to_owned();
    }
    rest.is_empty()
}

#[tokio::test]
async fn every_attribute_has_its_bytes_one_by_one_and_in_a_list() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_bench, mut client) = client(folder.path()).await;
    refuse_one_open_and_one_close(&mut client).await;
    let mut wrong = Vec::new();
    for (class, instance, id, expected) in ATTRIBUTES {
        let one = get(&mut client, *class, *instance, *id).await;
        let place = format!("class {class:#x} instance {instance} attribute {id}");
        assert!(one.status.is_success(), "{place}: {}", one.status);
        if !matches(expected, &one.data) {
            wrong.push(format!("{place}: {} is not {expected}", hex(&one.data)));
        }
        let request = list(&[*id]);
        let listed = ask(&mut client, service::GET_ATTRIBUTE_LIST, *class, *instance, &request).await;
        assert!(listed.status.is_success(), "{place}: {}", listed.status);
        let head = [1, 0, id.to_le_bytes()[0], id.to_le_bytes()[1], 0, 0];
        assert_eq!(listed.data.get(..6), Some(&head[..]), "{place}");
        if !expected.contains('*') {
            assert_eq!(listed.data.get(6..), Some(&one.data[..]), "{place}");
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
}

#[tokio::test]
async fn all_attributes_are_those_one_by_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_bench, mut client) = client(folder.path()).await;
    for (class, instance, ids) in ALL {
        let all = ask(&mut client, service::GET_ATTRIBUTES_ALL, *class, *instance, &[]).await;
        if ids.is_empty() {
            assert_eq!(codes(all.status), (0x08, 0), "class {class:#x}");
            continue;
        }
        let mut expected = Vec::new();
        for id in *ids {
            expected.extend_from_slice(&get(&mut client, *class, *instance, *id).await.data);
        }
        assert_eq!(hex(&all.data), hex(&expected), "class {class:#x} instance {instance}");
    }
}

#[tokio::test]
async fn the_message_router_lists_the_classes_of_this_table() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_bench, mut client) = client(folder.path()).await;
    let data = get(&mut client, 0x02, 1, 1).await.data;
    let words: Vec<u16> = data
        .chunks_exact(2)
        .map(|word| u16::from_le_bytes([word[0], word[1]]))
        .collect();
    let (count, classes) = words.split_first().expect("a count");
    assert_eq!(usize::from(*count), classes.len());
    for class in classes {
        let known = ATTRIBUTES.iter().any(|(known, ..)| known == class) || [class::ASSEMBLY, 0x0304].contains(class);
        assert!(known, "class {class:#x} has no line in the table");
        // Every class has its own attributes.
        for id in [1, 2, 3, 4, 5, 6, 7] {
            let reply = get(&mut client, *class, 0, id).await;
            assert_eq!(
                (codes(reply.status), reply.data.len()),
                ((0, 0), 2),
                "class {class:#x} attribute {id}"
            );
        }
    }
}

#[tokio::test]
async fn missing_objects_and_attributes_have_their_status() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_bench, mut client) = client(folder.path()).await;
    let classes: Vec<u16> = ATTRIBUTES.iter().map(|(class, ..)| *class).collect();
    for class in classes {
        let none = get(&mut client, class, 0, 99).await;
        assert_eq!(codes(none.status), (0x14, 0), "class {class:#x}, class attribute 99");
        let set = attribute(service::SET_ATTRIBUTE_SINGLE, class, 0, 1, &[1, 0]);
        assert_eq!(
            codes(client.ask(&set).await.status),
            (0x0E, 0),
            "class {class:#x} is set"
        );
        let far = get(&mut client, class, 0xFFFF_FFF0, 1).await;
        // An execution that there never was, or that was dropped.
        let expected = if class == 0x303 { 0x16 } else { 0x05 };
        assert_eq!(codes(far.status), (expected, 0), "class {class:#x}, no such instance");
        for code in [service::SET_ATTRIBUTES_ALL, 0x15, 0x16, 0x4B, 0x0D, 0x18, 0x19] {
            let reply = ask(&mut client, code, class, 0, &[]).await;
            assert_eq!(codes(reply.status), (0x08, 0), "class {class:#x} service {code:#x}");
        }
    }
    #[rustfmt::skip]
    let cases: [Refused; 30] = [
        // Probes of HMI browsers: each has its answer at once, with the status of an object that does not exist.
        (0x01, 0x47, 1, None, &[], (0x05, 0)),
        (0x0E, 0x47, 1, Some(1), &[], (0x05, 0)),
        (0x15, 0x01, 1, None, &[], (0x08, 0)),
        (0x16, 0x01, 1, None, &[], (0x08, 0)),
        (0x4B, 0x64, 1, None, &[0; 8], (0x08, 0)),
        (0x4B, 0xB2, 1, None, &[], (0x05, 0)),
        (0x55, 0x68, 0, None, &[1, 0, 28, 0], (0x05, 0)),
        (0x01, 0xF4, 2, None, &[], (0x05, 0)),
        // Reset: no role may execute it, and there is no type 2.
        (0x05, 0x01, 1, None, &[], (0x0F, 0)),
        (0x05, 0x01, 1, None, &[0], (0x0F, 0)),
        (0x05, 0x01, 1, None, &[1], (0x0F, 0)),
        (0x05, 0x01, 1, None, &[2], (0x20, 0)),
        (0x05, 0x01, 0, None, &[], (0x08, 0)),
        (0x05, 0x02, 1, None, &[], (0x08, 0)),
        // Attributes that are not there, cannot be set, or not so.
        (0x0E, 0x01, 1, Some(11), &[], (0x14, 0)),
        (0x0E, 0x01, 1, None, &[], (0x04, 0)),
        (0x0E, 0x02, 1, Some(4), &[], (0x14, 0)),
        (0x0E, 0xF5, 1, Some(7), &[], (0x14, 0)),
        (0x10, 0x01, 1, Some(7), b"\x01X", (0x0E, 0)),
        (0x10, 0x01, 1, Some(99), &[0], (0x14, 0)),
        (0x10, 0xF5, 1, Some(5), &[0; 22], (0x0E, 0)),
        (0x10, 0xF5, 1, Some(13), &[1], (0x13, 0)),
        (0x10, 0xF5, 1, Some(13), &[60, 0, 0], (0x15, 0)),
        (0x10, 0xF5, 1, Some(13), &[0x11, 0x0E], (0x09, 0)),
        (0x10, 0x48, 1, Some(4), &[46], (0x0E, 0)),
        (0x10, 0x48, 1, Some(0), &[46], (0x14, 0)),
        (0x0E, 0x48, 1, Some(9), &[], (0x14, 0)),
        (0x0E, 0x06, 1, Some(9), &[], (0x14, 0)),
        (0x0E, 0x8B, 1, Some(8), &[], (0x14, 0)),
        (0x10, 0x8B, 1, Some(11), &[0; 8], (0x0E, 0)),
    ];
    for (code, class, instance, id, data, expected) in cases {
        let mut path = Epath::object(class, instance);
        path.0.extend(id.map(|id| Segment::Attribute(id.into())));
        let reply = client
            .ask(&Request::new(code, path, Bytes::copy_from_slice(data)))
            .await;
        assert_eq!(
            codes(reply.status),
            expected,
            "{code:#x} of {class:#x}/{instance}/{id:?}"
        );
    }
}

#[tokio::test]
async fn a_list_tells_of_each_attribute_and_lies_about_its_count_do_no_harm() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_bench, mut client) = client(folder.path()).await;
    let mixed = ask(&mut client, service::GET_ATTRIBUTE_LIST, 0x01, 1, &list(&[1, 99, 8])).await;
    assert_eq!(codes(mixed.status), (0x0A, 0));
    assert_eq!(hex(&mixed.data), "030001000000c1a26300140008000000".to_owned() + "03");
    let set = [2, 0, 13, 0, 30, 0, 6, 0, 0, 0];
    let mixed = ask(&mut client, service::SET_ATTRIBUTE_LIST, 0xF5, 1, &set).await;
    assert_eq!(
        (codes(mixed.status), hex(&mixed.data).as_str()),
        ((0x0A, 0), "02000d00000006000e00")
    );
    assert_eq!(get(&mut client, 0xF5, 1, 13).await.data[..], [30, 0]);
    // Every count with every length behind it, on every class (OpENer CVE-2020-13556, CVE-2022-43604, -43605).
    for class in [
        0x01, 0x02, 0x06, 0x48, 0x64, 0x6B, 0x6C, 0x8B, 0xAC, 0xF4, 0xF5, 0xF6, 0x300, 0x301, 0x302, 0x303,
    ] {
        for code in [service::GET_ATTRIBUTE_LIST, service::SET_ATTRIBUTE_LIST] {
            for count in [0_u16, 1, 2, 255, 256, 257, 0x7FFF, 0x8000, 0xFFFF] {
                for length in 0..6 {
                    let mut data = count.to_le_bytes().to_vec();
                    data.truncate(length);
                    data.resize(length, 1);
                    let reply = ask(&mut client, code, class, 1, &data).await;
                    assert!(
                        matches!(
                            reply.status.general(),
                            0x00 | 0x03 | 0x05 | 0x0A | 0x0E | 0x11 | 0x13 | 0x14 | 0x16
                        ),
                        "class {class:#x} service {code:#x} count {count} length {length}: {}",
                        reply.status
                    );
                }
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn the_inactivity_time_out_that_a_client_sets_holds_for_everybody() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (bench, mut client) = client(folder.path()).await;
    let mut other = bench.client().await;
    let set = attribute(service::SET_ATTRIBUTE_SINGLE, 0xF5, 1, 13, &[5, 0]);
    assert!(client.ask(&set).await.status.is_success());
    let began = tokio::time::Instant::now();
    assert!(other.frame().await.is_none(), "the one that was silent is closed");
    let silent = began.elapsed().as_secs_f64();
    assert!((4.9..7.0).contains(&silent), "closed after {silent} s");
    // Never: ten minutes of silence are no reason.
    let mut client = bench.client().await;
    let never = attribute(service::SET_ATTRIBUTE_SINGLE, 0xF5, 1, 13, &[0, 0]);
    assert!(client.ask(&never).await.status.is_success());
    tokio::time::sleep(std::time::Duration::from_secs(600)).await;
    assert!(get(&mut client, 0x01, 1, 1).await.status.is_success());
}

async fn refuse_one_open_and_one_close(client: &mut Client) {
    let key = ConnectionKey {
        serial: 1,
        vendor: 2,
        originator: 3,
    };
    let refused = client.ask(&forward_open(1, key)).await;
    assert_eq!(codes(refused.status), (0x01, 0x0109));
    let refused = ask(client, service::FORWARD_CLOSE, 0x06, 1, &[0, 0]).await;
    assert_eq!(refused.status.general(), 0x13);
}
