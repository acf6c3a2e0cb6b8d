//! The hex blocks of spec/ethernet-ip.md, read aloud; each also cut at every byte.

#![allow(clippy::unwrap_used)]

use arcline_proto::cip::{self, CipStatus, Reply, Request};
use arcline_proto::connection::{ConnectionKey, ForwardClose, ForwardOpen, ForwardOpenReply, UnconnectedSend};
use arcline_proto::cpf::{ConnectionId, Item, Packet, decode_items, encode_items};
use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, Header, RegisterSession, Service, SessionHandle};
use arcline_proto::epath::{Epath, Segment, Target};
use arcline_proto::identity::Identity;
use arcline_proto::logix::{
    ReadModifyWrite, ReadReply, ReadTag, ReadTemplate, Symbol, TemplateAttributes, Typed, TypedError, WireType,
    WriteTag, decode_operands, encode_operands,
};
use arcline_tag::{Elementary, PathSegment, Value};
use bytes::{Bytes, BytesMut};

/// Bytes of hex text; blanks and bars are for the reader.
fn hex(text: &str) -> Bytes {
    let digits: Vec<u8> = text
        .chars()
        .filter_map(|c| c.to_digit(16))
        .map(|digit| u8::try_from(digit).unwrap())
        .collect();
    assert_eq!(digits.len() % 2, 0, "{text}");
    digits.chunks(2).map(|pair| pair[0] << 4 | pair[1]).collect()
}

/// Decodes every prefix too: none may panic.
fn request(text: &str) -> Request {
    let bytes = hex(text);
    for end in 0..bytes.len() {
        if let Ok(request) = Request::decode(&bytes.slice(..end)) {
            exercise(&request);
        }
    }
    let request = Request::decode(&bytes).unwrap();
    assert_eq!(request.to_bytes().unwrap(), bytes, "{text}");
    request
}

fn reply(text: &str) -> Reply {
    let bytes = hex(text);
    for end in 0..bytes.len() {
        let _ = Reply::decode(&bytes.slice(..end));
    }
    let reply = Reply::decode(&bytes).unwrap();
    assert_eq!(reply.to_bytes(), bytes, "{text}");
    reply
}

/// Every decoder over a request's data.
fn exercise(request: &Request) {
    let data = &request.data;
    let _ = Target::new(&request.path);
    let _ = (
        ReadTag::decode(data),
        ReadTag::decode_fragmented(data),
        WriteTag::decode(data),
    );
    let _ = (
        WriteTag::decode_fragmented(data),
        ReadModifyWrite::decode(data),
        ReadTemplate::decode(data),
    );
    let _ = (
        cip::decode_attribute_ids(data),
        cip::split_multiple(data),
        UnconnectedSend::decode(data),
    );
    let _ = (
        ForwardOpen::decode(data, true),
        ForwardOpen::decode(data, false),
        ForwardClose::decode(data),
    );
    let _ = decode_operands(data);
}

#[test]
fn register_session() {
    // RegisterSession, 4 bytes, no session, context "_pycomm_", version 1, options 0.
    let bytes = hex("6500 0400 00000000 00000000 5f7079636f6d6d5f 00000000 | 0100 0000");
    let decoder = FrameDecoder::default();
    for end in 0..bytes.len() {
        let mut buf = BytesMut::from(&bytes[..end]);
        assert_eq!(decoder.decode(&mut buf), Ok(None), "cut at {end}");
        assert_eq!(buf.len(), end, "nothing is taken");
    }
    let frame = decoder.decode(&mut BytesMut::from(&bytes[..])).unwrap().unwrap();
    assert_eq!(frame.header.command, Command::REGISTER_SESSION);
    assert_eq!(&frame.header.context, b"_pycomm_");
    assert_eq!(RegisterSession::decode(&frame.data), Some(RegisterSession::CURRENT));
    // The reply: the same with the new handle.
    let header = Header {
        session: SessionHandle(0x5846_3f9d),
        ..frame.header
    };
    let expected = hex("6500 0400 9d3f4658 00000000 5f7079636f6d6d5f 00000000 | 0100 0000");
    assert_eq!(
        EncapFrame::reply(&header, RegisterSession::CURRENT.to_bytes()).to_bytes(),
        expected
    );
}

