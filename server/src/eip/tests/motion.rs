//! Motion by tag and by service.

use arcline_instruction_set::{Flag, Mnemonic, MotionControl};
use arcline_proto::cip::{Request, join_multiple, service};
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::logix::{Typed, encode_operands};
use arcline_tag::{Elementary, Value};
use bytes::BytesMut;

use super::*;

const REAL: WireType = WireType::Atomic(0xCA);
const BOOL: WireType = WireType::Atomic(0xC1);

pub(super) fn name(text: &str) -> Typed {
    Typed::ShortString(text.to_owned())
}

pub(super) fn numbers(numbers: &[f64]) -> Typed {
    let values = numbers
        .iter()
        .map(|number| Value::from_f64(Elementary::Lreal, *number))
        .collect();
    Typed::Numbers(Elementary::Lreal, values)
}

fn data(operands: &[Typed]) -> Bytes {
    let mut out = BytesMut::new();
    encode_operands(operands, &mut out);
    out.freeze()
}

/// An absolute MCLM at 400 units/s and 5,000 units/s², trapezoidal.
pub(super) fn line(control: &str, position: &[f64]) -> Vec<Typed> {
    let mut operands = vec![name(control), numbers(&[0.0]), numbers(position)];
    operands.extend([400.0, 0.0, 5000.0, 0.0, 5000.0, 0.0, 0.0].map(|number| numbers(&[number])));
    operands
}

pub(super) fn on(mnemonic: Mnemonic, instance: u32, operands: &[Typed]) -> Request {
    let (class, service) = mnemonic.instruction().service();
    Request::new(service, Epath::object(class, instance), data(operands))
}

impl Bench {
    fn control(&self, tag: &str) -> MotionControl {
        self.device.plant.with_image(|image| {
            let slot = image.known_control(tag).expect("a motion control").expect("known");
            image.control(slot)
        })
    }

    async fn until(&self, tag: &str, flag: Flag) -> MotionControl {
        let wait = async {
            loop {
                let control = self.control(tag);
                if control.has(flag) {
                    return control;
                }
                tokio::task::yield_now().await;
            }
        };
        tokio::time::timeout(PATIENCE, wait)
            .await
            .unwrap_or_else(|_| panic!("{tag} never showed {flag}"))
    }

    fn position(&self, axis: &str) -> f64 {
        let path = format!("{axis}.CommandPosition").parse().expect("a path");
        self.device
            .plant
            .with_image(|image| image.read(&path).expect("a position").as_f64())
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_written_enable_in_moves_and_a_refused_operand_shows_its_place() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let target: Vec<u8> = [3_f32, 2.0, 1.0]
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    assert!(
        client
            .ask(&write("Move1.Position", REAL, 3, &target))
            .await
            .status
            .is_success()
    );
    assert!(client.write("Move1.EnableIn", BOOL, &[1]).await.is_success());
    assert!(
        bench.control("Move1").has(Flag::Dn),
        "verified before the write was answered"
    );
    bench.until("Move1", Flag::Pc).await;
    assert_eq!(
        [bench.position("X"), bench.position("Y"), bench.position("Z")],
        [3.0, 2.0, 1.0]
    );
    assert!(client.write("Move1.EnableIn", BOOL, &[0]).await.is_success());

    // One packet is one action: operands behind EnableIn count too.
    let enable = write("Move1.EnableIn", BOOL, 1, &[1]);
    let slower = write("Move1.Speed", REAL, 1, &(-5_f32).to_le_bytes());
    let packet = join_multiple(&[enable, slower]).expect("short");
    let packet = Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), packet);
    assert!(client.ask(&packet).await.status.is_success());
    let control = bench.control("Move1");
    assert_eq!((control.has(Flag::Er), control.err, control.exerr), (true, 13, 4));
    assert_eq!(bench.position("X"), 3.0, "nothing moved");
}

