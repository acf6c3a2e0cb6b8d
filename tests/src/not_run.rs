//! What a machine cannot test is said, and counted.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Whether this is a run of the project's CI, where nothing may be missing.
#[must_use]
pub fn in_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| value == "true" || value == "1")
}

/// Says on the terminal that `what` cannot be tested here and why, and how many tests of this process could not run. Adds a line to
/// `target/not-run.txt`, which `.ci/run` counts at its end.
///
/// # Panics
/// In CI, where a missing program is a failure.
pub fn not_run(what: &str, why: &str) {
    assert!(!in_ci(), "{what}: cannot run, and CI must run everything: {why}");
    not_granted(what, why);
}

/// The same for what a machine may refuse to a test although everything is installed, as to trace a process or to mount a file system. It is
/// said and counted, in CI too, and is not a failure there.
pub fn not_granted(what: &str, why: &str) {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed) + 1;
    // The test harness captures what `println!` and `eprintln!` write, and shows it only when a test fails; not what is written to the
    // handle itself.
    let _ = writeln!(std::io::stderr(), "NOT RUN ({count} so far): {what}: {why}");
    let file = target_directory().join("not-run.txt");
    let file = std::fs::OpenOptions::new().create(true).append(true).open(file);
    let _ = file.and_then(|mut file| writeln!(file, "{what}: {why}"));
}

/// The target folder, for what tests fetch or leave behind.
///
/// # Panics
/// When the running program is not a test that Cargo has built.
#[must_use]
pub fn target_directory() -> PathBuf {
    profile_directory()
        .parent()
        .expect("a profile's folder stands in the target folder")
        .to_owned()
}

/// `target/debug` or `target/release`: the folder that holds the running test.
///
/// # Panics
/// When the running program is not a test that Cargo has built.
#[must_use]
pub fn profile_directory() -> PathBuf {
    let test = std::env::current_exe().expect("a running program has a file");
    let deps = test.parent().expect("a file has a folder");
    deps.parent().expect("tests stand in target/PROFILE/deps").to_owned()
}
