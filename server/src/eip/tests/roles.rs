//! EtherNet/IP clients of every role: the permitted services, tags and packets of each, also inside of Unconnected Send.

use std::collections::BTreeMap;

use arcline_config::{IoLoss, Role};
use arcline_instruction_set::Mnemonic;
use arcline_proto::arcline::machine::SeriesReply;
use arcline_proto::arcline::motion::axis as of_axis;
use arcline_proto::arcline::{machine, trace};
use arcline_proto::cip::join_multiple;
use arcline_proto::connection::UnconnectedSend;
use arcline_proto::epath::Segment;
use arcline_proto::logix::CreateSymbol;

use super::io::open;
use super::motion::{line, name, on};
use super::trace::config;
use super::*;
use crate::eip::connection::Incoming;
use crate::eip::io::layout::{INPUT_ONLY, OUTPUT};
use crate::eip::objects::{Objects, On};
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

/// Every attribute that can be set, by its class and number, with the right that a value of zeros needs. A test holds that there are no others.
const SETTABLE: [(u16, u16, Right); 23] = [
    (0x04, 3, Right::OwnOutputs),
    (0x06, 100, Right::SetLoss),
    (0x8B, 5, Right::SetClock),
    (0x8B, 6, Right::SetClock),
    (0x8B, 7, Right::SetClock),
    (0x8B, 10, Right::SetClock),
    (0xF5, 13, Right::SetInactivity),
    (0x0301, of_axis::INJECTED_FAULTS, Right::InjectFaults),
    (0x0301, 11, Right::SetAttribute),
    (0x0301, 89, Right::SetAttribute),
    (0x0301, 90, Right::SetAttribute),
    (0x0301, 112, Right::SetAttribute),
    (0x0301, 113, Right::SetAttribute),
    (0x0302, 3, Right::SetAttribute),
    (0x0302, 4, Right::SetAttribute),
    (0x0302, 5, Right::SetAttribute),
    (0x0302, 6, Right::SetAttribute),
    (0x0302, 7, Right::SetAttribute),
    (0x0302, 8, Right::SetAttribute),
    (0x0302, 9, Right::SetAttribute),
    (0x0302, 26, Right::SetAttribute),
    (FEED_OVERRIDE.0, FEED_OVERRIDE.1, Right::Override),
    (machine::CLASS, machine::attribute::MODE, Right::ChangeMode),
];

/// The right that a request needs; `None`: every role is refused.
type Needs = Option<Right>;

/// Instances that the services of a role may delete.
#[derive(Clone, Copy)]
struct Made {
    trace: u32,
    symbol: u32,
}

/// An instance of a class that exists.
fn instance_of(class: u16, made: Made) -> u32 {
    match class {
        0x04 => OUTPUT,
        0x6B => made.symbol,
        trace::CLASS => made.trace,
        _ => 1,
    }
}

/// The attributes of [`SETTABLE`], by both services.
fn sets(widths: &BTreeMap<(u16, u16), usize>) -> Vec<(String, Needs, Request)> {
    let mut requests = Vec::new();
    for (class, attribute, right) in SETTABLE {
        let value = vec![0; widths[&(class, attribute)]];
        let instance = instance_of(class, Made { trace: 1, symbol: 1 });
        let single = Request::new(
            service::SET_ATTRIBUTE_SINGLE,
            Epath::attribute(class, instance, attribute),
            value.clone(),
        );
        let mut list = vec![1, 0];
        list.extend(attribute.to_le_bytes());
        list.extend(value);
        let list = Request::new(service::SET_ATTRIBUTE_LIST, Epath::object(class, instance), list);
        for (how, request) in [("", single), (" in a list", list)] {
            requests.push((
                format!("attribute {attribute} of 0x{class:X}{how}"),
                Some(right),
                request,
            ));
        }
    }
    requests
}

/// The services that each class has of its own, those that read its attributes, and every instruction.
fn services(made: Made) -> Vec<(String, Needs, Request)> {
    let mut requests = Vec::new();
    for object in Objects::ALL.0 {
        let class = object.class();
        for own in object.services() {
            let instance = match own.on {
                On::Class => 0,
                On::Instance | On::Any => instance_of(class, made),
            };
            // The server checks a whole series.
            let data = match (class, own.code) {
                (machine::CLASS, machine::service::EXECUTE_SERIES) => {
                    join_multiple(&[on(Mnemonic::Mclm, 1, &line("", &[0.0; 3]))]).expect("short")
                }
                _ => Bytes::new(),
            };
            // No role may commission the device or reset it.
            let needs = match class {
                0x01 | 0x5D | 0x5E | 0x5F => None,
                _ => Some(own.right),
            };
            let what = format!("{} of {}", own.name, object.name());
            requests.push((
                what,
                needs,
                Request::new(own.code, Epath::object(class, instance), data),
            ));
        }
        for instance in [0, instance_of(class, made)] {
            for (code, data) in [
                (service::GET_ATTRIBUTES_ALL, vec![]),
                (service::GET_ATTRIBUTE_LIST, vec![1, 0, 1, 0]),
            ] {
                let what = format!("service {code} of {} {instance}", object.name());
                let request = Request::new(code, Epath::object(class, instance), data);
                requests.push((what, Some(Right::Look), request));
            }
            let single = Request::new(
                service::GET_ATTRIBUTE_SINGLE,
                Epath::attribute(class, instance, 1),
                Bytes::new(),
            );
            requests.push((
                format!("attribute 1 of {} {instance}", object.name()),
                Some(Right::Look),
                single,
            ));
        }
    }
    for mnemonic in Mnemonic::ALL {
        let right = match mnemonic {
            Mnemonic::Mas | Mnemonic::Mcs | Mnemonic::Mgs => Right::Stop,
            _ => Right::Move,
        };
        requests.push((mnemonic.to_string(), Some(right), on(*mnemonic, 1, &[name("Matrix")])));
    }
    requests
}

