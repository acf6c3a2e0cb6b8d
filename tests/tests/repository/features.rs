//! Packages that are built by themselves ask for no fewer features of others than the whole workspace (`crates/shared-features`): `.ci/run`
//! would build half of it once more.

use std::collections::BTreeSet;
use std::process::Command;

/// Every crate of others that a build of `selection` takes, with its version and features.
fn crates_with_features(selection: &[&str], kinds: &str) -> BTreeSet<String> {
    let output = Command::new(std::env::var_os("CARGO").expect("cargo starts the tests"))
        .args([
            "tree", "--locked", "--prefix", "none", "--format", "{p} {f}", "--edges", kinds,
        ])
        .args(selection)
        .current_dir(arcline_tests::workspace())
        .output()
        .expect("cargo tree runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("cargo tree writes UTF-8");
    text.lines()
        .filter(|line| !line.starts_with("arcline-"))
        // What stands behind a crate that was listed before, and behind macros.
        .map(|line| line.replace(" (*)", "").replace(" (proc-macro)", ""))
        .collect()
}

#[test]
fn packages_that_are_built_by_themselves_take_what_was_built_for_all() {
    let all = crates_with_features(&["--workspace"], "normal,build");
    assert!(all.len() > 100, "{all:?}");
    for (package, kinds) in [
        ("arcline-python", "normal,build"),
        ("arcline-fmu", "normal,build"),
        ("arcline-system-tests", "normal,build,dev"),
    ] {
        let alone = crates_with_features(&["--package", package], kinds);
        let other: Vec<_> = alone.difference(&all).collect();
        assert!(
            other.is_empty(),
            "{package} alone asks for other features than the whole workspace; crates/shared-features/Cargo.toml is to name them: {other:#?}"
        );
    }
}
