//! The table of docs/IEC_62443.md: every test that a row names is there.

use std::collections::BTreeSet;

use arcline_tests::workspace;

use crate::specification::{files, read};

#[test]
fn the_tests_of_each_requirement_exist() {
    let page = read(&workspace().join("docs/IEC_62443.md"));
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    let named: BTreeSet<&str> = rows
        .iter()
        .filter_map(|row| row.trim_end_matches('|').rsplit('|').next())
        .flat_map(|tests| tests.split('`').skip(1).step_by(2))
        .filter(|name| !name.contains(' '))
        .collect();
    assert!(rows.len() > 30 && named.len() > 30, "{} rows, {named:?}", rows.len());
    let mut missing = named;
    for file in files(&["rs"]) {
        let text = read(&file);
        missing.retain(|name| !text.contains(&format!("fn {name}(")));
    }
    assert!(missing.is_empty(), "tests that are not there: {missing:?}");
}

/// No code of the page makes elements or code of a text, so that no name and no value of a tag, a client or a program can become one.
#[test]
fn the_page_makes_no_elements_of_texts() {
    let folder = workspace().join("web/js");
    let modules: Vec<_> = files(&["js"])
        .into_iter()
        .filter(|file| file.starts_with(&folder))
        .collect();
    assert!(modules.len() > 30, "{modules:?}");
    for file in modules {
        let text = read(&file);
        for maker in [
            "innerHTML",
            "outerHTML",
            "insertAdjacentHTML",
            "document.write",
            "DOMParser",
            "createContextualFragment",
            "setHTML",
            "srcdoc",
            "eval(",
            "new Function",
        ] {
            assert!(!text.contains(maker), "{}: {maker}", file.display());
        }
    }
}
