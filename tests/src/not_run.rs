//! Reports and counts the tests that cannot run on this machine.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Whether this is a run of the project's CI, in which every program must be present.
#[must_use]
pub fn in_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| value == "true" || value == "1")
}

/// Prints that a subject, `what`, cannot be tested here, with the reason and the number of such tests in this process. Adds a line to
/// `target/not-run.txt`, which `.ci/run` counts at its end.
///
/// # Panics
/// In CI, where a missing program is a failure.
pub fn not_run(what: &str, why: &str) {
    assert!(!in_ci(), "{what}: cannot run, and CI must run everything: {why}");
    not_granted(what, why);
}

/// The same for a permission that a machine may refuse to a test although everything is installed, such as tracing a process or mounting a file
/// system. It is printed and counted, in CI too, and is not a failure there.
pub fn not_granted(what: &str, why: &str) {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed) + 1;
    // The test harness captures the output of `println!` and `eprintln!`, and shows it only when a test fails; it does not capture writes to
    // the handle itself.
    let _ = writeln!(std::io::stderr(), "NOT RUN ({count} so far): {what}: {why}");
    let file = target_directory().join("not-run.txt");
    let file = std::fs::OpenOptions::new().create(true).append(true).open(file);
    let _ = file.and_then(|mut file| writeln!(file, "{what}: {why}"));
}

/// The target folder, for files that tests fetch or leave behind.
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
