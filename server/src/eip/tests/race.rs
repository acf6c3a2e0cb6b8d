//! Several clients that write the operands and `EnableIn` of one instruction tag at once: each message is one action, so every
//! execution has the operands of the message that began it, and the edges reach the controller in their order.
//!
//! `ARCLINE_RACE` is the number of messages of each client: 25,000 in a nightly run (`tests/nightly race`), 100,000 in all.

use std::sync::atomic::{AtomicBool, Ordering};

use arcline_controller::{Command as Sent, Port as _};
use arcline_instruction_set::{Call, Flag, MotionControl};
use arcline_proto::cip::{join_multiple, split_multiple_replies};
use arcline_realtime::Rings;
use arcline_tag::Elementary;

use super::*;
use crate::work_threads::WorkThreads;

/// The operands that every message writes, all with one value.
const OPERANDS: [&str; 5] = ["Speed", "AccelRate", "DecelRate", "Position[0]", "Position[1]"];
/// Clients that also write `EnableIn`, and clients that write operands only, again and again.
const CLIENTS: u32 = 4;
const WRITERS: u32 = 2;
/// Messages of each client in the normal run.
const MESSAGES: u32 = 1000;

/// The edges of the tag's EnableIn that the controller received.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Edge {
    /// An execution with its values of [`OPERANDS`].
    Rise([f64; OPERANDS.len()]),
    Fall,
}

/// The values of [`OPERANDS`] in a call.
fn values(call: &Call) -> [f64; OPERANDS.len()] {
    let operands = call.instruction().operands;
    let place = |name: &str| operands.iter().position(|operand| operand.name == name).expect(name);
    let number = |name| call.number(place(name));
    let position = call.array(place("Position"));
    [
        number("Speed"),
        number("Accel Rate"),
        number("Decel Rate"),
        position[0],
        position[1],
    ]
}

/// Takes all commands and answers every call, until it is to end.
fn serve(mut rings: Rings, plant: &Plant, end: &AtomicBool) -> Vec<Edge> {
    let mut edges = Vec::new();
    loop {
        // Read the end flag first, so that the loop still takes all commands from before it.
        let last = end.load(Ordering::Acquire);
        let mut took = false;
        while let Some(command) = rings.next_command() {
            took = true;
            match command {
                Sent::Call(ticket, call) => {
                    edges.push(Edge::Rise(values(&call)));
                    let mut control = MotionControl::default();
                    control.set(Flag::En);
                    control.set(Flag::Dn);
                    rings.answer(ticket, control);
                }
                Sent::RungFalse(_) => edges.push(Edge::Fall),
                other => panic!("no client sent {other:?}"),
            }
        }
        if took {
            rings.publish();
            // As the pump of a plant that runs would do.
            plant.with_image(|_| ());
        } else if last {
            return edges;
        }
        std::thread::yield_now();
    }
}

/// A packet that reads `EnableIn`, writes all operands, and `EnableIn` if it is given.
fn packet(value: f32, enable: Option<bool>) -> Request {
    let real = Elementary::Real.into();
    let operands = OPERANDS.map(|name| write(&format!("Move1.{name}"), real, 1, &value.to_le_bytes()));
    let enable = enable.map(|on| write("Move1.EnableIn", Elementary::Bool.into(), 1, &[u8::from(on)]));
    let mut requests = vec![read("Move1.EnableIn", 1)];
    requests.extend(operands);
    requests.extend(enable);
    let data = join_multiple(&requests).expect("short paths");
    Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data)
}

