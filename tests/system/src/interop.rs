//! A foreign client against a real server, with a record that Wireshark's dissectors check.

use std::fmt::Write as _;
use std::net::SocketAddr;
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::capture::Capture;
use crate::command_line::read_numbers;
use crate::libplctag::Libplctag;
use crate::node::Node;
use crate::python::Python;
use crate::secured::{CLIENT, Secured};
use crate::server::{Server, signal};
use crate::tunnel::{Kind, Tunnel};

/// Tags beyond those of `config/interop_tags.toml`, so that a list of them takes several pages.
const PAGE_TAGS: usize = 300;

/// Runs `tests/python/SCRIPT HOST:PORT` with the packages of `python/requirements/CLIENT.txt`.
///
/// # Panics
/// As `against_a_server`.
pub fn python(client: &str, script: &str) {
    match Python::with(client) {
        Ok(python) => against_a_server(script, "127.0.0.1:0", |server| {
            python.run(script, &[&server.to_string()])
        }),
        Err(why) => crate::not_run(script, &why),
    }
}

/// Runs `tests/python/SCRIPT HOST:PORT` against a server that runs the program of `config/Cell.L5X`.
///
/// # Panics
/// When the script fails, or something needed is missing in CI.
pub fn python_on_program(client: &str, script: &str) {
    match Python::with(client) {
        Ok(python) => {
            let file = crate::fixture("config/Cell.L5X");
            let server = Server::start_with(&[file.to_str().expect("the project's paths are UTF-8")]);
            print!("{}", python.run(script, &[&server.address().to_string()]));
        }
        Err(why) => crate::not_run(script, &why),
    }
}

/// Runs `tests/python/SCRIPT HOST:PORT` against two servers on the step clock, which must make it print the same.
///
/// # Panics
/// When the script fails, or the two differ, or something needed is missing in CI.
pub fn python_on_the_step_clock(client: &str, script: &str) {
    match Python::with(client) {
        Ok(python) => {
            let run = || {
                let server = Server::start_with(&["--clock", "step"]);
                python.run(script, &[&server.address().to_string()])
            };
            let printed = run();
            print!("{printed}");
            assert_eq!(printed, run(), "{script}: the second run differs");
        }
        Err(why) => crate::not_run(script, &why),
    }
}

/// Runs `tests/python/SCRIPT HOST:PORT`, which jogs the axis S by its instruction tag `Jog1`, and halts its process while the axis moves:
/// its connections stay open, and the axis must stand within `jog_silence_ms` of the configuration and the time of a look and a ramp.
///
/// # Panics
/// When the axis does not move, or does not stand in time; in CI also when something needed is missing.
pub fn python_hangs(client: &str, script: &str) {
    match Python::with(client) {
        Ok(python) => hangs(script, |server| {
            let mut command = python.command();
            command
                .arg(crate::fixture("python").join(script))
                .arg(server.to_string());
            command
        }),
        Err(why) => crate::not_run(script, &why),
    }
}

/// The same with the program of `tests/libplctag`.
///
/// # Panics
/// As [`python_hangs`].
pub fn libplctag_hangs() {
    match Libplctag::build() {
        Ok(client) => hangs("libplctag", |server| client.jog(server)),
        Err(why) => crate::not_run("libplctag_hangs", &why),
    }
}

fn hangs(name: &str, client: impl FnOnce(SocketAddr) -> Command) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("jog.toml");
    let jog = "\n[[instruction]]\ntag = \"Jog1\"\ntype = \"MAJ\"\ntarget = \"S\"\n";
    std::fs::write(&file, format!("{}{jog}", arcline_config::DEFAULT)).expect("a file");
    let server = Server::start_on(&file);
    let address = server.address();
    let speed = || read_numbers(address, &["S.CommandVelocity"])[0].abs();
    let mut child = client(address).spawn().expect("it can be started");
    crate::eventually("the jog has its speed", Duration::from_secs(60), || {
        (speed() > 49.0).then_some(())
    });
    signal("STOP", child.id());
    let began = Instant::now();
    crate::eventually("the axis stands", Duration::from_secs(30), || {
        (speed() == 0.0).then_some(())
    });
    let took = began.elapsed();
    signal("KILL", child.id());
    child.wait().expect("it is our child");
    println!("{name}: at rest {took:?} after its client hung");
    assert!(took > SILENCE / 2, "{name}: something else stopped it, after {took:?}");
    assert!(took < SILENCE + MARGIN, "{name}: {took:?}");
}

