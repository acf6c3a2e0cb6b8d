//! The programs under test.
//!
//! They are programs of this package, so `cargo test` has built them when a test runs. Tests start them by the names that users know,
//! from a folder in which both stand, because `arcline` looks for `arcline-server` beside itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// `arcline-server`.
#[must_use]
pub fn arcline_server() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| linked("arcline-server"))
}

/// The command line, `arcline`.
#[must_use]
pub fn arcline() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        // `arcline simulate` starts the server that stands beside it.
        let _ = arcline_server();
        linked("arcline")
    })
}

/// The target folder, for what tests fetch or leave behind.
#[must_use]
pub fn target_directory() -> PathBuf {
    profile_directory()
        .parent()
        .expect("a profile's folder stands in the target folder")
        .to_owned()
}

/// `target/debug` or `target/release`: the folder that holds the running test.
fn profile_directory() -> PathBuf {
    let test = std::env::current_exe().expect("a running program has a file");
    let deps = test.parent().expect("a file has a folder");
    deps.parent().expect("tests stand in target/PROFILE/deps").to_owned()
}

/// A link with the name that users know to the program that cargo has built. Test processes that run at the same time replace it by
/// one with the same contents.
fn linked(name: &str) -> PathBuf {
    let built = profile_directory().join(format!("tested-{name}"));
    let folder = profile_directory().join("tested");
    fs::create_dir_all(&folder).expect("the target folder is writable");
    let new = folder.join(format!("{name}-{}", std::process::id()));
    fs::hard_link(&built, &new).unwrap_or_else(|error| panic!("{}: {error}", built.display()));
    let program = folder.join(name);
    fs::rename(&new, &program).expect("the target folder is writable");
    // A rename between two links of one file leaves both.
    let _ = fs::remove_file(&new);
    program
}