fn create_tag(name: &str) -> Request {
    let create = CreateSymbol {
        name: name.to_owned(),
        data_type: "DINT".to_owned(),
        access: 0,
    };
    Request::new(service::CREATE, Epath::object(0x6B, 0), create.to_bytes())
}

/// Services of tags, and services that the tables of objects do not distinguish.
fn tags() -> Vec<(&'static str, Right, Request)> {
    let fragment = |path: Epath, data_type: u8, value: &[u8]| {
        let mut data = vec![data_type, 0, 1, 0, 0, 0, 0, 0];
        data.extend(value);
        Request::new(service::WRITE_TAG_FRAGMENTED, path, data)
    };
    let masks = |tag: &str, or: u8| Request::new(service::READ_MODIFY_WRITE_TAG, path(tag), vec![1, 0, or, 0xFF]);
    let (half, double) = (50_f32.to_le_bytes(), 150_f32.to_le_bytes());
    #[rustfmt::skip]
    let requests = vec![
        ("a read",                    Right::Look,          read("aDint", 1)),
        ("a read in parts",           Right::Look,          Request::new(service::READ_TAG_FRAGMENTED, path("Dints"), vec![1, 0, 0, 0, 0, 0])),
        ("STOP as a tag",             Right::Stop,          write("MotionInhibit", BOOL, 1, &[1])),
        ("its release as a tag",      Right::ReleaseStop,   write("MotionInhibit", BOOL, 1, &[0])),
        ("a write",                   Right::WriteTag,      write("aDint", DINT, 1, &[1, 0, 0, 0])),
        ("a write in parts",          Right::WriteTag,      fragment(path("aDint"), 0xC4, &[1, 0, 0, 0])),
        ("a write by masks",          Right::WriteTag,      masks("aSint", 1)),
        ("a write of a member",       Right::WriteTag,      write("Move1.Speed", REAL, 1, &double)),
        ("a write of a part of a structure", Right::WriteTag, write("Routes[0].Points[1].Valid", BOOL, 1, &[1])),
        ("a write by an alias",       Right::WriteTag,      write("Valid", BOOL, 1, &[1])),
        ("EnableIn of a move",        Right::Move,          write("Move1.EnableIn", BOOL, 1, &[0])),
        ("a motion service",          Right::Move,          on(Mnemonic::Mclm, 1, &line("Ctl", &[1.0, 1.0, 0.0]))),
        ("an override",               Right::Override,      write("FeedOverride[0]", REAL, 1, &half)),
        ("an override above 100 %",   Right::OverrideAbove, write("FeedOverride[0]", REAL, 1, &double)),
        ("the same in parts",         Right::OverrideAbove, fragment(path("FeedOverride[0]"), 0xCA, &double)),
        ("the same, by its object",   Right::OverrideAbove, set(FEED_OVERRIDE.0, FEED_OVERRIDE.1, &double)),
        ("a fault",                   Right::InjectFaults,  write("FaultInject[0]", DINT, 1, &[0; 4])),
        ("a new tag",                 Right::ChangeTags,    create_tag("Fresh")),
    ];
    requests
}

/// The rights that the matrix of EtherNet/IP judges.
pub(crate) fn rights() -> Vec<Right> {
    let objects = Objects::ALL.0.iter();
    let services = objects.flat_map(|object| object.services()).map(|own| own.right);
    let sets = SETTABLE.into_iter().map(|(_, _, right)| right);
    let tags = tags().into_iter().map(|(_, right, _)| right);
    services.chain(sets).chain(tags).collect()
}

/// Whether a reply refuses the client for its role: for the request, for an attribute of its list, or for the first move of its series.
fn is_refused(request: &Request, reply: &Reply) -> bool {
    if request.path.is_object(machine::CLASS, 1) && request.service == machine::service::EXECUTE_SERIES {
        let failed = SeriesReply::decode(&reply.data).and_then(|reply| reply.failed);
        return failed.is_some_and(|failed| codes(failed.status).0 == PRIVILEGE);
    }
    let is_list = reply.status.is(CipStatus::ATTRIBUTE_LIST_ERROR);
    match reply.data.get(4..6) {
        Some(status) if is_list => status == [PRIVILEGE, 0],
        _ => codes(reply.status).0 == PRIVILEGE,
    }
}