/// `jog_silence_ms` of a configuration that does not say it.
const SILENCE: Duration = Duration::from_secs(2);
/// A look, a ramp, and the time of the command line that asks, on a machine that is busy with other tests.
const MARGIN: Duration = Duration::from_millis(1500);

/// As [`python`], with the default machine alone and implicit I/O on UDP port 2222 of 127.0.0.1: a scanner that does not
/// say where it listens can only be answered there.
///
/// # Panics
/// As `against_a_server`, and when the port does not become free.
pub fn python_io(client: &str, script: &str) {
    let python = match Python::with(client) {
        Ok(python) => python,
        Err(why) => return crate::not_run(script, &why),
    };
    let _turn = IO_PORT.lock().unwrap_or_else(PoisonError::into_inner);
    crate::eventually("UDP port 2222 is free", IO_PORT_FREE, || {
        std::net::UdpSocket::bind(IO_ADDRESS).ok().map(drop)
    });
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("io.toml");
    let io = format!("[server]\nio = \"{IO_ADDRESS}\"\n");
    std::fs::write(&file, arcline_config::DEFAULT.replacen("[server]\n", &io, 1)).expect("a file");
    let server = Server::start_on(&file);
    let capture = Capture::with_io(server.address());
    print!("{}", python.run(script, &[&server.address().to_string()]));
    judge(script, capture);
}

/// The address of implicit I/O.
const IO_ADDRESS: &str = "127.0.0.1:2222";
/// The turn among the tests of one program.
static IO_PORT: Mutex<()> = Mutex::new(());
/// The longest time for which another program may use the port.
const IO_PORT_FREE: std::time::Duration = std::time::Duration::from_secs(60);

/// Runs `tests/node/SCRIPT ADDRESS`. Its client knows no port but 44818, so the server has an address of its own.
///
/// # Panics
/// As `against_a_server`.
pub fn node(script: &str) {
    if !cfg!(target_os = "linux") {
        return crate::not_run(script, "only Linux has more loopback addresses than one");
    }
    match Node::with("node") {
        Ok(node) => {
            let [low, high, ..] = std::process::id().to_le_bytes();
            let listen = format!("127.{}.{low}.1:44818", high.max(1));
            against_a_server(script, &listen, |server| node.run(script, &[&server.ip().to_string()]));
        }
        Err(why) => crate::not_run(script, &why),
    }
}

/// As [`python`], against a server without plain EtherNet/IP, through a tunnel to its TLS.
///
/// # Panics
/// When the client finds a fault; in CI also when something needed is missing.
pub fn python_through(kind: Kind, client: &str, script: &str) {
    match Python::with(client) {
        Ok(python) => through(kind, script, None, |tunnel| python.run(script, &[&tunnel.to_string()])),
        Err(why) => crate::not_run(&format!("{script} through {kind:?}"), &why),
    }
}

/// As [`libplctag`], in the same manner.
///
/// # Panics
/// As [`python_through`].
pub fn libplctag_through(kind: Kind) {
    match Libplctag::build() {
        Ok(client) => through(kind, "libplctag", None, |tunnel| client.run(&[&tunnel.to_string()])),
        Err(why) => crate::not_run(&format!("libplctag through {kind:?}"), &why),
    }
}

