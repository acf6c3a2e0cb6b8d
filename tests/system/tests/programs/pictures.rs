//! `arcline plot` draws the pictures of the documentation from the traces of their programs. `UPDATE_EXPECT=1` draws them
//! anew.

use std::path::Path;
use std::process::Command;

use arcline_system_tests::programs;

/// Picture, program, configuration, further arguments of `plot`. A program `PAGE#FILE` is a file of a page of the guide.
#[rustfmt::skip]
const PICTURES: &[(&str, &str, Option<&str>, &[&str])] = &[
    ("first-move.svg",     "images/first-move.st",             None,                         &["--axes", "X,Y"]),
    ("profiles.svg",       "images/profiles.st",               None,                         &[]),
    ("overshoot.svg",      "images/overshoot.st",              None,                         &[]),
    ("blends.svg",         "images/blends.st",                 None,                         &[]),
    ("contour.svg",        "images/contour.st",                Some("images/contour.toml"),  &[]),
    ("tool-path.svg",      "images/tool-path.st",              Some("images/tool-path.toml"), &["--axes", "X,Y,Z,J1,J2,J3"]),
    ("square.svg",         "guide/first-move.md#square.st",    None,                         &[]),
    ("pick-and-place.svg", "guide/pick-and-place.md#cycle.st", Some("guide/pick-and-place.md#cell.toml"), &[]),
];

#[test]
fn pictures_are_new() {
    let docs = arcline_system_tests::workspace().join("docs");
    let folder = tempfile::tempdir().expect("a folder");
    for (picture, program, config, arguments) in PICTURES {
        let (trace, events, drawn) = (
            folder.path().join("t.csv"),
            folder.path().join("e.jsonl"),
            folder.path().join("p.svg"),
        );
        let mut simulate = Command::new(programs::arcline_server());
        simulate.arg("simulate").arg(file(&docs, program, folder.path()));
        simulate.arg("--trace").arg(&trace).arg("--events").arg(&events);
        if let Some(config) = config {
            simulate.arg("--config").arg(file(&docs, config, folder.path()));
        }
        succeed(picture, &mut simulate);
        let mut plot = Command::new(programs::arcline());
        plot.arg("plot")
            .arg(&trace)
            .arg("-o")
            .arg(&drawn)
            .arg("--events")
            .arg(&events)
            .args(*arguments);
        succeed(picture, &mut plot);
        let new = std::fs::read_to_string(&drawn).expect("it has been drawn");
        let path = docs.join("images").join(picture);
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::write(&path, &new).expect("docs/ can be written");
        }
        let old = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            old == new,
            "docs/images/{picture} is old: run the test with UPDATE_EXPECT=1"
        );
        assert!(new.len() < 400_000, "{picture}: {} bytes", new.len());
    }
}

/// A file of the documentation; a block of a page is written into the folder.
fn file(docs: &Path, name: &str, folder: &Path) -> std::path::PathBuf {
    let Some((page, name)) = name.split_once('#') else {
        return docs.join(name);
    };
    let text = std::fs::read_to_string(docs.join(page)).expect("pages can be read");
    let (_, rest) = text
        .split_once(&format!(" {name}\n"))
        .unwrap_or_else(|| panic!("{page} has no {name}"));
    let (block, _) = rest.split_once("\n```").expect("blocks end");
    let path = folder.join(name);
    std::fs::write(&path, format!("{block}\n")).expect("the folder is writable");
    path
}

fn succeed(what: &str, command: &mut Command) {
    let output = command.output().expect("the program was just built");
    assert!(
        output.status.success(),
        "{what}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}