#[test]
fn list_services() {
    // One item 0x0100 of 20 bytes: version 1, capability 0x0120, "Communications" with two zeros.
    let data = hex("0100 0001 1400 0100 2001 436f6d6d756e69636174696f6e73 0000");
    for end in 0..data.len() {
        assert!(decode_items(&data.slice(..end)).is_err(), "cut at {end}");
    }
    let items = decode_items(&data).unwrap();
    let [Item::Services(service)] = items.as_slice() else {
        panic!("{items:?}")
    };
    assert_eq!(
        Service::decode(service),
        Some(Service::communications(Service::TCP | Service::UDP_IO))
    );
    let mut out = BytesMut::new();
    encode_items(&items, &mut out);
    assert_eq!(out, data);
}

#[test]
fn list_identity() {
    // Address 127.0.0.1:44818, vendor 0x1337, type 0x0E, product 0x55, revision 33.11, status 0x3060, state 3.
    let data = hex("0100 0c00 2c00 | 0100 | 0002 af12 7f000001 0000000000000000 |
         3713 0e00 5500 210b 6030 01eeffc0 0a 5265664c6f6769782f41 03");
    // The specification prints the port as af32, but 44818 is af12; only the length of the item is checked otherwise.
    let items = decode_items(&data).unwrap();
    let [Item::Identity(item)] = items.as_slice() else {
        panic!("{items:?}")
    };
    for end in 0..item.len() {
        assert_eq!(Identity::decode_item(&item[..end]), None, "cut at {end}");
    }
    let (address, identity) = Identity::decode_item(item).unwrap();
    assert_eq!(address.to_string(), "127.0.0.1:44818");
    assert_eq!(
        (identity.vendor, identity.major, identity.minor, identity.name()),
        (0x1337, 33, 11, "RefLogix/A")
    );
    assert_eq!(identity.list_identity(address), data);
}

#[test]
fn write_with_the_request_repeated_behind_it() {
    // Speed := 2.5 by instance 0x12 of class 0x6B; then 2 bytes sequence and the whole request again.
    let request = request("4d 02 206b 2412 | ca00 0100 00002040 | 2c00 4d02206b2412ca00010000002040");
    assert_eq!(request.path, Epath::object(0x6B, 0x12));
    let write = WriteTag::decode(&request.data).unwrap();
    assert_eq!((write.data_type, write.elements), (WireType::from(Elementary::Real), 1));
    assert_eq!(Value::read(Elementary::Real, &write.data[..4]), Some(Value::Real(2.5)));
    assert!(write.data.len() > 4, "surplus is kept apart, not refused");
    assert_eq!(reply("cd 00 00 00"), Reply::success(0x4D, Bytes::new()));
}

#[test]
fn unknown_tag() {
    // Read "NoTag", one element; 0x05 with one additional word 0.
    let request = request("4c 04 9105 4e6f546167 00 | 0100");
    assert_eq!(Target::new(&request.path).unwrap().first_symbol(), Some("NoTag"));
    assert_eq!(
        reply("cc 00 05 01 0000").status,
        CipStatus::PATH_DESTINATION_UNKNOWN.with(0)
    );
}

#[test]
fn unconnected_send() {
    // Get Attributes All of the Identity through slot 0.
    let request = request("52 02 2006 2401 | 0a 05 | 0600 | 01 02 2001 2401 | 01 00 | 0100");
    let send = UnconnectedSend::decode(&request.data).unwrap();
    assert_eq!(send.time.duration().as_millis(), 5120);
    let inner = Request::decode(&send.message).unwrap();
    assert_eq!((inner.service, inner.path), (1, Epath::object(1, 1)));
    assert!(matches!(send.route.0.as_slice(), [Segment::Port(port)] if port.backplane_slot() == Some(0)));
    assert_eq!(send.to_bytes().unwrap(), request.data);
    let all = reply("81 00 00 00 | 3713 0e00 5500 210b 6030 01eeffc0 0a 5265664c6f6769782f41");
    let identity = Identity::decode_all(&all.data).unwrap();
    assert_eq!(identity.attributes_all(), all.data);
}

#[test]
fn large_forward_open() {
    // RPI 2.113 s, point-to-point, variable, 4000 bytes, class 3, path slot 0 / Message Router 1.
    let request = request(
        "5b 02 2006 2401 | 0a 05 | 00000000 | ff6f035d | 2704 | 0910 | 15190b8e | 07 000000 |
         01402000 | a00f0042 | 01402000 | a00f0042 | a3 | 03 | 0100 2002 2401",
    );
    for end in 0..request.data.len() {
        assert!(
            ForwardOpen::decode(&request.data.slice(..end), true).is_err(),
            "cut at {end}"
        );
    }
    let open = ForwardOpen::decode(&request.data, true).unwrap();
    let key = ConnectionKey {
        serial: 0x0427,
        vendor: 0x1009,
        originator: 0x8e0b_1915,
    };
    assert_eq!(
        (open.key, open.t_to_o_id, open.multiplier),
        (key, ConnectionId(0x5d03_6fff), 7)
    );
    assert_eq!(
        (open.o_to_t.size, open.o_to_t.variable, open.transport_class()),
        (4000, true, 3)
    );
    assert_eq!(open.to_bytes(true).unwrap(), request.data);
    let opened = reply("db 00 00 00 | 35e2034e | ff6f035d | 2704 | 0910 | 15190b8e | 01402000 | 01402000 | 00 00");
    let decoded = ForwardOpenReply::decode(&opened.data).unwrap();
    assert_eq!(
        (decoded.o_to_t_id, decoded.o_to_t_api),
        (ConnectionId(0x4e03_e235), 2_113_537)
    );
    assert_eq!(decoded.to_bytes(), opened.data);
}

#[test]
fn forward_close() {
    let request = request("4e 02 2006 2401 | 0a 05 | 2704 | 0910 | 15190b8e | 03 00 | 0100 2002 2401");
    let close = ForwardClose::decode(&request.data).unwrap();
    assert_eq!(close.to_bytes().unwrap(), request.data);
    assert_eq!(
        ForwardClose::reply(close.key),
        reply("ce 00 00 00 | 2704 0910 15190b8e 00 00")
    );
}

#[test]
fn connected_read() {
    // SendUnitData: O→T id, sequence 16, Read Tag of symbol instance 0x11, element 3, one element.
    let bytes = hex(
        "7000 2000 9d3f4658 00000000 5f7079636f6d6d5f 00000000 | 00000000 0a00 0200 | a100 0400 35e2034e |
         b100 0c00 | 1000 | 4c 03 206b 2411 2803 | 0100",
    );
    let frame = FrameDecoder::default()
        .decode(&mut BytesMut::from(&bytes[..]))
        .unwrap()
        .unwrap();
    for end in 0..frame.data.len() {
        assert!(Packet::decode(&frame.data.slice(..end)).is_err(), "cut at {end}");
    }
    let (id, sequence, message) = Packet::decode(&frame.data).unwrap().connected_message().unwrap();
    assert_eq!((id, sequence), (ConnectionId(0x4e03_e235), 16));
    let request = Request::decode(&message).unwrap();
    let target = Target::new(&request.path).unwrap();
    assert_eq!((target.class, target.instance), (Some(0x6B), Some(0x11)));
    assert_eq!(target.members, [PathSegment::Element(3)]);
    let read = reply("cc 00 00 00 | c400 67000000");
    let read = ReadReply::decode(&read.data).unwrap();
    assert_eq!(Value::read(Elementary::Dint, &read.data), Some(Value::Dint(103)));
}

#[test]
fn fragmented_read() {
    // 3000 DINTs from byte 3992; the reply is partial.
    let request = request("52 02 206b 2430 | b80b | 980f0000");
    let read = ReadTag::decode_fragmented(&request.data).unwrap();
    assert_eq!((read.elements, read.offset), (3000, 3992));
    let all: Vec<u8> = (0..3000_u32).flat_map(u32::to_le_bytes).collect();
    let reply = read.reply(0x52, WireType::from(Elementary::Dint), 4, &all, 3998);
    assert_eq!(
        &reply.to_bytes()[..10],
        &hex("d200 0600 c400 e6030000")[..],
        "begins with element 998"
    );
    assert_eq!(reply.data.len() - 2, 3992, "whole elements only");
}

#[test]
fn read_modify_write() {
    // W.5 := 1; the AND mask is 8 bytes for a 4-byte mask.
    let long = request("4e 02 206b 2433 | 0400 | 20000000 | ffffffff ffffffff");
    let short = request("4e 02 9101 5700 | 0400 | 20000000 | ffffffff");
    let masks = ReadModifyWrite::decode(&long.data).unwrap();
    assert_eq!(masks, ReadModifyWrite::decode(&short.data).unwrap());
    let mut word = [1, 0, 0, 0];
    masks.apply(&mut word).unwrap();
    assert_eq!(word, [0x21, 0, 0, 0]);
    assert_eq!(masks.apply(&mut [0, 0]), Err(CipStatus::INVALID_PARAMETER_VALUE));
    assert_eq!(
        ReadModifyWrite::decode(&hex("0300 000000 000000")),
        Err(CipStatus::INVALID_PARAMETER_VALUE)
    );
}

#[test]
fn multiple_service_packet() {
    // Two reads back to back: "TestDINT"[0] four elements, "Speed" one.
    let request = request(
        "0a 02 2002 2401 | 0200 | 0600 | 1600 | 4c 06 9108 54657374 44494e54 2800 0400 | 4c 04 9105 5370656564 00 0100",
    );
    let inner: Vec<Request> = cip::split_multiple(&request.data)
        .unwrap()
        .into_iter()
        .map(Result::unwrap)
        .collect();
    assert_eq!(
        Target::new(&inner[0].path).unwrap().tag_path().unwrap().to_string(),
        "TestDINT[0]"
    );
    assert_eq!(cip::join_multiple(&inner).unwrap(), request.data);
    let expected = reply(
        "8a 00 00 00 | 0200 | 0600 | 1c00 | cc 00 00 00 c400 64000000 65000000 66000000 37000000 | cc 00 00 00 ca00 0000803f",
    );
    let parts = cip::split_multiple_replies(&expected.data).unwrap();
    let mut replies = cip::MultipleReplies::new(2, 504).unwrap();
    parts.iter().for_each(|part| replies.push(part));
    assert_eq!(replies.finish(), expected);
}

#[test]
fn browse() {
    // Seven attributes from the beginning; the reply is partial.
    let ids = [1, 2, 3, 5, 6, 8, 10];
    let asked = request("55 02 206b 2400 | 0700 | 0100 0200 0300 0500 0600 0800 0a00");
    assert_eq!(cip::decode_attribute_ids(&asked.data).unwrap(), ids);
    let bytes = hex(
        "05000000 | 0800 5f5f537973546167 | c410 | 05100000 | 05200000 | 00000004 | 00000000 00000000 00000000 | 00",
    );
    for end in 1..bytes.len() {
        assert_eq!(Symbol::decode_list(&bytes[..end], &ids), None, "cut at {end}");
    }
    let symbols = Symbol::decode_list(&bytes, &ids).unwrap();
    assert_eq!(
        (symbols[0].instance, symbols[0].name.as_str(), symbols[0].symbol_type),
        (5, "__SysTag", 0x10C4)
    );
    let reply = arcline_proto::logix::instance_list_reply(&symbols, 0, &ids, 504);
    assert_eq!((reply.status, &reply.data), (CipStatus::SUCCESS, &bytes));
    assert_eq!(
        arcline_proto::logix::instance_list_reply(&symbols, 6, &ids, 504)
            .data
            .len(),
        0,
        "beyond the last"
    );
    assert_eq!(
        arcline_proto::logix::instance_list_reply(&symbols, 0, &[4], 504)
            .status
            .general(),
        0x14
    );
    // The next page, in the 16-bit form; a program's scope; a request without stride 8-bit instance.
    for (why, text, instance, scope) in [
        ("next page", "55 03 206b 2500 f701 | 0100 0100", 0x1F7, None),
        (
            "program scope",
            "55 0d 9113 50726f6772616d3a4d61696e50726f6772616d 00 206b 2400 | 0100 0100",
            0,
            Some("Program:MainProgram"),
        ),
    ] {
        let request = request(text);
        let target = Target::new(&request.path).unwrap();
        assert_eq!((target.class, target.instance), (Some(0x6B), Some(instance)), "{why}");
        assert_eq!(target.first_symbol(), scope, "{why}");
    }
    // 25 00 0000 is instance 0 in the long form: equal to 24 00.
    let path = Request::decode(&hex("55 03 206b 2500 0000 | 0400 | 0200 0700 0800 0100"))
        .unwrap()
        .path;
    assert_eq!(path, Epath::object(0x6B, 0));
}

#[test]
fn templates() {
    let asked = request("03 03 206c 2500 a201 | 0400 | 0400 0500 0200 0100");
    let ids = cip::decode_attribute_ids(&asked.data).unwrap();
    assert_eq!(ids, TemplateAttributes::IDS);
    let expected =
        reply("83 00 00 00 | 0400 | 0400 0000 2d000000 | 0500 0000 80000000 | 0200 0000 0800 | 0100 0000 8877");
    let attributes = TemplateAttributes::decode(&expected.data).unwrap();
    assert_eq!(
        attributes,
        TemplateAttributes {
            handle: 0x7788,
            members: 8,
            definition_words: 45,
            size: 128
        }
    );
    assert_eq!(attributes.reply(&ids, 504), expected);
    assert_eq!(
        attributes.reply(&[4, 3, 2, 1], 504).data.slice(10..16),
        hex("0300 0000 0000"),
        "attribute 3 exists"
    );
    // 35 bytes of the definition from offset 0: X REAL@0, Y REAL@4, "Vec2;nEAEA".
    let asked = request("4c 03 206c 2500 a101 | 00000000 | 2300");
    let definition =
        hex("0000 ca00 00000000 | 0000 ca00 04000000 | 56656332 3b6e 4541 4541 00 | 5800 | 5900 | 0000000000");
    let read = ReadTemplate::decode(&asked.data).unwrap();
    assert_eq!(
        read.reply(&definition, 504),
        Reply::success(0x4C, definition.slice(..35.min(definition.len())))
    );
    assert_eq!(read.reply(&definition, 20).status, CipStatus::PARTIAL_TRANSFER);
}

#[test]
fn wide_ids_and_attribute_lists() {
    // Class 0x300, instance 300, attribute 300.
    let bytes = hex("2100 0003 2500 2c01 3100 2c01");
    assert_eq!(Epath::decode(&bytes), Ok(Epath::attribute(0x300, 300, 300)));
    assert_eq!(Epath::attribute(0x300, 300, 300).to_bytes(), bytes);
    // M2[1,2]
    let path = Epath::decode(&hex("91024d32 2801 2802")).unwrap();
    let target = Target::new(&path).unwrap();
    assert_eq!(target.tag_path().unwrap().to_string(), "M2[1,2]");
    // The wall clock's setters: two values of 8 and 1 bytes.
    let set = request("04 02 208b 2401 | 0200 | 0600 0102030405060708 0a00 00");
    let mut list = cip::AttributeListReader::new(&set.data).unwrap();
    assert_eq!((list.next_id(), list.value(8).map(<[u8]>::len)), (Some(6), Some(8)));
    assert_eq!(
        (list.next_id(), list.value(1), list.next_id()),
        (Some(10), Some(&[0][..]), None)
    );
    let mut answer = cip::AttributeListReply::new(4);
    answer.push(6, Ok(&[]));
    answer.push(10, Ok(&[]));
    assert_eq!(answer.finish(504), reply("84 00 00 00 | 0200 | 0600 0000 0a00 0000"));
}

#[test]
fn class_1_forward_open_and_datagram() {
    // O→T 38 bytes, T→O 34, RPI 100 ms, assemblies 0x97, 0x96, 0x64.
    let request = request(
        "54 02 2006 2401 | 0a 0e | 00000000 | 01000100 | 7700 | 3713 | 44332211 | 00 000000 |
         a0860100 | 2648 | a0860100 | 2248 | 01 | 04 | 2004 2497 2c96 2c64",
    );
    let open = ForwardOpen::decode(&request.data, false).unwrap();
    assert_eq!((open.o_to_t.size, open.t_to_o.size, open.o_to_t_rpi), (38, 34, 100_000));
    assert_eq!(
        (open.transport_class(), open.o_to_t.variable, open.o_to_t.priority),
        (1, false, 2)
    );
    assert_eq!(Target::new(&open.path).unwrap().connection_points, [0x96, 0x64]);
    // Reply items: null address, data, 0x8000 with port 2222.
    let items = hex("0300 0000 0000 b200 0400 d4000000 0080 1000 0002 08ae 00000000 0000000000000000");
    assert!(matches!(decode_items(&items).unwrap().as_slice(), [.., Item::SockaddrOToT(at)] if at.port() == 2222));
    // T→O datagram: sequenced address, connected data.
    let items = hex("0200 0280 0800 01000100 01000000 b100 0400 0100 0001");
    let sequenced = Item::SequencedAddress {
        id: ConnectionId(0x0001_0001),
        sequence: 1,
    };
    assert_eq!(
        decode_items(&items).unwrap(),
        [sequenced, Item::ConnectedData(hex("0100 0001"))]
    );
}

#[test]
fn motion_operands() {
    let operands = [
        Typed::ShortString("Move1".into()),
        Typed::Numbers(Elementary::Dint, vec![Value::Dint(0)]),
        Typed::Numbers(Elementary::Real, vec![Value::Real(9.0), Value::Real(0.0)]),
        Typed::ShortString(String::new()),
    ];
    let mut out = BytesMut::new();
    encode_operands(&operands, &mut out);
    // SHORT_STRING × 1 "Move1"; DINT × 1; REAL × 2; SHORT_STRING × 1 "".
    let bytes = hex("da00 0100 05 4d6f766531 | c400 0100 00000000 | ca00 0200 00001041 00000000 | da00 0100 00");
    assert_eq!(out, bytes);
    assert_eq!(decode_operands(&bytes).unwrap(), operands);
    for end in 0..bytes.len() {
        match decode_operands(&bytes[..end]) {
            Ok(whole) => assert!([0, 10, 18, 30].contains(&end) && whole.len() < 4, "cut at {end}"),
            Err(error) => assert_eq!(error.status(), CipStatus::NOT_ENOUGH_DATA, "cut at {end}"),
        }
    }
    for (why, text, status) in [
        ("a structure", "a002 ce0f 0100", CipStatus::INVALID_PARAMETER),
        ("a BOOL", "c100 0100 01", CipStatus::INVALID_PARAMETER),
        (
            "a word beyond 8 bits",
            "c401 0100 00000000",
            CipStatus::INVALID_PARAMETER,
        ),
        ("two names", "da00 0200 00 00", CipStatus::INVALID_PARAMETER),
        (
            "a name that is no text",
            "da00 0100 01 ff",
            CipStatus::INVALID_PARAMETER,
        ),
        ("no elements", "c400 0000", CipStatus::NOT_ENOUGH_DATA),
        ("65535 announced", "c500 ffff 00", CipStatus::NOT_ENOUGH_DATA),
        ("one byte behind", "c400 0100 00000000 00", CipStatus::NOT_ENOUGH_DATA),
    ] {
        assert_eq!(
            decode_operands(&hex(text)).map_err(TypedError::status),
            Err(status),
            "{why}"
        );
    }
    let many: Bytes = (0..65).flat_map(|_| hex("c200 0100 00")).collect();
    assert_eq!(
        decode_operands(&many).map_err(TypedError::status),
        Err(CipStatus::TOO_MUCH_DATA)
    );
}

#[test]
fn paths() {
    #[rustfmt::skip]
    let cases = [
        // why,                          bytes,                                    meaning of the names
        ("a dotted name in one symbol",  "9106 412e425b335d",                      Ok("A.B[3]")),
        ("a plain name",                 "9101 4100 2803 9101 4200",               Ok("A[3].B")),
        ("long element forms",           "9101 4100 2900 0300",                    Ok("A[3]")),
        ("an empty name",                "9100",                                   Err(0x04)),
        ("no text",                      "9102 fffe",                              Err(0x04)),
        ("a bad dotted name",            "9102 2e41",                              Err(0x04)),
        ("a name past the path",         "9105 4141",                              Err(0x04)),
        ("a reserved logical format",    "2300",                                   Err(0x04)),
        ("two classes",                  "2001 2001",                              Err(0x04)),
        ("a class beyond 16 bits",       "2200 00000100 2401",                     Err(0x05)),
        ("an index in front",            "2801",                                   Err(0x04)),
        ("port zero",                    "0000",                                   Err(0x04)),
    ];
    for (why, text, expected) in cases {
        let path = Epath::decode(&hex(text));
        let target = path.as_ref().map_err(|error| *error).and_then(Target::new);
        let name = target.map(|target| target.tag_path().unwrap().to_string());
        assert_eq!(
            name.map_err(|error| error.status().general()),
            expected.map(str::to_owned),
            "{why}"
        );
    }
    // Key, ports of every form, network and data segments survive a round trip.
    let text = "34 04 0100 0e00 5500 21 0b | 01 00 | 12 09 31302e302e302e3500 00 | 0f 1000 03 | 1f 02 1000 4142 | 43 05 | 5102 01020304 | 8001 0102";
    let bytes = hex(text);
    let path = Epath::decode(&bytes).unwrap();
    assert_eq!((path.to_bytes(), path.0.len()), (bytes.clone(), 8));
    for end in 0..bytes.len() {
        let _ = Epath::decode(&bytes.slice(..end));
    }
    let deep: Bytes = (0..33).flat_map(|_| hex("9102 4142")).collect();
    assert!(Target::new(&Epath::decode(&deep).unwrap()).is_err(), "33 names");
    for (why, text, general) in [
        ("path beyond the message", "4c 05 9101 4100", 0x26),
        ("no path size", "4c", 0x13),
        ("nothing", "", 0x13),
        ("a reply", "cc 00 00 00", 0x08),
    ] {
        assert_eq!(
            Request::decode(&hex(text)).map_err(|error| error.status.general()),
            Err(general),
            "{why}"
        );
    }
}
