//! The security objects and the item of ListIdentity, byte by byte (spec/security.md §2, §4; OpENer's branch `CIPSecurity_develop`).

use std::net::SocketAddr;

use arcline_config::{PlainAccess, Role};
use arcline_proto::cpf::{Item, decode_items, item_type};
use arcline_proto::encap::Command;
use arcline_proto::epath::Epath;
use arcline_proto::security::{CONFIDENTIALITY, FACTORY_DEFAULT, SecurityInformation, port};

use super::*;
use crate::eip::objects::{Objects, On};

/// A device whose configuration has TLS.
fn bench(change: impl FnOnce(&mut arcline_config::Security)) -> Bench {
    Bench::with(|settings| {
        settings.config.security.tls = Some(SocketAddr::from(([127, 0, 0, 1], 2221)));
        change(&mut settings.config.security);
    })
}

async fn get(client: &mut Client, class: u16, instance: u32, id: u16) -> Reply {
    let path = Epath::attribute(class, instance, id);
    client
        .ask(&Request::new(service::GET_ATTRIBUTE_SINGLE, path, Bytes::new()))
        .await
}

/// Class, instance, attribute, bytes with TLS, bytes without; `None`: there is no such instance.
type Row = (u16, u32, u16, &'static [u8], Option<&'static [u8]>);

#[rustfmt::skip]
const ROWS: &[Row] = &[
    // CIP Security: configured or factory default; confidentiality; in use.
    (0x5D, 0, 1, &[3, 0],                          Some(&[3, 0])),
    (0x5D, 1, 1, &[2],                             Some(&[0])),
    (0x5D, 1, 2, &[2, 0],                          Some(&[2, 0])),
    (0x5D, 1, 3, &[2, 0],                          Some(&[0, 0])),
    // EtherNet/IP Security: state, no renegotiation, nine suites in IANA's byte order, twice.
    (0x5E, 0, 1, &[7, 0],                          Some(&[7, 0])),
    (0x5E, 0, 8, &[0, 0],                          Some(&[0, 0])),
    (0x5E, 0, 9, &[0],                             Some(&[0])),
    (0x5E, 1, 1, &[2],                             Some(&[0])),
    (0x5E, 1, 2, &[0, 0, 0, 0],                    Some(&[0, 0, 0, 0])),
    (0x5E, 1, 3, SUITES,                           Some(SUITES)),
    (0x5E, 1, 4, SUITES,                           Some(SUITES)),
    // No keys; one certificate: two words, class 0x5F, instance 2; no authorities and lists as objects.
    (0x5E, 1, 5, &[0],                             Some(&[0])),
    (0x5E, 1, 6, &[1, 2, 0x20, 0x5F, 0x24, 2],     Some(&[0])),
    (0x5E, 1, 7, &[0],                             Some(&[0])),
    (0x5E, 1, 8, &[0],                             Some(&[0])),
    // The client is verified, the chain sent, the expiration checked; no identities.
    (0x5E, 1, 9, &[1],                             Some(&[1])),
    (0x5E, 1, 10, &[1],                            Some(&[1])),
    (0x5E, 1, 11, &[1],                            Some(&[1])),
    (0x5E, 1, 12, &[0],                            Some(&[0])),
    // No pull model; 12 s; not UDP only.
    (0x5E, 1, 13, &[0],                            Some(&[0])),
    (0x5E, 1, 14, &[0xFF, 0xFF],                   Some(&[0xFF, 0xFF])),
    (0x5E, 1, 15, &[12, 0],                        Some(&[12, 0])),
    (0x5E, 1, 16, &[0],                            Some(&[0])),
    // Certificate Management: neither push nor pull, the certificates by name and path, PEM.
    (0x5F, 0, 1, &[2, 0],                          Some(&[2, 0])),
    (0x5F, 0, 2, &[2, 0],                          Some(&[1, 0])),
    (0x5F, 0, 8, &[0, 0, 0, 0],                    Some(&[0, 0, 0, 0])),
    (0x5F, 0, 9, b"\x02\x1aDefault Device Certificate\x02\x20\x5F\x24\x01\x0aConfigured\x02\x20\x5F\x24\x02",
                                                   Some(b"\x01\x1aDefault Device Certificate\x02\x20\x5F\x24\x01")),
    (0x5F, 0, 10, &[1, 0, 0, 0],                   Some(&[1, 0, 0, 0])),
    // The factory's certificate is empty; that of the configuration is verified.
    (0x5F, 1, 1, b"\x1aDefault Device Certificate", Some(b"\x1aDefault Device Certificate")),
    (0x5F, 1, 2, &[0],                             Some(&[0])),
    (0x5F, 1, 3, &[0, 0],                          Some(&[0, 0])),
    (0x5F, 2, 1, b"\x0aConfigured",                None),
    (0x5F, 2, 2, &[3],                             None),
    (0x5F, 2, 3, &[1, 0],                          None),
    (0x5F, 2, 4, &[1, 0],                          None),
    (0x5F, 2, 5, &[0],                             None),
];

