//! The time of a wrong log-in does not reveal whether a user exists (spec/security.md §10).

use std::io::Write as _;
use std::net::{Ipv4Addr, SocketAddr};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use arcline_system_tests::bare::median;
use arcline_system_tests::server::{Server, processor_time};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpSocket;

/// Log-ins of each of the two, and by how much their times may differ: medians of 200 within 5 % in a release build (`.ci/run timed_tests`).
/// In others the server's processor time is compared, which does not depend on the load of the computer: a check of a password that is left out
/// for an unknown user takes nearly all of it.
const TRIES: usize = if cfg!(debug_assertions) { 10 } else { 200 };
const MOST: f64 = if cfg!(debug_assertions) { 0.5 } else { 0.05 };

/// The time of a wrong log-in, from an address of this computer.
async fn refused(page: SocketAddr, from: Ipv4Addr, user: &str) -> Duration {
    let socket = TcpSocket::new_v4().expect("a socket");
    socket
        .bind((from, 0).into())
        .expect("all of 127.0.0.0/8 is this computer");
    let mut stream = socket.connect(page).await.expect("it accepts");
    let body = format!("{{\"user\":\"{user}\",\"password\":\"a wrong password\"}}");
    let head = format!(
        "POST /login HTTP/1.1\r\nHost: localhost\r\nContent-Length: {}\r\n",
        body.len()
    );
    let request = format!("{head}Content-Type: application/json\r\nConnection: close\r\n\r\n{body}");
    let began = Instant::now();
    stream.write_all(request.as_bytes()).await.expect("it reads");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).await.expect("it answers");
    let took = began.elapsed();
    let answer = String::from_utf8_lossy(&answer);
    assert!(answer.starts_with("HTTP/1.1 401"), "{answer}");
    took
}

#[test]
fn a_wrong_log_in_takes_as_long_for_an_unknown_user() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let mut add = Command::new(arcline_system_tests::programs::arcline_server())
        .args(["users", "add", &file("users.toml"), "anna", "--role", "operator"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("it was just built");
    let mut input = add.stdin.take().expect("piped");
    input.write_all(b"a long password\n").expect("it reads");
    drop(input);
    assert!(add.wait().is_ok_and(|status| status.success()));
    let text = arcline_config::DEFAULT.to_owned() + "\n[security]\nusers = \"users.toml\"\n";
    std::fs::write(file("machine.toml"), text).expect("a writable folder");
    let server = Server::start_with(&["--hmi", "127.0.0.1:0", "--config", &file("machine.toml")]);
    let page = server.hmi().expect("it has a page");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.expect("a runtime");
    // Four failures of an address lock nothing. One of each kind follows the other, so that both see the same load.
    let mut times = [Vec::new(), Vec::new()];
    for try_ in 0..TRIES {
        let [high, low] = u16::try_from(try_ / 2 + 1).expect("a few hundred").to_be_bytes();
        let from = Ipv4Addr::new(127, 9, high, low);
        let mut users = [(0, "anna"), (1, "nobody-of-that-name")];
        // Which of the two comes first changes.
        users.rotate_left(try_ % 2);
        for (kind, user) in users {
            let before = processor_time(server.process());
            let waited = runtime.block_on(refused(page, from, user));
            let worked = processor_time(server.process()).saturating_sub(before);
            let time = if cfg!(debug_assertions) { worked } else { waited };
            times[kind].push(time.as_secs_f64());
        }
    }
    let [known, unknown] = times.map(median);
    println!(
        "{TRIES} log-ins each: {:.2} ms for a user, {:.2} ms for none",
        known * 1e3,
        unknown * 1e3
    );
    let differ = (known / unknown - 1.0).abs();
    assert!(differ <= MOST, "the medians differ by {:.1} %", differ * 100.0);
}
