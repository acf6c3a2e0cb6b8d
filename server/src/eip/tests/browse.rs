//! The tag list, the templates and the attributes of objects.

use arcline_instruction_set::FaultKind;
use arcline_proto::cip::{Request, encode_attribute_ids, service};
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::logix::{Definition, ReadTemplate, Symbol, TemplateAttributes};
use arcline_tag::Elementary;
use bytes::Bytes;

use super::*;

/// Why, request, general and additional status, data if it matters.
type Case = (&'static str, Request, (u8, u16), Option<&'static [u8]>);

fn list(start: u32, attributes: &[u16]) -> Request {
    let data = encode_attribute_ids(attributes);
    Request::new(service::GET_INSTANCE_ATTRIBUTE_LIST, Epath::object(0x6B, start), data)
}

#[tokio::test]
async fn the_tag_list_comes_in_pages_whatever_is_asked() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let names: Vec<String> = bench.device.plant.with_image(|i| {
        let controller = i.tags().iter().filter(|tag| tag.program.is_none());
        controller.map(|tag| tag.name.clone()).collect()
    });
    // pycomm3, pylogix, libplctag, st-ethernet-ip.
    for attributes in [&[1, 2, 3, 5, 6, 8, 10][..], &[1, 2, 8], &[2, 7, 8, 1], &[1, 2]] {
        let (mut got, mut start) = (Vec::new(), 0);
        loop {
            let reply = client.ask(&list(start, attributes)).await;
            assert!(reply.len() <= 504, "the reply is bounded");
            let page = Symbol::decode_list(&reply.data, attributes).expect("symbols");
            start = page.last().expect("a symbol").instance + 1;
            got.extend(page.into_iter().map(|symbol| symbol.name));
            if reply.status.is_success() {
                break;
            }
            assert_eq!(reply.status.general(), 0x06);
        }
        assert_eq!(got, names, "{attributes:?}");
        let beyond = client.ask(&list(start, attributes)).await;
        assert_eq!((beyond.status.general(), beyond.data.len()), (0, 0), "behind the last");
    }
    assert_eq!(
        codes(client.ask(&list(0, &[1, 99])).await.status),
        (0x14, 0),
        "a width nobody knows"
    );
    let mut scoped = list(0, &[1, 2]);
    scoped.path.0.insert(0, Segment::Symbol("Program:Other".into()));
    assert_eq!(codes(client.ask(&scoped).await.status), (0x05, 0), "no such program");
}

#[tokio::test]
async fn every_template_uploads() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(4000, 1).await;
    let templates: Vec<_> = bench
        .device
        .plant
        .with_image(|image| image.templates().cloned().collect());
    assert!(templates.len() > 5, "there is something to upload");
    for template in templates {
        let path = Epath::object(0x6C, template.instance.into());
        // pylogix asks for attribute 3 too.
        let ask = Request::new(
            service::GET_ATTRIBUTE_LIST,
            path.clone(),
            encode_attribute_ids(&[4, 3, 2, 1, 5]),
        );
        let reply = client.ask_connected(&mut connected, &ask).await;
        let attributes = TemplateAttributes::decode(&reply.data).expect("attributes");
        assert_eq!(
            (attributes.handle, attributes.size),
            (template.handle, template.size),
            "{}",
            template.name
        );
        let definition = Definition::of(&template).1.to_bytes();
        let (mut got, wanted) = (Vec::<u8>::new(), 4 * attributes.definition_words as usize - 20);
        while got.len() < wanted {
            let read = ReadTemplate {
                offset: got.len() as u32,
                bytes: (wanted - got.len()) as u16,
            };
            let request = Request::new(service::READ_TAG, path.clone(), read.to_bytes());
            let reply = client.ask_connected(&mut connected, &request).await;
            assert!(
                matches!(reply.status.general(), 0 | 6),
                "{}: {}",
                template.name,
                reply.status
            );
            got.extend(&reply.data[..]);
        }
        assert_eq!(got[..], definition[..wanted], "{}", template.name);
    }
}

