//! Attributes of axes and coordinate systems that are set over the wire (spec/axis-and-data-types.md §9.6).

use arcline_proto::cip::{Request, service};
use arcline_proto::epath::{Epath, Segment};
use bytes::Bytes;

use super::{Bench, Client, codes};

/// Why, the data of a Set Attribute Single, its status, and the bits afterwards.
type Set = (&'static str, &'static [u8], (u8, u16), u8);

/// Axis X by class and instance, axis Y by name, coordinate system CS1, and the number of the attribute of each.
fn paths() -> [(&'static str, Epath, u16); 3] {
    let name = |name: &str| Epath(vec![Segment::Symbol(name.into())]);
    [
        ("axis 1", Epath::object(0x301, 1), 11),
        ("axis Y by name", name("Y"), 11),
        ("coordinate system 2", Epath::object(0x302, 2), 26),
    ]
}

fn single(code: u8, path: &Epath, id: u16, data: &[u8]) -> Request {
    let mut path = path.clone();
    path.0.push(Segment::Attribute(id.into()));
    Request::new(code, path, Bytes::copy_from_slice(data))
}

async fn value(client: &mut Client, path: &Epath, id: u16) -> Vec<u8> {
    let reply = client.ask(&single(service::GET_ATTRIBUTE_SINGLE, path, id, &[])).await;
    assert_eq!(codes(reply.status), (0, 0));
    reply.data.to_vec()
}

#[tokio::test]
async fn dynamics_configuration_bits_are_set_alone_and_in_a_list() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    for (what, path, id) in paths() {
        assert_eq!(
            value(&mut client, &path, id).await,
            [7, 0, 0, 0],
            "{what}: as configured"
        );
        #[rustfmt::skip]
        let cases: [Set; 7] = [
            ("some",         &[5, 0, 0, 0],          (0, 0),    5),
            ("none",         &[0, 0, 0, 0],          (0, 0),    0),
            ("a fourth bit", &[8, 0, 0, 0],          (0x09, 0), 0),
            ("a high bit",   &[1, 0, 0, 0x80],       (0x09, 0), 0),
            ("too short",    &[1, 0],                (0x13, 0), 0),
            ("too long",     &[1, 0, 0, 0, 0],       (0x15, 0), 0),
            ("all",          &[7, 0, 0, 0],          (0, 0),    7),
        ];
        for (why, data, status, expected) in cases {
            let set = single(service::SET_ATTRIBUTE_SINGLE, &path, id, data);
            let reply = client.ask(&set).await;
            assert_eq!(codes(reply.status), status, "{what}: {why}");
            assert_eq!(
                value(&mut client, &path, id).await,
                [expected, 0, 0, 0],
                "{what}: {why}"
            );
        }
        // A list goes on behind a value that is refused, and ends at an attribute that cannot be set.
        let [low, high] = id.to_le_bytes();
        #[rustfmt::skip]
        let list = [4, 0, low, high, 3, 0, 0, 0, low, high, 9, 0, 0, 0, low, high, 2, 0, 0, 0, 1, 0, 0, 0, 0, 0];
        let reply = client
            .ask(&Request::new(
                service::SET_ATTRIBUTE_LIST,
                path.clone(),
                Bytes::copy_from_slice(&list),
            ))
            .await;
        assert_eq!(codes(reply.status), (0x0A, 0), "{what}");
        assert_eq!(
            value(&mut client, &path, id).await,
            [2, 0, 0, 0],
            "{what}: the last of the list"
        );
    }
    // Each object has its own.
    let other = Epath::object(0x301, 3);
    assert_eq!(value(&mut client, &other, 11).await, [7, 0, 0, 0]);
    // In Get Attributes All: of an axis in front of its faults, of a coordinate system in front of three LREALs of its active move.
    for (class, instance, behind) in [(0x301, 1, 4), (0x302, 2, 24)] {
        let all = Request::new(
            service::GET_ATTRIBUTES_ALL,
            Epath::object(class, instance),
            Bytes::new(),
        );
        let all = client.ask(&all).await;
        let bits = all.data.len().saturating_sub(behind + 4);
        assert_eq!(
            all.data.get(bits..bits + 4),
            Some(&[2, 0, 0, 0][..]),
            "class {class:#x}"
        );
    }
    let maximum = single(service::SET_ATTRIBUTE_SINGLE, &Epath::object(0x301, 1), 3, &[0; 8]);
    assert_eq!(
        codes(client.ask(&maximum).await.status),
        (0x0E, 0),
        "a maximum of an axis is the configuration's"
    );
}

#[tokio::test]
async fn maxima_and_tolerances_of_a_coordinate_system_are_set() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let path = Epath::object(0x302, 2);
    let lreal = |number: f64| number.to_le_bytes().to_vec();
    #[rustfmt::skip]
    let cases = [
        // Why, attribute, the data, its status.
        ("a maximum speed",         3, lreal(75.5),              (0, 0)),
        ("a maximum jerk",          7, lreal(1e5),               (0, 0)),
        ("no deceleration",         5, lreal(0.0),               (0x09, 0)),
        ("a negative acceleration", 4, lreal(-1.0),              (0x09, 0)),
        ("no number",               6, lreal(f64::NAN),          (0x09, 0)),
        ("no end",                  3, lreal(f64::INFINITY),     (0x09, 0)),
        ("an actual tolerance",     8, lreal(0.25),              (0, 0)),
        ("no actual tolerance",     8, lreal(0.0),               (0, 0)),
        ("a command tolerance",     9, lreal(1.5),               (0, 0)),
        ("a negative tolerance",    9, lreal(-0.1),              (0x09, 0)),
        ("a REAL",                  9, 1.5_f32.to_le_bytes().to_vec(), (0x13, 0)),
        ("two of them",             9, [lreal(1.0), lreal(2.0)].concat(), (0x15, 0)),
    ];
    for (why, id, data, status) in cases {
        let before = value(&mut client, &path, id).await;
        let set = single(service::SET_ATTRIBUTE_SINGLE, &path, id, &data);
        assert_eq!(codes(client.ask(&set).await.status), status, "{why}");
        let expected = if status == (0, 0) { data } else { before };
        assert_eq!(value(&mut client, &path, id).await, expected, "{why}");
    }
    // The other systems keep theirs.
    let other = value(&mut client, &Epath::object(0x302, 1), 3).await;
    assert_ne!(other, lreal(75.5));
}
