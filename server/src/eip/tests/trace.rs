//! The Trace object, class 0x0304 (docs/TRACE.md).

use bytes::BufMut;

use super::*;

const CLASS: u16 = 0x0304;
const LIST: u8 = 0x32;
const READ: u8 = 0x33;
const COMPLETE: u8 = 2;

pub(super) fn of(service: u8, instance: u32, data: impl Into<Bytes>) -> Request {
    Request::new(service, Epath::object(CLASS, instance), data.into())
}

fn named(out: &mut BytesMut, name: &str) {
    out.put_u8(name.len() as u8);
    out.put_slice(name.as_bytes());
}

/// A configuration: ticks before and from the trigger on, every nth, the trigger's bytes, signals.
pub(super) fn config(before: u32, length: u32, every: u16, trigger: &[u8], signals: &[&str]) -> BytesMut {
    let mut out = BytesMut::new();
    out.put_u32_le(before);
    out.put_u32_le(length);
    out.put_u16_le(every);
    out.put_slice(trigger);
    out.put_u16_le(signals.len() as u16);
    signals.iter().for_each(|signal| named(&mut out, signal));
    out
}

fn rises(signal: &str, level: f64) -> BytesMut {
    let mut out = BytesMut::new();
    out.put_u8(1);
    named(&mut out, signal);
    out.put_f64_le(level);
    out
}

fn instruction(of: &str, flags: u32) -> BytesMut {
    let mut out = BytesMut::new();
    out.put_u8(5);
    named(&mut out, of);
    out.put_u32_le(flags);
    out
}

/// A reply to Read.
struct Rows {
    state: u8,
    count: u64,
    every: u64,
    first: u64,
    values: Vec<f64>,
}

impl Client {
    pub(super) async fn create(&mut self, config: BytesMut) -> u32 {
        let reply = self.ask(&of(service::CREATE, 0, config)).await;
        assert!(reply.status.is_success(), "Create: {}", reply.status);
        u32::from_le_bytes(*reply.data.first_chunk().expect("an instance"))
    }

    async fn rows(&mut self, connected: &mut Connected, instance: u32, from: u64, most: u16) -> Rows {
        let mut data = BytesMut::new();
        data.put_u64_le(from);
        data.put_u16_le(most);
        let reply = self.ask_connected(connected, &of(READ, instance, data)).await;
        assert!(reply.status.is_success(), "Read: {}", reply.status);
        let (head, values) = reply.data.split_first_chunk::<16>().expect("a head");
        let word = |at: usize| u64::from(u16::from_le_bytes([head[at], head[at + 1]]));
        let values: Vec<f64> = values
            .chunks_exact(8)
            .map(|value| f64::from_le_bytes(*value.first_chunk().expect("8 bytes")))
            .collect();
        assert_eq!(values.len() as u64, word(2) * word(4));
        Rows {
            state: head[0],
            count: word(2),
            every: word(6),
            first: u64::from_le_bytes(*head.last_chunk().expect("8 bytes")),
            values,
        }
    }

    /// Everything of a trace that ends by itself: ticks and rows of `signals`.
    async fn whole(&mut self, connected: &mut Connected, instance: u32, signals: usize) -> Vec<(u64, Vec<f64>)> {
        let (mut from, mut all) = (0, Vec::new());
        loop {
            let rows = self.rows(connected, instance, from, 0).await;
            for (place, row) in (0..).zip(rows.values.chunks_exact(signals)) {
                all.push((rows.first + place * rows.every, row.to_vec()));
            }
            from = rows.first + rows.count * rows.every;
            if rows.count == 0 && rows.state == COMPLETE {
                return all;
            }
        }
    }
}