/// As [`node`], in the same manner: the tunnel has an address of its own.
///
/// # Panics
/// As [`python_through`].
pub fn node_through(kind: Kind, script: &str) {
    match Node::with("node") {
        Ok(node) => {
            let [low, high, ..] = std::process::id().to_le_bytes();
            let octet = if kind == Kind::Stunnel { 2 } else { 3 };
            let address = SocketAddr::from(([127, high.max(1), low, octet], 44818));
            through(kind, script, Some(address), |tunnel| {
                node.run(script, &[&tunnel.ip().to_string()])
            });
        }
        Err(why) => crate::not_run(&format!("{script} through {kind:?}"), &why),
    }
}

/// Runs a client against a tunnel at an address, at a free port of 127.0.0.1 without one.
fn through(kind: Kind, name: &str, address: Option<SocketAddr>, client: impl FnOnce(SocketAddr) -> String) {
    let text = std::fs::read_to_string(configuration(&format!("{name}-{kind:?}"))).expect("it was just written");
    let secured = Secured::start(&text, "plain = \"off\"\n", &[]);
    let (tls, folder) = (
        secured.server.tls().expect("the configuration has TLS"),
        secured.folder(),
    );
    let tunnel = match address {
        Some(address) => Tunnel::start_at(kind, address, tls, folder, CLIENT),
        None => Tunnel::start(kind, tls, folder, CLIENT),
    };
    match tunnel {
        Ok(tunnel) => print!("{}", client(tunnel.address())),
        Err(why) => crate::not_run(&format!("{name} through {kind:?}"), &why),
    }
}

/// Builds and runs the program of `tests/libplctag`.
///
/// # Panics
/// As `against_a_server`.
pub fn libplctag() {
    match Libplctag::build() {
        Ok(client) => against_a_server("libplctag", "127.0.0.1:0", |server| client.run(&[&server.to_string()])),
        Err(why) => crate::not_run("libplctag", &why),
    }
}

/// Runs `client` against a server on `listen` with the default configuration and plain tags of every type and shape,
/// and holds that the capture of the run has no malformed frame.
///
/// # Panics
/// When the client or the dissectors find a fault; in CI also when something needed is missing.
pub fn against_a_server(name: &str, listen: &str, client: impl FnOnce(SocketAddr) -> String) {
    let configuration = configuration(name);
    let file = configuration.to_str().expect("the project's paths are UTF-8");
    let server = Server::start_at(listen, &["--config", file]);
    let address = server.address();
    let capture = Capture::of(address);
    print!("{}", client(address));
    judge(name, capture);
}

/// Holds that a capture has frames and none that is malformed.
fn judge(name: &str, capture: Result<Capture, String>) {
    let verdict = match capture.and_then(Capture::finish) {
        Ok(verdict) => verdict,
        Err(why) => return crate::not_run(&format!("capture of {name}"), &why),
    };
    assert!(
        verdict.frames > 100,
        "only {} EtherNet/IP frames were captured",
        verdict.frames
    );
    assert!(
        verdict.faults.is_empty(),
        "malformed frames:\n{}",
        verdict.faults.join("\n")
    );
    println!("{name}: {} EtherNet/IP frames, none malformed", verdict.frames);
}

/// The output of `arcline-server default-config`, with the tags of `config/interop_tags.toml` behind it.
fn configuration(name: &str) -> std::path::PathBuf {
    let default = Command::new(crate::programs::arcline_server())
        .arg("default-config")
        .output()
        .expect("the server was just built");
    assert!(default.status.success(), "default-config: {default:?}");
    let mut text = String::from_utf8(default.stdout).expect("a configuration is UTF-8");
    text += &std::fs::read_to_string(crate::fixture("config/interop_tags.toml")).expect("a file of this package");
    for number in 0..PAGE_TAGS {
        let written = write!(text, "\n[[tag]]\nname = \"Page{number:03}\"\ntype = \"DINT\"\n");
        written.expect("a String takes everything");
    }
    let file = crate::programs::target_directory().join(format!("interop-{name}-{}.toml", std::process::id()));
    std::fs::write(&file, text).expect("the target folder is writable");
    file
}
