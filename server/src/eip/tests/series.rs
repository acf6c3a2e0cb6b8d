//! Series of moves: their order, the move that fails, the queue without room, and requests that are not moves.

use arcline_instruction_set::predefined::coordinate_system_status::MOTION_STATUS;
use arcline_instruction_set::{Flag, Mnemonic, MotionControl};
use arcline_proto::arcline::machine::{CLASS, SeriesReply, service::EXECUTE_SERIES};
use arcline_proto::cip::{Request, join_multiple};

use super::motion::{line, name, numbers, on};
use super::*;

/// Moves that can wait in the queue of CS1.
const DEPTH: usize = 6;

fn bench() -> Bench {
    let mut project = project();
    project.machine.systems[0].queue_depth = DEPTH;
    Bench::of(Plant::start(&project).expect("a thread"), settings_of("Bench"))
}

fn series(moves: &[Request]) -> Request {
    let data = join_multiple(moves).expect("short");
    Request::new(EXECUTE_SERIES, Epath::object(CLASS, 1), data)
}

/// A line that does not end while a test runs.
fn long(control: &str, x: f64) -> Request {
    let mut operands = line(control, &[x, 0.0, 0.0]);
    operands[3] = numbers(&[1.0]);
    on(Mnemonic::Mclm, 1, &operands)
}

impl Client {
    async fn series(&mut self, moves: &[Request]) -> SeriesReply {
        let reply = self.ask(&series(moves)).await;
        assert!(reply.status.is_success(), "{}", reply.status);
        SeriesReply::decode(&reply.data).expect("whole")
    }
}

fn shown(bench: &Bench, tag: &str) -> Option<MotionControl> {
    bench
        .device
        .plant
        .with_image(|image| Some(image.control(image.known_control(tag).ok()??)))
}

#[tokio::test(flavor = "multi_thread")]
async fn the_moves_of_a_series_are_executed_in_their_order() {
    let bench = bench();
    let mut client = bench.client().await;
    let moves: Vec<Request> = (1..=4).map(|n| long(&format!("M{n}"), f64::from(n) * 50.0)).collect();
    let reply = client.series(&moves).await;
    assert_eq!((reply.accepted.len(), reply.full, reply.failed), (4, None, None));
    let instances: Vec<u32> = reply.accepted.iter().map(|accepted| accepted.instance).collect();
    assert!(instances.is_sorted_by(|one, other| one < other), "{instances:?}");
    for (place, accepted) in reply.accepted.iter().enumerate() {
        let control = MotionControl::from_bytes(accepted.control);
        assert!(
            control.has(Flag::Dn) && control.has(Flag::Ip),
            "move {place}: {control:?}"
        );
        assert!(shown(&bench, &format!("M{}", place + 1)).is_some_and(|control| control.has(Flag::Ip)));
    }
    let full = client.series(&moves).await;
    assert_eq!(
        (full.accepted.len(), full.full),
        (DEPTH + 1 - 4, Some(DEPTH as u16)),
        "the rest finds no room"
    );
    let full = client.series(&[long("Late", 1.0)]).await;
    assert_eq!((full.accepted.len(), full.full), (0, Some(DEPTH as u16)));
    let late = shown(&bench, "Late").unwrap_or_default();
    assert_eq!(
        late,
        MotionControl::default(),
        "a move without room leaves no error in its tag"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_is_executed_behind_a_move_that_fails() {
    let bench = bench();
    let mut client = bench.client().await;
    let backward = {
        let mut operands = line("Wrong", &[9.0, 9.0, 9.0]);
        operands[3] = numbers(&[-1.0]);
        on(Mnemonic::Mclm, 1, &operands)
    };
    let word = on(Mnemonic::Mclm, 1, &[name("Wrong"), numbers(&[0.0]), name("x")]);
    let merges = {
        let mut operands = line("Wrong", &[9.0, 9.0, 9.0]);
        operands.extend([100.0, 100.0, 0.0, 0.0, 1.0].map(|number| numbers(&[number])));
        on(Mnemonic::Mclm, 1, &operands)
    };
    let read = read("X.CommandPosition", 1);
    let stop = on(Mnemonic::Mcs, 1, &[name("Stop"), numbers(&[0.0])]);
    #[rustfmt::skip]
    let cases: Vec<(&str, Request, &[u16])> = vec![
        ("a motion error",             backward,                   &[0x1F, 13, 4]),
        ("an operand of another type", word,                       &[0x20, 3]),
        ("a move that merges",         merges,                     &[0x20]),
        ("another instruction",        stop,                       &[0x20]),
        ("no motion service",          read,                       &[0x08]),
    ];
    for (why, wrong, expected) in cases {
        let reply = client.series(&[long("Good", 20.0), wrong, long("Behind", 30.0)]).await;
        assert_eq!((reply.accepted.len(), reply.full), (1, None), "{why}");
        let status = reply.failed.expect("a reply").status;
        let words: Vec<u16> = [u16::from(status.general())]
            .iter()
            .chain(status.additional())
            .copied()
            .collect();
        assert_eq!(words, expected, "{why}");
        let behind = shown(&bench, "Behind").unwrap_or_default();
        assert_eq!(behind, MotionControl::default(), "{why}");
        let all = on(Mnemonic::Mcs, 1, &[name("All"), numbers(&[0.0])]);
        assert!(client.ask(&all).await.status.is_success(), "{why}");
        let at_rest = async {
            while bench
                .device
                .plant
                .with_snapshot(|snapshot| snapshot.systems[0].status & MOTION_STATUS != 0)
            {
                tokio::task::yield_now().await;
            }
        };
        tokio::time::timeout(PATIENCE, at_rest).await.expect("it comes to rest");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn data_that_is_no_series_is_refused() {
    let bench = bench();
    let mut client = bench.client().await;
    let empty = client.series(&[]).await;
    assert_eq!(empty, SeriesReply::default(), "nothing to do");
    let good = series(&[long("Good", 20.0)]);
    let at = |instance| Request {
        path: Epath::object(CLASS, instance),
        ..good.clone()
    };
    let cut = Request {
        data: Bytes::from_static(&[1]),
        ..good.clone()
    };
    for (why, request, expected) in [
        ("on the class", at(0), 0x08),
        ("on another instance", at(2), 0x05),
        ("cut", cut, 0x13),
    ] {
        assert_eq!(client.ask(&request).await.status.general(), expected, "{why}");
    }
    assert_eq!(shown(&bench, "Good"), None, "nothing was executed");
}
