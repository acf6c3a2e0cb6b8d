//! The audit has the changes that EtherNet/IP clients make without a command of the plant (spec/security.md §9).

use arcline_config::{IoLoss, Role};
use arcline_proto::arcline::trace::service as of_trace;

use super::io::{bench, open, output};
use super::roles::set;
use super::trace::{config, of};
use super::*;
use crate::audit::Audit;
use crate::eip::io::layout::OUTPUT;
use crate::metrics::metrics;

#[tokio::test]
async fn requests_that_are_no_commands_are_recorded_when_done() {
    let bench = bench(IoLoss::Hold);
    let folder = tempfile::tempdir().expect("a folder");
    bench
        .device
        .plant
        .set_audit(Audit::open(folder.path()).expect("a writable folder"));
    let metric = metrics(&bench.device.plant);
    // A label with the hash would be a new series each minute.
    assert!(metric.contains("\narcline_audit_line 1\n"), "{metric}");

    let mut client = bench.client_as(Role::Engineer).await;
    let clock = 1_795_301_281_000_000_u64.to_le_bytes();
    for request in [set(0x8B, 6, &clock), set(0xF5, 13, &[60, 0]), set(0x06, 100, &[0])] {
        assert!(client.ask(&request).await.status.is_success());
    }
    // A request that is refused for another reason than the role changes nothing, and has no line.
    assert!(!client.ask(&set(0xF5, 13, &[0xFF, 0xFF])).await.status.is_success());
    let trace = client.create(config(0, 10, 1, &[0], &["X.CommandPosition"])).await;
    for code in [of_trace::STOP, of_trace::START, service::DELETE] {
        assert!(client.ask(&of(code, trace, Bytes::new())).await.status.is_success());
    }
    assert!(
        !client
            .ask(&of(of_trace::STOP, trace, Bytes::new()))
            .await
            .status
            .is_success()
    );
    // Reading is no change.
    assert!(
        client
            .ask(&of(of_trace::LIST_SIGNALS, 0, vec![0, 0]))
            .await
            .status
            .is_success()
    );
    let outputs = output(0, [100.0; 4]);
    let reply = client
        .assembly(service::SET_ATTRIBUTE_SINGLE, OUTPUT, 3, &outputs)
        .await;
    assert!(reply.status.is_success(), "{}", reply.status);
    let (reply, _) = client.open_io(&open(1, OUTPUT), 50_000).await;
    assert!(reply.status.is_success(), "{}", reply.status);
    assert!(client.close_io(1).await.is_success());

    bench.device.plant.close_audit();
    let text = std::fs::read_to_string(folder.path().join("000001.jsonl")).expect("it is there");
    let lines = text
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("JSON"));
    let lines: Vec<_> = lines
        .filter(|line| line["what"] == "config" || line["what"] == "take")
        .collect();
    let found: Vec<(&str, &str)> = lines
        .iter()
        .map(|line| {
            (
                line["what"].as_str().unwrap_or_default(),
                line["object"].as_str().unwrap_or_default(),
            )
        })
        .collect();
    let of_trace = |name: &str| format!("{name} of Trace {trace}");
    let (stop, start, delete) = (of_trace("Stop"), of_trace("Start"), of_trace("Delete"));
    assert_eq!(
        found,
        [
            ("config", "attribute 6 of Wall Clock Time 1"),
            ("config", "attribute 13 of TCP/IP Interface 1"),
            ("config", "attribute 100 of Connection Manager 1"),
            ("config", "Create of Trace"),
            ("config", &stop),
            ("config", &start),
            ("config", &delete),
            ("config", "attribute 3 of Assembly 150"),
            ("take", "the outputs of implicit I/O"),
        ],
        "{text}"
    );
    for line in &lines {
        assert_eq!(
            (&line["result"], &line["role"], &line["door"]),
            (&"done".into(), &"engineer".into(), &"enip".into())
        );
    }
    assert_eq!(
        (&lines[1]["old"], &lines[1]["new"]),
        (&"7800".into(), &"3c00".into()),
        "120 s, then 60 s"
    );
}
