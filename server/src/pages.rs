//! Pages and types that tests write from the code, whole or in parts. `UPDATE_EXPECT=1` writes them; without it the test fails when they
//! are old.

use std::path::{Path, PathBuf};

/// A file of the project.
fn path_of(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file)
}

/// Writes a file, or compares it.
pub(crate) fn compare_or_write(file: &str, written: &str) {
    let path = path_of(file);
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(&path, written).expect("the file can be written");
    } else {
        let page = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(page == written, "{file} is old: run the test with UPDATE_EXPECT=1");
    }
}

/// Writes the part of a page between its marks, or compares it. The rest of the page is written by hand.
pub(crate) fn compare_or_write_part(file: &str, part: &str, written: &str) {
    let begin = format!("<!-- A test of the server writes the part \"{part}\" to the next mark. -->\n");
    let end = format!("<!-- The end of \"{part}\". -->\n");
    let page = std::fs::read_to_string(path_of(file)).expect(file);
    let marked = page.split_once(&begin).and_then(|(before, rest)| {
        let (_, after) = rest.split_once(&end)?;
        Some((before, after))
    });
    let (before, after) = marked.unwrap_or_else(|| panic!("{file} has no marks of {part:?}"));
    compare_or_write(file, &format!("{before}{begin}\n{written}\n{end}{after}"));
}
