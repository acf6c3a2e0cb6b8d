//! `arcline fault` against a live server: inject, list, clear, and the view of a client meanwhile.

use std::time::Duration;

use arcline_system_tests::command_line::arcline;
use arcline_system_tests::eventually;
use arcline_system_tests::server::Server;

#[test]
fn faults_are_injected_listed_and_cleared() {
    let server = Server::start();
    let at = server.address();
    let listed = |axis: &str| arcline(at, &["--json", "fault", "list", axis]).expect(0).objects()[0].clone();
    let becomes = |axis: &str, state: &str| {
        eventually(&format!("{axis} {state}"), Duration::from_secs(20), || {
            (listed(axis)["state"] == state).then_some(())
        });
    };
    let _ = arcline(at, &["move", "CS1", "100000,0,0", "--speed", "100", "--no-wait"]).expect(0);
    assert_eq!(
        arcline(at, &["fault", "inject", "X", "overcurrent"]).expect(0).stdout,
        "X: overcurrent injected\n"
    );
    becomes("X", "faulted");
    assert_eq!(listed("X")["faults"][0], "overcurrent");
    assert_eq!(listed("x")["injected"][0], "overcurrent");
    let words = arcline(
        at,
        &[
            "--json",
            "read",
            "X.AxisFault",
            "X.MotorOvercurrentFault",
            "CS1.PhysicalAxesFaulted",
            "FaultInject[0]",
        ],
    );
    let values: Vec<_> = words
        .expect(0)
        .objects()
        .iter()
        .map(|o| o["value"].to_string())
        .collect();
    assert_eq!(values, ["1", "true", "1", "16"]);
    let refused = arcline(at, &["move", "CS1", "0,0,0"]);
    assert_eq!(refused.code, Some(1), "{refused:?}");
    assert!(refused.stderr.contains("20"), "{refused:?}");

    // A fault that is cleared while its cause is there comes back.
    let _ = arcline(at, &["exec", "MAFR(X, R1)"]).expect(0);
    becomes("X", "faulted");
    let _ = arcline(at, &["fault", "inject", "X", "feedback-loss"]);
    assert_eq!(
        arcline(at, &["fault", "clear", "X"]).expect(0).stdout,
        "X: faults cleared\n"
    );
    becomes("X", "stopped");
    assert_eq!(listed("X")["faults"], serde_json::json!([]));
    let _ = arcline(at, &["servo", "on", "X"]).expect(0);
    becomes("X", "running");

    // A tag does the same, and the table shows it.
    let _ = arcline(at, &["write", "FaultInject[1]", "1"]).expect(0);
    eventually("Y faults", Duration::from_secs(20), || {
        (listed("Y")["faults"][0] == "soft_travel_positive").then_some(())
    });
    let table = arcline(at, &["fault", "list"]).expect(0).stdout;
    assert!(table.contains("soft_travel_positive"), "{table}");
    assert_eq!(listed("Y")["state"], "running", "soft limits stop the planner only");
    let _ = arcline(at, &["fault", "clear", "Y", "soft_travel_positive"]).expect(0);
    assert_eq!(listed("Y")["injected"], serde_json::json!([]));

    for (arguments, message) in [
        (&["fault", "inject", "A", "drive"][..], "it has no drive"),
        (&["fault", "inject", "X", "sulk"], "overcurrent"),
        (&["fault", "inject", "Nobody", "drive"], "Nobody"),
    ] {
        let refused = arcline(at, arguments);
        assert_eq!(refused.code, Some(2), "{refused:?}");
        assert!(refused.stderr.contains(message), "{refused:?}");
    }
    let refused = arcline(at, &["write", "FaultInject[0]", "65536"]);
    assert_eq!(refused.code, Some(1), "{refused:?}");
}
