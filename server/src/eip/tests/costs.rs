//! The cost of a packet in the server without the system's part: bytes in, bytes out, on one thread.

use std::time::Instant;

use arcline_proto::cip::{class, join_multiple};

use super::*;

/// Reads in a packet.
const TAGS: usize = 100;

/// The number of packets: `ARCLINE_PACKETS`, or a few by default. A release build prints the time of one.
fn packets() -> u32 {
    let given = std::env::var("ARCLINE_PACKETS").ok();
    given.and_then(|text| text.parse().ok()).unwrap_or(20)
}

#[tokio::test]
async fn a_packet_of_100_tags_is_answered_whole() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(4000, 1).await;
    let reads: Vec<Request> = (0..TAGS).map(|number| read(&format!("Dints[{number}]"), 1)).collect();
    let packet = Request::new(
        service::MULTIPLE_SERVICE_PACKET,
        Epath::object(class::MESSAGE_ROUTER, 1),
        join_multiple(&reads).expect("short paths"),
    );
    let message = packet.to_bytes().expect("a short path");
    let mut took = Duration::ZERO;
    let packets = packets();
    for _ in 0..packets {
        connected.sequence = connected.sequence.wrapping_add(1);
        let data = Packet::connected(connected.id, connected.sequence, &message).to_bytes();
        let began = Instant::now();
        let frame = client.exchange(Command::SEND_UNIT_DATA, data).await;
        took += began.elapsed();
        let reply = connected_reply(&frame, &connected);
        assert!(reply.status.is_success(), "{}", reply.status);
        // Count, offsets, and of each reply its head, the type and the value.
        assert_eq!(reply.data.len(), 2 + TAGS * (2 + 4 + 2 + 4));
    }
    println!("{TAGS} tags: {:.1} µs", took.as_secs_f64() * 1e6 / f64::from(packets));
}