/// Executes Structured Text-like MCLM by its instruction tag: Move1 to a position.
async fn move_to(client: &mut Client, x: f32) {
    let real = WireType::Atomic(0xCA);
    let bool_ = WireType::Atomic(0xC1);
    assert!(client.write("Move1.EnableIn", bool_, &[0]).await.is_success());
    assert!(
        client
            .write("Move1.Position[0]", real, &x.to_le_bytes())
            .await
            .is_success()
    );
    assert!(client.write("Move1.EnableIn", bool_, &[1]).await.is_success());
}

#[tokio::test]
async fn a_trace_has_every_tick_once() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(4000, 1).await;
    let signals = ["X.CommandPosition", "x.movestatus", "CS1.PathSpeed", "CS1.MoveStatus"];
    let instance = client.create(config(0, 1500, 1, &[0], &signals)).await;
    move_to(&mut client, 20.0).await;
    let rows = client.whole(&mut connected, instance, signals.len()).await;
    assert_eq!(rows.len(), 1500);
    assert!(
        rows.windows(2).all(|pair| pair[0].0 + 1 == pair[1].0),
        "a tick is missing"
    );
    let mut moved = rows.iter().map(|(_, row)| row[0]);
    assert!(moved.clone().is_sorted(), "X only goes forward");
    assert!(moved.next_back().is_some_and(|x| x > 0.0));
    assert!(rows.iter().all(|(_, row)| row[1] == 0.0), "no MAM moves X");
    assert!(
        rows.iter().any(|(_, row)| row[2] > 0.0 && row[3] == 1.0),
        "the path is travelled"
    );
}

#[tokio::test]
async fn a_trigger_has_time_before_it() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(4000, 1).await;
    let ip = arcline_instruction_set::Flag::Ip.mask();
    let level = client
        .create(config(
            30,
            40,
            1,
            &rises("X.CommandPosition", 1.0),
            &["X.CommandPosition"],
        ))
        .await;
    let tag = client
        .create(config(10, 20, 2, &instruction("move1", ip), &["X.CommandVelocity"]))
        .await;
    let erred = client
        .create(config(10, 20, 1, &instruction("MCLM", 0), &["X.CommandVelocity"]))
        .await;
    let state = |instance| of(service::GET_ATTRIBUTE_SINGLE, instance, Bytes::new());
    assert!(
        !client.ask(&state(level)).await.status.is_success(),
        "no attribute is named"
    );
    let armed = client.rows(&mut connected, level, 0, 0).await;
    assert_eq!((armed.state, armed.count), (0, 0));
    // Wait until the store has rows from before the trace.
    while bench.device.plant.trace().stored_ticks().next < 100 {
        tokio::task::yield_now().await;
    }
    move_to(&mut client, 20.0).await;

    let rows = client.whole(&mut connected, level, 1).await;
    assert_eq!(rows.len(), 70);
    assert!(rows[29].1[0] < 1.0 && rows[30].1[0] >= 1.0, "{rows:?}");
    let rows = client.whole(&mut connected, tag, 1).await;
    assert_eq!(rows.len(), 15);
    assert!(
        rows.windows(2).all(|pair| pair[0].0 + 2 == pair[1].0),
        "every second tick"
    );
    assert!(
        rows[..5].iter().all(|(_, row)| row[0] == 0.0),
        "it stood before: {rows:?}"
    );
    assert!(rows[14].1[0] > 0.0, "and moves: {rows:?}");
    let waits = client.rows(&mut connected, erred, 0, 0).await;
    assert_eq!(waits.state, 0, "nothing has erred");
}

