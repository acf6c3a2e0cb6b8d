//! The programs under test.
//!
//! They are programs of this package, so `cargo test` has built them when a test runs. Tests start them by the names that users know,
//! from a folder in which both stand, because `arcline` looks for `arcline-server` beside itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use arcline_tests::not_run::profile_directory;
pub use arcline_tests::not_run::target_directory;

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
