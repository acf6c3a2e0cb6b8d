//! Viewers of every role.

use arcline_config::Role;

use super::*;
use crate::guard::VIEWERS;
use crate::hmi::protocol::Request;
use crate::plant::Right;

/// Requests of the page with the right that each needs, in their order: every kind of request at least once.
pub(crate) fn cases() -> Vec<(Right, Value)> {
    let mas = "MAS(X, Weak, All, Yes, 1000, Unitspersec2);";
    #[rustfmt::skip]
    let cases = vec![
        (Right::Look,          json!({"do": "ping"})),
        (Right::Look,          json!({"do": "active"})),
        (Right::Look,          json!({"do": "read", "names": ["Move1.Speed"]})),
        (Right::Look,          json!({"do": "tags"})),
        (Right::Look,          json!({"do": "watch", "names": ["Move1.Speed"]})),
        (Right::Look,          json!({"do": "check", "text": "MSO(X, C);"})),
        (Right::Look,          json!({"do": "line", "instruction": "MSO"})),
        (Right::Look,          json!({"do": "preview", "text": "MSO(X, C);"})),
        (Right::Look,          json!({"do": "dry_run", "text": "MSO(X, C);"})),
        (Right::Look,          json!({"do": "routines"})),
        (Right::Look,          json!({"do": "rungs", "routine": 0, "from": 0, "count": 1})),
        (Right::Look,          json!({"do": "look", "routine": null})),
        (Right::Look,          json!({"do": "uses", "tag": "Move1"})),
        (Right::Look,          json!({"do": "trace", "on": true})),
        (Right::Look,          json!({"do": "history", "before": 1})),
        (Right::Look,          json!({"do": "events"})),
        (Right::EndSessions,   json!({"do": "sessions"})),
        (Right::EndSessions,   json!({"do": "end_session", "session": 9})),
        (Right::TakeControl,   json!({"do": "take", "object": "CS1"})),
        (Right::TakeByForce,   json!({"do": "take", "object": "CS1", "force": true})),
        (Right::Move,          json!({"do": "execute", "text": "MSO(X, C);"})),
        (Right::Stop,          json!({"do": "execute", "text": mas})),
        (Right::Move,          json!({"do": "jog", "axis": "X", "speed": 1})),
        (Right::Stop,          json!({"do": "keep", "axis": "X"})),
        (Right::Stop,          json!({"do": "jog_end", "axis": "X"})),
        (Right::WriteTag,      json!({"do": "write", "tag": "Move1.Speed", "value": 5})),
        (Right::InjectFaults,  json!({"do": "write", "tag": "FaultInject[0]", "value": 0})),
        (Right::Override,      json!({"do": "override", "coordinate_system": "CS1", "percent": 50})),
        (Right::OverrideAbove, json!({"do": "override", "coordinate_system": "CS1", "percent": 120})),
        (Right::Stop,          json!({"do": "hold", "coordinate_system": "CS1"})),
        (Right::Override,      json!({"do": "resume", "coordinate_system": "CS1"})),
        (Right::Stop,          json!({"do": "stop"})),
        (Right::ReleaseStop,   json!({"do": "release_stop"})),
        (Right::RunProgram,    json!({"do": "run", "text": "DELAY(0.001);"})),
        (Right::RunProgram,    json!({"do": "continue"})),
        (Right::RunProgram,    json!({"do": "step"})),
        (Right::Stop,          json!({"do": "pause"})),
        (Right::Stop,          json!({"do": "end"})),
        (Right::ChangeMode,    json!({"do": "mode", "run": false})),
        (Right::Force,         json!({"do": "force", "tag": "Local:1:I.Data.0", "value": true})),
        (Right::Force,         json!({"do": "remove_forces"})),
        (Right::TakeControl,   json!({"do": "release", "object": "CS1"})),
    ];
    cases
}

#[tokio::test]
async fn every_request_for_every_role() {
    let bench = Bench::start().await;
    let cases = cases();
    for (number, role) in (1_u64..).zip(Role::ALL) {
        let mut viewer = bench.viewer().await;
        bench.plant.roles().set(VIEWERS | number, role);
        for (right, request) in &cases {
            let answer = viewer.ask(request.clone()).await;
            let text = answer
                .as_ref()
                .err()
                .and_then(|error| error["text"].as_str())
                .unwrap_or_default();
            let refused = text.starts_with(&format!("the role {} may not", role.word()));
            assert_eq!(refused, !right.is_of(role), "{request} as {}: {answer:?}", role.word());
        }
    }
}

/// A request that the page learns has a row above. The error of a request that there is not lists those that there are.
#[test]
fn every_kind_of_request_has_a_row() {
    let cases = cases();
    let error = serde_json::from_value::<Request>(json!({"do": "?"})).expect_err("it is none");
    let error = error.to_string();
    // The odd pieces stand between the quotes; the first one is the request itself.
    let kinds: Vec<&str> = error.split('`').skip(1).step_by(2).skip(1).collect();
    assert!(kinds.len() > 30, "{error}");
    for kind in &kinds {
        assert!(
            cases.iter().any(|(_, request)| request["do"] == *kind),
            "{kind} has no row"
        );
    }
}

/// The program that an engineer started ends with the right to run programs.
#[tokio::test]
async fn a_program_stops_when_its_viewer_may_no_longer_run_it() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer
        .run("WHILE TRUE DO Move1.Speed := 10; DELAY(0.005); END_WHILE;")
        .await
        .expect("it runs");
    viewer.program("running").await;
    bench.plant.roles().set(VIEWERS | 1, Role::Operator);
    let failed = viewer.program("failed").await;
    let text = failed["error"]["text"].as_str().unwrap_or_default();
    assert!(text.contains("run programs"), "{failed}");
}

/// The audit records the outcome of a request, not the request itself.
#[tokio::test]
async fn the_audit_has_the_outcome_of_a_request() {
    let bench = Bench::start().await;
    let folder = tempfile::tempdir().expect("a folder");
    let audit = crate::audit::Audit::open(folder.path()).expect("a writable folder");
    bench.plant.set_audit(audit);
    let (mut viewer, mut other) = (bench.viewer().await, bench.viewer().await);
    let take = json!({"do": "take", "object": "CS1"});
    viewer.ask(take.clone()).await.expect("nobody has it");
    other.ask(take).await.expect_err("another viewer has it");
    viewer.run("nonsense").await.expect_err("it is no program");
    bench.plant.close_audit();
    let text = std::fs::read_to_string(folder.path().join("000001.jsonl")).expect("it is there");
    let lines = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
    let lines = lines.filter(|line| line["what"] == "take" || line["what"] == "program");
    let results: Vec<Value> = lines.map(|line| line["result"].clone()).collect();
    assert_eq!(results, ["done", "refused", "refused"], "{text}");
}