#[tokio::test(flavor = "multi_thread")]
async fn services_execute_connected_and_unconnected_by_instance_and_by_name() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(500, 1).await;
    let by_name = Request {
        path: Epath(vec![Segment::Symbol("cs1".into())]),
        ..on(Mnemonic::Mclm, 1, &line("M", &[3.0, 0.0, 0.0]))
    };
    let mut stray = on(Mnemonic::Mclm, 1, &line("M", &[4.0, 0.0, 0.0]));
    stray.data = [&stray.data[..], &[1, 0, 1, 0]].concat().into();
    let mut last = 0;
    for (why, request, over_connection, x) in [
        (
            "unconnected",
            on(Mnemonic::Mclm, 1, &line("M", &[1.0, 0.0, 0.0])),
            false,
            1.0,
        ),
        (
            "connected",
            on(Mnemonic::Mclm, 1, &line("M", &[2.0, 0.0, 0.0])),
            true,
            2.0,
        ),
        ("by name", by_name, true, 3.0),
        ("with the route a stock client leaves behind", stray, false, 4.0),
    ] {
        let reply = if over_connection {
            client.ask_connected(&mut connected, &request).await
        } else {
            client.ask(&request).await
        };
        assert!(reply.status.is_success(), "{why}: {}", reply.status);
        let (instance, control) = reply.data.split_first_chunk::<4>().expect("an instance");
        let instance = u32::from_le_bytes(*instance);
        assert!(instance > last, "{why}");
        last = instance;
        let control = MotionControl::from_bytes(control.try_into().expect("16 bytes"));
        assert!(control.has(Flag::Dn) && !control.has(Flag::Er), "{why}: {control:?}");
        bench.until("M", Flag::Pc).await;
        assert_eq!(bench.position("X"), x, "{why}");
        let ask = Request::new(
            service::GET_ATTRIBUTES_ALL,
            Epath::object(0x303, instance),
            Bytes::new(),
        );
        let seen = MotionControl::from_bytes(client.ask(&ask).await.data[..].try_into().expect("16 bytes"));
        assert!(seen.has(Flag::Pc), "{why}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn refused_services_tell_why_and_nothing_moves() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let fast = {
        let mut operands = line("M", &[9.0, 9.0, 9.0]);
        operands[3] = numbers(&[-1.0]);
        operands
    };
    let many = {
        let mut operands = line("M", &[9.0, 9.0, 9.0]);
        operands.extend(std::iter::repeat_n(numbers(&[0.0]), 20));
        operands
    };
    let raw = |bytes: &'static [u8]| Request::new(0x32, Epath::object(0x302, 1), bytes);
    let at = |path: Epath| Request::new(0x32, path, data(&line("M", &[9.0, 0.0, 0.0])));
    #[rustfmt::skip]
    let cases: Vec<(&str, Request, &[u16])> = vec![
        ("speed below zero",     on(Mnemonic::Mclm, 1, &fast),                       &[0x1F, 13, 4]),
        ("nothing at all",       on(Mnemonic::Mclm, 1, &[]),                         &[0x13]),
        ("only a name: no position", on(Mnemonic::Mclm, 1, &[name("M")]),           &[0x1F, 13, 3]),
        ("a number for a name",  on(Mnemonic::Mclm, 1, &[numbers(&[1.0])]),          &[0x20]),
        ("a name for a number",  on(Mnemonic::Mclm, 1, &[name("M"), numbers(&[0.0]), name("x")]), &[0x20, 3]),
        ("too many",             on(Mnemonic::Mclm, 1, &many),                       &[0x15]),
        ("cut",                  raw(&[0xDA, 0, 1, 0, 9, b'M']),                     &[0x13]),
        ("an unknown type",      raw(&[0xDA, 0, 1, 0, 0, 0xD5, 0, 1, 0, 0, 0]),      &[0x20]),
        ("a tag of another kind", on(Mnemonic::Mclm, 1, &line("X", &[9.0, 0.0, 0.0])), &[0x20]),
        ("no tag name",          on(Mnemonic::Mclm, 1, &line("a b", &[9.0, 0.0, 0.0])), &[0x20]),
        ("a system beyond",      on(Mnemonic::Mclm, 9, &line("M", &[9.0, 0.0, 0.0])), &[0x05, 0]),
        ("the class",            on(Mnemonic::Mclm, 0, &line("M", &[9.0, 0.0, 0.0])), &[0x08]),
        ("an unknown name",      at(Epath::symbol("CS9")),                           &[0x05, 0]),
        ("a tag's name",         at(Epath::symbol("aDint")),                         &[0x08]),
        ("a member's name",      at(path("CS1.Shutdown")),                           &[0x08]),
        ("no such service",      Request::new(0x4A, Epath::object(0x302, 1), Bytes::new()), &[0x08]),
    ];
    for (why, request, expected) in cases {
        let status = client.ask(&request).await.status;
        let got: Vec<u16> = [u16::from(status.general())]
            .iter()
            .chain(status.additional())
            .copied()
            .collect();
        assert_eq!(got, expected, "{why}");
    }
    assert_eq!(bench.position("X"), 0.0);
    let ip = bench
        .device
        .plant
        .with_image(|image| image.known_control("M").is_ok_and(|slot| slot.is_some()));
    assert!(ip, "the refused instruction's tag was made, since it shows the error");
}

#[tokio::test(flavor = "multi_thread")]
async fn axes_take_their_own_services() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let on_bit = |bench: &Bench| {
        let path = "X.ServoActionStatus".parse().expect("a path");
        bench
            .device
            .plant
            .with_image(|image| image.read(&path).expect("a bit").as_bool())
    };
    for (mnemonic, expected) in [(Mnemonic::Msf, false), (Mnemonic::Mso, true)] {
        let reply = client.ask(&on(mnemonic, 1, &[name("Servo")])).await;
        assert!(reply.status.is_success(), "{mnemonic}: {}", reply.status);
        assert_eq!(on_bit(&bench), expected, "{mnemonic}");
    }
}