const SUITES: &[u8] = &[
    9, 0x13, 0x02, 0x13, 0x01, 0x13, 0x03, 0xC0, 0x2C, 0xC0, 0x2B, 0xCC, 0xA9, 0xC0, 0x30, 0xC0, 0x2F, 0xCC, 0xA8,
];

#[tokio::test]
async fn every_attribute_has_its_bytes() {
    for has_tls in [true, false] {
        let bench = if has_tls { bench(|_| {}) } else { Bench::new() };
        let mut client = bench.client().await;
        for (class, instance, id, with, without) in ROWS {
            let reply = get(&mut client, *class, *instance, *id).await;
            let place = format!("TLS {has_tls}: class {class:#x} instance {instance} attribute {id}");
            match if has_tls { Some(*with) } else { *without } {
                Some(expected) => assert_eq!((codes(reply.status), &reply.data[..]), ((0, 0), expected), "{place}"),
                None => assert_eq!(codes(reply.status), (0x05, 0), "{place}"),
            }
        }
        // Attributes on which the editions of the specification differ do not exist.
        for id in 17..=20 {
            assert_eq!(
                codes(get(&mut client, 0x5E, 1, id).await.status),
                (0x14, 0),
                "attribute {id}"
            );
        }
    }
}

/// Class, instance, attribute, the bytes of OpENer's branch `CIPSecurity_develop` 155d6cf as it runs (2026-11-26), and why ours are others.
type Theirs = (u16, u32, u16, &'static [u8], Option<&'static str>);

#[rustfmt::skip]
const OPENER: &[Theirs] = &[
    (0x5D, 0, 1, &[3, 0], None), (0x5D, 0, 2, &[1, 0], None), (0x5D, 0, 3, &[1, 0], None), (0x5D, 0, 6, &[7, 0], None),
    (0x5D, 0, 7, &[3, 0], None), (0x5D, 1, 1, &[0], None), (0x5D, 1, 2, &[2, 0], None),
    (0x5D, 1, 3, &[2, 0], Some("no profile is in use without TLS")),
    (0x5E, 0, 1, &[7, 0], None), (0x5E, 0, 2, &[1, 0], None), (0x5E, 0, 3, &[1, 0], None), (0x5E, 0, 6, &[9, 0], None),
    (0x5E, 0, 7, &[0x10, 0], None), (0x5E, 0, 8, &[0, 0], None),
    (0x5E, 0, 9, &[4], Some("no key is shared, so none has a use")),
    (0x5E, 1, 1, &[0], None), (0x5E, 1, 2, &[0, 0, 0, 0], None),
    (0x5E, 1, 3, &[8, 0, 0x3B, 0, 0x3C, 0, 0x3D, 0xC0, 6, 0xC0, 0x23, 0xC0, 0x24, 0xC0, 0x3A, 0xC0, 0x37], Some("those of the first edition")),
    (0x5E, 1, 4, &[2, 0xC0, 0x23, 0xC0, 0x24], Some("those of the first edition")),
    (0x5E, 1, 5, &[0], None),
    (0x5E, 1, 6, &[1, 2, 0x20, 0x5F, 0x24, 1], Some("no certificate is in use without TLS")),
    (0x5E, 1, 7, &[0], None), (0x5E, 1, 8, &[0], None),
    (0x5E, 1, 9, &[0], Some("a client is always verified")), (0x5E, 1, 10, &[0], Some("the chain is always sent")),
    (0x5E, 1, 11, &[0], Some("the expiration is checked")),
    (0x5E, 1, 12, &[0], None),
    (0x5E, 1, 13, &[1], Some("there is no pull model")), (0x5E, 1, 14, &[0, 0], Some("there is no pull model")),
    (0x5E, 1, 15, &[12, 0], None), (0x5E, 1, 16, &[0], None),
    (0x5F, 0, 1, &[2, 0], None), (0x5F, 0, 2, &[1, 0], None), (0x5F, 0, 3, &[1, 0], None), (0x5F, 0, 6, &[10, 0], None),
    (0x5F, 0, 7, &[5, 0], None),
    (0x5F, 0, 8, &[1, 0, 0, 0], Some("no certificate is pushed")),
    (0x5F, 0, 9, b"\x01\x1aDefault Device Certificate\x02\x20\x5F\x24\x01", None),
    (0x5F, 0, 10, &[3, 0, 0, 0], Some("PEM alone")),
    (0x5F, 1, 1, b"\x1aDefault Device Certificate", None),
    (0x5F, 1, 2, &[3], Some("that of the factory does not exist")),
    (0x5F, 1, 3, &[1, 2, 0x20, 0x37, 0x24, 1], Some("a certificate is no File object")),
    (0x5F, 1, 4, &[1, 2, 0x20, 0x37, 0x24, 2], Some("an authority is no File object")),
    (0x5F, 1, 5, &[0], None),
];

