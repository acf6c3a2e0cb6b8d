//! Class 0x0305: STOP and its release as services, the identification of clients, counters; and the movers of axes and coordinate
//! systems.

use arcline_instruction_set::Mnemonic;
use arcline_proto::arcline::machine::{self, CommandCount, Identification, attribute, decode_counts, service as own};
use arcline_proto::arcline::motion::{Mover, MoverKind, axis, coordinate_system};
use arcline_proto::cip::{join_multiple, split_multiple_replies};

use super::motion::{line, name, numbers, on};
use super::*;

/// Axes of the default machine that are in no coordinate system with others: S and A.
const S: u32 = 4;
const A: u32 = 5;

fn jog(axis: u32) -> Request {
    let mut operands = vec![name("")];
    operands.extend([0.0, 5.0, 0.0, 1000.0, 0.0, 1000.0, 0.0].map(|number| numbers(&[number])));
    on(Mnemonic::Maj, axis, &operands)
}

fn service_of(code: u8, data: &[u8]) -> Request {
    Request::new(code, Epath::object(machine::CLASS, machine::INSTANCE), data.to_vec())
}

fn get(class: u16, instance: u32, attribute: u16) -> Request {
    Request::new(
        service::GET_ATTRIBUTE_SINGLE,
        Epath::attribute(class, instance, attribute),
        Bytes::new(),
    )
}

impl Client {
    async fn is_inhibited(&mut self) -> bool {
        let reply = self.ask(&get(machine::CLASS, 1, attribute::MOTION_INHIBITED)).await;
        reply.data[..] == [1]
    }

    async fn mover(&mut self, class: u16, instance: u32, attribute: u16) -> Mover {
        let reply = self.ask(&get(class, instance, attribute)).await;
        Mover::decode(&reply.data).unwrap_or_else(|| panic!("{}", reply.status))
    }
}

#[tokio::test]
async fn stop_is_a_service_and_holds_until_it_is_released() {
    let bench = Bench::new();
    let (mut one, mut two) = (bench.client().await, bench.client().await);
    assert_eq!(codes(one.ask(&jog(S)).await.status), (0, 0));
    assert_eq!(codes(two.ask(&service_of(own::STOP, &[])).await.status), (0, 0));
    assert!(one.is_inhibited().await);
    // ERR 53 with the index of no operand.
    assert_eq!(codes(one.ask(&jog(A)).await.status), (0x1F, 53));
    #[rustfmt::skip]
    let packets: [(&str, &[u8], bool); 3] = [
        ("a STOP behind a release", &[own::RELEASE, own::STOP], true),
        ("a release behind a STOP", &[own::STOP, own::RELEASE], false),
        ("a STOP alone",            &[own::STOP],               true),
    ];
    for (why, codes_of, inhibited) in packets {
        let requests: Vec<Request> = codes_of.iter().map(|code| service_of(*code, &[])).collect();
        let data = join_multiple(&requests).expect("short paths");
        let packet = Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data);
        let reply = one.ask(&packet).await;
        let parts = split_multiple_replies(&reply.data).expect("a packet of replies");
        assert!(parts.iter().all(|part| part.status.is_success()), "{why}");
        assert_eq!(two.is_inhibited().await, inhibited, "{why}");
    }
    #[rustfmt::skip]
    let refused: [(&str, Request, (u8, u16)); 7] = [
        ("data behind it",   service_of(own::STOP, &[1]),    (0x15, 0)),
        ("data of Release",  service_of(own::RELEASE, &[1]), (0x15, 0)),
        ("a service of none", service_of(0x37, &[]),         (0x08, 0)),
        ("a step that is cut", service_of(own::STEP, &[1, 0]), (0x13, 0)),
        ("too many ticks",   service_of(own::STEP, &1_000_001u32.to_le_bytes()), (0x20, 0)),
        ("a step on the real clock", service_of(own::STEP, &1u32.to_le_bytes()), (0x0C, 0)),
        ("the class",        Request::new(own::STOP, Epath::object(machine::CLASS, 0), Bytes::new()), (0x08, 0)),
    ];
    for (why, request, status) in refused {
        assert_eq!(codes(one.ask(&request).await.status), status, "{why}");
        assert!(one.is_inhibited().await, "{why}");
    }
    assert_eq!(codes(two.ask(&service_of(own::RELEASE, &[])).await.status), (0, 0));
    assert!(!one.is_inhibited().await);
    assert_eq!(codes(one.ask(&jog(A)).await.status), (0, 0));
    let counts = one.ask(&get(machine::CLASS, 1, attribute::COMMANDS)).await;
    let counts = decode_counts(&counts.data).expect("a list");
    let of = |kind: &str| counts.iter().find(|count| count.kind == kind).cloned().expect(kind);
    let expected = |kind: &str, done| CommandCount {
        kind: kind.into(),
        done,
        refused: 0,
    };
    // STOP: a service, twice in a packet with a release, one in a packet alone. Releases: twice in packets and a service.
    assert_eq!(of("stops"), expected("stops", 7));
    assert_eq!(of("instructions"), expected("instructions", 3));
    bench.device.plant.stop_all();
}

#[tokio::test]
async fn an_object_names_its_mover() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let nothing = Mover::default();
    assert_eq!(client.mover(0x0301, S, axis::MOVER).await, nothing);
    assert_eq!(codes(client.ask(&jog(S)).await.status), (0, 0));
    let plain = Mover {
        kind: MoverKind::CLIENT,
        address: PEER.to_string(),
        ..Mover::default()
    };
    assert_eq!(
        client.mover(0x0301, S, axis::MOVER).await,
        plain,
        "nothing else is known"
    );

    client.open(500, 1).await;
    assert_eq!(codes(client.ask(&jog(A)).await.status), (0, 0));
    let shown = client.mover(0x0301, A, axis::MOVER).await;
    assert_eq!(
        (&*shown.identification.product, shown.address),
        ("pylogix", PEER.to_string()),
        "by its vendor id and serial number"
    );

    let identification = Identification {
        product: "arcline 0.2.0".into(),
        user: "jane".into(),
        program: "part.st".into(),
    };
    let identified = client.ask(&service_of(own::IDENTIFY, &identification.to_bytes())).await;
    assert_eq!(codes(identified.status), (0, 0));
    let moved = client
        .ask(&on(Mnemonic::Mclm, 1, &line("", &[100_000.0, 0.0, 0.0])))
        .await;
    assert_eq!(codes(moved.status), (0, 0), "{}", moved.status);
    let mover = Mover {
        identification: identification.clone(),
        ..plain.clone()
    };
    assert_eq!(client.mover(0x0302, 1, coordinate_system::MOVER).await, mover);
    assert_eq!(
        client.mover(0x0301, 1, axis::MOVER).await,
        mover,
        "its coordinate system moves it"
    );
    assert_eq!(
        mover.to_string(),
        format!("{PEER} (arcline 0.2.0, user jane, program part.st)")
    );
    assert_eq!(client.mover(0x0301, S, axis::MOVER).await, plain, "as it was then");
    let cut = client
        .ask(&service_of(own::IDENTIFY, &identification.to_bytes()[..5]))
        .await;
    assert_eq!(codes(cut.status), (0x13, 0));
    bench.device.plant.stop_all();
}
