//! `doctor`, `health`, `completions` and `man` as users start them.

use std::fs;
use std::net::TcpListener;
use std::process::{Command, Output};

use arcline_system_tests::programs;
use arcline_system_tests::server::Server;
use serde_json::Value;

fn server(arguments: &[&str]) -> Output {
    let mut command = Command::new(programs::arcline_server());
    command.args(arguments).output().expect("the server was just built")
}

#[test]
fn doctor_reports_findings_with_their_severity() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("machine.toml");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("its address").port();
    let write = |hmi: &str| {
        let text = format!("[server]\nlisten = \"127.0.0.1:0\"\nhmi = \"{hmi}\"\nio = \"off\"\n");
        fs::write(&config, text).expect("writable");
    };
    let file = config.to_str().expect("UTF-8");
    write(&format!("127.0.0.1:{port}"));
    let output = server(&["doctor", "--config", file, "--measure", "0.2"]);
    let told = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(
        told.contains("FAILED") && told.contains("ss -lntup") && told.contains("A server does not start here"),
        "{told}"
    );
    write("off");
    let state = folder.path().join("state");
    let state = state.to_str().expect("UTF-8");
    let output = server(&[
        "doctor",
        "--json",
        "--config",
        file,
        "--measure",
        "0.2",
        "--state",
        state,
    ]);
    let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let checks = result["checks"].as_array().expect("checks");
    // The test does not depend on the real-time settings of this computer.
    let code = if result["worst"] == "ok" { 0 } else { 1 };
    assert_eq!(output.status.code(), Some(code), "{result}");
    for check in ["configuration", "EtherNet/IP", "open files", "state"] {
        let found = checks.iter().find(|finding| finding["check"] == check);
        assert!(
            found.is_some_and(|finding| finding["grade"] == "ok"),
            "{check}: {result}"
        );
    }
    for finding in checks {
        assert_eq!(finding["remedy"].is_string(), finding["grade"] != "ok", "{finding}");
    }
    let ticks = checks.iter().find(|finding| finding["check"] == "ticks");
    assert!(ticks.is_some_and(|ticks| {
        ticks["found"]
            .as_str()
            .is_some_and(|found| !found.starts_with("0 ticks"))
    }));
    // The files that the server reads beside its configuration.
    let secured =
        "[server]\nlisten = \"127.0.0.1:0\"\nhmi = \"off\"\nio = \"off\"\n[security]\ntls = \"127.0.0.1:0\"\n";
    fs::write(&config, secured).expect("writable");
    let state = folder.path().to_str().expect("UTF-8");
    let output = server(&["doctor", "--config", file, "--measure", "0", "--state", state]);
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.code() == Some(2) && told.contains("server.key") && told.contains("it is not a file"),
        "{told}"
    );
    assert_eq!(server(&["doctor", "--measure", "1e300"]).status.code(), Some(2));
    fs::write(&config, "[server]\nlisten = 5\n").expect("writable");
    let wrong = server(&["doctor", "--config", file]);
    assert_eq!(wrong.status.code(), Some(2), "{wrong:?}");
    // The client has it too, with the same output and exit code.
    let mut client = Command::new(programs::arcline());
    let client = client
        .args(["doctor", "--config", file])
        .output()
        .expect("the client was just built");
    assert_eq!(
        (client.status, client.stdout, client.stderr),
        (wrong.status, wrong.stdout, wrong.stderr)
    );
}

#[test]
fn health_is_an_answer_to_list_identity() {
    let running = Server::start();
    let at = running.address().to_string();
    let output = server(&["health", "--server", &at]);
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && told.starts_with(&format!("{at}  Arcline")),
        "{output:?}"
    );
    drop(running);
    let output = server(&["health", "--server", &at]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    // A listener that sends no bytes.
    let silent = TcpListener::bind("127.0.0.1:0").expect("a port");
    let at = silent.local_addr().expect("its address").to_string();
    let output = server(&["health", "--server", &at, "--within", "0.2"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(1) && told.contains("no answer within 0.2 s"),
        "{told}"
    );
}

#[test]
fn completions_and_manual_pages_are_inside() {
    for shell in ["bash", "zsh", "fish"] {
        let output = server(&["completions", shell]);
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(
            output.status.success() && text.contains("simulate") && text.contains("doctor"),
            "{shell}"
        );
    }
    let folder = tempfile::tempdir().expect("a folder");
    let man = folder.path().join("man");
    assert!(
        server(&["man", "--output", man.to_str().expect("UTF-8")])
            .status
            .success()
    );
    for name in [
        "arcline-server.1",
        "arcline-server-simulate.1",
        "arcline-server-doctor.1",
    ] {
        let text = fs::read_to_string(man.join(name)).expect(name);
        assert!(text.contains(".TH"), "{name}");
    }
    assert!(fs::read_to_string(man.join("arcline-server-simulate.1")).is_ok_and(|text| text.contains("\\-\\-cases")));
}
