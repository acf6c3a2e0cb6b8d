//! Reading and writing tags.

use arcline_proto::cip::{Request, join_multiple, service, split_multiple_replies};
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::logix::ReadModifyWrite;
use arcline_tag::{Elementary, STRING_HANDLE};

use super::*;

const DINT: WireType = WireType::Atomic(0xC4);
const BOOL: WireType = WireType::Atomic(0xC1);
const REAL: WireType = WireType::Atomic(0xCA);
const STRING: WireType = WireType::Structure(STRING_HANDLE);

fn string(length: i32, text: &[u8]) -> Vec<u8> {
    let mut bytes = length.to_le_bytes().to_vec();
    bytes.extend(text);
    bytes.resize(88, 0);
    bytes
}

#[tokio::test]
async fn every_type_reads_back_its_written_value() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    #[rustfmt::skip]
    let cases: [(&str, WireType, Vec<u8>); 12] = [
        ("aBool",   Elementary::Bool.into(),  vec![1]),
        ("aSint",   Elementary::Sint.into(),  vec![0x85]),
        ("aInt",    Elementary::Int.into(),   vec![1, 0x82]),
        ("aDint",   DINT,                     vec![1, 2, 3, 0x84]),
        ("aLint",   Elementary::Lint.into(),  vec![1, 2, 3, 4, 5, 6, 7, 0x88]),
        ("aUsint",  Elementary::Usint.into(), vec![200]),
        ("aUint",   Elementary::Uint.into(),  vec![1, 200]),
        ("aUdint",  Elementary::Udint.into(), vec![1, 2, 3, 200]),
        ("aReal",   REAL,                     1.5_f32.to_le_bytes().to_vec()),
        ("aLreal",  Elementary::Lreal.into(), 1.5_f64.to_le_bytes().to_vec()),
        ("aString", STRING,                   string(5, b"Hello")),
        ("aStRiNg", STRING,                   string(2, b"Hi")),
    ];
    for (tag, data_type, bytes) in cases {
        // Stock clients send surplus bytes behind a value.
        let surplus: Vec<u8> = bytes.iter().chain(&[9, 9, 9]).copied().collect();
        assert_eq!(
            client.write(tag, data_type, &surplus).await,
            CipStatus::SUCCESS,
            "{tag}"
        );
        let value = client.read(tag).await;
        assert_eq!((value.data_type, &value.data[..]), (data_type, &bytes[..]), "{tag}");
    }
    assert!(client.write("aBool", BOOL, &[0xFF]).await.is_success());
    assert_eq!(&client.read("aBool").await.data[..], [1], "any byte but 0 is true");
    assert!(client.write("aString", STRING, &string(1000, b"x")).await.is_success());
    assert_eq!(
        client.read("aString").await.data[..4],
        82_i32.to_le_bytes(),
        "no text is longer than its room"
    );
}

#[tokio::test]
async fn refusals_tell_why_and_change_nothing() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let by_instance = |instance, data: &[u8]| {
        Request::new(
            service::READ_TAG,
            Epath::object(0x6B, instance),
            Bytes::copy_from_slice(data),
        )
    };
    let dotted = Epath(vec![Segment::Symbol("Move1.Position[2]".into())]);
    #[rustfmt::skip]
    let cases: Vec<(&str, Request, (u8, u16))> = vec![
        ("unknown tag",            read("NoTag", 1),                                (0x05, 0)),
        ("unknown member",         read("Move1.Nothing", 1),                        (0x05, 0)),
        ("member of a number",     read("aDint.X", 1),                              (0x05, 0)),
        ("unknown program",        read("Program:Main.X", 1),                       (0x05, 0)),
        ("unknown instance",       by_instance(9999, &[1, 0]),                      (0x05, 0)),
        ("index beyond",           read("Dints[3000]", 1),                          (0xFF, 0x2105)),
        ("elements beyond",        read("Dints[2999]", 2),                          (0xFF, 0x2105)),
        ("no elements",            read("Dints", 0),                                (0xFF, 0x2105)),
        ("two of one",             read("aDint", 2),                                (0xFF, 0x2105)),
        ("no count",               Request::new(service::READ_TAG, path("aDint"), Bytes::new()), (0x13, 0)),
        ("another type",           write("aDint", REAL, 1, &[0; 4]),                (0xFF, 0x2107)),
        ("another handle",         write("aString", WireType::Structure(7), 1, &[0; 88]), (0xFF, 0x2107)),
        ("too few bytes",          write("aDint", DINT, 1, &[0; 3]),                (0x13, 0)),
        ("too few bytes of two",   write("Dints", DINT, 2, &[0; 7]),                (0x13, 0)),
        ("elements beyond, write", write("Dints[2999]", DINT, 2, &[0; 8]),          (0xFF, 0x2105)),
        ("status of an axis",      write("X.ActualPosition", REAL, 1, &[0; 4]),     (0x0F, 0)),
        ("status of a system",     write("CS1.CoordinateMotionStatus", DINT, 1, &[0; 4]), (0x0F, 0)),
        ("EnableOut",              write("Move1.EnableOut", BOOL, 1, &[1]),         (0x0F, 0)),
        ("motion control",         write("Move1.MotionControl.ERR", Elementary::Int.into(), 1, &[1, 0]), (0x0F, 0)),
        ("no tag service",         Request::new(0x4F, path("aDint"), Bytes::new()), (0x08, 0)),
        ("no path",                Request::new(service::READ_TAG, Epath::default(), vec![1, 0]), (0x05, 0)),
        ("a dotted name",          Request::new(service::READ_TAG, dotted, vec![1, 0]), (0, 0)),
    ];
    let before = client.device_bytes(&bench);
    for (why, request, expected) in cases {
        assert_eq!(codes(client.ask(&request).await.status), expected, "{why}");
    }
    assert_eq!(client.device_bytes(&bench), before, "nothing was written");
}

