//! EtherNet/IP clients of every role: what each may, as a service, by a tag, in a packet, and inside of Unconnected Send.

use arcline_config::Role;
use arcline_instruction_set::Mnemonic;
use arcline_proto::arcline::{machine, trace};
use arcline_proto::cip::join_multiple;
use arcline_proto::epath::Segment;
use arcline_proto::logix::CreateSymbol;

use super::motion::{line, name, on};
use super::*;
use crate::eip::connection::Incoming;
use crate::plant::Right;

const REAL: WireType = WireType::Atomic(0xCA);
const BOOL: WireType = WireType::Atomic(0xC1);
const DINT: WireType = WireType::Atomic(0xC4);
/// Class and attribute of the feed override of a coordinate system.
const FEED_OVERRIDE: (u16, u16) = (0x0302, arcline_proto::arcline::motion::coordinate_system::FEED_OVERRIDE);
/// 0x0F.
const PRIVILEGE: u8 = 0x0F;

impl Bench {
    pub(super) async fn client_as(&self, role: Role) -> Client {
        let (ours, theirs) = tokio::io::duplex(64 * 1024);
        let incoming = Incoming {
            slot: None,
            local: LOCAL,
            peer: PEER,
            role,
            tls: None,
        };
        tokio::spawn(connection::serve_in(incoming, theirs, self.device.clone()));
        self.client_on(ours).await
    }
}

pub(super) fn set(class: u16, attribute: u16, data: &[u8]) -> Request {
    let mut path = Epath::object(class, 1);
    path.0.push(Segment::Attribute(attribute.into()));
    Request::new(service::SET_ATTRIBUTE_SINGLE, path, Bytes::copy_from_slice(data))
}

/// One request for each right that EtherNet/IP reaches, twice where it is reached in another way.
fn requests() -> Vec<(&'static str, Right, Request)> {
    let create = CreateSymbol {
        name: "Fresh".to_owned(),
        data_type: "DINT".to_owned(),
        access: 0,
    };
    let own = |code: u8| Request::new(code, Epath::object(machine::CLASS, 1), Bytes::new());
    let double = 150_f32.to_le_bytes();
    let tag_instance = Request::new(service::CREATE, Epath::object(0x6B, 0), create.to_bytes());
    #[rustfmt::skip]
    let requests = vec![
        ("a read",                    Right::Look,          read("aDint", 1)),
        ("an attribute",              Right::Look,          Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(1, 1), Bytes::new())),
        ("the signals of traces",     Right::Look,          Request::new(trace::service::LIST_SIGNALS, Epath::object(trace::CLASS, 0), Bytes::from_static(&[0, 0]))),
        ("STOP",                      Right::Stop,          own(machine::service::STOP)),
        ("STOP as a tag",             Right::Stop,          write("MotionInhibit", BOOL, 1, &[1])),
        ("its release",               Right::ReleaseStop,   own(machine::service::RELEASE)),
        ("its release as a tag",      Right::ReleaseStop,   write("MotionInhibit", BOOL, 1, &[0])),
        ("a write",                   Right::WriteTag,      write("aDint", DINT, 1, &[1, 0, 0, 0])),
        ("a write of a member",       Right::WriteTag,      write("Move1.Speed", REAL, 1, &double)),
        ("EnableIn of a move",        Right::Move,          write("Move1.EnableIn", BOOL, 1, &[0])),
        ("a motion service",          Right::Move,          on(Mnemonic::Mclm, 1, &line("Ctl", &[1.0, 1.0, 0.0]))),
        ("a servo",                   Right::Move,          on(Mnemonic::Msf, 7, &[name("Servo")])),
        ("an override",               Right::Override,      write("FeedOverride[0]", REAL, 1, &50_f32.to_le_bytes())),
        ("an override above 100 %",   Right::OverrideAbove, write("FeedOverride[0]", REAL, 1, &double)),
        ("the same, by its object",   Right::OverrideAbove, set(FEED_OVERRIDE.0, FEED_OVERRIDE.1, &double)),
        ("a fault",                   Right::InjectFaults,  write("FaultInject[0]", DINT, 1, &[0; 4])),
        ("a new tag",                 Right::ChangeTags,    tag_instance),
        ("the clock",                 Right::SetClock,      set(0x8B, 6, &1_795_301_281_000_000_u64.to_le_bytes())),
        ("the inactivity",            Right::SetInactivity, set(0xF5, 13, &[120, 0])),
        ("the reaction to a loss",    Right::SetLoss,       set(0x06, 100, &[0])),
        ("a trace",                   Right::SetUpTrace,    Request::new(service::CREATE, Epath::object(trace::CLASS, 0), Bytes::new())),
    ];
    requests
}