/// As OpENer from the factory, without TLS: the same bytes, but where a value is another one on purpose.
#[tokio::test]
async fn attributes_have_the_bytes_of_opener() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    for (class, instance, id, theirs, why) in OPENER {
        let reply = get(&mut client, *class, *instance, *id).await;
        let place = format!("class {class:#x} instance {instance} attribute {id}: {why:?}");
        assert_eq!(codes(reply.status), (0, 0), "{place}");
        assert_eq!(
            reply.data[..] == **theirs,
            why.is_none(),
            "{place}: {:02x?}",
            &reply.data[..]
        );
    }
}

/// The item of OpENer's ListIdentity, where it stands behind the identity too.
#[test]
fn the_item_of_opener_reads() {
    let theirs = SecurityInformation::decode(&[2, 0, 0, 0, 3, 2, 0]).expect("whole");
    assert_eq!(
        (theirs.profiles, theirs.profiles_configured),
        (CONFIDENTIALITY, CONFIDENTIALITY)
    );
    assert_eq!(
        (theirs.state, theirs.ethernet_ip_state),
        (FACTORY_DEFAULT, FACTORY_DEFAULT)
    );
    assert_eq!(theirs.ports, port::EXPLICIT_TCP | port::EXPLICIT_UDP);
    assert_eq!(theirs.encode(), [2, 0, 0, 0, 3, 2, 0]);
}

#[tokio::test]
async fn all_attributes_come_in_their_order() {
    let bench = bench(|_| {});
    let mut client = bench.client().await;
    for (class, instance) in [(0x5D, 1), (0x5E, 1), (0x5F, 1), (0x5F, 2)] {
        let path = Epath::object(class, instance);
        let all = Request::new(service::GET_ATTRIBUTES_ALL, path, Bytes::new());
        let reply = client.ask(&all).await;
        let mut expected = Vec::new();
        for id in 1..=16 {
            let one = get(&mut client, class, instance, id).await;
            // Attribute 3 of CIP Security is not among them.
            if one.status.is_success() && (class, id) != (0x5D, 3) {
                expected.extend_from_slice(&one.data);
            }
        }
        assert_eq!(
            (codes(reply.status), &reply.data[..]),
            ((0, 0), &expected[..]),
            "class {class:#x}"
        );
    }
}

/// No role changes an attribute of these objects: 0x0F.
#[tokio::test]
async fn every_service_that_would_change_something_is_refused() {
    let bench = bench(|_| {});
    let mut client = bench.client().await;
    let mut asked = 0;
    for role in [Role::Viewer, Role::Administrator] {
        bench.device.plant.roles().set(1, role);
        for class in [0x5D, 0x5E, 0x5F] {
            for own in Objects::ALL.find(class).expect("it answers").services() {
                let instance = if own.on == On::Class { 0 } else { 1 };
                let request = Request::new(own.code, Epath::object(class, instance), Bytes::new());
                let reply = client.ask(&request).await;
                assert_eq!(
                    codes(reply.status),
                    (0x0F, 0),
                    "{} of class {class:#x} as {}",
                    own.name,
                    role.word()
                );
                asked += 1;
            }
        }
    }
    assert_eq!(asked, 2 * 14);
    let set = Request::new(
        service::SET_ATTRIBUTE_SINGLE,
        Epath::attribute(0x5E, 1, 4),
        Bytes::from_static(&[0]),
    );
    assert_eq!(codes(client.ask(&set).await.status), (0x0E, 0), "nothing can be set");
}

#[tokio::test]
async fn list_identity_has_an_item_behind_the_identity() {
    #[rustfmt::skip]
    let cases = [
        ("plain beside TLS",   PlainAccess::On,        0x0B),
        ("hardened",           PlainAccess::Off,       0x0A),
        ("discovery only",     PlainAccess::Discovery, 0x0B),
    ];
    for (why, plain, ports) in cases {
        let bench = bench(|security| security.plain = plain);
        // Also where the session is refused.
        let mut client = bench.client().await;
        let reply = client.exchange(Command::LIST_IDENTITY, Bytes::new()).await;
        let items = decode_items(&reply.data).expect("items");
        let [Item::Identity(_), Item::Other { item, data }] = items.as_slice() else {
            panic!("{why}: {items:?}");
        };
        assert_eq!(*item, item_type::SECURITY_INFORMATION);
        assert_eq!(data[..], [2, 0, 2, 2, ports, 2, 0], "{why}");
    }
}
