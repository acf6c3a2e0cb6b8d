//! Examples in the documentation of the crates: `cargo test` runs them, unless a manifest says that there are none.

use std::path::Path;

use cargo_metadata::MetadataCommand;

/// Languages of blocks that are not run.
const NOT_RUN: [&str; 5] = ["text", "toml", "json", "console", "sh"];

/// `doctest = false` saves the time that rustdoc needs for a crate. A crate with an example must not have it.
#[test]
fn no_example_is_left_out() {
    let metadata = MetadataCommand::new()
        .manifest_path(arcline_tests::workspace().join("Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata describes the workspace");
    let mut wrong = Vec::new();
    for package in metadata.workspace_packages() {
        for target in package
            .targets
            .iter()
            .filter(|target| target.is_lib() && !target.doctest)
        {
            let folder = target.src_path.parent().expect("a source file is in a folder");
            examples(folder.as_std_path(), &mut wrong);
        }
    }
    assert!(
        wrong.is_empty(),
        "take `doctest = false` out of the manifest, so that these examples run:\n{}",
        wrong.join("\n")
    );
}

/// The places of the examples in doc comments of a folder of sources.
fn examples(folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources can be read") {
        let path = entry.expect("an entry of a folder").path();
        if path.is_dir() {
            examples(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = std::fs::read_to_string(&path).expect("a source file can be read");
            let mut inside = false;
            for (number, line) in text.lines().enumerate() {
                let line = line.trim_start();
                let Some(fence) = ["//! ```", "/// ```"].iter().find_map(|mark| line.strip_prefix(mark)) else {
                    continue;
                };
                inside = !inside;
                if inside && !NOT_RUN.contains(&fence.trim()) {
                    found.push(format!("{}:{}", path.display(), number + 1));
                }
            }
        }
    }
}