#[tokio::test]
async fn objects_answer_for_themselves() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let single = |class, instance, attribute| {
        Request::new(
            service::GET_ATTRIBUTE_SINGLE,
            Epath::attribute(class, instance, attribute),
            Bytes::new(),
        )
    };
    let all = |class, instance| {
        Request::new(
            service::GET_ATTRIBUTES_ALL,
            Epath::object(class, instance),
            Bytes::new(),
        )
    };
    let named = |name| Request::new(service::GET_ATTRIBUTES_ALL, Epath::symbol(name), Bytes::new());
    let of_name = |code, name: &str, attribute| {
        let path = Epath(vec![Segment::Symbol(name.into()), Segment::Attribute(attribute)]);
        Request::new(code, path, vec![1, 0])
    };
    let list_of = |name| {
        let ids = &[2, 0, 1, 0, 2, 0];
        Request::new(service::GET_ATTRIBUTE_LIST, Epath::symbol(name), &ids[..])
    };
    let set = |class, attribute, data: &'static [u8]| {
        Request::new(
            service::SET_ATTRIBUTE_SINGLE,
            Epath::attribute(class, 1, attribute),
            data,
        )
    };
    #[rustfmt::skip]
    let cases: Vec<Case> = vec![
        ("vendor",                    single(0x01, 1, 1),  (0, 0),    Some(&[0xC1, 0xA2])),
        ("no such attribute",         single(0x01, 1, 99), (0x14, 0), None),
        ("no such instance",          single(0x01, 2, 1),  (0x05, 0), None),
        ("no such class",             single(0x99, 1, 1),  (0x05, 0), None),
        ("class revision",            single(0x01, 0, 1),  (0, 0),    Some(&[1, 0])),
        ("the classes there are",     single(0x02, 1, 1),  (0, 0),    None),
        ("program name",              all(0x64, 1),        (0, 0),    Some(b"\x05\0Bench")),
        ("a reset is refused",        Request::new(service::RESET, Epath::object(1, 1), Bytes::new()), (0x0F, 0), None),
        ("not settable",              set(0x01, 1, &[0, 0]), (0x0E, 0), None),
        ("clock, too short",          set(0x8B, 6, &[0; 7]), (0x13, 0), None),
        ("clock, too long",           set(0x8B, 6, &[0; 9]), (0x15, 0), None),
        ("clock with a stray route",  set(0x8B, 6, &[1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0]), (0, 0), None),
        ("where it is reached",       single(0xF5, 1, 5),  (0, 0),    None),
        ("inactivity",                single(0xF5, 1, 13), (0, 0),    Some(&[120, 0])),
        ("link",                      all(0xF6, 1),        (0, 0),    None),
        ("changes",                   all(0xAC, 1),        (0, 0),    None),
        ("coordinate systems",        single(0x302, 0, 3), (0, 0),    Some(&[4, 0])),
        ("a system's name",           single(0x302, 1, 1), (0, 0),    Some(b"\x03CS1")),
        ("a system's axes",           single(0x302, 2, 2), (0, 0),    Some(&[3, 0, 1, 0, 2, 0, 4, 0])),
        ("a system beyond",           single(0x302, 5, 1), (0x05, 0), None),
        ("an axis's units",           single(0x301, 1, 8), (0, 0),    Some(b"\x02mm")),
        ("the group by name",         named("Motion"),     (0, 0),    None),
        ("a system by name",          named("cs1"),        (0, 0),    None),
        ("a tag by name",             named("aDint"),      (0, 0),    None),
        ("nobody by name",            named("nobody"),     (0x05, 0), None),
        ("a tag's type by name",      of_name(service::GET_ATTRIBUTE_SINGLE, "aDint", 2), (0, 0), Some(&[0xC4, 0])),
        ("an axis's units by name",   of_name(service::GET_ATTRIBUTE_SINGLE, "x", 8), (0, 0), Some(b"\x02mm")),
        ("an attribute nobody has",   of_name(service::GET_ATTRIBUTE_SINGLE, "aDint", 99), (0x14, 0), None),
        ("rust-ethernet-ip browses",  list_of("aDint"),    (0x04, 0), None),
        ("in a program's scope too",  list_of("Program:Main.Count"), (0x04, 0), None),
        ("an axis's list by name",    list_of("x"),        (0, 0),    None),
        ("an attribute is no tag",    of_name(service::READ_TAG, "aDint", 2), (0x04, 0), None),
        ("an execution never made",   all(0x303, 1),       (0x16, 0), None),
        ("executions",                single(0x303, 0, 3), (0, 0),    Some(&[0, 0])),
    ];
    for (why, request, expected, data) in cases {
        let reply = client.ask(&request).await;
        assert_eq!(codes(reply.status), expected, "{why}");
        if let Some(data) = data {
            assert_eq!(&reply.data[..], data, "{why}");
        }
    }
}

