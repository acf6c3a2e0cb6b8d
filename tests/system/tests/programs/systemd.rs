//! The messages of the server to systemd (`sd_notify(3)`).

use std::os::unix::net::UnixDatagram;
use std::process::{Command, Stdio};
use std::time::Duration;

use arcline_system_tests::programs::arcline_server;

#[test]
fn systemd_hears_that_the_server_is_ready_lives_and_stops() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("notify");
    let socket = UnixDatagram::bind(&path).expect("a free path");
    socket
        .set_read_timeout(Some(Duration::from_secs(60)))
        .expect("a socket");
    let hear = || {
        let mut message = [0; 64];
        let length = socket.recv(&mut message).expect("a message within a minute");
        String::from_utf8_lossy(&message[..length]).into_owned()
    };
    let child = Command::new(arcline_server())
        .args([
            "run",
            "--listen",
            "127.0.0.1:0",
            "--hmi",
            "off",
            "--state",
            "off",
            "--end-with-stdin",
        ])
        .env("NOTIFY_SOCKET", &path)
        .env("WATCHDOG_USEC", "300000")
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let mut child = child.expect("the server was just built");
    assert_eq!([hear(), hear(), hear()], ["READY=1", "WATCHDOG=1", "WATCHDOG=1"]);
    drop(child.stdin.take());
    let last = std::iter::repeat_with(hear).find(|message| message != "WATCHDOG=1");
    assert_eq!(last.as_deref(), Some("STOPPING=1"));
    assert!(child.wait().expect("it ends").success());
}