#[tokio::test]
async fn every_request_for_every_role() {
    let bench = Bench::new();
    for role in Role::ALL {
        let mut client = bench.client_as(role).await;
        for (why, right, request) in requests() {
            let alone = codes(client.ask(&request).await.status).0;
            let expected = !right.is_of(role);
            assert_eq!(alone == PRIVILEGE, expected, "{why} as {}: 0x{alone:02X}", role.word());
            // Each request of a packet is judged alone; the packet itself is answered.
            let around = [read("aDint", 1), request.clone(), read("aDint", 1)];
            let packet = Request::new(
                service::MULTIPLE_SERVICE_PACKET,
                Epath::object(2, 1),
                join_multiple(&around).expect("short"),
            );
            let reply = client.ask(&packet).await;
            let replies = arcline_proto::cip::split_multiple_replies(&reply.data).expect("replies");
            let statuses: Vec<u8> = replies.iter().map(|reply| codes(reply.status).0).collect();
            // A long answer leaves no room for the second read.
            assert!(
                statuses[0] == 0 && [0, 6].contains(&statuses[2]),
                "{why}: the reads around it"
            );
            assert_eq!(
                statuses[1] == PRIVILEGE,
                expected,
                "{why} in a packet as {}",
                role.word()
            );
        }
        assert_eq!(client.read("aDint").await.data.len(), 4, "the connection lives");
    }
    assert!(
        bench.device.plant.with_image(|image| image.find("Fresh").is_some()),
        "an engineer made it"
    );
}

/// A request that no role may make is refused alike for every role: clients find out by it what the server is.
#[tokio::test]
async fn what_does_not_exist_has_the_same_status_for_every_role() {
    let bench = Bench::new();
    let mut statuses = Vec::new();
    for role in Role::ALL {
        let mut client = bench.client_as(role).await;
        let mut of_role = Vec::new();
        for request in [
            write("NoSuchTag", DINT, 1, &[0; 4]),
            Request::new(0x4B, Epath::object(0x77, 1), Bytes::new()),
            Request::new(0x7E, Epath::object(1, 1), Bytes::new()),
            set(1, 1, &[0, 0]),
            write("aDint", REAL, 1, &[0; 4]),
        ] {
            of_role.push(codes(client.ask(&request).await.status));
        }
        statuses.push(of_role);
    }
    assert!(statuses.windows(2).all(|two| two[0] == two[1]), "{statuses:?}");
}

/// A role that changes holds for the connection that is open.
#[tokio::test]
async fn a_role_that_changes_holds_from_the_next_request_on() {
    let bench = Bench::new();
    let mut client = bench.client_as(Role::Operator).await;
    let write = write("aDint", DINT, 1, &[1, 0, 0, 0]);
    assert!(client.ask(&write).await.status.is_success());
    bench.device.plant.roles().set(0, Role::Viewer);
    assert_eq!(codes(client.ask(&write).await.status).0, PRIVILEGE);
}

#[tokio::test]
async fn requests_have_a_rate_by_role_and_stops_have_none() {
    let bench = Bench::with(|settings| settings.config.security.max_requests = [20, 0, 0, 0]);
    let mut viewer = bench.client_as(Role::Viewer).await;
    let mut answered = 0;
    for _ in 0..200 {
        answered += usize::from(viewer.ask(&read("aDint", 1)).await.status.is_success());
    }
    assert!((20..150).contains(&answered), "{answered} of 200");
    let stop = Request::new(machine::service::STOP, Epath::object(machine::CLASS, 1), Bytes::new());
    for _ in 0..50 {
        assert!(viewer.ask(&stop).await.status.is_success());
    }
    let mut operator = bench.client_as(Role::Operator).await;
    for _ in 0..200 {
        assert!(operator.ask(&read("aDint", 1)).await.status.is_success());
    }
}
