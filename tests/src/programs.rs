//! The programs under test, built once for each test process. Not a build system: `cargo build` decides what is old.
//!
//! `cargo test --workspace` builds a package's binaries for the tests of that package only, so the first test that
//! needs a program has `cargo` build it, in the profile and the target folder of the test itself.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use cargo_metadata::Message;

/// `arcline-server`.
#[must_use]
pub fn arcline_server() -> &'static Path {
    program("arcline-server")
}

/// The command line, `arcline`.
#[must_use]
pub fn arcline() -> &'static Path {
    program("arcline")
}

/// The target folder, for what tests fetch or leave behind.
#[must_use]
pub fn target_directory() -> PathBuf {
    profile_directory()
        .parent()
        .expect("a profile's folder stands in the target folder")
        .to_owned()
}

fn program(name: &str) -> &'static Path {
    static PROGRAMS: OnceLock<BTreeMap<String, PathBuf>> = OnceLock::new();
    let programs = PROGRAMS.get_or_init(build);
    programs
        .get(name)
        .unwrap_or_else(|| panic!("cargo built no program {name}, only {programs:?}"))
}

/// `target/debug` or `target/release`: the folder that holds the running test.
fn profile_directory() -> PathBuf {
    let test = std::env::current_exe().expect("a running program has a file");
    let deps = test.parent().expect("a file has a folder");
    deps.parent().expect("tests stand in target/PROFILE/deps").to_owned()
}

fn build() -> BTreeMap<String, PathBuf> {
    let profile = match profile_directory().file_name().and_then(|name| name.to_str()) {
        Some("debug") | None => "dev".to_owned(),
        Some(other) => other.to_owned(),
    };
    let output = Command::new(env!("CARGO"))
        .args([
            "build",
            "--workspace",
            "--bins",
            "--locked",
            "--message-format=json-render-diagnostics",
        ])
        .args(["--profile", &profile])
        .arg("--target-dir")
        .arg(target_directory())
        .current_dir(crate::workspace())
        .output()
        .expect("cargo, which built this test, can be started");
    assert!(
        output.status.success(),
        "cargo build of the programs under test failed:\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    Message::parse_stream(output.stdout.as_slice())
        .filter_map(|message| match message {
            Ok(Message::CompilerArtifact(artifact)) => {
                Some((artifact.target.name.clone(), artifact.executable?.into_std_path_buf()))
            }
            _ => None,
        })
        .collect()
}