impl Client {
    /// Asks in every way that there is: alone, in a packet between two reads, inside of Unconnected Send, and over a connection.
    async fn ask_in_every_way(&mut self, connected: &mut Connected, why: &str, request: &Request) -> [bool; 4] {
        let alone = is_refused(request, &self.ask(request).await);
        let around = [read("aDint", 1), request.clone(), read("aDint", 1)];
        let packet = Request::new(
            service::MULTIPLE_SERVICE_PACKET,
            Epath::object(2, 1),
            join_multiple(&around).expect("short"),
        );
        let reply = self.ask(&packet).await;
        let replies = arcline_proto::cip::split_multiple_replies(&reply.data).expect("replies");
        let statuses: Vec<u8> = replies.iter().map(|reply| codes(reply.status).0).collect();
        // A long answer leaves no room for the second read.
        let is_around = statuses[0] == 0 && [0, 6, 0x11].contains(&statuses[2]);
        assert!(is_around, "{why}: the reads around it: {statuses:?}");
        let packed = is_refused(request, &replies[1]);
        let send = UnconnectedSend {
            time: TickTime::DEFAULT,
            message: request.to_bytes().expect("short"),
            route: Epath(vec![]),
        };
        let data = send.to_bytes().expect("short");
        let send = Request::new(service::UNCONNECTED_SEND, Epath::object(6, 1), data);
        let sent = is_refused(request, &self.ask(&send).await);
        let over = is_refused(request, &self.ask_connected(connected, request).await);
        [alone, packed, sent, over]
    }
}

/// Attributes that can be set, with their widths: an empty value is too short for them, and for no other attribute.
async fn settable(bench: &Bench) -> BTreeMap<(u16, u16), usize> {
    // A viewer finds the widths and changes nothing.
    let mut viewer = bench.client_as(Role::Viewer).await;
    let mut found = BTreeMap::new();
    for object in Objects::ALL.0 {
        let class = object.class();
        for attribute in 1..=0xFF {
            let made = Made { trace: 1, symbol: 1 };
            let path = Epath::attribute(class, instance_of(class, made), attribute);
            for width in 0..=64 {
                let request = Request::new(service::SET_ATTRIBUTE_SINGLE, path.clone(), vec![0; width]);
                match viewer.ask(&request).await.status.general() {
                    0x13 => {}
                    PRIVILEGE => {
                        found.insert((class, attribute), width);
                        break;
                    }
                    _ => break,
                }
            }
        }
    }
    found
}

/// Every service of every object, every attribute that can be set, every instruction, and every service of tags: for every role.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_request_for_every_role() {
    let bench = super::io::bench(IoLoss::Hold);
    let widths = settable(&bench).await;
    let known: Vec<(u16, u16)> = widths.keys().copied().collect();
    let mut listed = SETTABLE.map(|(class, attribute, _)| (class, attribute));
    listed.sort_unstable();
    assert_eq!(known, listed, "the attributes that can be set are those of SETTABLE");
    let mut checked = 0;
    for role in Role::ALL {
        let mut client = bench.client_as(role).await;
        let mut connected = client.open(500, 7).await;
        let mut maker = bench.client_as(Role::Engineer).await;
        let trace = maker.create(config(0, 10, 1, &[0], &["X.CommandPosition"])).await;
        let tags = tags()
            .into_iter()
            .map(|(why, right, request)| (why.to_owned(), Some(right), request));
        let passing = format!("Passing_{}", role.word());
        assert!(maker.ask(&create_tag(&passing)).await.status.is_success());
        let symbol = bench
            .device
            .plant
            .with_image(|image| image.find(&passing).map(|tag| tag.id.0));
        let symbol = symbol.expect("it was made");
        let all = services(Made { trace, symbol })
            .into_iter()
            .chain(sets(&widths))
            .chain(tags);
        for (why, right, request) in all {
            let expected = right.is_none_or(|right| !right.is_of(role));
            let found = client.ask_in_every_way(&mut connected, &why, &request).await;
            assert_eq!(found, [expected; 4], "{why} as {}", role.word());
            checked += 1;
        }
        // The exclusive owner; without the right nothing is opened.
        let (reply, _) = client.open_io(&open(9, OUTPUT), 50_000).await;
        let is_of = Right::OwnOutputs.is_of(role);
        assert_eq!(
            codes(reply.status).0,
            if is_of { 0 } else { PRIVILEGE },
            "as {}",
            role.word()
        );
        assert_eq!(client.close_io(9).await.is_success(), is_of);
        // Every role may read the inputs.
        let (reply, _) = client.open_io(&open(10, INPUT_ONLY), 50_000).await;
        assert!(reply.status.is_success(), "{} as {}", reply.status, role.word());
        assert!(client.close_io(10).await.is_success());
        assert_eq!(client.read("aDint").await.data.len(), 4, "the connection lives");
    }
    assert!(checked > 4 * 200, "{checked} rows");
    assert!(
        bench.device.plant.with_image(|image| image.find("Fresh").is_some()),
        "an engineer made it"
    );
}

/// A request that no role may make has the same refusal for every role: clients identify the server by such a request.
#[tokio::test]
async fn missing_objects_have_the_same_status_for_every_role() {
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
