//! A foreign client's script against a real server, recorded and judged by Wireshark's dissectors.

use std::fs;
use std::process::Command;

use crate::capture::Capture;
use crate::python::Python;
use crate::server::Server;

/// Runs `tests/python/SCRIPT HOST:PORT` against a server with the default configuration and plain tags of every
/// type, and holds that the capture of the run has no malformed frame.
///
/// # Panics
/// When the script or the dissectors find a fault; in CI also when something needed is missing.
pub fn run(script: &str) {
    let python = match Python::with_clients() {
        Ok(python) => python,
        Err(why) => return crate::not_run(script, &why),
    };
    let server = Server::start_on(&configuration());
    let address = server.address();
    let capture = Capture::of(address);
    print!("{}", python.run(script, &[&address.to_string()]));
    let verdict = match capture.and_then(Capture::finish) {
        Ok(verdict) => verdict,
        Err(why) => return crate::not_run(&format!("capture of {script}"), &why),
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
    println!("{} EtherNet/IP frames, none malformed", verdict.frames);
}

/// What `arcline-server default-config` prints, and the tags of `config/interop_tags.toml` behind it.
fn configuration() -> std::path::PathBuf {
    let default = Command::new(crate::programs::arcline_server())
        .arg("default-config")
        .output()
        .expect("the server was just built");
    assert!(default.status.success(), "default-config: {default:?}");
    let mut text = default.stdout;
    text.extend(fs::read(crate::fixture("config/interop_tags.toml")).expect("a file of this package"));
    let file = crate::programs::target_directory().join(format!("interop-{}.toml", std::process::id()));
    fs::write(&file, text).expect("the target folder is writable");
    file
}