#[tokio::test]
async fn an_override_is_set_as_an_attribute_or_a_tag() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let get = |attribute| {
        Request::new(
            service::GET_ATTRIBUTE_SINGLE,
            Epath::attribute(0x302, 2, attribute),
            Bytes::new(),
        )
    };
    let set = |instance, value: &[u8]| {
        Request::new(
            service::SET_ATTRIBUTE_SINGLE,
            Epath::attribute(0x302, instance, 10),
            Bytes::copy_from_slice(value),
        )
    };
    let real = |value: f32| value.to_le_bytes();
    let tag = |value: f32| write("FeedOverride[1]", Elementary::Real.into(), 1, &real(value));
    #[rustfmt::skip]
    let cases = [
        // why,                       request,                       status, override, before the hold
        ("as it starts",              get(10),                       (0, 0),    100.0, 100.0),
        ("as an attribute",           set(2, &real(50.0)),           (0, 0),    50.0,  50.0),
        ("another system's",          set(1, &real(10.0)),           (0, 0),    50.0,  50.0),
        ("a hold",                    set(2, &real(0.0)),            (0, 0),    0.0,   50.0),
        ("too much",                  set(2, &real(200.1)),          (0x09, 0), 0.0,   50.0),
        ("below zero",                set(2, &real(-1.0)),           (0x09, 0), 0.0,   50.0),
        ("no number",                 set(2, &real(f32::NAN)),       (0x09, 0), 0.0,   50.0),
        ("too short",                 set(2, &[0, 0]),               (0x13, 0), 0.0,   50.0),
        ("too long",                  set(2, &[0; 5]),               (0x15, 0), 0.0,   50.0),
        ("a system beyond",           set(5, &real(50.0)),           (0x05, 0), 0.0,   50.0),
        ("as a tag",                  tag(150.0),                    (0, 0),    150.0, 150.0),
        ("as a tag, too much",        tag(201.0),                    (0x20, 0), 150.0, 150.0),
        ("as a tag, no number",       tag(f32::NAN),                 (0x20, 0), 150.0, 150.0),
    ];
    for (why, request, status, percent, before) in cases {
        let reply = client.ask(&request).await;
        assert_eq!(codes(reply.status), status, "{why}");
        assert_eq!(client.ask(&get(10)).await.data[..], real(percent), "{why}");
        assert_eq!(client.ask(&get(11)).await.data[..], real(before), "{why}");
        assert_eq!(client.read("FeedOverride[1]").await.data[..], real(percent), "{why}");
    }
    assert_eq!(client.read("FeedOverride[0]").await.data[..], real(10.0));
    let both = client
        .ask(&write(
            "FeedOverride",
            Elementary::Real.into(),
            2,
            &[real(20.0), real(300.0)].concat(),
        ))
        .await;
    assert_eq!(codes(both.status), (0x20, 0));
    assert_eq!(
        client.read("FeedOverride[0]").await.data[..],
        real(10.0),
        "none of them is written"
    );
    let reply = client
        .ask(&Request::new(
            service::SET_ATTRIBUTE_SINGLE,
            Epath::attribute(0x302, 1, 11),
            Bytes::from_static(&[0; 4]),
        ))
        .await;
    assert_eq!(
        codes(reply.status),
        (0x0E, 0),
        "what a hold has replaced is not settable"
    );
}

#[tokio::test]
async fn faults_are_injected_as_an_attribute_and_as_a_tag() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let get = |id| {
        Request::new(
            service::GET_ATTRIBUTE_SINGLE,
            Epath::attribute(0x301, 1, id),
            Bytes::new(),
        )
    };
    let set = |instance, id, value: &[u8]| {
        Request::new(
            service::SET_ATTRIBUTE_SINGLE,
            Epath::attribute(0x301, instance, id),
            Bytes::copy_from_slice(value),
        )
    };
    let word = |value: u32| value.to_le_bytes();
    let tag = |value: u32| write("FaultInject[0]", Elementary::Dint.into(), 1, &word(value));
    #[rustfmt::skip]
    let cases = [
        // why,                        request,                   status, injected
        ("as it starts",               get(9),                    (0, 0),    0),
        ("as an attribute",            set(1, 9, &word(16)),      (0, 0),    16),
        ("two",                        set(1, 9, &word(0x104)),   (0, 0),    0x104),
        ("a fault that there isn't",   set(1, 9, &word(1 << FaultKind::COUNT)), (0x09, 0), 0x104),
        ("too short",                  set(1, 9, &[0, 0]),        (0x13, 0), 0x104),
        ("too long",                   set(1, 9, &[0; 5]),        (0x15, 0), 0x104),
        ("an axis beyond",             set(99, 9, &word(1)),      (0x05, 0), 0x104),
        ("what is possible",           set(1, 10, &word(1)),      (0x0E, 0), 0x104),
        ("as a tag",                   tag(1),                    (0, 0),    1),
        ("as a tag, a fault too many", tag(1 << FaultKind::COUNT),               (0x20, 0), 1),
    ];
    for (why, request, status, injected) in cases {
        let reply = client.ask(&request).await;
        assert_eq!(codes(reply.status), status, "{why}");
        assert_eq!(client.ask(&get(9)).await.data[..], word(injected), "{why}");
        assert_eq!(client.read("FaultInject[0]").await.data[..], word(injected), "{why}");
    }
    assert_eq!(client.ask(&get(10)).await.data[..], word((1 << FaultKind::COUNT) - 1));
}