impl Client {
    /// The bytes of the tags that the refusals aim at.
    fn device_bytes(&self, bench: &Bench) -> Vec<Vec<u8>> {
        bench.device.plant.with_image(|image| {
            let bytes = |name| image.find(name).map(|tag| image.bytes(tag.id).to_vec()).expect("a tag");
            ["aDint", "aString", "Dints", "Move1"].into_iter().map(bytes).collect()
        })
    }
}

#[tokio::test]
async fn tags_are_addressed_by_instance_element_and_member() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let (dints, move1) = bench.device.plant.with_image(|image| {
        let id = |name| image.find(name).expect("a tag").id.0;
        (id("Dints"), id("Move1"))
    });
    assert!(client.write("Dints[7]", DINT, &77_i32.to_le_bytes()).await.is_success());
    let mut element = Epath::object(0x6B, dints);
    element.0.push(Segment::Member(7));
    let reply = client.ask(&Request::new(service::READ_TAG, element, vec![1, 0])).await;
    assert_eq!(&reply.data[2..], 77_i32.to_le_bytes());
    assert!(
        client
            .write("move1.position[2]", REAL, &5_f32.to_le_bytes())
            .await
            .is_success()
    );
    let mut member = Epath::object(0x6B, move1);
    member
        .0
        .extend([Segment::Symbol("POSITION".into()), Segment::Member(2)]);
    let reply = client.ask(&Request::new(service::READ_TAG, member, vec![1, 0])).await;
    assert_eq!(&reply.data[2..], 5_f32.to_le_bytes());
    let reply = client.ask(&read("Move1.Position[1]", 8)).await;
    assert_eq!(reply.data.len(), 2 + 32, "from an element to the end");
}

#[tokio::test]
async fn large_arrays_travel_in_fragments_both_ways() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(500, 1).await;
    let all: Vec<u8> = (0..3000_i32).flat_map(i32::to_le_bytes).collect();
    for offset in (0..all.len()).step_by(400) {
        let part = &all[offset..all.len().min(offset + 400)];
        let write = WriteTag {
            data_type: DINT,
            elements: 3000,
            offset: offset as u32,
            data: Bytes::copy_from_slice(part),
        };
        let request = Request::new(
            service::WRITE_TAG_FRAGMENTED,
            path("Dints"),
            write.to_bytes_fragmented(),
        );
        assert!(
            client.ask_connected(&mut connected, &request).await.status.is_success(),
            "offset {offset}"
        );
    }
    let mut got = Vec::<u8>::new();
    loop {
        let read = ReadTag {
            elements: 3000,
            offset: got.len() as u32,
        };
        let request = Request::new(service::READ_TAG_FRAGMENTED, path("Dints"), read.to_bytes_fragmented());
        let reply = client.ask_connected(&mut connected, &request).await;
        assert!(reply.len() <= 498, "the reply fits the connection");
        got.extend(&ReadReply::decode(&reply.data).expect("a fragment").data[..]);
        match reply.status.general() {
            0x06 => {}
            0x00 => break,
            other => panic!("status 0x{other:02X} at {}", got.len()),
        }
    }
    assert_eq!(got, all);
    let beyond = ReadTag {
        elements: 3000,
        offset: 12_000,
    };
    let request = Request::new(
        service::READ_TAG_FRAGMENTED,
        path("Dints"),
        beyond.to_bytes_fragmented(),
    );
    assert_eq!(codes(client.ask(&request).await.status), (0xFF, 0x2104));
}

