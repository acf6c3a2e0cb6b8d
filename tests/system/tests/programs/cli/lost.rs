//! A command line that dies: its jog does not outlive it.

use std::process::Stdio;
use std::time::Duration;

use arcline_client::Client;
use arcline_system_tests::command_line::command;
use arcline_system_tests::eventually;
use arcline_system_tests::server::Server;

/// Position units per second, and the ramp that MAS takes from it: at the default machine's 10,000 units/s², S-curve.
const SPEED: f64 = 100.0;
const RAMP: f64 = 0.1;
/// The time that issue 6 allows from the death to the beginning of the ramp, s.
const ALLOWED: f64 = 0.25;

/// The way that is gone after the kill is the time, in the time of the machine, whatever the load of the computer.
#[test]
fn killing_the_command_line_stops_its_jog() {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .expect("a runtime");
    let server = Server::start();
    let at = server.address();
    let client = runtime
        .block_on(Client::connect(&at.to_string()))
        .expect("a connection");
    let read = |tag: &str| {
        let reading = runtime.block_on(client.read(tag)).expect("the tag is there");
        reading.as_f64().expect("a number")
    };
    let mut jogging = command(at, &["jog", "X", "100"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command line was just built");
    eventually("the jog", Duration::from_secs(20), || {
        ((read("X.CommandVelocity") - SPEED).abs() < 1e-9).then_some(())
    });
    let before = read("X.CommandPosition");
    // SIGKILL: it cannot say goodbye.
    jogging.kill().expect("it runs");
    jogging.wait().expect("it is our child");
    eventually("the stop", Duration::from_secs(20), || {
        (read("X.CommandVelocity") == 0.0).then_some(())
    });
    let way = read("X.CommandPosition") - before;
    assert!(
        way <= SPEED * (ALLOWED + RAMP),
        "stopped after {way} units at {SPEED} units/s"
    );
    println!(
        "stopped {way:.2} units behind the kill, {:.0} ms at {SPEED} units/s",
        way / SPEED * 1e3
    );
}
