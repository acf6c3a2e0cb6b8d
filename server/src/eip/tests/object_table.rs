//! A new CIP object is one implementation and one row of a table: its classes, the list of the Message Router, its services and
//! attributes derive from that. docs/OBJECTS.md is written from the table too.

use std::sync::atomic::{AtomicU32, Ordering};

use arcline_proto::cip::class;

use super::*;
use crate::eip::action::ParsedRequest;
use crate::eip::objects::{Access, Extent, Object, ObjectContext, Objects, On, OwnService};
use crate::eip::pages;
use crate::pages::compare_or_write_part;
use crate::plant::Right;
use crate::work_threads::WorkThreads;

const CLASS: u16 = 0x0399;
const ADD: u8 = 0x32;
const CLEAR: u8 = 0x33;

/// The object of this test: a counter.
#[derive(Debug)]
struct Counter(AtomicU32);

impl Object for Counter {
    fn class(&self) -> u16 {
        CLASS
    }

    fn name(&self) -> &'static str {
        "Counter"
    }

    fn services(&self) -> &'static [OwnService] {
        &[
            OwnService {
                code: ADD,
                name: "Add",
                on: On::Instance,
                access: Access::Read,
                right: Right::Look,
            },
            OwnService {
                code: CLEAR,
                name: "Clear",
                on: On::Class,
                access: Access::Change,
                right: Right::ChangeTags,
            },
        ]
    }

    fn serve(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32) -> Result<Reply, CipStatus> {
        let code = cx.request.service;
        match (code, cx.request.data.first()) {
            (ADD, Some(more)) => drop(self.0.fetch_add((*more).into(), Ordering::Relaxed)),
            (ADD, None) => return Err(CipStatus::NOT_ENOUGH_DATA),
            _ => self.0.store(0, Ordering::Relaxed),
        }
        Ok(Reply::success(code, &[][..]))
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 1)
    }

    fn attribute(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 => Ok(Bytes::copy_from_slice(&self.0.load(Ordering::Relaxed).to_le_bytes())),
            _ => Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED),
        }
    }
}

/// The objects of a controller and the counter.
fn objects() -> Objects {
    let counter: &'static dyn Object = Box::leak(Box::new(Counter(AtomicU32::new(7))));
    let mut all = Objects::ALL.0.to_vec();
    all.push(counter);
    Objects(all.leak())
}

/// Why, service, instance, data, and the status and data of the reply.
type Case = (&'static str, u8, u32, &'static [u8], (u8, u16), &'static [u8]);

#[tokio::test]
async fn a_row_makes_an_object() {
    let (plant, _thread) = plant();
    let mut device = Device::new(plant, settings_of("Bench"), WorkThreads::Pool).expect("a free port");
    device.objects = objects();
    let (ours, theirs) = tokio::io::duplex(64 * 1024);
    tokio::spawn(connection::serve(theirs, LOCAL, PEER, Arc::new(device)));
    let mut client = Client::register(ours).await;
    let listed = client
        .ask(&Request::new(
            service::GET_ATTRIBUTE_SINGLE,
            Epath::attribute(class::MESSAGE_ROUTER, 1, 1),
            Bytes::new(),
        ))
        .await;
    assert!(
        listed.data.ends_with(&CLASS.to_le_bytes()),
        "the Message Router lists it"
    );
    #[rustfmt::skip]
    let cases: [Case; 10] = [
        ("its value", service::GET_ATTRIBUTE_SINGLE, 1, &[], (0, 0), &[7, 0, 0, 0]),
        ("a service on an instance", ADD, 1, &[3], (0, 0), &[]),
        ("what it did", service::GET_ATTRIBUTE_SINGLE, 1, &[], (0, 0), &[10, 0, 0, 0]),
        ("its own status", ADD, 1, &[], (0x13, 0), &[]),
        ("not on the class", ADD, 0, &[3], (0x08, 0), &[]),
        ("not on another instance", ADD, 2, &[3], (0x05, 0), &[]),
        ("a service on the class", CLEAR, 0, &[], (0, 0), &[]),
        ("what that did", service::GET_ATTRIBUTE_SINGLE, 1, &[], (0, 0), &[0, 0, 0, 0]),
        ("not on an instance", CLEAR, 1, &[], (0x08, 0), &[]),
        ("nothing can be set", service::SET_ATTRIBUTE_SINGLE, 1, &[1, 0, 0, 0], (0x0E, 0), &[]),
    ];
    for (why, code, instance, data, status, expected) in cases {
        let path = match code {
            service::GET_ATTRIBUTE_SINGLE | service::SET_ATTRIBUTE_SINGLE => Epath::attribute(CLASS, instance, 1),
            _ => Epath::object(CLASS, instance),
        };
        let reply = client.ask(&Request::new(code, path, data.to_vec())).await;
        assert_eq!((codes(reply.status), &reply.data[..]), (status, expected), "{why}");
    }
}

#[test]
fn requests_are_classified_by_lock_and_disk() {
    const NOTHING: (bool, bool, bool) = (false, false, false);
    let objects = objects();
    let object = |code, class| Request::new(code, Epath::object(class, 1), Bytes::new());
    let named = |code| Request::new(code, path("X"), Bytes::new());
    // Under the plant's lock, after its release, and only when the retained state has the change.
    #[rustfmt::skip]
    let cases = [
        ("a read", named(service::READ_TAG), NOTHING),
        ("a write", named(service::WRITE_TAG), (true, false, true)),
        ("a write by instance", object(service::WRITE_TAG_FRAGMENTED, class::SYMBOL), (true, false, true)),
        ("a write to what is no tag", object(service::WRITE_TAG, class::IDENTITY), NOTHING),
        ("an instruction", object(0x32, 0x0301), (false, true, false)),
        ("an instruction by name", named(0x32), (false, true, false)),
        ("an attribute", object(service::GET_ATTRIBUTE_SINGLE, 0x0301), NOTHING),
        ("an attribute that is set", object(service::SET_ATTRIBUTE_SINGLE, 0x0301), (true, false, false)),
        ("of a name", named(service::SET_ATTRIBUTE_LIST), (true, false, false)),
        ("a tag that is created", object(service::CREATE, class::SYMBOL), (true, false, true)),
        ("a tag that is deleted by name", named(service::DELETE), (true, false, true)),
        ("an object that is late", object(service::SET_ATTRIBUTE_SINGLE, class::ASSEMBLY), (false, true, false)),
        ("a trace that is created", object(service::CREATE, 0x0304), (false, true, false)),
        ("a class that is not there", object(service::CREATE, 0x47), NOTHING),
        ("a new object", object(CLEAR, CLASS), (true, false, true)),
    ];
    for (why, request, expected) in cases {
        let action = ParsedRequest::new(&request, objects).action;
        let needs = (action.writes(), action.is_late(), action.must_be_kept());
        assert_eq!(needs, expected, "{why}: {action:?}");
    }
}

#[test]
fn the_table_ascends() {
    let classes: Vec<u16> = Objects::ALL.0.iter().map(|object| object.class()).collect();
    assert!(classes.is_sorted_by(|one, next| one < next), "{classes:x?}");
}

#[test]
fn the_table_of_the_page_is_new() {
    compare_or_write_part("docs/OBJECTS.md", "objects", &pages::objects());
}