/// Sends the messages of one client. Returns the values of those that made an edge, rises and falls apart.
async fn toggle(mut client: Client, number: u32, messages: u32) -> [Vec<f64>; 2] {
    let mut edges = [Vec::new(), Vec::new()];
    for message in 0..messages {
        let (value, enable) = (message * CLIENTS + number + 1, message % 2 == 0);
        let reply = client.ask(&packet(value as f32, Some(enable))).await;
        let parts = split_multiple_replies(&reply.data).expect("a packet of replies");
        for part in &parts[..=OPERANDS.len()] {
            assert!(part.status.is_success(), "{}", part.status);
        }
        let status = codes(parts[OPERANDS.len() + 1].status);
        let before = ReadReply::decode(&parts[0].data).expect("a BOOL").data[0] != 0;
        assert_eq!(status, (0, 0), "there is room for {CLIENTS} clients");
        if before != enable {
            edges[usize::from(!enable)].push(f64::from(value as f32));
        }
    }
    edges
}

/// Writes operands until the end; they are those of no execution.
async fn overwrite(mut client: Client, end: Arc<AtomicBool>) {
    let mut value = -1.0;
    while !end.load(Ordering::Acquire) {
        let reply = client.ask(&packet(value, None)).await;
        assert!(reply.status.is_success(), "{}", reply.status);
        value -= 1.0;
    }
}

/// Three worker threads, as a server on four processors has.
#[tokio::test(flavor = "multi_thread", worker_threads = 3)]
async fn operands_and_enable_in_are_one_action_between_clients() {
    let messages = std::env::var("ARCLINE_RACE").map_or(MESSAGES, |text| text.parse().expect("a number"));
    let project = project();
    let (rings, link) = arcline_realtime::link(&project.machine);
    let plant = Plant::new(&project, link);
    let device = Arc::new(Device::new(plant.clone(), settings_of("Race"), WorkThreads::Pool).expect("a free port"));
    let end = Arc::new(AtomicBool::new(false));
    let controller = {
        let (end, plant) = (end.clone(), plant.clone());
        std::thread::spawn(move || serve(rings, &plant, &end))
    };
    let connect = || {
        let (ours, theirs) = tokio::io::duplex(64 * 1024);
        tokio::spawn(connection::serve(theirs, LOCAL, PEER, device.clone()));
        Client::register(ours)
    };
    let mut clients = Vec::new();
    for number in 0..CLIENTS {
        clients.push(tokio::spawn(toggle(connect().await, number, messages)));
    }
    let over = Arc::new(AtomicBool::new(false));
    let mut writers = Vec::new();
    for _ in 0..WRITERS {
        writers.push(tokio::spawn(overwrite(connect().await, over.clone())));
    }
    let (mut rises, mut falls) = (Vec::new(), 0);
    for client in clients {
        let [rose, fell] = client.await.expect("a client");
        rises.extend(rose);
        falls += fell.len();
    }
    over.store(true, Ordering::Release);
    for writer in writers {
        writer.await.expect("a writer");
    }
    end.store(true, Ordering::Release);
    let edges = controller.join().expect("the controller");

    let mut executed = Vec::new();
    let (mut mixed, mut out_of_order, mut fallen) = (0, 0, 0);
    let mut last = None;
    for edge in edges {
        let rose = match edge {
            Edge::Rise(values) => {
                mixed += u32::from(values.iter().any(|value| *value != values[0]));
                executed.push(values[0]);
                true
            }
            Edge::Fall => {
                fallen += 1;
                false
            }
        };
        out_of_order += u32::from(last.replace(rose) == Some(rose));
    }
    let all = executed.len();
    let by_value = |values: &mut Vec<f64>| values.sort_by(f64::total_cmp);
    by_value(&mut executed);
    by_value(&mut rises);
    let other = executed
        .iter()
        .filter(|value| rises.binary_search_by(|rise| rise.total_cmp(value)).is_err());
    let other = other.count();
    assert_eq!(
        (mixed, other, out_of_order, all, fallen),
        (0, 0, 0, rises.len(), falls),
        "of {all} executions: those with operands of two messages, with operands of another message than that of their edge; \
         edges that repeat the one before; rises; falls"
    );
    assert!(all > 100, "the clients compete: {all}");
}
