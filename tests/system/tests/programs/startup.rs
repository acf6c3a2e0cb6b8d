//! A server with no configuration and no rights answers soon after it was started.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

use arcline_system_tests::capture::list_identity;
use arcline_system_tests::programs;
use arcline_system_tests::server::Server;

/// The longest time from the start of the process to the answer of its first request.
const LIMIT: Duration = Duration::from_millis(300);

fn first_answer() -> Duration {
    let began = Instant::now();
    let server = Server::start();
    let mut stream = TcpStream::connect(server.address()).expect("a ready server accepts");
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .expect("a timeout that is not zero");
    stream
        .write_all(&list_identity(*b"startup!"))
        .expect("the server reads");
    let mut header = [0; 24];
    stream.read_exact(&mut header).expect("the server answers");
    assert_eq!(header[..2], [0x63, 0x00], "the command is echoed: {header:x?}");
    assert_eq!(
        header[12..20],
        *b"startup!",
        "the sender context is echoed: {header:x?}"
    );
    began.elapsed()
}

#[test]
fn the_first_request_is_answered_soon() {
    const TRIES: usize = 5;
    let _ = programs::arcline_server(); // built before the clock runs
    let best = (0..TRIES).map(|_| first_answer()).min().expect("there are tries");
    println!("first answer {best:?} after the start of the process, best of {TRIES}");
    // A debug build on a busy machine is measured, not checked.
    assert!(
        cfg!(debug_assertions) || best < LIMIT,
        "first answer after {best:?}, expected less than {LIMIT:?}"
    );
}

#[test]
fn the_default_configuration_can_be_written_down_and_used() {
    let printed = Command::new(programs::arcline_server())
        .arg("default-config")
        .output()
        .expect("a built program");
    assert!(printed.status.success(), "{printed:?}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.toml");
    std::fs::write(&file, &printed.stdout).expect("the folder is writable");
    let check = Command::new(programs::arcline_server())
        .args(["check", "--config"])
        .arg(&file)
        .output();
    let check = check.expect("a built program");
    assert!(check.status.success(), "{check:?}");
    let text = String::from_utf8_lossy(&check.stdout);
    for name in [
        "Motion", "CS1", "CS2", "CS3", "XY", "T1", "Move1", "Arc1", "Change1", "Stop1",
    ] {
        assert!(text.contains(name), "{name} in what check prints: {text}");
    }
    let _ = Server::start_on(&file);
}