#[tokio::test]
async fn masks_change_bits_of_integers_only() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let modify =
        |tag: &str, masks: ReadModifyWrite| Request::new(service::READ_MODIFY_WRITE_TAG, path(tag), masks.to_bytes());
    #[rustfmt::skip]
    let cases = [
        ("set a bit",            "aDint",   ReadModifyWrite::bit(4, 5, true),  (0, 0)),
        ("set another",          "aDint",   ReadModifyWrite::bit(4, 31, true), (0, 0)),
        ("clear one",            "aDint",   ReadModifyWrite::bit(4, 5, false), (0, 0)),
        ("a BOOL array's word",  "Bools[1]", ReadModifyWrite::bit(4, 8, true), (0, 0)),
        ("another size",         "aDint",   ReadModifyWrite::bit(2, 5, true),  (0x03, 0)),
        ("no integer",           "aReal",   ReadModifyWrite::bit(4, 5, true),  (0xFF, 0x2107)),
        ("a BOOL member",        "Move1.EnableIn", ReadModifyWrite::bit(1, 0, true), (0xFF, 0x2107)),
        ("read-only",            "X.AxisStatus", ReadModifyWrite::bit(4, 0, true), (0x0F, 0)),
    ];
    for (why, tag, masks, expected) in cases {
        assert_eq!(codes(client.ask(&modify(tag, masks)).await.status), expected, "{why}");
    }
    assert_eq!(&client.read("aDint").await.data[..], [0, 0, 0, 0x80]);
    assert_eq!(&client.read("Bools[1]").await.data[..], [0, 1, 0, 0]);
}

#[tokio::test]
async fn a_packet_answers_each_of_its_requests_within_the_connection() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(500, 1).await;
    let packet = |requests: &[Request]| {
        let data = join_multiple(requests).expect("short paths");
        Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data)
    };
    let nested = packet(&[read("aDint", 1)]);
    let requests = [
        write("aDint", DINT, 1, &5_i32.to_le_bytes()),
        read("aDint", 1),
        read("NoTag", 1),
        nested,
        read("Dints", 100),
        read("Dints", 100),
        read("aDint", 1),
    ];
    let reply = client.ask_connected(&mut connected, &packet(&requests)).await;
    assert_eq!(reply.status.general(), 0x1E);
    assert!(reply.len() <= 498, "the reply fits the connection");
    let replies = split_multiple_replies(&reply.data).expect("replies");
    let general: Vec<u8> = replies.iter().map(|reply| reply.status.general()).collect();
    assert_eq!(
        general,
        [0, 0, 0x05, 0x08, 0, 0x06, 0x06],
        "what does not fit is cut in its place"
    );
    assert!(
        replies[6].data.is_empty(),
        "libplctag asks again for what a packet has no room for at all"
    );
    assert_eq!(
        &replies[1].data[2..],
        5_i32.to_le_bytes(),
        "requests act in their order"
    );
    assert!(
        client
            .ask_connected(&mut connected, &packet(&[]))
            .await
            .status
            .is_success(),
        "an empty packet"
    );
    // As many as the largest connection holds of the shortest, 12 bytes each with its offset.
    let mut largest = client.open(4002, 2).await;
    let shortest = Request::new(service::READ_TAG, path("aInt"), vec![1, 0]);
    let many = packet(&vec![shortest; 330]);
    let reply = client.ask_connected(&mut largest, &many).await;
    let replies = split_multiple_replies(&reply.data).expect("replies");
    assert_eq!((reply.status.general(), replies.len()), (0, 330));
}

#[tokio::test]
async fn bits_in_a_dotted_name_are_booleans() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let bit = Epath(vec![Segment::Symbol("aDint.4".into())]);
    let set = WriteTag {
        data_type: BOOL,
        elements: 1,
        offset: 0,
        data: Bytes::from_static(&[1]),
    };
    assert!(
        client
            .ask(&Request::new(service::WRITE_TAG, bit.clone(), set.to_bytes()))
            .await
            .status
            .is_success()
    );
    assert_eq!(&client.read("aDint").await.data[..], [16, 0, 0, 0]);
    assert_eq!(
        &client.ask(&Request::new(service::READ_TAG, bit, vec![1, 0])).await.data[..],
        [0xC1, 0, 1]
    );
}

#[tokio::test]
async fn a_write_that_cannot_be_kept_is_not_acknowledged() {
    let plant = crate::retained::tests::plant_that_cannot_keep(&project());
    let bench = Bench::of(plant, settings_of("Bench"));
    let mut client = bench.client().await;
    let number = 7_i32.to_le_bytes();
    assert_eq!(client.write("aDint", DINT, &number).await, CipStatus::STORE_FAILURE);
    assert_eq!(
        client.write("Move1.MoveType", DINT, &number).await,
        CipStatus::SUCCESS,
        "never kept"
    );
    assert_eq!(
        client.write("X.ActualPosition", REAL, &number).await,
        CipStatus::PRIVILEGE_VIOLATION
    );
    let requests = [
        write("aDint", DINT, 1, &number),
        read("aDint", 1),
        write("Nothing", DINT, 1, &number),
    ];
    let data = join_multiple(&requests).expect("short paths");
    let packet = Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data);
    let reply = client.ask(&packet).await;
    let replies = split_multiple_replies(&reply.data).expect("replies");
    let general: Vec<u8> = replies.iter().map(|reply| reply.status.general()).collect();
    assert_eq!(general, [0x19, 0, 0x05], "what is read is not kept");
}