#[tokio::test]
async fn attributes_and_services_are_those_of_the_page() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let class = |id: u8| {
        let mut path = Epath::object(CLASS, 0);
        path.0.push(arcline_proto::epath::Segment::Attribute(id.into()));
        Request::new(service::GET_ATTRIBUTE_SINGLE, path, Bytes::new())
    };
    assert_eq!(client.ask(&class(8)).await.data, 1_000_000u32.to_le_bytes().as_slice());
    assert_eq!(client.ask(&class(9)).await.data, 107u16.to_le_bytes().as_slice());
    assert_eq!(client.ask(&class(13)).await.data.len(), 4);

    let mut names = Vec::new();
    while names.len() < 107 {
        let reply = client
            .ask(&of(LIST, 0, (names.len() as u16).to_le_bytes().to_vec()))
            .await;
        assert!(reply.status.is_success(), "{}", reply.status);
        let (head, mut rest) = reply.data.split_at(4);
        assert_eq!(head[..2], 107u16.to_le_bytes());
        let count = u16::from_le_bytes([head[2], head[3]]);
        assert!(count > 0);
        for _ in 0..count {
            let (name, behind) = rest[1..].split_at(rest[0].into());
            names.push(String::from_utf8_lossy(name).into_owned());
            rest = behind;
        }
        assert!(rest.is_empty());
    }
    assert_eq!(
        (names[0].as_str(), names[106].as_str()),
        ("X.CommandPosition", "XY.CoordinateMotionStatus")
    );

    let instance = client.create(config(0, 0, 1, &[0], &["X.ActualPosition"])).await;
    assert!(
        client.ask(&of(0x07, instance, Bytes::new())).await.status.is_success(),
        "Stop"
    );
    let mut connected = client.open(4000, 1).await;
    assert_eq!(client.rows(&mut connected, instance, 0, 1).await.state, 3);
    assert!(
        client.ask(&of(0x06, instance, Bytes::new())).await.status.is_success(),
        "Start"
    );
    assert_eq!(client.rows(&mut connected, instance, 0, 1).await.state, 1);
    let all = client
        .ask(&of(service::GET_ATTRIBUTES_ALL, instance, Bytes::new()))
        .await;
    assert_eq!(all.data.len(), 1 + 8 + 8 + 8 + 2 + 2 + 4);
    assert!(
        client
            .ask(&of(service::DELETE, instance, Bytes::new()))
            .await
            .status
            .is_success()
    );
    assert_eq!(codes(client.ask(&of(READ, instance, vec![0; 10])).await.status).0, 0x05);
}

#[tokio::test]
async fn invalid_trace_requests_have_their_status() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let good = config(0, 1, 1, &[0], &["X.ActualPosition"]);
    let longer = [good.as_ref(), &[0]].concat();
    #[rustfmt::skip]
    let cases: [(&str, &[u8], (u8, u16)); 9] = [
        ("cut short",             &good[..good.len() - 1],                                      (0x13, 0)),
        ("empty",                 &[],                                                          (0x13, 0)),
        ("too much",              &longer,                                                      (0x15, 0)),
        ("no such trigger",       &config(0, 1, 1, &[9], &["X.ActualPosition"]),                (0x20, 0)),
        ("no signal",             &config(0, 1, 1, &[0], &[]),                                  (0x20, 0)),
        ("an unknown axis",       &config(0, 1, 1, &[0], &["X.ActualPosition", "Q.ActualPosition"]), (0x05, 1)),
        ("an unknown member",     &config(0, 1, 1, &[0], &["X.Nothing"]),                       (0x05, 0)),
        ("an unknown trigger",    &config(0, 1, 1, &rises("Q.PathSpeed", 1.0), &["X.ActualPosition"]), (0x05, 0xFFFF)),
        ("a level that is none",  &config(0, 1, 1, &rises("X.ActualPosition", f64::NAN), &["X.ActualPosition"]), (0x20, 0)),
    ];
    for (why, data, expected) in cases {
        let reply = client.ask(&of(service::CREATE, 0, data.to_vec())).await;
        assert_eq!(codes(reply.status), expected, "{why}");
    }
    for _ in 0..crate::trace::TRACES {
        client.create(good.clone()).await;
    }
    let reply = client.ask(&of(service::CREATE, 0, good.clone())).await;
    assert_eq!(codes(reply.status).0, 0x02, "as many as there may be");
}
