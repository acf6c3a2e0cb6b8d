//! The counters of requests.

use arcline_proto::cip::{Request, join_multiple, service};
use arcline_proto::epath::Epath;
use arcline_tag::Elementary;
use bytes::Bytes;

use super::{Bench, read, write};
use crate::metrics::metrics;
use crate::plant::RequestKind;

#[tokio::test]
async fn each_request_is_counted_by_its_kind_and_outcome() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let dint = Elementary::Dint.into();
    let good = write("aDint", dint, 1, &1_i32.to_le_bytes());
    for request in [
        read("aDint", 1),
        read("NoSuchTag", 1),
        good.clone(),
        Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(1, 1), Bytes::new()),
        Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(0x4242, 1), Bytes::new()),
    ] {
        client.ask(&request).await;
    }
    let wide = write("aDint", dint, 2, &[0; 8]);
    let reads = [read("aDint", 1), read("aBool", 1)];
    for packet in [&reads[..], &[read("aDint", 1), good, wide]] {
        let data = join_multiple(packet).expect("short paths");
        let packet = Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data);
        client.ask(&packet).await;
    }
    let counted = RequestKind::ALL.map(|kind| {
        let count = bench.device.plant.requests(kind);
        (count.done, count.refused)
    });
    assert_eq!(counted, [(4, 1), (2, 1), (0, 0), (1, 0), (0, 1)]);
    let text = metrics(&bench.device.plant);
    for line in [
        "arcline_requests_total{kind=\"tag reads\",outcome=\"done\"} 4\n",
        "arcline_requests_total{kind=\"unknown\",outcome=\"refused\"} 1\n",
    ] {
        assert!(text.contains(line), "{line}{text}");
    }
    assert!(!text.contains("arcline_audit_lost_total"), "there is no audit: {text}");
}
